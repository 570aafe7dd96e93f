"""PictureExporter: a PNG of a field, drawn off screen by PyVista."""

from __future__ import annotations

from pathlib import Path

from rbs_core import Field, Part, Trigger, always
from rbs_core.trigger import Clock
from rbs_plugins.exporters.drawing import DrawingExporter, draw, save
from rbs_plugins.fields import displacement


class PictureExporter(DrawingExporter):
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

    example = {"field": displacement, "path": "picture", "size": (200, 180)}

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
        super().__init__(
            part, field, path, component=component, limits=limits, configuration=configuration, scale=scale, size=size,
            colors=colors, when=when,
        )  # fmt: skip

    def _draw(self, clock: Clock) -> None:
        save(draw(self.sketch(clock)), self.frame(clock, "png"))
