"""Fictitious layers: nodes that extend a part beyond its body, to carry supports and loads."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.errors import BadInput, nearest
from rbs_core.geometry import Geometry
from rbs_core.space import Cells, Grid, uniform
from rbs_core.space.grids.regular import WHOLE

if TYPE_CHECKING:
    from rbs_core.part.discretized import Discretized

BODY = "body"  # the node set of what is no layer
AXES = "xyz"
Points = NDArray[np.float64]
Places = NDArray[Any]  # (k, d) positions, m, or whole numbers of cells
Beyond = str | Sequence[str] | Geometry | Cells


class FictitiousLayer:
    """Nodes that extend a part beyond its body, to carry supports and loads; made by `part.extend`.

    Attributes:
        part: the part.
        name: of its node set.

    It is a region of its part: `BoundaryDomain(part, layer, velocity=0.0)`.
    """

    def __init__(self, part: Discretized, name: str) -> None:
        self.part, self.name = part, name

    @property
    def nodes(self) -> NDArray[np.int64]:
        """Ascending indices of its nodes; later layers may change them.

        Raises:
            BadInput: if the part has been discretized anew, without the layer.
        """
        return self.part.node_sets[self.name]

    def __len__(self) -> int:
        return len(self.nodes)

    def __repr__(self) -> str:
        return f"<FictitiousLayer {self.name!r} of part '{self.part.name}'>"


class Extension:
    """The nodes of a part and those that are to come.

    Args:
        part: its name, nodes and grid are looked at.
        across: thickness or area.

    Attributes:
        grid: the grid of the nodes, if they still lie on it.
    """

    def __init__(self, part: Discretized, cells: NDArray[np.int64] | None, across: float) -> None:
        self.owner, self._positions, self._across = f"part '{part.name}'", part.positions, across
        self._body, self._spacing, self.grid = part.body, part.spacing, part.grid
        if self.grid is not None:
            taken = np.arange(len(self._positions)) if cells is None else cells
            if np.array_equal(self._positions, self.grid.points()[taken]):
                self._cells = np.stack(np.unravel_index(taken, self.grid.shape, order="F"), axis=1)
            else:  # somebody has moved them
                self.grid = None

    def find(
        self, where: Beyond, thickness: float | None, volumes: NDArray[np.float64]
    ) -> tuple[Places, NDArray[np.float64]]:
        """Places and volumes of the new nodes; whole numbers of cells if the nodes lie on a grid.

        Raises:
            BadInput: see `part.extend`.
        """
        if isinstance(where, Geometry | Cells):
            if thickness is not None:
                raise BadInput(f"{self.owner}: thickness= is for a side such as '-x': leave it out for {where!r}")
            places, sizes = self._given(where)
        else:
            places, sizes = self._continued(self._sides(where), thickness, volumes)
        if not len(places):
            raise BadInput(f"{self.owner}: no node of the layer lies in {where!r}: check it, or use a smaller spacing")
        self._check_apart(places)
        return places, sizes

    def _sides(self, where: Any) -> list[tuple[int, int]]:
        """(axis, sign) of sides such as "-x"."""
        axes = AXES[: self._positions.shape[1]]
        known = [f"{sign}{axis}" for axis in axes for sign in "-+"]
        sides = [where] if isinstance(where, str) else list(where) if isinstance(where, Sequence) else []
        if not sides:
            raise BadInput(f"{self.owner}: a layer lies on a side such as '-x', in a geometry or a grid, got {where!r}")
        for side in sides:
            if side not in known:
                raise BadInput(f"{self.owner} has no side {side!r}: {nearest(str(side), known)}")
        return [(AXES.index(side[1]), 1 if side[0] == "+" else -1) for side in sides]

    def _continued(
        self, sides: Sequence[tuple[int, int]], thickness: float | None, volumes: NDArray[np.float64]
    ) -> tuple[Places, NDArray[np.float64]]:
        """Copies of the outermost nodes of the body on some sides, spacing by spacing."""
        if self._spacing is None:
            raise BadInput(f"{self.owner} has no spacing that a side could be continued by: give a grid (rbs.grids)")
        if thickness is None or not (np.isfinite(thickness) and thickness > 0):
            raise BadInput(f"{self.owner}: thickness={thickness} must be positive and finite, such as the horizon")
        count = int(thickness / self._spacing + WHOLE)
        if count == 0:
            raise BadInput(
                f"{self.owner}: a layer of {thickness:g} m is thinner than the spacing {self._spacing:g} m and would "
                "have no nodes: give the horizon"
            )
        step = 1 if self.grid is not None else self._spacing
        every = (self._cells if self.grid is not None else self._positions)[self._body]
        sizes = volumes[self._body]
        first = len(every)
        for axis, sign in sides:
            along = sign * every[:, axis]
            outer = along > along.max() - 0.5 * step
            more = np.repeat(every[outer], count, axis=0)
            more[:, axis] += sign * step * np.tile(np.arange(1, count + 1), np.count_nonzero(outer))
            every, sizes = np.concatenate([every, more]), np.concatenate([sizes, np.repeat(sizes[outer], count)])
        return every[first:], sizes[first:]

    def _given(self, where: Geometry | Cells) -> tuple[Places, NDArray[np.float64]]:
        """The places of a geometry or of a grid; a geometry continues the grid of the nodes, if they lie on one."""
        dimension = self._positions.shape[1]
        if where.dimension not in (None, dimension):
            raise BadInput(f"{self.owner} is {dimension}-D, but {where!r} has {where.dimension}")
        if isinstance(where, Cells):
            self.grid = None
            return where.points(), where.volumes(self._across)
        if self._spacing is None:
            raise BadInput(f"{self.owner} has no spacing that {where!r} could be filled with: give a grid (rbs.grids)")
        filled = uniform(*where.bounds, self._spacing)  # refuses what is not bounded
        if self.grid is None:
            points = filled.points()
            places = points[where.contains(points)]
            return places, np.full(len(places), filled.cell_volume(self._across))
        origin = self.grid.points()[0]
        low, high = ((bound - origin) / self._spacing for bound in where.bounds)
        axes = [np.arange(np.floor(a), np.ceil(b) + 1).astype(np.int64) for a, b in zip(low, high, strict=True)]
        places = np.stack([each.ravel() for each in np.meshgrid(*axes, indexing="ij")], axis=1)
        places = places[where.contains(origin + places * self._spacing)]
        return places, np.full(len(places), self.grid.cell_volume(self._across))

    def _check_apart(self, places: Places) -> None:
        """Raises BadInput if a new node is where one is, or nearer to it than half a spacing."""
        from scipy.spatial import cKDTree  # late: few scripts need it

        there: Places = self._positions
        least = 0.5 * (self._spacing or 0.0)
        if self.grid is not None:
            there, least = self._cells, 0.5
        away, nearby = cKDTree(there).query(places)
        close = np.flatnonzero(away <= least)
        if len(close):
            node = int(nearby[close[0]])
            what = "the body" if np.isin(node, self._body) else "another layer"
            raise BadInput(
                f"{self.owner}: {len(close)} nodes of the layer would lie on those of {what}, the first on node {node} "
                f"at {self._positions[node].tolist()}: take the region without it, e.g. region - part.geometry"
            )

    def laid(self, places: Places) -> tuple[Points, NDArray[np.int64], Grid | None, NDArray[np.int64] | None]:
        """All nodes: positions, which of old and new ones they are, and their grid with the cells of it that they take.

        Nodes on a grid are numbered along it; others follow behind those that are there.
        """
        if self.grid is None:
            every = np.concatenate([self._positions, places])
            return every, np.arange(len(every)), None, None
        taken = np.concatenate([self._cells, places])
        low, high = taken.min(axis=0), taken.max(axis=0)
        shape = tuple((high - low + 1).tolist())
        center = self.grid.center + (low + high - np.array(self.grid.shape) + 1) / 2 * self.grid.spacing
        grid = Grid(self.grid.spacing, shape, center)
        numbers = np.ravel_multi_index(tuple((taken - low).T), shape, order="F")
        order = np.argsort(numbers)
        cells = numbers[order]
        return grid.points()[cells], order, grid, None if len(cells) == len(grid) else cells
