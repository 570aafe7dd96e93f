"""Half space, box, ball, everywhere, nowhere, where: containment, bounds, distance, measured size."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rbs_core.errors import BadInput
from rbs_core.geometry import Ball, Box, Everywhere, HalfSpace, Nowhere, Where
from rbs_core.space import uniform

QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=100)
NUMBERS = st.integers(-64, 64).map(lambda number: number / 16)


def vectors(dimension: int):
    return st.lists(NUMBERS, min_size=dimension, max_size=dimension)


def measured(geometry, spacing: float) -> float:
    """Length, area or volume by counting the cells whose middle is in."""
    lower, upper = geometry.bounds
    grid = uniform(lower, upper, spacing)
    return geometry.contains(grid.points()).sum() * grid.cell_volume()


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


def test_box_size_is_exact():
    box = Box.between((0.0, 0.0, -1.0), (0.3, 0.5, 1.0))
    assert measured(box, 0.1) == pytest.approx(0.3, rel=1e-12)


def test_half_space_holds_the_side_into_which_the_normal_points():
    upper = HalfSpace((0.0, 0.025), normal=(0.0, 3.0))
    assert upper.contains([[5.0, 0.0251], [5.0, 0.025], [5.0, 0.0249]]).tolist() == [True, True, False]
    assert upper.distance([[5.0, 1.025], [5.0, 0.0]]) == pytest.approx([-1.0, 0.025], rel=1e-15)
    assert HalfSpace(1.0, -1.0).contains([[0.0], [1.0], [2.0]]).tolist() == [True, True, False]
    assert HalfSpace(0.0, (1.0, 1.0)).point.tolist() == [0.0, 0.0]


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


def test_everywhere_and_nowhere_work_in_any_dimension():
    for dimension in (1, 2, 3):
        points = np.zeros((4, dimension))
        assert Everywhere().contains(points).all()
        assert not Nowhere().contains(points).any()
        assert (Everywhere().distance(points) == -np.inf).all()
        assert (Nowhere().distance(points) == np.inf).all()
    assert Everywhere().dimension is None
    assert Nowhere().dimension is None
    assert np.broadcast_shapes(Everywhere().bounds[0].shape, (3,)) == (3,)


def test_infinite_and_empty_geometries_cannot_be_filled_by_a_grid():
    with pytest.raises(BadInput, match="give a bounded geometry"):
        uniform(*Everywhere().bounds, 0.1)
    with pytest.raises(BadInput, match="the box is empty"):
        uniform(*Nowhere().bounds, 0.1)


def test_where_is_a_plain_function_of_the_points():
    right = Where(lambda points: points[:, 0] > 0.0)
    assert right.contains([[1.0, 0.0], [-1.0, 0.0]]).tolist() == [True, False]
    assert right.dimension is None
    assert (right & Box((1.0, 1.0))).dimension == 2
    assert Where(np.any, dimension=2).bounds[0].shape == (2,)


def test_where_cannot_change_the_points_of_others():
    def careless(points):
        points[:, 0] = 0.0
        return points[:, 0] == 0.0

    with pytest.raises(ValueError, match="read-only"):
        Where(careless).contains(np.ones((2, 2)))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: HalfSpace((0, 0), (0, 0)), r"normal = \(0.0, 0.0\) has no length; give a vector of any length but 0"),
        (lambda: HalfSpace((0, 0), (0, 0, 1)), r"point = \(0.0, 0.0\) has 2 components, normal = .* has 3"),
        (lambda: HalfSpace((0, np.nan), (0, 1)), r"point\[1\] = nan is not finite"),
        (lambda: Box((1.0, 0.0)), r"size\[1\] = 0.0 is not positive"),
        (lambda: Box((1.0, 1.0), (np.inf, 0.0)), r"center\[0\] = inf is not finite; use Box.between"),
        (lambda: Box((1.0, 1.0), (0.0, 0.0, 0.0)), r"size = .* has 2 components, center = .* has 3"),
        (lambda: Box.between((0, 1), (1, 1)), r"upper\[1\] = 1.0 is not above lower\[1\] = 1.0"),
        (lambda: Ball(0.0, (0, 0)), r"radius = 0.0 is not positive"),
        (lambda: Ball(np.inf, (0, 0)), r"radius = inf is not finite"),
        (lambda: Ball(1.0, np.zeros((2, 2))), r"center has shape \(2, 2\)"),
        (lambda: Where(3), r"predicate = 3 cannot be called"),
        (lambda: Where(np.any, dimension=4), r"dimension = 4 is not 1, 2 or 3"),
        (
            lambda: Where(np.any).contains([[1.0], [2.0]]),
            r"returned bool of shape \(\) for 2 points; return .* shape \(2,\)",
        ),
        (lambda: Where(lambda points: points[:, 0]).contains([[1.0]]), r"returned float64 of shape \(1,\)"),
        (lambda: Where(np.any).distance([[1.0]]), r"Where\(.*\) knows no distance"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
