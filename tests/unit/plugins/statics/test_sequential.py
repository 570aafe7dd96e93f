"""SequentiallyLinear: every equilibrium has one bond at its limit, and the path goes through snap-back."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import Analysis, BadInput
from rbs_plugins import BondBased, BoundaryDomain, Criterion, CriticalStretch, Damage, Pressure, ReactionForce
from rbs_plugins.fields import displacement, load_factor, reaction_force
from rbs_plugins.statics.sequential import SequentiallyLinear

S0, SPACING = 1e-3, 0.2


def notched(fracture=None):
    """A strip of 12 x 5 nodes with a notch in the middle."""
    part = (
        rbs.Part("strip", rbs.Box([2.4, 1.0], center=[1.2, 0.5])).discretize(SPACING).connect(horizon=2.015 * SPACING)
    )
    part.bonds.cut(rbs.Segment([1.2, -0.1], [1.2, 0.3]))
    force = BondBased(part, 1e9, fracture or CriticalStretch(S0), linear=True)
    x = part.positions[:, 0]
    left = BoundaryDomain(part, x < 2 * SPACING, displacement=[0.0, 0.0])
    return part, force, left, x > 2.4 - 2 * SPACING


def run(part, solver, *more, steps=200):
    analysis = Analysis([solver, *more], steps=steps, dt=1.0)
    return analysis, analysis.run(progress=False)


def largest_share(part, holds):
    offsets, neighbors = part.bonds.as_rows()
    i = np.repeat(np.arange(len(part)), np.diff(offsets))
    bond = part.positions[neighbors] - part.positions[i]
    eta = part[displacement][neighbors] - part[displacement][i]
    stretch = np.sum(eta * bond, axis=1) / np.sum(bond * bond, axis=1)
    return stretch[holds].max() / S0


def test_the_worst_bond_is_at_its_limit_and_fails_next():
    part, force, left, right = notched()
    solver = SequentiallyLinear(part, force, [left, BoundaryDomain(part, right, displacement=[1e-3, 0.0])])
    held = part.bonds.intact.sum()
    analysis = Analysis([solver], steps=12, dt=1.0)
    for step in range(1, 9):
        analysis.run(steps=step, progress=False)
        assert largest_share(part, part.bonds.intact) == pytest.approx(1.0, rel=1e-9)
        assert part[load_factor] == solver.history[-1].factor
        assert part.bonds.intact.sum() == held - 2 * sum(len(e.bonds) for e in solver.history[:-1])


def test_a_kept_factor_gives_what_a_new_one_gives(monkeypatch):
    from rbs_plugins.statics import lowrank

    factors = []
    for most in (60, 0):
        monkeypatch.setattr(lowrank, "MOST", most)
        part, force, left, right = notched()
        solver = SequentiallyLinear(part, force, [left, BoundaryDomain(part, right, displacement=[1e-3, 0.0])])
        run(part, solver, steps=15)
        factors.append([each.factor for each in solver.history])
    assert factors[0] == pytest.approx(factors[1], rel=1e-8)


def test_the_path_ends_when_nothing_carries_load_and_goes_through_snap_back():
    part, force, left, right = notched(CriticalStretch(S0, within=rbs.Box([1.6, 1.0], center=[1.2, 0.5])))
    pull = BoundaryDomain(part, right, displacement=[1e-3, 0.0])
    solver, reaction = SequentiallyLinear(part, force, [left, pull]), ReactionForce(part, pull)
    path = []

    class Path(rbs.Measure):
        reads, stays = (reaction_force, load_factor), True

        def apply(self, clock):
            path.append((float(self[load_factor]), float(self[reaction_force][0])))

    analysis, report = run(part, solver, reaction, Damage(part), Path(part))
    assert solver.finished
    assert report.stopped == "finished"
    assert analysis.clock.step < 200
    assert path[-1] == (0.0, 0.0)
    factor, force_ = np.array(path[:-1]).T
    assert (np.diff(factor) < 0).any(), "the displacement turns back"
    stiffness = force_ / factor
    assert (np.diff(stiffness) < 1e-9 * stiffness[0]).all(), "it never gets stiffer"
    assert stiffness[-1] < 0.1 * stiffness[0]


def test_a_force_is_scaled_as_well():
    part, force, left, right = notched()
    solver = SequentiallyLinear(part, force, [left, BoundaryDomain(part, right, force=[1e5, 0.0])])
    reaction = ReactionForce(part, left)
    run(part, solver, reaction, steps=5)
    assert part[reaction_force][0] == pytest.approx(-1e5 * solver.history[-1].factor, rel=1e-9)


def test_loads_on_supports_are_scaled_and_the_path_ends_at_a_mechanism():
    """Body forces act on supports, too, and do not depend on time; behind the last event a hinge is left."""
    part, force, left, _ = notched()
    weight = BoundaryDomain(part, rbs.Everywhere(), body_force=[1e5, 0.0])
    solver, reaction = SequentiallyLinear(part, force, [left, weight]), ReactionForce(part, left)
    found = []

    class Path(rbs.Measure):
        reads, stays = (reaction_force, load_factor), True

        def apply(self, clock):
            found.append((float(self[load_factor]), float(self[reaction_force][0])))

    run(part, solver, reaction, Path(part))
    assert solver.finished
    factors, forces = np.array(found).T
    assert forces == pytest.approx(-1e5 * 2.4 * factors, rel=1e-6)


def test_a_run_in_pieces_is_the_same_to_the_bit():
    found = []
    for pieces in ((8,), (3, 8)):
        part, force, left, right = notched()
        solver = SequentiallyLinear(part, force, [left, BoundaryDomain(part, right, force=[1e5, 0.0])])
        analysis = Analysis([solver], dt=1.0)
        for steps in pieces:
            analysis.run(steps=steps, progress=False)
        found.append(part[displacement].copy())
    assert np.array_equal(*found)


def test_everything_may_be_prescribed_but_not_nothing():
    part, force, left, right = notched()
    stretched = BoundaryDomain(part, rbs.Everywhere(), displacement=lambda time, X: (1e-3 * time * X[:, 0], 0.0))
    solver = SequentiallyLinear(part, force, stretched)
    run(part, solver, steps=1)
    assert solver.history[0].factor == pytest.approx(1.0)
    with pytest.raises(BadInput, match="no first equilibrium: no bond that can fail carries any load"):
        run(part, SequentiallyLinear(part, force, [left, BoundaryDomain(part, right, force=[0.0, 0.0])]), steps=1)


def test_what_it_cannot_do_is_refused():
    part, force, left, _ = notched()
    with pytest.raises(BadInput, match="is not linear: make it with linear=True, or take Newton"):
        SequentiallyLinear(part, BondBased(part, 1e9, CriticalStretch(S0)), left)
    with pytest.raises(BadInput, match="nothing can fail"):
        SequentiallyLinear(part, BondBased(part, 1e9, linear=True), left)
    other = Criterion(lambda stretch, limit: stretch > limit, limit=1e-3)
    with pytest.raises(BadInput, match="only a CriticalStretch tells at which load"):
        SequentiallyLinear(part, BondBased(part, 1e9, other, linear=True), left)
    pressure = Pressure(part, [59], 1.0, normal=(1.0, 0.0))
    with pytest.raises(BadInput, match=r"Pressure 'strip' depends on displacements.*take a dead load"):
        SequentiallyLinear(part, force, [left, pressure])
    with pytest.raises(BadInput, match="60 nodes that hang together can move along x"):
        run(part, SequentiallyLinear(part, force, []), steps=1)
