"""The projection of one single shape on another."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import (
    Ball,
    Bar,
    Box,
    Circle,
    Cylinder,
    Disk,
    Everywhere,
    HalfSpace,
    Line,
    Nowhere,
    Plane,
    Point,
    Polygon,
    Ray,
    Ring,
    Segment,
    Slab,
)
from rbs_core.geometry.projecting import projection
from tests.unit.core.geometry.examples import cloud

X, Y, Z = np.eye(3)
ORIGIN = np.zeros(3)
FLOOR, TILTED = Plane(ORIGIN, Z), Plane((0.0, 0.0, 1.0), (1.0, 0.0, 1.0))
TRIANGLE = [(0.0, 0.0, 0.0), (1.0, 0.0, 1.0), (0.0, 1.0, 2.0)]


@pytest.mark.parametrize(
    ("a", "on", "image"),
    [
        (Point((1.0, 2.0, 3.0)), FLOOR, Point((1.0, 2.0, 0.0))),
        (Point((2.0, 0.0, 0.0)), Ball(0.5, ORIGIN), Point((0.5, 0.0, 0.0))),
        (Point((2.0, 2.0)), Box((2.0, 2.0)), Point((1.0, 1.0))),
        (Point((1.0, 2.0, 3.0)), Point(X), Point(X)),
        (Ball(0.5, (5.0, 1.0, 0.0)), Point(X), Point(X)),
        (Segment((0.0, 0.0, 1.0), (1.0, 1.0, 2.0)), FLOOR, Segment(ORIGIN, (1.0, 1.0, 0.0))),
        (Segment(ORIGIN, Z), FLOOR, Point(ORIGIN)),
        (Ray((1.0, 0.0, 1.0), (1.0, 0.0, 1.0)), FLOOR, Ray(X, X)),
        (Line((0.0, 1.0, 1.0), (1.0, 0.0, 1.0)), FLOOR, Line(Y, X)),
        (Line((1.0, 1.0, 1.0), Z), FLOOR, Point((1.0, 1.0, 0.0))),
        (Segment((1.0, 5.0), (3.0, 7.0)), Line((0.0, 0.0), (1.0, 0.0)), Segment((1.0, 0.0), (3.0, 0.0))),
        (Segment((1.0, 5.0), (3.0, 7.0)), Plane((0.0, 0.0), (0.0, 1.0)), Segment((1.0, 0.0), (3.0, 0.0))),
        (Segment((1.0, 5.0), (3.0, 7.0)), Ray((2.0, 0.0), (1.0, 0.0)), Segment((2.0, 0.0), (3.0, 0.0))),
        (Segment((1.0, 5.0), (3.0, 7.0)), Segment((5.0, 0.0), (9.0, 0.0)), Point((5.0, 0.0))),
        (Line(Z, X), Line(ORIGIN, Y), Point(ORIGIN)),
        (Line(Z, X), Line(ORIGIN, X), Line(ORIGIN, X)),
        (Ball(0.5, (1.0, 2.0, 3.0)), FLOOR, Disk(0.5, (1.0, 2.0, 0.0), Z)),
        (Ball(0.5, (1.0, 2.0)), Line((0.0, 0.0), (0.0, 1.0)), Segment((0.0, 1.5), (0.0, 2.5))),
        (Bar(0.5, X, Z), FLOOR, Disk(0.5, X, Z)),
        (Bar(0.5, X, Z), Line(ORIGIN, X), Segment((0.5, 0.0, 0.0), (1.5, 0.0, 0.0))),
        (Cylinder(0.5, ORIGIN, 2 * X), Line(ORIGIN, X), Segment(ORIGIN, 2 * X)),
        (Box((2.0, 2.0, 2.0), Z), Line(ORIGIN, Z), Segment(ORIGIN, 2 * Z)),
        (FLOOR, TILTED, TILTED),
        (FLOOR, Plane(X, X), Line(X, Y)),
        (HalfSpace(ORIGIN, (1.0, 0.0, 1.0)), FLOOR, FLOOR),
        (Slab(1.0, ORIGIN, Z), FLOOR, FLOOR),
        (Everywhere(), FLOOR, FLOOR),
        (Polygon(TRIANGLE), FLOOR, Polygon([(0, 0, 0), (1, 0, 0), (0, 1, 0)])),
        (Polygon(TRIANGLE), Plane(X, X), Polygon([(1, 0, 0), (1, 0, 1), (1, 1, 2)])),
        (Disk(0.5, Z, Z), FLOOR, Disk(0.5, ORIGIN, Z)),
        (Ring(0.5, 0.25, Z, Z), FLOOR, Ring(0.5, 0.25, ORIGIN, Z)),
        (Circle(0.5, Z, Z), FLOOR, Circle(0.5, ORIGIN, Z)),
        (Disk(0.5, Z, X), FLOOR, Segment((0.0, -0.5, 0.0), (0.0, 0.5, 0.0))),
    ],
    ids=repr,
)  # fmt: skip
def test_images(a, on, image):
    found = a.projected(on)
    assert type(found) is type(image)
    points = cloud(image, count=200)
    assert found.distance(points) == pytest.approx(image.distance(points), abs=1e-12)
    assert found == projection(a, on)


@pytest.mark.parametrize(
    ("a", "on"),
    [
        (Ball(0.5, ORIGIN), Bar(0.5, 3 * X, Z)),
        (Disk(0.5, ORIGIN, X + Z), FLOOR),  # an ellipse
        (HalfSpace(ORIGIN, X), FLOOR),  # half a plane
        (Bar(0.5, ORIGIN, X), FLOOR),  # a strip
        (Cylinder(0.5, ORIGIN, X), FLOOR),
        (Nowhere(), FLOOR),
        (FLOOR, Everywhere()),
        (Ball(1.0, ORIGIN) - Ball(0.5, ORIGIN), Line(ORIGIN, X)),
    ],
    ids=repr,
)
def test_what_is_no_single_shape_is_nowhere(a, on):
    assert a.projected(on) == Nowhere()


def test_a_point_projects_where_projection_says(rng):
    for on in (Ball(0.5, ORIGIN), Cylinder(0.5, ORIGIN, X), Ball(1.0, ORIGIN) - Ball(0.5, X)):
        point = rng.uniform(-2.0, 2.0, 3)
        assert np.array_equal(Point(point).projected(on).x, on.projection([point])[0])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: FLOOR.projected(3), r"on = 3 is no Geometry"),
        (lambda: FLOOR.projected(Ball(1.0, (0, 0))), r"has dimension 3, Ball.* has 2"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
