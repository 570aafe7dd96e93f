"""Constants of the linear solid against classical elasticity."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins.constitutive.linear_solid import constants, moduli

E = 7e9


def continuum(case, nu):
    """Lamé's constants, those of the plane in 2-D, from the sums over a whole family (ω = 1).

    With e = ε:ξξ/|ξ| the energy is ½[γ/m² S² + α Σ ω e² V]: S = m tr ε/d, and Σ ω e² V = m (tr² + 2 ε:ε)/(d (d + 2)).
    """
    gamma, pull = moduli(case, E, nu)
    d = {"1-D": 1, "stress": 2, "strain": 2, "3-D": 3}[case]
    return gamma / d**2 + pull / (d * (d + 2)), pull / (d * (d + 2))


@pytest.mark.parametrize("nu", [-0.9, -0.3, 0.0, 0.2, 0.25, 1 / 3, 0.45, 0.499])
@pytest.mark.parametrize("case", ["stress", "strain", "3-D"])
def test_the_family_has_the_moduli_of_the_material(case, nu):
    first, shear = continuum(case, nu)
    lame = E * nu / (1 - nu**2) if case == "stress" else E * nu / ((1 + nu) * (1 - 2 * nu))
    assert shear == pytest.approx(E / (2 * (1 + nu)), rel=1e-13)
    assert first == pytest.approx(lame, rel=1e-12, abs=1e-12 * E)


def test_a_bar_has_its_modulus():
    first, shear = continuum("1-D", 0.0)
    assert first + 2 * shear == pytest.approx(E)


def test_wrong_constants_are_refused_with_the_node():
    part = rbs.Part("plate", rbs.Box(size=(4.0, 2.0))).discretize(1.0)
    assert constants("Solid", "stress", part, 1.0, 0.3) == (1.0, 0.3)
    for given, message in {
        (1.0, None): "give E and nu",
        (-1.0, 0.3): r"E=-1.0 must be positive",
        (1.0, 0.5): r"nu=0.5 must be between -1 and 0.5",
        (np.nan, 0.3): "must be positive and finite",
        ("stiff", 0.3): "E must be a number, or one for each of 8 nodes",
    }.items():
        with pytest.raises(rbs.BadInput, match=message):
            constants("Solid", "stress", part, *given)
    nu = np.full(8, 0.3)
    nu[5] = 0.7
    with pytest.raises(rbs.BadInput, match=r"nu=0.7 of node 5 at \[-0.5, 0.5\] must be"):
        constants("Solid", "stress", part, 1.0, nu)
    with pytest.raises(rbs.BadInput, match="one for each of 8 nodes"):
        constants("Solid", "stress", part, 1.0, nu[:3])
    with pytest.raises(rbs.BadInput, match="a 1-D part has no Poisson's ratio"):
        constants("Solid", "1-D", part, 1.0, 0.3)
