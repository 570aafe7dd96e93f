"""Polygons: regions of the plane, and cuts in space."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rbs_core.errors import BadInput
from rbs_core.geometry import Ball, Box, Point, Polygon, Rectangle, RegularPolygon, Triangle
from rbs_core.space import Cartesian, uniform

QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=200)
NUMBERS = st.integers(-16, 16).map(lambda number: number / 10)
SQUARE = [(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)]
L_SHAPE = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)]
TILT = Cartesian((0.3, -0.2, 0.5), [(0.6, 0.0, 0.8), (0.0, 1.0, 0.0), (-0.8, 0.0, 0.6)])
UP, DOWN = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -0.5])


def through(polygon: Polygon, places, mapping: Cartesian | None = None) -> list[bool]:
    """Which bonds straight through places (x, y) of the plane cross."""
    at = np.array([(x, y, 0.0) for x, y in places])
    starts, ends = at + UP, at + DOWN
    if mapping is not None:
        starts, ends = mapping.to_parent(starts), mapping.to_parent(ends)
    return polygon.crosses(starts, ends).tolist()


@pytest.mark.parametrize("mapping", [None, TILT], ids=["flat", "tilted"])
@pytest.mark.parametrize("turn", range(6))
@pytest.mark.parametrize("step", [1, -1])
def test_non_convex_polygon_from_any_corner_in_any_sense(mapping, turn, step):
    corners = np.roll(np.array(L_SHAPE, dtype=float), turn, axis=0)[::step]
    polygon = Polygon(corners if mapping is None else mapping.to_parent(corners))
    inside = [(0.5, 0.5), (1.5, 0.5), (0.5, 1.5), (0.5, 1.0), (1.0, 0.5)]
    border = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2), (1.5, 1.0), (1.0, 1.5), (0.0, 0.7)]
    outside = [(1.5, 1.5), (1.001, 1.001), (-0.001, 0.5), (2.001, 0.5), (0.5, -0.001), (3, 1), (-1, 1), (1.2, 1.1)]
    assert all(through(polygon, inside, mapping))
    assert all(through(polygon, border, mapping))
    assert not any(through(polygon, outside, mapping))


def test_oblique_bonds_and_bonds_that_do_not_reach():
    polygon = Polygon(SQUARE)
    assert polygon.crosses([[0, 0, 1], [0, 0, 2], [3, 0, 1]], [[0, 0, 0.5], [2, 0, -2], [0, 0, -1]]).tolist() == [
        False,
        True,
        False,
    ]


def test_ends_on_the_plane_belong_to_the_side_of_the_normal():
    on, up, down = [[0.2, 0.1, 0.0]], [[0.2, 0.1, 1.0]], [[0.2, 0.1, -1.0]]
    assert Polygon(SQUARE).crosses(on, down).all()
    assert not Polygon(SQUARE).crosses(on, up).any()
    assert Polygon(SQUARE[::-1]).crosses(on, up).all()
    assert not Polygon(SQUARE).crosses(on, [[0.9, 0.9, 0.0]]).any()
    assert not Polygon(SQUARE).crosses([[1.5, 0.1, -1e-10]], [[0.5, 0.1, -1.0]]).any()


@QUIET
@given(
    arrays(float, (6, 3), elements=NUMBERS),
    arrays(float, (6, 3), elements=NUMBERS),
    arrays(float, (3, 3), elements=NUMBERS),
)
def test_a_bond_and_its_reverse_get_the_same_answer(starts, ends, corners):
    if np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0])) < 1e-3:
        return
    polygon = Polygon(corners)
    assert np.array_equal(polygon.crosses(starts, ends), polygon.crosses(ends, starts))


@QUIET
@given(
    arrays(float, (3, 2), elements=NUMBERS),
    arrays(float, (20, 2), elements=st.integers(-2000, 2000).map(lambda number: number / 1000)),
)
def test_triangle_agrees_with_its_half_planes(corners, places):
    edges = np.roll(corners, -1, axis=0) - corners
    area = edges[0, 0] * edges[1, 1] - edges[0, 1] * edges[1, 0]
    if abs(area) < 1e-3:
        return
    polygon = Polygon(np.column_stack([corners, np.zeros(3)]))
    to_place = places[:, None] - corners[None]
    left = np.sign(area) * (edges[:, 0] * to_place[..., 1] - edges[:, 1] * to_place[..., 0])
    left /= np.linalg.norm(edges, axis=1)
    clear = np.abs(left).min(axis=1) > 1e-7
    inside = (left > 0.0).all(axis=1)
    assert np.array_equal(np.array(through(polygon, places))[clear], inside[clear])


def test_symmetric_meshes_are_cut_symmetrically():
    points = uniform((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5), 0.1).points()
    lengths = np.linalg.norm(points[:, None] - points[None], axis=2)
    start, end = np.nonzero((lengths <= 0.2001) & (lengths > 0.0))
    for half in (0.2, 0.25, 0.3):  # edges between nodes and through nodes
        polygon = Polygon(np.array(SQUARE) * half)
        cut = polygon.crosses(points[start], points[end])
        assert cut.any()
        for mirror in ([-1, 1, 1], [1, -1, 1], [1, 1, -1], [-1, -1, -1]):
            assert np.array_equal(polygon.crosses(points[start] * mirror, points[end] * mirror), cut)
        quarter = points[:, [1, 0, 2]] * [-1.0, 1.0, 1.0]
        assert np.array_equal(polygon.crosses(quarter[start], quarter[end]), cut)


@pytest.mark.parametrize("half", [1e-8, 1.0, 100.0])
@pytest.mark.parametrize("mapping", [Cartesian(), Cartesian((0.0, 0.0, 0.0), TILT.axes)], ids=["flat", "tilted"])
def test_the_size_of_a_polygon_does_not_move_it(half, mapping):
    spacing = 1e-9
    points = uniform((-2 * spacing,) * 3, (2 * spacing,) * 3, spacing).points()
    lengths = np.linalg.norm(points[:, None] - points[None], axis=2)
    start, end = np.nonzero((lengths <= 2.001 * spacing) & (lengths > 0.0))
    polygon = Polygon(mapping.to_parent(np.array(SQUARE) * half))
    placed = mapping.to_parent(points)
    cut = polygon.crosses(placed[start], placed[end])
    assert np.array_equal(cut, (points[start, 2] > 0.0) != (points[end, 2] > 0.0))
    assert np.array_equal(polygon.crosses(placed[end], placed[start]), cut)
    # Nodes on it still belong to the side of the normal, and its rim is closed.
    on, up = mapping.to_parent(np.array([[0.3, 0.7, 0.0], [half / 1e-9, 0.0, 0.0]]) * 1e-9), mapping.axes[2] * 2e-9
    assert polygon.crosses(on, on - up).all()
    assert not polygon.crosses(on, on + up).any()


def test_bounds_dimension_and_repr():
    polygon = Polygon([(0, 0, 0), (1, 0, 0), (0, 2, 0)])
    assert np.array_equal(polygon.bounds, [[0.0, 0.0, 0.0], [1.0, 2.0, 0.0]])
    assert polygon.dimension == 3
    assert repr(polygon) == "Polygon(points=((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 2.0, 0.0)))"


def test_in_the_plane_a_polygon_is_a_region():
    polygon = Polygon([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)])
    points = [[0.5, 0.5], [1.5, 1.5], [1.0, 1.5], [2.0, 0.0], [-3.0, -4.0]]
    assert polygon.contains(points).tolist() == [True, False, True, True, False]
    assert polygon.status(points).tolist() == [-1, 1, 0, 0, 1]
    assert polygon.distance(points) == pytest.approx([-0.5, 0.5, 0.0, 0.0, 5.0])
    assert polygon.area == 3.0
    assert np.array_equal(polygon.bounds, [[0.0, 0.0], [2.0, 2.0]])


def test_triangle_rectangle_and_regular_polygon_are_polygons(rng):
    points = rng.uniform(-2.0, 2.0, (2000, 2))
    assert np.array_equal(Rectangle((-1, -1), (2, 0), (0, 2)).contains(points), Box((2.0, 2.0)).contains(points))
    square = RegularPolygon(4, (0, 0), (1, 0))
    assert np.array_equal(square.contains(points), np.abs(points).sum(axis=1) <= 1.0)
    assert square.points.tolist() == [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]
    assert Triangle((0, 0), (2, 0), (0, 2)).area == 2.0
    assert RegularPolygon(6, (0, 0), (1, 0)).area == pytest.approx(1.5 * np.sqrt(3.0))
    many = RegularPolygon(100, (0, 0), (1, 0))
    assert many.distance(points) == pytest.approx(Ball(1.0, (0, 0)).distance(points), abs=1e-3)


def test_in_space_they_cut_like_the_polygon_with_the_same_corners(rng):
    starts, ends = rng.uniform(-1.0, 1.0, (2, 1000, 3))
    rectangle = Rectangle((-0.5, -0.5, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    square = RegularPolygon(4, (0.0, 0.0, 0.0), (0.5, 0.5, 0.0), (0.0, 0.0, 1.0))
    expected = Polygon(np.array(SQUARE) / 2).crosses(starts, ends)
    assert np.array_equal(rectangle.crosses(starts, ends), expected)
    assert np.array_equal(square.crosses(starts, ends), expected)


def test_what_is_coplanar_within_round_off_is_accepted():
    corners = TILT.to_parent(np.array(L_SHAPE, dtype=float)) * 1e-9 + [0.0, 0.0, 1e-8]
    assert Polygon(corners).crosses([corners[0] + 1e-9], [corners[0] - 1e-9]).shape == (1,)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Polygon([(0, 0, 0), (1, 0, 0)]), r"points has shape \(2, 3\); give 3 points or more in 2-D or 3-D"),
        (lambda: Polygon([(0,), (1,), (2,)]), r"points has shape \(3, 1\); give 3 points or more in 2-D or 3-D"),
        (
            lambda: Polygon([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0.1)]),
            r"points\[3\] = \(0.0, 1.0, 0.1\) lies 0.1 m off the plane of the points before it; move it",
        ),
        (
            lambda: Polygon([(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, -0.2), (0, 1, 0)]),
            r"points\[4\] = \(1.0, 1.0, -0.2\) lies 0.2 m off the plane",
        ),
        (
            lambda: Polygon([(0, 0, 0), (1, 1, 1), (2, 2, 2)]),
            r"enclose no area; give corners that do not lie on a line",
        ),
        (
            lambda: Polygon([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 0, 0)]),
            r"points\[0\] = .* repeats points\[3\]; leave it out",
        ),
        (
            lambda: Polygon([(0, 0), (2, 2), (2, 0), (0, 1)]),
            r"the edges points\[0\] to points\[1\] and points\[2\] to points\[3\] cross or touch; give the corners in",
        ),
        (lambda: Polygon([(0, 0), (1, 1), (1, 0), (0, 1)]), r"the edges points\[0\] to points\[1\] and points\[2\]"),
        (lambda: Polygon([(0, 0, 5), (1, 1, 5), (1, 0, 5), (0, 1, 5)]), r"the edges points\[0\] to points\[1\] and"),
        (lambda: Polygon([(0, 0), (1, 0), (2, 0)]), r"enclose no area; give corners that do not lie on a line"),
        (lambda: Triangle((0, 0), (1, 1), (2, 2)), r"enclose no area"),
        (lambda: Triangle((0, 0), (1, 1), (2, 2, 2)), r"c = .* has 3 components; give 2"),
        (
            lambda: Rectangle((0, 0), (1, 0), (1, 1)),
            r"first = .* and second = .* are not at right angles",
        ),
        (lambda: Rectangle((0, 0), (1, 0), (0, 0)), r"second = .* has no length"),
        (lambda: RegularPolygon(2, (0, 0), (1, 0)), r"sides = 2 is no number of edges; give a whole number from 3"),
        (lambda: RegularPolygon(4.5, (0, 0), (1, 0)), r"sides = 4.5 is no number of edges"),
        (lambda: RegularPolygon("many", (0, 0), (1, 0)), r"sides = 'many' does not hold real numbers"),
        (lambda: RegularPolygon(5, (1, 1), (1, 1)), r"corner = center = .*; give a corner away from the center"),
        (lambda: RegularPolygon(5, (0, 0, 0), (1, 0, 0)), r"normal is missing: in 3-D give the direction"),
        (lambda: RegularPolygon(5, (0, 0, 0), (1, 0, 0), (1, 0, 0)), r"corner - center = .* not at right angles"),
        (lambda: RegularPolygon(5, (0, 0), (1, 0), (0, 0, 1)), r"give 2 without a normal, or 3 with one"),
        (lambda: Polygon([(0, 0, 0), (1, 0, 0), (1, 0, 0), (1, 1, 0)]), r"points\[2\] = .* repeats points\[1\]"),
        (lambda: Polygon([(0, 0, 0), (1, 0, 0), (1, np.nan, 0)]), r"points\[2, 1\] = nan is not finite"),
        (
            lambda: Polygon(SQUARE).crosses([[0, 0]], [[1, 1]]),
            r"starts has 2 columns, but Polygon\(.*\) has dimension 3",
        ),
        (lambda: Polygon(SQUARE) | Point(0.0), r"has dimension 3, Point\(x=0.0\) has 1"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
