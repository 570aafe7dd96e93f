"""Newton: equilibria are equilibria, however they are reached, and what is none is reported."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import Analysis, NotConverged
from rbs_plugins import (
    BondBased,
    BoundaryDomain,
    CriticalStretch,
    PairwiseForce,
    ReactionForce,
    StrainEnergy,
    VelocityVerlet,
)
from rbs_plugins.fields import (
    density,
    displacement,
    external_work,
    force_density,
    reaction_force,
    strain_energy_density,
    volume,
)
from rbs_plugins.statics.newton import Newton
from rbs_plugins.statics.solvers import OPTIONAL

E, LENGTH, SPACING = 1e9, 2.0, 0.2
TIGHT = 1e-12


def bar(name="bar", **more):
    """A strip of 10 x 4 nodes."""
    part = rbs.Part(name, rbs.Box([LENGTH, 0.8], center=[LENGTH / 2, 0.4])).discretize(SPACING)
    return part.connect(horizon=2.015 * SPACING, **more)


def ends(part, **load):
    """Clamped on the left, and something on the right."""
    x = part.positions[:, 0]
    return [
        BoundaryDomain(part, x < SPACING, displacement=[0.0, 0.0]),
        BoundaryDomain(part, x > LENGTH - SPACING, **load),
    ]


def solved(force, boundaries, *more, steps=1, **options):
    part = force.part
    newton = Newton(part, force, boundaries, **{"tolerance": TIGHT, **options})
    Analysis([newton, *more], steps=steps).run(progress=False)
    return part[displacement].copy(), newton


def bent(part, **options):
    """Bent by half of its length."""
    boundaries = ends(part, force=[0.0, lambda time: -1.5e7 * time])
    return solved(BondBased(part, E), boundaries, **options)


def test_reactions_balance_loads():
    part = bar()
    boundaries = ends(part, force=[3e6, lambda time: -1e6 * time])
    reaction = ReactionForce(part, boundaries[0])
    solved(BondBased(part, E), boundaries, reaction)
    assert part[reaction_force] == pytest.approx([-3e6, 1e6], rel=1e-9)
    free = np.flatnonzero(part.positions[:, 0] > SPACING)
    assert np.abs((part[force_density] * part[volume][:, None])[free]).max() < 1e-9 * 1e6


def test_an_elastic_equilibrium_does_not_depend_on_the_steps():
    (one, newton), (many, _) = bent(bar(), steps=1), bent(bar(), steps=6)
    assert np.abs(one).max() > 0.4 * LENGTH, "large displacements"
    assert one == pytest.approx(many, rel=1e-9, abs=1e-10)
    assert newton.history[-1].converged


def test_the_last_iterations_converge_quadratically():
    _, newton = bent(bar(), steps=4, tolerance=1e-11)
    r = [each for each in newton.history[-1].residuals if each > 1e-13]
    assert r[-1] < 10 * r[-2] ** 1.9, r


def test_a_linear_problem_takes_one_solution():
    part = bar()
    _, newton = solved(BondBased(part, E, linear=True), ends(part, force=[lambda time: 1e6 * time, 0.0]), steps=3,
                       tolerance=1e-9)  # fmt: skip
    assert [len(each.residuals) for each in newton.history] == [1, 1, 1]
    assert newton.solved == {"SuperLU": 3}


@pytest.mark.parametrize("solver", ["cg", "gmres", "multigrid", "pardiso"])
def test_solvers_agree(solver):
    if solver in OPTIONAL:
        pytest.importorskip(OPTIONAL[solver])
    direct, _ = _pulled("direct")
    other, newton = _pulled(solver)
    assert set(newton.solved) == {solver}
    assert other == pytest.approx(direct, rel=1e-8, abs=1e-10)


def _pulled(solver):
    part = bar()
    return solved(BondBased(part, E), ends(part, displacement=[0.1, 0.05]), solver=solver, tolerance=1e-10)


def test_a_velocity_prescribes_what_it_adds_up_to():
    part, other = bar(), bar()
    by_velocity, _ = solved(BondBased(part, E), ends(part, velocity=[lambda time: 0.2 * time, 0.0]), steps=4)
    straight, _ = solved(BondBased(other, E), ends(other, displacement=[lambda time: 0.1 * time**2, 0.0]), steps=4)
    assert by_velocity == pytest.approx(straight, rel=1e-9, abs=1e-12)


def test_the_work_of_supports_and_loads_is_the_strain_energy():
    part = bar()
    force = BondBased(part, E, linear=True)
    boundaries = ends(part, displacement=[lambda time: 0.01 * time, lambda time: 0.02 * time])
    middle = np.abs(part.positions[:, 0] - 1.0) < 0.2
    boundaries.append(BoundaryDomain(part, middle, force=[0.0, lambda time: 1e5 * time]))
    energy = StrainEnergy(part, [force])
    work = rbs.Field("seen_work", "part", "scalar", "J", "A", "The work, as somebody reads it.")

    class Seen(rbs.Measure):
        reads, writes = (external_work,), (work,)

        def apply(self, clock):
            self[work][...] = self[external_work]

    solved(force, boundaries, energy, Seen(part), steps=3)
    held = float(np.sum(part[strain_energy_density] * part[volume]))
    assert float(part[work]) == pytest.approx(held, rel=1e-9)


class Work(rbs.Measure):
    """Lets the work be followed."""

    reads, stays = (external_work,), True


def test_work_is_that_of_the_path_also_where_bonds_fail_and_a_run_is_resumed(tmp_path):
    """Supports that have moved before bonds fail have worked against all of them; work is half of force times way."""

    def scene(pieces, resume=None):
        part = bar()
        part.bonds.cut(rbs.Segment([1.0, -0.1], [1.0, 0.3]))
        force = BondBased(part, E, CriticalStretch(0.008), linear=True)
        newton = Newton(part, force, ends(part, displacement=[lambda time: 0.012 * time, 0.0]))
        saved = rbs.Checkpoint(tmp_path / "saved.npz", when=rbs.every(1))
        analysis = Analysis([newton, Work(part), saved], steps=2)
        for steps in pieces:
            analysis.run(steps=steps, resume=resume, progress=False)
        return float(part[external_work]), newton

    once, newton = scene([2])
    assert sum(each.broken for each in newton.history if each.time == 1.0) > 0
    assert scene([1, 2])[0] == once
    half, newton = scene([1])
    assert not any(each.broken for each in newton.history)
    assert once == pytest.approx(4.0 * half, rel=1e-7)
    assert scene([2], resume=tmp_path / "saved.npz")[0] == once


def test_a_factor_may_be_used_again():
    (full, newton), (reused, modified) = bent(bar(), steps=6), bent(bar(), steps=6, reuse=0.3)
    assert modified._solver.factorised < 0.8 * newton._solver.factorised
    assert reused == pytest.approx(full, rel=1e-8, abs=1e-9)


def saturating(stretch, c):
    """Gets soft in both directions."""
    return c * stretch / (1.0 + 100.0 * abs(stretch))


def test_a_line_search_finds_what_full_steps_miss():
    def up_and_down(line_search):
        part = bar()
        force = PairwiseForce(part, saturating, c=BondBased(part, E).c)
        boundaries = ends(part, force=[lambda time: 4.5e6 * (1.0 - abs(2.0 * time - 1.0)), 0.0])
        return solved(force, boundaries, steps=2, tolerance=1e-10, cuts=0, line_search=line_search)

    with pytest.raises(NotConverged, match=r"between 0\.5 and 1 s"):
        up_and_down(line_search=False)
    rest, _ = up_and_down(line_search=True)
    assert np.abs(rest).max() < 1e-12


# -- what fails ---------------------------------------------------------------------------------------------------


def test_a_step_that_is_too_large_is_cut():
    part = bar()
    u, newton = solved(BondBased(part, E), ends(part, force=[0.0, lambda time: -2e7 * time]), iterations=4)
    assert any(not each.converged for each in newton.history)
    assert newton.history[-1].converged
    assert np.isfinite(u).all()


def softening(stretch, c):
    """Carries at most c / 400."""
    return c * stretch * (1.0 - 100.0 * stretch)


def test_without_equilibrium_there_is_a_report_and_no_frame():
    part = bar()
    frames = []

    class Frames(rbs.Exporter):
        reads = (displacement,)

        def apply(self, clock):
            frames.append(clock.step)

    force = PairwiseForce(part, softening, c=BondBased(part, E).c)
    boundaries = ends(part, force=[lambda time: 1e7 * time, 0.0])
    newton = Newton(part, force, boundaries, cuts=3)
    with pytest.raises(
        NotConverged, match=r"step \d+: Newton 'bar' finds no equilibrium .* N, is on component 0 of node"
    ) as caught:
        Analysis([newton, Frames(part)], steps=10).run(progress=False)
    good = [each for each in newton.history if each.converged]
    assert frames == list(range(1, len(frames) + 1))
    assert len(frames) < 10
    assert caught.value.history == newton.history
    assert good[-1].time >= 0.1 * len(frames)
    assert np.abs(part[displacement]).max() < 0.1 * LENGTH, "displacements are those of the last equilibrium"


def test_bonds_fail_until_none_does_at_the_same_load():
    part = bar()
    part.bonds.cut(rbs.Segment([1.0, -0.1], [1.0, 0.3]))
    force = BondBased(part, E, CriticalStretch(0.01))
    boundaries = ends(part, displacement=[lambda time: 0.017 * time, 0.0])
    u, newton = solved(force, boundaries, steps=2, tolerance=1e-10)
    times = [each.time for each in newton.history]
    assert max(np.unique(times, return_counts=True)[1]) > 2, "several equilibria at one load"
    last = {each.time: each.broken for each in newton.history}
    assert set(last.values()) == {0}
    offsets, neighbors = part.bonds.as_rows()
    i = np.repeat(np.arange(len(part)), np.diff(offsets))
    y = part.positions + u
    stretch = np.linalg.norm(y[neighbors] - y[i], axis=1) * part.bonds.inverse_lengths - 1
    assert stretch[part.bonds.intact].max() <= 0.01


def test_bonds_of_an_attempt_that_is_given_up_are_as_before():
    part = bar()
    part.bonds.cut(rbs.Segment([1.0, -0.1], [1.0, 0.3]))
    force = BondBased(part, E, CriticalStretch(0.01))
    newton = Newton(part, force, ends(part, force=[lambda time: 4e6 * time, 0.0]), rebalance=1, cuts=4)
    before = part.bonds.intact.copy()
    with pytest.raises(NotConverged, match=r"bonds went on failing, 1 times.*Displacements and bonds are those of"):
        Analysis([newton], steps=1).run(progress=False)
    assert newton.history[0].broken > 0
    assert newton.history[2].broken == 0, "at half of the load all bonds are there again, and hold"
    assert np.array_equal(part.bonds.intact, before)


def test_a_piece_that_has_broken_off_stays_where_it_is():
    part = bar()
    force = BondBased(part, E, CriticalStretch(0.01))
    boundaries = ends(part, displacement=[lambda time: 0.1 * time, None])
    u, newton = solved(force, boundaries, steps=4, tolerance=1e-10)
    assert newton.history[-1].converged
    assert np.isfinite(u).all()
    right = part.positions[:, 0] > LENGTH - SPACING
    assert u[right, 0] == pytest.approx(0.1)


# -- scenes -------------------------------------------------------------------------------------------------------


def test_two_parts_and_their_connection_are_one_problem():
    whole = bar()
    u, _ = solved(BondBased(whole, E), ends(whole, displacement=[0.1, 0.05]))
    halves = [
        rbs.Part(name, rbs.Box([1.0, 0.8], center=[x, 0.4])).discretize(SPACING).connect(horizon=2.015 * SPACING)
        for name, x in (("left", 0.5), ("right", 1.5))
    ]
    joint = rbs.Connection(*halves, horizon=2.015 * SPACING)
    forces = [BondBased(host, E) for host in (*halves, joint)]
    left, right = halves
    boundaries = [
        BoundaryDomain(left, left.positions[:, 0] < SPACING, displacement=[0.0, 0.0]),
        BoundaryDomain(right, right.positions[:, 0] > LENGTH - SPACING, displacement=[0.1, 0.05]),
    ]
    Analysis([Newton(halves, forces, boundaries, tolerance=TIGHT)], steps=1).run(progress=False)
    both = {
        tuple(np.round(x, 6)): v for part in halves for x, v in zip(part.positions, part[displacement], strict=True)
    }
    mine = np.array([both[tuple(np.round(x, 6))] for x in whole.positions])
    assert mine == pytest.approx(u, rel=1e-9, abs=1e-11)


def test_a_preload_hands_over_to_dynamics():
    part = bar()
    part[density] = 1000.0
    force, boundaries = BondBased(part, E), ends(part, force=[5e6, -1e6])
    newton = Newton(part, force, boundaries, tolerance=TIGHT, when=rbs.once)
    scheme = VelocityVerlet(part)
    analysis = Analysis([newton, *scheme.step([force], boundaries)], steps=1)
    analysis.run(progress=False)
    still = part[displacement].copy()
    analysis.run(steps=40, progress=False)
    assert np.abs(part[displacement] - still).max() < 1e-9 * np.abs(still).max()


def test_a_resumed_run_is_the_same_to_the_bit(tmp_path):
    def scene():
        part = bar()
        force = BondBased(part, E, CriticalStretch(0.01))
        boundaries = ends(part, displacement=[lambda time: 0.02 * time, 0.0])
        newton = Newton(part, force, boundaries, tolerance=1e-10)
        return part, Analysis([newton, rbs.Checkpoint(tmp_path / "saved.npz", when=rbs.every(3))], steps=6)

    part, analysis = scene()
    analysis.run(progress=False)
    _, second = scene()
    second.run(steps=3, progress=False)
    third, last = scene()
    last.run(resume=tmp_path / "saved.npz", progress=False)
    assert (third[displacement] == part[displacement]).all()
