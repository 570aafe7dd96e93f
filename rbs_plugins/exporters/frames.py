"""What exporters of frames share: which fields, in which configuration, under which names, on which resumed run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Exporter, Field, Part, Trigger, convert, world
from rbs_core.files import writable_folder
from rbs_core.space import Cartesian
from rbs_core.trigger import Clock
from rbs_plugins.fields import displacement, reference_position

CONFIGURATIONS = ("current", "reference")


class FrameExporter(Exporter):
    """An exporter that writes one file per frame: `<path>_<step>.<suffix>`.

    Args:
        part: the part.
        fields: node fields to export.
        path: folder and beginning of the file names.
        configuration: "current" or "reference" positions.
        when: trigger.

    Raises:
        BadInput: on a field that does not live at nodes or an unknown configuration; at the start of the run, if the
            folder cannot be written.
    """

    def __init__(
        self, part: Part, fields: Iterable[Field], path: str | Path, *, configuration: str, when: Trigger
    ) -> None:
        super().__init__(part, when=when)
        self.path = Path(path)
        self.fields = (fields,) if isinstance(fields, Field) else tuple(fields)
        for field in self.fields:
            if not isinstance(field, Field) or field.at != "node":
                raise BadInput(f"{self.label}: {field!r} is no node field: only those can be exported as frames")
        if configuration not in CONFIGURATIONS:
            raise BadInput(f"{self.label}: configuration={configuration!r} must be one of {', '.join(CONFIGURATIONS)}")
        self.configuration = configuration
        self.frames: list[tuple[float, str]] = []

    @property
    def reads(self) -> tuple[Field, ...]:  # type: ignore[override]
        """Positions of the configuration, and the exported fields."""
        moved = (displacement,) if self.configuration == "current" else ()
        return tuple(dict.fromkeys((reference_position, *moved, *self.fields)))

    @property
    def label(self) -> str:
        """Name in reports, and in checkpoints: two exporters of one part differ by their files."""
        return f"{super().label} {self.path.name}"

    def attach(self) -> None:
        writable_folder(self.path.parent)

    def positions(self, scale: float = 1.0) -> NDArray[np.float64]:
        """(n, 3) positions in the configuration of this exporter, displaced so many times, in world coordinates, m."""
        local = self[reference_position]
        if self.configuration == "current":
            local = local + scale * self[displacement]
        padded = np.zeros((len(local), 3))
        padded[:, : local.shape[1]] = local
        return padded if self.part.system is world else convert(padded, self.part.system, world)

    def values(self, field: Field) -> NDArray[np.float64]:
        """A field as viewers expect it, vectors and tensors turned into world coordinates as the positions are."""
        array = three(self[field])
        turn = None if array.ndim == 1 or self.part.system is world else self._turn()
        if turn is None:
            return array
        if field.shape == "vector":
            return array @ turn.T
        return (turn @ array.reshape(-1, 3, 3) @ turn.T).reshape(-1, 9)

    def _turn(self) -> NDArray[np.float64] | None:
        """(3, 3) the axes of the part in the world; None for curved coordinates, where each node has its own."""
        system = self.part.system
        while system.parent is not None:
            if not isinstance(system.mapping, Cartesian):
                return None
            system = system.parent
        corners = convert(np.vstack([np.zeros(3), np.eye(3)]), self.part.system, world)
        return (corners[1:] - corners[0]).T

    def frame(self, clock: Clock, suffix: str) -> Path:
        """Name of the file of this step; remembered as a frame."""
        file = self.path.with_name(f"{self.path.name}_{clock.step:06d}.{suffix}")
        self.frames.append((clock.time, file.name))
        return file

    def reset(self) -> None:
        self.frames = []

    def state(self) -> dict[str, Any]:
        return {"frames": [list(frame) for frame in self.frames]}

    def restore(self, state: dict[str, Any]) -> None:
        self.frames = [(float(time), str(name)) for time, name in state["frames"]]


def three(array: NDArray[Any]) -> NDArray[np.float64]:
    """A scalar, vector or tensor field with three components per direction, as viewers expect it."""
    if array.ndim == 1:
        return array
    padded = np.zeros((len(array),) + (3,) * (array.ndim - 1))
    padded[(slice(None), *(slice(0, size) for size in array.shape[1:]))] = array
    return padded.reshape(len(array), -1)


def axis_of(component: str | int | None, names: Sequence[str] = "xyz") -> int | None:
    """Index of a component given by name or number, -1 for an unknown name; None for the magnitude."""
    if not isinstance(component, str):
        return component
    return list(names).index(component) if component in list(names) else -1
