"""Bond loops by hand: two nodes, whose forces and energies fit on a line."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, BadLaw, MissingField, NotFinite
from rbs_plugins import CriticalStretch, FractureDissipation, PairwiseForce, StrainEnergy
from rbs_plugins.constitutive.pairwise import hardening
from rbs_plugins.fields import (
    density,
    displacement,
    dissipation_density,
    force_density,
    intact,
    strain_energy,
    volume,
)
from rbs_plugins.functions import exp, log


def step(*relations, dt=0.5):
    analysis = rbs.Analysis(relations)
    analysis.run(steps=1, dt=dt, force_dt=True, progress=False)
    return analysis


@pytest.fixture
def pair():
    """Volumes 2 and 3, one metre apart."""
    part = rbs.Part("pair", rbs.Everywhere(), dimension=1)
    part.place([[0.0], [1.0]], [2.0, 3.0], spacing=1.0).connect(1.5)
    part[displacement] = 0.0
    return part


def linear(stretch, c):
    return c * stretch


def aging(stretch, c, time, dt):
    return c * stretch * (1.0 + time) + dt


def test_force_by_hand(pair):
    pair[displacement] = [[0.0], [0.5]]
    step(PairwiseForce(pair, linear, c=4.0))
    assert pair[force_density].tolist() == [[6.0], [-4.0]]


def test_clock_reaches_force_and_energy(pair):
    pair[displacement] = [[0.0], [0.5]]
    law = PairwiseForce(pair, aging, c=4.0)
    measure = StrainEnergy(pair, [law])
    analysis = rbs.Analysis([law, measure])
    for steps in (1, 2):
        analysis.run(steps=steps, dt=0.25, force_dt=True, progress=False)
        time = 0.25 * steps
        assert pair[force_density][0, 0] == 3.0 * (4.0 * 0.5 * (1.0 + time) + 0.25)
        # ∫ f d(length) from rest to the stretch of one half
        assert pair[strain_energy] == pytest.approx(6.0 * (0.5 * 4.0 * 0.25 * (1 + time) + 0.25 * 0.5), rel=1e-14)


def test_two_laws_add_up(pair):
    pair[displacement] = [[0.0], [0.5]]
    laws = [PairwiseForce(pair, linear, c=4.0), PairwiseForce(pair, linear, c=1.0)]
    measure = StrainEnergy(pair, laws)
    step(*laws, measure)
    assert pair[force_density].tolist() == [[7.5], [-5.0]]
    assert pair[strain_energy] == pytest.approx(0.5 * 5.0 * 0.25 * 6.0, rel=1e-14)
    assert measure.items() == 2 * 2  # two laws, two directed bonds


def test_bond_that_one_law_breaks_is_broken_for_the_other(pair):
    pair[displacement] = [[0.0], [0.5]]
    step(PairwiseForce(pair, linear, CriticalStretch(0.1), c=4.0), PairwiseForce(pair, linear, c=1.0))
    assert not pair.bonds.intact.any()
    assert pair[force_density].tolist() == [[0.0], [0.0]]


def test_cut_bonds_carry_nothing(pair):
    pair.bonds.cut(rbs.Point(0.5))
    pair[displacement] = [[0.0], [0.5]]
    law = PairwiseForce(pair, linear, c=4.0)
    step(law, StrainEnergy(pair, [law]))
    assert not pair[force_density].any()
    assert pair[strain_energy] == 0.0


class Path(rbs.Boundary):
    """Puts the second node where a list says."""

    updates = (displacement,)

    def __init__(self, part, stops):
        super().__init__(part)
        self.stops = stops

    def apply(self, clock):
        self[displacement][1] = self.stops[clock.step]


def test_energy_of_a_failing_bond(pair):
    """A bond held at 0.09 is pulled to 0.11 and breaks at 0.1: it held ½ c s², and half of its force did the last work.

    Half, because velocity Verlet takes the mean of the forces before and after, and after is none.
    """
    law = PairwiseForce(pair, linear, CriticalStretch(0.1), c=4.0)
    analysis = rbs.Analysis([Path(pair, [0.0, 0.09, 0.11, 0.02, 0.3]), law, FractureDissipation(pair)])
    analysis.run(steps=1, dt=1.0, force_dt=True, progress=False)
    assert pair[dissipation_density].tolist() == [0.0, 0.0]
    analysis.run(steps=2, dt=1.0, force_dt=True, progress=False)
    wanted = 6.0 * (0.5 * 4.0 * 0.09**2 + 0.5 * 4.0 * 0.09 * 0.02)
    assert float(np.sum(pair[dissipation_density] * pair[volume])) == pytest.approx(wanted, rel=1e-12)
    analysis.run(steps=4, dt=1.0, force_dt=True, progress=False)  # counted once
    assert float(np.sum(pair[dissipation_density] * pair[volume])) == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize("stops", [[0.0, 0.09, 0.11], [0.0, 0.05, 0.09, 0.11]])
def test_looking_at_the_energy_does_not_change_what_breaking_costs(pair, stops):
    """Strain energy in front of the force, where the displacement is newer than that of the last force."""
    lost = []
    for look in (True, False):
        pair[intact] = 1
        pair[dissipation_density] = 0.0
        law = PairwiseForce(pair, linear, CriticalStretch(0.1), c=4.0)
        measure = [StrainEnergy(pair, [law])] if look else []
        relations = [Path(pair, stops), *measure, law, FractureDissipation(pair)]
        rbs.Analysis(relations).run(steps=len(stops) - 1, dt=1.0, force_dt=True, progress=False)
        lost.append(pair[dissipation_density].tolist())
    assert lost[0] == lost[1]
    assert min(lost[0]) > 0


def test_release_in_the_next_step(pair):
    """The failing bond pulls until the step is over; that costs the work of half of its force in the step to come.

    0.02 is the way of this step, and what is taken for that of the next.
    """
    law = PairwiseForce(pair, linear, CriticalStretch(0.1, release="next step"), c=4.0)
    analysis = rbs.Analysis([Path(pair, [0.0, 0.09, 0.11, 0.13]), law, FractureDissipation(pair)])
    seen = []
    for steps in (1, 2, 3):
        analysis.run(steps=steps, dt=1.0, force_dt=True, progress=False)
        lost = float(np.sum(pair[dissipation_density] * pair[volume]))
        seen.append((pair.bonds.intact.tolist(), pair[force_density][0, 0], lost))
    assert [holds for holds, _, _ in seen] == [[True, True], [False, False], [False, False]]
    assert [force for _, force, _ in seen] == pytest.approx([0.09 * 12, 0.11 * 12, 0.0], rel=1e-13)
    wanted = 6.0 * (0.5 * 4.0 * 0.11**2 + 0.5 * 4.0 * 0.11 * 0.02)
    assert [lost for _, _, lost in seen] == pytest.approx([0.0, wanted, wanted], rel=1e-12)


def test_broken_bond_may_be_pressed_to_nothing(pair):
    pair.bonds.cut(rbs.Point(0.5))
    pair[displacement] = [[0.0], [-1.0]]
    step(PairwiseForce(pair, linear, c=4.0))
    assert pair[force_density].tolist() == [[0.0], [0.0]]


def test_intact_bond_pressed_to_nothing_is_an_error(pair):
    pair[displacement] = [[0.0], [-1.0]]
    with pytest.raises(NotFinite, match=r"relation 0 .*'force_density' of node 0 at"):
        step(PairwiseForce(pair, linear, c=4.0))


def test_displacement_that_is_not_finite_is_named(pair):
    law = PairwiseForce(pair, linear, c=4.0)
    analysis = step(law)
    pair[displacement][1] = np.nan
    with pytest.raises(NotFinite, match="'displacement' of node 1"):
        analysis.run(steps=2, dt=0.5, force_dt=True, progress=False)


# -- potentials ----------------------------------------------------------------------------------------------------


def kinked(stretch, c, s_y):
    return c * stretch if stretch < s_y else c * s_y


def kinked_energy(stretch, c, s_y):
    return 0.5 * c * stretch**2 if stretch < s_y else c * s_y * (stretch - 0.5 * s_y)


def exponential(stretch, c):
    return c * (exp(stretch) - 1.0)


def of_length(length, reference_length, c):
    return c * log(length / reference_length)


def of_extension(extension, reference_length, c):
    return c * (extension / reference_length) ** 3


@pytest.mark.parametrize("stretch", [-0.6, -0.01, 0.02, 0.5])
@pytest.mark.parametrize(
    ("law", "exact"),
    [
        (linear, lambda s: 2.0 * s**2),
        (hardening, lambda s: 4.0 * (s**2 / 2 + s**4 / 4)),
        (exponential, lambda s: 4.0 * (math.exp(s) - s - 1)),
        (of_length, lambda s: 4.0 * ((1 + s) * math.log1p(s) - s)),
        (of_extension, lambda s: s**4),
    ],
    ids=lambda x: getattr(x, "__name__", None),
)
def test_quadrature_of_smooth_laws_is_exact(pair, law, exact, stretch):
    """Gauss rules with 5 points integrate polynomials of degree 9 exactly; on 8 panels these laws are as good."""
    pair[displacement] = [[0.0], [stretch]]
    force = PairwiseForce(pair, law, c=4.0)
    step(force, StrainEnergy(pair, [force]))
    assert pair[strain_energy] == pytest.approx(6.0 * exact(stretch), rel=1e-9, abs=1e-15)


def test_quadrature_of_a_kink_costs_as_much_as_promised(pair):
    """Up to 1e-3 of the energy, says the docstring: kinks from 5 to 95 % of the way. (And it is not nothing.)"""
    worst = 0.0
    for share in np.linspace(0.05, 0.95, 40):
        force = PairwiseForce(pair, kinked, c=4.0, s_y=0.1 * share)
        pair[displacement] = [[0.0], [0.1]]
        step(force, StrainEnergy(pair, [force]))
        exact = 6.0 * kinked_energy(0.1, 4.0, 0.1 * share)
        worst = max(worst, abs(float(pair[strain_energy]) / exact - 1))
    assert 1e-5 < worst < 1e-3


# -- stable step ---------------------------------------------------------------------------------------------------


def steeper_in_compression(stretch, c):
    return c * stretch if stretch > 0 else 3 * c * stretch


def steeper_in_tension(stretch, c):
    return 3 * c * stretch if stretch > 0 else c * stretch


@pytest.mark.parametrize("steeper", [steeper_in_compression, steeper_in_tension])
def test_stable_step_takes_the_steeper_side_of_a_kink(pair, steeper):
    pair[density] = 1.0
    dt = [rbs.Analysis([PairwiseForce(pair, law, c=4.0)]).stable_dt() for law in (linear, steeper)]
    assert dt[0] / dt[1] == pytest.approx(math.sqrt(3), rel=1e-9)


def test_without_density_there_is_no_say(pair):
    law = PairwiseForce(pair, linear, c=4.0)
    rbs.Analysis([law]).prepare()
    assert law.squared_frequency() is None


# -- what is refused -----------------------------------------------------------------------------------------------


def test_bad_arguments(pair):
    with pytest.raises(BadLaw, match="must be a function"):
        PairwiseForce(pair, 3.0)
    with pytest.raises(BadInput, match="must be a criterion"):
        PairwiseForce(pair, linear, 0.1, c=1.0)
    with pytest.raises(BadInput, match="partial_volume='cubic' must be one of none, linear"):
        PairwiseForce(pair, linear, c=1.0, partial_volume="cubic")
    with pytest.raises(BadLaw, match="asks for 'c'"):
        PairwiseForce(pair, linear)
    with pytest.raises(BadInput, match="nobody asks for k"):
        PairwiseForce(pair, linear, c=1.0, k=2.0)
    with pytest.raises(BadInput, match="no bonds"):
        PairwiseForce(rbs.Part("dots", rbs.Box(size=3.0)).discretize(1.0), linear, c=1.0)
    with pytest.raises(BadLaw, match="law and criterion both have a parameter s0"):
        PairwiseForce(pair, lambda stretch, s0: stretch * s0, CriticalStretch(0.1), s0=0.2)
    with pytest.raises(BadInput, match="does not know how the fracture energy"):
        PairwiseForce(pair, linear, CriticalStretch(fracture_energy=10.0), c=1.0)


def test_field_that_nobody_gives_is_missed(pair):
    """Its default would be silently wrong: a law that asks for a field needs somebody who gives it."""
    with pytest.raises(MissingField, match="reads 'density'"):
        rbs.Analysis([PairwiseForce(pair, lambda stretch, density_i, density_j: stretch)]).prepare()


def test_energy_of_a_law_outside_of_the_scene_is_refused(pair):
    law = PairwiseForce(pair, linear, c=1.0)
    with pytest.raises(BadInput, match="not in the list of relations"):
        step(StrainEnergy(pair, [law]))


def test_law_without_source_runs_all_the_same(pair):
    space = {}
    exec("def helper(x):\n    return 2.0 * x\n\ndef law(stretch, c):\n    return c * helper(stretch)", space)
    pair[displacement] = [[0.0], [0.5]]
    step(PairwiseForce(pair, space["law"], c=4.0))
    assert pair[force_density].tolist() == [[12.0], [-8.0]]


def test_laws_of_one_text_and_other_constants_do_not_share_a_loop(pair):
    def made(k):
        return lambda stretch, c: k * c * stretch

    pair[displacement] = [[0.0], [0.5]]
    for k in (1.0, 2.0):
        step(PairwiseForce(pair, made(k), c=4.0))
        assert pair[force_density].tolist() == [[6.0 * k], [-4.0 * k]]
