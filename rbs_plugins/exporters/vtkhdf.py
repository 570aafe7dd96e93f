"""VTKHDFExporter: all frames of a run in one file, for ParaView and PyVista; fast, and safe to be interrupted."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Clock, Field, Part, Trigger, always
from rbs_plugins.boundary.motion import SolidMotion
from rbs_plugins.exporters import series
from rbs_plugins.exporters.frames import RADIUS, NodeExporter, Room, systems
from rbs_plugins.exporters.one_file import PRECISIONS, OneFileExporter, in_words

COMPRESSIONS = (None, "gzip")  # what every HDF5 can read, thus every viewer


class VTKHDFExporter(OneFileExporter, NodeExporter):
    """Writes all frames into one file `<path>.vtkhdf`, which ParaView (5.12 or newer) and VTK read with their times.

    Args:
        part: the part; every node becomes a point.
        fields: what to export: node fields become point data, numbers of the part (at="part") field data.
        path: the file; `.vtkhdf` is added if it does not end so. Started anew by a run from the beginning (when its
            first frame is complete), continued by a resumed one.
        configuration: "reference" (default): points are stored once, and viewers keep the mesh from frame to frame;
            with the displacement among the fields, they warp by it, at any scale. "current": points of every frame,
            as is needed for a part whose coordinate system moves.
        precision: "single" stores real numbers of frames in 4 bytes, "double" in 8; None (default) as the part does.
            Points that are stored once are double.
        compression: "gzip" for files that are smaller and written many times slower; None (default).
        radius: True to write a scalar `radius`, m, as well, once: that of the sphere (in 2-D disk, in 1-D segment) with
            the volume of the node at the first frame, so that glyphs of this size show the body.
        when: trigger.

    Raises:
        BadInput: as other exporters of nodes; on an unknown precision or compression; at the start of a resumed run, if
            the file is not the one that the run has written; for points that are stored once of a part that some
            relation moves as a whole.

    The file is closed after every frame, so it can be copied or looked at while the run goes on. A process that is
    killed leaves all complete frames readable, whenever that happens but for microseconds in every 4096th frame. There
    is no such promise for a loss of power.
    """

    example = {"fields": (), "path": "frames"}
    places = ("node", "part")

    def __init__(
        self,
        part: Part,
        fields: Iterable[Field],
        path: str | Path,
        *,
        configuration: str = "reference",
        precision: str | None = None,
        compression: str | None = None,
        radius: bool = False,
        when: Trigger = always,
    ) -> None:
        path = Path(path)
        path = path if path.suffix == ".vtkhdf" else path.with_name(f"{path.name}.vtkhdf")
        super().__init__(part, fields, path, configuration=configuration, radius=radius, when=when)
        self._choice("precision", precision, PRECISIONS)
        self._choice("compression", compression, COMPRESSIONS)
        self.precision, self.compression = precision, compression
        self._times: list[float] = []
        self._room: Room = {}
        self._place: tuple[Any, ...] = ()  # how the coordinate system lay in the world when it was last compared

    def attach(self) -> None:
        above = systems(self.part.system)
        if self.configuration == "reference" and any(
            isinstance(each, SolidMotion) and each.system in above for each in self._scene
        ):
            raise BadInput(self._moves())
        super().attach()
        self._room, self._place = {}, ()

    # -- what is in the file ----------------------------------------------------------------------------------------

    def _make(self, path: Path) -> None:
        series.make(path, self._still(), len(self.part), self._arrays(), self.compression)

    def _append(self, file: Any, times: list[float], clock: Clock) -> None:
        if self.configuration == "reference":
            self._check_place(file)
        series.append(file, times, self._arrays())

    def _check_place(self, file: Any) -> None:
        """Looks whether points that are stored once are still where they were, whoever has moved the coordinate system.

        Raises:
            BadInput: if they are not.
        """
        now = tuple(system.mapping for system in systems(self.part.system))
        if now == self._place:
            return
        if not np.array_equal(file["VTKHDF/Points"][:], self.positions()):
            raise BadInput(self._moves())
        self._place = now

    def _moves(self) -> str:
        return (
            f"{self.label}: the coordinate system of the part moves, and configuration='reference' stores its points "
            "once: take configuration='current'"
        )

    def _still(self) -> Iterator[tuple[str, NDArray[Any]]]:
        """What is the same in all frames, by the names of the file."""
        if self.configuration == "reference":
            yield "Points", self.positions()
        if self.radius:
            yield f"PointData/{RADIUS}", self.radii()

    def _arrays(self) -> Iterator[tuple[str, NDArray[Any]]]:
        """What belongs to a frame, by the names of the file: one after the other, as each may be a copy."""
        if self.configuration == "current":
            yield "Points", self._stored(self.positions(room=self._room))
        for field in self.node_fields:
            yield f"PointData/{field.name}", self._stored(self.values(field, self._room))
        for field in self.part_fields:
            yield f"FieldData/{field.name}", self._stored(self[field].reshape(1, -1))

    def _count(self, file: Any) -> int:
        return int(file["VTKHDF/Steps"].attrs["NSteps"])

    def _cut(self, file: Any, count: int) -> None:
        series.cut(file, count)

    def _save(self, times: list[float]) -> None:
        series.save(self.path, times)

    def _difference(self, file: Any) -> str:
        if not series.is_series(file):
            return "is no series of frames"
        if series.nodes(file) != len(self.part):
            return f"has {series.nodes(file)} nodes instead of {len(self.part)}"
        holds = {name: (data.dtype, data.shape[1:], data.compression) for name, data in series.moving(file).items()}
        wanted = {name: (values.dtype, values.shape[1:], self._how(name)) for name, values in self._arrays()}
        if holds != wanted:
            return f"holds {in_words(holds)} instead of {in_words(wanted)}"
        has, needs = list(series.still(file)), [name for name, _ in self._still()]
        if has != needs:
            return f"holds {has} once for all frames instead of {needs}"
        return self._other_times(file["VTKHDF/Steps/Values"][:].tolist())

    def _how(self, name: str) -> str | None:
        """How an array is compressed: a few numbers are not."""
        return None if name.startswith("FieldData") else self.compression
