"""Part: a coordinate system, a geometry, the nodes that fill it and the bonds between them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput, MissingField
from rbs_core.fields import Field, FieldStore, volume
from rbs_core.geometry import Everywhere, Geometry
from rbs_core.part.discretized import Discretized
from rbs_core.part.families import Predicate, families, left_out
from rbs_core.part.mesh import placed
from rbs_core.part.neighborhoods import Bonds
from rbs_core.part.rigid import rigid
from rbs_core.part.storage import TOLERANCE
from rbs_core.space import CoordinateSystem, Grid, world

REALS = {"double": "float64", "single": "float32"}


class Part(Discretized):
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
        self._sets: dict[str, NDArray[np.int64]] = {}
        self._values = FieldStore(f"part '{name}'", "part", None, dimension)

    @classmethod
    def from_points(
        cls,
        name: str,
        points: ArrayLike,
        volumes: ArrayLike,
        *,
        spacing: float | None = None,
        thickness: float | None = None,
        area: float | None = None,
        system: CoordinateSystem | None = None,
        precision: str = "double",
    ) -> Self:
        """A part of nodes from elsewhere.

        Args:
            name: of the part.
            points: (n, d) positions in local coordinates, m; d is the dimension. (n,) for a 1-D part.
            volumes: (n,) or one number, m^3, with the thickness (2-D) or area (1-D) in it.
            spacing: typical distance of nodes, m, for whatever needs one.
            thickness: of a 2-D part, m (1 m if not given).
            area: cross-section of a 1-D part, m^2 (1 m^2 if not given).
            system: as of every part.
            precision: as of every part.

        Raises:
            BadInput: on a wrong shape, a number that is not finite, or a volume that is not positive.
        """
        positions = np.asarray(points)
        if positions.ndim not in (1, 2) or (positions.ndim == 2 and positions.shape[1] not in (1, 2, 3)):
            raise BadInput(f"part '{name}': points must be (n, d) with d = 1, 2 or 3, got {positions.shape}")
        dimension = 1 if positions.ndim == 1 else positions.shape[1]
        part = cls(name, Everywhere(), system=system, dimension=dimension, precision=precision)
        return part.place(points, volumes, spacing=spacing, thickness=thickness, area=area)

    @classmethod
    def from_mesh(
        cls,
        name: str,
        mesh: Any,
        *,
        only: str | Sequence[str] | None = None,
        scale: float = 1.0,
        thickness: float | None = None,
        area: float | None = None,
        spacing: float | None = None,
        reorient: bool = False,
        file_format: str | None = None,
        system: CoordinateSystem | None = None,
        precision: str = "double",
    ) -> Self:
        """A part with a node for each cell of a mesh: at its centroid, with its volume.

        Args:
            name: of the part.
            mesh: path of a file that meshio reads (Abaqus, gmsh, Exodus, VTK and others), or a meshio.Mesh.
            only: name of a set, or several: nodes are the cells in one of them.
            scale: length of one unit of the mesh, m, e.g. 1e-3 for millimetres.
            thickness: of a 2-D part, m (1 m if not given).
            area: cross-section of a 1-D part, m^2 (1 m^2 if not given).
            spacing: typical distance of nodes, m; the mean size of the cells if not given, or None where the largest is
                more than 1.5 times as wide as the smallest.
            reorient: take cells that are turned inside out (negative volume) as if they were not.
            file_format: as meshio calls it; from the name of the file if not given.
            system: as of every part; its coordinates are those of the mesh.
            precision: as of every part.

        The dimension is the highest one of cells: triangles make a 2-D part, if they lie in a plane of constant z.
        Cells of second order count as their corners. Points that no cell uses, and cells that are there twice, are left
        out. Sets keep their names, as `node_sets`: those of cells; those of lower cells, such as boundaries, as the
        cells that have one of these as a side, edge or corner; those of points as the cells with a whole side among
        them, or with any of the points if there is no such side.

        Raises:
            BadInput: if the file is not there or cannot be read, if cells have no volume or a negative one (named with
                their points), are of an unknown kind or form a shell in space, or if `only` does not exist (with the
                nearest names).

        Warns:
            UserWarning: with what meshio has to say, and the names of sets in which there is no cell.
        """
        owner = f"part '{name}'"
        found = placed(owner, mesh, only=only, scale=scale, file_format=file_format, reorient=reorient)
        part = cls(name, Everywhere(), system=system, dimension=found.dimension, precision=precision)
        across = part._across(thickness, area)
        part.place(
            found.positions, found.measures * across, thickness=thickness, area=area,
            spacing=found.spacing if spacing is None else spacing,
        )  # fmt: skip
        for each, nodes in found.sets.items():
            part.node_sets[each] = nodes
        if found.unknown:
            warnings.warn(f"{owner}: no cell is in {', '.join(found.unknown)}: left out", stacklevel=2)
        return part

    def __repr__(self) -> str:
        nodes = "not discretized" if self._nodes is None else f"{len(self)} nodes"
        bonds = "not connected" if self._bonds is None else repr(self._bonds)[1:-1]
        return f"<Part '{self.name}', {self.dimension}-D, {nodes}, {bonds}>"

    # -- nodes ------------------------------------------------------------------------------------------------------

    @property
    def version(self) -> tuple[int, int | None]:
        """Numbers of the present nodes and bonds (None before `connect`): they change when these are made anew."""
        return self._made[0], self._made[1] if self._bonds is not None else None

    # -- bonds ------------------------------------------------------------------------------------------------------

    def connect(
        self,
        horizon: float,
        *,
        reach: float | None = None,
        storage: str | None = None,
        where: Predicate | None = None,
    ) -> Self:
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
            where: leaves out bonds for which this function of their starts and ends, (m, d) in local coordinates, is
                not True; it must say the same of both directions of a bond.

        Raises:
            BadInput: if the horizon is not positive, or below the spacing so that nobody has a neighbor; on a reach
                below the horizon, an unknown storage, or a lattice for nodes that are not on a grid; before bonds are
                made, if they do not fit into memory; if `where` does not return one truth value per bond, or not the
                same for the way back.

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
        if where is not None:
            stored.remove(left_out(self.name, where), np.ones(len(positions), np.bool_))
        positions.flags.writeable = False  # the bonds hold lengths that were measured here
        self._made = (self._made[0], self._made[1] + 1)
        self._bonds = Bonds(f"part '{self.name}'", positions, float(horizon), stored, storage is not None, radius)
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
