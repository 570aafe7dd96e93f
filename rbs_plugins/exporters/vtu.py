"""VTU files and the PVD file that lists them, written as numpy holds the numbers: one header, then raw bytes.

The format is that of VTK's XML files (docs.vtk.org, "VTK XML formats"), unstructured grid, raw appended data. A frame
costs what it costs to write its bytes.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from rbs_core.files import written_whole

VERTEX, LINE = 1, 3  # VTK's numbers of types of cells
KINDS = {"f": "Float", "i": "Int", "u": "UInt"}
Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class Cells:
    """What connects the points of a grid.

    Attributes:
        connectivity: (sum of points of all cells,) points of one cell after the other.
        offsets: (k,) where the points of the next cell begin.
        types: (k,) VTK's numbers.
    """

    connectivity: NDArray[Any]
    offsets: NDArray[Any]
    types: NDArray[np.uint8]


def cells(count: int, lines: NDArray[Any] | None = None) -> Cells:
    """A vertex for each of so many points, and behind them lines (k, 2) between points."""
    ends = np.zeros((0, 2)) if lines is None else lines
    # numbers of four bytes where they are large enough: a frame is written as fast as it is small
    kind = np.int32 if count + ends.size < 2**31 else np.int64
    return Cells(
        np.concatenate([np.arange(count, dtype=kind), ends.ravel().astype(kind)]),
        np.concatenate([np.arange(1, count + 1, dtype=kind), count + 2 * np.arange(1, len(ends) + 1, dtype=kind)]),
        np.repeat(np.array([VERTEX, LINE], np.uint8), [count, len(ends)]),
    )


@dataclass(frozen=True)
class Grid:
    """What a file holds.

    Attributes:
        points: (n, 3) m.
        cells: what connects them.
        point_data: arrays (n,) or (n, k) by name.
        cell_data: arrays with one row for each cell, by name.
        field_data: arrays with rows of their own, by name.
    """

    points: NDArray[Any]
    cells: Cells
    point_data: Arrays = field(default_factory=dict)
    cell_data: Arrays = field(default_factory=dict)
    field_data: Arrays = field(default_factory=dict)


def write_grid(path: Path, grid: Grid) -> None:
    """Writes a VTU file, which appears complete or not at all."""
    sections = {
        "FieldData": grid.field_data,
        "PointData": grid.point_data,
        "CellData": grid.cell_data,
        "Points": {"Points": grid.points},
        "Cells": vars(grid.cells),
    }
    arrays = [_plain(array) for section in sections.values() for array in section.values()]
    # The last array of the header comes first in the data: meshio looks for arrays by their offsets while it changes
    # these, from the first to the last, and so never meets one that it has changed before.
    offsets, offset = [], 0
    for array in reversed(arrays):
        offsets.append(offset)
        offset += 8 + array.nbytes
    tags = iter([_tag(array, offset) for array, offset in zip(arrays, reversed(offsets), strict=True)])
    text = {
        section: "".join(f"<DataArray Name={quoteattr(name)}{next(tags)}/>\n" for name in held)
        for section, held in sections.items()
    }
    piece = "".join(f"<{section}>\n{text[section]}</{section}>\n" for section in list(sections)[1:])
    head = (
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" '
        f'byte_order="{sys.byteorder.title()}Endian" header_type="UInt64">\n<UnstructuredGrid>\n'
        f"<FieldData>\n{text['FieldData']}</FieldData>\n"
        f'<Piece NumberOfPoints="{len(grid.points)}" NumberOfCells="{len(grid.cells.types)}">\n{piece}</Piece>\n'
        '</UnstructuredGrid>\n<AppendedData encoding="raw">\n_'
    )
    with written_whole(path) as partial, partial.open("wb") as file:
        file.write(head.encode())
        for array in reversed(arrays):
            file.write(array.nbytes.to_bytes(8, sys.byteorder))
            file.write(array.data)
        file.write(b"\n</AppendedData>\n</VTKFile>\n")


def _plain(array: NDArray[Any]) -> NDArray[Any]:
    """The same numbers, of a type that VTK knows, one after the other in memory."""
    return np.ascontiguousarray(array, np.uint8 if array.dtype.kind == "b" else None)


def _tag(array: NDArray[Any], offset: int) -> str:
    """What the header says about an array."""
    kind = f"{KINDS[array.dtype.kind]}{8 * array.dtype.itemsize}"
    columns = "" if array.ndim == 1 else f' NumberOfComponents="{array.shape[1]}"'
    return f' type="{kind}"{columns} NumberOfTuples="{len(array)}" format="appended" offset="{offset}"'


def write_collection(path: Path, frames: Sequence[tuple[float, str]]) -> None:
    """Writes the PVD file of a series: times, s, and names of files beside it."""
    rows = "".join(
        f'    <DataSet timestep="{time!r}" group="" part="0" file={quoteattr(name)}/>\n' for time, name in frames
    )
    text = f'<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n{rows}'
    with written_whole(path) as partial:
        partial.write_text(f"{text}  </Collection>\n</VTKFile>\n", encoding="utf-8")
