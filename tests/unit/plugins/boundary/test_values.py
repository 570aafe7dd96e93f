"""Prescribed values: every way to give them, every way to get them wrong."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core import BadInput
from rbs_plugins.boundary.values import Values

LINE = np.array([[0.0], [1.0], [3.0]])
PLANE = np.array([[0.0, 0.0], [1.0, 2.0], [3.0, 4.0]])


def at(given, positions, time=2.0):
    """What is prescribed at a time: axis -> list of numbers."""
    return {axis: row.tolist() for axis, row in Values("owner", given, positions).at(time)}


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
