"""A planar polygon in space, as a surface that bonds can cross."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry.surfaces import TOLERANCE, Surface, on_different_sides, tolerances, weights
from rbs_core.space.checks import BoolArray, Bounds, FloatArray, as_points, as_text


class Polygon(Surface):
    """A flat cut through space with straight edges, convex or not; rule as in surfaces.py.

    Seen from its positive side the points run counterclockwise. Where edges cross each other, what the outline goes
    around twice is outside. The size, for the tolerance, is the diagonal of the bounds.

    Args:
        points: corners in order (m), shape (n, 3), n >= 3; the last is joined to the first.

    Raises:
        BadInput: when there are less than 3 points, when two that follow each other are the same, when they enclose no
            area, or when one lies off the plane of the others; the message names it.
    """

    def __init__(self, points: ArrayLike) -> None:
        corners = as_points(points).copy()
        if corners.shape[1] != 3 or len(corners) < 3:
            raise BadInput(f"points has shape {corners.shape}; give 3 points or more in 3-D, shape (n, 3)")
        corners.flags.writeable = False
        self.points = corners
        size = float(np.linalg.norm(np.ptp(corners, axis=0)))
        self._size, self._largest = size, float(np.abs(corners).max())
        flatness = TOLERANCE * size  # of the corners; what counts as on the polygon depends on the bond
        _require_edges(corners, flatness)
        # From the middle, as for a segment: symmetric shapes stay symmetric to the last bit.
        self._middle: FloatArray = corners.mean(axis=0)
        around = corners - self._middle
        normal = _area_vector(around)
        area = float(np.linalg.norm(normal))
        if area <= flatness * size:
            raise BadInput(
                f"the points {as_text(corners)} enclose no area; give corners that do not lie on a line, "
                "in order along the outline"
            )
        self._normal = normal / area
        if np.abs(around @ self._normal).max() > flatness:
            raise BadInput(_off_plane(corners, flatness))
        first = corners[1] - corners[0]
        first = first - (first @ self._normal) * self._normal
        self._first = first / np.linalg.norm(first)
        self._second = np.cross(self._normal, self._first)
        self._outline = np.stack([around @ self._first, around @ self._second], axis=1)

    @property
    def dimension(self) -> int:
        """3."""
        return 3

    @property
    def bounds(self) -> Bounds:
        """The box around the corners."""
        return self.points.min(axis=0), self.points.max(axis=0)

    def _along(self, points: FloatArray, direction: FloatArray) -> FloatArray:
        """Coordinate along a direction, from the middle; summed in one order, so the same bits in any round."""
        result: FloatArray = (points[:, 0] - self._middle[0]) * direction[0]
        result += (points[:, 1] - self._middle[1]) * direction[1]
        result += (points[:, 2] - self._middle[2]) * direction[2]
        return result

    def _crosses(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        start_height, end_height = self._along(starts, self._normal), self._along(ends, self._normal)
        tolerance = tolerances(starts, ends, self._size, self._largest)
        crossing = on_different_sides(start_height, end_height, tolerance)
        found = np.flatnonzero(crossing)
        if not found.size:
            return crossing
        tolerance = tolerance[found]
        to_start, to_end = weights(start_height[found], tolerance), weights(end_height[found], tolerance)
        # Written so that both ends play the same part: a bond and its reverse meet the plane in the same bits.
        start, end, total = starts[found], ends[found], to_start + to_end
        first, second = (
            (self._along(start, axis) * to_end + self._along(end, axis) * to_start) / total
            for axis in (self._first, self._second)
        )
        crossing[found] = self._covers(first, second, tolerance)
        return crossing

    def _covers(self, x: FloatArray, y: FloatArray, tolerance: FloatArray) -> BoolArray:
        """Whether points of the plane are inside, or at most the tolerance beside the outline."""
        inside = np.zeros(len(x), dtype=np.bool_)
        near = np.zeros(len(x), dtype=np.bool_)
        for (x0, y0), (x1, y1) in zip(self._outline, np.roll(self._outline, -1, axis=0), strict=True):
            along_x, along_y = x1 - x0, y1 - y0
            from_x, from_y = x - x0, y - y0
            share = (from_x * along_x + from_y * along_y) / (along_x**2 + along_y**2)
            share = np.clip(share, 0.0, 1.0)
            near |= (from_x - share * along_x) ** 2 + (from_y - share * along_y) ** 2 <= tolerance**2
            if y0 != y1:
                # A ray towards +x flips inside and outside at every edge; the half-open rule counts a corner once.
                inside ^= ((y0 <= y) != (y1 <= y)) & (from_x < from_y * (along_x / along_y))
        return inside | near

    def _parameters(self) -> dict[str, object]:
        return {"points": tuple(tuple(row) for row in self.points.tolist())}


def _require_edges(corners: FloatArray, tolerance: float) -> None:
    """Refuse a corner that repeats the one before it."""
    lengths = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    for index, length in enumerate(lengths.tolist()):
        if length <= tolerance:
            before = (index - 1) % len(corners)
            raise BadInput(
                f"points[{index}] = {as_text(corners[index])} repeats points[{before}]; "
                "leave it out (the outline closes by itself)"
            )


def _area_vector(around: FloatArray) -> FloatArray:
    """Normal of the polygon, as long as its area; right for any outline, convex or not."""
    area: FloatArray = np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0) / 2
    return area


def _off_plane(corners: FloatArray, tolerance: float) -> str:
    """Message about the first corner that is not in the plane of those before it."""
    for count in range(4, len(corners) + 1):
        some = corners[:count] - corners[:count].mean(axis=0)
        if np.abs(some @ np.linalg.svd(some)[2][-1]).max() > tolerance:
            break
    before = corners[: count - 1] - corners[: count - 1].mean(axis=0)
    normal = np.linalg.svd(before)[2][-1]
    off = abs(float((corners[count - 1] - corners[: count - 1].mean(axis=0)) @ normal))
    return (
        f"points[{count - 1}] = {as_text(corners[count - 1])} lies {off:.3g} m off the plane of the points before it; "
        "move it into that plane, or cut with several polygons (a | b)"
    )
