"""Kicks, drifts, and the lists that schemes make of them. Orders are shown in tests/conformance/test_registry.py."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import BondBased, BoundaryDomain, Drift, Kick, SymplecticEuler, VelocityVerlet
from rbs_plugins.fields import density, displacement, force_density, velocity


@pytest.fixture
def part(rng):
    made = rbs.Part("cloud", rbs.Everywhere(), dimension=2)
    made.place(rng.uniform(size=(50, 2)), rng.uniform(1.0, 2.0, 50), spacing=0.1)
    made[density] = 1500.0
    made[velocity] = rng.normal(size=(50, 2))
    made[displacement] = rng.normal(size=(50, 2))
    made[force_density] = rng.normal(size=(50, 2)) * 1e3
    return made


@pytest.mark.parametrize("share", [0.5, 1.0])
@pytest.mark.parametrize("uniform", [True, False])
def test_kick(part, rng, share, uniform):
    if not uniform:
        part[density] = rng.uniform(1000.0, 2000.0, 50)
    before = part[velocity].copy()
    rbs.Analysis([Kick(part, share)]).run(steps=1, dt=0.2, progress=False)
    wanted = before + share * 0.2 * part[force_density] / part[density][:, None]
    np.testing.assert_allclose(part[velocity], wanted, rtol=1e-14, atol=1e-14)


def test_density_that_another_relation_changes_is_not_taken_for_constant(part):
    class Melting(rbs.Relation):
        """Loses half of its mass in every step."""

        updates = (density,)

        def apply(self, clock):
            self[density][...] *= 0.5

    before = part[velocity].copy()
    rbs.Analysis([Melting(part), Kick(part)]).run(steps=2, dt=1.0, progress=False)
    wanted = before + part[force_density] * (1 / 750.0 + 1 / 375.0)
    np.testing.assert_allclose(part[velocity], wanted, rtol=1e-14, atol=1e-14)


def test_drift(part):
    before = part[displacement].copy()
    rbs.Analysis([Drift(part)]).run(steps=3, dt=0.2, progress=False)
    np.testing.assert_allclose(part[displacement], before + 0.6 * part[velocity], rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize("bad", [0.0, -1.0])
def test_density_must_be_positive(part, bad):
    part[density] = np.where(np.arange(50) == 7, bad, 1.0)
    with pytest.raises(BadInput, match=f"density of node 7 at .* is {bad}, not positive"):
        rbs.Analysis([Kick(part)]).prepare()


def test_lists_of_the_schemes(part):
    part.connect(0.5)
    force = BondBased(part, E=1e9)
    motion = BoundaryDomain(part, [0], velocity=(0.0, 0.0))
    load = BoundaryDomain(part, [1], force=(0.0, 1.0))
    verlet, euler = VelocityVerlet(part), SymplecticEuler(part)
    assert verlet.step([force], [load, motion]) == [
        verlet.kick, motion, verlet.drift, load, force, verlet.kick, motion,
    ]  # fmt: skip
    assert euler.step([force], [motion, load]) == [load, force, euler.kick, motion, euler.drift]
    assert (verlet.kick.share, euler.kick.share) == (0.5, 1.0)
    assert (verlet.order, euler.order) == (2, 1)


def test_free_flight_is_exact(part):
    """Without forces both schemes go straight on; with a constant force velocity Verlet follows the parabola."""
    part[force_density] = 0.0
    start = part[displacement].copy()
    for scheme in (VelocityVerlet, SymplecticEuler):
        part[displacement] = start
        rbs.Analysis([scheme(part).kick, scheme(part).drift]).run(steps=4, dt=0.25, progress=False)
        np.testing.assert_allclose(part[displacement], start + part[velocity], rtol=1e-14, atol=1e-14)
    gravity = BoundaryDomain(part, rbs.Everywhere(), body_force=(0.0, -1500.0 * 9.81))
    part[displacement] = 0.0
    part[velocity] = 0.0
    rbs.Analysis(VelocityVerlet(part).step([], [gravity])).run(steps=10, dt=0.1, progress=False)
    np.testing.assert_allclose(part[displacement], [[0.0, -0.5 * 9.81]] * 50, rtol=1e-13)
    np.testing.assert_allclose(part[velocity], [[0.0, -9.81]] * 50, rtol=1e-13)
