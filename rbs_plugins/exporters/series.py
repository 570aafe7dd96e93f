"""A file with a time series of nodes in it, in the VTKHDF format: made, continued, cut, and saved after a crash.

The format is that of the VTKHDF file format specification, version 2.0 (docs.vtk.org): an UnstructuredGrid with steps,
one vertex cell per node. What belongs to a frame is appended, and the offsets of a step say where its rows begin. What
never changes (the cells, and points that stay) is there once, and every step points to it:

    VTKHDF                        attributes Version, Type
        NumberOfPoints, NumberOfCells, NumberOfConnectivityIds, Types, Offsets, Connectivity
        Points                    (n, 3), or frame after frame if they move
        PointData/<name>          (steps n,), (steps n, 3) or (steps n, 9)
        Steps                     attribute NSteps
            Values                times
            PointOffsets, PointDataOffsets/<name>, ...

A step counts when NSteps says so, and that is written last.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.files import written_whole

Arrays = Iterable[tuple[str, NDArray[Any]]]  # what belongs to a frame, by its name below VTKHDF

VERTEX = 1  # VTK's number of the type of cell
STEADY = ("PartOffsets", "CellOffsets", "ConnectivityIdOffsets")  # the one mesh of all steps begins at 0

# A file is made with an old header of HDF5: newer ones mark a file as open, and after a crash no viewer would take it.
# It is filled with the index of HDF5 1.10 (ParaView has it), which only grows at its end: frames are found where they
# were before, at whatever moment the writing stops.
HEADER, INDEX = ("v108", "v110"), ("v110", "v110")

# Steps whose times lie together. Only where a new chunk of times begins a crash, within microseconds, costs the file.
CHUNK = 4096


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """A file to be continued. It is not locked: a viewer that has it open must not stop a run."""
    import h5py

    with h5py.File(path, "r+", libver=INDEX, locking=False) as file:
        yield file


def make(path: Path, points: NDArray[Any] | None, count: int, arrays: Arrays, compression: str | None) -> None:
    """A file without frames.

    NSteps and Values come first: they lie side by side then, and one write to the disk makes a frame part of both.

    Args:
        path: the file.
        points: (n, 3) m; None if they are among the arrays.
        count: number of nodes.
        arrays: like those of all frames.
        compression: None or "gzip".
    """
    import h5py

    with h5py.File(path, "w", libver=HEADER, locking=False):
        pass
    with opened(path) as file:
        root = file.create_group("VTKHDF")
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = np.int64(0)
        _numbers(steps, "Values", np.float64)
        root.attrs["Version"] = np.array([2, 0], np.int64)
        root.attrs["Type"] = np.bytes_("UnstructuredGrid")
        for name in ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"):
            root[name] = np.array([count], np.int64)
        root["Types"] = np.full(count, VERTEX, np.uint8)
        root["Offsets"] = np.arange(count + 1, dtype=np.int64)
        root["Connectivity"] = np.arange(count, dtype=np.int64)
        root.create_group("PointData")
        _numbers(steps, "NumberOfParts", np.int64, 1)
        zeros = _numbers(steps, STEADY[0], np.int64)
        for name in STEADY[1:]:
            steps[name] = zeros  # another name of the same numbers
        if points is not None:
            root["Points"] = points
            steps["PointOffsets"] = zeros
        offsets = None
        for name, values in arrays:
            entry = values.shape[1:]
            root.create_dataset(
                name, (0, *entry), values.dtype, maxshape=(None, *entry), chunks=values.shape,
                compression=compression, shuffle=compression is not None,
            )  # fmt: skip
            if offsets is None:
                offsets = _numbers(steps, _offsets(name), np.int64)
            else:
                steps[_offsets(name)] = offsets


def append(file: Any, times: Sequence[float], count: int, arrays: Arrays) -> None:
    """Writes a frame behind the others, and makes it count when all of it is in the file.

    Args:
        file: opened.
        times: of all frames, s; that of this one is the last.
        count: number of nodes.
        arrays: of the frame.
    """
    frame = len(times) - 1
    offsets = None
    for name, values in arrays:
        offsets = _offsets(name)
        data = _resized(file, name, (frame + 1) * count)
        if data.get_create_plist().get_nfilters():
            file[f"VTKHDF/{name}"][frame * count :] = values
        else:  # a frame is a chunk: from the array to the disk
            data.write_direct_chunk((frame * count, *(0 for _ in values.shape[1:])), values)
    for name in ("NumberOfParts", STEADY[0]):
        _resized(file, f"Steps/{name}", frame + 1)
    if offsets is not None:
        _write_last(file, f"Steps/{offsets}", range(0, (frame + 1) * count, count))
    file.flush()
    _write_last(file, "Steps/Values", times)
    file["VTKHDF/Steps"].attrs.modify("NSteps", np.int64(frame + 1))


def cut(file: Any, frames: int) -> None:
    """Drops the frames behind the first ones: at first they do not count, then they are not there."""
    count, names = nodes(file), list(moving(file))
    file["VTKHDF/Steps"].attrs.modify("NSteps", np.int64(frames))
    _resized(file, "Steps/Values", frames)
    file.flush()
    for name in names:
        _resized(file, name, frames * count)
    for name in {"NumberOfParts", STEADY[0], *map(_offsets, names)}:
        _resized(file, f"Steps/{name}", frames)


def was_closed(path: Path) -> bool:
    """False if the process was killed while it wrote a frame: HDF5 has not told the header how long the file is."""
    with path.open("rb") as file:
        header = file.read(48)
    return int.from_bytes(header[28:36], "little") == path.stat().st_size


def save(path: Path, times: Sequence[float]) -> None:
    """Makes a file that was not closed a sound one, with the first frames of it.

    What HDF5 has begun behind the end of the file cannot be continued, only left behind.
    """
    import h5py

    with written_whole(path) as partial, h5py.File(path, "r", locking=False) as old:
        count, names = nodes(old), list(moving(old))

        def arrays(frame: int) -> Arrays:
            return ((name, old[f"VTKHDF/{name}"][frame * count : (frame + 1) * count]) for name in names)

        points = None if "Points" in names else old["VTKHDF/Points"][:]
        compression = next((data.compression for data in moving(old).values()), None)
        make(partial, points, count, arrays(0), compression)
        with opened(partial) as new:
            for frame in range(len(times)):
                append(new, times[: frame + 1], count, arrays(frame))


def is_series(file: Any) -> bool:
    """True if the file holds what a file of frames must hold."""
    wanted = ("NumberOfPoints", "Points", "PointData", "Steps/Values", f"Steps/{STEADY[0]}")
    return all(f"VTKHDF/{name}" in file for name in wanted)


def nodes(file: Any) -> int:
    """Number of nodes."""
    return int(file["VTKHDF/NumberOfPoints"][0])


def moving(file: Any) -> dict[str, Any]:
    """The datasets that grow with every frame, by name."""
    root = file["VTKHDF"]
    points = {"Points": root["Points"]} if root["Points"].chunks else {}
    return points | {f"PointData/{name}": data for name, data in root["PointData"].items()}


def _numbers(group: Any, name: str, kind: Any, fill: int = 0) -> Any:
    """A dataset with one number for each step, none so far."""
    return group.create_dataset(name, (0,), kind, maxshape=(None,), chunks=(CHUNK,), fillvalue=fill)


def _write_last(file: Any, name: str, numbers: Sequence[float]) -> None:
    """Writes the last chunk of the numbers of all steps."""
    data = _resized(file, name, len(numbers))
    first = (len(numbers) - 1) // CHUNK * CHUNK
    chunk = np.zeros(CHUNK, data.dtype)
    chunk[: len(numbers) - first] = numbers[first:]
    data.write_direct_chunk((first,), chunk)


def _resized(file: Any, name: str, rows: int) -> Any:
    """A dataset with so many rows: that of HDF5, which is there ten times as fast as that of h5py."""
    from h5py import h5d

    data = h5d.open(file.id, f"VTKHDF/{name}".encode())
    data.set_extent((rows, *data.shape[1:]))
    return data


def _offsets(name: str) -> str:
    """Where the offsets of an array of the frames stand among the steps."""
    return "PointOffsets" if name == "Points" else name.replace("PointData/", "PointDataOffsets/")
