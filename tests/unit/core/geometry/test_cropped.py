"""Parts of surfaces in regions."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import (
    Ball,
    Circle,
    Cropped,
    Disk,
    HalfSpace,
    Line,
    Plane,
    Point,
    Segment,
    Surfaces,
    TriangulatedSurface,
    Where,
)

UP, DOWN = np.array([0.0, 0.0, 0.5]), np.array([0.0, 0.0, -0.5])
FLOOR = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))


def through(surface, places) -> list[bool]:
    at = np.array([(x, y, 0.0) for x, y in places])
    forth = surface.crosses(at + UP, at + DOWN)
    assert np.array_equal(forth, surface.crosses(at + DOWN, at + UP))
    return forth.tolist()


def test_a_half_plane():
    half = FLOOR & HalfSpace((0, 0, 0), (1, 0, 0))
    assert half == HalfSpace((0, 0, 0), (1, 0, 0)) & FLOOR == Cropped(FLOOR, HalfSpace((0, 0, 0), (1, 0, 0)))
    assert through(half, [(1.0, 0.0), (1e6, 5.0), (0.0, 0.0), (-1e-3, 0.0)]) == [True, True, True, False]
    assert half.distance([[1.0, 0.0, 2.0], [-3.0, 0.0, 0.0]]).tolist() == [2.0, 3.0]


def test_a_plane_in_a_ball_is_a_disk(rng):
    cropped, disk = FLOOR & Ball(1.0, (0.0, 0.0, 0.6)), Disk(0.8, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    starts, ends = rng.uniform(-1.0, 1.0, (2, 2000, 3))
    assert np.array_equal(cropped.crosses(starts, ends), disk.crosses(starts, ends))
    points = rng.uniform(-1.0, 1.0, (60, 3))
    away = np.linalg.norm(points - cropped.projection(points), axis=1)
    assert away == pytest.approx(disk.distance(points), rel=0.05, abs=1e-6)
    assert (cropped.distance(points) <= disk.distance(points) + 1e-12).all()


def test_a_crack_with_a_bridge():
    crack = Segment((-1.0, 0.0), (1.0, 0.0)) - Ball(0.25, (0.0, 0.0))
    at, up = np.array([[-0.5, 0.0], [0.0, 0.0], [0.24, 0.0], [0.26, 0.0]]), np.array([0.0, 1.0])
    assert crack.crosses(at + up, at - up).tolist() == [True, False, False, True]
    assert [side.tolist() for side in crack.bounds] == [[-1.0, 0.0], [1.0, 0.0]]


def test_several_surfaces_are_cropped_one_by_one():
    both = (Segment((0, 0), (1, 0)) | Segment((0, 1), (1, 1))) & Ball(0.5, (0, 0))
    assert isinstance(both, Surfaces)
    assert both.crosses([[0.2, 0.1], [0.2, 1.1]], [[0.2, -0.1], [0.2, 0.9]]).tolist() == [True, False]


def test_regions_without_distance_crop_as_well():
    cut = Line((0, 0), (1, 0)) & Where(lambda points: points[:, 0] > 0.5)
    assert cut.crosses([[0.6, 1.0], [0.4, 1.0]], [[0.6, -1.0], [0.4, -1.0]]).tolist() == [True, False]


def test_bounds_are_those_that_the_region_leaves():
    assert [side.tolist() for side in (FLOOR & Ball(1.0, (0, 0, 0))).bounds] == [[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]


def crossed(surface, dimension: int):
    return surface.crosses(np.full((1, dimension), -9.0), np.full((1, dimension), 9.0))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Cropped(Ball(1.0, (0, 0)), Ball(1.0, (0, 0))), r"surface = Ball\(.*\) is no Surface"),
        (lambda: Cropped(FLOOR, 3), r"region = 3 is no Geometry"),
        (lambda: FLOOR & Ball(1.0, (0, 0)), r"has dimension 3, Ball.* has 2"),
        (lambda: Cropped(Point(0.0) | Point(1.0), Ball(1.0, 0.0)), r"is several; crop them one by one"),
        (
            lambda: crossed(Circle(1.0, (0, 0)) & Ball(1.0, (1, 0)), 2),
            r"Circle\(.*\) lies in no plane, so no region can crop it; cut with the whole of it",
        ),
        (
            lambda: crossed(TriangulatedSurface(np.eye(3), [(0, 1, 2)]) & Ball(9.0, (0, 0, 0)), 3),
            r"lies in no plane, so no region can crop it",
        ),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
