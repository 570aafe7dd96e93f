"""Prescribed values: every way to give them, every way to get them wrong."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from rbs_core import BadInput
from rbs_plugins.boundary.values import Values

LINE = np.array([[0.0], [1.0], [3.0]])
PLANE = np.array([[0.0, 0.0], [1.0, 2.0], [3.0, 4.0]])


def at(given, positions, time=2.0):
    """What is prescribed at a time: axis -> list of numbers."""
    return {axis: row.tolist() for axis, row in Values("owner", given, positions).at(time)}


class Ramp:
    """Something that can be called, and is no function."""

    def __init__(self, slope):
        self.slope = slope

    def __call__(self, time):
        return self.slope * time

    def slowly(self, time, positions, factor=1.0):
        return factor * self.slope * time + 0.0 * positions[:, 0]


def components(time, positions):
    return [time, positions[:, 0]]


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        ((1.0, -2), {0: [1.0] * 3, 1: [-2.0] * 3}),
        ([None, 5.0], {1: [5.0] * 3}),
        (np.array([1.0, 2.0]), {0: [1.0] * 3, 1: [2.0] * 3}),
        (([1.0, 2.0, 3.0], None), {0: [1.0, 2.0, 3.0]}),
        ((np.arange(3), 0), {0: [0.0, 1.0, 2.0], 1: [0.0] * 3}),
        ((lambda time: 3 * time, None), {0: [6.0] * 3}),
        ((None, lambda time, positions: time * positions[:, 1]), {1: [0.0, 4.0, 8.0]}),
        ((lambda time: np.arange(3.0) + time, 1.0), {0: [2.0, 3.0, 4.0], 1: [1.0] * 3}),
        (lambda time: (time, None), {0: [2.0] * 3}),
        (components, {0: [2.0] * 3, 1: [0.0, 1.0, 3.0]}),
        (lambda time, positions: time * positions, {0: [0.0, 2.0, 6.0], 1: [0.0, 4.0, 8.0]}),
        (PLANE, {0: [0.0, 1.0, 3.0], 1: [0.0, 2.0, 4.0]}),
    ],
)
def test_in_a_plane(given, wanted):
    assert at(given, PLANE) == wanted


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        (4.0, [4.0] * 3),
        ((4.0,), [4.0] * 3),
        (np.array([1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]),
        (lambda time: time, [2.0] * 3),
        (lambda time: (time,), [2.0] * 3),
        (lambda time, positions: positions[:, 0] - time, [-2.0, -1.0, 1.0]),
        (lambda time, positions: time * positions, [0.0, 2.0, 6.0]),  # a column, as the positions are
        (LINE, [0.0, 1.0, 3.0]),
    ],
)
def test_on_a_line(given, wanted):
    assert at(given, LINE) == {0: wanted}


@pytest.mark.parametrize(
    "function",
    [
        lambda time, factor=3.0: factor * time,
        lambda time, *, factor=3.0: factor * time,
        lambda time, *more, **named: 3.0 * time + len(more) + len(named),
        functools.partial(lambda factor, time: factor * time, 3.0),
        functools.partial(lambda time, factor: factor * time, factor=3.0),
        functools.partial(lambda time, positions, factor: factor * time + 0.0 * positions[:, 0], factor=3.0),
        Ramp(3.0),
        Ramp(3.0).slowly,
    ],
)
def test_only_what_has_no_default_is_given(function):
    assert at((function, None), PLANE) == {0: [6.0] * 3}


class Odd:
    __signature__ = "none"

    def __call__(self, time):
        return time


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (lambda time=0.0: time, "this one takes 0"),
        (lambda *times: 1.0, "this one takes 0"),
        (lambda time, *, factor: factor * time, "this one takes 2: time factor"),
        (functools.partial(lambda time, positions: time, time=1.0), "this one takes 1: positions"),
        (Odd(), "does not tell what it takes"),
    ],
)
def test_functions_that_cannot_be_called(function, words):
    with pytest.raises(BadInput, match=f"owner.*({words})"):
        Values("owner", (function, None), PLANE)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (1.0, "give 2 components"),
        ((1.0, 2.0, 3.0), "give 2 components"),
        ("ab", "component 0 must be a number"),
        ((None, None), "every component is None"),
        (([1.0, 2.0], None), "component 0 must be a number, 3 numbers"),
        ((np.nan, None), "component 0 is nan for the node at"),
        (([0.0, np.inf, 0.0], None), r"component 0 is inf for the node at \[1.0, 2.0\]"),
        ((lambda time: "fast", None), "component 0 at time 0 s must be a number"),
        ((lambda time: np.inf, None), "component 0 at time 0 s is inf"),
        ((lambda: 1.0, None), "takes 0"),
        ((lambda a, b, c: 1.0, None), "takes 3"),
        (lambda time: 1.0, "give 2 components"),
        (lambda time: (1.0, 2.0, 3.0), "give 2 components"),
    ],
)
def test_what_is_refused_at_once(given, words):
    with pytest.raises(BadInput, match=f"owner.*{words}"):
        Values("owner", given, PLANE)


def test_what_goes_wrong_later_names_the_time():
    values = Values("owner", (lambda time: np.log(-1.0) if time > 1 else 0.0, None), PLANE)
    with np.errstate(invalid="ignore"), pytest.raises(BadInput, match="component 0 at time 2 s is nan"):
        values.at(2.0)


def late(time):
    return (1.0, 2.0) if time < 0.5 else (1.0, None)


def test_components_that_come_and_go_are_refused_where_they_must_be_steady():
    values = Values("owner", late, PLANE, steady=True)
    assert [axis for axis, _ in values.at(0.4)] == [0, 1]
    with pytest.raises(BadInput, match=r"owner: prescribes components \[0\] at time 0.75 s, but \[0, 1\] at time 0 s"):
        values.at(0.75)
    assert [axis for axis, _ in Values("owner", late, PLANE).at(0.75)] == [0]


def test_entries_are_numbers_where_numbers_were_given():
    values = Values("owner", ([1.0, 2.0, 3.0], lambda time: np.array([time])), PLANE)
    assert [(axis, value.shape) for axis, value in values.entries(2.0)] == [(0, (3,)), (1, ())]


def digest(given):
    return Values("owner", given, PLANE).digest()


def test_digests_tell_values_apart_and_survive_what_fails():
    assert digest((Ramp(1.0), None)) == digest((Ramp(1.0), None))
    assert digest((Ramp(1.0), None)) != digest((Ramp(2.0), None))
    assert digest((Ramp(1.0), None)) != digest((None, Ramp(1.0)))
    assert digest((1.0, None)) != digest(([1.0, 1.0, 1.0], None))  # as forces they are not the same

    def short(slope):
        def function(time):
            if time > 1e-3:
                raise RuntimeError("only 1 ms was measured")
            return slope * time if time < 1e-3 else np.log(-np.float64(1.0))

        return function

    assert digest((short(1.0), None)) == digest((short(1.0), None))
    assert digest((short(1.0), None)) != digest((short(2.0), None))
