"""The text of a law must compute what the function computes, with whatever the function names."""

from __future__ import annotations

import functools
import math
from math import sqrt

import numba
import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import PairwiseForce
from rbs_plugins.loops import cache
from rbs_plugins.loops.source import answers, definitions, plain

LIMIT = np.float64(0.25)
FLOAT = np.float32(0.5)
COUNT = np.int64(3)
ENDLESS = float("inf")
NOT = float("nan")
SWITCH = True
TABLE = np.array([1.0, 2.0])


def run(function, *arguments, name="law"):
    """Value of the text of a function, run as plain Python."""
    pieces = definitions({name: function})
    assert pieces is not None, "no text"
    space = {"njit": lambda **_: lambda each: each}
    exec(cache.HEAD.replace("from numba import njit", ""), space)
    exec("\n\n".join(pieces), space)
    return space[name](*arguments)


def straight(stretch, c):
    """A docstring, which the text leaves out."""
    return c * stretch


def annotated(stretch: float, c: float = 2.0) -> float:
    force: float = c * stretch
    return force


def with_numbers(stretch, c):
    return min(c * stretch, ENDLESS) * LIMIT + COUNT * FLOAT if SWITCH else NOT


def with_modules(stretch, c):
    return math.exp(stretch) * np.sqrt(c) + sqrt(c) * abs(stretch)


def ramp(x, width=2.0, *, high=COUNT):
    return high * x / width


def with_helpers(stretch, c):
    return ramp(stretch) + ramp(stretch, c) + ramp(stretch, c, high=1.0) + twice(stretch)


def twice(x):
    return 2.0 * once(x)


def once(x):
    return x


def fails(x):
    """Has the name of a function of the loops."""
    return 10.0 * x


def kinematics(x):
    """Has the name of a function of the loops, too."""
    return 0.1 * x


def with_clashing_names(stretch, c):
    return fails(stretch) + kinematics(c)


def with_inner(stretch, c):
    def once(x):  # not the global one
        return x * c

    return once(stretch) + sum([x * c for x in (1.0, 2.0)])


def hidden_by_locals(stretch, c):
    LIMIT = c
    return LIMIT * stretch


def doubled(function):
    """A decorator that passes for what it wraps."""

    @functools.wraps(function)
    def inner(stretch, c):
        return 2.0 * function(stretch, c)

    return inner


@doubled
def decorated(stretch, c):
    return c * stretch


def closed_over(k, shift):
    def law(stretch, c):
        return k * c * stretch + shift

    return law


@numba.njit
def jitted(stretch, c):
    return c * stretch + 1.0


square = lambda stretch, c: c * stretch**2  # noqa: E731
default = lambda stretch, c=LIMIT: c * stretch  # noqa: E731
pair = (lambda stretch, c: c * stretch, lambda stretch, c: c - stretch)


class Rock:
    law = staticmethod(straight)

    @staticmethod
    def softening(stretch, c):
        return c * stretch * (1 - stretch)


@pytest.mark.parametrize(
    "function",
    [
        straight, annotated, with_numbers, with_modules, with_helpers, with_clashing_names, with_inner,
        hidden_by_locals, decorated, closed_over(3.0, 0.5), closed_over(np.float64(1.5), -1), jitted, square, default,
        *pair, Rock.law, Rock.softening,
    ],
    ids=lambda function: function.__name__,
)  # fmt: skip
def test_text_computes_what_the_function_computes(function):
    for stretch, c in ((0.3, 2.0), (-0.7, 5.0)):
        wanted = plain(function)(stretch, c)
        found = run(function, stretch, c)
        assert found == wanted
        assert math.isfinite(found)


def test_functions_may_share_helpers_and_get_their_new_names():
    pieces = definitions({"law": with_helpers, "criterion": twice})
    text = "\n".join(pieces)
    assert text.count("def own_twice(") == 1
    assert "def law(" in text
    assert "def criterion(" in text
    assert text.index("def own_once(") < text.index("def own_twice(") < text.index("def law(")


def test_helper_cannot_replace_a_function_of_the_loops():
    text = "\n".join(definitions({"law": with_clashing_names}))
    assert "def fails(" not in text
    assert "def kinematics(" not in text


def made_by_exec():
    space = {}
    exec("def law(stretch, c):\n    return c * stretch", space)
    return space["law"]


def with_table(stretch, c):
    return TABLE[0] * c * stretch


def with_nobody(stretch, c):
    return nobody * stretch  # noqa: F821


def recursive(stretch, c):
    return recursive(stretch, c - 1) if c > 0 else stretch


def open_ended(*values):
    return values[0]


def with_open_ended(stretch, c):
    return open_ended(stretch, c)


def odd_default(x, table=TABLE):
    return x


def with_odd_default(stretch, c):
    return odd_default(stretch)


@pytest.mark.parametrize(
    "function",
    [made_by_exec(), with_table, with_nobody, recursive, with_open_ended, with_odd_default, math.sin, np.sin],
)
def test_what_no_text_can_say_is_left_to_memory(function):
    assert definitions({"law": function}) is None


def test_two_values_under_one_name_are_left_to_memory():
    assert definitions({"law": closed_over(1.0, 0.0), "criterion": closed_over(2.0, 0.0)}) is None
    assert definitions({"law": closed_over(1.0, 0.0), "criterion": closed_over(1.0, 0.0)}) is not None


def test_lambdas_of_one_line_are_told_apart():
    assert run(pair[0], 0.5, 4.0) == 2.0
    assert run(pair[1], 0.5, 4.0) == 3.5


def test_lambda_that_closes_over_a_number_is_left_to_memory_or_right():
    k = 7.0
    law = lambda stretch, c: k * c * stretch  # noqa: E731
    pieces = definitions({"law": law})
    assert pieces is None or run(law, 0.5, 2.0) == 7.0


def test_plain_is_the_python_function():
    assert plain(jitted) is jitted.py_func
    assert plain(straight) is straight


# -- answers -----------------------------------------------------------------------------------------------------------


def whole(stretch, c):
    if stretch > 0:
        if stretch > 1:
            return 2 * c * stretch
        return c * stretch
    else:  # noqa: RET505  the two branches are what is tested
        return 0.0


def half(stretch, c):  # noqa: RET503  that is the mistake
    if stretch > 0:
        return c * stretch


def silent(stretch, c):
    c * stretch


def test_branches():
    assert answers(whole)
    assert answers(lambda stretch: stretch)
    assert not answers(half)
    assert not answers(silent)


@pytest.mark.parametrize("law", [half, silent])
def test_a_law_without_an_answer_is_named(law):
    bar = rbs.Part("bar", rbs.Box(size=1.0, center=0.0)).discretize(0.1).connect(0.2)
    with pytest.raises(rbs.BadLaw, match=rf"law '{law.__name__}' \(.*\) returns nothing in some branch"):
        PairwiseForce(bar, law, c=1.0)
