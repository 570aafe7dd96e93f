"""HDF5Exporter: a whole run in one compressed file, for work with numbers in Python (see `run.read_run`).

The file, in HDF5:

    /                             attributes format, version, frames
        time                      (frames,) s
        step                      (frames,)
        parts/<name>              attribute dimension
            position              (n, d) reference positions, m
            volume                (n,) m^3
            placement             (frames, 4, 3) origin, m, and axes of its coordinate system in the world
            fields/<name>         (frames, n), (frames, n, d), (frames, n, d, d), or without n for numbers of the part;
                                  attributes at, shape, unit, symbol, doc

Fields and positions are in the coordinates of their part. A frame counts when the attribute `frames` says so, and that
is written last.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Clock, Field, Part, Trigger, always, convert, world
from rbs_core.files import writable_folder, written_whole
from rbs_plugins.exporters import growing
from rbs_plugins.exporters.names import field_of, listed
from rbs_plugins.exporters.one_file import PRECISIONS, OneFileExporter, in_words
from rbs_plugins.fields import reference_position, volume

FORMAT, VERSION = "rbs run", 1
COMPRESSIONS = ("gzip", "lzf", None)
ROWS = 16384  # nodes in a chunk of a field: enough chunks for all threads, and few enough for the index
STILL = {"position": reference_position, "volume": volume}
Key = tuple[Part, Field]


class HDF5Exporter(OneFileExporter):
    """Writes fields of one or several parts into one file `<path>.h5`, frame by frame; `read_run` reads it.

    Args:
        part: the part.
        fields: node fields and numbers of the part; a field of another part as a pair (part, field).
        path: the file; `.h5` is added unless it ends with `.h5` or `.hdf5`. Started anew by a run from the beginning
            (when its first frame is complete), continued by a resumed one.
        precision: "single" stores real numbers in 4 bytes, "double" in 8; None (default) as the part does.
        compression: "gzip" (default, on all threads), "lzf" (faster, larger, for h5py only) or None.
        when: trigger.

    Raises:
        BadInput: on a bond field or what is no field, with the nearest names; on an unknown option; at the start of the
            run, if the folder cannot be written, or of a resumed run, if the file is not the one that it has written.

    Reference positions and volumes of the first frame are there once. A process that is killed leaves all complete
    frames readable, as with VTKHDFExporter.
    """

    example = {"fields": (volume,), "path": "run"}

    def __init__(
        self,
        part: Part,
        fields: Iterable[Field | Key],
        path: str | Path,
        *,
        precision: str | None = None,
        compression: str | None = "gzip",
        when: Trigger = always,
    ) -> None:
        super().__init__(part, when=when)
        path = Path(path)
        self.path = path if path.suffix in (".h5", ".hdf5") else path.with_name(f"{path.name}.h5")
        self.fields = tuple(dict.fromkeys(self._key(each) for each in _pairs(fields)))
        self._choice("precision", precision, PRECISIONS)
        self._choice("compression", compression, COMPRESSIONS)
        self.precision, self.compression = precision, compression
        self._times: list[float] = []
        for other in self.written:
            if "/" in other.name or other.name == ".":
                raise BadInput(f"{self.label}: a part called {other.name!r} has no place in HDF5: rename it")

    def _key(self, given: Any) -> Key:
        part, field = given if isinstance(given, tuple) and len(given) == 2 else (self.part, given)
        if not isinstance(part, Part):
            raise BadInput(f"{self.label}: {given!r} must be a field or a pair (part, field)")
        return part, field_of(self.label, field, ("node", "part"), "only those can be exported")

    @property
    def written(self) -> list[Part]:
        """The parts in the file, in order of first mention."""
        return list(dict.fromkeys(part for part, _ in self.fields)) or [self.part]

    @property
    def reads(self) -> tuple[Field | Key, ...]:  # type: ignore[override]
        """The fields, and positions and volumes of their parts."""
        still = [(part, field) for part in self.written for field in STILL.values()]
        keys = dict.fromkeys([*self.fields, *still])
        return tuple(field if part is self.part else (part, field) for part, field in keys)

    @property
    def label(self) -> str:
        """Name in reports, and in checkpoints: two exporters of one part differ by their files."""
        return f"{super().label} {self.path.name}"

    def attach(self) -> None:
        writable_folder(self.path.parent)

    # -- what is in the file ----------------------------------------------------------------------------------------

    def _still(self) -> Iterator[tuple[str, NDArray[Any]]]:
        """What is the same in all frames, by its place."""
        for part in self.written:
            for name, field in STILL.items():
                yield f"parts/{part.name}/{name}", self[part, field]

    def _arrays(self) -> Iterator[tuple[str, NDArray[Any]]]:
        """What belongs to a frame, with one entry along the first axis, by its place."""
        for part, field in self.fields:
            yield f"parts/{part.name}/fields/{field.name}", self._stored(self[part, field])[None]

    def _placements(self) -> Iterator[tuple[str, NDArray[Any]]]:
        """Where the coordinate systems of the parts are, with one entry along the first axis, by its place."""
        for part in self.written:
            corners = convert(np.vstack([np.zeros(3), np.eye(3)]), part.system, world)
            corners[1:] -= corners[0]
            yield f"parts/{part.name}/placement", corners[None]

    def _places(self) -> list[str]:
        """Of all that belongs to a frame."""
        return [place for place, _ in chain(self._placements(), self._arrays())]

    def _make(self, path: Path) -> None:
        with growing.begun(path) as file:
            file.attrs.update({"format": FORMAT, "version": VERSION, "frames": np.int64(0)})
            growing.numbers(file, "time", np.float64)
            growing.frames(file, "step", np.zeros(1, np.int64), None)
            for part in self.written:
                file.create_group(f"parts/{part.name}/fields").parent.attrs["dimension"] = part.dimension
            for place, values in self._still():
                file.create_dataset(place, data=values, shuffle=bool(self.compression), compression=self.compression)
            for place, values in self._placements():
                growing.frames(file, place, values, None)
            for (place, values), (_, field) in zip(self._arrays(), self.fields, strict=True):
                how = self.compression if field.at == "node" else None
                data = growing.frames(file, place, values, how, ROWS)
                told = {name: getattr(field, name) for name in ("at", "shape", "unit", "symbol", "doc")}
                data.attrs.update(told)

    def _append(self, file: Any, times: list[float], clock: Clock) -> None:
        self._write(file, times, clock.step, chain(self._placements(), self._arrays()))

    def _write(self, file: Any, times: list[float], step: int, arrays: Iterable[tuple[str, NDArray[Any]]]) -> None:
        frame = len(times) - 1
        for place, values in arrays:
            growing.put(file, place, frame, values)
        growing.put(file, "step", frame, np.array([step], np.int64))
        growing.put_numbers(file, "time", times)
        file.flush()
        file.attrs.modify("frames", np.int64(len(times)))

    def _count(self, file: Any) -> int:
        return int(file.attrs["frames"])

    def _cut(self, file: Any, count: int) -> None:
        file.attrs.modify("frames", np.int64(count))
        file.flush()
        for place in ["time", "step", *self._places()]:
            growing.resized(file, place, count)

    def _save(self, times: list[float]) -> None:
        import h5py

        with written_whole(self.path) as partial, h5py.File(self.path, "r", locking=False) as old:
            self._make(partial)
            places = self._places()
            with growing.opened(partial) as new:
                for place, _ in self._still():
                    new[place][...] = old[place][...]
                for frame in range(len(times)):
                    arrays = ((place, old[place][frame : frame + 1]) for place in places)
                    self._write(new, times[: frame + 1], int(old["step"][frame]), arrays)

    def _difference(self, file: Any) -> str:
        if file.attrs.get("format") != FORMAT or file.attrs.get("version") != VERSION:
            return f"is no run of format {VERSION}"
        nodes = {name: len(group["position"]) for name, group in file["parts"].items()}
        wanted = {part.name: len(part) for part in self.written}
        if nodes != wanted:
            return f"has nodes {nodes} instead of {wanted}"
        groups = {f"parts/{name}/fields": group["fields"] for name, group in file["parts"].items()}
        held = {f"{place}/{name}": data for place, group in groups.items() for name, data in group.items()}
        holds = {place: (data.dtype, data.shape[1:], data.compression) for place, data in held.items()}
        kinds = [field.at for _, field in self.fields]
        needs = {
            place: (values.dtype, values.shape[1:], self.compression if at == "node" else None)
            for (place, values), at in zip(self._arrays(), kinds, strict=True)
        }
        if holds != needs:
            return f"holds {in_words(holds)} instead of {in_words(needs)}"
        return self._other_times(file["time"][: self._count(file)].tolist())


def _pairs(given: Any) -> tuple[Any, ...]:
    """What was given as a list of fields and pairs, or as one of them."""
    single = isinstance(given, tuple) and len(given) == 2 and isinstance(given[0], Part)
    return (given,) if single else listed(given)
