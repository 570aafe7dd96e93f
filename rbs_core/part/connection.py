"""Connection: bonds between the nodes of two parts."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from rbs_core.errors import BadInput, MissingField
from rbs_core.fields import Field, FieldStore
from rbs_core.part.host import Host
from rbs_core.part.neighborhoods import Bonds
from rbs_core.part.part import Part
from rbs_core.part.rows import Rows
from rbs_core.part.storage import TOLERANCE
from rbs_core.space import convert, world

Points = NDArray[np.float64]
Pairs = NDArray[np.int64]


class Connection(Host):
    """Bonds between two parts, which may have systems of their own, and overlap.

    Args:
        part: one part.
        other: the other one, of the same dimension.
        horizon: nodes of the two parts up to so far apart are bonded, m.
        pairs: (k, 2) instead of a horizon: which node of `part` is bonded to which node of `other`.
        where: leaves out bonds for which this function of their ends, (k, d) in world coordinates, is not True.
        both: False for bonds that only the nodes of `part` feel.
        name: used in messages, reports and files; "<part> to <other>" if not given.

    Raises:
        BadInput: if both or neither of horizon and pairs are given, on parts without nodes or of other dimensions, on
            nodes that do not exist, or two nodes at one place.

    Warns:
        UserWarning: if there is no bond.

    The nodes of a connection are those of `part` that have a bond, in ascending order, and then those of `other`.

    Attributes:
        ends: the two parts.
        nodes: for each of them, (k,) indices of the nodes that have a bond.
    """

    def __init__(
        self,
        part: Part,
        other: Part,
        horizon: float | None = None,
        *,
        pairs: ArrayLike | None = None,
        where: Callable[[Points, Points], ArrayLike] | None = None,
        both: bool = True,
        name: str | None = None,
    ) -> None:
        self.ends = (part, other)
        self.name = " to ".join(getattr(end, "name", repr(end)) for end in self.ends) if name is None else name
        self._check_ends()
        if (horizon is None) == (pairs is None):
            raise BadInput(f"connection '{self.name}': give either a horizon or pairs of nodes")
        if horizon is not None and not (np.isfinite(horizon) and horizon > 0):
            raise BadInput(f"connection '{self.name}': horizon={horizon} must be positive and finite")
        self.horizon, self._where, self._both = horizon, where, both
        self.dimension, self.precision = part.dimension, "double"
        self.thickness, self.area, self.spacing = part.thickness, part.area, part.spacing
        self._made = 0
        self._again = False
        self._values = FieldStore(f"connection '{self.name}'", "part", None, part.dimension)
        places = tuple(in_world(end) for end in self.ends)
        self._connect(self._given(pairs) if pairs is not None else self._found(*places), *places)
        if not len(self.bonds):
            warnings.warn(
                f"connection '{self.name}' has no bond: check the horizon, and where the parts lie in the world",
                stacklevel=2,
            )

    def _check_ends(self) -> None:
        for end in self.ends:
            if not isinstance(end, Part):
                raise BadInput(f"connection '{self.name}': {end!r} is no Part")
            len(end)  # a part without nodes says so
        one, two = self.ends
        if one.dimension != two.dimension:
            raise BadInput(
                f"connection '{self.name}': '{one.name}' has dimension {one.dimension}, '{two.name}' has "
                f"{two.dimension}: only parts of one dimension can be connected"
            )

    def __repr__(self) -> str:
        one, two = (f"{len(nodes)} nodes of '{end.name}'" for nodes, end in zip(self.nodes, self.ends, strict=True))
        return f"<Connection '{self.name}', {len(self.bonds)} directed bonds, {one}, {two}>"

    def __len__(self) -> int:
        return sum(len(nodes) for nodes in self.nodes)

    # -- search -----------------------------------------------------------------------------------------------------

    def search(self, displacements: tuple[NDArray[Any], NDArray[Any]] | None = None) -> None:
        """Finds the bonds anew, among nodes that have been displaced; what bond fields held is forgotten.

        Args:
            displacements: (n, d) of either part, m, in its own coordinates; none if not given.

        Raises:
            BadInput: for a connection that was given pairs.
        """
        if self.horizon is None:
            raise BadInput(f"connection '{self.name}' was given pairs of nodes: there is nothing to search")
        moved = (None, None) if displacements is None else displacements
        places = tuple(in_world(end, u) for end, u in zip(self.ends, moved, strict=True))
        self._connect(self._found(*places), *places)

    def search_during_runs(self) -> None:
        """Says that bonds will come and go during a run."""
        self._again = True

    @property
    def searched_again(self) -> bool:
        return self._again

    def _given(self, pairs: ArrayLike) -> Pairs:
        found = np.asarray(pairs)
        if found.ndim != 2 or found.shape[1] != 2 or found.dtype.kind not in "iu":
            raise BadInput(f"connection '{self.name}': pairs must be whole numbers (k, 2), got shape {found.shape}")
        for column, end in enumerate(self.ends):
            wrong = found[(found[:, column] < 0) | (found[:, column] >= len(end)), column]
            if len(wrong):
                raise BadInput(
                    f"connection '{self.name}': part '{end.name}' has no node {wrong[0]}, only 0 to {len(end) - 1}"
                )
        return np.unique(found.astype(np.int64), axis=0)

    def _found(self, one: Points, two: Points) -> Pairs:
        """(k, 2) nodes within the horizon."""
        assert self.horizon is not None
        pairs = pairs_within(one, two, self.horizon)
        if self._where is not None and len(pairs):
            keep = np.asarray(self._where(one[pairs[:, 0]], two[pairs[:, 1]]))
            if keep.shape != (len(pairs),) or keep.dtype != np.bool_:
                raise BadInput(f"connection '{self.name}': where(starts, ends) must return one truth value per bond")
            pairs = pairs[keep]
        return pairs

    def _connect(self, pairs: Pairs, one: Points, two: Points) -> None:
        self.nodes = tuple(np.unique(pairs[:, column]) for column in (0, 1))
        here, there = (np.searchsorted(self.nodes[column], pairs[:, column]) for column in (0, 1))
        there = there + len(self.nodes[0])
        directed = np.stack([here, there], axis=1)
        if self._both:
            directed = np.concatenate([directed, directed[:, ::-1]])
        directed = directed[np.lexsort((directed[:, 1], directed[:, 0]))]
        positions = np.concatenate([one[self.nodes[0]], two[self.nodes[1]]])
        offsets = np.searchsorted(directed[:, 0], np.arange(len(positions) + 1)).astype(np.int64)
        lengths = np.linalg.norm(positions[directed[:, 1]] - positions[directed[:, 0]], axis=1)
        if len(lengths) and not lengths.min() > 0:
            first, second = directed[int(np.argmin(lengths))]
            raise BadInput(
                f"connection '{self.name}': nodes of '{self.ends[0].name}' and '{self.ends[1].name}' are both at "
                f"{positions[min(first, second)].tolist()} (world): move one, or leave the bond out with where="
            )
        rows = Rows(self.name, positions, (offsets, directed[:, 1].astype(np.uint32), 1.0 / lengths), "float64")
        horizon = float(lengths.max(initial=0.0)) if self.horizon is None else self.horizon
        self._made += 1
        self._bonds = Bonds(self.name, positions, horizon, rows, chosen=True)

    # -- as every host ----------------------------------------------------------------------------------------------

    def store(self, at: str) -> FieldStore:
        if at == "node":
            raise MissingField(f"connection '{self.name}' has no fields at nodes: ask its parts")
        return self.bonds.fields if at == "bond" else self._values

    def __setitem__(self, field: Field, value: Any) -> None:
        self.store(field.at).set(field, value)

    @property
    def fields(self) -> list[Field]:
        return [*self.bonds.fields, *self._values]

    @property
    def nbytes(self) -> int:
        return self.bonds.nbytes + sum(nodes.nbytes for nodes in self.nodes) + self.positions.nbytes

    @property
    def bonds(self) -> Bonds:
        return self._bonds

    @property
    def connected(self) -> bool:
        return True

    @property
    def version(self) -> tuple[int, int | None]:
        return 1, self._made

    @property
    def positions(self) -> Points:
        """(n, d) positions of its nodes when the bonds were found, m, in world coordinates."""
        return self.bonds.positions


def in_world(part: Part, displacement: NDArray[Any] | None = None) -> Points:
    """(n, d) positions of the nodes of a part in world coordinates, m."""
    local = part.positions if displacement is None else part.positions + displacement
    return local if part.system is world else convert(local, part.system, world)


def pairs_within(one: Points, two: Points, horizon: float) -> Pairs:
    """(k, 2) which of some points are within a distance of which others, ordered by the first and the second."""
    reach = horizon * (1 + TOLERANCE)
    first = _inside(one, two, reach)
    second = _inside(two, one[first], reach) if len(first) else first
    if not len(first) or not len(second):
        return np.empty((0, 2), np.int64)
    close = cKDTree(one[first]).sparse_distance_matrix(cKDTree(two[second]), reach, output_type="ndarray")
    pairs = np.stack([first[close["i"]], second[close["j"]]], axis=1).astype(np.int64)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def _inside(points: Points, others: Points, reach: float) -> NDArray[np.int64]:
    """Indices of the points in the box around others, widened."""
    low, high = others.min(axis=0) - reach, others.max(axis=0) + reach
    return np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))
