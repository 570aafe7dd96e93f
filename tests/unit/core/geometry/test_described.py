"""Texts, equality and checks of what is known by its parameters."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import Ball, Box, Everywhere, Where
from rbs_core.geometry.described import (
    Described,
    as_direction,
    as_place,
    as_smaller,
    common_dimension,
    coordinate_tuple,
    empty_bounds,
    no_bounds,
    require_kind,
    row_tuples,
)


class Pair(Described):
    dimension = 2

    def __init__(self, first, second):
        self.first, self.second = first, second

    def _parameters(self):
        return {"first": self.first, "second": self.second}


def test_parameters_make_text_equality_and_hash():
    assert repr(Pair(np.float64(1.5), (1, 2.0))) == "Pair(first=1.5, second=(1, 2.0))"
    assert repr(Pair(len, float("inf"))) == "Pair(first=len, second=float('inf'))"
    assert Pair(1, 2) == Pair(1.0, 2) != Pair(2, 1)
    assert len({Pair(1, 2), Pair(1, 2), Pair(2, 1)}) == 2
    assert Pair(1, 2) != (1, 2)


def test_the_dimension_of_two_is_that_of_the_one_that_has_one():
    assert common_dimension(Everywhere(), Ball(1.0, 0.0)) == 1
    assert common_dimension(Box((1, 1)), Where(np.any)) == 2
    assert common_dimension(Everywhere(), Everywhere()) is None


def test_bounds_of_all_and_of_nothing():
    assert [side.tolist() for side in no_bounds(2)] == [[-np.inf] * 2, [np.inf] * 2]
    assert [side.tolist() for side in empty_bounds(None)] == [[np.inf], [-np.inf]]


def test_arrays_become_plain_numbers():
    assert coordinate_tuple(np.array([1.0, 2.0])) == (1.0, 2.0)
    assert type(coordinate_tuple(np.array([1.0]))[0]) is float
    assert row_tuples(np.array([[1.0, 2.0], [3.0, 4.0]])) == ((1.0, 2.0), (3.0, 4.0))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: common_dimension(Ball(1.0, 0.0), Box((1, 1))), r"has dimension 1, Box.* has 2; join only"),
        (lambda: require_kind(3, Described, "thing"), r"thing = 3 is no Described; give one of rbs_core.geometry"),
        (lambda: as_place((1, 2), "place", 3), r"place = \(1.0, 2.0\) has 2 components; give 3"),
        (lambda: as_direction((0, 0), "way", 2), r"way = \(0.0, 0.0\) has no length; give a vector of any length but"),
        (lambda: as_smaller(2.0, 1.0, ("inner", "outer")), r"inner = 2.0 is not below outer = 1.0; give the smaller"),
        (lambda: as_smaller(0.0, 1.0, ("inner", "outer")), r"inner = 0.0 is not positive"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
