"""Shifts, turns, mirror images, changes of size."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import Ball
from rbs_core.geometry.similarity import Similarity, cosine_and_sine, mirror, rotation, scaling, shift


def test_quarter_turns_are_exact():
    assert [cosine_and_sine(number * np.pi / 2) for number in range(-1, 4)] == [
        (0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)
    ]  # fmt: skip
    assert cosine_and_sine(1e-9)[1] == pytest.approx(1e-9)
    turn = rotation(np.pi / 2, (0.0, 0.0, 2.0), None, 3)
    assert turn.points(np.array([[1.0, 2.0, 3.0]])).tolist() == [[-2.0, 1.0, 3.0]]


def test_a_turn_about_an_axis_leaves_it_where_it_is():
    turn = rotation(0.7, (1.0, 2.0, 2.0), (3.0, 1.0, 0.0), 3)
    axis = np.array([[3.0, 1.0, 0.0]]) + np.outer([0.0, 1.0, -5.0], [1.0, 2.0, 2.0])
    assert turn.points(axis) == pytest.approx(axis, abs=1e-14)


@pytest.mark.parametrize(
    "by",
    [shift((1.0, -2.0)), rotation(0.3, None, (1.0, 2.0), 2), mirror((0.0, 1.0), (1.0, 2.0)), scaling(3.0, None, 2)],
)
def test_back_undoes_it_and_after_does_one_after_the_other(by, rng):
    points = rng.normal(size=(20, 2))
    assert by.back(by.points(points)) == pytest.approx(points, abs=1e-14)
    first = rotation(1.0, None, (0.5, 0.0), 2)
    assert by.after(first).points(points) == pytest.approx(by.points(first.points(points)), abs=1e-14)
    assert by.mirrors == (np.linalg.det(by.turn) < 0.0)


def test_images_of_parameters():
    by = Similarity([[0.0, -1.0], [1.0, 0.0]], 2.0, (1.0, 0.0))
    assert by.image((1.0, 1.0), "point") == (-1.0, 2.0)
    assert by.image(((1.0, 1.0), (0.0, 0.0)), "points") == ((-1.0, 2.0), (1.0, 0.0))
    assert by.image((1.0, 1.0), "vector") == (-2.0, 2.0)
    assert by.image((1.0, 1.0), "direction") == (-1.0, 1.0)
    assert by.image(3.0, "length") == 6.0
    assert by.image(3.0, "number") == 3.0
    assert by.image(None, "direction") is None
    assert by.image(Ball(1.0, (1.0, 1.0)), "geometry") == Ball(2.0, (-1.0, 2.0))
    assert by.image((Ball(1.0, (0.0, 0.0)),), "geometries") == (Ball(2.0, (1.0, 0.0)),)
    assert shift(2.0).image(0.5, "point") == (2.5,)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Similarity([[1.0, 1.0], [0.0, 1.0]], 1.0, (0.0, 0.0)), r"stretches or shears; give an orthogonal"),
        (lambda: Similarity(np.eye(3), 1.0, (0.0, 0.0)), r"turn has shape \(3, 3\), shift has 2 components"),
        (lambda: Similarity(np.eye(2), 0.0, (0.0, 0.0)), r"factor = 0.0 is not positive"),
        (lambda: mirror((0.0, 0.0), (0.0, 0.0)), r"normal = \(0.0, 0.0\) has no length"),
        (lambda: rotation(1.0, None, None, 3), r"axis is missing: in 3-D give the direction"),
        (lambda: rotation(1.0, (0.0, 0.0, 0.0), None, 3), r"axis = \(0.0, 0.0, 0.0\) has no length"),
        (lambda: rotation(1.0, (0.0, 0.0, 1.0), None, 2), r"in 2-D everything turns in the plane; leave the axis out"),
        (lambda: rotation(1.0, None, None, 1), r"nothing turns in 1-D; use mirrored"),
        (lambda: rotation(np.nan, None, None, 2), r"angle = nan is not finite"),
        (lambda: scaling(-1.0, None, 2), r"factor = -1.0 is not positive; give a number above 0"),
        (lambda: scaling(2.0, (0.0,), 2), r"center = \(0.0,\) has 1 components; give 2"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
