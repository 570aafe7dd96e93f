"""Laws that call a library bond after bond are told once, with the cure."""

from __future__ import annotations

import math
import warnings
from math import exp as e_to_the

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import PairwiseForce
from rbs_plugins.functions import exp
from rbs_plugins.loops.slow import slow_calls


@pytest.fixture
def part():
    return rbs.Part("bar", rbs.Box(size=4.0)).discretize(1.0).connect(1.5)


def helper(stretch):
    return np.tanh(stretch)


LAWS = {
    "of a module": (lambda stretch: math.exp(stretch) - 1.0, ["exp"]),
    "by another name": (lambda stretch: e_to_the(stretch) - 1.0, ["exp"]),
    "of numpy": (lambda stretch: np.log(1.0 + stretch), ["log"]),
    "in a helper": (lambda stretch: helper(stretch), ["tanh"]),
    "a power": (lambda stretch: abs(stretch) ** 1.5, ["pow"]),
    "no cure": (lambda stretch: math.sin(stretch), ["sin"]),
    "several": (lambda stretch: math.sin(stretch) + math.exp(stretch), ["sin", "exp"]),
    "quick": (lambda stretch: stretch**3 + abs(stretch) ** 0.5 + stretch**-2 + math.sqrt(abs(stretch)), []),
    "ours": (lambda stretch: exp(stretch) - 1.0, []),
}


@pytest.mark.parametrize("case", LAWS)
def test_which_calls_are_slow(case):
    law, wanted = LAWS[case]
    assert sorted(slow_calls(law)) == sorted(wanted)


def test_the_warning_comes_once_and_names_the_cure(part):
    def law(stretch, c):
        return c * (math.exp(stretch) - 1.0)

    with pytest.warns(UserWarning, match=r"law 'law' .* calls exp, .*`from rbs_plugins.functions import exp`") as seen:
        PairwiseForce(part, law, c=1.0)
    assert seen[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        PairwiseForce(part, law, c=2.0)


def test_without_a_cure_it_says_what_to_try(part):
    with pytest.warns(UserWarning, match=r"calls sin, .* write sin with arithmetic"):
        PairwiseForce(part, lambda stretch, c: c * math.sin(stretch), c=1.0)


def test_quick_laws_are_not_told(part):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        PairwiseForce(part, lambda stretch, c: c * exp(stretch) - c, c=1.0)
