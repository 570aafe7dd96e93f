"""Physics conformance: what every relation must do, whoever wrote it.

A plugin author needs two lines in a test file:

    from rbs_plugins.testing import conformance
    test_granite = conformance("rbs_granite")

Every check is a plain function of a relation class, a dimension and a cloud of nodes ("grid" or "jittered"), and can be
called on its own: `check_momentum(Granite, 2, "jittered", E=50e9)`. Instances come from the class attribute `example`;
keywords given to a check replace or complete it.

How exact is exact? Two scales decide, and both are measured on the specimen:

* Positions are known to half a unit in the last place, so the length of a bond at rest is known to a few ε |X|. That
  acts like a rough displacement of this size. With the stiffness K = max |force| / size of a small rough displacement,
  a force that should vanish may be as large as `ULPS` ε (|X| + |u|) K, and no larger: `floor`.
* A sum of N terms loses at most N ε times the sum of their sizes, whatever its order. For rough displacements the terms
  point in random directions, and the sum of their sizes is about √N times the size of the sum: a force that should
  equal another may differ by N^1.5 ε of the largest: `blur`.
"""

from __future__ import annotations

import importlib
import inspect
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import eigsh

import rbs_core as rbs
from rbs_core.testing import (
    check_contract,
    check_resume,
    furnish,
    isolated_registry,
    make,
    partners,
)
from rbs_plugins.constitutive.bond_based import BondBased
from rbs_plugins.constitutive.fracture import CriticalStretch
from rbs_plugins.fields import density, displacement, force_density, intact, reference_position, velocity, volume
from rbs_plugins.integrators.explicit import VelocityVerlet
from rbs_plugins.loops import SERIAL_BELOW
from rbs_plugins.measures import StrainEnergy

Array = NDArray[np.float64]
RelationClass = type[rbs.Relation]

CLOUDS = ("grid", "jittered")
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


# -- specimens ------------------------------------------------------------------------------------------------------


def body(
    dimension: int, cloud: str = "jittered", *, shape: Sequence[int] | None = None, notched: bool = True
) -> rbs.Part:
    """A connected part away from the origin, with density, and bonds broken across a plane.

    Args:
        dimension: 1, 2 or 3.
        cloud: "grid" for a regular grid with equal volumes, "jittered" for displaced nodes with unequal volumes.
        shape: nodes per axis.
        notched: whether the longer bonds through the middle plane are broken.
    """
    shape = FEW[dimension] if shape is None else tuple(shape)
    across: dict[str, Any] = {1: {"area": 2e-6}, 2: {"thickness": 2e-3}, 3: {}}[dimension]
    box = rbs.Box(size=[SPACING * n for n in shape], center=CENTER[:dimension])
    part = rbs.Part("specimen", box if cloud == "grid" else rbs.Everywhere(), dimension=dimension)
    if cloud == "grid":
        part.discretize(SPACING, **across)
    else:
        rng = np.random.default_rng(7)
        grid = rbs.Part("grid", box).discretize(SPACING, **across)
        points = grid.positions + rng.uniform(-0.2, 0.2, grid.positions.shape) * SPACING
        part.place(points, grid[volume] * rng.uniform(0.7, 1.3, len(grid)), spacing=SPACING, **across)
    part.connect(RATIO * SPACING)
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
    copy = rbs.Part(part.name, rbs.Everywhere(), dimension=part.dimension)
    places = (part.positions if points is None else points)[order]
    copy.place(places, part[volume][order], spacing=part.spacing, **across).connect(part.bonds.horizon)
    copy[density] = part[density][order]
    assert len(copy.bonds) == len(part.bonds), "the copy has other families: a node lies on the edge of a horizon"
    old = _keys(part, np.arange(len(part)))
    new = _keys(copy, order)
    sorting = np.argsort(old)
    copy.bonds.intact[...] = part.bonds.intact[sorting][np.searchsorted(old[sorting], new)]
    return copy


def _keys(part: rbs.Part, order: NDArray[np.int64]) -> NDArray[np.int64]:
    """One number per directed bond, in terms of the nodes that `order` names."""
    nodes, neighbors = ends(part)
    return order[nodes] * len(part) + order[neighbors]


def ends(part: rbs.Part) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Node and neighbor of every directed bond."""
    offsets, neighbors = part.bonds.as_rows()
    return np.repeat(np.arange(len(part)), np.diff(offsets)), neighbors.astype(np.int64)


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
        if force_density not in relation.adds:
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
        self._start = {(part, field): part[field].copy() for part, field in self._plan.changed}

    def _place(self, u: Array) -> None:
        """Back to the start, with another displacement."""
        for (part, field), values in self._start.items():
            part[field][...] = values
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
        return self.part[force_density].copy()

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
            broken = np.count_nonzero(self._start[self.part, intact] != self.part[intact])
            if broken < len(self.part.bonds) / 4:
                break
            size /= 2
        return self.rough(size)

    @property
    def stiffness(self) -> float:
        """K, N/m^4: force density per size of a small rough displacement."""
        return float(np.abs(self.force(self.rough(SMALL))).max()) / (SMALL * SPACING)

    def floor(self, u: Array | float = 0.0) -> float:
        """Largest force density that round-off of the positions can make at a displacement."""
        return ULPS * EPSILON * float(np.abs(self.part.positions).max() + np.abs(u).max()) * self.stiffness

    @property
    def blur(self) -> float:
        """Relative error of a sum over a family."""
        return float(self.part.bonds.counts().max()) ** 1.5 * EPSILON


# -- checks of forces -----------------------------------------------------------------------------------------------


def check_rest(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """A body at rest feels no force, and holds no energy: bonds have the lengths they were born with."""
    specimen = Specimen(relation_class, body(dimension, cloud), **arguments)
    still = np.zeros_like(specimen.part.positions)
    floor = specimen.floor()
    assert floor > 0, f"{specimen.relation!r} does not resist a small displacement: nothing could be seen at rest"
    _small("force at rest", specimen.force(still), floor)
    if specimen.measure is not None:
        error = ULPS * EPSILON * float(np.abs(specimen.part.positions).max())
        worst = specimen.stiffness * error**2 * specimen.part[volume].sum()
        _small("energy at rest", np.array(specimen.energy(still)), worst)


def check_momentum(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """Forces cancel: Σ f V = 0 for any displacement, unequal volumes and broken bonds (Newton's third law)."""
    specimen = Specimen(relation_class, body(dimension, cloud), **arguments)
    forces = specimen.force(specimen.deformation()) * specimen.part[volume][:, None]
    total = np.array([math.fsum(component) for component in forces.T])
    _small("total force", total, specimen.blur * float(np.abs(forces).sum()))


def check_angular_momentum(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """Torques cancel: Σ y × f V = 0 for any displacement, y the deformed positions."""
    specimen = Specimen(relation_class, body(dimension, cloud), **arguments)
    u = specimen.deformation()
    forces = specimen.force(u) * specimen.part[volume][:, None]
    places = specimen.part.positions + u
    pairs = [(a, b) for a in range(dimension) for b in range(a)]
    torques = np.array([places[:, a] * forces[:, b] - places[:, b] * forces[:, a] for a, b in pairs])
    total = np.array([math.fsum(component) for component in torques])
    arms = np.linalg.norm(places, axis=1) @ np.linalg.norm(forces, axis=1)
    _small("total torque", total, specimen.blur * float(arms))


def check_rigid_motion(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """A body moved as a whole, far and by a large angle, feels no force."""
    specimen = Specimen(relation_class, body(dimension, cloud), **arguments)
    X = specimen.part.positions
    shift = np.broadcast_to(np.array([12.3, -4.5, 6.7])[:dimension] * SPACING, X.shape)
    _small("force of a translation", specimen.force(shift), specimen.floor(shift))
    if dimension > 1:
        turned = X @ rotation(dimension).T + shift - X
        _small("force of a rotation", specimen.force(turned), specimen.floor(turned))


def check_objectivity(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """The force turns with the body: R (X + u) feels R f(u)."""
    specimen = Specimen(relation_class, body(dimension, cloud), **arguments)
    X, u, turn = specimen.part.positions, specimen.deformation(), rotation(dimension)
    forces = specimen.force(u)
    turned = (X + u) @ turn.T - X
    error = specimen.force(turned) - forces @ turn.T
    _small("force of the turned body, turned back", error, _tolerance(specimen, forces, turned))


def check_mirror(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """The mirrored body with the mirrored displacement feels the mirrored force: the law has no handedness."""
    part = body(dimension, cloud)
    image = np.ones(dimension)
    image[0] = -1.0
    specimen = Specimen(relation_class, part, **arguments)
    mirrored = Specimen(relation_class, again(part, points=part.positions * image), **arguments)
    u = specimen.deformation()
    forces = specimen.force(u)
    error = mirrored.force(u * image) - forces * image
    same = specimen.part.bonds.intact == mirrored.part.bonds.intact
    assert same.all(), f"{np.count_nonzero(~same)} bonds broke only on one side of the mirror"
    _small("force of the mirror image", error, _tolerance(specimen, forces, u))


def check_permutation(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """Numbering the nodes in another order changes nothing but the order."""
    part = body(dimension, cloud)
    order = np.random.default_rng(3).permutation(len(part))
    specimen = Specimen(relation_class, part, **arguments)
    shuffled = Specimen(relation_class, again(part, order=order), **arguments)
    u = specimen.deformation()
    forces = specimen.force(u)
    error = shuffled.force(u[order]) - forces[order]
    _small("force in another order of nodes", error, _tolerance(specimen, forces, u))


def check_threads(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """One thread and two give the same force to the bit."""
    if getattr(numba.config, "NUMBA_NUM_THREADS", 1) < 2:
        raise NotApplicable("this machine has one core")
    specimen = Specimen(relation_class, body(dimension, cloud, shape=MANY[dimension]), **arguments)
    assert len(specimen.part.bonds) >= SERIAL_BELOW, "too small a body: it would run on one thread anyway"
    u = specimen.deformation()
    threads = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        one = specimen.force(u)
        numba.set_num_threads(2)
        two = specimen.force(u)
    finally:
        numba.set_num_threads(threads)
    assert np.array_equal(one, two), f"the forces differ by up to {np.abs(one - two).max()}"


def check_energy(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """Forces are what the energy says: f V = −dU/du for every component of every node, by central differences.

    The step is 1e-4 of the displacement: the neglected third derivative is then 1e-8 of the force, round-off of the
    energy 1e-7; a kink of the law adds at most 1e-6, from the few bonds within a step of it. A potential of another law,
    or a factor 2, is off by far more than the 1e-5 that is asked for.
    """
    specimen = Specimen(relation_class, body(dimension, cloud), **arguments)
    specimen.energy(np.zeros_like(specimen.part.positions))
    u = specimen.deformation()
    specimen.settle(u)
    forces = specimen.force(u) * specimen.part[volume][:, None]
    step = 1e-4 * float(np.abs(u).max())
    slope = np.empty_like(u)
    for index in np.ndindex(*u.shape):
        there = u.copy()
        there[index] = u[index] + step
        up = specimen.energy(there)
        there[index] = u[index] - step
        slope[index] = (up - specimen.energy(there)) / (2 * step)
    _small("f V + dU/du", forces + slope, 1e-5 * float(np.abs(forces).max()))


def check_stable_step(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """`squared_frequency` is a bound: no eigenvalue of the stiffness at rest, by central differences, lies above it."""
    specimen = Specimen(relation_class, body(dimension, cloud), **arguments)
    bound = specimen.relation.squared_frequency()
    if bound is None:
        raise NotApplicable(f"{relation_class.__name__} knows no bound of its frequency")
    still = np.zeros_like(specimen.part.positions)
    step = SMALL * SPACING
    columns = []
    for index in np.ndindex(*still.shape):
        there = still.copy()
        there[index] = step
        columns.append((specimen.force(-there) - specimen.force(there)).ravel() / (2 * step))
    volumes, densities = (np.repeat(specimen.part[f], dimension) for f in (volume, density))
    # scaled by roots of masses: symmetric if the forces have a potential, and then Lanczos finds the highest at once
    scale = np.sqrt(volumes / densities)
    scaled = np.array(columns).T * scale[:, None] / (scale * densities)
    symmetric = np.abs(scaled - scaled.T).max() <= 1e-6 * np.abs(scaled).max()
    first = np.random.default_rng(2).uniform(-1.0, 1.0, len(scaled))
    if symmetric:
        highest = float(eigsh((scaled + scaled.T) / 2, k=1, which="LA", v0=first, return_eigenvectors=False)[0])
    else:
        highest = float(np.linalg.eigvals(scaled).real.max())
    assert highest > 0, "the body has no stiffness at rest"
    assert bound.max() >= highest * (1 - 1e-6), f"a node swings with ω² = {highest:.6g}, the bound is {bound.max():.6g}"


def check_breaking(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """Bonds break from both ends together, pull no more from then on, and do not heal.

    Relations that take `fracture` get a critical stretch of 5 %, the displacement makes stretches of up to 40 %.
    """
    if "fracture" in inspect.signature(relation_class).parameters:
        arguments = {"fracture": CriticalStretch(0.05), **arguments}
    part = body(dimension, cloud)
    specimen = Specimen(relation_class, part, **arguments)
    if intact not in specimen.relation.updates:
        raise NotApplicable(f"bonds of {relation_class.__name__} do not break")
    before = part.bonds.intact.copy()
    u = specimen.rough(0.2)
    specimen.settle(u)
    holds = part.bonds.intact.copy()
    assert not (holds & ~before).any(), "a broken bond has healed under load"
    assert (before & ~holds).any(), "no bond broke, although stretches reach 40 %"
    assert holds.any(), "every bond broke"
    lonely = holds[np.argsort(_keys(part, np.arange(len(part))))] != holds[np.argsort(_keys_back(part))]
    assert not lonely.any(), f"{np.count_nonzero(lonely)} directed bonds broke from one end only"
    broken = specimen.force(u)
    cut = again(part)
    whole = Specimen(relation_class, cut, **arguments)
    forces = whole.force(u)
    _small("force with bonds that broke before", forces - broken, _tolerance(specimen, broken, u))
    specimen.force(np.zeros_like(u))
    assert np.array_equal(part.bonds.intact, holds), "a broken bond has healed at rest"


def _keys_back(part: rbs.Part) -> NDArray[np.int64]:
    nodes, neighbors = ends(part)
    return neighbors * len(part) + nodes


def rotation(dimension: int) -> Array:
    """A rotation by about one radian, about an axis that is no axis of the grid."""
    if dimension == 1:
        return np.eye(1)
    if dimension == 2:
        c, s = math.cos(1.1), math.sin(1.1)
        return np.array([[c, -s], [s, c]])
    axis = np.array([1.0, -2.0, 2.0]) / 3.0
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + math.sin(1.1) * cross + (1 - math.cos(1.1)) * cross @ cross


def _tolerance(specimen: Specimen, forces: Array, u: Array) -> float:
    return specimen.floor(u) + specimen.blur * float(np.abs(forces).max())


def _small(what: str, values: Array, limit: float) -> None:
    """Asserts that something vanishes, and says by how much it does not."""
    worst = float(np.abs(values).max())
    assert worst <= limit, f"{what}: {worst:.3g}, where round-off explains {limit:.3g}"


# -- checks of contracts and schemes --------------------------------------------------------------------------------


def scene_of(
    relation_class: RelationClass, dimension: int, cloud: str = "jittered", **arguments: Any
) -> list[rbs.Relation]:
    """A small moving body with the relation at its place in the step; the relation is the last that is named.

    Beside it a brittle bond-based material and velocity Verlet, so that everything has something to work on.
    """
    part = body(dimension, cloud)
    rng = np.random.default_rng(5)
    part[velocity] = rng.uniform(-1.0, 1.0, part.positions.shape)
    relation = make(relation_class, part, **arguments)
    if relation is None:
        raise NotApplicable(f"the example of {relation_class.__name__} is not made for {dimension}-D parts")
    steel = BondBased(part, E=1e9, fracture=CriticalStretch(1e-3))
    verlet = VelocityVerlet(part)
    others = partners(relation)
    if relation.role == "constitutive":
        return verlet.step([steel, *others, relation])
    if relation.role == "boundary":
        return verlet.step([steel, *others], [relation])  # type: ignore[list-item]
    return [*verlet.step([steel, *others]), relation]


def check_scene(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """In a small moving scene the relation does what its contract says, and describes itself: `check_contract`."""
    scene = scene_of(relation_class, dimension, cloud, **arguments)
    relation = next(each for each in reversed(scene) if type(each) is relation_class)
    check_contract(relation, scene)


def check_going_on(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """A run with the relation, stopped and resumed in new objects, equals the uninterrupted one to the bit."""
    scene_of(relation_class, dimension, cloud, **arguments)  # not applicable? then say so before anything runs
    check_resume(lambda: scene_of(relation_class, dimension, cloud, **arguments))


def measured_order(scheme: type[Any], *, cycles: float = 0.8, steps: int = 80) -> float:
    """Order of convergence that a time integrator shows on an oscillator of two unequal nodes, known in closed form.

    The error is that of displacement and velocity together (in either alone the first-order term can vanish at some
    instants), at the end of so many cycles, with so many steps and with twice as many. The next term of the error is
    smaller than the first by about ω dt = 2π cycles/steps, 0.06 here and half of that in the finer run; so the measured
    order lies within 0.1 of the true one.
    """
    errors = []
    for count in (steps, 2 * steps):
        bar = rbs.Part("oscillator", rbs.Everywhere(), dimension=1)
        bar.place([[0.0], [0.1]], [1e-3, 3e-3], spacing=0.1, area=0.01).connect(0.11)
        bar[density] = 1000.0
        spring = BondBased(bar, c=1e12)
        omega = math.sqrt(1e12 / 0.1 * 4e-3 / 1000.0)
        bar[velocity] = np.array([[3.0], [-1.0]]) * 1e-3 * omega  # no momentum: the masses are 1 to 3
        bar[displacement] = np.array([[3.0], [-1.0]]) * 1e-3
        end = 2 * math.pi * cycles / omega
        rbs.Analysis(scheme(bar).step([spring])).run(steps=count, dt=end / count, progress=False)
        phase = 2 * math.pi * cycles
        wanted = np.array([math.cos(phase) + math.sin(phase), math.cos(phase) - math.sin(phase)]) * 3e-3
        found = np.array([bar[displacement][0, 0], bar[velocity][0, 0] / omega])
        errors.append(float(np.linalg.norm(found - wanted)))
    return math.log2(errors[0] / errors[1])


def check_order(scheme: type[Any]) -> None:
    """A time integrator converges with the order that its class attribute `order` claims."""
    found = measured_order(scheme)
    assert abs(found - scheme.order) < 0.1, f"{scheme.__name__} claims order {scheme.order} and shows {found:.3f}"


# -- the suite ------------------------------------------------------------------------------------------------------

FORCES: dict[Callable[..., None], tuple[int, ...]] = {
    check_rest: (1, 2, 3),
    check_momentum: (1, 2, 3),
    check_angular_momentum: (2, 3),
    check_rigid_motion: (1, 2, 3),
    check_objectivity: (2, 3),
    check_mirror: (1, 2, 3),
    check_permutation: (1, 2, 3),
    check_threads: (1, 2, 3),
    check_energy: (1, 2, 3),
    check_stable_step: (1, 2, 3),
    check_breaking: (1, 2, 3),
}
SCENES: tuple[Callable[..., None], ...] = (check_scene, check_going_on)


@dataclass(frozen=True)
class Case:
    """One check of one relation, to be run as a test."""

    check: Callable[..., None]
    relation_class: RelationClass
    dimension: int
    cloud: str
    plugin: Any = None

    @property
    def name(self) -> str:
        """Identifies the test."""
        check = self.check.__name__.removeprefix("check_")
        return f"{self.relation_class.__name__}-{check}-{self.dimension}D-{self.cloud}"

    def run(self) -> None:
        """Raises AssertionError, an error of the kernel, or NotApplicable."""
        with _registered(self.plugin):
            self.check(self.relation_class, self.dimension, self.cloud)


def cases(what: str | Sequence[RelationClass] | None = None) -> list[Case]:
    """Every check of every relation; what is as in `conformance`."""
    plugin = importlib.import_module(what) if isinstance(what, str) else None
    if plugin is not None:
        with isolated_registry(plugin) as found:
            classes = list(found.relations().values())
        assert classes, f"{what} offers no relation: does it have an @rbs.hookimpl function rbs_relations?"
    else:
        classes = list(rbs.registry().relations().values()) if what is None else list(what)  # type: ignore[arg-type]
    made = []
    for each in classes:
        forces = FORCES if each.role == "constitutive" else {}
        made += [Case(c, each, d, cloud, plugin) for c, dims in forces.items() for d in dims for cloud in CLOUDS]
        made += [Case(check, each, d, "jittered", plugin) for check in SCENES for d in (1, 2, 3)]
    return made


def conformance(what: str | Sequence[RelationClass] | None = None) -> Callable[..., None]:
    """A pytest function, parametrised over every check of every relation.

    Args:
        what: name of the module of a plugin, or relation classes; everything that is registered if not given.
    """
    import pytest

    every = cases(what)

    @pytest.mark.parametrize("case", every, ids=[case.name for case in every])
    def test(case: Case) -> None:
        try:
            case.run()
        except NotApplicable as reason:
            pytest.skip(str(reason))

    return test


@contextmanager
def _registered(plugin: Any) -> Iterator[None]:
    """For the length of a block a registry that knows the plugin, so that laws may ask for its fields by name."""
    if plugin is None or rbs.registry().manager.is_registered(plugin):
        yield
        return
    import rbs_plugins

    with isolated_registry(*dict.fromkeys([rbs_plugins, plugin])):
        yield


__all__ = [
    *(check.__name__ for check in (*FORCES, *SCENES)),
    "NotApplicable",
    "Specimen",
    "again",
    "body",
    "cases",
    "check_order",
    "conformance",
    "ends",
    "measured_order",
    "reference_position",
    "rotation",
    "scene_of",
]
