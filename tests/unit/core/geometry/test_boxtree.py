"""Trees of boxes: every pair that matters is found, few others are asked."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.geometry.boxtree import BoxTree, far, overlapping


@pytest.fixture(params=[1, 2, 3, 7, 64, 1000])
def corners(request, rng) -> np.ndarray:
    return rng.uniform(-1.0, 1.0, (request.param, 1, 3)) + rng.uniform(-0.05, 0.05, (request.param, 3, 3))


def test_all_triangles_near_points_are_found(corners, rng):
    points = rng.uniform(-1.2, 1.2, (50, 3))
    tree = BoxTree(corners)
    queries, triangles = tree.pairs(np.arange(50), lambda rows, low, high: far(points[rows], low, high) <= 0.3**2)
    low, high = corners.min(axis=1), corners.max(axis=1)
    ways = np.linalg.norm(np.maximum(0.0, np.maximum(low - points[:, None], points[:, None] - high)), axis=2)
    found = list(zip(queries.tolist(), triangles.tolist(), strict=True))
    assert set(found) == {(query, triangle) for query, triangle in np.argwhere(ways <= 0.3).tolist()}
    assert len(found) == len(set(found))


def test_every_triangle_has_a_leaf(corners):
    tree = BoxTree(corners)
    assert sorted(tree.leaves[tree.leaves >= 0].tolist()) == list(range(len(corners)))


def test_few_boxes_are_asked(rng):
    corners = rng.uniform(-1.0, 1.0, (4096, 1, 3)) + rng.uniform(-0.01, 0.01, (4096, 3, 3))
    asked = []

    def near(rows, low, high):
        asked.append(len(rows))
        return far(np.zeros((len(rows), 3)), low, high) <= 0.05**2

    BoxTree(corners).pairs(np.zeros(1, dtype=np.int64), near)
    assert sum(asked) < 400


def test_boxes_that_touch_overlap():
    low, high = np.zeros((3, 3)), np.ones((3, 3))
    other = np.array([[1.0, 0.0, 0.0], [1.1, 0.0, 0.0], [0.2, 0.2, 0.2]])
    assert overlapping(low, high, other, other + 1.0).tolist() == [True, False, True]
