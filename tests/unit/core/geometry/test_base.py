"""What all geometries share: checks of points, operators, repr, equality."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import (
    Ball,
    Box,
    Combined,
    Complement,
    Everywhere,
    Geometry,
    HalfSpace,
    Nowhere,
    Placed,
    Point,
    Polygon,
    Segment,
    Surfaces,
    Where,
)
from rbs_core.geometry.described import no_bounds
from rbs_core.space import world


def above_parabola(points):
    return points[:, 1] > points[:, 0] ** 2


DISK = Ball(1.5, (0.0, 0.5))
SQUARE = Box(2.0, (0.0, 1.0))
DESCRIBED = [
    DISK,
    SQUARE,
    Box((np.inf, 1.0)),
    Box.between((-np.inf, 0.0), (0.0, 1.0)),
    HalfSpace(0.0, (0.0, -2.0)),
    Everywhere(),
    Nowhere(),
    Where(above_parabola),
    Where(above_parabola, dimension=2),
    DISK | SQUARE,
    DISK & ~SQUARE,
    ~(DISK ^ (SQUARE - Nowhere())),
    (~DISK).moved((1.0, -2.0)),
    (DISK - SQUARE).moved((1.0, 0.0)),
    Point(0.25),
    Segment((0.0, 0.0), (1.0, 0.5)),
    Polygon([(0, 0, 0), (1, 0, 0), (0, 1, 0)]),
    Point(0.25) | Point(1.0) | Point(2.0),
]


@pytest.mark.parametrize("thing", DESCRIBED, ids=repr)
def test_repr_can_be_typed_back(thing):
    again = eval(repr(thing))
    assert again == thing
    assert hash(again) == hash(thing)
    assert repr(again) == repr(thing)


def test_equality_is_that_of_the_parameters():
    assert len(set(DESCRIBED)) == len(DESCRIBED)
    unit = Box((1.0, 1.0))
    assert unit == Box.between((-0.5, -0.5), (0.5, 0.5))
    assert unit == Box(1.0, (0, 0))
    assert Ball(1.0, (0, 0)) != Ball(1.0, (0, 0, 0))
    assert Ball(1.0, 0) != 3
    plate = world.child("plate")
    assert DISK.placed(plate) == DISK.placed(plate) != DISK.placed(world.child("plate"))
    assert isinstance(eval(repr(DISK.placed(plate))), Placed)


def test_operators_make_combined_geometries():
    for operation, joined in {
        "union": DISK | SQUARE,
        "intersection": DISK & SQUARE,
        "difference": DISK - SQUARE,
        "symmetric difference": DISK ^ SQUARE,
    }.items():
        assert joined == Combined(operation, DISK, SQUARE)
    assert Complement(DISK) == ~DISK
    assert ~~DISK is DISK
    assert Point(0.0) | Point(1.0) == Surfaces(Point(0.0), Point(1.0))


def test_a_geometry_of_ones_own_needs_four_words():
    class Stripes(Geometry):
        dimension = 1
        bounds = property(lambda self: no_bounds(1))

        def _contains(self, points):
            return np.floor(points[:, 0]) % 2 == 0

        def _parameters(self):
            return {}

    striped = Box.between(0.0, 2.5) & Stripes()
    assert striped.contains([[0.5], [1.5], [2.2], [2.7]]).tolist() == [True, False, True, False]
    assert repr(Stripes()) == "Stripes()"
    with pytest.raises(BadInput, match=r"Stripes\(\) knows no distance"):
        striped.distance([[0.5]])


def test_whole_numbers_and_lists_are_points_too():
    assert SQUARE.contains([[0, 0], [5, 5]]).tolist() == [True, False]
    assert SQUARE.contains(np.zeros((0, 2))).shape == (0,)
    assert SQUARE.contains(np.zeros((2, 2), dtype=np.float32)).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: SQUARE.contains(np.zeros((5, 3))),
            r"points has 3 columns, but Box\(.*\) has dimension 2; give .* \(n, 2\)",
        ),
        (lambda: Ball(1.0, 0.0).distance([[0.0, 0.0]]), r"points has 2 columns, but Ball\(.*\) has dimension 1"),
        (lambda: SQUARE.contains([0.0, 0.0]), r"points has shape \(2,\); give one row per point"),
        (lambda: SQUARE.contains([[0.0, 0.0], [np.nan, 0.0]]), r"points\[1, 0\] = nan is not finite"),
        (
            lambda: DISK | Ball(1.0, (0, 0, 0)),
            r"Ball\(.*\) has dimension 2, Ball\(.*\) has 3; join only what has the same",
        ),
        (lambda: DISK & 3, r"b = 3 is no Geometry"),
        (lambda: DISK - Point(0.0), r"Ball\(.*\) has dimension 2, Point\(x=0.0\) has 1"),
        (lambda: DISK.status([[0.0, 0.0]], tolerance=-1.0), r"tolerance = -1.0 is negative; give a length from 0"),
        (lambda: Point(0.0) | "disk", r"b = 'disk' is no Geometry"),
        (lambda: Complement("box"), r"a = 'box' is no Geometry"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
