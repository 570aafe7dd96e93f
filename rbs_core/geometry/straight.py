"""Segments, rays and lines: straight cuts through a plane, and sets of points in space."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry.described import as_direction, as_place, coordinate_tuple
from rbs_core.geometry.frames import along, lengths, rows_along, square, unit
from rbs_core.geometry.solid import bounds_of
from rbs_core.geometry.surfaces import Surface, on_different_sides, tolerances, weights
from rbs_core.space.checks import BoolArray, Bounds, FloatArray, as_text, as_vectors


class Straight(Surface):
    """The points origin + t along with t between two limits, of which none, one or both are infinite.

    In 2-D bonds can cross it; its positive side is on the left on the way along it.
    """

    _middle: FloatArray  # everything is measured from there
    _along: FloatArray  # of length 1
    _limits: tuple[float, float]

    def _set(self, middle: FloatArray, direction: FloatArray, limits: tuple[float, float], largest: float) -> None:
        self._middle, self._along, self._limits, self._largest = middle, direction, limits, largest

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self._middle.size

    @property
    def bounds(self) -> Bounds:
        """As small a box as there is; infinite where it does not end."""
        return bounds_of(self)

    def _cure(self) -> str | None:
        return None if self.dimension == 2 else "in 3-D bonds pass by a line; cut with a Polygon, a Disk or a Plane"

    def _from_middle(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Coordinates along it, from its middle, and to its left."""
        x, y = points[:, 0] - self._middle[0], points[:, 1] - self._middle[1]
        return x * self._along[0] + y * self._along[1], y * self._along[0] - x * self._along[1]

    def _heights(self, points: FloatArray) -> FloatArray:
        return self._from_middle(points)[1]

    def _margins(self, starts: FloatArray, ends: FloatArray) -> FloatArray:
        return tolerances(starts, ends, self.size or np.inf, self._largest)

    def _crosses(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        (start_along, start_height), (end_along, end_height) = self._from_middle(starts), self._from_middle(ends)
        tolerance = self._margins(starts, ends)
        crossing = on_different_sides(start_height, end_height, tolerance)
        found = np.flatnonzero(crossing)
        tolerance = tolerance[found]
        to_start, to_end = weights(start_height[found], tolerance), weights(end_height[found], tolerance)
        # The bond meets the line at meeting / (to_start + to_end); written so that both ends play the same part.
        meeting = start_along[found] * to_end + end_along[found] * to_start
        crossing[found] = self._covers(meeting, to_start + to_end, tolerance)
        return crossing

    @abstractmethod
    def _covers(self, meeting: FloatArray, total: FloatArray, tolerance: FloatArray) -> BoolArray:
        """Whether places meeting / total along the line belong to it, or are at most a tolerance beside it."""

    def _nearest(self, points: FloatArray) -> FloatArray:
        """Coordinates along it of the nearest points of it."""
        return np.clip(along(points, self._middle, self._along), *self._limits)

    def _distance(self, points: FloatArray) -> FloatArray:
        return lengths(points - self._middle - rows_along(self._nearest(points), self._along))

    def _projection(self, points: FloatArray) -> FloatArray:
        return self._middle + rows_along(self._nearest(points), self._along)

    def _reaches(self, direction: FloatArray) -> float:
        slope = 0.0 if square(self._along, unit(direction)) else float(self._along @ direction)
        start = float(self._middle @ direction)
        return start if slope == 0.0 else start + slope * self._limits[slope > 0.0]


class Segment(Straight):
    """The straight line between two tips; in 2-D a cut, whose positive side is on the left from start to end.

    Its size, for the tolerance, is its length.

    Args:
        start: one tip (m), shape (2,) or (3,).
        end: the other tip (m), of the same shape.

    Raises:
        BadInput: when the tips are the same point or do not have two or three components; in `crosses` in 3-D.
    """

    _kinds = {"start": "point", "end": "point"}

    def __init__(self, start: ArrayLike, end: ArrayLike) -> None:
        self.start, self.end = as_vectors(start, end, ("start", "end"))
        if self.start.size == 1:
            raise BadInput(
                f"start = {as_text(self.start)} has 1 component; give 2 or 3 (1-D: Point to cut, Box.between to fill)"
            )
        way = self.end - self.start
        # np.hypot and np.linalg.norm may differ in the last bit, on which cuts depend: hypot it is, in 2-D.
        length = float(np.hypot(*way)) if way.size == 2 else float(np.linalg.norm(way))
        if length == 0.0:
            raise BadInput(f"start = end = {as_text(self.start)}: a segment without length; give two different tips")
        self.length, self._half = length, length / 2
        largest = float(max(np.abs(self.start).max(), np.abs(self.end).max()))
        # Everything is measured from the middle: a cut that is symmetric about an axis then stays so to the last bit.
        self._set((self.start + self.end) / 2, way / length, (-self._half, self._half), largest)

    @property
    def size(self) -> float:
        """The length."""
        return self.length

    @property
    def bounds(self) -> Bounds:
        """The box around both tips."""
        return np.minimum(self.start, self.end), np.maximum(self.start, self.end)

    def _covers(self, meeting: FloatArray, total: FloatArray, tolerance: FloatArray) -> BoolArray:
        inside: BoolArray = np.abs(meeting) <= (self._half + tolerance) * total
        return inside

    def _reaches(self, direction: FloatArray) -> float:
        return max(float(self.start @ direction), float(self.end @ direction))

    def _parameters(self) -> dict[str, object]:
        return {"start": coordinate_tuple(self.start), "end": coordinate_tuple(self.end)}


class Ray(Straight):
    """Half of a line, from a tip to infinity; in 2-D a cut, whose positive side is on the left on the way along it.

    Args:
        start: the tip (m), shape (2,) or (3,).
        direction: vector of any length but 0, of the same shape.

    Raises:
        BadInput: for a direction without length and for other numbers of components; in `crosses` in 3-D.
    """

    _kinds = {"start": "point", "direction": "direction"}

    def __init__(self, start: ArrayLike, direction: ArrayLike) -> None:
        self.start, self.direction = _origin_and_direction(start, direction, "start")
        self._set(self.start, unit(self.direction), (0.0, np.inf), float(np.abs(self.start).max()))

    def _covers(self, meeting: FloatArray, total: FloatArray, tolerance: FloatArray) -> BoolArray:
        inside: BoolArray = meeting >= -tolerance * total
        return inside

    def _parameters(self) -> dict[str, object]:
        return {"start": coordinate_tuple(self.start), "direction": coordinate_tuple(self.direction)}


class Line(Straight):
    """A straight line without ends; in 2-D a cut, whose positive side is on the left on the way along it.

    Args:
        point: any point of it (m), shape (2,) or (3,).
        direction: vector of any length but 0, of the same shape.

    Raises:
        BadInput: for a direction without length and for other numbers of components; in `crosses` in 3-D.
    """

    _kinds = {"point": "point", "direction": "direction"}

    def __init__(self, point: ArrayLike, direction: ArrayLike) -> None:
        self.point, self.direction = _origin_and_direction(point, direction, "point")
        self._set(self.point, unit(self.direction), (-np.inf, np.inf), float(np.abs(self.point).max()))

    @classmethod
    def through(cls, first: ArrayLike, second: ArrayLike) -> Line:
        """The line through two points (m), shape (d,) each.

        Raises:
            BadInput: when the points are the same.
        """
        a, b = as_vectors(first, second, ("first", "second"))
        if np.array_equal(a, b):
            raise BadInput(f"first = second = {as_text(a)}; give two different points")
        return cls(a, b - a)

    def _covers(self, meeting: FloatArray, total: FloatArray, tolerance: FloatArray) -> BoolArray:
        return np.ones(len(meeting), dtype=np.bool_)

    def _parameters(self) -> dict[str, object]:
        return {"point": coordinate_tuple(self.point), "direction": coordinate_tuple(self.direction)}


def _origin_and_direction(origin: ArrayLike, direction: ArrayLike, what: str) -> tuple[FloatArray, FloatArray]:
    place = as_vectors(origin, origin, (what, what))[0]
    if place.size == 1:
        raise BadInput(f"{what} = {as_text(place)} has 1 component; give 2 or 3 (in 1-D: HalfSpace or Everywhere)")
    return place, as_direction(as_place(direction, "direction", place.size), "direction", place.size)
