"""The Cartesian mapping: there and back, boxes, and axes that cannot be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rbs_core.errors import BadInput
from rbs_core.space.mapping import Cartesian

QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=100)
NUMBERS = st.integers(-1000, 1000).map(lambda number: number / 64)


def rotation(angle: float) -> list[list[float]]:
    return [[np.cos(angle), np.sin(angle), 0.0], [-np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]]


def test_axes_are_where_one_unit_leads():
    mapping = Cartesian((1.0, 2.0, 3.0), [(2.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 0.0, -3.0)])
    own = np.vstack([np.zeros(3), np.eye(3)])
    expected = [[1, 2, 3], [3, 2, 3], [2, 3, 3], [1, 2, 0]]
    assert np.array_equal(mapping.to_parent(own), expected)
    assert np.array_equal(mapping.from_parent(np.array(expected, dtype=float)), own)


@QUIET
@given(
    arrays(float, (3, 3), elements=NUMBERS), arrays(float, (4, 3), elements=NUMBERS), arrays(float, 3, elements=NUMBERS)
)
def test_there_and_back_is_exact_to_round_off(axes, points, origin):
    lengths = np.linalg.norm(axes, axis=1)
    if not lengths.all() or np.linalg.cond(axes) > 1e3:
        return
    mapping = Cartesian(origin, axes)
    parent = mapping.to_parent(points)
    error = np.abs(mapping.from_parent(parent) - points).max()
    size = np.abs(parent).max() + np.abs(origin).max() + np.abs(axes).max() * np.abs(points).max()
    assert error <= 1e-14 * np.linalg.cond(axes) * size / lengths.min() + 1e-300


def test_plain_shift_and_quarter_turn_lose_nothing():
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (100, 3))
    assert np.array_equal(Cartesian().to_parent(points), points)
    turn = Cartesian(axes=[(0.0, 1.0), (-1.0, 0.0)])
    assert np.array_equal(turn.from_parent(turn.to_parent(points)), points)
    assert np.array_equal(turn.to_parent(points), points[:, [1, 0, 2]] * [-1.0, 1.0, 1.0])


def test_a_point_maps_to_the_same_bits_alone_and_among_others():
    points = np.random.default_rng(2).uniform(-1.0, 1.0, (1001, 3))
    mapping = Cartesian((0.1, 0.2, 0.3), rotation(0.7))
    together = mapping.to_parent(points)
    alone = np.vstack([mapping.to_parent(points[i : i + 1]) for i in range(len(points))])
    assert np.array_equal(together, alone)


def test_two_axes_are_completed_by_their_normalised_cross_product():
    mapping = Cartesian(axes=[(0.0, 3.0, 0.0), (0.0, 0.0, 5.0)])
    assert np.array_equal(mapping.axes, [[0, 3, 0], [0, 0, 5], [1, 0, 0]])
    oblique = Cartesian(axes=[(1.0, 0.0), (1.0, 1.0)])
    assert np.allclose(oblique.axes[2], [0, 0, 1], atol=1e-15)


def test_box_around_the_image_is_the_hull_of_the_corners():
    mapping = Cartesian((0.5, -1.0, 2.0), [(1.0, 2.0, 0.0), (-1.0, 1.0, 0.5), (0.0, 0.3, 2.0)])
    lower, upper = np.array([-1.0, 0.0, 2.0]), np.array([1.0, 3.0, 2.5])
    corners = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (0.0, 3.0) for z in (2.0, 2.5)])
    image = mapping.to_parent(corners)
    least, most = mapping.bounds_to_parent(lower, upper)
    assert np.allclose(least, image.min(axis=0), rtol=0, atol=1e-15)
    assert np.allclose(most, image.max(axis=0), rtol=0, atol=1e-15)


def test_box_around_a_slab_is_infinite_only_along_it():
    mapping = Cartesian((1.0, 0.0, 0.0), [(0.0, 1.0), (-1.0, 0.0)])
    least, most = mapping.bounds_to_parent(np.array([-np.inf, -1.0, 0.0]), np.array([np.inf, 2.0, 0.0]))
    assert least.tolist() == [-1.0, -np.inf, 0.0]
    assert most.tolist() == [2.0, np.inf, 0.0]


def test_least_stretch():
    assert Cartesian(axes=rotation(0.3)).least_stretch(2) == 1.0
    assert Cartesian(axes=[(2.0, 0.0), (0.0, 5.0)]).least_stretch(2) == pytest.approx(2.0)
    assert Cartesian(axes=[(2.0, 0.0), (0.0, 5.0)]).least_stretch(3) == pytest.approx(1.0)


def test_repr_can_be_typed_back():
    mapping = Cartesian((1.0, 0.5), [(2.0, 0.0), (0.0, 1.0)])
    again = eval(repr(mapping))
    assert np.array_equal(again.axes, mapping.axes)
    assert np.array_equal(again.origin, mapping.origin)
    assert repr(Cartesian((1.0,))) == "Cartesian(origin=(1.0, 0.0, 0.0))"


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        ([(1, 0, 0)], r"axes has 1 vectors; give 3, or 2"),
        ([(1, 0, 0), (0, 0, 0), (0, 0, 1)], r"axes\[1\] = \(0.0, 0.0, 0.0\) has no length"),
        (
            [(1, 0, 0), (0, 1, 0), (2, 0, 0)],
            r"axes\[0\] = \(1.0, 0.0, 0.0\), axes\[2\] = \(2.0, 0.0, 0.0\) are parallel",
        ),
        (
            [(1, 0, 0), (0, 1, 0), (1, 1, 0)],
            r"axes\[0\].*axes\[1\].*axes\[2\].* lie in one plane; give linearly independent",
        ),
        ([(1, 2), (-2, -4)], r"axes\[0\].*axes\[1\].* are parallel"),
        ([(1, 0, 0), (0, np.nan, 0)], r"axes\[1\]\[1\] = nan is not finite"),
        ([(1, 0, 0), 3.0], r"axes\[1\] has shape \(\); give 3 components"),
    ],
)
def test_bad_axes_are_named(axes, message):
    with pytest.raises(BadInput, match=message):
        Cartesian(axes=axes)
