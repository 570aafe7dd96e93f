"""Implicit dynamics: order, energy, and the same motions as by explicit steps and static solvers."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import (
    BondBased,
    BoundaryDomain,
    CriticalStretch,
    Damage,
    Drift,
    Kick,
    KineticEnergy,
    Newmark,
    StrainEnergy,
    VelocityVerlet,
    ViscousDamping,
)
from rbs_plugins.fields import (
    damage,
    density,
    displacement,
    external_work,
    kinetic_energy,
    strain_energy,
    velocity,
    viscous_dissipation,
)
from rbs_plugins.statics.newton import Newton
from rbs_plugins.testing import check_order

E, RHO = 1e9, 1000.0


class Implicit:
    """Newmark as a scheme of time integration."""

    order = 2

    def __init__(self, part):
        self._part = part

    def step(self, forces):
        return [Newmark(self._part, forces, tolerance=1e-11)]


class Watch(rbs.Measure):
    """Adds up the energies, work taken away, at every step."""

    def __init__(self, part, damped=False):
        super().__init__(part)
        losses = (viscous_dissipation,) if damped else ()
        self.reads = (kinetic_energy, strain_energy, external_work, *losses)
        self.found, self._losses = [], losses

    def apply(self, clock):
        total = self[kinetic_energy] + self[strain_energy] - self[external_work]
        self.found.append(float(total + sum(self[loss] for loss in self._losses)))


def bar(n=12, **options):
    part = rbs.Part("bar", rbs.Box.between(0.0, 1.0)).discretize(1.0 / n, area=1e-4).connect(2.0 / n)
    part[density] = RHO
    return part, BondBased(part, E=E, **options)


def plate(n=4, **options):
    part = rbs.Part("plate", rbs.Box(size=(2.0, 1.0))).discretize(1.0 / n, thickness=0.1)
    part.connect(2.015 / n, storage="list")
    part[density] = RHO
    return part, BondBased(part, E=E, **options)


def limit(part, force):
    """Stable step of explicit schemes, s."""
    return rbs.Analysis(VelocityVerlet(part).step([force])).stable_dt()


def test_it_is_of_second_order():
    check_order(Implicit)


def test_the_energy_of_a_linear_body_stays_far_above_the_explicit_step(rng):
    part, force = bar()
    dt = 20.0 * limit(part, force)
    part[velocity] = rng.normal(size=(12, 1))
    first = 0.5 * RHO * 1e-4 / 12 * float(np.sum(part[velocity] ** 2))
    watch = Watch(part)
    relations = [Newmark(part, force, tolerance=1e-12), KineticEnergy(part), StrainEnergy(part, force), watch]
    rbs.Analysis(relations).run(steps=50, dt=dt, progress=False)
    np.testing.assert_allclose(watch.found, first, rtol=1e-10)


def test_work_and_damping_are_in_the_balance():
    part, force = bar()
    ends = [
        BoundaryDomain(part, [0, 1], velocity=0.0),
        BoundaryDomain(part, [11], displacement=lambda time: 1e-3 * np.sin(3e3 * time) ** 2),
        BoundaryDomain(part, [5], force=lambda time: 1e3 * np.cos(2e3 * time)),
        ViscousDamping(part, coefficient=2e6),
    ]
    watch = Watch(part, damped=True)
    relations = [Newmark(part, force, ends, tolerance=1e-12), KineticEnergy(part), StrainEnergy(part, force), watch]
    rbs.Analysis(relations).run(steps=200, dt=1e-5, progress=False)
    assert part[viscous_dissipation] > 0.01
    # the trapezoidal rule of the damping is of second order; everything else is exact
    np.testing.assert_allclose(watch.found, 0.0, atol=2e-3 * float(part[viscous_dissipation]))


@pytest.mark.parametrize("share", [0.5, 0.25])
def test_small_steps_are_those_of_velocity_verlet(share):
    """A plate that turns, so that nothing is linear; both are of second order, so they differ by (ω dt)²."""
    found = []
    for implicit in (True, False):
        part, force = plate()
        dt = share * limit(part, force)
        part[velocity] = 200.0 * part.positions[:, ::-1] * (-1.0, 1.0)
        pull = BoundaryDomain(part, lambda X: X[:, 0] > 0.8, force=(0.0, 1e6))
        verlet = VelocityVerlet(part)
        steps = [Newmark(part, force, pull)] if implicit else verlet.step([force], [pull])
        rbs.Analysis(steps).run(steps=int(20 / share), dt=dt, progress=False)
        found.append(part[displacement].copy())
    np.testing.assert_allclose(*found, atol=0.004 * share**2 * np.abs(found[1]).max())


def test_a_static_solver_hands_over_and_nothing_moves():
    moved = {}
    for then in ("Newmark", "velocity Verlet"):
        part, force = plate()
        held = BoundaryDomain(part, lambda X: X[:, 0] < -0.6, velocity=(0.0, 0.0))
        pull = BoundaryDomain(part, lambda X: X[:, 0] > 0.8, force=(0.0, 1e5))
        dt = 0.5 * limit(part, force)
        first = rbs.once
        newton = Newton(part, force, [held, pull], when=first, tolerance=1e-12)
        if then == "Newmark":
            after = [Newmark(part, force, [held, pull], when=~first, tolerance=1e-11)]
            dt *= 40.0
        else:
            kick, drift = Kick(part, share=0.5, when=~first), Drift(part, when=~first)
            still = BoundaryDomain(part, held.nodes, velocity=(0.0, 0.0), when=~first)
            load = BoundaryDomain(part, pull.nodes, force=(0.0, 1e5))
            after = [kick, still, drift, load, force, kick]
        analysis = rbs.Analysis([newton, *after])
        analysis.run(steps=1, dt=dt, progress=False)
        u = part[displacement].copy()
        assert np.abs(u).max() > 1e-3
        analysis.run(steps=60, dt=dt, progress=False)
        moved[then] = np.abs(part[displacement] - u).max() / np.abs(u).max()
    assert moved == {name: pytest.approx(0.0, abs=1e-8) for name in moved}


def test_bonds_fail_on_the_way():
    part, force = bar(fracture=CriticalStretch(1e-3))
    ends = [BoundaryDomain(part, [0, 1], velocity=0.0), BoundaryDomain(part, [10, 11], velocity=5.0)]
    newmark = Newmark(part, force, ends)
    rbs.Analysis([newmark, Damage(part)]).run(steps=100, dt=1e-5, progress=False)
    assert part[damage].max() >= 0.5
    assert sum(each.broken for each in newmark.history) == np.count_nonzero(~part.bonds.intact) > 0
    assert part[displacement][11, 0] == pytest.approx(5e-3, rel=1e-12)
    assert part[velocity][11, 0] == 5.0


def test_wrong_arguments():
    part, force = bar()
    for beta, gamma in ((0.2, 0.5), (0.25, 0.4), (0.25, 0.6)):
        with pytest.raises(BadInput, match=rf"beta={beta} and gamma={gamma} are stable for every dt only if"):
            Newmark(part, force, beta=beta, gamma=gamma)
    part[density] = 0.0
    with pytest.raises(BadInput, match=r"the density of node 0 of part 'bar' at .* is not positive"):
        rbs.Analysis([Newmark(part, force)]).run(steps=1, dt=1e-5, progress=False)
