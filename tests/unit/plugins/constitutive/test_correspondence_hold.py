"""Trials: with `hold` the force is that of the present displacement, and nothing of the part or its bonds moves on."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import BondSoftening, Correspondence, CriticalStretch
from rbs_plugins.constitutive import stress
from rbs_plugins.constitutive.softening import soften, soften_slope
from rbs_plugins.fields import (
    displacement,
    equivalent_plastic_strain,
    force_density,
    intact,
    largest_stretch,
    plastic_strain,
)

H, E = 1e-3, 10e9
PLASTIC = {"law": stress.j2_plasticity, "yield_stress": 5e6, "hardening": 1e9}
SLOW = pytest.mark.verify
CASES = [
    (1, "list", PLASTIC, (plastic_strain, equivalent_plastic_strain)),
    pytest.param(1, "list", {"fracture": CriticalStretch(5e-4)}, (intact,), marks=SLOW),
    pytest.param(1, "list", {"fracture": BondSoftening(5e-4, 5e-3)}, (intact, largest_stretch), marks=SLOW),
    pytest.param(2, "lattice", PLASTIC, (plastic_strain, equivalent_plastic_strain), marks=SLOW),
    pytest.param(2, "lattice", {"fracture": CriticalStretch(5e-4)}, (intact,), marks=SLOW),
]


def made(d, storage, arguments):
    """A stretched body, the relation, and what evaluates its force."""
    across = {1: {"area": 2e-6}, 2: {"thickness": 2e-3}}[d]
    part = rbs.Part("body", rbs.Box(size=[9 * H] * d)).discretize(H, **across).connect(2.015 * H, storage=storage)
    part[displacement] = np.zeros_like(part.positions)
    force = Correspondence(part, **{"law": stress.saint_venant_kirchhoff, "E": E, "nu": 0.3, **arguments})
    analysis = rbs.Analysis([force])
    analysis.prepare()
    force.begin(analysis.clock)

    def now(hold):
        part[force_density][...] = 0.0
        force.hold = hold
        force.apply(analysis.clock)
        return part[force_density].copy()

    now(False)
    part[displacement] = 2e-3 * part.positions
    return part, now


@pytest.mark.parametrize(("d", "storage", "arguments", "kept"), CASES)
def test_nothing_moves_on(d, storage, arguments, kept):
    part, now = made(d, storage, arguments)
    before = {field: np.array(part.store(field.at).get(field)) for field in kept}
    first, second = now(True), now(True)
    np.testing.assert_array_equal(first, second)
    for field, values in before.items():
        np.testing.assert_array_equal(part.store(field.at).get(field), values)
    accepted = now(False)
    assert any((part.store(field.at).get(field) != values).any() for field, values in before.items())
    if isinstance(arguments.get("fracture"), CriticalStretch):  # all bonds have failed
        assert np.abs(first).max() > 0
        assert not accepted.any()
    else:
        np.testing.assert_array_equal(first, accepted)


def test_slope_of_softening():
    numbers = (1e-3, 4e-3, 3.0)
    for stretch in (1.2e-3, 2.5e-3, 3.9e-3):
        change = soften(stretch + 1e-8, *numbers) - soften(stretch - 1e-8, *numbers)
        assert soften_slope(stretch, *numbers) == pytest.approx(change / 2e-8, rel=1e-6)
        assert soften_slope(stretch, *numbers) < 0
    assert soften_slope(0.9e-3, *numbers) == soften_slope(4.1e-3, *numbers) == 0.0
