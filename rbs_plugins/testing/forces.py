"""Checks of forces: each takes a relation class, a dimension and a cloud of nodes, and raises AssertionError.

They can be called on their own: `check_momentum(Granite, 2, "jittered", E=50e9)`. Instances come from the class
attribute `example`; keywords replace or complete it. What "zero" and "equal" mean is reasoned in `specimen`.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from scipy.sparse.linalg import eigsh

from rbs_plugins.constitutive.fracture import CriticalStretch
from rbs_plugins.fields import density, intact, volume
from rbs_plugins.loops import SERIAL_BELOW
from rbs_plugins.testing.specimen import (
    EPSILON,
    MANY,
    SMALL,
    SPACING,
    ULPS,
    Array,
    NotApplicable,
    RelationClass,
    Specimen,
    again,
    body,
    ends,
)


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
    energy 1e-7; a kink of the law adds at most 1e-6, from the few bonds within a step of it. The potential of another
    law is off by far more than the 1e-5 that is asked for.
    """
    specimen = Specimen(relation_class, body(dimension, cloud), **arguments)
    if specimen.part.precision == "single":
        raise NotApplicable("differences of energies in single precision are too rough to be forces")
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
    i, j = ends(part)
    lonely = holds[np.lexsort((j, i))] != holds[np.lexsort((i, j))]  # every bond beside its other half
    assert not lonely.any(), f"{np.count_nonzero(lonely)} directed bonds broke from one end only"
    broken = specimen.force(u)
    cut = again(part)
    whole = Specimen(relation_class, cut, **arguments)
    forces = whole.force(u)
    _small("force with bonds that broke before", forces - broken, _tolerance(specimen, broken, u))
    specimen.force(np.zeros_like(u))
    assert np.array_equal(part.bonds.intact, holds), "a broken bond has healed at rest"


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
