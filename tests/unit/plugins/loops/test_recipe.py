"""What decides the text of loops, and what can be said about a law without compiling it."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import PairwiseForce
from rbs_plugins.fields import displacement, force_density
from rbs_plugins.loops import lattice_text
from rbs_plugins.loops.arguments import resolve
from rbs_plugins.loops.recipe import Recipe, kinematic_values
from tests.unit.plugins.loops.doubles import STORAGES, assert_close, body

LENGTHS = np.array([1.0, 2.0, 1.0, math.sqrt(2)])


def linear(stretch, c):
    return c * stretch


def kinked(stretch, c):
    return c * stretch if stretch < 0 else 3.0 * c * stretch


def of_lengths(length, reference_length, extension, c):
    return c * ((length - reference_length) / reference_length + extension)


def timed(stretch, time, c):
    return c * stretch * time


def prestressed(stretch, c):
    return c * (stretch + 0.5)


def rooted(stretch, c):
    """Not defined at rest."""
    return c * stretch / math.sqrt(abs(stretch))


def never(stretch):
    return stretch > 0.1


def always(stretch):
    return stretch > -0.1


def recipe(law, criterion=None, **options):
    part = rbs.Part("body", rbs.Box(size=3.0)).discretize(1.0).connect(1.5)
    arguments = tuple(resolve(law, part, {"c": 2.0}))
    others = () if criterion is None else tuple(resolve(criterion, part, {}))
    return Recipe(1, law, arguments, criterion, others, **options)


def test_kinematics_of_a_bond():
    found = kinematic_values(0.25, 2.0)
    assert found == {"stretch": 0.25, "extension": 0.5, "length": 2.5, "reference_length": 2.0}
    assert recipe(of_lengths).force_at(0.25, 2.0) == 2.0 * (0.25 + 0.5)


@pytest.mark.parametrize(
    ("law", "wanted"),
    [
        (linear, [2.0] * 4),
        (kinked, [6.0] * 4),  # the steeper side
        (of_lengths, 2.0 * (1.0 + LENGTHS)),
        (prestressed, [2.0] * 4),
    ],
)
def test_slopes_at_rest(law, wanted):
    np.testing.assert_allclose(recipe(law).slopes(LENGTHS), wanted, rtol=1e-9)  # eps / 1e-6 of a difference


def test_slopes_of_laws_of_fields_are_for_the_loops():
    assert recipe(timed).slopes(LENGTHS) is None


@pytest.mark.parametrize(
    ("law", "criterion", "why"),
    [
        (linear, None, None),
        (linear, never, None),
        (kinked, None, None),
        (of_lengths, None, None),
        (timed, None, "its law depends on more than the bond's own deformation"),
        (prestressed, None, "its law is 1.0 at rest"),
        (linear, always, "its criterion is True at rest"),
    ],
)
def test_why_a_bond_is_never_quiet(law, criterion, why):
    assert recipe(law, criterion).why_never_quiet(LENGTHS) == why


@pytest.mark.parametrize("storage", STORAGES)
def test_a_law_that_is_not_defined_at_rest_may_still_be_used(storage):
    """A lattice must not ask it about bonds at rest where there are none."""
    parts = [body(each, (9, 8)) for each in ("list", storage)]
    for part in parts:
        part[displacement] = 0.01 * part.positions + 0.001 * part.positions**2
        rbs.Analysis([PairwiseForce(part, rooted, c=2.0)]).run(steps=1, dt=0.1, force_dt=True, progress=False)
    one, two = ({"force": part[force_density]} for part in parts)
    assert one["force"].any()
    assert_close(one, two, parts[0])


def test_values_of_parameters_are_not_in_the_text():
    one = recipe(linear)
    two = Recipe(1, linear, tuple(resolve(linear, rbs.Part("a", rbs.Box(size=1.0)).discretize(1.0), {"c": 7.0})))
    assert one != two
    assert one.bare == two.bare
    assert lattice_text.text("force", one.bare) is lattice_text.text("force", two.bare)


def test_a_force_needs_the_arguments_of_the_potential_only_to_record():
    def energy(stretch, g):
        return g * stretch * stretch

    part = rbs.Part("body", rbs.Box(size=3.0)).discretize(1.0).connect(1.5)
    given = {"potential": energy, "potential_arguments": tuple(resolve(energy, part, {"g": 1.0}))}
    plain, recording = recipe(linear, never, **given), recipe(linear, never, dissipation=True, **given)
    assert [a.name for a in plain.of_force] == ["stretch", "c", "stretch"]
    assert [a.name for a in recording.of_force] == ["stretch", "c", "stretch", "stretch", "g"]
    assert [a.name for a in plain.of_energy] == ["stretch", "c", "stretch", "g"]
    assert list(plain.laws) == ["law", "criterion", "potential"]
    assert list(recipe(linear).laws) == ["law"]
