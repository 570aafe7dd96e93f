"""The arithmetic that the loops over a lattice spell, and that they take no more than they need."""

from __future__ import annotations

from decimal import Decimal, getcontext

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins.loops import Loop, Text, lattice_text, roots
from rbs_plugins.loops.arguments import resolve
from rbs_plugins.loops.loop import _parameters
from rbs_plugins.loops.recipe import Recipe

EPSILON = np.finfo(float).eps

ASK = """@njit(error_model='numpy')
def ask(begin, end, thread, xi, eta, found):
    for i in range(begin, end):
        d0, d1, length, stretch, quotient = kinematics(
            xi[i, 0], xi[i, 1], eta[i, 0], eta[i, 1], sqrt(xi[i, 0]**2 + xi[i, 1]**2),
            1.0 / sqrt(xi[i, 0]**2 + xi[i, 1]**2))
        found[i, 0], found[i, 1], found[i, 2], found[i, 3], found[i, 4] = d0, d1, length, stretch, quotient
    return 0
"""


@pytest.fixture(params=roots.WAYS)
def way(request):
    return request.param


def kinematics(xi, eta, way):
    """The columns d0, d1, length, stretch, 1 / length, as the loops compute them."""
    text = Recipe(2, linear, (), roots=way).text(*lattice_text.kinematics(Recipe(2, linear, (), roots=way)), ASK).body
    found = np.zeros((len(xi), 5))
    Loop(Text(text), "ask", {"xi": xi, "eta": eta, "found": found}, len(xi))()
    return found


def exact(xi, eta):
    getcontext().prec = 150
    (x, y), (u, v) = ([Decimal(float(number)) for number in each] for each in (xi, eta))
    size, length = (x * x + y * y).sqrt(), ((x + u) ** 2 + (y + v) ** 2).sqrt()
    return [float(length), float(length / size - 1), float(1 / length)]


@pytest.mark.parametrize("size", [1e-100, 1e-12, 1e-6, 1e-2, 0.5])
def test_small_stretches_keep_their_digits(size, way, rng):
    """A length minus another would lose those that are the same in both."""
    xi = rng.integers(1, 5, (40, 2)) * 1e-3
    eta = size * 1e-3 * rng.uniform(0.1, 1.0, (40, 2))  # along the bond: across it terms of second order cancel
    found = kinematics(xi, eta, way)
    wanted = np.array([exact(*each) for each in zip(xi, eta, strict=True)])
    np.testing.assert_allclose(found[:, [2, 3, 4]], wanted, rtol=12 * EPSILON)
    np.testing.assert_allclose(found[:, :2], xi + eta, rtol=EPSILON)


def test_rest_is_exactly_zero(way, rng):
    xi = np.concatenate([[[1.0, 2.0], [3e-9, 0.0], [-7e5, 1e-3]], rng.normal(size=(100, 2))])
    assert (kinematics(xi, np.zeros_like(xi), way)[:, 3] == 0.0).all()


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e3])
def test_large_stretches_keep_their_digits(size, way, rng):
    """Also bonds that are almost pressed to nothing, and those drawn out to many times their length."""
    xi = rng.integers(1, 5, (40, 2)) * 1e-3
    eta = -xi + size * 1e-3 * rng.uniform(0.1, 1.0, (40, 2))
    found = kinematics(xi, eta, way)
    wanted = np.array([exact(*each) for each in zip(xi, eta, strict=True)])
    # the displacement as a number says where the end is to its last digit only
    np.testing.assert_allclose(found[:, [2, 4]], wanted[:, [0, 2]], rtol=30 * EPSILON * max(1.0, (5 / size) ** 2))
    np.testing.assert_allclose(found[:, 3], wanted[:, 1], rtol=30 * EPSILON * max(1.0, 5 / size))


def test_what_is_no_number_stays_none(way):
    xi = np.ones((3, 2))
    found = kinematics(xi, np.array([[np.nan, 0.0], [0.0, np.inf], [1e200, 1e200]]), way)
    assert not np.isfinite(found[:, 3] * found[:, 4]).any()


def test_both_ends_see_the_same_to_the_bit(way, rng):
    xi, eta = rng.normal(size=(2, 1000, 2))
    ahead, back = kinematics(xi, eta, way), kinematics(-xi, -eta, way)
    assert np.array_equal(ahead[:, 2:], back[:, 2:])
    assert np.array_equal(ahead[:, :2], -back[:, :2])


# -- parameters ----------------------------------------------------------------------------------------------------


def linear(stretch, c):
    return c * stretch


def fails(stretch):
    return stretch > 0.1


def warm(stretch, warmth_j, c):
    return c * stretch * warmth_j


def recipe(law=linear, **options):
    part = rbs.Part("body", rbs.Box(size=3.0)).discretize(1.0).connect(1.5)
    part[rbs.Field("warmth", "node", "scalar", "K", "T", "Made up for these tests.")] = 1.0
    failing = {"criterion": fails, "criterion_arguments": tuple(resolve(fails, part, {})), "intact": True}
    return Recipe(2, law, tuple(resolve(law, part, {"c": 2.0})), **failing, **options).bare


def asked(name, **options):
    return set(_parameters(lattice_text.text(name, recipe(**options)).body, name))


@pytest.mark.parametrize(
    ("options", "more"),
    [
        ({"breakable": True}, {"zone"}),
        ({"fraction": True}, {"volume_fraction"}),
        ({"uniform": False}, {"volume"}),
        ({"law": warm}, {"field_warmth"}),
        ({"late": True}, set()),
        ({"real": "float32"}, set()),
        ({"dissipation": True}, set()),
    ],
)
def test_a_loop_asks_for_what_it_needs(options, more):
    assert asked("force", **options) - asked("force") == more
    assert asked("force") <= asked("force", **options)


def test_only_the_record_asks_for_the_displacement_before():
    every = {name: asked(name, dissipation=True) for name in ("force", "energy", "record", "release", "stiffness")}
    assert [name for name, parameters in every.items() if "before" in parameters] == ["record"]


def test_only_where_bonds_break_each_is_asked_whether_it_may():
    every = {name: asked(name, breakable=True) for name in ("force", "energy", "record", "release", "stiffness")}
    assert [name for name, parameters in every.items() if "zone" in parameters] == ["force", "record", "release"]


def test_bits_are_written_only_where_bonds_break():
    for name in ("force", "energy", "record", "release", "stiffness"):
        body = lattice_text.text(name, recipe(dissipation=True)).body
        assert ("_bits[q] &=" in body) == (name == "release")


def test_the_law_is_asked_once_for_each_bond():
    body = lattice_text.text("force", recipe()).body
    assert body.count("REAL(law(") == 1
    assert body.count("= kinematics(") == 1
