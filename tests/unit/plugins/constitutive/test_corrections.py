"""Partial volumes."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import BondBased
from rbs_plugins.constitutive.corrections import linear_band, set_partial_volume
from rbs_plugins.fields import volume_fraction


def rod(ratio, n=20):
    return rbs.Part("rod", rbs.Box(size=float(n))).discretize(1.0).connect(ratio)


@pytest.mark.parametrize(
    ("ratio", "wanted"),
    [
        (3.0, {1: 1.0, 2: 1.0, 3: 0.5}),
        (3.015, {1: 1.0, 2: 1.0, 3: 0.515}),
        (2.6, {1: 1.0, 2: 1.0}),
        (2.4, {1: 1.0, 2: 0.9}),
    ],
)
def test_share_of_the_cell_within_the_horizon(ratio, wanted):
    """In 1-D the share can be read off: a cell from x − ½ to x + ½ reaches beyond δ by x + ½ − δ."""
    part = rod(ratio)
    beta = linear_band(part, part.bonds.lengths)
    for x, share in wanted.items():
        found = beta[np.isclose(part.bonds.lengths, x)]
        assert len(found)
        assert found == pytest.approx(share, abs=1e-9)
    assert set(np.round(part.bonds.lengths).astype(int)) == set(wanted)


@pytest.mark.parametrize("ratio", [2, 3, 4, 5])
def test_bar_with_a_whole_ratio_has_exactly_its_modulus(ratio):
    """Σ β ξ over one side is δ²/2, the integral, if the last cell counts half: c A Σ β ξ Δx = E exactly."""
    part = rod(float(ratio))
    beta = linear_band(part, part.bonds.lengths)
    middle = len(part) // 2
    row = part.bonds.family(middle)
    assert np.sum(beta[row] * part.bonds.lengths[row]) / 2 == pytest.approx(ratio**2 / 2, rel=1e-9)


def test_both_ends_get_the_same_share():
    part = rbs.Part("cloud", rbs.Everywhere(), dimension=2)
    points = np.random.default_rng(0).uniform(0.0, 10.0, (80, 2))
    part.place(points, 1.0, spacing=1.0).connect(3.0)
    shares = dict(zip(part.bonds, linear_band(part, part.bonds.lengths), strict=True))
    assert all(shares[i, j] == shares[j, i] for i, j in shares)


def test_rules():
    part = rod(3.0)
    assert set_partial_volume(part, "none") is False
    assert volume_fraction not in part
    assert set_partial_volume(part, "linear") is True
    assert set_partial_volume(part, "linear") is True  # the same again
    with pytest.raises(BadInput, match="must be one of none, linear"):
        set_partial_volume(part, "cubic")
    part[volume_fraction] = 0.7
    with pytest.raises(BadInput, match="already has other volume fractions"):
        BondBased(part, E=1e9, partial_volume="linear")


def test_cloud_needs_a_spacing():
    part = rbs.Part("cloud", rbs.Everywhere(), dimension=1).place([[0.0], [1.0]], 1.0).connect(1.5)
    with pytest.raises(BadInput, match="has no spacing"):
        BondBased(part, E=1e9, partial_volume="linear")
