"""Closed outlines with straight edges: what is inside, how far away they are, whether they cross themselves."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rbs_core.space.checks import BoolArray, FloatArray

# Points per round: the temporary arrays of a round stay in the cache, whatever the number of points.
ROUND = 1 << 12


def _rounds(count: int) -> Iterator[slice]:
    for begin in range(0, count, ROUND):
        yield slice(begin, begin + ROUND)


def edges_of(corners: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Start and end of each edge of an outline (k, 2); the last corner is joined to the first."""
    yield from zip(corners, np.roll(corners, -1, axis=0), strict=True)


def covered_by(corners: FloatArray, x: FloatArray, y: FloatArray, margin: FloatArray) -> BoolArray:
    """Whether points are inside of an outline (k, 2), or at most a margin (n,) beside it; faster than distances."""
    covered = np.empty(len(x), dtype=np.bool_)
    for rows in _rounds(len(x)):
        covered[rows] = _covered(corners, x[rows], y[rows], margin[rows])
    return covered


def _covered(corners: FloatArray, x: FloatArray, y: FloatArray, margin: FloatArray) -> BoolArray:
    inside, near = np.zeros(len(x), dtype=np.bool_), np.zeros(len(x), dtype=np.bool_)
    for (x0, y0), (x1, y1) in edges_of(corners):
        along_x, along_y = x1 - x0, y1 - y0
        from_x, from_y = x - x0, y - y0
        side = from_x * along_y - from_y * along_x
        if along_y != 0.0:
            # A ray towards +x flips inside and outside at every edge; the half-open rule counts a corner once.
            inside ^= ((y0 <= y) != (y1 <= y)) & ((side < 0.0) if along_y > 0.0 else (side > 0.0))
        square = along_x**2 + along_y**2
        close = np.flatnonzero(np.abs(side) <= margin * np.sqrt(square))
        if close.size:  # to the line of the edge: few
            share = np.clip((from_x[close] * along_x + from_y[close] * along_y) / square, 0.0, 1.0)
            off = np.hypot(from_x[close] - share * along_x, from_y[close] - share * along_y)
            near[close] |= off <= margin[close]
    return inside | near


def inside_of(corners: FloatArray, x: FloatArray, y: FloatArray) -> BoolArray:
    """Whether points are inside of an outline (k, 2), or exactly on it."""
    return covered_by(corners, x, y, np.zeros(len(x)))


def nearest_of(corners: FloatArray, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Distance of points from an outline (k, 2), and the coordinates of the nearest points of it."""
    away, nearest_x, nearest_y = np.empty_like(x), np.empty_like(x), np.empty_like(x)
    for rows in _rounds(len(x)):
        away[rows], nearest_x[rows], nearest_y[rows] = _nearest(corners, x[rows], y[rows])
    return away, nearest_x, nearest_y


def _nearest(corners: FloatArray, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    least = np.full(len(x), np.inf)
    nearest_x, nearest_y = np.empty_like(x), np.empty_like(y)
    for (x0, y0), (x1, y1) in edges_of(corners):
        along_x, along_y = x1 - x0, y1 - y0
        share = ((x - x0) * along_x + (y - y0) * along_y) / (along_x**2 + along_y**2)
        share = np.clip(share, 0.0, 1.0)
        # From the nearer end, so that an end is met exactly.
        second = share > 0.5
        on_x = np.where(second, x1 - (1.0 - share) * along_x, x0 + share * along_x)
        on_y = np.where(second, y1 - (1.0 - share) * along_y, y0 + share * along_y)
        squares = (x - on_x) ** 2 + (y - on_y) ** 2
        nearer = squares < least
        least[nearer], nearest_x[nearer], nearest_y[nearer] = squares[nearer], on_x[nearer], on_y[nearer]
    return np.sqrt(least), nearest_x, nearest_y


def distance_of(corners: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """Signed distance of points from an outline (k, 2), negative inside."""
    away = nearest_of(corners, x, y)[0]
    return np.where(inside_of(corners, x, y) & (away > 0.0), -away, away)  # never -0.0


def first_crossing(corners: FloatArray, tolerance: float) -> tuple[int, int] | None:
    """The first two edges of an outline (k, 2) that cross or touch without following each other, or fold back.

    Args:
        corners: shape (k, 2).
        tolerance: distance up to which two edges touch (m).

    Returns:
        Numbers of the edges (edge i starts at corner i), or None.
    """
    count = len(corners)
    ends = np.roll(corners, -1, axis=0)
    ways = ends - corners
    for edge in range(count):
        others = np.arange(edge + 1, count)
        following = (others == edge + 1) | ((edge == 0) & (others == count - 1))
        meets = _meet(corners[edge], ends[edge], corners[others], ends[others], tolerance)
        # Edges that follow each other share a corner; they fold back if the second leads along the first again.
        before, after = ways[edge], ways[others]
        lean = before[0] * after[:, 1] - before[1] * after[:, 0]
        long = np.hypot(*before) * np.hypot(after[:, 0], after[:, 1])
        back = (np.abs(lean) <= 1e-12 * long) & (after @ before < 0.0)
        wrong = np.flatnonzero(np.where(following, back, meets))
        if wrong.size:
            return edge, int(others[wrong[0]])
    return None


def _meet(start: FloatArray, end: FloatArray, starts: FloatArray, ends: FloatArray, tolerance: float) -> BoolArray:
    """Which segments come nearer to one segment than a tolerance."""
    way, ways = end - start, ends - starts
    first, second = _side(start, way, starts), _side(start, way, ends)
    third, fourth = _sides(starts, ways, start), _sides(starts, ways, end)
    crossing = (np.sign(first) * np.sign(second) < 0.0) & (np.sign(third) * np.sign(fourth) < 0.0)
    near = np.minimum(_from(start[None], way[None], starts), _from(start[None], way[None], ends))
    near = np.minimum(near, np.minimum(_from(starts, ways, start[None]), _from(starts, ways, end[None])))
    touching: BoolArray = crossing | (near <= tolerance)
    return touching


def _side(start: FloatArray, way: FloatArray, points: FloatArray) -> FloatArray:
    side: FloatArray = way[0] * (points[:, 1] - start[1]) - way[1] * (points[:, 0] - start[0])
    return side


def _sides(starts: FloatArray, ways: FloatArray, point: FloatArray) -> FloatArray:
    sides: FloatArray = ways[:, 0] * (point[1] - starts[:, 1]) - ways[:, 1] * (point[0] - starts[:, 0])
    return sides


def _from(starts: FloatArray, ways: FloatArray, points: FloatArray) -> FloatArray:
    """Distances of points from segments, row by row."""
    share = ((points - starts) * ways).sum(axis=1) / (ways**2).sum(axis=1)
    off = points - starts - np.clip(share, 0.0, 1.0)[:, None] * ways
    distance: FloatArray = np.hypot(off[:, 0], off[:, 1])
    return distance
