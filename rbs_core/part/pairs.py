"""Which points are near each other: pairs of nodes, of two clouds or within one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from rbs_core.memory import fits, require_memory
from rbs_core.part.storage import TOLERANCE

Points = NDArray[np.float64]
Pairs = NDArray[np.int64]
PAIR = 150  # bytes of a pair while bonds are made of it


def pairs_between(one: Points, two: Points, horizon: float) -> Pairs:
    """(k, 2) which of some points are within a distance of which others, ordered by the first and the second."""
    reach = horizon * (1 + TOLERANCE)
    first = _inside(one, two, reach)
    second = _inside(two, one[first], reach) if len(first) else first
    if not len(first) or not len(second):
        return np.empty((0, 2), np.int64)
    trees = cKDTree(one[first]), cKDTree(two[second])
    if not fits(PAIR * len(first) * len(second)):  # were all within reach of all
        _require(int(trees[0].count_neighbors(trees[1], reach)), horizon)
    close = trees[0].sparse_distance_matrix(trees[1], reach, output_type="ndarray")
    return ordered(np.stack([first[close["i"]], second[close["j"]]], axis=1))


def pairs_among(points: Points, horizon: float) -> Pairs:
    """(k, 2) which points are within a distance of each other, the lower number first, ordered."""
    tree, reach = cKDTree(points), horizon * (1 + TOLERANCE)
    if not fits(PAIR * len(points) ** 2):
        _require(int(tree.count_neighbors(tree, reach) - len(points)) // 2, horizon)
    return ordered(tree.query_pairs(reach, output_type="ndarray"))


def _require(count: int, horizon: float) -> None:
    what = f"a search for nodes within {horizon:g} m of each other: {count:,} pairs"
    require_memory(float(PAIR * count), what, "take a smaller horizon")


def ordered(pairs: NDArray[np.integer]) -> Pairs:
    """The pairs by their first and then by their second."""
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))].astype(np.int64)


def _inside(points: Points, others: Points, reach: float) -> NDArray[np.int64]:
    """Indices of the points in the box around others, widened."""
    low, high = others.min(axis=0) - reach, others.max(axis=0) + reach
    found = np.flatnonzero((points[:, 0] >= low[0]) & (points[:, 0] <= high[0]))
    for axis in range(1, points.shape[1]):  # each axis leaves fewer to look at
        along = points[found, axis]
        found = found[(along >= low[axis]) & (along <= high[axis])]
    return found
