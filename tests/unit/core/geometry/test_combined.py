"""The laws of set algebra, bounds, and distance as a bound."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rbs_core.errors import BadInput
from rbs_core.geometry import (
    Ball,
    Bar,
    Box,
    Capsule,
    Combined,
    Disk,
    Everywhere,
    HalfSpace,
    Nowhere,
    Point,
    Polygon,
    Ring,
    Segment,
    Slab,
    Where,
)
from tests.unit.core.geometry.examples import counting_error

QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=100)
POINTS = np.random.default_rng(4).integers(-8, 9, (200, 2)) / 4  # many of them exactly on surfaces
PLACES = st.tuples(st.integers(-4, 4), st.integers(-4, 4)).map(lambda pair: (pair[0] / 2, pair[1] / 2))
SIZES = st.integers(1, 6).map(lambda number: number / 2)
PRIMITIVES = st.one_of(
    st.builds(Ball, SIZES, PLACES),
    st.builds(Box, SIZES, PLACES),
    st.builds(HalfSpace, PLACES, st.sampled_from([(1, 0), (0, -1), (1, 1), (-1, 2)])),
    st.builds(Slab, SIZES, PLACES, st.sampled_from([(1, 0), (1, 2)])),
    st.builds(Bar, SIZES, PLACES, st.sampled_from([(1, 0), (1, 2)])),
    st.builds(Disk, SIZES, PLACES),
    st.builds(Ring, st.just(2.0), st.sampled_from([0.5, 1.0]), PLACES),
    st.builds(Capsule, SIZES, PLACES, st.just((9.0, 1.0))),
    PLACES.map(lambda place: Polygon(np.add(place, [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]))),
    st.just(Everywhere()),
    st.just(Nowhere()),
)
GEOMETRIES = st.recursive(
    PRIMITIVES,
    lambda some: st.one_of(
        st.builds(
            Combined, st.sampled_from(["union", "intersection", "difference", "symmetric difference"]), some, some
        ),
        some.map(lambda geometry: ~geometry),
        st.builds(lambda geometry, vector: geometry.moved(vector), some, PLACES),
    ),
    max_leaves=5,
)


def same(a, b) -> bool:
    return np.array_equal(a.contains(POINTS), b.contains(POINTS))


@QUIET
@given(GEOMETRIES, GEOMETRIES, GEOMETRIES)
def test_laws_of_set_algebra(a, b, c):
    assert same(~(a | b), ~a & ~b)
    assert same(~(a & b), ~a | ~b)
    assert same(a | b, b | a)
    assert same(a & b, b & a)
    assert same(a ^ b, b ^ a)
    assert same((a | b) | c, a | (b | c))
    assert same((a & b) & c, a & (b & c))
    assert same((a ^ b) ^ c, a ^ (b ^ c))
    assert same(a & (b | c), (a & b) | (a & c))
    assert same(a | (b & c), (a | b) & (a | c))
    assert same(a | (a & b), a)
    assert same(a - b, a & ~b)
    assert same(a ^ b, (a | b) - (a & b))
    assert same(a - (b | c), (a - b) - c)


@QUIET
@given(GEOMETRIES)
def test_laws_with_nothing_and_everything(a):
    assert same(~~a, a)
    assert same(a | Nowhere(), a)
    assert same(a & Everywhere(), a)
    assert same(a & Nowhere(), Nowhere())
    assert same(a | ~a, Everywhere())
    assert same(a - a, Nowhere())
    assert same(a ^ a, Nowhere())
    assert same(a ^ Everywhere(), ~a)


@QUIET
@given(GEOMETRIES)
def test_all_points_are_within_the_bounds(a):
    lower, upper = a.bounds
    assert lower.shape == upper.shape == (a.dimension or 1,)
    inside = POINTS[a.contains(POINTS)]
    assert ((inside >= lower) & (inside <= upper)).all()


@QUIET
@given(GEOMETRIES)
def test_distance_has_the_right_sign_and_is_a_bound(a):
    distance, inside = a.distance(POINTS), a.contains(POINTS)
    clear = np.abs(distance) > 1e-12
    assert np.array_equal((distance < 0.0)[clear], inside[clear])
    # A point on the other side is never nearer than the distance says.
    ways = np.linalg.norm(POINTS[:, None] - POINTS[None], axis=2)
    other_side = inside[:, None] != inside[None]
    nearest = np.where(other_side, ways, np.inf).min(axis=1)
    assert (np.abs(distance) <= nearest + 1e-12).all()


@QUIET
@given(GEOMETRIES)
def test_repr_can_be_typed_back(a):
    assert eval(repr(a)) == a


@QUIET
@given(GEOMETRIES, st.integers(-30, 30).map(lambda number: number / 10), PLACES)
def test_turning_a_whole_is_turning_its_members(a, angle, center):
    turned, points = a.rotated(angle, center=center), np.array(POINTS)
    cosine, sine = np.cos(angle), np.sin(angle)
    images = center + (points - center) @ [[cosine, sine], [-sine, cosine]]
    clear = np.abs(a.distance(points)) > 1e-9
    assert np.array_equal(turned.contains(images)[clear], a.contains(points)[clear])
    with np.errstate(invalid="ignore"):
        difference = turned.distance(images) - a.distance(points)
    assert np.nan_to_num(difference) == pytest.approx(0.0, abs=1e-9)


@QUIET
@given(GEOMETRIES)
def test_status_is_the_sign_of_the_distance_where_that_is_clear(a):
    status, distance = a.status(POINTS), a.distance(POINTS)
    clear = np.abs(distance) > 1e-8
    assert np.array_equal(status[clear], np.sign(distance)[clear])
    assert np.array_equal((~a).status(POINTS), -status)


def test_there_is_no_surface_between_two_boxes_side_by_side():
    a, b = Box.between((0, 0), (1, 1)), Box.between((1, 0), (2, 1))
    points = [[1.0, 0.5], [1.0, 1.0], [1.0, 0.0], [0.0, 0.5], [0.5, 0.5], [1.0, 1.1]]
    assert (a | b).status(points).tolist() == [-1, 0, 0, 0, -1, 1]
    assert (a ^ b).status(points).tolist() == [-1, 0, 0, 0, -1, 1] or (a ^ b).status(points)[0] == 0
    assert (a & b).status(points[4:]).tolist() == [1, 1]


def test_thin_shapes_join_as_well():
    crossing = Combined("intersection", Segment((0, 0), (2, 0)), Segment((1, -1), (1, 1)))
    assert crossing.contains([[1.0, 0.0], [0.5, 0.0]]).tolist() == [True, False]
    assert (Ball(1.0, (0, 0)) - Point((0.0, 0.0))).contains([[0.0, 0.0], [0.1, 0.0]]).tolist() == [False, True]


def test_projection_on_the_edge_of_two_surfaces():
    lens = Ball(1.0, (0.0, 0.0)) & Ball(1.0, (1.0, 0.0))
    tip = np.array([0.5, np.sqrt(0.75)])
    assert lens.projection([[0.5, 3.0]]) == pytest.approx(tip[None], abs=1e-6)
    corner = Box((2.0, 2.0)) - Ball(1.0, (1.0, 1.0))
    assert corner.projection([[0.9, 0.9], [-3.0, 0.0]]) == pytest.approx(
        np.array([1.0 - np.sqrt(0.5), 1.0 - np.sqrt(0.5), -1.0, 0.0]).reshape(2, 2), abs=1e-6
    )


def test_projection_where_both_surfaces_coincide_ends_on_the_whole():
    both = Combined("symmetric difference", Box((1.0, 1.0)), Box((1.0, 1.0), (0.5, 0.0)))
    points = np.random.default_rng(8).uniform(-1.5, 1.5, (60, 2))
    found = both.projection(points)
    assert (both.status(found, 1e-7) == 0).all()
    assert both.projection([[0.3, 1.25]]) == pytest.approx(np.array([[0.5, 0.5]]), abs=1e-6)


def cut_pipe():
    axis, middle = (0, 0, 1), (0, 0, 0)
    pipe = Bar(1.1, middle, axis) - Bar(1.0, middle, axis)
    return pipe - (HalfSpace(middle, (0, 0, -1)) | HalfSpace((0, 0, 1), (0, 3, 4)))


def test_the_cut_pipe_is_where_it_should_be():
    """Figure 3.8 of Jenabidehkordi (2021): between two bars, below z = 1 - 0.75 y."""
    shape = cut_pipe()
    assert np.allclose(shape.bounds, [[-1.1, -1.1, 0.0], [1.1, 1.1, 1.825]], atol=1e-12)
    x, y, z = (points := np.random.default_rng(3).uniform(*shape.bounds, (20000, 3))).T
    radius = np.hypot(x, y)
    expected = (radius >= 1.0) & (radius <= 1.1) & (z >= 0.0) & (z <= 1.0 - 0.75 * y)
    assert np.array_equal(shape.contains(points), expected)
    chosen = [[1.05, 0.0, 0.5], [1.1, 0.0, 0.5], [1.0, 0.0, 0.5], [1.05, 0.0, 1.0], [0.0, 0.0, 0.5]]
    assert shape.status(chosen).tolist() == [-1, 0, 0, 0, 1]


def test_the_volume_of_the_cut_pipe_converges(rng):
    """Its mean height is 1: the slope takes away on one side what it adds on the other."""
    coarse, middle, fine = (counting_error(cut_pipe(), 0.21 * np.pi, spacing, rng) for spacing in (0.1, 0.05, 0.025))
    assert coarse < 0.1
    assert middle < 0.04
    assert fine < 0.02


def test_bounds_of_the_operations():
    a, b = Box.between((0, 0), (2, 2)), Box.between((1, -1), (3, 1))
    assert [side.tolist() for side in (a | b).bounds] == [[0.0, -1.0], [3.0, 2.0]]
    assert [side.tolist() for side in (a ^ b).bounds] == [[0.0, -1.0], [3.0, 2.0]]
    assert [side.tolist() for side in (a & b).bounds] == [[1.0, 0.0], [2.0, 1.0]]
    assert [side.tolist() for side in (a - b).bounds] == [[0.0, 0.0], [2.0, 2.0]]
    assert [side.tolist() for side in (a & ~b).bounds] == [[0.0, 0.0], [2.0, 2.0]]
    assert [side.tolist() for side in (~a).bounds] == [[-np.inf] * 2, [np.inf] * 2]
    assert [side.tolist() for side in (HalfSpace((0, 1), (0, 1)) & a).bounds] == [[0.0, 1.0], [2.0, 2.0]]


def test_bounds_of_what_cannot_overlap_are_empty_and_do_not_widen_a_union():
    a, far = Box.between((0, 0), (1, 1)), Box.between((0, 5), (1, 6))
    assert [side.tolist() for side in (a & far).bounds] == [[np.inf] * 2, [-np.inf] * 2]
    assert [side.tolist() for side in ((a & far) | a).bounds] == [[0.0, 0.0], [1.0, 1.0]]
    assert [side.tolist() for side in (Nowhere() | a).bounds] == [[0.0, 0.0], [1.0, 1.0]]
    assert [side.tolist() for side in (Everywhere() - a).bounds] == [[-np.inf] * 2, [np.inf] * 2]


def test_dimension_comes_from_the_part_that_has_one():
    assert (Everywhere() - Ball(1.0, (0, 0, 0))).dimension == 3
    assert (Nowhere() | Where(np.any)).dimension is None
    assert (~Box((1, 1))).dimension == 2


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Combined("or", Everywhere(), Nowhere()), r"operation = 'or' is unknown; give one of 'union', 'inter"),
        (lambda: Box((1, 1)) ^ Box((1, 1, 1)), r"has dimension 2, Box.* has 3; join only"),
        (lambda: (Box((1, 1)) | Where(np.any)).distance([[0, 0]]), r"Where\(.*\) knows no distance"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
