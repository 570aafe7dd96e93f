"""Meshes as they come: read from files by meshio, every cell with a number, sets with the numbers of their cells."""

from __future__ import annotations

import contextlib
import io
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.errors import BadInput
from rbs_core.part.mesh import abaqus, exodus
from rbs_core.part.mesh.shapes import Corners, Kind, Points, kind_of

Numbers = NDArray[np.int64]
EXODUS = (".e", ".ex2", ".exo")
DIMENSIONS = ("point", "curve", "surface", "volume")


@dataclass(frozen=True)
class Block:
    """Cells of one kind that stand together in a file.

    Attributes:
        type: as meshio calls it.
        kind: what is known of such cells.
        corners: (k, c) numbers of points.
        first: number of the first of these cells; cells are numbered from 0 in the order of the file.
    """

    type: str
    kind: Kind
    corners: Corners
    first: int


@dataclass(frozen=True)
class Source:
    """A mesh.

    Attributes:
        label: for messages.
        points: (p, 3) coordinates, in units of the file.
        blocks: the cells.
        cell_sets: numbers of cells by name.
        point_sets: numbers of points by name.
    """

    label: str
    points: Points
    blocks: list[Block]
    cell_sets: dict[str, Numbers]
    point_sets: dict[str, Numbers]


def read(owner: str, mesh: Any, file_format: str | None = None) -> Source:
    """Reads a file, or takes a mesh that meshio has read.

    Args:
        owner: for messages.
        mesh: path, or meshio.Mesh.
        file_format: as meshio calls it; from the name of the file if not given.

    Raises:
        BadInput: if there is no such file, if it cannot be read, or holds cells of an unknown kind, points that are not
            there, or coordinates that are not finite.

    Warns:
        UserWarning: with what meshio has to say about the file.
    """
    if hasattr(mesh, "points") and hasattr(mesh, "cells"):
        return _taken(f"{owner}, mesh", mesh, {})
    path = Path(mesh)
    if not path.is_file():
        raise BadInput(f"{owner}: there is no file {path}: check the path")
    found, said = _from_file(owner, path, file_format)
    if said:
        warnings.warn(f"{owner}: {path}: meshio says: {said}", stacklevel=4)
    label = f"{owner}, {path.name}"
    ending = "" if file_format else path.suffix.lower()
    if file_format == "exodus" or ending in EXODUS:
        cells, points = exodus.sets(path)
        found.point_sets = {**points, **found.point_sets}
        return _taken(label, found, cells)
    if file_format == "abaqus" or ending == ".inp":
        sets = abaqus.cell_sets(path, [np.shape(block.data) for block in found.cells])
        if sets is None and found.cell_sets:
            why = "the file includes others, or has numbers of elements twice"
            warnings.warn(f"{label}: its element sets are left out: {why}", stacklevel=4)
        found.cell_sets = {}
        return _taken(label, found, sets or {})
    return _taken(label, found, {})


def _from_file(owner: str, path: Path, file_format: str | None) -> tuple[Any, str]:
    """What meshio reads, and says; it prints, and ends the process, where others raise."""
    import meshio

    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            found = meshio.read(path, file_format)
    except (Exception, SystemExit) as error:
        if isinstance(error, ModuleNotFoundError):
            cure = f"python -m pip install {error.name}"
            raise BadInput(f"{owner}: to read {path}, meshio needs {error.name}: {cure}") from error
        kind = "" if isinstance(error, SystemExit) else f"{type(error).__name__}: {error}"
        why = " ".join(f"{said.getvalue()} {kind}".split())
        raise BadInput(
            f"{owner}: meshio cannot read {path} ({why}): say file_format= if the name does not tell it, or convert "
            "the file to another format, such as gmsh's MSH 2.2"
        ) from error
    return found, " ".join(said.getvalue().split())


def _taken(label: str, mesh: Any, cell_sets: dict[str, Numbers]) -> Source:
    points = np.asarray(mesh.points, np.float64)
    if points.ndim != 2 or points.shape[1] not in (1, 2, 3):
        raise BadInput(f"{label}: points must be (n, 1), (n, 2) or (n, 3), got {points.shape}")
    points = np.pad(points, ((0, 0), (0, 3 - points.shape[1])))
    blocks, firsts, first = [], [], 0
    for each in mesh.cells:
        firsts.append(first)
        if len(each.data):
            blocks.append(_block(label, each, first, points))
            first += len(each.data)
    sets = {name: [cells] for name, cells in cell_sets.items()}
    for name, members in mesh.cell_sets.items():
        if not name.startswith("gmsh:"):
            sets.setdefault(name, []).extend(
                np.asarray(some, np.int64) + start
                for some, start in zip(members, firsts, strict=False)
                if some is not None
            )
    for name, cells in _groups(mesh, firsts):
        sets.setdefault(name, []).append(cells)
    point_sets = {name: np.unique(np.asarray(some, np.int64)) for name, some in mesh.point_sets.items()}
    joined = {name: np.unique(np.concatenate([np.empty(0, np.int64), *cells])) for name, cells in sets.items()}
    return Source(label, points, blocks, joined, point_sets)


def _block(label: str, each: Any, first: int, points: Points) -> Block:
    width = len(each.data[0])
    kind = kind_of(each.type, width)
    if kind is None:
        raise BadInput(
            f"{label}: {len(each.data)} cells are of the type {each.type}, which is not known (known are lines, "
            "triangles, quadrilaterals, polygons, tetrahedra, hexahedra, wedges and pyramids): split them where the "
            "mesh is made"
        )
    numbers = np.asarray(each.data, np.int64)
    wrong = np.flatnonzero(((numbers < 0) | (numbers >= len(points))).any(axis=1))
    if len(wrong):
        raise BadInput(
            f"{label}: cell {first + wrong[0]} ({each.type}) has the points {numbers[wrong[0]].tolist()}, and the mesh "
            f"only those from 0 to {len(points) - 1}: write the file again"
        )
    corners = numbers[:, : kind.corners]
    endless = np.flatnonzero(~np.isfinite(points[corners]).all(axis=(1, 2)))
    if len(endless):
        raise BadInput(
            f"{label}: cell {first + endless[0]} ({each.type}) has a point whose coordinates are not finite: "
            f"{points[corners[endless[0]]].tolist()}"
        )
    return Block(each.type, kind, corners, first)


def _groups(mesh: Any, firsts: list[int]) -> list[tuple[str, Numbers]]:
    """Physical groups of gmsh: their tags are data of cells, and their names stand elsewhere, if they have any."""
    found = []
    names = {(int(entry[1]), int(entry[0])): name for name, entry in mesh.field_data.items() if np.size(entry) == 2}
    for block, first, tags in zip(mesh.cells, firsts, mesh.cell_data.get("gmsh:physical", []), strict=False):
        for tag in np.unique(tags[tags != 0]).tolist():
            name = names.get((block.dim, tag), f"{DIMENSIONS[block.dim]}_{tag}")
            found.append((name, np.flatnonzero(tags == tag) + first))
    return found
