"""Part: a coordinate system, a geometry, the nodes that fill it and the bonds between them."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput, MissingField
from rbs_core.fields import Field, FieldStore, reference_position, volume
from rbs_core.geometry import Geometry
from rbs_core.part.families import families
from rbs_core.part.host import Host
from rbs_core.part.neighborhoods import Bonds
from rbs_core.part.rigid import rigid
from rbs_core.part.storage import TOLERANCE
from rbs_core.part.views import Node
from rbs_core.space import Cells, CoordinateSystem, Grid, uniform, world

REALS = {"double": "float64", "single": "float32"}


class Part(Host):
    """A body or region.

    Args:
        name: used in messages, reports and files; unique within an analysis.
        geometry: which points belong to it, in its local coordinates, m.
        system: local coordinate system, the world if not given.
        dimension: 1, 2 or 3; from the geometry if not given.
        precision: "double", or "single" for fields at nodes and bonds (not reference positions) in float32: half the
            memory and, for bonds stored as lattice, about twice the speed; displacements and forces are then good to
            about five digits.

    Raises:
        BadInput: if the dimension cannot be told or is impossible, or if the system, seen from the root, is stretched,
            sheared or curved: the lengths of bonds are measured in local coordinates. Systems may move later, rigidly.

    Use `part[field]` for the array of a field, `part[field] = value` to set it (a number, one entry, an array, or a
    function of the (n, d) reference positions). Volumes must be positive.
    """

    def __init__(
        self,
        name: str,
        geometry: Geometry,
        *,
        system: CoordinateSystem | None = None,
        dimension: int | None = None,
        precision: str = "double",
    ) -> None:
        if not isinstance(geometry, Geometry):
            raise BadInput(f"Part({name!r}): the second argument must be a geometry such as Box, got {geometry!r}")
        dimension = geometry.dimension if dimension is None else dimension
        if dimension not in (1, 2, 3):
            raise BadInput(f"Part({name!r}): say dimension=1, 2 or 3 ({geometry!r} alone does not tell)")
        if geometry.dimension not in (None, dimension):
            raise BadInput(f"Part({name!r}): dimension={dimension}, but {geometry!r} has {geometry.dimension}")
        if precision not in REALS:
            raise BadInput(f"Part({name!r}): precision={precision!r} must be one of {', '.join(REALS)}")
        self.name, self.geometry, self.dimension, self.precision = name, geometry, dimension, precision
        self._real = REALS[precision]
        self.system = world if system is None else rigid(system, name)
        self.spacing: float | None = None
        self.thickness: float | None = None
        self.area: float | None = None
        self.grid: Grid | None = None
        self._made = (0, 0)  # how often nodes and bonds were made
        self._cells: NDArray[np.int64] | None = None  # of the grid that hold nodes; None if all do
        self._bonds: Bonds | None = None
        self._nodes: FieldStore | None = None
        self._values = FieldStore(f"part '{name}'", "part", None, dimension)

    def __repr__(self) -> str:
        nodes = "not discretized" if self._nodes is None else f"{len(self)} nodes"
        bonds = "not connected" if self._bonds is None else repr(self._bonds)[1:-1]
        return f"<Part '{self.name}', {self.dimension}-D, {nodes}, {bonds}>"

    def __len__(self) -> int:
        return int(self._node_store.count or 0)

    # -- nodes ------------------------------------------------------------------------------------------------------

    def discretize(self, spacing: float | Cells, *, thickness: float | None = None, area: float | None = None) -> Part:
        """Fills the geometry with nodes: at the cell centres of a regular grid, or at the points of any other grid.

        A node in the geometry stands for its whole cell, one outside for nothing.

        Args:
            spacing: distance of nodes, m; or a grid in local coordinates (`rbs.grids`).
            thickness: of a 2-D part, m (1 m if not given).
            area: cross-section of a 1-D part, m^2 (1 m^2 if not given).

        Raises:
            BadInput: on a spacing that is not positive, an unbounded geometry, a grid or an argument of another
                dimension, or if no point lies in the geometry.
        """
        across = self._across(thickness, area)
        cells = spacing if isinstance(spacing, Cells) else uniform(*self.geometry.bounds, spacing)
        if cells.dimension != self.dimension:
            raise BadInput(f"part '{self.name}' is {self.dimension}-D, but the grid has {cells.dimension}: {cells!r}")
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
    ) -> Part:
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
        self._nodes, self._bonds = store, None

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
    def version(self) -> tuple[int, int | None]:
        """Numbers of the present nodes and bonds (None before `connect`): they change when these are made anew."""
        return self._made[0], self._made[1] if self._bonds is not None else None

    @property
    def nodes(self) -> Nodes:
        """The nodes as views: `part.nodes[7]`, iteration, `len`."""
        return Nodes(self)

    @property
    def positions(self) -> NDArray[np.float64]:
        """(n, d) reference positions in local coordinates, m."""
        return self._node_store.get(reference_position)

    def where(self, region: Geometry | ArrayLike | Callable[[NDArray[np.float64]], ArrayLike]) -> NDArray[np.int64]:
        """Indices of the nodes in a geometry, in a mask (n,), in a list of indices, or where a function is True.

        Raises:
            BadInput: if the mask has another length, or an index does not exist.
        """
        if isinstance(region, Geometry):
            return np.flatnonzero(region.contains(self.positions))
        chosen = np.asarray(region(self.positions) if callable(region) else region)
        if chosen.dtype == np.bool_:
            if chosen.shape != (len(self),):
                raise BadInput(f"part '{self.name}': a mask must have shape ({len(self)},), got {chosen.shape}")
            return np.flatnonzero(chosen)
        if chosen.dtype.kind not in "iu" or chosen.ndim != 1:
            raise BadInput(f"part '{self.name}': a region is a geometry, a mask, indices or a function, got {region!r}")
        if len(chosen) and (chosen.min() < 0 or chosen.max() >= len(self)):
            raise BadInput(f"part '{self.name}': node indices must lie in 0..{len(self) - 1}")
        return np.unique(chosen).astype(np.int64)

    # -- bonds ------------------------------------------------------------------------------------------------------

    def connect(self, horizon: float, *, reach: float | None = None, storage: str | None = None) -> Part:
        """Searches the families: every node is bonded to all others within the horizon.

        Args:
            horizon: radius δ of a family, m, of which the constants of materials are made. Nodes on it up to one part
                in 1e9 belong to the family.
            reach: bonds to nodes up to so far away, m; the horizon if not given. A partial volume counts a neighbor
                with the share of its cell that lies within the horizon, and some of these have their middle beyond it:
                up to half a spacing for the linear band, up to half a diagonal of a cell for whole cells.
            storage: "list" (a row of neighbors for each node), "lattice" (one bit per bond, for nodes on a regular
                grid: several times faster and smaller), or None: a lattice where the nodes fill enough of a grid, as
                long as no relation of the scene needs a list.

        Raises:
            BadInput: if the horizon is not positive, or below the spacing so that nobody has a neighbor; on a reach
                below the horizon, an unknown storage, or a lattice for nodes that are not on a grid.

        Warns:
            UserWarning: with number and first positions, if some nodes have no neighbor.
        """
        positions = self.positions
        if not (np.isfinite(horizon) and horizon > 0):
            raise BadInput(f"part '{self.name}': horizon={horizon} must be positive and finite")
        if self.spacing is not None and horizon < self.spacing * (1 - TOLERANCE):
            raise BadInput(
                f"part '{self.name}': the horizon {horizon:g} m is below the spacing {self.spacing:g} m, so nodes "
                "would have no neighbors: a horizon of about 3 spacings is usual"
            )
        radius = float(horizon if reach is None else reach)
        if not (np.isfinite(radius) and radius >= horizon):
            raise BadInput(f"part '{self.name}': reach={reach} must be finite, and not below the horizon {horizon:g} m")
        stored = families(self.name, positions, (self.grid, self._cells), radius, storage, self._real)
        positions.flags.writeable = False  # the bonds hold lengths that were measured here
        self._made = (self._made[0], self._made[1] + 1)
        self._bonds = Bonds(self.name, positions, float(horizon), stored, storage is not None, radius)
        self._warn_of_lonely_nodes()
        return self

    def _warn_of_lonely_nodes(self) -> None:
        lonely = np.flatnonzero(self.bonds.counts() == 0)
        if len(lonely):
            first = ", ".join(f"{i} at {self.positions[i].tolist()}" for i in lonely[:3])
            warnings.warn(
                f"part '{self.name}': {len(lonely)} nodes have no bond and will feel no force (first: {first}): "
                "use a larger horizon or remove them",
                stacklevel=3,
            )

    @property
    def bonds(self) -> Bonds:
        """The bonds.

        Raises:
            MissingField: before `connect`.
        """
        if self._bonds is None:
            raise MissingField(f"part '{self.name}' has no bonds: call part.connect(horizon=...) first")
        return self._bonds

    @property
    def connected(self) -> bool:
        """True after `connect`."""
        return self._bonds is not None

    # -- fields -----------------------------------------------------------------------------------------------------

    @property
    def _node_store(self) -> FieldStore:
        if self._nodes is None:
            raise MissingField(f"part '{self.name}' has no nodes: call part.discretize(spacing) first")
        return self._nodes

    def store(self, at: str) -> FieldStore:
        """The arrays of one place: "node", "bond" or "part"."""
        if at == "bond":
            return self.bonds.fields
        return self._node_store if at == "node" else self._values

    def __setitem__(self, field: Field, value: Any) -> None:
        if callable(value):
            value = value(self.positions)
        if field == volume:
            value = self._volumes(value, self.positions)
        if field.at == "bond":
            self.bonds.set(field, value)
        else:
            self.store(field.at).set(field, value)

    @property
    def fields(self) -> list[Field]:
        """The fields that have an array now."""
        stores = [self._nodes, self._bonds.fields if self._bonds else None, self._values]
        return [field for store in stores if store is not None for field in store]

    @property
    def nbytes(self) -> int:
        """Bytes of all fields and bonds."""
        cells = 0 if self._cells is None else self._cells.nbytes
        return cells + (self._nodes.nbytes if self._nodes else 0) + (self._bonds.nbytes if self._bonds else 0)


class Nodes:
    """The nodes of a part as a sequence of views."""

    def __init__(self, part: Part) -> None:
        self._part = part

    def __len__(self) -> int:
        return len(self._part)

    def __getitem__(self, index: int) -> Node:
        return Node(self._part, index)

    def __iter__(self) -> Iterator[Node]:
        return (Node(self._part, index) for index in range(len(self)))

    def __repr__(self) -> str:
        return f"<{len(self)} nodes of part '{self._part.name}'>"
