"""Specimens: small bodies with one relation on them, and how exact their forces can be.

Two scales decide what "zero" and "equal" mean, and both are measured on the specimen:

* Positions are known to half a unit in the last place, so the length of a bond at rest is known to a few ε |X|. That
  acts like a rough displacement of this size. With the stiffness K = max |force| / size of a small rough displacement,
  a force that should vanish may be as large as `ULPS` ε (|X| + |u|) K, and no larger: `floor`.
* A sum of N terms loses at most N ε times the sum of their sizes, whatever its order. For rough displacements the terms
  point in random directions, and the sum of their sizes is about √N times the size of the sum: a force that should
  equal another may differ by N^1.5 ε of the largest: `blur`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rbs_core as rbs
from rbs_core.relation import WORDS
from rbs_core.testing import furnish, make, partners
from rbs_plugins.fields import density, displacement, force_density, intact, volume
from rbs_plugins.measures.energy import StrainEnergy

Array = NDArray[np.float64]
RelationClass = type[rbs.Relation]

CLOUDS = ("grid", "jittered", "lattice", "single")
SPACING = 1e-3
CENTER = (0.013, -0.007, 0.021)  # away from the origin: there round-off would be flattered
RATIO = 3.015
FEW = {1: (24,), 2: (8, 7), 3: (5, 5, 4)}
MANY = {1: (4000,), 2: (36, 32), 3: (12, 12, 10)}
EPSILON = float(np.finfo(np.float64).eps)
ULPS = 8  # rounding of X, u and X + u at both ends, of the difference, its square root, and the inverse length
SMALL = 1e-6  # spacings: a displacement within which every law is straight
ROUGH = 0.02  # spacings: a displacement in which a law shows its shape


class NotApplicable(Exception):
    """A check that says nothing about a relation, with the reason."""


def body(
    dimension: int, cloud: str = "jittered", *, shape: Sequence[int] | None = None, notched: bool = True
) -> rbs.Part:
    """A connected part away from the origin, with density, and bonds broken across a plane.

    Args:
        dimension: 1, 2 or 3.
        cloud: "jittered" for displaced nodes with unequal volumes; for a regular grid with equal volumes "grid", with
            bonds stored as list, "lattice", stored as that, or "single", as lattice and in single precision.
        shape: nodes per axis.
        notched: whether the longer bonds through the middle plane are broken.
    """
    shape = FEW[dimension] if shape is None else tuple(shape)
    across: dict[str, Any] = {1: {"area": 2e-6}, 2: {"thickness": 2e-3}, 3: {}}[dimension]
    box = rbs.Box(size=[SPACING * n for n in shape], center=CENTER[:dimension])
    precision = "single" if cloud == "single" else "double"
    geometry = rbs.Everywhere() if cloud == "jittered" else box
    part = rbs.Part("specimen", geometry, dimension=dimension, precision=precision)
    storage = "list"
    if cloud != "jittered":
        part.discretize(SPACING, **across)
        storage = "list" if cloud == "grid" else "lattice"
    else:
        rng = np.random.default_rng(7)
        grid = rbs.Part("grid", box).discretize(SPACING, **across)
        points = grid.positions + rng.uniform(-0.2, 0.2, grid.positions.shape) * SPACING
        part.place(points, grid[volume] * rng.uniform(0.7, 1.3, len(grid)), spacing=SPACING, **across)
    part.connect(RATIO * SPACING, storage=storage)
    part[density] = np.random.default_rng(8).uniform(1000.0, 2000.0, len(part))
    if notched:
        part.bonds.cut(_notch)
    return part


def _notch(starts: Array, ends: Array) -> NDArray[np.bool_]:
    """Longer bonds through the plane in the middle: nodes stay attached, and no node loses all of one side."""
    through = (starts[:, 0] > CENTER[0]) != (ends[:, 0] > CENTER[0])
    return through & (np.linalg.norm(ends - starts, axis=1) > 1.5 * SPACING)


def again(part: rbs.Part, *, points: Array | None = None, order: NDArray[np.int64] | None = None) -> rbs.Part:
    """The same nodes at other places or in another order, with the same bonds broken.

    Args:
        part: a connected part.
        points: (n, d) new places, in the order of `part`.
        order: node k of the copy is node order[k] of the part.
    """
    order = np.arange(len(part)) if order is None else order
    across = {name: getattr(part, name) for name in ("thickness", "area") if getattr(part, name) is not None}
    copy = rbs.Part(part.name, rbs.Everywhere(), dimension=part.dimension, precision=part.precision)
    places = (part.positions if points is None else points)[order]
    copy.place(places, part[volume][order], spacing=part.spacing, **across).connect(part.bonds.horizon)
    copy[density] = part[density][order]
    assert len(copy.bonds) == len(part.bonds), "the copy has other families: a node lies on the edge of a horizon"
    old = _keys(part, np.arange(len(part)))
    new = _keys(copy, order)
    sorting = np.argsort(old)
    copy[intact] = part.bonds.intact[sorting][np.searchsorted(old[sorting], new)]
    return copy


def _keys(part: rbs.Part, order: NDArray[np.int64]) -> NDArray[np.int64]:
    """One number per directed bond, in terms of the nodes that `order` names."""
    nodes, neighbors = ends(part)
    return order[nodes] * len(part) + order[neighbors]


def ends(part: rbs.Part) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Node and neighbor of every directed bond."""
    offsets, neighbors = part.bonds.as_rows()
    return np.repeat(np.arange(len(part)), np.diff(offsets)), neighbors.astype(np.int64)


def suits(relation: rbs.Relation) -> None:
    """Raises NotApplicable if a relation cannot work with the bonds of its part as they are stored."""
    bonds = any(field.at == "bond" for _, field in relation.keys(*WORDS))
    if bonds and relation.part.bonds.storage not in relation.storages:
        known = " or ".join(relation.storages)
        raise NotApplicable(f"{type(relation).__name__} works with bonds stored as {known} only")


class Specimen:
    """A part with one relation on it, ready to be asked for forces and energies of any displacement.

    Args:
        relation_class: makes the relation, by its `example`.
        part: see `body`.
        **arguments: instead of, or beside those of the example.
    """

    def __init__(self, relation_class: RelationClass, part: rbs.Part, **arguments: Any) -> None:
        relation = make(relation_class, part, **arguments)
        if relation is None:
            raise NotApplicable(f"the example of {relation_class.__name__} is not made for {part.dimension}-D parts")
        suits(relation)
        if (part, force_density) not in relation.keys("adds"):
            raise NotApplicable(f"{relation_class.__name__} adds no force density")
        self.part, self.relation = part, relation
        self.relations = [*partners(relation), relation]
        self.measure = StrainEnergy(part, [relation]) if hasattr(relation, "energy") else None  # type: ignore[list-item]
        scene = [*self.relations, *([self.measure] if self.measure else [])]
        furnish(scene)
        self._analysis = rbs.Analysis(scene)
        self._plan = self._analysis.prepare()
        self._clock = rbs.Clock(dt=1e-9, step=1, time=1e-9, last_step=1)
        self._start: dict[Any, Any] = {}
        self._remember()

    def _remember(self) -> None:
        self._start = {(part, field): part.raw(field).copy() for part, field in self._plan.changed}

    def _place(self, u: Array) -> None:
        """Back to the start, with another displacement."""
        for (part, field), values in self._start.items():
            part.raw(field)[...] = values
        self.part[displacement][...] = u

    def force(self, u: Array) -> Array:
        """(n, d) force density for a displacement, N/m^3, from the state at the start."""
        self._place(u)
        for relation in self.relations:
            relation.begin(self._clock)
        for position, relation in enumerate(self.relations):
            for part, field in self._plan.clear.get(position, ()):
                part[field][...] = 0
            relation.apply(self._clock)
        return self.part[force_density].astype(np.float64)

    def settle(self, u: Array) -> None:
        """Applies a displacement and makes the state behind it (broken bonds) the start of what follows."""
        self.force(u)
        self._remember()

    def energy(self, u: Array) -> float:
        """Strain energy for a displacement, J, from the state at the start."""
        if self.measure is None:
            raise NotApplicable(f"{type(self.relation).__name__} does not know its energy")
        self._place(u)
        self.measure.begin(self._clock)
        self.measure.apply(self._clock)
        return float(self.part[self.measure.writes[1]])

    # -- displacements and scales

    def rough(self, size: float, seed: int = 1) -> Array:
        """(n, d) random displacement of so many spacings: neighbors move in different directions."""
        shape = self.part.positions.shape
        return np.random.default_rng(seed).uniform(-1.0, 1.0, shape) * size * SPACING

    def deformation(self) -> Array:
        """A rough displacement in which the law shows its shape: as large as it goes without breaking most bonds."""
        size = ROUGH
        while intact in self.relation.updates and size > SMALL:
            self.force(self.rough(size))
            holding = np.count_nonzero(self.part.bonds.intact)
            self._place(np.zeros_like(self.part.positions))
            broken = np.count_nonzero(self.part.bonds.intact) - holding
            if broken < len(self.part.bonds) / 4:
                break
            size /= 2
        return self.rough(size)

    @property
    def epsilon(self) -> float:
        """Rounding of fields, relative."""
        return float(np.finfo(self.part[displacement].dtype).eps)

    @property
    def stiffness(self) -> float:
        """K, N/m^4: force density per size of a small rough displacement."""
        return float(np.abs(self.force(self.rough(SMALL))).max()) / (SMALL * SPACING)

    def floor(self, u: Array | float = 0.0) -> float:
        """Largest force density that round-off of the positions can make at a displacement."""
        blurred = EPSILON * float(np.abs(self.part.positions).max()) + self.epsilon * float(np.abs(u).max())
        return ULPS * blurred * self.stiffness

    @property
    def blur(self) -> float:
        """Relative error of a sum over a family."""
        return float(self.part.bonds.counts().max()) ** 1.5 * self.epsilon
