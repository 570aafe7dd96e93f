"""Triangles from the files of other programs: STL, PLY, OBJ, VTK and whatever else meshio reads."""

from __future__ import annotations

from contextlib import redirect_stderr
from io import StringIO
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from rbs_core.errors import BadInput
from rbs_core.geometry.boxtree import Indices
from rbs_core.space.checks import FloatArray, as_number

# Cells that bound surfaces, and how they are cut into triangles; points and lines of a file are left out.
CUTS = {"triangle": [(0, 1, 2)], "quad": [(0, 1, 2), (0, 2, 3)]}
THIN = ("vertex", "line")


def read_triangles(path: str | PathLike[str], unit: float, join: float) -> tuple[FloatArray, Indices]:
    """Vertices (n, 3) and triangles (m, 3) of a file; quadrilaterals are cut in two.

    Args:
        path: the file.
        unit: length of the unit of the file (m), such as 1e-3 for mm.
        join: vertices that are at most so far apart become one (m); triangles that collapse by it are left out.

    Raises:
        BadInput: for a file that is missing, cannot be read, or holds no triangles or other cells as well.
    """
    factor, reach = as_number(unit, "unit", positive=True), as_number(join, "join")
    if reach < 0.0:
        raise BadInput(f"join = {reach} is negative; give a length from 0")
    file = Path(path)
    mesh = _read(file)
    found: list[Indices] = []
    for block in mesh.cells:
        if block.type in CUTS:
            rows = np.asarray(block.data, dtype=np.int64)
            found.extend(rows[:, list(corners)] for corners in CUTS[block.type])
        elif block.type not in THIN:
            raise BadInput(f"{file} holds cells of type {block.type!r}; give a file with the triangles of the surface")
    triangles = np.concatenate(found) if found else np.zeros((0, 3), dtype=np.int64)
    if not len(triangles):
        raise BadInput(f"{file} holds no triangles; give a file with the triangles of the surface")
    vertices = factor * np.asarray(mesh.points, dtype=np.float64)
    return joined(vertices, triangles, reach) if reach else (vertices, triangles)


def _read(file: Path) -> Any:
    """The file as meshio reads it; all of its ways to fail end in one error."""
    import meshio  # late: file formats are no business of most scripts

    if not file.is_file():
        raise BadInput(f"there is no file {file}; give the path of a surface, such as body.stl")
    said = StringIO()
    try:
        # The size that an ASCII file would have, were it a binary one, may be too large for its integer.
        with redirect_stderr(said), np.errstate(over="ignore"):
            return meshio.read(file)
    # Broken files end in many kinds of errors, and in an exit of the interpreter if no reader is left.
    except (Exception, SystemExit) as error:
        reason = " ".join(said.getvalue().split()) if isinstance(error, SystemExit) else str(error)
        raise BadInput(
            f"{file} cannot be read ({reason or type(error).__name__}); give an STL, PLY, OBJ or VTK file"
        ) from error


def joined(vertices: FloatArray, triangles: Indices, reach: float) -> tuple[FloatArray, Indices]:
    """The same triangles, with vertices that are at most so far apart made one, and without those that collapse."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(vertices).query_pairs(reach, output_type="ndarray")
    near = coo_array((np.ones(len(pairs), np.bool_), (pairs[:, 0], pairs[:, 1])), shape=(len(vertices),) * 2)
    _, groups = connected_components(near, directed=False)
    _, first = np.unique(groups, return_index=True)
    rows = groups[triangles].astype(np.int64)
    kept = (rows[:, 0] != rows[:, 1]) & (rows[:, 1] != rows[:, 2]) & (rows[:, 2] != rows[:, 0])
    return vertices[first], rows[kept]
