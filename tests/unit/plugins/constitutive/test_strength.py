"""Strength that differs from node to node."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import BondBased, CriticalStretch, VelocityVerlet, Weibull
from rbs_plugins.fields import breakable, critical_stretch, density, displacement, velocity
from rbs_plugins.testing import check_breaking, check_momentum, check_storages


def pairs(stretches):
    """Pairs of nodes, each bond stretched by a number of its own."""
    points = np.ravel([(10.0 * k, 10.0 * k + 1.0) for k in range(len(stretches))])[:, None]
    part = rbs.Part("pairs", rbs.Everywhere(), dimension=1).place(points, 1.0, spacing=1.0).connect(1.5)
    part[displacement] = np.ravel([(0.0, s) for s in stretches])[:, None]
    return part


def broken(part, criterion, **options):
    steel = BondBased(part, **{"c": 1.0, **options}, fracture=criterion)
    rbs.Analysis([steel]).run(steps=1, dt=1.0, force_dt=True, progress=False)
    both = part.bonds.intact.reshape(-1, 2)
    assert np.array_equal(both[:, 0], both[:, 1])
    return [not holds for holds in both[:, 0].tolist()]


STRETCHES = [-0.25, -0.15, 0.05, 0.15, 0.25]


@pytest.mark.parametrize(
    ("options", "wanted"),
    [
        ({}, [0, 0, 0, 0, 1]),
        ({"rule": "mean"}, [0, 0, 0, 0, 1]),
        ({"rule": "minimum"}, [0, 0, 0, 1, 1]),
        ({"mode": "compression"}, [1, 0, 0, 0, 0]),
        ({"mode": "compression", "rule": "minimum"}, [1, 1, 0, 0, 0]),
        ({"mode": "both"}, [1, 0, 0, 0, 1]),
        ({"mode": "both", "rule": "minimum"}, [1, 1, 0, 1, 1]),
    ],
)
@pytest.mark.parametrize("turned", [False, True])
def test_rules(options, wanted, turned):
    """Ends with limits of 0.1 and 0.3: 0.2 in the mean, 0.1 for the weaker one, from whichever end."""
    limits = np.tile([0.3, 0.1] if turned else [0.1, 0.3], len(STRETCHES))
    assert broken(pairs(STRETCHES), CriticalStretch(limits, **options)) == [bool(each) for each in wanted]


def test_a_bond_at_its_limit_holds():
    limits = [0.25, 0.75, 0.25, 0.75]
    assert broken(pairs([0.5, 0.5 + 1e-12]), CriticalStretch(limits)) == [False, True]


def test_ways_to_give_limits():
    part = pairs(STRETCHES)
    BondBased(part, c=1.0, fracture=CriticalStretch(lambda X: 0.1 + X[:, 0]))
    assert part[critical_stretch] == pytest.approx(0.1 + part.positions[:, 0])
    BondBased(part, c=1.0, fracture=CriticalStretch(critical_stretch))  # as it is
    assert part[critical_stretch] == pytest.approx(0.1 + part.positions[:, 0])
    part = pairs(STRETCHES)
    part[critical_stretch] = 0.2
    assert broken(part, CriticalStretch(critical_stretch)) == [False] * 4 + [True]


def test_the_field_must_be_set():
    with pytest.raises(rbs.MissingField, match="critical_stretch"):
        broken(pairs([0.1]), CriticalStretch(critical_stretch))


def test_limits_from_fracture_energies():
    part = rbs.Part("plate", rbs.Box(size=(6.0, 5.0))).discretize(1.0).connect(2.0)
    energies = np.linspace(1.0, 9.0, len(part))
    steel = BondBased(part, E=1e9, fracture=CriticalStretch(fracture_energy=energies))
    wanted = np.sqrt(4 * math.pi * energies / (9 * 1e9 * 2.0))
    np.testing.assert_allclose(part[critical_stretch], wanted, rtol=1e-14)
    assert steel.critical_stretch(4.0) == pytest.approx(math.sqrt(4 * math.pi * 4.0 / (9 * 1e9 * 2.0)), rel=1e-14)


def test_on_a_connection():
    one = rbs.Part("one", rbs.Box(size=(3.0, 2.0))).discretize(1.0)
    two = rbs.Part("two", rbs.Box(size=(3.0, 2.0), center=(0.0, 2.5))).discretize(1.0)
    glue = rbs.Connection(one, two, 2.0)
    for part in (one, two):
        part[displacement] = lambda X: 0.5 * X
    BondBased(glue, c=1.0, fracture=CriticalStretch(lambda X: 0.1 + 0.0 * X[:, 0]))
    assert one[critical_stretch].tolist() == two[critical_stretch].tolist() == [0.1] * 6
    with pytest.raises(BadInput, match="belongs to one part"):
        BondBased(glue, c=1.0, fracture=CriticalStretch(np.full(6, 0.1)))


def test_together_with_a_region():
    part = pairs([0.5] * 2)
    assert broken(part, CriticalStretch([0.1] * 4, within=rbs.HalfSpace(5.0, 1.0))) == [False, True]
    assert part[breakable].tolist() == [0, 0, 1, 1]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"s0": [0.1, 0.2]}, r"one per node, \(4,\)"),
        ({"s0": [0.1, 0.2, 0.0, 0.1]}, "limit of node 2 .* is 0, not positive"),
        ({"s0": lambda X: np.nan * X[:, 0]}, "limit of node 0 .* not positive"),
        ({"s0": [0.1] * 4, "mode": "both", "compression": 0.2}, "compression= has none of its own"),
        ({"s0": 0.1, "rule": "maximum"}, "rule='maximum' must be one of mean, minimum"),
        ({"s0": density}, "'density' is not the field critical_stretch"),
    ],
)
def test_bad_limits(given, words):
    with pytest.raises(BadInput, match=words):
        BondBased(pairs([0.0, 0.0]), c=1.0, fracture=CriticalStretch(**given))


def test_two_sets_of_limits_on_one_part_are_refused():
    part = pairs([0.0])
    BondBased(part, c=1.0, fracture=CriticalStretch([0.1, 0.2]))
    BondBased(part, c=2.0, fracture=CriticalStretch([0.1, 0.2], rule="minimum"))
    with pytest.raises(BadInput, match="already has other limits"):
        BondBased(part, c=1.0, fracture=CriticalStretch([0.1, 0.3]))
    assert part[critical_stretch].tolist() == [0.1, 0.2]


def test_repr():
    assert repr(CriticalStretch([0.1, 0.2])) == "CriticalStretch(<array (2,)>, mode='tension', rule='mean')"
    assert repr(CriticalStretch(critical_stretch)) == "CriticalStretch(critical_stretch, mode='tension', rule='mean')"
    random = CriticalStretch(fracture_energy=Weibull(5.0, 8.0, seed=1), rule="minimum")
    assert repr(random) == (
        "CriticalStretch(fracture_energy=Weibull(5.0, 8.0, seed=1), mode='tension', rule='minimum')"
    )


# -- on a lattice ---------------------------------------------------------------------------------------------------


def graded(part):
    return {"E": 1e9, "fracture": CriticalStretch(Weibull(1e-3, 4.0, seed=2), rule="minimum")}


class Graded(BondBased):
    """Brittle, with limits that differ."""

    example = staticmethod(graded)

    def __init__(self, part, E, fracture):
        super().__init__(part, E, CriticalStretch(Weibull(1e-3, 4.0, seed=2), rule="minimum"))


@pytest.mark.parametrize("check", [check_storages, check_breaking, check_momentum])
def test_lists_and_lattices_break_the_same_bonds(check):
    check(Graded, 2, "lattice")


def test_nodes_at_rest_are_skipped_all_the_same():
    """Limits are positive, so nothing fails that has not moved: a hit at one end is not felt at the other."""
    part = rbs.Part("strip", rbs.Box(size=(4000.0, 3.0))).discretize(1.0).connect(3.0, storage="lattice")
    part[density], part[velocity] = 1.0, 0.0
    part[velocity][:3] = 1e-3
    steel = BondBased(part, E=1.0, fracture=CriticalStretch(Weibull(1e-3, 4.0, seed=2)), active=True)
    rbs.Analysis(VelocityVerlet(part).step([steel])).run(steps=3, progress=False)
    assert 0 < steel.visited() < len(part.bonds)


# -- random ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("least", [0.0, 0.2])
def test_weibull(least):
    """Its distribution, by the largest distance of a sample of n: below 1.63/√n with 99 % (Kolmogorov)."""
    n, scale, shape = 20000, 0.05, 6.0
    values = np.sort(Weibull(scale, shape, seed=4, least=least)(np.zeros((n, 2))))
    wanted = 1.0 - np.exp(-(((values - least) / scale) ** shape))
    assert np.abs(wanted - (np.arange(n) + 0.5) / n).max() < 1.63 / math.sqrt(n)
    weaker = np.sort(values[np.random.default_rng(1).permutation(n)].reshape(-1, 2).min(axis=1))
    wanted = 1.0 - np.exp(-(((weaker - least) / (scale * 2 ** (-1 / shape))) ** shape))
    assert np.abs(wanted - (np.arange(n // 2) + 0.5) / (n // 2)).max() < 1.63 / math.sqrt(n / 2)


def test_the_seed_decides():
    places = np.zeros((50, 3))
    one, same, other = (Weibull(1.0, 5.0, seed=seed)(places) for seed in (3, 3, 4))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


@pytest.mark.parametrize(
    ("given", "words"),
    [((0.0, 5.0), "scale=0.0 must be positive"), ((1.0, math.nan), "shape=nan must be positive")],
)
def test_bad_distributions(given, words):
    with pytest.raises(BadInput, match=words):
        Weibull(*given, seed=1)
    with pytest.raises(BadInput, match="must not be below zero"):
        Weibull(1.0, 5.0, seed=1, least=-1.0)
