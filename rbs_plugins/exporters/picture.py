"""PictureExporter: a PNG of a field, drawn off screen by PyVista."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from rbs_core import BadInput, Field, Part, Trigger, always
from rbs_core.report import log
from rbs_core.trigger import Clock
from rbs_plugins.exporters.frames import FrameExporter, axis_of


class PictureExporter(FrameExporter):
    """Draws the nodes of a part, coloured by a field, and writes `<path>_<step>.png`.

    Args:
        part: the part.
        field: node field; of a vector the magnitude, or one component.
        path: folder and beginning of the file names.
        component: "x", "y", "z" or a number, for vectors.
        limits: (low, high) of the colours; the extremes of the frame if not given.
        configuration: "current" or "reference" positions.
        scale: factor on the displacement in the picture.
        size: of the picture in pixels.
        colors: name of a colour map.
        when: trigger.

    Where no picture can be drawn (no graphics library), the run goes on and a warning says so once.
    """

    example = {"field": Field("displacement", "node", "vector", "m", "u", "Position minus reference position."),
               "path": "picture"}  # fmt: skip

    def __init__(
        self,
        part: Part,
        field: Field,
        path: str | Path,
        *,
        component: str | int | None = None,
        limits: tuple[float, float] | None = None,
        configuration: str = "current",
        scale: float = 1.0,
        size: tuple[int, int] = (1000, 900),
        colors: str = "viridis",
        when: Trigger = always,
    ) -> None:
        super().__init__(part, [field], path, configuration=configuration, when=when)
        self.field, self.axis = field, axis_of(component)
        if self.axis is not None and (field.shape != "vector" or not 0 <= self.axis < part.dimension):
            raise BadInput(f"{self.label}: '{field.name}' of this part has no component {component!r}")
        self.limits, self.scale, self.size, self.colors = limits, scale, size, colors
        self._able = True

    def apply(self, clock: Clock) -> None:
        if not self._able:
            return
        try:
            self._draw(clock)
        except (ImportError, RuntimeError, OSError) as error:
            self._able = False
            log.warning("%s cannot draw (%s): the run goes on without pictures", self.label, error)

    def _draw(self, clock: Clock) -> None:
        import pyvista
        from vtkmodules.vtkCommonCore import vtkLogger

        # VTK finds a way without a screen, but not without complaining
        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)

        values = self[self.field]
        if values.ndim > 1:
            values = values[:, self.axis] if self.axis is not None else np.linalg.norm(values, axis=-1)
        points = self.positions(self.scale)
        plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(self.size))
        try:
            plotter.set_background("white")
            name = self.field.name if self.axis is None else f"{self.field.name} {'xyz'[self.axis]}"
            title = f"{name} [{self.field.unit}]"
            plotter.add_mesh(
                pyvista.PolyData(points),
                scalars=np.array(values),
                clim=self.limits,
                cmap=self.colors,
                point_size=self._point_size(points),
                render_points_as_spheres=False,
                lighting=False,
                show_scalar_bar=False,
            )
            plotter.add_scalar_bar(
                title, color="black", vertical=True, position_x=0.87, position_y=0.2, width=0.08, height=0.6,
                title_font_size=18, label_font_size=16, n_labels=6, fmt="%.3g",
            )  # fmt: skip
            plotter.add_text(f"{self.part.name}, t = {clock.time:.4g} s", font_size=12, color="black")
            if self.part.dimension < 3:
                plotter.view_xy()
                plotter.enable_parallel_projection()
                self._frame_between_title_and_bar(plotter, points)
            file = self.frame(clock, "png")
            plotter.screenshot(str(file))
        finally:
            plotter.close()

    def _frame_between_title_and_bar(self, plotter: Any, points: np.ndarray) -> None:
        """Fits the part into the left 85 % and the lower 92 % of the picture."""
        low, high = points.min(axis=0), points.max(axis=0)
        width, height = self.size
        tall = max((high[1] - low[1]) / 0.92, (high[0] - low[0]) / 0.85 * height / width, 1e-300) * 1.04
        camera = plotter.camera
        middle = (low + high) / 2
        focus = (middle[0] + 0.075 * tall * width / height, middle[1] + 0.04 * tall, middle[2])
        camera.focal_point = focus
        camera.position = (focus[0], focus[1], focus[2] + 10 * tall)
        camera.parallel_scale = tall / 2
        camera.clipping_range = (5 * tall, 15 * tall)

    def _point_size(self, points: np.ndarray) -> float:
        """Pixels per node, so that the nodes of a grid just touch."""
        extent = max(float(np.ptp(points, axis=0).max()), 1e-300)
        spacing = self.part.spacing or extent / max(len(points), 1) ** (1 / self.part.dimension)
        return float(np.clip(min(self.size) * spacing / extent, 1.0, 60.0))
