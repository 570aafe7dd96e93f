"""Criteria, the regions in which they hold, and damage."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_core.part import Connection
from rbs_plugins import (
    BondBased,
    BoundaryDomain,
    Criterion,
    CriticalStretch,
    CSVExporter,
    Damage,
    FractureDissipation,
    KineticEnergy,
    StrainEnergy,
    VelocityVerlet,
)
from rbs_plugins.fields import (
    breakable,
    damage,
    density,
    displacement,
    external_work,
    force_density,
    fracture_dissipation,
    kinetic_energy,
    strain_energy,
    volume,
)


def row(stretches):
    """Pairs of nodes, each bond stretched by a number of its own."""
    n = len(stretches)
    points = np.ravel([(10.0 * k, 10.0 * k + 1.0) for k in range(n)])[:, None]
    part = rbs.Part("pairs", rbs.Everywhere(), dimension=1).place(points, 1.0, spacing=1.0).connect(1.5)
    part[displacement] = np.ravel([(0.0, s) for s in stretches])[:, None]
    return part


def broken(part, criterion):
    rbs.Analysis([BondBased(part, c=1.0, fracture=criterion)]).run(steps=1, dt=1.0, force_dt=True, progress=False)
    both = part.bonds.intact.reshape(-1, 2)
    assert np.array_equal(both[:, 0], both[:, 1])
    return [not holds for holds in both[:, 0].tolist()]


STRETCHES = [-0.5, -0.11, -0.09, 0.0, 0.09, 0.11, 0.5]


@pytest.mark.parametrize(
    ("criterion", "wanted"),
    [
        (CriticalStretch(0.1), [0, 0, 0, 0, 0, 1, 1]),
        (CriticalStretch(0.1, mode="compression"), [1, 1, 0, 0, 0, 0, 0]),
        (CriticalStretch(0.1, mode="both"), [1, 1, 0, 0, 0, 1, 1]),
        (CriticalStretch(0.1, mode="both", compression=0.3), [1, 0, 0, 0, 0, 1, 1]),
        (CriticalStretch(0.3, mode="both", compression=0.1), [1, 1, 0, 0, 0, 0, 1]),
        (Criterion(lambda stretch, limit: abs(stretch) < limit, limit=0.095), [0, 0, 1, 1, 1, 0, 0]),
        (Criterion(lambda length: length > 1.4), [0, 0, 0, 0, 0, 0, 1]),
    ],
)
def test_modes(criterion, wanted):
    assert broken(row(STRETCHES), criterion) == [bool(each) for each in wanted]


def test_a_bond_at_its_limit_holds():
    """Beyond, not at: 1.5 is an exact number, so the stretch is exactly the limit."""
    assert broken(row([0.5, 0.5 + 1e-12]), CriticalStretch(0.5)) == [False, True]


def test_within():
    part = row([0.5] * 4)
    region = rbs.HalfSpace(10.5, 1.0)  # cuts the second pair in two: one end is not enough
    assert broken(part, CriticalStretch(0.1, within=region)) == [False, False, True, True]
    assert part[breakable].tolist() == [0, 0, 0, 0, 1, 1, 1, 1]


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_within_a_node_set(storage):
    part = rbs.Part("bar", rbs.Box(size=6.0)).discretize(1.0).connect(1.0, storage=storage)
    part.node_sets["right"] = [3, 4, 5]
    BondBased(part, c=1.0, fracture=CriticalStretch(0.1, within="right"))
    assert part[breakable].tolist() == [0, 0, 0, 0, 0, 0, 1, 1, 1, 1]
    assert breakable in part.store("bond").given
    with pytest.raises(BadInput, match="part 'bar' has no node set 'rigth': the nearest names are right"):
        BondBased(part, c=1.0, fracture=CriticalStretch(0.1, within="rigth"))
    with pytest.raises(BadInput, match="within=3 must be a geometry such as Box, or the name of a node set"):
        CriticalStretch(0.1, within=3)
    pair = Connection(part, pairs=[[0, 5]])
    with pytest.raises(BadInput, match="'within bar' is a connection, which has no node sets: give a geometry"):
        BondBased(pair, c=1.0, fracture=CriticalStretch(0.1, within="right"))


def test_two_regions_on_one_part_are_refused():
    part = row([0.0])
    BondBased(part, c=1.0, fracture=CriticalStretch(0.1, within=rbs.HalfSpace(0.5, 1.0)))
    BondBased(part, c=2.0, fracture=CriticalStretch(0.2, within=rbs.HalfSpace(0.5, 1.0)))
    with pytest.raises(BadInput, match="two criteria with different regions"):
        BondBased(part, c=1.0, fracture=CriticalStretch(0.1, within=rbs.HalfSpace(-0.5, 1.0)))


def test_bonds_break_for_good():
    part = row([0.5])
    law = BondBased(part, c=1.0, fracture=CriticalStretch(0.1))
    analysis = rbs.Analysis([law])
    analysis.run(steps=1, dt=1.0, force_dt=True, progress=False)
    part[displacement] = 0.0
    analysis.run(steps=2, dt=1.0, force_dt=True, progress=False)
    assert not part.bonds.intact.any()


@pytest.mark.parametrize(("dimension", "plane"), [(1, None), (2, "stress"), (2, "strain"), (3, None)])
def test_critical_stretch_from_fracture_energy(dimension, plane):
    """The closed forms; that they hold the fracture energy is integrated in test_bond_based.py."""
    E, G0, horizon = 72e9, 135.0, 1.5
    part = rbs.Part("part", rbs.Box(size=(4.0,) * dimension)).discretize(1.0).connect(horizon)
    law = BondBased(part, E=E, fracture=CriticalStretch(fracture_energy=G0), plane=plane)
    squared = {
        (1, None): 3 * G0 / (E * horizon),
        (2, "stress"): 4 * math.pi * G0 / (9 * E * horizon),
        (2, "strain"): 5 * math.pi * G0 / (12 * E * horizon),
        (3, None): 5 * G0 / (9 * (E / 1.5) * horizon),
    }[dimension, plane]
    assert CriticalStretch(fracture_energy=G0).parameters(law)["s0"] == pytest.approx(math.sqrt(squared), rel=1e-13)
    both = CriticalStretch(fracture_energy=G0, mode="both").parameters(law)
    assert both["s0_compression"] == both["s0"]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "either the stretch s0 or the fracture_energy"),
        ({"s0": 0.1, "fracture_energy": 1.0}, "either the stretch s0 or the fracture_energy"),
        ({"s0": 0.0}, "s0=0.0 must be positive"),
        ({"s0": math.nan}, "s0=nan must be positive"),
        ({"fracture_energy": -1.0}, "fracture_energy=-1.0 must be positive"),
        ({"s0": 0.1, "mode": "shear"}, "must be one of tension, compression, both"),
        ({"s0": 0.1, "compression": 0.2}, "belongs to mode='both'"),
        ({"s0": 0.1, "mode": "both", "compression": -0.2}, "compression=-0.2 must be positive"),
        ({"s0": 0.1, "within": (0, 1)}, "must be a geometry"),
        ({"s0": 0.1, "release": "later"}, "release='later' must be one of at once, next step"),
    ],
)
def test_bad_criteria(given, words):
    with pytest.raises(BadInput, match=words):
        CriticalStretch(**given)


def test_repr():
    assert repr(CriticalStretch(0.1)) == "CriticalStretch(0.1, mode='tension')"
    both = CriticalStretch(fracture_energy=5.0, mode="both", compression=0.2, within=rbs.Everywhere())
    assert repr(both) == "CriticalStretch(fracture_energy=5.0, mode='both', compression=0.2, within=Everywhere())"

    late = CriticalStretch(0.1, release="next step")
    assert repr(late) == "CriticalStretch(0.1, mode='tension', release='next step')"

    def gone(stretch, s0):
        return stretch > s0

    assert repr(Criterion(gone, s0=0.5)) == "Criterion(gone, s0=0.5)"


# -- release -------------------------------------------------------------------------------------------------------


def late(stretch, s0):
    return stretch > s0


CRITERIA = [
    lambda release: CriticalStretch(0.1, release=release),
    lambda release: CriticalStretch(0.1, mode="both", release=release),
    lambda release: Criterion(late, s0=0.1, release=release),
]


@pytest.mark.parametrize("make", CRITERIA)
@pytest.mark.parametrize(
    ("release", "wanted"), [("at once", [0.05, 0.0, 0.0]), ("next step", [0.05, 0.2, 0.0])], ids=["at once", "next"]
)
def test_a_failing_bond_lets_go_at_once_or_in_the_next_step(make, release, wanted):
    """Broken in the same step; what differs is whether it still pulls in that step. In the one behind it does not."""
    part = row([0.05])
    analysis = rbs.Analysis([BondBased(part, c=1.0, fracture=make(release))])
    forces, holds = [], []
    for step, stretch in enumerate((0.05, 0.2, 0.2), 1):
        part[displacement] = [[0.0], [stretch]]
        analysis.run(steps=step, dt=1.0, force_dt=True, progress=False)
        forces.append(part[force_density].tolist())
        holds.append(part.bonds.intact.tolist())
    assert holds == [[True, True], [False, False], [False, False]]
    for force, pull in zip(forces, wanted, strict=True):
        assert force == [[pytest.approx(pull, rel=1e-14)], [pytest.approx(-pull, rel=1e-14)]]


def test_in_the_next_step_the_other_bonds_of_the_node_pull_as_ever():
    """Three nodes in a line, one bond of the middle one fails: in that step it feels both, then the other one only."""
    part = rbs.Part("rod", rbs.Everywhere(), dimension=1).place([[0.0], [1.0], [2.0]], 1.0, spacing=1.0).connect(1.0)
    part[displacement] = [[0.0], [0.05], [0.25]]
    analysis = rbs.Analysis([BondBased(part, c=1.0, fracture=CriticalStretch(0.1, release="next step"))])
    for step, wanted in ((1, [0.05, 0.15, -0.2]), (2, [0.05, -0.05, 0.0])):
        analysis.run(steps=step, dt=1.0, force_dt=True, progress=False)
        np.testing.assert_allclose(part[force_density][:, 0], wanted, rtol=1e-13, atol=1e-15)
        assert part.bonds.intact.tolist() == [True, True, False, False]


@pytest.mark.parametrize("release", Criterion.RELEASES)
@pytest.mark.parametrize("mode", ["tension", "both"])
def test_the_energy_balance_of_a_cracking_plate_closes(tmp_path, release, mode):
    """Work = kinetic + strain + fracture energy to 0.5 %, at half of the stable step, a quarter gone into fracture."""
    side, n, end = 0.05, 24, 2.5e-5
    spacing = side / n
    part = rbs.Part("plate", rbs.Box(size=(side, side + 6 * spacing))).discretize(spacing, thickness=spacing)
    part.connect(3.015 * spacing).bonds.cut(rbs.Segment((-side / 10, 0.0), (side / 10, 0.0)))
    part[density] = 8000.0
    within = rbs.Box(size=(side, side / 2))
    steel = BondBased(part, E=192e9, fracture=CriticalStretch(0.02, mode=mode, within=within, release=release))
    grips = [
        BoundaryDomain(part, rbs.HalfSpace((0, sign * side / 2), (0, sign)), velocity=(None, sign * 20.0))
        for sign in (1, -1)
    ]
    energies = (kinetic_energy, strain_energy, fracture_dissipation)
    analysis = rbs.Analysis([
        *VelocityVerlet(part).step([steel], grips),
        KineticEnergy(part, when=rbs.last),
        StrainEnergy(part, [steel], when=rbs.last),
        FractureDissipation(part, when=rbs.last),
        CSVExporter(part, [external_work], tmp_path / "work.csv", when=rbs.last),
    ])  # fmt: skip
    steps = math.ceil(end / (0.5 * analysis.stable_dt()))
    analysis.run(steps=steps, dt=end / steps, progress=False)
    found, work = sum(float(part[field]) for field in energies), float(part[external_work])
    assert float(part[fracture_dissipation]) > 0.25 * work
    assert found == pytest.approx(work, rel=5e-3)


# -- damage --------------------------------------------------------------------------------------------------------


def test_damage_is_the_broken_share_by_volume():
    part = rbs.Part("rod", rbs.Everywhere(), dimension=1)
    part.place([[0.0], [1.0], [2.0], [9.0]], [1.0, 2.0, 5.0, 1.0], spacing=1.0)
    with pytest.warns(UserWarning, match="no bond"):
        part.connect(2.0)
    part.bonds.cut(rbs.Point(0.5))
    rbs.Analysis([Damage(part)]).run(steps=1, dt=1.0, progress=False)
    np.testing.assert_allclose(part[damage], [1.0, 1 / 6, 1 / 3, 0.0], rtol=1e-15, atol=1e-16)


def test_removed_bonds_are_no_damage():
    part = rbs.Part("rod", rbs.Box(size=4.0)).discretize(1.0).connect(1.0)
    part.bonds.remove(rbs.Point(0.0))
    assert part.bonds.intact.all()
    rbs.Analysis([Damage(part)]).run(steps=1, dt=1.0, progress=False)
    assert part[damage].tolist() == [0.0] * 4


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_damage_against_numpy(dimension):
    from rbs_plugins.testing import body, ends

    part = body(dimension)
    rbs.Analysis([Damage(part)]).run(steps=1, dt=1.0, progress=False)
    i, j = ends(part)
    total, left = (np.bincount(i, part[volume][j] * mask, len(part)) for mask in (np.ones(len(i)), part.bonds.intact))
    np.testing.assert_allclose(part[damage], 1 - left / total, atol=1e-14)
    assert part[damage].max() > 0
