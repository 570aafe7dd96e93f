"""A file with a time series of nodes in it, in the VTKHDF format: made, continued, cut, and saved after a crash.

The format is that of the VTKHDF file format specification, version 2.0 (docs.vtk.org): an UnstructuredGrid with steps,
one vertex cell per node. What belongs to a frame is appended, and the offsets of a step say where its rows begin. What
never changes (the cells, and points that stay) is there once, and every step points to it:

    VTKHDF                        attributes Version, Type
        NumberOfPoints, NumberOfCells, NumberOfConnectivityIds, Types, Offsets, Connectivity
        Points                    (n, 3), or frame after frame if they move
        PointData/<name>          (steps n,), (steps n, 3) or (steps n, 9); (n,) if it never changes
        FieldData/<name>          (steps,) or (steps, k)
        Steps                     attribute NSteps
            Values                times
            PointOffsets, PointDataOffsets/<name>, FieldDataOffsets/<name>, ...

A step counts when NSteps says so, and that is written last.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.files import written_whole
from rbs_plugins.exporters import growing
from rbs_plugins.exporters.growing import numbers

Arrays = Iterable[tuple[str, NDArray[Any]]]  # what belongs to a frame, by its name below VTKHDF

VERTEX = 1  # VTK's number of the type of cell
STEADY = ("PartOffsets", "CellOffsets", "ConnectivityIdOffsets")  # the one mesh of all steps begins at 0


def make(path: Path, still: Arrays, count: int, arrays: Arrays, compression: str | None) -> None:
    """A file without frames.

    NSteps and Values come first: they lie side by side then, and one write to the disk makes a frame part of both.

    Args:
        path: the file.
        still: what is the same in all frames.
        count: number of nodes.
        arrays: like those of all frames.
        compression: None or "gzip", of what there is for each node.
    """
    with growing.begun(path) as file:
        root = file.create_group("VTKHDF")
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = np.int64(0)
        numbers(steps, "Values", np.float64)
        root.attrs["Version"] = np.array([2, 0], np.int64)
        root.attrs["Type"] = np.bytes_("UnstructuredGrid")
        for name in ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"):
            root[name] = np.array([count], np.int64)
        root["Types"] = np.full(count, VERTEX, np.uint8)
        root["Offsets"] = np.arange(count + 1, dtype=np.int64)
        root["Connectivity"] = np.arange(count, dtype=np.int64)
        root.create_group("PointData")
        numbers(steps, "NumberOfParts", np.int64, 1)
        zeros = numbers(steps, STEADY[0], np.int64)
        for name in STEADY[1:]:
            steps[name] = zeros  # another name of the same numbers
        for name, values in still:
            root[name] = values
            steps[_offsets(name)] = zeros
        offsets: dict[int, Any] = {}
        for name, values in arrays:
            rows = len(values)
            growing.frames(root, name, values, None if name.startswith("FieldData") else compression)
            if rows in offsets:
                steps[_offsets(name)] = offsets[rows]
            else:
                offsets[rows] = numbers(steps, _offsets(name), np.int64)


def append(file: Any, times: Sequence[float], arrays: Arrays) -> None:
    """Writes a frame behind the others, and makes it count when all of it is in the file.

    Args:
        file: opened.
        times: of all frames, s; that of this one is the last.
        arrays: of the frame.
    """
    frame = len(times) - 1
    offsets: dict[int, str] = {}
    for name, values in arrays:
        offsets[len(values)] = _offsets(name)
        growing.put(file, f"VTKHDF/{name}", frame, values)
    for name in ("NumberOfParts", STEADY[0]):
        growing.resized(file, f"VTKHDF/Steps/{name}", frame + 1)
    for rows, name in offsets.items():
        growing.put_numbers(file, f"VTKHDF/Steps/{name}", range(0, (frame + 1) * rows, rows))
    file.flush()
    growing.put_numbers(file, "VTKHDF/Steps/Values", times)
    file["VTKHDF/Steps"].attrs.modify("NSteps", np.int64(frame + 1))


def cut(file: Any, count: int) -> None:
    """Drops the frames behind the first ones: at first they do not count, then they are not there."""
    rows = {name: data.chunks[0] for name, data in moving(file).items()}  # a frame is a chunk
    file["VTKHDF/Steps"].attrs.modify("NSteps", np.int64(count))
    growing.resized(file, "VTKHDF/Steps/Values", count)
    file.flush()
    for name, each in rows.items():
        growing.resized(file, f"VTKHDF/{name}", count * each)
    for name in {"NumberOfParts", STEADY[0], *map(_offsets, rows)}:
        growing.resized(file, f"VTKHDF/Steps/{name}", count)


def save(path: Path, times: Sequence[float]) -> None:
    """Makes a file that was not closed a sound one, with the first frames of it.

    What HDF5 has begun behind the end of the file cannot be continued, only left behind.
    """
    import h5py

    with written_whole(path) as partial, h5py.File(path, "r", locking=False) as old:
        held = moving(old)

        def arrays(frame: int) -> Arrays:
            return ((name, data[frame * data.chunks[0] : (frame + 1) * data.chunks[0]]) for name, data in held.items())

        compression = next((data.compression for data in held.values() if data.compression), None)
        make(partial, [(name, data[:]) for name, data in still(old).items()], nodes(old), arrays(0), compression)
        with growing.opened(partial) as new:
            for frame in range(len(times)):
                append(new, times[: frame + 1], arrays(frame))


def is_series(file: Any) -> bool:
    """True if the file holds what a file of frames must hold."""
    wanted = ("NumberOfPoints", "Points", "PointData", "Steps/Values", f"Steps/{STEADY[0]}")
    return all(f"VTKHDF/{name}" in file for name in wanted)


def nodes(file: Any) -> int:
    """Number of nodes."""
    return int(file["VTKHDF/NumberOfPoints"][0])


def moving(file: Any) -> dict[str, Any]:
    """The datasets that grow with every frame, by name."""
    return {name: data for name, data in _datasets(file).items() if data.chunks}


def still(file: Any) -> dict[str, Any]:
    """The datasets of points that never change, by name."""
    return {name: data for name, data in _datasets(file).items() if not data.chunks}


def _datasets(file: Any) -> dict[str, Any]:
    root = file["VTKHDF"]
    groups = [group for group in ("PointData", "FieldData") if group in root]
    held = {f"{group}/{name}": data for group in groups for name, data in root[group].items()}
    return {"Points": root["Points"], **held}


def _offsets(name: str) -> str:
    """Where the offsets of an array of the frames stand among the steps."""
    return "PointOffsets" if name == "Points" else name.replace("Data/", "DataOffsets/")
