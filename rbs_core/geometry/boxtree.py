"""A tree of boxes around triangles: which of many triangles can matter for which of many points, without asking all."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from rbs_core.space.checks import BoolArray, FloatArray

Indices: TypeAlias = NDArray[np.int64]

# Whether queries (by index) may have to do with boxes: (queries, lowers (k, 3), uppers (k, 3)) -> (k,) truth values.
Question: TypeAlias = Callable[[Indices, FloatArray, FloatArray], BoolArray]

# Queries per round: some hundred times as many pairs should still fit the cache.
ROUND = 1 << 11


class BoxTree:
    """A complete binary tree; every leaf is the box of one triangle.

    Args:
        corners: of the triangles (m), shape (m, 3, 3): triangle, corner, coordinate.
    """

    def __init__(self, corners: FloatArray) -> None:
        lower, upper = corners.min(axis=1), corners.max(axis=1)
        count = len(corners)
        depth = int(np.ceil(np.log2(count))) if count > 1 else 0
        self.order = _sorted((lower + upper) / 2, depth)
        limits = count * np.arange(2**depth + 1) // 2**depth
        # A leaf holds one triangle or none; an empty one has a box that is never reached.
        self.leaves: Indices = np.where(np.diff(limits) > 0, self.order[np.minimum(limits[:-1], count - 1)], -1)
        empty = self.leaves < 0
        low, high = lower[self.leaves], upper[self.leaves]
        low[empty], high[empty] = np.inf, -np.inf
        self.levels = [(low, high)]
        while len(low) > 1:
            low, high = low.reshape(-1, 2, 3).min(axis=1), high.reshape(-1, 2, 3).max(axis=1)
            self.levels.insert(0, (low, high))

    def pairs(self, queries: Indices, question: Question) -> tuple[Indices, Indices]:
        """Pairs (query, triangle) that may have to do with each other.

        Args:
            queries: indices of what is asked about.
            question: whether queries may have to do with boxes; never refuses a box that holds one it accepts.

        Returns:
            Index of the query and of the triangle for each pair, shape (k,) each.
        """
        boxes = np.zeros(len(queries), dtype=np.int64)
        for level, (lower, upper) in enumerate(self.levels):
            if level:
                queries, boxes = np.repeat(queries, 2), np.repeat(2 * boxes, 2)
                boxes[1::2] += 1
            kept = question(queries, lower[boxes], upper[boxes])
            queries, boxes = queries[kept], boxes[kept]
        triangles = self.leaves[boxes]
        return queries[triangles >= 0], triangles[triangles >= 0]


def far(points: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Squared distances of points from boxes, row by row; infinite for empty boxes."""
    squares = np.zeros(len(points))
    for axis in range(points.shape[1]):
        beyond = np.maximum(lower[:, axis] - points[:, axis], points[:, axis] - upper[:, axis])
        squares += np.maximum(beyond, 0.0) ** 2
    return squares


def overlapping(lower: FloatArray, upper: FloatArray, low: FloatArray, high: FloatArray) -> BoolArray:
    """Whether boxes share a point with other boxes, row by row."""
    return np.asarray(((lower <= high) & (upper >= low)).all(axis=1))


def _sorted(centers: FloatArray, depth: int) -> Indices:
    """Order in which all triangles of a box stand together, for the boxes of every level."""
    count = len(centers)
    order = np.arange(count)
    for level in range(depth):
        limits = count * np.arange(2**level + 1) // 2**level
        part = np.searchsorted(limits, np.arange(count), side="right") - 1
        begins = limits[:-1]
        spans = np.stack(
            [
                np.maximum.reduceat(centers[order, axis], begins) - np.minimum.reduceat(centers[order, axis], begins)
                for axis in range(3)
            ]
        )
        along = spans.argmax(axis=0)[part]  # every box is halved along its longest side
        order = order[np.lexsort((centers[order, along], part))]
    return order
