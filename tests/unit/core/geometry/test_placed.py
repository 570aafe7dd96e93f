"""Geometries moved by a vector and placed by coordinate systems."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import Ball, Box, Everywhere, HalfSpace, Nowhere, Placed, Slab, Transformed, Where
from rbs_core.space import Cartesian, Mapping, convert, uniform, world
from tests.unit.core.geometry.examples import counting_error

POINTS = np.random.default_rng(5).uniform(-3.0, 3.0, (500, 2))


def turned(angle: float, stretch: tuple[float, float] = (1.0, 1.0)) -> list[list[float]]:
    cosine, sine = np.cos(angle), np.sin(angle)
    return [[stretch[0] * cosine, stretch[0] * sine], [-stretch[1] * sine, stretch[1] * cosine]]


def within_bounds(geometry, points) -> bool:
    lower, upper = geometry.bounds
    inside = points[geometry.contains(points)]
    return bool(((inside >= lower - 1e-12) & (inside <= upper + 1e-12)).all())


def test_moved():
    box = Box((2.0, 2.0)).moved((1.0, 3.0))
    assert np.array_equal(box.contains(POINTS), Box((2.0, 2.0), (1.0, 3.0)).contains(POINTS))
    assert np.allclose(box.distance(POINTS), Box((2.0, 2.0), (1.0, 3.0)).distance(POINTS), atol=1e-15)
    assert [side.tolist() for side in box.bounds] == [[0.0, 2.0], [2.0, 4.0]]
    assert [side.tolist() for side in HalfSpace((0, 0), (0, 1)).moved((1, 2)).bounds] == [[-np.inf, 2.0], [np.inf] * 2]
    assert Everywhere().moved((1.0, 2.0, 3.0)) == Everywhere()


def test_placed_and_turned():
    system = world.child("turned", (1.0, 0.0), turned(np.pi / 6))
    box = Box((2.0, 1.0)).placed(system)
    assert np.array_equal(box.contains(POINTS), Box((2.0, 1.0)).contains(convert(POINTS, world, system)))
    assert np.allclose(box.distance(POINTS), Box((2.0, 1.0)).distance(convert(POINTS, world, system)), rtol=1e-14)
    half = np.array([np.cos(np.pi / 6) + 0.5 * np.sin(np.pi / 6), np.sin(np.pi / 6) + 0.5 * np.cos(np.pi / 6)])
    center = np.array([1.0, 0.0])
    assert np.allclose(box.bounds, [center - half, center + half])
    assert within_bounds(box, POINTS)


def test_ball_under_stretched_axes_is_an_ellipsoid():
    system = world.child("stretched", axes=[(2.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
    ellipsoid = Ball(2.5, (0.0, 0.0, 0.0)).placed(system)
    assert np.array_equal(ellipsoid.bounds, [[-5.0, -2.5, -2.5], [5.0, 2.5, 2.5]])
    assert ellipsoid.contains([[5.0, 0.0, 0.0], [5.1, 0.0, 0.0], [0.0, 2.5, 0.0], [0.0, 2.6, 0.0]]).tolist() == [
        1,
        0,
        1,
        0,
    ]
    grid = uniform(*ellipsoid.bounds, 0.125)
    volume = ellipsoid.contains(grid.points()).sum() * grid.cell_volume()
    assert volume == pytest.approx(4 / 3 * np.pi * 5.0 * 2.5 * 2.5, rel=2e-3)


def test_the_volume_of_an_ellipsoid_converges(rng):
    """Section 3.4.2.3 of Jenabidehkordi (2021): half axes 5, 2.5, 2.5."""
    system = world.child("stretched", axes=[(2.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
    ellipsoid, exact = Ball(2.5, (0.0, 0.0, 0.0)).placed(system), 4 / 3 * np.pi * 5.0 * 2.5 * 2.5
    coarse, middle, fine = (counting_error(ellipsoid, exact, spacing, rng) for spacing in (0.5, 0.25, 0.125))
    assert coarse < 0.02
    assert middle < 0.007
    assert fine < 0.002


def test_distance_under_stretched_axes_is_a_bound():
    system = world.child("stretched", axes=turned(0.4, (2.0, 0.5)))
    ellipse = Ball(1.0, (0.0, 0.0)).placed(system)
    distance, inside = ellipse.distance(POINTS), ellipse.contains(POINTS)
    assert np.array_equal(distance <= 0.0, inside)
    ways = np.linalg.norm(POINTS[:, None] - POINTS[None], axis=2)
    nearest = np.where(inside[:, None] != inside[None], ways, np.inf).min(axis=1)
    assert (np.abs(distance) <= nearest).all()


def test_placed_twice_goes_up_two_systems():
    arm = world.child("arm", (1.0, 1.0), turned(0.3))
    hand = arm.child("hand", (0.5, 0.0), turned(-0.8))
    disk = Box((1.0, 0.5)).placed(hand).placed(arm)
    expected = Box((1.0, 0.5)).contains(convert(POINTS, world, hand))
    assert np.array_equal(disk.contains(POINTS), expected)
    assert within_bounds(disk, POINTS)


def test_mirrored_by_a_reversed_axis():
    triangle = Box((2.0, 2.0)) & HalfSpace((0, 0), (1, 2))
    mirrored = triangle.placed(world.child("mirror", axes=[(-1.0, 0.0), (0.0, 1.0)]))
    assert np.array_equal(mirrored.contains(POINTS), triangle.contains(POINTS * [-1.0, 1.0]))
    assert np.array_equal(mirrored.distance(POINTS), triangle.distance(POINTS * [-1.0, 1.0]))


def test_a_placed_geometry_moves_with_its_system():
    system = world.child("cart")
    disk = Ball(1.0, (0.0, 0.0)).placed(system)
    assert disk.contains([[5.0, 0.0]]).tolist() == [False]
    system.mapping = Cartesian((5.0, 0.0))
    assert disk.contains([[5.0, 0.0]]).tolist() == [True]
    assert np.array_equal(disk.bounds, [[4.0, -1.0], [6.0, 1.0]])


@pytest.mark.parametrize(
    ("start", "stop"),
    [(0.0, 1.0), (-1.0, 1.0), (2.5, 4.0), (-4.0, -2.5), (0.0, 2 * np.pi), (-np.pi, np.pi), (9.0, 10.0)],
)
def test_a_box_in_polar_coordinates_is_a_sector(start, stop):
    """Wherever its angles begin, also across the seam of the angles that points get."""
    system = world.cylindrical("polar", (0.5, -0.5), turned(0.3))
    sector = Box.between((1.0, start), (2.0, stop)).placed(system)
    x, y = (POINTS - [0.5, -0.5]).T
    angle = (np.arctan2(y, x) - 0.3 - start) % (2 * np.pi)
    expected = (np.hypot(x, y) >= 1.0) & (np.hypot(x, y) <= 2.0) & (angle <= stop - start)
    assert np.array_equal(sector.contains(POINTS), expected)
    assert within_bounds(sector, POINTS)
    with pytest.raises(BadInput, match=r"knows no distance: Cylindrical.* keeps no lengths"):
        sector.distance(POINTS)


def test_sharp_bounds_of_sectors_of_tubes_and_shells():
    quarter = Box.between((1.0, 0.0, -1.0), (2.0, np.pi / 2, 3.0)).placed(world.cylindrical("pipe", (5.0, 0.0, 0.0)))
    assert np.allclose(quarter.bounds, [[5.0, 0.0, -1.0], [7.0, 2.0, 3.0]], atol=1e-15)
    cap = Box.between((1.0, 0.0, -np.pi), (2.0, np.pi / 3, np.pi)).placed(world.spherical("globe"))
    side = 2.0 * np.sin(np.pi / 3)
    assert np.allclose(cap.bounds, [[-side, -side, 0.5], [side, side, 2.0]], atol=1e-15)
    assert cap.contains([[0.0, 0.0, 1.5], [0.0, 0.0, -1.5], [1.0, 0.0, 0.5], [1.0, 0.0, 0.6]]).tolist() == [1, 0, 0, 1]


def test_everything_and_nothing_in_curved_coordinates():
    system = world.cylindrical("polar")
    assert Everywhere().placed(system).contains(POINTS).all()
    assert not (Box((1.0, 1.0)) & Box((1.0, 1.0), (9.0, 0.0))).placed(system).contains(POINTS).any()
    assert Box((4.0, np.inf)).placed(system).contains([[-1.9, 0.0], [0.0, 2.1]]).tolist() == [True, False]


def test_bounds_of_the_infinite_and_the_empty():
    system = world.child("turned", (1.0, 0.0), [(0.0, 1.0), (-1.0, 0.0)])
    slab = Box((np.inf, 2.0)).placed(system)
    assert np.array_equal(slab.bounds, [[0.0, -np.inf], [2.0, np.inf]])
    nothing = (Box((1.0, 1.0)) & Box((1.0, 1.0), (9.0, 0.0))).placed(system)
    assert np.array_equal(nothing.bounds, [[np.inf] * 2, [-np.inf] * 2])
    assert np.array_equal(Nowhere().placed(system).bounds, Nowhere().bounds)
    assert np.array_equal(Everywhere().placed(system).bounds, Everywhere().bounds)


class Paraboloid(Mapping):
    """z -> z + x^2 + (y/2)^2."""

    def to_parent(self, points):
        return points + (points[:, :1] ** 2 + points[:, 1:2] ** 2 / 4) * [0.0, 0.0, 1.0]

    def from_parent(self, points):
        return points - (points[:, :1] ** 2 + points[:, 1:2] ** 2 / 4) * [0.0, 0.0, 1.0]


def test_under_a_curved_mapping_bounds_are_infinite_and_distance_is_unknown():
    plate = Box((np.inf, np.inf, 0.04)).placed(world.mapped("paraboloid", Paraboloid()))
    assert plate.contains([[1.0, 2.0, 2.01], [1.0, 2.0, 2.03], [0.0, 0.0, 0.0]]).tolist() == [True, False, True]
    assert np.isinf(plate.bounds).all()
    with pytest.raises(BadInput, match=r"knows no distance: .*Paraboloid.* keeps no lengths"):
        plate.distance([[0.0, 0.0, 0.0]])


def test_the_volume_of_a_paraboloid_plate_converges(rng):
    """The same section; the mapping keeps volumes."""
    plate = Slab(0.04, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)).placed(world.mapped("paraboloid", Paraboloid()))
    piece = plate & Box.between((-0.25, -0.5, -0.05), (0.25, 0.5, 0.2))
    coarse, fine = (counting_error(piece, 0.5 * 1.0 * 0.04, spacing, rng) for spacing in (0.03, 0.009))
    assert coarse < 0.1
    assert fine < 0.02


def test_nodes_of_a_paraboloid_plate_are_those_of_the_flat_one_mapped():
    system = world.mapped("paraboloid", Paraboloid())
    grid = uniform((-2.5, -5.0, -0.02), (2.5, 5.0, 0.02), 0.04)
    points = system.to_parent(grid.points())
    plate = Slab(0.04, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)).placed(system)
    assert plate.contains(points).all()
    assert len(grid) * grid.cell_volume() == pytest.approx(5.0 * 10.0 * 0.04)
    assert points[:, 2].max() == pytest.approx(12.5, rel=0.02)
    assert points[:, 2].min() == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Box((1, 1)).moved((1, 2, 3)), r"vector = .* has 3 components, but Box\(.* has dimension 2; give 2"),
        (lambda: Box((1, 1)).moved((1, np.inf)), r"vector\[1\] = inf is not finite"),
        (lambda: Box((1, 1)).placed(world), r"system 'world' is a root; place the geometry in a child"),
        (lambda: Box((1, 1)).placed("plate"), r"system = 'plate' is no CoordinateSystem; make one by world.child"),
        (lambda: Transformed(3, np.eye(2), 1.0, (1, 2)), r"geometry = 3 is no Geometry"),
        (lambda: Transformed(Box((1, 1)), np.eye(3), 1.0, (1, 2, 3)), r"shift = .* has 3 components, but Box.* give 2"),
        (lambda: Placed(3, world.child("a")), r"geometry = 3 is no Geometry"),
        (
            lambda: Where(np.any).placed(world.child("up", axes=[(1, 0, 0), (0, 0, 1)])).contains([[0.0, 1.0]]),
            r"points\[0\] gets z = .* leaves 2 dimensions; give 3-D points",
        ),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
