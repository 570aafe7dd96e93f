"""Discretized: the nodes of a part, where they come from and which of them are meant by a region."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput, MissingField
from rbs_core.fields import FieldStore, is_fictitious, reference_position, volume
from rbs_core.geometry import Geometry
from rbs_core.part.estimate import require_points
from rbs_core.part.host import Host
from rbs_core.part.layer import BODY, Beyond, Extension, FictitiousLayer
from rbs_core.part.neighborhoods import Bonds
from rbs_core.part.regions import NodeSets, Region, nodes_in
from rbs_core.part.views import Node
from rbs_core.space import Cells, Grid, uniform


class Discretized(Host):
    """What a part knows of its nodes."""

    geometry: Geometry
    grid: Grid | None
    _real: str
    _made: tuple[int, int]  # how often nodes and bonds were made
    _cells: NDArray[np.int64] | None  # of the grid that hold nodes; None if all do
    _nodes: FieldStore | None
    _bonds: Bonds | None
    _sets: dict[str, NDArray[np.int64]]

    def __len__(self) -> int:
        return int(self._node_store.count or 0)

    def discretize(self, spacing: float | Cells, *, thickness: float | None = None, area: float | None = None) -> Self:
        """Fills the geometry with nodes: at the cell centres of a regular grid, or at the points of any other grid.

        A node in the geometry stands for its whole cell, one outside for nothing.

        Args:
            spacing: distance of nodes, m; or a grid in local coordinates (`rbs.grids`).
            thickness: of a 2-D part, m (1 m if not given).
            area: cross-section of a 1-D part, m^2 (1 m^2 if not given).

        Raises:
            BadInput: on a spacing that is not positive, an unbounded geometry, a grid or an argument of another
                dimension, if no point lies in the geometry, or if the grid does not fit into memory.
        """
        across = self._across(thickness, area)
        cells = spacing if isinstance(spacing, Cells) else uniform(*self.geometry.bounds, spacing)
        if cells.dimension != self.dimension:
            raise BadInput(f"part '{self.name}' is {self.dimension}-D, but the grid has {cells.dimension}: {cells!r}")
        require_points(self.name, len(cells), self.dimension)
        points = cells.points()
        inside = self.geometry.contains(points)
        if not inside.any():
            raise BadInput(
                f"part '{self.name}' is empty: none of the {len(cells)} points of {cells!r} lies in "
                f"{self.geometry!r}: use a smaller spacing or check the geometry"
            )
        self._place(points[inside], cells.volumes(across)[inside])
        self.spacing = cells.spacing
        self.grid, self._cells = cells.lattice(inside) or (None, None)
        return self

    def place(
        self,
        points: ArrayLike,
        volumes: ArrayLike,
        *,
        spacing: float | None = None,
        thickness: float | None = None,
        area: float | None = None,
    ) -> Self:
        """Takes nodes from anywhere: positions (n, d) in m and volumes (n,) or one number, in m^3.

        The volumes must already contain the thickness (2-D) or area (1-D). `spacing` is the typical distance of
        nodes, for whatever needs one (the linear partial volume, pictures).

        Raises:
            BadInput: on a wrong shape, a node outside of the geometry, or a volume that is not positive.
        """
        self._across(thickness, area)
        if spacing is not None and not (np.isfinite(spacing) and spacing > 0):
            raise BadInput(f"part '{self.name}': spacing={spacing} must be positive and finite")
        positions = np.atleast_1d(np.asarray(points, np.float64))
        if positions.ndim == 1:
            positions = positions[:, None] if self.dimension == 1 else positions[None, :]
        if positions.ndim != 2 or positions.shape[1] != self.dimension or not len(positions):
            raise BadInput(
                f"part '{self.name}': points must be (n, {self.dimension}) with n > 0, got {positions.shape}"
            )
        outside = np.flatnonzero(~self.geometry.contains(positions))
        if len(outside):
            raise BadInput(
                f"part '{self.name}': {len(outside)} points lie outside of {self.geometry!r}, the first is point "
                f"{outside[0]} at {positions[outside[0]].tolist()}"
            )
        self._place(positions, volumes)
        self.spacing, self.grid, self._cells = spacing, None, None
        return self

    def extend(self, name: str, where: Beyond, thickness: float | None = None) -> FictitiousLayer:
        """Adds nodes outside of the body, which carry supports and loads and complete the families at its surface.

        Args:
            name: of the node set that they become.
            where: a side of the body, "-x" or "+y", on which its outermost nodes are continued; several sides, corners
                between them filled; a geometry, filled along the grid of the nodes; or a grid of its own (`rbs.grids`).
            thickness: on a side, m: the horizon. As many spacings as fit into it.

        Call it before `connect`, and before other fields are set. What is no layer becomes the node set "body", to
        which sums and means over the part are limited. Nodes on a grid are numbered anew along it.

        Raises:
            BadInput: if the part is connected or has fields already, on a name that is taken, an unknown side, a layer
                without nodes or one that lies on the body or on another layer.
        """
        store, owner = self._node_store, f"part '{self.name}'"
        if self._bonds is not None:
            raise BadInput(f"{owner} is connected, and a new layer would have no bonds: extend it before connect")
        others = [field.name for field in store if field not in (reference_position, volume, is_fictitious)]
        if others:
            raise BadInput(f"{owner}: new nodes would have no {', '.join(others)}: extend it before these are set")
        if not isinstance(name, str) or not name or name in self._sets or name == BODY:
            raise BadInput(f"{owner}: the name of a layer must be a text that no node set has yet, got {name!r}")
        if BODY in self._sets and not self.extended:
            raise BadInput(f"{owner}: its node set 'body' would be replaced by what is no layer: give it another name")
        extension = Extension(self, self._cells, self.thickness or self.area or 1.0)
        places, sizes = extension.find(where, thickness, self[volume])
        positions, order, grid, cells = extension.laid(places)
        count, sets, spacing = len(self), {BODY: self.body, **self._sets}, self.spacing
        new_place = np.empty(len(order), np.int64)
        new_place[order] = np.arange(len(order))
        fictitious = np.ones(len(order), np.uint8)
        fictitious[new_place[sets[BODY]]] = 0
        self._place(positions, np.concatenate([self[volume], sizes])[order])
        self.spacing, self.grid, self._cells = spacing, grid, cells
        self._node_store.set(is_fictitious, fictitious)
        for each, nodes in {**{key: new_place[held] for key, held in sets.items()}, name: new_place[count:]}.items():
            self.node_sets[each] = nodes
        return FictitiousLayer(self, name)

    @property
    def extended(self) -> bool:
        """True if some nodes belong to a fictitious layer."""
        return is_fictitious in self._node_store and bool(self._node_store.get(is_fictitious).any())

    @property
    def body(self) -> NDArray[np.int64]:
        """Ascending indices of the nodes that belong to no fictitious layer."""
        return np.flatnonzero(self[is_fictitious] == 0) if self.extended else np.arange(len(self))

    def _across(self, thickness: float | None, area: float | None) -> float:
        """Volume per length**d of the cells; remembers thickness and area."""
        for name, value, dimension in (("thickness", thickness, 2), ("area", area, 1)):
            if value is not None and self.dimension != dimension:
                raise BadInput(f"part '{self.name}' is {self.dimension}-D: {name} belongs to {dimension}-D parts only")
            if value is not None and not (np.isfinite(value) and value > 0):
                raise BadInput(f"part '{self.name}': {name}={value} must be positive and finite")
        self.thickness = (1.0 if thickness is None else float(thickness)) if self.dimension == 2 else None
        self.area = (1.0 if area is None else float(area)) if self.dimension == 1 else None
        return self.thickness or self.area or 1.0

    def _place(self, positions: NDArray[np.float64], volumes: ArrayLike) -> None:
        if len(positions) >= 2**32:
            raise BadInput(f"part '{self.name}': {len(positions)} nodes are more than 2**32 - 1: split it")
        store = FieldStore(f"part '{self.name}'", "node", len(positions), self.dimension, self._real)
        store.set(reference_position, positions)
        store.set(volume, self._volumes(volumes, positions))
        self._made = (self._made[0] + 1, self._made[1])
        self._nodes, self._bonds, self._sets = store, None, {}

    def _volumes(self, volumes: ArrayLike, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Volumes (n,) of nodes at these positions, refused unless they are positive."""
        store = FieldStore(f"part '{self.name}'", "node", len(positions), self.dimension)
        store.set(volume, volumes)
        checked = store.get(volume)
        bad = np.flatnonzero(checked <= 0)
        if len(bad):
            raise BadInput(
                f"part '{self.name}': node {bad[0]} at {positions[bad[0]].tolist()} has no positive volume "
                f"({checked[bad[0]]:g} m^3): give it one, or make the part without this node"
            )
        return checked

    @property
    def nodes(self) -> Nodes:
        """The nodes as views: `part.nodes[7]`, iteration, `len`."""
        return Nodes(self)

    @property
    def positions(self) -> NDArray[np.float64]:
        """(n, d) reference positions in local coordinates, m."""
        return self._node_store.get(reference_position)

    @property
    def node_sets(self) -> NodeSets:
        """The named regions: name to ascending indices (k,) of nodes; `part.node_sets["left"] = region` makes one."""
        return NodeSets(f"part '{self.name}'", self._sets, self.where)

    def where(self, region: Region | FictitiousLayer) -> NDArray[np.int64]:
        """Ascending indices of nodes: those in a geometry, a mask (n,), a list of indices, or the node set of a name.

        Args:
            region: one of these, a fictitious layer, or a function of the (n, d) reference positions that returns a
                mask or indices.

        Raises:
            BadInput: if the mask has another length, an index or a node set does not exist (with the nearest names), or
                the layer is of another part.
        """
        if isinstance(region, FictitiousLayer):
            if region.part is not self:
                raise BadInput(f"part '{self.name}': {region!r} is of another part")
            region = region.name
        return nodes_in(f"part '{self.name}'", region, self.positions, self._sets)

    @property
    def _node_store(self) -> FieldStore:
        if self._nodes is None:
            raise MissingField(f"part '{self.name}' has no nodes: call part.discretize(spacing) first")
        return self._nodes


class Nodes:
    """The nodes of a part as a sequence of views."""

    def __init__(self, part: Discretized) -> None:
        self._part = part

    def __len__(self) -> int:
        return len(self._part)

    def __getitem__(self, index: int) -> Node:
        return Node(self._part, index)

    def __iter__(self) -> Iterator[Node]:
        return (Node(self._part, index) for index in range(len(self)))

    def __repr__(self) -> str:
        return f"<{len(self)} nodes of part '{self._part.name}'>"
