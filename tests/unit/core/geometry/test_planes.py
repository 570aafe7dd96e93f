"""Points and planes, and what a half space leaves of a box."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import HalfSpace, Plane, Point
from rbs_core.geometry.planes import left_by


def test_point():
    point = Point((1.0, 2.0, 3.0))
    assert point.distance([[1.0, 2.0, 5.0]]).tolist() == [2.0]
    assert point.contains([[1.0, 2.0, 3.0], [1.0, 2.0, 3.001]]).tolist() == [True, False]
    assert point.projection([[9.0, 9.0, 9.0]]).tolist() == [[1.0, 2.0, 3.0]]
    assert np.array_equal(point.bounds, [[1.0, 2.0, 3.0]] * 2)
    assert repr(Point(0.5)) == "Point(x=0.5)"


def test_plane():
    plane = Plane((0.0, 0.0, 1.0), (0.0, 0.0, -2.0))
    assert plane.distance([[5.0, 5.0, 3.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]).tolist() == [2.0, 0.0, 1.0]
    assert plane.projection([[5.0, 6.0, 3.0]]).tolist() == [[5.0, 6.0, 1.0]]
    assert plane.status([[5.0, 6.0, 1.0], [0.0, 0.0, 0.0]]).tolist() == [0, 1]
    assert np.array_equal(plane.bounds, [[-np.inf, -np.inf, 1.0], [np.inf, np.inf, 1.0]])


def test_a_plane_cuts_without_end_and_its_positive_side_is_that_of_the_normal():
    plane = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    assert plane.crosses([[1e9, -1e9, 1.0]], [[1e9, -1e9, -1.0]]).all()
    assert plane.crosses([[0.0, 0.0, 0.0]], [[0.0, 0.0, -1.0]]).all()
    assert not plane.crosses([[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]]).any()
    assert Plane(0.5, 1.0).crosses([[0.0]], [[1.0]]).all()


def test_plane_through_points():
    plane = Plane.through((0, 0, 1), (1, 0, 1), (0, 1, 1))
    assert plane.normal.tolist() == [0.0, 0.0, 1.0]
    assert Plane.through((0, 0), (1, 0)).normal.tolist() == [0.0, 1.0]
    points = np.array([(1.0, 2.0, 0.5), (0.0, 1.0, 3.0), (2.0, 2.0, 2.0)])
    assert Plane.through(*points).distance(points) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("normal", [(1.0, 2.0), (-1.0, 3.0), (0.0, -1.0), (1.0, 0.0)])
def test_bounds_of_what_a_half_space_leaves_of_a_box(normal, rng):
    box = np.array([-1.0, -2.0]), np.array([1.0, 3.0])
    lower, upper = left_by(*box, np.array([0.3, 0.4]), np.array(normal))
    points = rng.uniform(*box, (20000, 2))
    inside = points[HalfSpace((0.3, 0.4), normal).contains(points)]
    assert np.allclose(lower, inside.min(axis=0), atol=0.05)
    assert np.allclose(upper, inside.max(axis=0), atol=0.05)
    assert (lower <= inside.min(axis=0)).all()
    assert (upper >= inside.max(axis=0)).all()


def test_a_half_space_leaves_infinite_boxes_infinite_where_it_must():
    lower, upper = left_by(np.array([0.0, -np.inf]), np.array([1.0, np.inf]), np.zeros(2), np.array([1.0, 1.0]))
    assert lower.tolist() == [0.0, -1.0]
    assert upper.tolist() == [1.0, np.inf]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Plane((0, 0, 0), (0, 0, 0)), r"normal = .* has no length"),
        (lambda: Plane((0, 0, 0), (0, 1)), r"point = .* has 3 components, normal = .* has 2"),
        (lambda: Plane.through((0, 0, 0), (1, 1, 1), (2, 2, 2)), r"lie on a line; give points that tell a plane"),
        (lambda: Plane.through((0, 0), (0, 0)), r"points\[0\] = points\[1\] = \(0.0, 0.0\); give two different points"),
        (lambda: Plane.through((0, 0, 0)), r"1 points; give three points in 3-D, or two in 2-D"),
        (lambda: Plane.through((0, 0, 0), (1, 0, 0), (0, 1)), r"points\[2\] = .* has 2 components; give 3"),
        (lambda: Point((1, 2, 3, 4)), r"x has shape \(4,\)"),
        (lambda: Point(np.inf), r"x\[0\] = inf is not finite"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
