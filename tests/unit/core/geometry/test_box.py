"""Boxes along the axes, and turned ones."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import Box, Cuboid, Rectangle, Transformed
from rbs_core.geometry.box import distance_of_box, nearest_of_box, require_right_angles
from tests.unit.core.geometry.examples import measured


def test_box_size_is_exact():
    box = Box.between((0.0, 0.0, -1.0), (0.3, 0.5, 1.0))
    assert measured(box, 0.1) == pytest.approx(0.3, rel=1e-12)


def test_box_from_size_and_between_corners():
    box = Box(size=2.0, center=(1.0, 2.0))
    assert [corner.tolist() for corner in box.bounds] == [[0.0, 1.0], [2.0, 3.0]]
    assert repr(box) == "Box(size=(2.0, 2.0), center=(1.0, 2.0))"
    assert repr(Box.between(0.0, (1.0, 2.0))) == "Box.between(lower=(0.0, 0.0), upper=(1.0, 2.0))"
    assert Box(3.0).dimension == 1
    slab = Box((np.inf, 1.0))
    assert slab.contains([[1e300, 0.5], [0.0, 0.6]]).tolist() == [True, False]
    assert slab.distance([[7.0, 0.0], [7.0, 2.5]]).tolist() == [-0.5, 2.0]


def test_bounds_can_be_changed_without_changing_the_box():
    box = Box((1.0, 1.0))
    box.bounds[0][0] = 7.0
    assert box == Box((1.0, 1.0))


def test_box_distance():
    box = Box((2.0, 4.0))
    points = [[0.0, 0.0], [0.5, 0.0], [0.0, 1.75], [1.0, 2.0], [4.0, 6.0], [0.0, 3.0]]
    assert box.distance(points).tolist() == [-1.0, -0.5, -0.25, 0.0, 5.0, 1.0]


def test_quarter_turns_and_mirror_images_of_a_box_are_boxes():
    box = Box.between((0.0, 0.0), (2.0, np.inf))
    assert box.rotated(np.pi / 2) == Box.between((-np.inf, 0.0), (0.0, 2.0))
    assert box.mirrored((1.0, 0.0), (1.0, 0.0)) == box
    assert box.scaled(2.0, (1.0, 1.0)) == Box.between((-1.0, -1.0), (3.0, np.inf))
    assert box.moved((1.0, -1.0)) == Box.between((1.0, -1.0), (3.0, np.inf))
    cube = Box((1.0, 2.0, 3.0))
    assert cube.rotated(-np.pi / 2, axis=(0.0, 0.0, 1.0)) == Box((2.0, 1.0, 3.0))


def test_other_turns_of_a_box_have_edges_in_other_directions():
    assert isinstance(Box((2.0, 1.0)).rotated(0.3), Rectangle)
    assert isinstance(Box((2.0, 1.0, 1.0)).rotated(0.3, axis=(1.0, 1.0, 0.0)), Cuboid)
    assert isinstance(Box((np.inf, 1.0)).rotated(0.3), Transformed)
    assert Box((np.inf, 1.0)).rotated(np.pi / 4).contains([[5.0, 5.6], [5.0, 6.0]]).tolist() == [True, False]


def test_cuboid():
    cuboid = Cuboid((0.0, 0.0, 0.0), (3.0, 4.0, 0.0), (-0.8, 0.6, 0.0), (0.0, 0.0, 2.0))
    assert cuboid.contains([[1.5, 2.0, 1.0], [3.0, 4.0, 2.0], [2.3, 2.0, 1.0]]).tolist() == [True, True, False]
    assert cuboid.distance([[1.1, 2.3, 1.0], [1.1, 2.3, 3.5]]) == pytest.approx([-0.5, 1.5])
    assert np.allclose(cuboid.bounds, [[-0.8, 0.0, 0.0], [3.0, 4.6, 2.0]])
    with pytest.raises(
        BadInput, match=r"first = .* and second = .* are not at right angles; give edges that are, or a"
    ):
        Cuboid((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    with pytest.raises(BadInput, match=r"third = \(0.0, 0.0, 0.0\) has no length"):
        Cuboid((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0))
    with pytest.raises(BadInput, match=r"corner = \(0.0, 0.0\) has 2 components; give 3"):
        Cuboid((0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def test_right_angles_may_have_round_off():
    turn = np.array([np.cos(0.1), np.sin(0.1)])
    require_right_angles([1e-9 * turn, 1e9 * np.array([-turn[1], turn[0]])], ("a", "b"), "a Polygon")


def test_distance_and_nearest_points_of_a_box_agree(rng):
    lower, upper = np.array([-1.0, -np.inf, 0.0]), np.array([1.0, 2.0, np.inf])
    points = rng.uniform(-3.0, 3.0, (500, 3))
    away, nearest = distance_of_box(points, lower, upper), nearest_of_box(points, lower, upper)
    assert np.linalg.norm(points - nearest, axis=1) == pytest.approx(np.abs(away), abs=1e-15)
    assert distance_of_box(nearest, lower, upper) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Box((1.0, 0.0)), r"size\[1\] = 0.0 is not positive"),
        (lambda: Box((1.0, 1.0), (np.inf, 0.0)), r"center\[0\] = inf is not finite; use Box.between"),
        (lambda: Box((1.0, 1.0), (0.0, 0.0, 0.0)), r"size = .* has 2 components, center = .* has 3"),
        (lambda: Box.between((0, 1), (1, 1)), r"upper\[1\] = 1.0 is not above lower\[1\] = 1.0"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
