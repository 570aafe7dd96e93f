"""Points and planes: a single place, and what divides all of space."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry.described import as_direction, as_place, coordinate_tuple
from rbs_core.geometry.frames import along, lengths, parallel, rows_along, unit
from rbs_core.geometry.solid import bounds_of
from rbs_core.geometry.surfaces import Surface, on_different_sides, tolerances
from rbs_core.space.checks import BoolArray, Bounds, FloatArray, as_text, as_vector, as_vectors


class Point(Surface):
    """A single point; in 1-D a cut through the line, whose positive side is x and above.

    Its size, for the tolerance of a cut, is |x| or the length of the bond, whichever is larger; far from 0 the length
    counts.

    Args:
        x: coordinate (m), a number in 1-D, or coordinates, shape (d,).

    Raises:
        BadInput: for more than 3 components; in `crosses` in 2-D and 3-D.
    """

    _kinds = {"x": "point"}

    def __init__(self, x: ArrayLike) -> None:
        self.x = as_vector(x, "x")

    @property
    def dimension(self) -> int:
        """Number of coordinates."""
        return self.x.size

    @property
    def bounds(self) -> Bounds:
        """The point, twice."""
        return self.x.copy(), self.x.copy()

    def _cure(self) -> str | None:
        return None if self.dimension == 1 else "a point cuts in 1-D alone; cut with a Segment (2-D) or a Polygon (3-D)"

    def _heights(self, points: FloatArray) -> FloatArray:
        height: FloatArray = points[:, 0] - self.x[0]
        return height

    def _margins(self, starts: FloatArray, ends: FloatArray) -> FloatArray:
        largest = abs(float(self.x[0]))
        return tolerances(starts, ends, np.maximum(np.abs(ends[:, 0] - starts[:, 0]), largest), largest)

    def _crosses(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        return on_different_sides(self._heights(starts), self._heights(ends), self._margins(starts, ends))

    def _distance(self, points: FloatArray) -> FloatArray:
        return lengths(points - self.x)

    def _projection(self, points: FloatArray) -> FloatArray:
        return np.broadcast_to(self.x, points.shape).copy()

    def _reaches(self, direction: FloatArray) -> float:
        return float(self.x @ direction)

    def _parameters(self) -> dict[str, object]:
        return {"x": float(self.x[0]) if self.dimension == 1 else coordinate_tuple(self.x)}


class Plane(Surface):
    """A plane in 3-D, a line in 2-D, a point in 1-D: the surface of a half space; it cuts from end to end.

    The positive side is the one to which the normal points.

    Args:
        point: any point of the plane (m), shape (d,), or one number for all components.
        normal: vector of any length but 0, at right angles to the plane, shape (d,).

    Raises:
        BadInput: for a normal without length and for different numbers of components.
    """

    _kinds = {"point": "point", "normal": "direction"}

    def __init__(self, point: ArrayLike, normal: ArrayLike) -> None:
        self.point, across = as_vectors(point, normal, ("point", "normal"))
        self.normal = as_direction(across, "normal", across.size)
        self._unit = unit(self.normal)

    @classmethod
    def through(cls, *points: ArrayLike) -> Plane:
        """The plane through three points in 3-D, two in 2-D; seen from its positive side they run counterclockwise.

        In 2-D the positive side is on the left on the way from the first to the second.

        Raises:
            BadInput: for another number of points, and for points that coincide or lie on a line.
        """
        count = len(points)
        if count not in (2, 3):
            raise BadInput(f"{count} points; give three points in 3-D, or two in 2-D")
        first, *others = (as_place(point, f"points[{index}]", count) for index, point in enumerate(points))
        sides = [other - first for other in others]
        normal = np.cross(sides[0], sides[1]) if count == 3 else np.array([-sides[0][1], sides[0][0]])
        size = float(np.prod([np.linalg.norm(side) for side in sides]))
        if np.linalg.norm(normal) <= 1e-12 * size:
            raise BadInput(
                f"points = {', '.join(map(as_text, (first, *others)))} lie on a line; give points that tell a plane"
                if count == 3
                else f"points[0] = points[1] = {as_text(first)}; give two different points"
            )
        return cls(first, normal)

    @property
    def dimension(self) -> int:
        """Number of components of `point`."""
        return self.point.size

    @property
    def bounds(self) -> Bounds:
        """Finite along the normal where it is along an axis, otherwise infinite."""
        return bounds_of(self)

    def _heights(self, points: FloatArray) -> FloatArray:
        return along(points, self.point, self._unit)

    def _margins(self, starts: FloatArray, ends: FloatArray) -> FloatArray:
        return tolerances(starts, ends, np.inf, float(np.abs(self.point).max()))

    def _crosses(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        return on_different_sides(self._heights(starts), self._heights(ends), self._margins(starts, ends))

    def _distance(self, points: FloatArray) -> FloatArray:
        return np.abs(self._heights(points))

    def _projection(self, points: FloatArray) -> FloatArray:
        return points - rows_along(self._heights(points), self._unit)

    def _reaches(self, direction: FloatArray) -> float:
        return float(self.point @ direction) if parallel(self._unit, unit(direction)) else np.inf

    def _inside(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        lower, upper = left_by(lower, upper, self.point, self._unit)
        return left_by(lower, upper, self.point, -self._unit)

    def _parameters(self) -> dict[str, object]:
        return {"point": coordinate_tuple(self.point), "normal": coordinate_tuple(self.normal)}


def left_by(lower: FloatArray, upper: FloatArray, point: FloatArray, normal: FloatArray) -> Bounds:
    """What a half space leaves of a box: bounds of those of its points to which the normal leads from the plane.

    Args:
        lower: smallest coordinates, shape (d,), may be -inf.
        upper: largest coordinates, shape (d,), may be +inf.
        point: of the plane, shape (d,).
        normal: into the half space, shape (d,).
    """
    low, high = np.array(np.broadcast_to(lower, normal.shape)), np.array(np.broadcast_to(upper, normal.shape))
    involved = np.flatnonzero(normal).tolist()
    ends = np.where(normal > 0.0, high, low)
    for axis in involved:
        # The farthest that the other coordinates reach along the normal leaves this one the most room.
        others = [other for other in involved if other != axis]
        if all(np.isfinite(ends[other]) for other in others):
            rest = sum(normal[other] * (ends[other] - point[other]) for other in others)
            limit = point[axis] - rest / normal[axis]
            if normal[axis] > 0.0:
                low[axis] = max(low[axis], limit)
            else:
                high[axis] = min(high[axis], limit)
    return low, high
