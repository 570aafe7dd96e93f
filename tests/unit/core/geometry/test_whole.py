"""All of space, nothing, and what a plain function says."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import Box, Everywhere, Nowhere, Where
from rbs_core.space import uniform


def test_everywhere_and_nowhere_work_in_any_dimension():
    for dimension in (1, 2, 3):
        points = np.zeros((4, dimension))
        assert Everywhere().contains(points).all()
        assert not Nowhere().contains(points).any()
        assert (Everywhere().distance(points) == -np.inf).all()
        assert (Nowhere().distance(points) == np.inf).all()
    assert Everywhere().dimension is None
    assert Nowhere().dimension is None
    assert np.broadcast_shapes(Everywhere().bounds[0].shape, (3,)) == (3,)


def test_infinite_and_empty_geometries_cannot_be_filled_by_a_grid():
    with pytest.raises(BadInput, match="give a bounded geometry"):
        uniform(*Everywhere().bounds, 0.1)
    with pytest.raises(BadInput, match="the box is empty"):
        uniform(*Nowhere().bounds, 0.1)


def test_where_is_a_plain_function_of_the_points():
    right = Where(lambda points: points[:, 0] > 0.0)
    assert right.contains([[1.0, 0.0], [-1.0, 0.0]]).tolist() == [True, False]
    assert right.dimension is None
    assert (right & Box((1.0, 1.0))).dimension == 2
    assert Where(np.any, dimension=2).bounds[0].shape == (2,)


def test_where_cannot_change_the_points_of_others():
    def careless(points):
        points[:, 0] = 0.0
        return points[:, 0] == 0.0

    with pytest.raises(ValueError, match="read-only"):
        Where(careless).contains(np.ones((2, 2)))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Where(3), r"predicate = 3 cannot be called"),
        (lambda: Where(np.any, dimension=4), r"dimension = 4 is not 1, 2 or 3"),
        (
            lambda: Where(np.any).contains([[1.0], [2.0]]),
            r"returned bool of shape \(\) for 2 points; return .* shape \(2,\)",
        ),
        (lambda: Where(lambda points: points[:, 0]).contains([[1.0]]), r"returned float64 of shape \(1,\)"),
        (lambda: Where(np.any).distance([[1.0]]), r"Where\(.*\) knows no distance"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
