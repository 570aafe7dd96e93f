"""Classical stress laws for correspondence: plain functions of the deformation gradient F.

    def mine(F, lame, G):
        return ...        # first Piola-Kirchhoff stress P, Pa

F and P are 3 x 3 tuples (see `rbs_plugins.tensors`), P with the spatial index first. A law asks by argument name for E,
nu, K, G and lame (λ, Pa), for numbers given to Correspondence as keywords, for state fields and scalar fields of the
node, for time and dt. One with state returns the new state behind P, in the order in which it is asked for.

In a plane F has F33 = 1 (plane strain), or the F33 for which P33 vanishes (plane stress), and no other component out of
the plane; in 1-D F22 = F33 are those for which P22 and P33 vanish.

Here λ is Lamé's first constant, ε the strain, H = F − I.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt
from typing import Any

from rbs_core import Field
from rbs_plugins.fields import equivalent_plastic_strain, plastic_strain
from rbs_plugins.functions import log
from rbs_plugins.tensors import (
    added,
    determinant,
    deviator,
    green_strain,
    identity,
    inner,
    inverse,
    norm,
    principal,
    product,
    scaled,
    spectral,
    symmetric,
    trace,
    transpose,
)

_TINY = 1e-30


def linear_elastic(F, lame, G):
    """P = σ = λ tr(ε) I + 2G ε, ε = sym(H): small strains and rotations; a rotated body is not free of stress."""
    strain = symmetric(added(F, identity(), -1.0))
    return added(scaled(identity(), lame * trace(strain)), strain, 2.0 * G)


def linear_elastic_energy(F, lame, G):
    """λ/2 tr(ε)² + G ε:ε, J/m^3."""
    strain = symmetric(added(F, identity(), -1.0))
    return 0.5 * lame * trace(strain) ** 2 + G * inner(strain, strain)


def saint_venant_kirchhoff(F, lame, G):
    """P = F S, S = λ tr(E) I + 2G E with Green's strain E: large rotations, moderate strains."""
    strain = green_strain(F)
    return product(F, added(scaled(identity(), lame * trace(strain)), strain, 2.0 * G))


def saint_venant_kirchhoff_energy(F, lame, G):
    """λ/2 tr(E)² + G E:E, J/m^3."""
    strain = green_strain(F)
    return 0.5 * lame * trace(strain) ** 2 + G * inner(strain, strain)


def neo_hookean(F, lame, G):
    """P = G (F − F^-T) + λ ln(J) F^-T, compressible (Bonet & Wood 2008, section 6.4.3)."""
    back = transpose(inverse(F))
    return added(scaled(F, G), back, lame * log(determinant(F)) - G)


def neo_hookean_energy(F, lame, G):
    """G/2 (F:F − 3) − G ln J + λ/2 ln²J, J/m^3."""
    volume = log(determinant(F))
    return 0.5 * G * (inner(F, F) - 3.0) - G * volume + 0.5 * lame * volume * volume


def hencky(F, lame, G):
    """P = τ F^-T, τ = λ tr(ε) I + 2G ε with the logarithmic strain ε = ½ ln(F F^T).

    As Hashim (2021), equations 3.4 to 3.17, with the factor ½ of her appendix; D for tensor components of strain.
    """
    values, directions = principal(product(F, transpose(F)))
    a, b, c = 0.5 * log(values[0]), 0.5 * log(values[1]), 0.5 * log(values[2])
    mean = lame * (a + b + c)
    kirchhoff = spectral((mean + 2.0 * G * a, mean + 2.0 * G * b, mean + 2.0 * G * c), directions)
    return product(kirchhoff, transpose(inverse(F)))


def hencky_energy(F, lame, G):
    """λ/2 tr(ε)² + G ε:ε, J/m^3."""
    values, _ = principal(product(F, transpose(F)))
    a, b, c = 0.5 * log(values[0]), 0.5 * log(values[1]), 0.5 * log(values[2])
    return 0.5 * lame * (a + b + c) ** 2 + G * (a * a + b * b + c * c)


def j2_plasticity(F, plastic_strain, equivalent_plastic_strain, K, G, yield_stress, hardening):
    """Small strains, von Mises yield, linear isotropic hardening: radial return (Simo & Hughes 1998, box 3.1).

    The yield stress is yield_stress + hardening α, Pa, α the equivalent plastic strain; the flow is exact for a step in
    which the direction of the stress stays. As linear_elastic, for small rotations only.
    """
    strain = symmetric(added(F, identity(), -1.0))
    trial = scaled(added(deviator(strain), plastic_strain, -1.0), 2.0 * G)
    size = norm(trial)
    beyond = size - 0.816496580927726 * (yield_stress + hardening * equivalent_plastic_strain)
    flow = (beyond if beyond > 0.0 else 0.0) / (2.0 * G + 0.6666666666666666 * hardening)
    along = flow / (size if size > _TINY else 1.0)
    stress = added(scaled(trial, 1.0 - 2.0 * G * along), identity(), K * trace(strain))
    return (
        stress,
        added(plastic_strain, trial, along),
        equivalent_plastic_strain + 0.816496580927726 * flow,
    )


def j2_plasticity_energy(F, plastic_strain, equivalent_plastic_strain, K, G, hardening):
    """Stored energy K/2 tr(ε)² + G |dev ε − ε_p|² + h/2 α², J/m^3; what plastic flow turns into heat is not in it."""
    strain = symmetric(added(F, identity(), -1.0))
    elastic = added(deviator(strain), plastic_strain, -1.0)
    stored = 0.5 * hardening * equivalent_plastic_strain * equivalent_plastic_strain
    return 0.5 * K * trace(strain) ** 2 + G * inner(elastic, elastic) + stored


# -- F33 of plane stress, in closed form ---------------------------------------------------------------------------


def _linear_thickness(F, lame, G):
    """ε33 = −λ/(λ + 2G) (ε11 + ε22)."""
    return 1.0 - lame / (lame + 2.0 * G) * (F[0][0] - 1.0 + (F[1][1] - 1.0))


def _green_thickness(F, lame, G):
    """E33 = −λ/(λ + 2G) (E11 + E22)."""
    strain = green_strain(F)
    return sqrt(1.0 - 2.0 * lame / (lame + 2.0 * G) * (strain[0][0] + strain[1][1]))


@dataclass(frozen=True)
class Known:
    """What is known of a law.

    Attributes:
        potential: plain function giving its energy density, J/m^3.
        state: fields of nodes that it takes along.
        thickness: plain function giving F33 of plane stress from F with F33 = 1; found by iteration without it.
    """

    potential: Callable[..., Any] | None = None
    state: tuple[Field, ...] = ()
    thickness: Callable[..., Any] | None = None


LAWS: dict[Callable[..., Any], Known] = {
    linear_elastic: Known(linear_elastic_energy, thickness=_linear_thickness),
    saint_venant_kirchhoff: Known(saint_venant_kirchhoff_energy, thickness=_green_thickness),
    neo_hookean: Known(neo_hookean_energy),
    hencky: Known(hencky_energy),
    j2_plasticity: Known(j2_plasticity_energy, (plastic_strain, equivalent_plastic_strain)),
}
