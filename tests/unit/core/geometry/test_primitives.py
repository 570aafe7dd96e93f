"""Half space, slab, bar, ball: containment, bounds, distance, measured size."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rbs_core.errors import BadInput
from rbs_core.geometry import Ball, Bar, Box, HalfSpace, Slab, Status, Where
from tests.unit.core.geometry.examples import measured

QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=100)
NUMBERS = st.integers(-64, 64).map(lambda number: number / 16)


def vectors(dimension: int):
    return st.lists(NUMBERS, min_size=dimension, max_size=dimension)


@pytest.mark.parametrize(
    ("geometry", "exact", "spacing"),
    [
        (Ball(1.0, 0.3), 2.0, 0.01),
        (Ball(1.0, (0.3, -0.2)), np.pi, 0.02),
        (Ball(1.0, (0.3, -0.2, 0.1)), 4 / 3 * np.pi, 0.08),
        (Box((2.0, 0.7), (0.1, 0.2)) & HalfSpace((0.1, 0.2), (1.0, 1.0)), 0.7, 0.02),
        (Ball(1.0, (0, 0)) - Ball(0.5, (0, 0)), 0.75 * np.pi, 0.02),
        (Ball(1.0, (0, 0)) & HalfSpace((0, 0), (1, 3)), np.pi / 2, 0.02),
        (Box((2.0, 2.0)) & Where(lambda points: points[:, 1] > points[:, 0] ** 2), 4 / 3, 0.02),
    ],
    ids=repr,
)
def test_measured_size_converges_to_the_exact_one(geometry, exact, spacing):
    dimension = geometry.dimension
    coarse, fine = (abs(measured(geometry, h) / exact - 1.0) for h in (spacing * 3.1, spacing))
    assert coarse < 2.0 * dimension * spacing * 3.1
    assert fine < 0.4 * dimension * spacing
    assert measured(geometry, spacing / 3.7) == pytest.approx(exact, rel=0.2 * dimension * spacing)


def test_half_space_holds_the_side_into_which_the_normal_points():
    upper = HalfSpace((0.0, 0.025), normal=(0.0, 3.0))
    assert upper.contains([[5.0, 0.0251], [5.0, 0.025], [5.0, 0.0249]]).tolist() == [True, True, False]
    assert upper.distance([[5.0, 1.025], [5.0, 0.0]]) == pytest.approx([-1.0, 0.025], rel=1e-15)
    assert HalfSpace(1.0, -1.0).contains([[0.0], [1.0], [2.0]]).tolist() == [True, True, False]
    assert HalfSpace(0.0, (1.0, 1.0)).point.tolist() == [0.0, 0.0]


def test_slab():
    slab = Slab(0.5, (1.0, 0.0), (0.0, -2.0))
    assert slab.distance([[9.0, 0.0], [9.0, 0.25], [9.0, -1.0]]).tolist() == [-0.25, 0.0, 0.75]
    assert slab.projection([[9.0, 0.1], [9.0, -3.0]]).tolist() == [[9.0, 0.25], [9.0, -0.25]]
    assert [side.tolist() for side in slab.bounds] == [[-np.inf, -0.25], [np.inf, 0.25]]
    assert np.isinf(Slab(0.5, (1.0, 0.0), (1.0, -2.0)).bounds).all()
    assert [side.tolist() for side in Slab(0.5, 1.0, -3.0).bounds] == [[0.75], [1.25]]


def test_bar():
    bar = Bar(2.0, (1.0, 0.0, 5.0), (0.0, 0.0, 0.1))
    assert bar.distance([[1.0, 0.0, 99.0], [1.0, 3.0, -99.0]]).tolist() == [-2.0, 1.0]
    assert bar.projection([[1.0, 5.0, 7.0]]).tolist() == [[1.0, 2.0, 7.0]]
    assert bar.status([[3.0, 0.0, -7.0], [1.0, 0.0, 0.0], [3.1, 0.0, 0.0]]).tolist() == [0, -1, 1]
    assert [side.tolist() for side in bar.bounds] == [[-1.0, -2.0, -np.inf], [3.0, 2.0, np.inf]]
    strip = Bar(1.0, (0.0, 0.0), (1.0, 1.0))
    assert strip.contains([[5.0, 5.0], [5.0, 6.4], [5.0, 6.5]]).tolist() == [True, True, False]


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e6])
def test_what_counts_as_on_grows_with_the_shape(scale):
    ball = Ball(scale, (0.0, 0.0))
    points = scale * np.array([[1.0 + 1e-10, 0.0], [1.0 - 1e-10, 0.0], [1.0 + 1e-8, 0.0], [1.0 - 1e-8, 0.0]])
    assert ball.status(points).tolist() == [Status.ON, Status.ON, Status.OUTSIDE, Status.INSIDE]
    assert ball.status(points, tolerance=1e-7 * scale).tolist() == [0, 0, 0, 0]
    assert ball.status(points, tolerance=0.0).tolist() == [1, -1, 1, -1]


def test_far_from_the_origin_round_off_counts_as_on():
    ball = Ball(1e-6, (1000.0, 0.0))
    assert ball.status([[1000.0 + 1e-6, 0.0], [1000.0 + 1.01e-6, 0.0], [1000.0, 0.0]]).tolist() == [0, 1, -1]


def test_half_space_bounds():
    assert [side.tolist() for side in HalfSpace((1, 2), (0, 3)).bounds] == [[-np.inf, 2.0], [np.inf, np.inf]]
    assert [side.tolist() for side in HalfSpace((1, 2), (-3, 0)).bounds] == [[-np.inf, -np.inf], [1.0, np.inf]]
    assert np.isinf(HalfSpace((1, 2), (1, 1)).bounds).all()


def test_box_and_ball_are_closed():
    assert Box((2.0, 4.0)).contains([[1.0, 2.0], [-1.0, -2.0], [np.nextafter(1.0, 2.0), 0.0]]).tolist() == [
        True,
        True,
        False,
    ]
    assert Ball(0.5, (0.0, 0.0)).contains([[0.3, 0.4], [0.0, -0.5], [0.0, np.nextafter(0.5, 1.0)]]).tolist() == [
        1,
        1,
        0,
    ]


@QUIET
@given(st.data(), st.integers(1, 3))
def test_distance_is_negative_inside_and_never_grows_faster_than_the_way(data, dimension):
    center = data.draw(vectors(dimension))
    geometry = data.draw(
        st.sampled_from([Ball(1.25, center), Box(1.5, center), HalfSpace(center, [1.0, -2.0, 0.5][:dimension])])
    )
    points = np.array(data.draw(st.lists(vectors(dimension), min_size=2, max_size=8)))
    distance = geometry.distance(points)
    clear = np.abs(distance) > 1e-12
    assert np.array_equal((distance < 0.0)[clear], geometry.contains(points)[clear])
    ways = np.linalg.norm(points[:, None] - points[None], axis=2)
    assert (np.abs(distance[:, None] - distance[None]) <= ways + 1e-12).all()


@QUIET
@given(st.data(), st.integers(1, 3))
def test_all_points_are_within_the_bounds(data, dimension):
    center = data.draw(vectors(dimension))
    points = np.array(data.draw(st.lists(vectors(dimension), min_size=1, max_size=20)))
    for geometry in (Ball(1.5, center), Box(2.0, center), HalfSpace(center, np.eye(3)[0, :dimension])):
        lower, upper = geometry.bounds
        inside = points[geometry.contains(points)]
        assert ((inside >= lower) & (inside <= upper)).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: HalfSpace((0, 0), (0, 0)), r"normal = \(0.0, 0.0\) has no length; give a vector of any length but 0"),
        (lambda: HalfSpace((0, 0), (0, 0, 1)), r"point = \(0.0, 0.0\) has 2 components, normal = .* has 3"),
        (lambda: HalfSpace((0, np.nan), (0, 1)), r"point\[1\] = nan is not finite"),
        (lambda: Slab(0.0, (0, 0), (0, 1)), r"thickness = 0.0 is not positive"),
        (lambda: Slab(1.0, (0, 0), (0, 0)), r"normal = \(0.0, 0.0\) has no length"),
        (lambda: Bar(-1.0, (0, 0), (0, 1)), r"radius = -1.0 is not positive"),
        (lambda: Bar(1.0, (0, 0, 0), (0, 0, 0)), r"axis = \(0.0, 0.0, 0.0\) has no length"),
        (lambda: Bar(1.0, 0.0, 1.0), r"point = \(0.0,\) has 1 component; give 2 or 3"),
        (lambda: Ball(0.0, (0, 0)), r"radius = 0.0 is not positive"),
        (lambda: Ball(np.inf, (0, 0)), r"radius = inf is not finite"),
        (lambda: Ball(1.0, np.zeros((2, 2))), r"center has shape \(2, 2\)"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
