"""Energy of pulling a body apart: closed forms of springs, and what springs do not know."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_plugins.constitutive import separation
from rbs_plugins.constitutive.bond_based import critical_stretch
from rbs_plugins.constitutive.linear_solid import moduli
from rbs_plugins.constitutive.separation import fracture_energy_of_unit_stretch

E, HORIZON = 2e9, 3e-3
CASES = {"1-D": (1, 2e-6, 0.0), "stress": (2, 1e-3, 1 / 3), "strain": (2, 1e-3, 0.25), "3-D": (3, 1.0, 0.25)}


def inverse(lengths):
    return HORIZON / lengths


@pytest.mark.parametrize("case", CASES)
def test_springs_take_the_closed_form(case):
    """Silling & Askari (2005), eq. 27, and its counterparts in the plane and on a line."""
    dimension, across, nu = CASES[case]
    gamma, pull = moduli(case, E, nu)
    assert gamma == pytest.approx(0.0, abs=1e-12 * E)
    found = fracture_energy_of_unit_stretch(dimension, HORIZON, across, inverse, gamma, pull)
    assert 1.0 / np.sqrt(found) == pytest.approx(critical_stretch(1.0, E, HORIZON, case), rel=1e-6)


@pytest.mark.parametrize("case", ["stress", "3-D"])
def test_quadrature_has_converged(case, monkeypatch):
    dimension, across, _ = CASES[case]
    given = (dimension, HORIZON, across, np.ones_like, *moduli(case, E, 0.4))
    rough = fracture_energy_of_unit_stretch(*given)
    for name in ("DEPTHS", "LENGTHS", "ANGLES"):
        monkeypatch.setattr(separation, name, 2 * getattr(separation, name))
    assert rough == pytest.approx(fracture_energy_of_unit_stretch(*given), rel=1e-4)


def test_it_does_not_depend_on_the_unit_of_the_influence():
    gamma, pull = moduli("3-D", E, 0.4)
    one, two = (
        fracture_energy_of_unit_stretch(3, HORIZON, 1.0, lambda r, f=factor: f * np.exp(-r / HORIZON), gamma, pull)
        for factor in (1.0, 7.0)
    )
    assert one == pytest.approx(two, rel=1e-12)


def test_a_solid_that_resists_growth_takes_more_energy():
    springs, stiff = (fracture_energy_of_unit_stretch(3, HORIZON, 1.0, inverse, g, 15e9) for g in (0.0, 20e9))
    assert stiff > 1.1 * springs
