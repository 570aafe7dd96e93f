"""What two single shapes share."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import (
    Ball,
    Bar,
    Box,
    Disk,
    Everywhere,
    HalfSpace,
    Line,
    Nowhere,
    Plane,
    Point,
    Polygon,
    Ray,
    Rectangle,
    Segment,
    Slab,
    Where,
)
from rbs_core.geometry.meeting import intersection
from tests.unit.core.geometry.examples import cloud

X, Y, Z = np.eye(3)
ORIGIN = np.zeros(3)
FLOOR = Plane(ORIGIN, Z)

# Primaries that meet each other in many ways: touching, inside, apart, parallel, square, through.
PRIMARIES = {
    1: [Point(0.5), Plane(0.5, 1.0), HalfSpace(0.25, -1.0), Slab(1.0, 0.0, 1.0), Ball(0.5, 0.0), Box.between(0.5, 2.0)],
    2: [
        Point((0.5, 0.0)),
        Line((0.0, 0.0), (1.0, 0.0)),
        Line((0.0, 0.5), (1.0, 1.0)),
        Ray((0.5, 0.0), (1.0, 0.0)),
        Ray((0.5, 0.0), (-1.0, 0.0)),
        Segment((-0.5, 0.0), (0.25, 0.0)),
        Segment((0.5, -0.5), (0.5, 0.5)),
        Plane((0.0, 0.0), (0.0, 2.0)),
        HalfSpace((0.0, 0.0), (0.0, 1.0)),
        HalfSpace((0.0, 0.5), (0.0, -1.0)),
        HalfSpace((0.5, 0.0), (1.0, 1.0)),
        Slab(1.0, (0.0, 0.0), (0.0, 1.0)),
        Slab(0.5, (0.0, 0.5), (0.0, 1.0)),
        Bar(0.25, (0.0, 0.0), (1.0, 0.0)),
        Ball(0.5, (0.0, 0.0)),
        Ball(0.25, (0.25, 0.0)),
        Ball(0.5, (1.0, 0.0)),
        Box((1.0, 1.0)),
        Box.between((0.5, -0.25), (1.0, 0.25)),
        Box.between((0.0, 0.5), (np.inf, 1.0)),
        Everywhere(),
        Nowhere(),
    ],
    3: [
        Point((0.5, 0.0, 0.0)),
        Line(ORIGIN, X),
        Line((0.0, 0.0, 0.5), X),
        Line(ORIGIN, (1.0, 1.0, 1.0)),
        Ray((0.25, 0.0, 0.0), X),
        Segment((0.0, 0.0, -1.0), (0.0, 0.0, 1.0)),
        Segment((-0.5, 0.0, 0.0), (0.5, 0.0, 0.0)),
        FLOOR,
        Plane((0.0, 0.0, 0.5), Z),
        Plane(ORIGIN, (1.0, 0.0, 1.0)),
        Plane((0.5, 0.0, 0.0), X),
        HalfSpace(ORIGIN, Z),
        HalfSpace((0.0, 0.0, 0.5), -Z),
        Slab(1.0, ORIGIN, Z),
        Slab(0.5, ORIGIN, X),
        Bar(0.5, ORIGIN, Z),
        Bar(0.25, (0.25, 0.0, 0.0), Z),
        Bar(0.5, ORIGIN, X),
        Ball(0.5, ORIGIN),
        Ball(0.25, (0.0, 0.0, 0.75)),
        Ball(0.5, (1.0, 0.0, 0.0)),
        Box((1.0, 1.0, 1.0)),
        Box.between((0.5, -0.25, 0.0), (1.0, 0.25, 0.5)),
        Disk(0.5, ORIGIN, Z),
        Polygon([(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.0, 0.5, 0.0)]),
    ],
}
PAIRS = [pair for shapes in PRIMARIES.values() for pair in combinations(shapes, 2)]


@pytest.mark.parametrize(("a", "b"), PAIRS, ids=repr)
def test_what_two_shapes_share_is_in_both_and_nothing_else_is(a, b):
    shared, reverse = a.intersection(b), b.intersection(a)
    dimension = a.dimension or b.dimension or 2
    points = cloud(Point(np.zeros(dimension)), count=600)
    if not isinstance(shared, Everywhere | Nowhere):  # points of thin results are met by projecting on them
        points = np.vstack([points, shared.projection(points[:100])])
    in_both = (a.status(points, 1e-9) <= 0) & (b.status(points, 1e-9) <= 0)
    if isinstance(shared, Nowhere):
        assert isinstance(reverse, Nowhere)
        return
    assert np.array_equal(shared.status(points, 2e-9) <= 0, in_both)
    assert np.array_equal(reverse.status(points, 2e-9) <= 0, in_both)


# Where no point is shared, or where points are shared and no primary describes them.
EMPTY_OR_NONE = [
    (Ball(0.5, ORIGIN), Ball(0.5, (0.5, 0.0, 0.0))),
    (Ball(0.5, ORIGIN), Ball(0.5, (2.0, 0.0, 0.0))),
    (Bar(0.5, ORIGIN, Z), Bar(0.5, ORIGIN, X)),
    (Bar(0.5, ORIGIN, Z), FLOOR.rotated(0.3, X)),
    (Slab(1.0, ORIGIN, Z), Slab(1.0, ORIGIN, X)),
    (FLOOR, Slab(1.0, ORIGIN, X)),
    (Line(ORIGIN, X), Line((0.0, 0.0, 0.5), Y)),
    (FLOOR, Plane((0.0, 0.0, 0.5), Z)),
    (Box((1.0, 1.0, 1.0)), Ball(0.6, ORIGIN)),
    (Disk(0.5, ORIGIN, Z), Disk(0.5, (0.2, 0.0, 0.0), Z)),
]


@pytest.mark.parametrize(("a", "b"), EMPTY_OR_NONE, ids=repr)
def test_what_is_no_single_shape_is_nowhere(a, b):
    assert a.intersection(b) == b.intersection(a) == Nowhere()


@pytest.mark.parametrize(
    ("a", "b", "shared"),
    [
        (Line(ORIGIN, X), Line(ORIGIN, Y), Point(ORIGIN)),
        (Line(ORIGIN, X), FLOOR, Line(ORIGIN, X)),
        (Line(ORIGIN, Z), FLOOR, Point(ORIGIN)),
        (Line(ORIGIN, X), Ball(0.5, ORIGIN), Segment((-0.5, 0.0, 0.0), (0.5, 0.0, 0.0))),
        (Line((0.0, 0.5, 0.0), X), Ball(0.5, ORIGIN), Point((0.0, 0.5, 0.0))),
        (Line(ORIGIN, X), HalfSpace(ORIGIN, X), Ray(ORIGIN, X)),
        (Line(ORIGIN, X), Slab(1.0, ORIGIN, X), Segment((-0.5, 0.0, 0.0), (0.5, 0.0, 0.0))),
        (Line(ORIGIN, X), Bar(0.5, ORIGIN, X), Line(ORIGIN, X)),
        (Line(ORIGIN, X), Bar(0.5, ORIGIN, Z), Segment((-0.5, 0.0, 0.0), (0.5, 0.0, 0.0))),
        (Segment(ORIGIN, 2 * X), Segment(X, 3 * X), Segment(X, 2 * X)),
        (Segment(ORIGIN, X), Segment(X, 3 * X), Point(X)),
        (Ray(ORIGIN, X), Ray(X, -X), Segment(ORIGIN, X)),
        (FLOOR, Plane(ORIGIN, X), Line(ORIGIN, Y)),
        (FLOOR, Ball(0.5, ORIGIN), Disk(0.5, ORIGIN, Z)),
        (Plane((0.0, 0.0, 0.3), Z), Ball(0.5, ORIGIN), Disk(0.4, (0.0, 0.0, 0.3), Z)),
        (Plane((0.0, 0.0, 0.5), Z), Ball(0.5, ORIGIN), Point((0.0, 0.0, 0.5))),
        (FLOOR, Bar(0.5, ORIGIN, Z), Disk(0.5, ORIGIN, Z)),
        (Plane((0.0, 0.0, 0.5), Z), Bar(0.5, ORIGIN, X), Line((0.0, 0.0, 0.5), X)),
        (FLOOR, HalfSpace(ORIGIN, Z), FLOOR),
        (Slab(1.0, ORIGIN, Z), HalfSpace(ORIGIN, Z), Slab(0.5, (0.0, 0.0, 0.25), Z)),
        (HalfSpace(ORIGIN, Z), HalfSpace(Z, -Z), Slab(1.0, (0.0, 0.0, 0.5), Z)),
        (HalfSpace(ORIGIN, Z), HalfSpace(Z, Z), HalfSpace(Z, Z)),
        (HalfSpace(ORIGIN, Z), HalfSpace(ORIGIN, -Z), FLOOR),
        (Ball(0.5, ORIGIN), Ball(0.1, (0.2, 0.0, 0.0)), Ball(0.1, (0.2, 0.0, 0.0))),
        (Ball(0.5, ORIGIN), Ball(0.5, X), Point((0.5, 0.0, 0.0))),
        (Ball(0.5, ORIGIN), HalfSpace(-Z, Z), Ball(0.5, ORIGIN)),
        (Box((2.0, 2.0)), Box((2.0, 2.0), (1.0, 1.0)), Box.between((0.0, 0.0), (1.0, 1.0))),
        (Box((2.0, 2.0)), Box((2.0, 2.0), (2.0, 0.0)), Segment((1.0, -1.0), (1.0, 1.0))),
        (Box((2.0, 2.0)), Box((2.0, 2.0), (2.0, 2.0)), Point((1.0, 1.0))),
        (Box((2.0, 2.0)), HalfSpace((0.0, 0.0), (0.0, 3.0)), Box.between((-1.0, 0.0), (1.0, 1.0))),
        (Box((2.0, 2.0, 2.0)), Box((2.0, 2.0, 2.0), 2 * X), Rectangle((1, -1, -1), (0, 2, 0), (0, 0, 2))),
        (Ball(0.5, 0.0), Ball(0.5, 0.5), Box.between(0.0, 0.5)),
        (Everywhere(), Ball(0.5, ORIGIN), Ball(0.5, ORIGIN)),
        (Nowhere(), Ball(0.5, ORIGIN), Nowhere()),
        (Point(X), Where(lambda points: points[:, 0] > 0.5), Point(X)),
    ],
    ids=repr,
)
def test_shared_shapes(a, b, shared):
    for found in (a.intersection(b), b.intersection(a), intersection(a, b)):
        assert type(found) is type(shared)
        points = cloud(shared, count=200)
        assert found.status(points).tolist() == shared.status(points).tolist()
        assert np.allclose(found.bounds, shared.bounds, atol=1e-12)


@pytest.mark.parametrize("scale", [1e-9, 1e6])
def test_touching_is_measured_by_the_size(scale):
    a, b = Ball(scale, (0.0, 0.0)), Ball(scale, (2.0 * scale, 0.0))
    assert a.intersection(b) == Point((scale, 0.0))
    assert a.intersection(b.moved((1e-6 * scale, 0.0))) == Nowhere()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: FLOOR.intersection(3), r"other = 3 is no Geometry"),
        (lambda: FLOOR.intersection(Ball(1.0, (0, 0))), r"has dimension 3, Ball.* has 2"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
