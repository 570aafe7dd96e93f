"""Directions and coordinates along them."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.geometry.frames import (
    along,
    directions,
    dots,
    lengths,
    parallel,
    perpendicular,
    rows_along,
    square,
    unit,
)


def test_sums_are_those_of_the_textbook(rng):
    a, b, way = rng.normal(size=(50, 3)), rng.normal(size=(50, 3)), np.array([0.6, 0.0, 0.8])
    assert along(a, b[0], way) == pytest.approx((a - b[0]) @ way)
    assert lengths(a) == pytest.approx(np.linalg.norm(a, axis=1))
    assert dots(a, b) == pytest.approx((a * b).sum(axis=1))
    assert rows_along(a[:, 0], way) == pytest.approx(np.outer(a[:, 0], way))


def test_a_point_gets_the_same_bits_in_any_array(rng):
    points, way = rng.normal(size=(101, 3)), unit(np.array([1.0, 2.0, 3.0]))
    whole = along(points, points[0], way)
    assert all(along(points[i : i + 1], points[0], way)[0] == whole[i] for i in range(101))
    assert all(lengths(points[i : i + 1])[0] == lengths(points)[i] for i in range(101))


def test_directions_without_length_are_replaced():
    length, way = directions(np.array([[3.0, 4.0], [0.0, 0.0]]), np.array([0.0, 1.0]))
    assert length.tolist() == [5.0, 0.0]
    assert way.tolist() == [[0.6, 0.8], [0.0, 1.0]]


@pytest.mark.parametrize("vector", [(1.0, 0.0), (0.0, -3.0), (1.0, 2.0), (0.0, 0.0, 1.0), (1.0, 1.0, 1.0)])
def test_perpendicular(vector):
    direction = unit(np.array(vector))
    other = perpendicular(direction)
    assert np.linalg.norm(other) == pytest.approx(1.0)
    assert square(direction, other)
    assert not parallel(direction, other)
    assert parallel(direction, -direction)
    assert not square(direction, unit(direction + other))
