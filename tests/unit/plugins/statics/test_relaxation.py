"""Equilibria by dynamic relaxation, against solutions by other ways."""

from __future__ import annotations

import numba
import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, NotConverged
from rbs_plugins import (
    AdaptiveDynamicRelaxation,
    BondBased,
    BoundaryDomain,
    CriticalStretch,
    PairwiseForce,
    ReactionForce,
    StrainEnergy,
    VelocityVerlet,
    ViscousDamping,
)
from rbs_plugins.fields import (
    density,
    displacement,
    external_work,
    force_density,
    reaction_force,
    strain_energy,
    velocity,
    volume,
)
from rbs_plugins.statics.newton import Newton

E = 1e9


def plate(storage="list", n=4, **options):
    """A plate of 2n x n nodes between two clamps, one of which is moved by (0.2, 0.5) m in 1 s: far from linear."""
    part = rbs.Part("plate", rbs.Box(size=(4.0, 2.0))).discretize(2.0 / n, thickness=1.0)
    low, high = part.extend("low", "-x", 6.03 / n), part.extend("high", "+x", 6.03 / n)
    part.connect(6.03 / n, storage=storage)
    force = BondBased(part, E=E, **options)
    ends = [
        BoundaryDomain(part, low, displacement=(0.0, 0.0)),
        BoundaryDomain(part, high, displacement=(lambda time: 0.2 * time, lambda time: 0.5 * time)),
    ]
    return part, force, ends


def bar(n=12, law=None, **parameters):
    """A bar of n nodes, clamped at its left."""
    part = rbs.Part("bar", rbs.Box.between(0.0, 0.1 * n)).discretize(0.1, area=1e-4)
    clamp = part.extend("clamp", "-x", 0.2)
    part.connect(0.2)
    force = BondBased(part, E=E) if law is None else PairwiseForce(part, law, **parameters)
    return part, force, BoundaryDomain(part, clamp, displacement=0.0)


def relaxed(part, *given, steps=1, more=(), **options):
    solver = AdaptiveDynamicRelaxation(part, *given, **options)
    rbs.Analysis([solver, *more]).run(steps=steps, progress=False)
    return solver


@pytest.mark.parametrize("damping", ["viscous", "kinetic"])
def test_the_equilibrium_is_that_of_newton(damping):
    part, force, ends = plate()
    solver = relaxed(part, force, ends, steps=2, damping=damping, tolerance=1e-10)
    assert [each.converged for each in solver.history] == [True, True]
    assert solver.history[0].residuals[-1] <= 1e-10
    assert solver.items() > 0
    found = part[displacement].copy()
    assert found[ends[1].nodes].tolist() == [[0.2, 0.5]] * len(ends[1].nodes)
    part, force, ends = plate()
    rbs.Analysis([Newton(part, force, ends, tolerance=1e-11)]).run(steps=2, progress=False)
    np.testing.assert_allclose(found, part[displacement], atol=1e-9)


def test_the_bonds_that_fail_are_those_of_newton():
    """Bonds fail in equilibria only, however far the motion overshoots on its way there."""
    found = []
    for solver in (AdaptiveDynamicRelaxation, Newton):
        part, force, ends = plate(fracture=CriticalStretch(0.06, within="body"))
        one = solver(part, force, ends, tolerance=1e-9)
        rbs.Analysis([one]).run(steps=3, progress=False)
        assert sum(each.broken for each in one.history) == np.count_nonzero(~part.bonds.intact) > 0
        found.append((part[displacement].copy(), part.bonds.intact.copy()))
    (u, holds), (other, hold) = found
    assert np.array_equal(holds, hold)
    np.testing.assert_allclose(u, other, atol=1e-8)


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_bonds_that_fail_are_counted_in_both_directions(storage):
    part = rbs.Part("bar", rbs.Box.between(0.0, 1.2)).discretize(0.1, area=1e-4).connect(0.2, storage=storage)
    solver = AdaptiveDynamicRelaxation(part, BondBased(part, E, CriticalStretch(1e-3)))
    rbs.Analysis([solver]).prepare()
    before = solver._problem.holding()
    assert before == len(part.bonds)
    part.bonds.cut(rbs.Plane([0.6], [1.0]))
    assert before - solver._problem.holding() == 2 * 3


@pytest.mark.parametrize("pieces", [(4,), (2, 4)])
def test_what_breaks_off_stays_also_in_a_run_that_goes_on(pieces):
    part = rbs.Part("bar", rbs.Box.between(0.0, 1.2)).discretize(0.1, area=1e-4)
    clamp = BoundaryDomain(part, part.extend("clamp", "-x", 0.2), displacement=0.0)
    part.connect(0.2)
    weak = CriticalStretch(1e-3, within=rbs.Box.between(0.25, 0.65))
    load = BoundaryDomain(part, part.positions[:, 0] > 0.9, body_force=lambda time: 6e6 * time)
    solver = AdaptiveDynamicRelaxation(part, BondBased(part, E, weak), [clamp, load])
    analysis = rbs.Analysis([solver], dt=0.25)
    for steps in pieces:
        analysis.run(steps=steps, progress=False)
    assert [each.broken for each in solver.history] == [0, 0, 0, 14, 0]


def test_a_lattice_and_dynamics_that_have_died_down_agree_with_it():
    part, force, ends = plate("lattice", 6)
    relaxed(part, force, ends, tolerance=1e-9)
    assert part.bonds.storage == "lattice"
    found = part[displacement].copy()
    listed, force, ends = plate("list", 6)
    relaxed(listed, force, ends, tolerance=1e-9)
    np.testing.assert_allclose(found, listed[displacement], atol=1e-8)
    part, force, (low, _) = plate("lattice", 6)
    part[density] = 1000.0
    # the slowest mode swings along the plate, at about π c / 2L
    damping = ViscousDamping(part, ratio=1.0, frequency=np.pi * np.sqrt(E / 1000.0) / 8.0)
    move = BoundaryDomain(part, "high", displacement=tuple(lambda t, a=a: a * min(t / 0.02, 1.0) for a in (0.2, 0.5)))
    rbs.Analysis(VelocityVerlet(part).step([force], [low, move, damping])).run(until=0.12, progress=False)
    assert np.abs(part[velocity]).max() < 1e-4
    np.testing.assert_allclose(found, part[displacement], atol=2e-6)


def test_loads_energies_and_reactions():
    """A bar that is linear: the work of a load that grows is half of the load times the displacement of its end."""
    part, force, clamp = bar()
    pull = BoundaryDomain(part, lambda X: X[:, 0] > 1.1, force=lambda time: 1000.0 * time)
    more = [StrainEnergy(part, force), ReactionForce(part, clamp), Reader(part)]
    solver = relaxed(part, force, [clamp, pull], steps=3, more=more, tolerance=1e-11)
    assert part[reaction_force] == pytest.approx(-1000.0, rel=1e-9)
    everything = float(part[volume] @ energy(force, part))
    assert part[external_work] == pytest.approx(0.5 * 1000.0 * part[displacement][-1, 0], rel=1e-9)
    assert everything == pytest.approx(part[external_work], rel=1e-9)
    assert part[strain_energy] < everything  # without that of the layer
    # displacements that go on as before are those of the next step
    assert solver.history[0].count > 50
    assert solver.history[2].count < 10


class Reader(rbs.Measure):
    """Wants the work."""

    reads = (external_work,)


def energy(force, part):
    out = np.zeros(len(part))
    force.energy(out)
    return out


def test_a_body_that_nothing_holds_may_be_in_balance():
    part = rbs.Part("bar", rbs.Box(size=1.0)).discretize(0.1).connect(0.2)
    force = BondBased(part, E=E)
    ends = [BoundaryDomain(part, [node], force=pull) for node, pull in ((0, -1e5), (9, 1e5))]
    relaxed(part, force, ends)
    u = part[displacement][:, 0]
    np.testing.assert_allclose(u, -u[::-1], atol=1e-9 * u.max())
    assert u[-1] > 0.0


def test_parts_that_are_connected():
    left, force, clamp = bar(6)
    right = rbs.Part("right", rbs.Box.between(0.6, 1.2)).discretize(0.1, area=1e-4).connect(0.2)
    joint = BondBased(rbs.Connection(left, right, 0.2), c=force.c)
    pull = BoundaryDomain(right, [5], displacement=1e-3)
    relaxed([left, right], [force, BondBased(right, E=E), joint], [clamp, pull], tolerance=1e-10)
    whole, force, clamp = bar(12)
    relaxed(whole, force, [clamp, BoundaryDomain(whole, [13], displacement=1e-3)], tolerance=1e-10)
    both = np.concatenate([left[displacement], right[displacement]])
    np.testing.assert_allclose(both, whole[displacement], atol=1e-11)


def stiffening(stretch, c):
    return c * stretch * (1.0 + 1e6 * stretch * stretch)


def test_a_material_that_stiffens_gets_a_larger_fictitious_density():
    part, force, clamp = bar(law=stiffening, c=1e13)
    solver = relaxed(part, force, [clamp, BoundaryDomain(part, [13], displacement=0.05)])
    assert solver._factor > 1.0
    f, V = part[force_density][:, 0], part[volume]
    assert np.abs((f * V)[2:13]).max() < 1e-6 * np.abs(f * V).max()


def test_steps_with_some_iterations():
    """Loads go on while the part follows; the slower they go, the nearer it is to equilibrium."""
    away = []
    for steps in (20, 80):
        part, force, clamp = bar()
        pull = BoundaryDomain(part, [13], displacement=lambda time: 1e-3 * time)
        solver = relaxed(part, force, [clamp, pull], steps=steps, per_step=5)
        assert [each.count for each in solver.history] == [5] * steps
        away.append(solver.history[-1].residuals[-1])
    assert away[1] < 0.5 * away[0] < 0.5
    assert part[displacement][13, 0] == 1e-3


def test_one_thread_or_two_give_the_same_bits():
    found = []
    for threads in (1, 2):
        numba.set_num_threads(min(threads, numba.config.NUMBA_NUM_THREADS))
        part = rbs.Part("plate", rbs.Box(size=(1.3, 1.0))).discretize(0.01).connect(0.03015)
        pull = BoundaryDomain(part, lambda X: X[:, 0] > 0.64, body_force=(lambda time, X: 1e6 * X[:, 1], None))
        held = BoundaryDomain(part, lambda X: X[:, 0] < -0.62, displacement=(0.0, 0.0))
        relaxed(part, BondBased(part, E=E), [held, pull], per_step=20)
        found.append(part[displacement].copy())
    numba.set_num_threads(numba.config.NUMBA_NUM_THREADS)
    assert found[0].any()
    assert np.array_equal(*found)


def test_what_is_not_found_is_said():
    part, force, clamp = bar()
    pull = BoundaryDomain(part, [13], force=1000.0)
    solver = AdaptiveDynamicRelaxation(part, force, [clamp, pull], iterations=9, cuts=1)
    message = (
        r"step 1: AdaptiveDynamicRelaxation 'bar' finds no equilibrium between 0 and 0.5 s: 9 iterations did not "
        r"reach the tolerance 1e-08; the largest unbalanced force, .* N, is on component 0 of node"
    )
    with pytest.raises(NotConverged, match=message) as caught:
        rbs.Analysis([solver]).run(steps=1, progress=False)
    assert [each.count for each in caught.value.history] == [9, 9]
    assert "residuals behind some of 9 iterations" in str(caught.value)
    assert not part[displacement].any()


class Silent(rbs.Constitutive):
    """Says nothing about its stiffness."""

    reads = (displacement,)
    adds = (force_density,)


def test_wrong_arguments():
    part, force, clamp = bar()
    for options, text in [
        ({"damping": "wet"}, "damping='wet' must be one of viscous, kinetic"),
        ({"per_step": 0}, "per_step=0 must be at least 1"),
        ({"tolerance": 0.0}, "tolerance=0.0 must lie between 0 and 1"),
    ]:
        with pytest.raises(BadInput, match=text):
            AdaptiveDynamicRelaxation(part, force, [clamp], **options)
    with pytest.raises(BadInput, match="no force on part 'bar' knows a bound of its stiffness"):
        relaxed(part, Silent(part), [clamp])
