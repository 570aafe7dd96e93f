"""Connection: bonds between the nodes of two parts, or more bonds between those of one."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput, MissingField
from rbs_core.fields import Field, FieldStore
from rbs_core.part.host import Host
from rbs_core.part.neighborhoods import Bonds
from rbs_core.part.pairs import Pairs, Points, ordered, pairs_among, pairs_between
from rbs_core.part.part import Part
from rbs_core.part.rows import Rows
from rbs_core.space import convert, world

Predicate = Callable[[Points, Points], ArrayLike]
Displacements = Sequence[NDArray[Any] | None]


class Connection(Host):
    """Bonds between two parts, which may have systems of their own, and overlap; or more bonds within one part.

    Args:
        part: one part.
        other: the other one, of the same dimension; None for bonds within the one, beside its own.
        horizon: nodes up to so far apart are bonded, m.
        pairs: (k, 2) instead of a horizon: which node of `part` is bonded to which node of `other`.
        where: leaves out bonds for which this function of their ends, (k, d) in world coordinates, is not True.
        both: False for bonds that only the nodes of `part` feel.
        name: used in messages, reports and files; "<part> to <other>" or "within <part>" if not given.

    Raises:
        BadInput: if both or neither of horizon and pairs are given, on parts without nodes or of other dimensions, on
            nodes that do not exist, or two nodes at one place.

    Warns:
        UserWarning: if no node is within the horizon of another.

    The nodes of a connection are those of `part` that have a bond, in ascending order, and then those of `other`.

    Attributes:
        ends: the two parts, or the one.
        nodes: for each of them, (k,) indices of the nodes that have a bond.
        both: whether the nodes of both parts feel the bonds.
    """

    def __init__(
        self,
        part: Part,
        other: Part | None = None,
        horizon: float | None = None,
        *,
        pairs: ArrayLike | None = None,
        where: Predicate | None = None,
        both: bool = True,
        name: str | None = None,
    ) -> None:
        self.ends: tuple[Part, ...] = (part,) if other is None or other is part else (part, other)
        names = [getattr(end, "name", repr(end)) for end in self.ends]
        self.name = (" to ".join(names) if len(names) == 2 else f"within {names[0]}") if name is None else name
        self._check_ends()
        if (horizon is None) == (pairs is None):
            raise BadInput(f"connection '{self.name}': give either a horizon or pairs of nodes")
        if horizon is not None and not (np.isfinite(horizon) and horizon > 0):
            raise BadInput(f"connection '{self.name}': horizon={horizon} must be positive and finite")
        if not both and len(self.ends) == 1:
            raise BadInput(f"connection '{self.name}': within one part, both ends of a bond feel it: leave both out")
        self.horizon, self._where, self.both = horizon, where, both
        self.dimension, self.precision = part.dimension, "double"
        one, two = self.ends[0], self.ends[-1]
        self.thickness = one.thickness if one.thickness == two.thickness else None
        self.area = one.area if one.area == two.area else None
        self.spacing = part.spacing
        self._made = 0
        self._again = False
        self._values = FieldStore(f"connection '{self.name}'", "part", None, part.dimension)
        if pairs is not None:
            self.take(pairs)
        else:
            self.search()
        if horizon is not None and not len(self.bonds):
            warnings.warn(
                f"connection '{self.name}' has no bond: check the horizon, and where the parts lie in the world",
                stacklevel=2,
            )

    def _check_ends(self) -> None:
        for end in self.ends:
            if not isinstance(end, Part):
                raise BadInput(f"connection '{self.name}': {end!r} is no Part")
            len(end)  # a part without nodes says so
        one, two = self.ends[0], self.ends[-1]
        if one.dimension != two.dimension:
            raise BadInput(
                f"connection '{self.name}': '{one.name}' has dimension {one.dimension}, '{two.name}' has "
                f"{two.dimension}: only parts of one dimension can be connected"
            )

    def __repr__(self) -> str:
        each = (f"{len(nodes)} nodes of '{end.name}'" for nodes, end in zip(self.nodes, self.ends, strict=True))
        return f"<Connection '{self.name}', {len(self.bonds)} directed bonds, {', '.join(each)}>"

    def __len__(self) -> int:
        return sum(len(nodes) for nodes in self.nodes)

    # -- search -----------------------------------------------------------------------------------------------------

    def search(self, displacements: Displacements | None = None) -> None:
        """Finds the bonds anew, among nodes that have been displaced; what bond fields held is forgotten.

        Args:
            displacements: (n, d) of each part, m, in its own coordinates; none if not given.

        Raises:
            BadInput: for a connection that was given pairs.
        """
        if self.horizon is None:
            raise BadInput(f"connection '{self.name}' was given pairs of nodes: there is nothing to search")
        places = self.places(displacements)
        one, two = places[0], places[-1]
        found = pairs_among(one, self.horizon) if two is one else pairs_between(one, two, self.horizon)
        if self._where is not None and len(found):
            keep = np.asarray(self._where(one[found[:, 0]], two[found[:, 1]]))
            if keep.shape != (len(found),) or keep.dtype != np.bool_:
                raise BadInput(f"connection '{self.name}': where(starts, ends) must return one truth value per bond")
            found = found[keep]
        self._connect(found, self._joint(found, places))

    def take(self, pairs: ArrayLike, displacements: Displacements | None = None) -> None:
        """Takes bonds that somebody else has found; what bond fields held is forgotten.

        Args:
            pairs: (k, 2) which node of the first part is bonded to which one of the second, or to which other one.
            displacements: of each part, as in `search`: lengths are measured between displaced nodes.

        Raises:
            BadInput: on a wrong shape, nodes that do not exist, or two nodes at one place.
        """
        found = self._given(pairs)
        self._connect(found, self._joint(found, self.places(displacements)))

    def state(self) -> dict[str, NDArray[Any]]:
        """What tells the present bonds: who searches during runs keeps it, for checkpoints."""
        fields = {f"field {field.name}": self.raw(field) for field in self.bonds.fields}
        return {"pairs": self.pairs, "positions": self.positions, **fields}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Takes bonds as `state` has told them."""
        fields = list(self.bonds.fields)
        self._connect(state["pairs"], state["positions"])
        for field in fields:
            if f"field {field.name}" in state:
                self.raw(field)[...] = state[f"field {field.name}"]

    def places(self, displacements: Displacements | None = None) -> list[Points]:
        """Positions of all nodes of each part in world coordinates, (n, d), m."""
        moved = displacements or [None] * len(self.ends)
        return [in_world(end, u) for end, u in zip(self.ends, moved, strict=True)]

    def search_during_runs(self) -> None:
        """Says that bonds will come and go during a run."""
        self._again = True

    @property
    def searched_again(self) -> bool:
        return self._again

    @property
    def pairs(self) -> Pairs:
        """(k, 2) which node of the first part is bonded to which one of the second, ordered."""
        offsets, neighbors = self.bonds.as_rows()
        split = len(self.nodes[0])
        starts, ends = np.repeat(np.arange(len(self)), np.diff(offsets)), neighbors.astype(np.int64)
        if len(self.ends) == 1:
            return np.stack([self.nodes[0][each[starts < ends]] for each in (starts, ends)], axis=1)
        ahead = starts < split
        return np.stack([self.nodes[0][starts[ahead]], self.nodes[1][ends[ahead] - split]], axis=1)

    def _given(self, pairs: ArrayLike) -> Pairs:
        found = np.asarray(pairs)
        if found.ndim != 2 or found.shape[1] != 2 or found.dtype.kind not in "iu":
            raise BadInput(f"connection '{self.name}': pairs must be whole numbers (k, 2), got shape {found.shape}")
        for column, end in enumerate((self.ends[0], self.ends[-1])):
            wrong = found[(found[:, column] < 0) | (found[:, column] >= len(end)), column]
            if len(wrong):
                raise BadInput(
                    f"connection '{self.name}': part '{end.name}' has no node {wrong[0]}, only 0 to {len(end) - 1}"
                )
        if len(self.ends) == 1:
            found = np.sort(found, axis=1)
            if (found[:, 0] == found[:, 1]).any():
                wrong = found[found[:, 0] == found[:, 1], 0]
                raise BadInput(f"connection '{self.name}': node {wrong[0]} cannot be bonded to itself")
        return np.unique(found.astype(np.int64), axis=0)

    def _bonded(self, pairs: Pairs) -> tuple[NDArray[np.int64], ...]:
        """Nodes of each part that have a bond."""
        return (np.unique(pairs),) if len(self.ends) == 1 else tuple(np.unique(each) for each in pairs.T)

    def _joint(self, pairs: Pairs, places: Sequence[Points]) -> Points:
        """Positions of the nodes that have a bond."""
        return np.concatenate([place[nodes] for place, nodes in zip(places, self._bonded(pairs), strict=True)])

    def _connect(self, pairs: Pairs, positions: Points) -> None:
        """Holds bonds between nodes at these (n, d) positions in the world."""
        self.nodes = self._bonded(pairs)
        here, there = (np.searchsorted(self.nodes[side], pairs[:, column]) for column, side in ((0, 0), (1, -1)))
        there = there + (len(self.nodes[0]) if len(self.ends) == 2 else 0)
        directed = np.stack([here, there], axis=1)
        directed = ordered(np.concatenate([directed, directed[:, ::-1]]) if self.both else directed)
        offsets = np.searchsorted(directed[:, 0], np.arange(len(positions) + 1)).astype(np.int64)
        lengths = np.linalg.norm(positions[directed[:, 1]] - positions[directed[:, 0]], axis=1)
        if len(lengths) and not lengths.min() > 0:
            wrong = np.argmin(np.linalg.norm(positions[there] - positions[here], axis=1))
            first, second = pairs[wrong]
            raise BadInput(
                f"connection '{self.name}': node {first} of '{self.ends[0].name}' and node {second} of "
                f"'{self.ends[-1].name}' are both at {positions[here[wrong]].tolist()} (world): move one, or leave the "
                "bond out with where="
            )
        rows = Rows(
            f"connection '{self.name}'",
            positions,
            (offsets, directed[:, 1].astype(np.uint32), 1.0 / lengths),
            "float64",
        )
        horizon = float(lengths.max(initial=0.0)) if self.horizon is None else self.horizon
        self._made += 1
        self._bonds = Bonds(f"connection '{self.name}'", positions, horizon, rows, chosen=True)

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
    return to_world(part, local)


def to_world(part: Part, points: Points) -> Points:
    """Points (n, d) of the system of a part in world coordinates, m."""
    return points if part.system is world else convert(points, part.system, world)
