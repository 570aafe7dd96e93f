"""Partial volumes."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import BondBased
from rbs_plugins.constitutive.corrections import cell_share, linear_band, set_partial_volume, share_of
from rbs_plugins.fields import volume, volume_fraction


def rod(ratio, n=20, **options):
    return rbs.Part("rod", rbs.Box(size=float(n))).discretize(1.0).connect(ratio, **options)


def vectors(part):
    """ξ (m, d) of all bonds."""
    return np.array([part.positions[j] - part.positions[i] for i, j in part.bonds])


def sparse(dimension, ratio, spacing=1.0):
    """A part whose horizon is so many spacings; for rules that look at nothing else."""
    part = rbs.Part("part", rbs.Everywhere(), dimension=dimension)
    points = np.zeros((2, dimension))
    points[1, 0] = spacing
    return part.place(points, 1.0, spacing=spacing).connect(ratio * spacing)


@pytest.mark.parametrize(
    ("ratio", "wanted"),
    [
        (3.0, {1: 1.0, 2: 1.0, 3: 0.5}),
        (3.015, {1: 1.0, 2: 1.0, 3: 0.515}),
        (2.6, {1: 1.0, 2: 1.0}),
        (2.4, {1: 1.0, 2: 0.9}),
    ],
)
@pytest.mark.parametrize("rule", [linear_band, cell_share])
def test_share_of_the_cell_within_the_horizon(ratio, wanted, rule):
    """In 1-D the share can be read off: a cell from x − ½ to x + ½ reaches beyond δ by x + ½ − δ."""
    part = rod(ratio)
    beta = rule(part, vectors(part))
    for x, share in wanted.items():
        found = beta[np.isclose(part.bonds.lengths, x)]
        assert len(found)
        assert found == pytest.approx(share, abs=1e-9)
    assert set(np.round(part.bonds.lengths).astype(int)) == set(wanted)


@pytest.mark.parametrize("ratio", [2, 3, 4, 5])
def test_bar_with_a_whole_ratio_has_exactly_its_modulus(ratio):
    """Σ β ξ over one side is δ²/2, the integral, if the last cell counts half: c A Σ β ξ Δx = E exactly."""
    part = rod(float(ratio))
    beta = linear_band(part, vectors(part))
    middle = len(part) // 2
    row = part.bonds.family(middle)
    assert np.sum(beta[row] * part.bonds.lengths[row]) / 2 == pytest.approx(ratio**2 / 2, rel=1e-9)


@pytest.mark.parametrize("rule", [linear_band, cell_share])
@pytest.mark.parametrize("dimension", [2, 3])
def test_both_ends_get_the_same_share(rule, dimension):
    part = rbs.Part("cloud", rbs.Everywhere(), dimension=dimension)
    points = np.random.default_rng(0).uniform(0.0, 10.0, (80, dimension))
    part.place(points, 1.0, spacing=1.0).connect(4.0)
    shares = dict(zip(part.bonds, rule(part, vectors(part)), strict=True))
    assert all(shares[i, j] == shares[j, i] for i, j in shares)


# -- whole cells ----------------------------------------------------------------------------------------------------


def test_known_areas_of_cells():
    """Squares at (2, 2), (0, 3), (1, 3) and (2, 3) in a circle of radius 3, found in another way, to five digits.

    The share of a turned or mirrored cell is the same to the bit.
    """
    places = np.array([[2.0, 2.0], [0.0, 3.0], [1.0, 3.0], [2.0, 3.0]])
    part = sparse(2, 3.0)
    found = cell_share(part, places)
    assert found == pytest.approx([0.69319, 0.48605, 0.31173, 0.00794], abs=1e-5)
    assert np.array_equal(cell_share(part, -places[:, ::-1]), found)


@pytest.mark.parametrize("ratio", [0.3, 1.2, 3.015])
@pytest.mark.parametrize(("dimension", "rounding"), [(2, 1e-12), (3, 1e-4)])
def test_shares_against_points_in_the_cell(dimension, ratio, rounding):
    """A million points of a low-discrepancy grid of the cell: their share within is known to about 2/100 of 1 %."""
    part = sparse(dimension, ratio, spacing=0.5) if ratio >= 1 else sparse(dimension, 1.0, spacing=0.5)
    ratio = part.bonds.horizon / 0.5
    rng = np.random.default_rng(1)
    ways = rng.normal(size=(12, dimension))
    middles = ways / np.linalg.norm(ways, axis=1)[:, None] * (ratio + rng.uniform(-0.6, 0.6, (12, 1)))
    steps = {2: 1000, 3: 100}[dimension]
    ticks = (np.arange(steps) + 0.5) / steps - 0.5
    cell = np.stack([a.ravel() for a in np.meshgrid(*[ticks] * dimension)], axis=1)
    for middle in middles:
        inside = np.mean(((cell + middle) ** 2).sum(axis=1) <= ratio**2)
        assert cell_share(part, 0.5 * middle[None])[0] == pytest.approx(inside, abs=1e-3 + rounding)


@pytest.mark.parametrize("ratio", [2.0, 3.0, 3.015, 4.7])
@pytest.mark.parametrize(("dimension", "tolerance"), [(1, 1e-13), (2, 1e-13), (3, 1e-6)])
def test_whole_families_have_the_volume_of_the_ball(dimension, ratio, tolerance):
    """With all cells that the ball cuts within reach, Σ β V + V_i is 2δA, πδ²h, and 4πδ³/3 to what slices can do."""
    n = 2 * math.ceil(ratio + 1) + 1
    across = {1: {"area": 0.3}, 2: {"thickness": 0.2}, 3: {}}[dimension]
    part = rbs.Part("body", rbs.Box(size=[float(n)] * dimension)).discretize(1.0, **across)
    part.connect(ratio, reach=ratio + math.sqrt(dimension) / 2)
    assert set_partial_volume(part, "exact")
    middle = len(part) // 2
    found = (part[volume_fraction][part.bonds.family(middle)].sum() + 1.0) * part[volume][0]
    ball = {1: 2 * 0.3 * ratio, 2: math.pi * ratio**2 * 0.2, 3: 4 / 3 * math.pi * ratio**3}[dimension]
    assert found == pytest.approx(ball, rel=tolerance)


def test_cells_in_and_out_of_reach():
    part = sparse(3, 3.0)
    found = cell_share(part, np.array([[1.0, 1.0, 1.0], [3.6, 0.0, 0.0], [2.4, 2.4, 2.4]]))
    assert found.tolist() == [1.0, 0.0, 0.0]


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_reach_gives_the_linear_band_its_outer_half(storage):
    part = rod(3.0, reach=3.5, storage=storage)
    set_partial_volume(part, "linear")
    lengths = np.round(part.bonds.lengths)
    assert part[volume_fraction] == pytest.approx(np.where(lengths == 3, 0.5, 1.0), abs=1e-9)
    wide = rod(2.8, reach=3.3, storage=storage)
    set_partial_volume(wide, "linear")
    third = np.round(wide.bonds.lengths) == 3
    assert third.any()
    assert wide[volume_fraction][third] == pytest.approx(0.3, abs=1e-9)


# -- by name --------------------------------------------------------------------------------------------------------


def test_rules():
    part = rod(3.0)
    assert set_partial_volume(part, "none") is False
    assert volume_fraction not in part
    assert set_partial_volume(part, "linear") is True
    assert set_partial_volume(part, "linear") is True  # the same again
    with pytest.raises(BadInput, match="must be one of none, linear, exact"):
        set_partial_volume(part, "cubic")
    part[volume_fraction] = 0.7
    with pytest.raises(BadInput, match="already has other volume fractions"):
        BondBased(part, E=1e9, partial_volume="linear")
    assert share_of(part, "none", np.ones((3, 1))).tolist() == [1.0] * 3


def test_bonds_beyond_the_horizon_count_with_a_partial_volume_only():
    with pytest.raises(BadInput, match="count with a partial volume only"):
        BondBased(rod(3.0, reach=3.5), E=1e9)


@pytest.mark.parametrize("rule", ["linear", "exact"])
def test_cloud_needs_a_spacing(rule):
    part = rbs.Part("cloud", rbs.Everywhere(), dimension=1).place([[0.0], [1.0]], 1.0).connect(1.5)
    with pytest.raises(BadInput, match=f"has no spacing, which partial_volume='{rule}' needs"):
        BondBased(part, E=1e9, partial_volume=rule)
