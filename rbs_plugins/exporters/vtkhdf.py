"""VTKHDFExporter: all frames of a run in one file, for ParaView and PyVista; fast, and safe to be interrupted."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Clock, Field, Part, Trigger, always
from rbs_core.files import written_whole
from rbs_plugins.exporters import series
from rbs_plugins.exporters.frames import NodeExporter, Room

PRECISIONS = {None: None, "single": np.float32, "double": np.float64}
COMPRESSIONS = (None, "gzip")  # what every HDF5 can read, thus every viewer


class VTKHDFExporter(NodeExporter):
    """Writes all frames into one file `<path>.vtkhdf`, which ParaView (5.12 or newer) and VTK read with their times.

    Args:
        part: the part; every node becomes a point.
        fields: node fields to export.
        path: the file; `.vtkhdf` is added if it does not end so. Started anew by a run from the beginning (when its
            first frame is complete), continued by a resumed one.
        configuration: "reference" (default): points are stored once, and viewers keep the mesh from frame to frame;
            with the displacement among the fields, they warp by it, at any scale. "current": points of every frame.
        precision: "single" stores real numbers of frames in 4 bytes, "double" in 8; None (default) as the part does.
            Points that are stored once are double.
        compression: "gzip" for files that are smaller and written many times slower; None (default).
        when: trigger.

    Raises:
        BadInput: as other exporters of nodes; on an unknown precision or compression; at the start of a resumed run, if
            the file is not the one that the run has written.

    The file is closed after every frame, so it can be copied or looked at while the run goes on. A process that is
    killed leaves all complete frames readable, whenever that happens but for microseconds in every 4096th frame. There
    is no such promise for a loss of power.
    """

    example = {"fields": (), "path": "frames"}

    def __init__(
        self,
        part: Part,
        fields: Iterable[Field],
        path: str | Path,
        *,
        configuration: str = "reference",
        precision: str | None = None,
        compression: str | None = None,
        when: Trigger = always,
    ) -> None:
        path = Path(path)
        path = path if path.suffix == ".vtkhdf" else path.with_name(f"{path.name}.vtkhdf")
        super().__init__(part, fields, path, configuration=configuration, when=when)
        for name, value, known in (("precision", precision, PRECISIONS), ("compression", compression, COMPRESSIONS)):
            if value not in known:
                raise BadInput(f"{self.label}: {name}={value!r} must be one of {', '.join(map(repr, known))}")
        self.precision, self.compression = precision, compression
        self._times: list[float] = []
        self._room: Room = {}

    # -- a run ------------------------------------------------------------------------------------------------------

    def attach(self) -> None:
        super().attach()
        self._room = {}

    def reset(self) -> None:
        self._times = []

    def state(self) -> dict[str, Any]:
        return {"times": list(self._times)}

    def restore(self, state: dict[str, Any]) -> None:
        self._times = [float(time) for time in state["times"]]

    def begin(self, clock: Clock) -> None:
        """Drops what lies behind the frames of this run, if it goes on.

        Raises:
            BadInput: if the file does not hold these frames.
        """
        if not self._times:
            return
        difference = "is not there"
        if self.path.exists():
            try:
                difference = self._continue()
            except (OSError, RuntimeError) as error:
                difference = f"cannot be continued ({error})"
        if difference:
            raise BadInput(
                f"{self.label}: {self.path} should hold {len(self._times)} frames of the run that goes on, and "
                f"{difference}: another run has written it; start again, or put the old file back"
            )

    def apply(self, clock: Clock) -> None:
        times = [*self._times, clock.time]
        try:
            if self._times:
                with series.opened(self.path) as file:
                    series.append(file, times, len(self.part), self._arrays())
            else:
                points = self.positions() if self.configuration == "reference" else None
                with written_whole(self.path) as partial:
                    series.make(partial, points, len(self.part), self._arrays(), self.compression)
                    with series.opened(partial) as file:
                        series.append(file, times, len(self.part), self._arrays())
        except (OSError, RuntimeError) as error:
            why = str(error).split("\n")[0]
            raise OSError(f"{self.label} cannot write {self.path} ({why}): is the disk full?") from error
        self._times = times

    # -- what is in the file ----------------------------------------------------------------------------------------

    def _arrays(self) -> Iterator[tuple[str, NDArray[Any]]]:
        """What belongs to a frame, by the names of the file: one after the other, as each may be a copy."""
        if self.configuration == "current":
            yield "Points", self._stored(self.positions(room=self._room))
        for field in dict.fromkeys(self.fields):
            yield f"PointData/{field.name}", self._stored(self.values(field, self._room))

    def _stored(self, array: NDArray[Any]) -> NDArray[Any]:
        """The same numbers, of the type of the file, one after the other in memory."""
        if array.dtype.kind == "b":  # HDF5 would make an enumeration of it, which viewers do not know
            return np.ascontiguousarray(array, np.uint8)
        return np.ascontiguousarray(array, PRECISIONS[self.precision] if array.dtype.kind == "f" else None)

    def _continue(self) -> str:
        """Makes the file one with the frames of this run and no others; what is wrong if that cannot be."""
        import h5py

        with h5py.File(self.path, "r", locking=False) as file:
            difference = self._difference(file)
            if difference:
                return difference
            frames = int(file["VTKHDF/Steps"].attrs["NSteps"])
        if not series.was_closed(self.path):
            series.save(self.path, self._times)
        elif frames > len(self._times):
            with series.opened(self.path) as file:
                series.cut(file, len(self._times))
        return ""

    def _difference(self, file: Any) -> str:
        """What tells the file from the one that this run has written so far, as the end of a sentence."""
        if not series.is_series(file):
            return "is no series of frames"
        if series.nodes(file) != len(self.part):
            return f"has {series.nodes(file)} nodes instead of {len(self.part)}"
        holds = {name: (data.dtype, data.shape[1:], data.compression) for name, data in series.moving(file).items()}
        wanted = {name: (values.dtype, values.shape[1:], self.compression) for name, values in self._arrays()}
        if holds != wanted:
            return f"holds {_listed(holds)} instead of {_listed(wanted)}"
        times = file["VTKHDF/Steps/Values"][:].tolist()
        if len(times) < len(self._times):
            return f"holds {len(times)}"
        wrong = [pair for pair in zip(times, self._times, strict=False) if pair[0] != pair[1]]
        return f"holds the time {wrong[0][0]} s instead of {wrong[0][1]} s" if wrong else ""


def _listed(arrays: dict[str, tuple[Any, ...]]) -> str:
    """Arrays of a frame in words."""
    texts = [f"{name} ({dtype}, compression {how})" for name, (dtype, _, how) in sorted(arrays.items())]
    return ", ".join(texts) or "no fields"
