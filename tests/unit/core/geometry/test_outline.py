"""Closed outlines: inside, distance, crossings."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rbs_core.geometry.outline import covered_by, distance_of, edges_of, first_crossing, inside_of, nearest_of

QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=100)
L_SHAPE = np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], dtype=float)


def test_edges_close_the_outline():
    assert [(start.tolist(), end.tolist()) for start, end in edges_of(L_SHAPE[:3])] == [
        ([0, 0], [2, 0]), ([2, 0], [2, 1]), ([2, 1], [0, 0])
    ]  # fmt: skip


def test_inside_and_distance():
    x, y = np.array([0.5, 1.5, 1.5, -1.0, 1.0]), np.array([0.5, 1.5, 0.5, -1.0, 1.5])
    assert inside_of(L_SHAPE, x[:4], y[:4]).tolist() == [True, False, True, False]
    assert distance_of(L_SHAPE, x, y) == pytest.approx([-0.5, 0.5, -0.5, np.sqrt(2.0), 0.0])
    away, nearest_x, nearest_y = nearest_of(L_SHAPE, x[1:2], y[1:2] + 2.0)
    assert away[0] == pytest.approx(np.hypot(0.5, 1.5))
    assert (nearest_x[0], nearest_y[0]) == (1.0, 2.0)


def test_covered_is_inside_or_near(rng):
    x, y = np.round(rng.uniform(-0.5, 2.5, (2, 9001)), 1)
    distance = distance_of(L_SHAPE, x, y)
    for margin in (0.0, 1e-9, 0.25):
        assert np.array_equal(
            covered_by(L_SHAPE, x, y, np.full(9001, margin))[np.abs(distance - margin) > 1e-12],
            (distance <= margin)[np.abs(distance - margin) > 1e-12],
        )


@QUIET
@given(st.integers(5, 12), st.integers(0, 10**6))
def test_star_shaped_outlines_do_not_cross_and_hold_their_center(count, seed):
    rng = np.random.default_rng(seed)
    angles = 2.0 * np.pi * (np.arange(count) + rng.uniform(0.0, 0.45, count)) / count
    corners = rng.uniform(0.3, 1.0, count)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    assert first_crossing(corners, 1e-9) is None
    assert first_crossing(corners[::-1], 1e-9) is None
    assert inside_of(corners, np.zeros(1), np.zeros(1))[0]


@pytest.mark.parametrize(
    ("corners", "edges"),
    [
        ([(0, 0), (1, 1), (1, 0), (0, 1)], (0, 2)),  # a bow tie
        ([(0, 0), (2, 0), (2, 2), (1, 0), (0, 2)], (0, 2)),  # touches an edge with a corner
        ([(0, 0), (2, 0), (1, 0), (1, 1)], (0, 1)),  # folds back
        ([(0, 0), (2, 0), (2, 1), (1, 1), (1, -1), (0, -1)], (0, 3)),
        ([(0, 0), (1, 0), (1, 1), (0, 1)], None),
        (L_SHAPE, None),
        (L_SHAPE[::-1], None),
        ([(0, 0), (1, 0), (2, 0), (2, 1)], None),  # a corner on a straight edge is none
    ],
)
def test_first_crossing(corners, edges):
    assert first_crossing(np.array(corners, dtype=float), 1e-9) == edges
