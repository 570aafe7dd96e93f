"""Influence functions: values by hand, no dimension, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins.constitutive.influence import FUNCTIONS, influences


@pytest.mark.parametrize("name", FUNCTIONS)
def test_no_function_depends_on_the_unit_of_length(name):
    lengths = np.array([0.35, 0.4, 0.7, 1.0])
    metres = influences(name, lengths, 1.0, 0.1, "test")
    millimetres = influences(name, 1e3 * lengths, 1e3, 100.0, "test")
    np.testing.assert_allclose(millimetres, metres, rtol=1e-12)
    assert (metres >= 0).all()


def test_values_by_hand():
    at = {name: influences(name, np.array([0.8]), 2.0, 0.4, "test")[0] for name in FUNCTIONS}
    expected = {
        "constant": 1.0, "gaussian": np.exp(-0.16), "linear": 0.4, "conical": 0.6, "inverse": 2.5,
        "inverse_fourth": 2.5**4, "hyperbolic": 2 / 1.4, "double_hyperbolic": 5.0, "exponential": np.exp(2 / 0.3),
        "cubic_spline": 1 - 6 * 0.16 + 6 * 0.064,
    }  # fmt: skip
    assert at == pytest.approx(expected, rel=1e-14)
    assert influences("cubic_spline", np.array([1.5, 2.0]), 2.0, None, "test") == pytest.approx([2 / 64, 0.0])


def test_a_function_of_ones_own_may_have_branches():
    def steps(reference_length, horizon):
        return 1.0 if reference_length < 0.5 * horizon else 0.25

    np.testing.assert_array_equal(influences(steps, np.array([0.1, 0.9, 0.1]), 1.0, None, "test"), [1, 0.25, 1])


def test_refusals():
    with pytest.raises(rbs.BadLaw, match="must be a function, or one of constant"):
        influences("bell", np.ones(1), 1.0, None, "test")
    with pytest.raises(rbs.BadLaw, match="must take reference_length"):
        influences(lambda r: r, np.ones(1), 1.0, None, "test")
    with pytest.raises(rbs.BadInput, match=r"needs the spacing"):
        influences("hyperbolic", np.ones(1), 1.0, None, "test")
    with pytest.raises(rbs.BadInput, match=r"of a bond of length 0.5 is inf: it must be finite"):
        influences("double_hyperbolic", np.array([0.5]), 1.0, None, "test")
    with pytest.raises(rbs.BadInput, match=r"not negative"):
        influences(lambda reference_length: -1.0, np.ones(1), 1.0, None, "test")
