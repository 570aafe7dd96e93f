"""Nodes at the centroids of the cells of a mesh, with node sets for everything that has a name there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from rbs_core.errors import BadInput, nearest
from rbs_core.part.mesh.shapes import Points, measured
from rbs_core.part.mesh.source import Block, Numbers, Source, read
from rbs_core.space.grids.cells import typical

FLAT = (
    1e-7  # of the extent of a mesh: so far its points may be away from a plane, as some files are in single precision
)
LOW = {1: ("lines", "y and z are the same everywhere"), 2: ("surfaces", "z is the same everywhere")}
SHOWN = 3


@dataclass(frozen=True)
class Placed:
    """What a mesh says about the nodes of a part.

    Attributes:
        dimension: 1, 2 or 3.
        positions: (n, d) centroids, m.
        measures: (n,) of cells, m^d.
        spacing: typical size of cells, m; None where they differ too much for one number.
        sets: ascending indices of nodes by name.
        unknown: names of sets that hold none.
    """

    dimension: int
    positions: Points
    measures: NDArray[np.float64]
    spacing: float | None
    sets: dict[str, Numbers]
    unknown: list[str]


def placed(
    owner: str, mesh: Any, *, only: str | Sequence[str] | None, scale: float, file_format: str | None, reorient: bool
) -> Placed:
    """Reads a mesh, checks it, and takes its cells of the highest dimension for nodes.

    Args:
        owner: for messages.
        mesh: path, or meshio.Mesh.
        only: names of sets: nodes are the cells in one of them.
        scale: length of one unit of the mesh, m.
        file_format: as meshio calls it.
        reorient: whether cells turned inside out are taken as if they were not.

    Raises:
        BadInput: if there is nothing to read or no cell, a set does not exist (with the nearest names), the mesh is a
            shell, or if a cell has no volume or is turned inside out.
    """
    if not (np.isfinite(scale) and scale > 0):
        raise BadInput(f"{owner}: scale={scale} must be positive and finite")
    source = read(owner, mesh, file_format)
    dimension = max((block.kind.dimension for block in source.blocks), default=0)
    if dimension == 0:
        raise BadInput(f"{source.label}: there are no cells, only points: Part.from_points takes points with volumes")
    source = replace(source, points=source.points * scale)
    cells = _Cells(source, dimension)
    sets, nodes = cells.node_sets(), np.arange(len(cells))
    if only is not None:
        nodes = _chosen(source.label, [only] if isinstance(only, str) else list(only), sets)
        sets = {name: np.flatnonzero(np.isin(nodes, some)) for name, some in sets.items()}
    positions, measures = cells.measure(nodes, reorient)
    sizes = measures ** (1 / dimension)
    spacing = typical([float(sizes.min()), float(sizes.max())])
    held = {name: nodes for name, nodes in sets.items() if len(nodes)}
    unknown = [] if only is not None else [name for name in sets if name not in held]
    return Placed(dimension, positions, measures, spacing and float(sizes.mean()), held, unknown)


def _chosen(label: str, names: Sequence[str], sets: dict[str, Numbers]) -> Numbers:
    for name in names:
        if name not in sets:
            raise BadInput(f"{label}: only={name!r} is no set of this mesh: {nearest(str(name), sets)}")
    chosen = np.unique(np.concatenate([np.empty(0, np.int64), *(sets[name] for name in names)]))
    if not len(chosen):
        raise BadInput(f"{label}: no cell is in only={', '.join(names)}: name other sets")
    return chosen


class _Cells:
    """The cells of a mesh that can be nodes: those of its dimension, each once.

    Attributes:
        numbers: (n,) of the cells, ascending.
    """

    def __init__(self, source: Source, dimension: int) -> None:
        self._source, self.dimension = source, dimension
        self._blocks = [block for block in source.blocks if block.kind.dimension == dimension]
        self._all = np.concatenate([block.first + np.arange(len(block.corners)) for block in self._blocks])
        first, self._node_of = self._alike()
        self.numbers = self._all[first]

    def __len__(self) -> int:
        return len(self.numbers)

    def _alike(self) -> tuple[Numbers, Numbers]:
        """Places in `_all` of cells, each once (gmsh writes those in two groups twice); and (all,) the nodes of all."""
        width = max(block.corners.shape[1] for block in self._blocks)
        table = np.full((len(self._all), width), -1)
        begin = 0
        for block in self._blocks:
            count, corners = block.corners.shape
            table[begin : begin + count, :corners] = np.sort(block.corners, axis=1)
            begin += count
        order = np.lexsort(table.T)  # keeps the order of equal rows; np.unique takes many times as long
        new = np.concatenate([[True], (table[order[1:]] != table[order[:-1]]).any(axis=1)])
        first = np.empty(len(table), np.int64)
        first[order] = order[new][np.cumsum(new) - 1]
        return np.unique(first, return_inverse=True)

    def _corners(self, nodes: Numbers) -> Iterator[tuple[Block, slice, Numbers]]:
        """(block, which of the nodes come from it, their corners)."""
        numbers = self.numbers[nodes]
        for block in self._blocks:
            low, high = np.searchsorted(numbers, [block.first, block.first + len(block.corners)]).tolist()
            yield block, slice(low, high), block.corners[numbers[low:high] - block.first]

    # -- volumes ----------------------------------------------------------------------------------------------------

    def measure(self, nodes: Numbers, reorient: bool) -> tuple[Points, NDArray[np.float64]]:
        """Centroids (k, d) and measures (k,) of some cells.

        Raises:
            BadInput: if they are a shell, or some are flat or turned inside out, named with their points.
        """
        self._check_plane(nodes)
        positions, measures = np.empty((len(nodes), self.dimension)), np.empty(len(nodes))
        flat = np.zeros(len(nodes), np.bool_)
        points = self._source.points[:, : self.dimension]
        for block, place, corners in self._corners(nodes):
            measures[place], positions[place], flat[place] = measured(points, corners, block.kind)
        self._refuse(flat, nodes, measures, "they are flat: remove them, or mesh that place anew")
        if not reorient:
            why = "the points of a cell go round clockwise" if self.dimension == 2 else "they are turned inside out"
            cure = "reverse their points where the mesh is made, or say reorient=True to take such cells turned round"
            self._refuse(measures < 0, nodes, measures, f"{why}: {cure}")
        return positions, np.abs(measures)

    def _check_plane(self, nodes: Numbers) -> None:
        """Refuses surfaces and lines that leave the plane or axis where the part lives."""
        if self.dimension == 3:
            return
        used = np.unique(np.concatenate([corners.ravel() for _, _, corners in self._corners(nodes)]))
        points = self._source.points[used]
        sizes = np.ptp(points, axis=0)
        across = self.dimension + int(np.argmax(sizes[self.dimension :]))
        if sizes[across] > FLAT * sizes.max():
            cells, rule = LOW[self.dimension]
            raise BadInput(
                f"{self._source.label}: the cells of the highest dimension are {cells}, and {'xyz'[across]} goes from "
                f"{points[:, across].min():g} to {points[:, across].max():g} m: shells and beams in space are no "
                f"parts; mesh the body with solid cells, or, if it is flat, turn it so that {rule}"
            )

    def _refuse(self, bad: NDArray[np.bool_], nodes: Numbers, measures: NDArray[np.float64], why: str) -> None:
        """Names the first of the bad cells."""
        wrong = np.flatnonzero(bad)
        if len(wrong):
            kind = {1: "length", 2: "area", 3: "volume"}[self.dimension]
            unit = "m" if self.dimension == 1 else f"m^{self.dimension}"
            shown = "; ".join(f"{self._named(nodes[k])} with {measures[k]:.3g} {unit}" for k in wrong[:SHOWN])
            count = f"{len(wrong)} of {len(nodes)} cells have no positive {kind}"
            raise BadInput(f"{self._source.label}: {count}, such as {shown}; {why}")

    def _named(self, node: np.int64) -> str:
        number = int(self.numbers[node])
        block = next(b for b in self._blocks if b.first <= number < b.first + len(b.corners))
        corners = block.corners[number - block.first]
        places = self._source.points[corners, : self.dimension].tolist()
        return f"cell {number} ({block.type}, points {corners.tolist()} at {places})"

    # -- sets -------------------------------------------------------------------------------------------------------

    def node_sets(self) -> dict[str, Numbers]:
        """Nodes of every set of cells or points; one of cells comes first where both have the same name."""
        points = {name: self._at_points(some) for name, some in self._source.point_sets.items()}
        return {**points, **{name: self._in_cells(some) for name, some in self._source.cell_sets.items()}}

    def _in_cells(self, cells: Numbers) -> Numbers:
        """Nodes of cells, or of the cells on whose sides, edges or corners these are."""
        found = [self._node_of[np.isin(self._all, cells)]]
        for block in self._source.blocks:
            if block.kind.dimension < self.dimension:
                low = cells[(cells >= block.first) & (cells < block.first + len(block.corners))]
                if len(low):
                    found.append(self._owners(block.corners[low - block.first]))
        return np.unique(np.concatenate(found))

    def _owners(self, corners: Numbers) -> Numbers:
        """Nodes whose cells have all corners (k, c) of one of some lower cells."""
        shared = _incidence(corners, len(self._source.points)) @ self._at_point.T
        return np.unique(shared.indices[shared.data == corners.shape[1]])

    @cached_property
    def _at_point(self) -> Any:
        """(n, points) 1 where a cell has a point as corner."""
        rows = [corners for _, _, corners in self._corners(np.arange(len(self)))]
        nodes = np.repeat(np.arange(len(self)), np.concatenate([np.full(len(c), c.shape[1]) for c in rows]))
        points = np.concatenate([corners.ravel() for corners in rows])
        table = csr_matrix((np.ones(len(nodes), np.int32), (nodes, points)), (len(self), len(self._source.points)))
        table.data[:] = 1  # a collapsed cell has a corner twice
        return table

    def _at_points(self, points: Numbers) -> Numbers:
        """Nodes whose cells have a whole side among some points; if there is none, those with any of the points."""
        inside = np.zeros(len(self._source.points), np.bool_)
        inside[points] = True
        found = [np.empty(0, np.int64)]
        for block, place, corners in self._corners(np.arange(len(self))):
            sides = np.zeros(len(corners), np.bool_)
            for side in block.kind.sides:
                sides |= inside[corners[:, side]].all(axis=1)
            found.append(np.flatnonzero(sides) + place.start)
        nodes = np.concatenate(found)
        if not len(nodes):
            nodes = np.flatnonzero(self._at_point @ inside.astype(np.int32))
        return np.sort(nodes)


def _incidence(corners: Numbers, points: int) -> Any:
    """(k, points) 1 where a lower cell has a point as corner."""
    count, width = corners.shape
    return csr_matrix((np.ones(corners.size, np.int32), corners.ravel(), np.arange(count + 1) * width), (count, points))
