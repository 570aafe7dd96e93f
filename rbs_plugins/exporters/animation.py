"""AnimationExporter: a movie of a field, GIF or MP4."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np

from rbs_core import BadInput, Field, Part, Trigger, always
from rbs_core.files import writable_folder
from rbs_core.trigger import Clock
from rbs_plugins.exporters.drawing import DrawingExporter, draw, save
from rbs_plugins.exporters.movie import ENDINGS, MOST_FPS, need_encoder, write_movie
from rbs_plugins.fields import displacement


class AnimationExporter(DrawingExporter):
    """Draws the nodes of a part, coloured by a field, and makes a movie of the pictures when the run ends.

    Args:
        part: the part.
        field: node field; of a vector the magnitude, or one component.
        path: the movie, "....gif" or "....mp4"; the second needs imageio-ffmpeg.
        fps: pictures per second; a GIF has 50 at most.
        component: "x", "y", "z" or a number, for vectors.
        limits: (low, high) of the colours; the extremes of the frames so far if not given.
        configuration: "current" or "reference" positions.
        scale: factor on the displacement in the picture.
        size: of the pictures in pixels; even numbers for an MP4.
        colors: name of a colour map.
        when: trigger.

    Raises:
        BadInput: as other exporters of nodes; on another ending of the path, or fps that cannot be; at the start of the
            run, if the folder cannot be written or an MP4 not be encoded; of a resumed run, if pictures are missing.

    The pictures are in the folder `<path>.frames`, where a resumed run finds them. The movie is made of them when the
    run ends, also after an interruption or an error, and appears complete or not at all; one picture is held at a time.
    All frames show the same space: that of the frames so far. Where no picture can be drawn (no graphics library), the
    run goes on and a warning says so once.
    """

    example = {"field": displacement, "path": "movie.gif", "size": (200, 180)}

    def __init__(
        self,
        part: Part,
        field: Field,
        path: str | Path,
        *,
        fps: float = 15.0,
        component: str | int | None = None,
        limits: tuple[float, float] | None = None,
        configuration: str = "current",
        scale: float = 1.0,
        size: tuple[int, int] = (800, 720),
        colors: str = "viridis",
        when: Trigger = always,
    ) -> None:
        super().__init__(
            part, field, path, component=component, limits=limits, configuration=configuration, scale=scale, size=size,
            colors=colors, when=when,
        )  # fmt: skip
        ending = self.path.suffix
        if ending not in ENDINGS:
            raise BadInput(f"{self.label}: the path must end with {' or '.join(ENDINGS)}, got {str(path)!r}")
        if not (isinstance(fps, int | float) and math.isfinite(fps) and 0.1 <= fps <= MOST_FPS[ending]):
            raise BadInput(f"{self.label}: fps={fps!r} must lie between 0.1 and {MOST_FPS[ending]:g} for {ending}")
        if ending == ".mp4" and any(side % 2 for side in size):
            raise BadInput(f"{self.label}: size={size!r} must be even numbers for an MP4")
        self.fps = float(fps)
        self.folder = self.path.with_name(f"{self.path.name}.frames")
        self._made, self._begun = 0, False  # frames in the movie, and whether the pictures of the others are there
        self._seen: dict[str, list[float]] = {}  # extremes of values and positions so far

    def attach(self) -> None:
        need_encoder(self.label, self.path)
        super().attach()
        writable_folder(self.folder)

    def reset(self) -> None:
        super().reset()
        self._made, self._seen = 0, {}

    def state(self) -> dict[str, Any]:
        return {**super().state(), "seen": self._seen}

    def restore(self, state: dict[str, Any]) -> None:
        super().restore(state)
        self._seen = {name: list(values) for name, values in state["seen"].items()}

    def begin(self, clock: Clock) -> None:
        """Looks for the pictures of a run that goes on.

        Raises:
            BadInput: if they are not all there, or of another size.
        """
        missing = [name for _, name in self.frames if not (self.folder / name).exists()]
        if missing:
            raise BadInput(
                f"{self.label}: the movie goes on, and {len(missing)} of its pictures are not in {self.folder} (first: "
                f"{missing[0]}): put them back, start again, or take another path, whose movie begins here"
            )
        if self.frames:
            from PIL import Image

            with Image.open(self.folder / self.frames[0][1]) as first:
                if first.size != tuple(self.size):
                    raise BadInput(
                        f"{self.label}: the movie goes on, and its pictures have the size {first.size} instead of "
                        f"{tuple(self.size)}: take the old size, or another path"
                    )
        self._begun = True

    def _draw(self, clock: Clock) -> None:
        sketch = self.sketch(clock)
        low, high = self._extremes("limits", sketch.values.min(), sketch.values.max())
        corners = self._extremes("space", sketch.low, sketch.high)
        sketch = dataclasses.replace(
            sketch, limits=self.limits or (float(low[0]), float(high[0])), low=corners[0], high=corners[1]
        )
        if not self.frames:  # what an earlier run has left would be taken for frames of this one
            for old in self.folder.glob(f"{self.path.stem}_*.png"):
                old.unlink()
        name = f"{self.path.stem}_{clock.step:06d}.png"
        save(draw(sketch), self.folder / name)
        self.frames.append((clock.time, name))

    def _extremes(self, name: str, low: Any, high: Any) -> tuple[np.ndarray, np.ndarray]:
        """Smallest and largest values of the frames so far, with these among them."""
        now = [*np.ravel(low).tolist(), *np.ravel(high).tolist()]
        before = self._seen.get(name, now)
        half = len(now) // 2
        lows, highs = np.minimum(now[:half], before[:half]), np.maximum(now[half:], before[half:])
        self._seen[name] = [*lows.tolist(), *highs.tolist()]
        return lows, highs

    def close(self) -> None:
        begun, self._begun = self._begun, False
        if not begun or len(self.frames) in (0, self._made):
            return
        try:
            write_movie(self.path, [self.folder / name for _, name in self.frames], self.fps, self.colors)
        except (OSError, RuntimeError) as error:
            raise OSError(
                f"{self.label} cannot write {self.path} ({error}): is the disk full? The pictures are in {self.folder}"
            ) from error
        self._made = len(self.frames)
