"""Drawing the nodes of a part, coloured by a field, off screen by PyVista: for pictures and for animations."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Field, Part, Trigger
from rbs_core.files import written_whole
from rbs_core.report import log
from rbs_core.trigger import Clock
from rbs_plugins.exporters.frames import FrameExporter, axis_of

SAMPLE = 100  # nodes that are looked at to find how much a body is deformed
WIDEST = 0.5  # squares that lie across need root two of their width


@dataclass(frozen=True)
class Sketch:
    """What is in a picture.

    Attributes:
        points: (n, 3) where the nodes are, m.
        values: (n,) what colours them.
        spacing: typical distance of nodes, m.
        low, high: (3,) corners of the space that is shown, m.
        flat: whether to look straight at the xy plane.
        title: of the colour bar.
        caption: text in the corner.
        limits: (low, high) of the colours; the extremes of the values if None.
        size: pixels.
        colors: name of a colour map.
    """

    points: NDArray[np.float64]
    values: NDArray[Any]
    spacing: float
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    flat: bool
    title: str
    caption: str
    limits: tuple[float, float] | None
    size: tuple[int, int]
    colors: str


def draw(sketch: Sketch) -> NDArray[np.uint8]:
    """(height, width, 3) the picture as red, green and blue from 0 to 255.

    Raises:
        ImportError, RuntimeError, OSError: where nothing can be drawn.
    """
    import pyvista
    from vtkmodules.vtkCommonCore import vtkLogger

    # VTK finds a way without a screen, but not without complaining
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(sketch.size))
    try:
        plotter.render_window.SetMultiSamples(0)  # soft edges of nodes would take a third of the time
        plotter.set_background("white")
        plotter.add_mesh(
            pyvista.PolyData(sketch.points),
            scalars=np.array(sketch.values),
            clim=sketch.limits,
            cmap=sketch.colors,
            point_size=np.ceil(_point_size(sketch)),  # whole pixels: rounding leaves specks between nodes otherwise
            render_points_as_spheres=False,
            lighting=False,
            show_scalar_bar=False,
        )
        plotter.add_scalar_bar(
            sketch.title, color="black", vertical=True, position_x=0.87, position_y=0.2, width=0.08, height=0.6,
            title_font_size=18, label_font_size=16, n_labels=6, fmt="%.3g",
        )  # fmt: skip
        plotter.add_text(sketch.caption, font_size=12, color="black")
        if sketch.flat:
            plotter.view_xy()
            plotter.enable_parallel_projection()
            _look_between_title_and_bar(plotter.camera, sketch)
        else:
            plotter.reset_camera(bounds=np.stack([sketch.low, sketch.high], axis=1).ravel().tolist())
        return np.asarray(plotter.screenshot(return_img=True), np.uint8)[:, :, :3]
    finally:
        plotter.close()


def _look_between_title_and_bar(camera: Any, sketch: Sketch) -> None:
    """Fits what is shown into the left 85 % and the lower 92 % of the picture."""
    width, height = sketch.size
    tall, middle = _height(sketch), (sketch.low + sketch.high) / 2
    focus = (middle[0] + 0.075 * tall * width / height, middle[1] + 0.04 * tall, middle[2])
    camera.focal_point = focus
    camera.position = (focus[0], focus[1], focus[2] + 10 * tall)
    camera.parallel_scale = tall / 2
    camera.clipping_range = (5 * tall, 15 * tall)


def _height(sketch: Sketch) -> float:
    """What the height of a flat picture shows, m."""
    extent, (width, height) = sketch.high - sketch.low, sketch.size
    return max(float(extent[1]) / 0.92, float(extent[0]) / 0.85 * height / width, 1e-300) * 1.04


def _point_size(sketch: Sketch) -> float:
    """Pixels per node, so that the nodes of a grid just touch."""
    extent = max(float((sketch.high - sketch.low).max()), 1e-300)
    scale = sketch.size[1] / _height(sketch) if sketch.flat else min(sketch.size) / extent
    return float(np.clip(scale * sketch.spacing, 1.0, 60.0))


def _widening(part: Part, points: NDArray[np.float64]) -> float:
    """How much wider nodes are to be drawn so that a body shows no gaps where it is turned or stretched."""
    if not part.connected:
        return 1.0
    grown = []
    for node in np.unique(np.linspace(0, len(part) - 1, SAMPLE).astype(np.int64)):
        others = part.bonds.neighbors(int(node))
        bond = part.positions[others] - part.positions[node]
        moved = points[others, : part.dimension] - points[node, : part.dimension] - bond
        grown.append(np.linalg.norm(moved, axis=1) / np.linalg.norm(bond, axis=1))
    usual = float(np.quantile(np.concatenate(grown), 0.9)) if sum(map(len, grown)) else 0.0
    return 1.0 + min(usual, WIDEST)


def save(image: NDArray[np.uint8], file: Path) -> None:
    """Writes a picture as PNG; the file appears complete or not at all."""
    from PIL import Image

    with written_whole(file) as partial:
        # a file twice as small takes twice as long, and drawing is slow enough
        Image.fromarray(image).save(partial, format="PNG", compress_level=3)


class DrawingExporter(FrameExporter):
    """What exporters share that draw a field.

    Args:
        part: the part.
        field: node field; of a vector the magnitude, or one component.
        path: folder and beginning of the file names.
        component: "x", "y", "z" or a number, for vectors.
        limits: (low, high) of the colours.
        configuration: "current" or "reference" positions.
        scale: factor on the displacement in the picture.
        size: of the picture in pixels.
        colors: name of a colour map.
        when: trigger.

    Raises:
        BadInput: as other exporters of nodes; on a component that the field does not have.
    """

    def __init__(
        self,
        part: Part,
        field: Field,
        path: str | Path,
        *,
        component: str | int | None,
        limits: tuple[float, float] | None,
        configuration: str,
        scale: float,
        size: tuple[int, int],
        colors: str,
        when: Trigger,
    ) -> None:
        super().__init__(part, [field], path, configuration=configuration, when=when)
        self.field, self.axis = field, axis_of(component)
        if self.axis is not None and (field.shape != "vector" or not 0 <= self.axis < part.dimension):
            raise BadInput(f"{self.label}: '{field.name}' of this part has no component {component!r}")
        self.limits, self.scale, self.size, self.colors = limits, scale, size, colors
        self._able = True

    def attach(self) -> None:
        super().attach()
        with contextlib.suppress(ImportError):  # so that the first picture takes no longer than the others
            import pyvista  # noqa: F401

    def apply(self, clock: Clock) -> None:
        if not self._able:
            return
        try:
            self._draw(clock)
        except (ImportError, RuntimeError, OSError) as error:
            self._able = False
            log.warning("%s cannot draw (%s): the run goes on without pictures", self.label, error)

    def _draw(self, clock: Clock) -> None:
        """Draws the frame of this step and writes it."""
        raise NotImplementedError

    def sketch(self, clock: Clock) -> Sketch:
        """What the picture of this step shows."""
        values = self[self.field]
        if values.ndim > 1:
            axes = tuple(range(1, values.ndim))
            values = values[:, self.axis] if self.axis is not None else np.sqrt(np.square(values).sum(axis=axes))
        points = self.positions(self.scale)
        low, high = points.min(axis=0), points.max(axis=0)
        extent = max(float((high - low).max()), 1e-300)
        name = self.field.name if self.axis is None else f"{self.field.name} {'xyz'[self.axis]}"
        spacing = self.part.spacing or extent / max(len(points), 1) ** (1 / self.part.dimension)
        return Sketch(
            points, values, spacing * _widening(self.part, points), low, high,
            flat=self.part.dimension < 3 and high[2] - low[2] <= 1e-9 * extent, title=f"{name}\n[{self.field.unit}]",
            caption=f"{self.part.name}, t = {clock.time:.4g} s", limits=self.limits, size=self.size, colors=self.colors,
        )  # fmt: skip
