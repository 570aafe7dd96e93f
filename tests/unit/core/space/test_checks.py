"""Numbers from outside: converted, or refused with what, where and cure."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.space.checks import as_number, as_points, as_text, as_vector, as_vectors


@pytest.mark.parametrize(
    ("values", "text"),
    [
        (np.float64(0.5), "0.5"),
        (np.array([1.0, -0.0]), "(1.0, -0.0)"),
        (np.array([[1, 2], [3, 4]]), "((1, 2), (3, 4))"),
        ((1.0,), "(1.0,)"),
        (np.array([-np.inf, np.inf]), "(float('-inf'), float('inf'))"),
    ],
)
def test_text_can_be_typed_back(values, text):
    assert as_text(values) == text
    assert np.array_equal(eval(text), values)


def test_vectors_are_read_only_copies_of_float64():
    given = np.array([1, 2], dtype=np.int32)
    vector = as_vector(given, "center")
    assert vector.dtype == np.float64
    assert not vector.flags.writeable
    given[0] = 7
    assert vector[0] == 1.0
    assert as_vector(3, "center").tolist() == [3.0]


def test_a_number_stands_for_all_components_of_the_other_vector():
    a, b = as_vectors(0.0, (1.0, 2.0, 3.0), ("point", "normal"))
    assert a.tolist() == [0.0, 0.0, 0.0]
    a, b = as_vectors((1.0, 2.0), 5, ("point", "normal"))
    assert b.tolist() == [5.0, 5.0]


def test_points_that_need_no_conversion_are_not_copied():
    points = np.zeros((4, 2))
    assert as_points(points) is points


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: as_number("3 m", "spacing"), r"spacing = '3 m' does not hold real numbers; give numbers"),
        (lambda: as_number(None, "spacing"), r"spacing = None does not hold real numbers"),
        (lambda: as_number(1j, "spacing"), r"spacing = 1j does not hold real numbers"),
        (lambda: as_number([1.0, 2.0], "spacing"), r"spacing has shape \(2,\); give a single number"),
        (lambda: as_number(np.nan, "spacing"), r"^spacing = nan is not finite"),
        (lambda: as_number(-2.0, "spacing", positive=True), r"spacing = -2.0 is not positive; give a number above 0"),
        (lambda: as_vector([1, 2, 3, 4], "center"), r"center has shape \(4,\); give 1, 2 or 3 components"),
        (lambda: as_vector([1, np.inf], "center"), r"center\[1\] = inf is not finite"),
        (lambda: as_vector([np.inf, np.nan], "size", infinite=True), r"size\[1\] = nan is not finite"),
        (
            lambda: as_vectors((1, 2), (1, 2, 3), ("a", "b")),
            r"a = \(1.0, 2.0\) has 2 components, b = .* has 3; give both",
        ),
        (lambda: as_points([1.0, 2.0]), r"points has shape \(2,\); give one row per point.*\[\[x, y\]\]"),
        (lambda: as_points(np.zeros((3, 4))), r"points has shape \(3, 4\)"),
        (lambda: as_points([[0.0, 1.0], [2.0, np.nan]]), r"points\[1, 1\] = nan is not finite"),
        (lambda: as_points([[0.0, 1.0], [2.0]]), r"points is no array .*give every row the same number"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
