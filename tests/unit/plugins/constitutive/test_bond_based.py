"""Constants of the bond-based material against classical elasticity, by integrals over a family that are done here.

Nothing of the closed forms of the module is used: energies of a homogeneous strain, and of a crack plane, are
integrated numerically over the ball, disk or interval of radius δ, and compared with what a textbook of elasticity and
the definition of the fracture energy say.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import dblquad, quad, tplquad

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import BondBased, CriticalStretch
from rbs_plugins.constitutive import bond_based

YOUNG = 73.4e9  # Pa
HORIZON = 2.7e-3  # m
THICKNESS, AREA = 0.4e-3, 3.1e-6  # m, m^2

CASES = {
    "1-D": (1, None, None),
    "plane stress": (2, "stress", 1 / 3),
    "plane strain": (2, "strain", 1 / 4),
    "3-D": (3, None, 1 / 4),
}

STRAINS = {
    1: [[[1e-3]]],
    2: [
        [[1e-3, 0.0], [0.0, 0.0]],
        [[1e-3, 0.0], [0.0, 1e-3]],
        [[0.0, 5e-4], [5e-4, 0.0]],
        [[7e-4, -2e-4], [-2e-4, -9e-4]],
    ],
    3: [np.diag([1e-3, 0, 0]), np.eye(3) * 1e-3, [[7e-4, -2e-4, 1e-4], [-2e-4, -9e-4, 3e-4], [1e-4, 3e-4, 2e-4]]],
}


def part_of(dimension):
    across = {1: {"area": AREA}, 2: {"thickness": THICKNESS}, 3: {}}[dimension]
    part = rbs.Part("part", rbs.Box(size=(4e-3,) * dimension)).discretize(1e-3, **across)
    return part.connect(HORIZON)


def material(case, **options):
    dimension, plane, _ = CASES[case]
    return BondBased(part_of(dimension), **({"E": YOUNG} | options), **({} if plane is None else {"plane": plane}))


def classical_energy(case, strain):
    """Strain energy density of Hooke's law, J/m^3."""
    dimension, plane, nu = CASES[case]
    if dimension == 1:
        return 0.5 * YOUNG * strain[0, 0] ** 2
    full = np.zeros((3, 3))
    full[:dimension, :dimension] = strain
    if plane == "stress":  # free to contract across: no stress in z
        full[2, 2] = -nu / (1 - nu) * (strain[0, 0] + strain[1, 1])
    shear, lame = YOUNG / (2 * (1 + nu)), YOUNG * nu / ((1 + nu) * (1 - 2 * nu))
    return 0.5 * lame * np.trace(full) ** 2 + shear * (full * full).sum()


def family_integral(dimension, density):
    """∫ density(ξ vector) dV over the family, with the thickness or area."""
    if dimension == 1:
        return AREA * sum(quad(lambda r, s=sign: density(np.array([s * r])), 0, HORIZON)[0] for sign in (1, -1))
    if dimension == 2:

        def on_disk(angle, r):
            return r * density(r * np.array([math.cos(angle), math.sin(angle)]))

        return THICKNESS * dblquad(on_disk, 0, HORIZON, 0, 2 * math.pi, epsrel=1e-9)[0]

    def in_ball(azimuth, polar, r):
        out = math.sin(polar)
        n = np.array([out * math.cos(azimuth), out * math.sin(azimuth), math.cos(polar)])
        return r * r * out * density(r * n)

    return tplquad(in_ball, 0, HORIZON, 0, math.pi, 0, 2 * math.pi, epsrel=1e-7, epsabs=0)[0]


@pytest.mark.parametrize(
    ("case", "number"), [(case, i) for case, (d, _, _) in CASES.items() for i in range(len(STRAINS[d]))]
)
def test_micromodulus_gives_the_energy_of_classical_elasticity(case, number):
    """W = ½ ∫ ½ c s² |ξ| dV', s = n·ε·n, for strains that also tell whether Poisson's ratio is right."""
    dimension = CASES[case][0]
    strain = np.array(STRAINS[dimension][number])
    c = material(case).c

    def held(xi):
        size = np.linalg.norm(xi)
        stretch = xi @ strain @ xi / size**2 if size > 0 else 0.0
        return 0.25 * c * stretch**2 * size

    # quadrature is asked for 1e-7 at least; its error is far below that for these smooth integrands
    assert family_integral(dimension, held) == pytest.approx(classical_energy(case, strain), rel=1e-6)


@pytest.mark.parametrize("case", CASES)
def test_critical_stretch_gives_the_fracture_energy(case):
    """G0 = energy per area of all bonds across a plane, each held at s0.

    Counted through the distances z of one end from the plane (Silling & Askari 2005, fig. 3): the other end lies in the
    part of the family beyond the plane. In 3-D a cap, in 2-D a segment of the disk, in 1-D an interval.
    """
    dimension = CASES[case][0]
    wanted = 135.0  # J/m^2
    law = material(case, fracture=CriticalStretch(fracture_energy=wanted))
    s0 = law.critical_stretch(wanted)
    assert law.parameters["fracture"].parameters(law) == {"s0": s0}

    def per_bond(size):
        return 0.5 * law.c * s0**2 * size

    if dimension == 1:
        found = AREA * dblquad(lambda r, z: per_bond(r), 0, HORIZON, lambda z: z, HORIZON)[0]
    elif dimension == 2:
        found = (
            THICKNESS
            * dblquad(lambda r, z: per_bond(r) * r * 2 * math.acos(z / r), 0, HORIZON, lambda z: z, HORIZON)[0]
        )
    else:  # the ring of directions within arccos(z/r) of the normal has the area 2π r² (1 − z/r)
        found = dblquad(lambda r, z: per_bond(r) * 2 * math.pi * r**2 * (1 - z / r), 0, HORIZON, lambda z: z, HORIZON)[
            0
        ]
    assert found == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize(
    ("case", "closed"),
    [
        ("1-D", 2 * YOUNG / (AREA * HORIZON**2)),
        ("plane stress", 9 * YOUNG / (math.pi * THICKNESS * HORIZON**3)),
        ("plane strain", 48 * YOUNG / (5 * math.pi * THICKNESS * HORIZON**3)),
        ("3-D", 12 * YOUNG / (math.pi * HORIZON**4)),
    ],
)
def test_micromodulus_is_that_of_the_glossary(case, closed):
    assert material(case).c == pytest.approx(closed, rel=1e-14)


def test_plane_stress_is_the_default_of_plates():
    assert BondBased(part_of(2), E=YOUNG).c == material("plane stress").c


def test_thickness_and_area_of_one_metre_are_the_default():
    part = rbs.Part("plate", rbs.Box(size=(4e-3, 4e-3))).discretize(1e-3).connect(HORIZON)
    assert BondBased(part, E=YOUNG).c == pytest.approx(material("plane stress").c * THICKNESS, rel=1e-14)


@pytest.mark.parametrize("case", ["plane stress", "plane strain", "3-D"])
def test_bulk_modulus(case):
    """K = E / (3 (1 − 2ν)): stress over volume strain under pressure from all sides, in three dimensions."""
    nu = CASES[case][2]
    bulk = material(case, E=None, K=YOUNG / (3 * (1 - 2 * nu)))
    assert bulk.c == pytest.approx(material(case).c, rel=1e-13)
    assert pytest.approx(YOUNG, rel=1e-13) == bulk.E


def test_silling_s_constant_of_the_bulk_modulus():
    """18 K / (π δ⁴), Silling & Askari 2005, eq. 10."""
    bulk = material("3-D", E=None, K=40e9)
    assert bulk.c == pytest.approx(18 * 40e9 / (math.pi * HORIZON**4), rel=1e-13)


def test_constant_itself():
    own = material("plane stress", E=None, c=1e20)
    assert own.c == 1e20
    assert own.E is None
    with pytest.raises(BadInput, match="needs E or K"):
        own.critical_stretch(100.0)


@pytest.mark.parametrize(
    "given",
    [{}, {"E": 1e9, "K": 1e9}, {"E": 1e9, "c": 1e20}, {"K": 1e9, "c": 1e20}, {"E": 1e9, "K": 1e9, "c": 1e20}],
)
def test_exactly_one_of_the_moduli(given):
    with pytest.raises(BadInput, match="exactly one of E, K and c"):
        BondBased(part_of(2), **given)


@pytest.mark.parametrize("name", ["E", "K", "c"])
@pytest.mark.parametrize("value", [0.0, -1e9, math.nan, math.inf])
def test_moduli_are_positive_and_finite(name, value):
    with pytest.raises(BadInput, match=f"{name}=.* must be positive and finite"):
        BondBased(part_of(2), **{name: value})


@pytest.mark.parametrize(
    ("case", "good", "bad"),
    [
        ("plane stress", [1 / 3, 0.33, 0.3333], [0.25, 0.3, 0.34, 0.0, 0.5, math.nan]),
        ("plane strain", [0.25], [1 / 3, 0.2, 0.26]),
        ("3-D", [0.25], [1 / 3, 0.3, 0.0]),
    ],
)
def test_poisson_s_ratio_that_it_cannot_have(case, good, bad):
    c = material(case).c
    for nu in good:
        assert material(case, nu=nu).c == c  # only checked, never used
    for nu in bad:
        with pytest.raises(BadInput, match=f"has Poisson's ratio {CASES[case][2]:.4g}, it cannot have"):
            material(case, nu=nu)


def test_a_bar_has_no_poisson_s_ratio_and_no_bulk_modulus():
    with pytest.raises(BadInput, match="give E"):
        material("1-D", E=None, K=1e9)
    with pytest.raises(BadInput, match="give E"):
        material("1-D", nu=0.25)


@pytest.mark.parametrize("dimension", [1, 3])
def test_plane_belongs_to_plates(dimension):
    with pytest.raises(BadInput, match="only for 2-D parts"):
        BondBased(part_of(dimension), E=1e9, plane="stress")
    with pytest.raises(BadInput, match="'stress' or 'strain'"):
        BondBased(part_of(2), E=1e9, plane="stresses")


def half(stretch, c):
    return 0.5 * c * stretch


class Half(BondBased):
    """Another law, with the potential of nobody."""

    law = staticmethod(half)


def test_other_laws_do_not_inherit_the_potential_nor_the_fracture_energy():
    soft = Half(part_of(1), E=YOUNG)
    assert soft._potential is None
    assert material("1-D")._potential is bond_based.proportional_potential
    with pytest.raises(BadInput, match="holds for f = c s"):
        soft.critical_stretch(100.0)


def without_c(stretch, k):
    return k * stretch


class Own(BondBased):
    """A law that does not want the micromodulus."""

    law = staticmethod(without_c)


def test_laws_need_not_ask_for_the_micromodulus_but_options_must_be_asked_for():
    Own(part_of(1), E=YOUNG, k=1.0)
    with pytest.raises(BadInput, match="nobody asks for fractur"):
        BondBased(part_of(1), E=YOUNG, fractur=CriticalStretch(0.1))


def test_unconnected_part_is_refused():
    part = rbs.Part("plate", rbs.Box(size=(4e-3, 4e-3))).discretize(1e-3)
    with pytest.raises(rbs.RBSError, match="connect"):
        BondBased(part, E=YOUNG)


def test_repr_shows_what_was_given():
    assert repr(material("plane strain", fracture=CriticalStretch(0.01))) == (
        "BondBased(part, E=73400000000.0, fracture=CriticalStretch(0.01, mode='tension'), plane='strain')"
    )
