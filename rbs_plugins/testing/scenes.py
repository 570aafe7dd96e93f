"""Checks of relations of any role in a small moving scene, and of the orders that time integrators claim."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from typing import Any

import numpy as np

import rbs_core as rbs
from rbs_core.stability import largest_stable_step
from rbs_core.testing import check_contract, check_resume, furnish, make, partners
from rbs_plugins.constitutive.bond_based import BondBased
from rbs_plugins.constitutive.fracture import CriticalStretch
from rbs_plugins.fields import density, displacement, reference_position, velocity
from rbs_plugins.integrators.explicit import VelocityVerlet
from rbs_plugins.testing.specimen import EPSILON, SPACING, ULPS, NotApplicable, RelationClass, body, suits

CRITICAL = 1e-3  # stretch at which bonds of the scenes break


def scene_of(
    relation_class: RelationClass, dimension: int, cloud: str = "jittered", **arguments: Any
) -> list[rbs.Relation]:
    """A small moving body, with the relation at its place in a step of velocity Verlet.

    Relations that make no forces get a brittle bond-based material, so that they have something to work on; solvers of
    equilibria have forces of their own.
    """
    part = body(dimension, cloud)
    rng = np.random.default_rng(5)
    part[velocity] = rng.uniform(-1.0, 1.0, part.positions.shape)
    relation = make(relation_class, part, **arguments)
    if relation is None:
        raise NotApplicable(f"the example of {relation_class.__name__} is not made for {dimension}-D parts")
    suits(relation)
    steel = BondBased(part, E=1e9, fracture=CriticalStretch(CRITICAL))
    verlet = VelocityVerlet(part)
    others = partners(relation)
    if relation.role == "statics":
        return [relation]
    if relation.role == "constitutive":
        return verlet.step([*others, relation])
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


def check_storages(relation_class: RelationClass, dimension: int, cloud: str, **arguments: Any) -> None:
    """After 1,000 steps in which bonds break, a list of bonds and a lattice agree in every field and broken bond.

    A list computes with positions, which round by a few ε |X|; so a stretch s has an error of a few ε |X| / |ξ|.
    What counts is s near the critical stretch, where bonds carry the most. The errors of n steps add up as those of a
    random walk, to √n of one.
    """
    if relation_class.role != "constitutive":
        raise NotApplicable("only forces look at bonds as they are stored")
    if "fracture" in inspect.signature(relation_class).parameters:
        arguments = {"fracture": CriticalStretch(CRITICAL), **arguments}
    steps, parts = 1000, []
    for each in ("grid", "lattice"):
        scene = scene_of(relation_class, dimension, each, **arguments)
        furnish(scene)
        analysis = rbs.Analysis(scene)
        analysis.prepare()
        if largest_stable_step(scene) is None:
            raise NotApplicable(f"{relation_class.__name__} knows no stable time step")
        analysis.run(steps=steps, progress=False)
        parts.append(scene[0].part)
    one, two = parts
    assert np.array_equal(one.bonds.intact, two.bonds.intact), "other bonds are broken"
    limit = ULPS * EPSILON * float(np.abs(one.positions).max()) / (CRITICAL * SPACING) * math.sqrt(steps)
    for field in one.fields:
        if field.at == "node" and field != reference_position:
            worst = np.abs(one[field] - two[field]).max(initial=0.0)
            largest = np.abs(one[field]).max(initial=0.0)
            assert worst <= limit * largest, f"'{field.name}' differs by {worst / largest:.3g}, allowed is {limit:.3g}"


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


SCENES: dict[Callable[..., None], tuple[str, ...]] = {
    check_scene: ("jittered", "lattice"),
    check_going_on: ("jittered", "lattice"),
    check_storages: ("lattice",),
}
