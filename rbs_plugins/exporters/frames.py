"""What exporters of frames share: which fields, in which configuration and coordinates, under which names."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, CoordinateSystem, Exporter, Field, Part, Trigger, convert, world
from rbs_core.files import writable_folder
from rbs_core.trigger import Clock
from rbs_plugins.exporters.names import fields_of
from rbs_plugins.fields import displacement, reference_position, volume

CONFIGURATIONS = ("current", "reference")
RADIUS = "radius"  # what the radius of nodes is called in files

# Arrays to be used again, by shape and dtype, because memory that was never touched is slow: what is made in one lasts
# until the next of that kind is made in it.
Room = dict[tuple[tuple[int, ...], np.dtype[Any]], NDArray[Any]]


class NodeExporter(Exporter):
    """An exporter of node fields, as viewers expect them.

    Args:
        part: the part.
        fields: node fields to export.
        path: the file, or folder and beginning of the file names.
        configuration: "current" or "reference" positions.
        radius: whether the radius of each node is written as well.
        when: trigger.

    Raises:
        BadInput: on a field that does not live at nodes (or at another place where the class takes some), with the
            nearest names; on an unknown configuration, or a field with the name of something else that is written; at
            the start of the run, if the folder cannot be written.
    """

    places: ClassVar[tuple[str, ...]] = ("node",)

    def __init__(
        self,
        part: Part,
        fields: Iterable[Field],
        path: str | Path,
        *,
        configuration: str,
        radius: bool = False,
        when: Trigger,
    ) -> None:
        super().__init__(part, when=when)
        self.path, self.radius = Path(path), radius
        self.fields = fields_of(self.label, fields, self.places, "only those can be exported as frames")
        if configuration not in CONFIGURATIONS:
            raise BadInput(f"{self.label}: configuration={configuration!r} must be one of {', '.join(CONFIGURATIONS)}")
        self.configuration = configuration
        taken = next((field for field in self.fields if radius and field.name == RADIUS), None)
        if taken is not None:
            raise BadInput(f"{self.label}: {taken!r} has the name of the radius of nodes: rename it, or radius=False")

    @property
    def reads(self) -> tuple[Field, ...]:  # type: ignore[override]
        """Positions of the configuration, the exported fields, and volumes for the radius."""
        moved = (displacement,) if self.configuration == "current" else ()
        sized = (volume,) if self.radius else ()
        return tuple(dict.fromkeys((reference_position, *moved, *self.fields, *sized)))

    @property
    def node_fields(self) -> list[Field]:
        """Those among the fields that live at nodes."""
        return [field for field in self.fields if field.at == "node"]

    @property
    def part_fields(self) -> list[Field]:
        """Those that are numbers of the part."""
        return [field for field in self.fields if field.at == "part"]

    @property
    def label(self) -> str:
        """Name in reports, and in checkpoints: two exporters of one part differ by their files."""
        return f"{super().label} {self.path.name}"

    def attach(self) -> None:
        writable_folder(self.path.parent)

    def positions(self, scale: float = 1.0, room: Room | None = None) -> NDArray[np.float64]:
        """(n, 3) positions in the configuration of this exporter, displaced so many times, in world coordinates, m."""
        return self.positions_of(self.part, scale, room)

    def positions_of(self, part: Part, scale: float = 1.0, room: Room | None = None) -> NDArray[np.float64]:
        """The same of another part, whose positions (and displacement) the contract names."""
        local = self[part, reference_position]
        padded = _zeros((len(local), 3), local.dtype, room)
        for axis in range(local.shape[1]):
            padded[:, axis] = local[:, axis]
            if self.configuration == "current":
                padded[:, axis] += scale * self[part, displacement][:, axis]
        return padded if part.system is world else convert(padded, part.system, world)

    def values(self, field: Field, room: Room | None = None) -> NDArray[Any]:
        """A field as viewers expect it, vectors and tensors turned into world coordinates as the positions are.

        Where nothing has to be turned or padded it is the array of the field itself: to be read, and not to be kept.
        """
        array = three(self[field], room)
        if array.ndim == 1 or self.part.system is world:
            return array
        turn = self._turn()
        turns = turn if field.shape == "vector" else np.kron(turn, turn)  # R T R^T of a tensor, row after row
        return array @ turns.T.astype(np.result_type(array, np.float32))

    def radii(self) -> NDArray[np.float64]:
        """(n,) radius of the sphere (disk, segment) with the volume of a node, m."""
        size = np.asarray(self[volume], np.float64)
        if self.part.dimension == 3:
            return np.cbrt(0.75 / np.pi * size)
        if self.part.dimension == 2:
            return np.sqrt(size / (np.pi * (self.part.thickness or 1.0)))
        return 0.5 * size / (self.part.area or 1.0)

    def _turn(self) -> NDArray[np.float64]:
        """(3, 3) the axes of the part in the world: no part lives in curved coordinates."""
        corners = convert(np.vstack([np.zeros(3), np.eye(3)]), self.part.system, world)
        return (corners[1:] - corners[0]).T


class FrameExporter(NodeExporter):
    """An exporter that writes one file per frame: `<path>_<step>.<suffix>`.

    Args:
        part: the part.
        fields: node fields to export.
        path: folder and beginning of the file names.
        configuration: "current" or "reference" positions.
        radius: whether the radius of each node is written as well.
        when: trigger.

    Raises:
        BadInput: as NodeExporter.
    """

    def __init__(
        self,
        part: Part,
        fields: Iterable[Field],
        path: str | Path,
        *,
        configuration: str,
        radius: bool = False,
        when: Trigger,
    ) -> None:
        super().__init__(part, fields, path, configuration=configuration, radius=radius, when=when)
        self.frames: list[tuple[float, str]] = []

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


def systems(system: CoordinateSystem) -> list[CoordinateSystem]:
    """A coordinate system and those above it, without the root: whichever of them moves, all of its points do."""
    found = []
    while system.parent is not None:
        found.append(system)
        system = system.parent
    return found


def three(array: NDArray[Any], room: Room | None = None) -> NDArray[Any]:
    """A scalar, vector or tensor field with three components per direction, as viewers expect it, of the same dtype.

    A field that has them already is not copied.
    """
    if array.ndim == 1 or array.shape[1] == 3:
        return array if array.ndim < 3 else array.reshape(len(array), -1)
    padded = _zeros((len(array),) + (3,) * (array.ndim - 1), array.dtype, room)
    for component in np.ndindex(array.shape[1:]):  # long runs are faster than many rows of two numbers
        padded[(slice(None), *component)] = array[(slice(None), *component)]
    return padded.reshape(len(array), -1)


def _zeros(shape: tuple[int, ...], dtype: np.dtype[Any], room: Room | None) -> NDArray[Any]:
    """An array to be filled, always in the same places; from `room` if there is one of this kind."""
    if room is None:
        return np.zeros(shape, dtype)
    if (shape, dtype) not in room:
        room[shape, dtype] = np.zeros(shape, dtype)
    return room[shape, dtype]


def axis_of(component: str | int | None, names: Sequence[str] = "xyz") -> int | None:
    """Index of a component given by name or number, -1 for an unknown name; None for the magnitude."""
    if not isinstance(component, str):
        return component
    return list(names).index(component) if component in list(names) else -1
