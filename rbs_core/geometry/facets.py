"""Many triangles at once: the nearest one, how often they go around a point, and which bonds pass through them."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.geometry.base import ROUND_OFF
from rbs_core.geometry.boxtree import ROUND, BoxTree, Indices, far, overlapping
from rbs_core.geometry.frames import dots
from rbs_core.geometry.surfaces import on_different_sides, weights
from rbs_core.geometry.triangles import as_triangles
from rbs_core.space.checks import BoolArray, FloatArray


class Facets:
    """Triangles with shared vertices.

    Args:
        vertices: (m), shape (n, 3).
        triangles: indices of three vertices each, shape (m, 3).

    Raises:
        BadInput: as `as_triangles`.
    """

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None:
        self.vertices, self.triangles = as_triangles(vertices, triangles)
        self.corners: FloatArray = self.vertices[self.triangles]
        self.tree = BoxTree(self.corners)
        first, second = self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0]
        self.areas: FloatArray = np.cross(first, second) / 2
        self._normals = self.areas / np.sqrt(dots(self.areas, self.areas))[:, None]
        self._middles: FloatArray = self.corners.mean(axis=1)
        self._radii = np.sqrt(((self.corners - self._middles[:, None]) ** 2).sum(axis=2).max(axis=1))

    @property
    def volume(self) -> float:
        """What they enclose if they are closed, positive if they run counterclockwise seen from outside (m^3)."""
        # From the middle: far from the origin little would be left of the sum.
        middle = self.vertices.mean(axis=0)
        return float(dots(self.corners[:, 0] - middle, self.areas).sum() / 3)

    def nearest(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Distances (n,) of points (n, 3), and the nearest points of the triangles (n, 3)."""
        squares, found = np.empty(len(points)), np.empty_like(points)
        for begin in range(0, len(points), ROUND):
            rows = slice(begin, begin + ROUND)
            squares[rows], found[rows] = self._nearest(points[rows])
        return np.sqrt(squares), found

    def _nearest(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        # The nearest vertex or middle of a triangle is hardly farther away than the nearest point, up to round-off.
        round_off = ROUND_OFF * (np.abs(points).max(axis=1, initial=0.0) + np.abs(self.vertices).max())
        limit = (self._landmarks.query(points)[0] * (1.0 + 1e-7) + round_off) ** 2
        queries, triangles = self.tree.pairs(
            np.arange(len(points)), lambda rows, low, high: far(points[rows], low, high) <= limit[rows]
        )
        kept = self._disk_distances(points[queries], triangles) <= limit[queries]
        queries, triangles = queries[kept], triangles[kept]
        candidates = nearest_on(points[queries], self.corners[triangles])
        reached = dots(points[queries] - candidates, points[queries] - candidates)
        order = np.lexsort((reached, queries))
        best = order[np.flatnonzero(np.diff(queries[order], prepend=-1))]
        return reached[best], candidates[best]

    @cached_property
    def _landmarks(self) -> Any:
        """Vertices and middles of the triangles, in a tree that finds the nearest one."""
        from scipy.spatial import cKDTree  # late: not every script asks for distances from triangles

        return cKDTree(np.vstack([self.vertices[np.unique(self.triangles)], self._middles]))

    def _disk_distances(self, points: FloatArray, triangles: Indices) -> FloatArray:
        """Squared distances of points from the disks around triangles, row by row: at most those of the triangles."""
        off = points - self._middles[triangles]
        height = dots(off, self._normals[triangles])
        sideways = np.sqrt(np.maximum(dots(off, off) - height**2, 0.0)) - self._radii[triangles]
        squares: FloatArray = height**2 + np.maximum(sideways, 0.0) ** 2
        return squares

    def within(self, points: FloatArray, distance: FloatArray) -> BoolArray:
        """Which points (n, 3) are at most so far away, shape (n,); cheap for small distances."""
        near = np.zeros(len(points), dtype=np.bool_)
        limit = distance**2
        queries, triangles = self.tree.pairs(
            np.arange(len(points)), lambda rows, low, high: far(points[rows], low, high) <= limit[rows]
        )
        off = points[queries] - nearest_on(points[queries], self.corners[triangles])
        near[queries[dots(off, off) <= limit[queries]]] = True
        return near

    def winding(self, points: FloatArray) -> NDArray[np.int64]:
        """How often closed triangles go around points (n, 3): 0 outside, 1 inside.

        A ray from each point along z counts triangles that face up and those that face down. On which side it passes
        an edge or a corner is decided alike for all triangles that meet there, so that it counts once.
        """
        result = np.zeros(len(points), dtype=np.int64)
        for begin in range(0, len(points), ROUND):
            part = points[begin : begin + ROUND]
            queries, triangles = self.tree.pairs(
                np.arange(len(part)),
                lambda rows, low, high, part=part: _above(part[rows], low, high),  # type: ignore[misc]
            )
            turns = self._turns(part[queries], triangles)
            hit = np.flatnonzero(turns)
            queries, triangles, turns = queries[hit], triangles[hit], turns[hit]
            height = dots(part[queries] - self.corners[triangles, 0], self.areas[triangles])
            over = (height * turns < 0.0) | (part[queries, 2] < self.corners[triangles, :, 2].min(axis=1))
            np.add.at(result, begin + queries[over], turns[over])
        return result

    def _turns(self, points: FloatArray, triangles: Indices) -> NDArray[np.int64]:
        """How triangles go around points, seen from above, row by row: 1 counterclockwise, -1 clockwise, or 0."""
        turns = np.zeros(len(points), dtype=np.int64)
        x, y = points[:, 0], points[:, 1]
        rows = self.triangles[triangles]
        for corner in range(3):
            start, end = self.vertices[rows[:, corner]], self.vertices[rows[:, (corner + 1) % 3]]
            upward = start[:, 1] < end[:, 1]
            low, high = np.where(upward[:, None], start, end), np.where(upward[:, None], end, start)
            # From its lower end, whichever triangle asks: both get the same bits. A point under a corner counts as
            # slightly higher than it and, even more so, to the right of it, for all edges alike.
            straddles = (low[:, 1] <= y) & (high[:, 1] > y)
            left = (high[:, 0] - low[:, 0]) * (y - low[:, 1]) - (high[:, 1] - low[:, 1]) * (x - low[:, 0]) > 0.0
            turns += np.where(upward, 1, -1) * (straddles & left)
        return turns

    def crossed(self, starts: FloatArray, ends: FloatArray, tolerance: FloatArray) -> BoolArray:
        """Which bonds (m,) cross a triangle, by the rule of surfaces.py for each."""
        crossing = np.zeros(len(starts), dtype=np.bool_)
        lower = np.minimum(starts, ends) - tolerance[:, None]
        upper = np.maximum(starts, ends) + tolerance[:, None]
        bonds, triangles = self.tree.pairs(
            np.arange(len(starts)),
            lambda rows, low, high: overlapping(lower[rows], upper[rows], low, high),
        )
        start, end, margin = starts[bonds], ends[bonds], tolerance[bonds]
        normal = self._normals[triangles]
        corner = self.corners[triangles, 0]
        start_height, end_height = dots(start - corner, normal), dots(end - corner, normal)
        found = np.flatnonzero(on_different_sides(start_height, end_height, margin))
        to_start = weights(start_height[found], margin[found])[:, None]
        to_end = weights(end_height[found], margin[found])[:, None]
        meeting = (start[found] * to_end + end[found] * to_start) / (to_start + to_end)
        off = meeting - nearest_on(meeting, self.corners[triangles[found]])
        # The meeting point is in the plane up to round-off, so that its distance is the one beside the triangle.
        crossing[bonds[found[dots(off, off) <= margin[found] ** 2]]] = True
        return crossing


def _above(points: FloatArray, lower: FloatArray, upper: FloatArray) -> BoolArray:
    """Whether rays along z from points meet boxes, row by row."""
    flat = (points[:, :2] >= lower[:, :2]) & (points[:, :2] <= upper[:, :2])
    meets: BoolArray = flat.all(axis=1) & (points[:, 2] <= upper[:, 2])
    return meets


def nearest_on(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Nearest points (k, 3) of triangles (k, 3, 3) to points (k, 3), row by row."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    # The foot of the perpendicular counts if it is on the inner side of all edges. By cross products: they keep their
    # digits in needles, where the usual barycentric formula loses all of them.
    inner = np.ones(len(points), dtype=np.bool_)
    for start, end in ((a, b), (b, c), (c, a)):
        inner &= dots(np.cross(end - start, points - start), normal) >= 0.0
    result = points - (dots(points - a, normal) / dots(normal, normal))[:, None] * normal
    outer = np.flatnonzero(~inner)
    least = np.full(len(outer), np.inf)
    for start, end in ((a[outer], b[outer]), (b[outer], c[outer]), (c[outer], a[outer])):
        way = end - start
        share = np.clip(dots(points[outer] - start, way) / dots(way, way), 0.0, 1.0)
        candidate = start + share[:, None] * way
        off = points[outer] - candidate
        squares = dots(off, off)
        nearer = squares < least
        least[nearer], result[outer[nearer]] = squares[nearer], candidate[nearer]
    return result
