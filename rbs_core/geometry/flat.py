"""Flat shapes: a region of the plane in 2-D, a face in space that bonds can cross in 3-D."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry.described import as_direction, as_smaller, coordinate_tuple
from rbs_core.geometry.frames import along, perpendicular, rows_along, unit
from rbs_core.geometry.solid import bounds_of
from rbs_core.geometry.surfaces import Surface, on_different_sides, tolerances, weights
from rbs_core.space.checks import BoolArray, Bounds, FloatArray, as_number, as_text, as_vector


class Flat(Surface):
    """A region of a plane, by coordinates along two directions from a middle.

    In 2-D it is filled: its distance is negative inside. In 3-D it is a face: bonds can cross it, and its distance is
    never negative. The rule is the one of surfaces.py.
    """

    _middle: FloatArray  # everything is measured from there
    _first: FloatArray  # of length 1, in the plane
    _second: FloatArray  # at right angles to it, in the plane
    _normal: FloatArray  # of length 1, to the positive side; in 3-D alone

    def _set_frame(self, middle: FloatArray, first: FloatArray, normal: FloatArray | None, largest: float) -> None:
        self._middle, self._first, self._largest = middle, first, largest
        if normal is not None:
            self._normal = normal
        self._second = perpendicular(first) if normal is None else np.cross(normal, first)

    @property
    def dimension(self) -> int:
        """2 for a region of the plane, 3 for a face in space."""
        return self._middle.size

    @property
    def bounds(self) -> Bounds:
        """As small a box as there is."""
        return bounds_of(self)

    @abstractmethod
    def _plane_distance(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Signed distance from the outline of points of the plane, negative inside."""

    @abstractmethod
    def _plane_nearest(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Nearest points of the outline."""

    def _covers(self, x: FloatArray, y: FloatArray, tolerance: FloatArray) -> BoolArray:
        """Whether points of the plane are inside, or at most the tolerance beside the outline."""
        inside: BoolArray = self._plane_distance(x, y) <= tolerance
        return inside

    @property
    def _fills(self) -> bool:
        return self.dimension == 2

    def _cure(self) -> str | None:
        return None if self.dimension == 3 else "in 2-D it fills a region; cut along its outline"

    def _along(self, points: FloatArray, direction: FloatArray) -> FloatArray:
        return along(points, self._middle, direction)

    def _heights(self, points: FloatArray) -> FloatArray:
        return self._along(points, self._normal)

    def _margins(self, starts: FloatArray, ends: FloatArray) -> FloatArray:
        return tolerances(starts, ends, self.size, self._largest)

    def _crosses(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        start_height, end_height = self._heights(starts), self._heights(ends)
        tolerance = self._margins(starts, ends)
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

    def _contains(self, points: FloatArray) -> BoolArray:
        if self.dimension == 3:
            return super()._contains(points)
        inside: BoolArray = self._distance(points) <= self._round_off(points)
        return inside

    def _distance(self, points: FloatArray) -> FloatArray:
        flat = self._plane_distance(self._along(points, self._first), self._along(points, self._second))
        return flat if self.dimension == 2 else np.hypot(np.maximum(flat, 0.0), self._heights(points))

    def _projection(self, points: FloatArray) -> FloatArray:
        x, y = self._along(points, self._first), self._along(points, self._second)
        nearest_x, nearest_y = self._plane_nearest(x, y)
        if self.dimension == 3:
            inside = self._plane_distance(x, y) <= 0.0
            nearest_x, nearest_y = np.where(inside, x, nearest_x), np.where(inside, y, nearest_y)
        return self._middle + rows_along(nearest_x, self._first) + rows_along(nearest_y, self._second)


class Round(Flat):
    """A flat shape around a center."""

    center: FloatArray
    normal: FloatArray | None

    def _set_center(self, center: ArrayLike, normal: ArrayLike | None) -> None:
        self.center = as_vector(center, "center")
        if self.center.size not in (2, 3):
            raise BadInput(f"center = {as_text(self.center)} has 1 component; give 2, or 3 (in 1-D: Ball or Box)")
        if self.center.size == 2 and normal is not None:
            raise BadInput(f"normal = {normal!r}: in 2-D it lies in the plane anyway; leave the normal out")
        if self.center.size == 3 and normal is None:
            raise BadInput("normal is missing: in 3-D give the direction in which the face looks, such as (0, 0, 1)")
        self.normal = None if normal is None else as_direction(normal, "normal", 3)
        out = None if self.normal is None else unit(self.normal)
        first = np.array([1.0, 0.0]) if out is None else perpendicular(out)
        self._set_frame(self.center, first, out, float(np.abs(self.center).max()))

    def _circle(self, x: FloatArray, y: FloatArray, radius: float | FloatArray) -> tuple[FloatArray, FloatArray]:
        """Nearest points of a circle around the center; that along the first direction for the center itself."""
        away = np.hypot(x, y)
        middle = away == 0.0
        factor = radius / np.where(middle, 1.0, away)
        return np.where(middle, radius, x * factor), y * factor

    def _reaches_from_center(self, direction: FloatArray, radius: float) -> float:
        across = direction if self.normal is None else direction - (direction @ self._normal) * self._normal
        return float(self.center @ direction + radius * np.linalg.norm(across))

    def _place(self) -> dict[str, object]:
        """The parameters that say where it is."""
        normal = {} if self.normal is None else {"normal": coordinate_tuple(self.normal)}
        return {"center": coordinate_tuple(self.center), **normal}


class Disk(Round):
    """What a circle encloses: a region of the plane in 2-D, a face in 3-D, such as a penny-shaped crack.

    Args:
        radius: (m), positive.
        center: middle (m), shape (2,) or (3,).
        normal: in 3-D the direction of the positive side, a vector of any length but 0.

    Raises:
        BadInput: for a radius that is not positive, a normal without length, a missing one in 3-D and one in 2-D.
    """

    _kinds = {"radius": "length", "center": "point", "normal": "direction"}

    def __init__(self, radius: float, center: ArrayLike, normal: ArrayLike | None = None) -> None:
        self.radius = as_number(radius, "radius", positive=True)
        self._set_center(center, normal)

    def _plane_distance(self, x: FloatArray, y: FloatArray) -> FloatArray:
        return np.hypot(x, y) - self.radius

    def _plane_nearest(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        return self._circle(x, y, self.radius)

    def _reaches(self, direction: FloatArray) -> float:
        return self._reaches_from_center(direction, self.radius)

    def _parameters(self) -> dict[str, object]:
        return {"radius": self.radius, **self._place()}


class Ring(Round):
    """What lies between two circles: a region of the plane in 2-D, a face in 3-D.

    Args:
        outer: radius of the outer circle (m), positive.
        inner: radius of the inner circle (m), positive, below the outer one.
        center: middle of both (m), shape (2,) or (3,).
        normal: in 3-D the direction of the positive side, a vector of any length but 0.

    Raises:
        BadInput: for radii that are not positive or in the other order, a normal without length, a missing one in 3-D
            and one in 2-D.
    """

    _kinds = {"outer": "length", "inner": "length", "center": "point", "normal": "direction"}

    def __init__(self, outer: float, inner: float, center: ArrayLike, normal: ArrayLike | None = None) -> None:
        self.outer = as_number(outer, "outer", positive=True)
        self.inner = as_smaller(inner, self.outer, ("inner", "outer"))
        self._set_center(center, normal)

    def _plane_distance(self, x: FloatArray, y: FloatArray) -> FloatArray:
        away = np.hypot(x, y)
        return np.maximum(away - self.outer, self.inner - away)

    def _plane_nearest(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        inward = 2.0 * np.hypot(x, y) < self.inner + self.outer
        return self._circle(x, y, np.where(inward, self.inner, self.outer))

    def _reaches(self, direction: FloatArray) -> float:
        return self._reaches_from_center(direction, self.outer)

    def _parameters(self) -> dict[str, object]:
        return {"outer": self.outer, "inner": self.inner, **self._place()}


class Circle(Round):
    """The line around a disk: a closed cut in 2-D, a set of points in 3-D.

    A bond crosses it in 2-D if its ends are on different sides, or if it goes in and out again. The positive side, to
    which ends on the circle belong, is the outside.

    Args:
        radius: (m), positive.
        center: middle (m), shape (2,) or (3,).
        normal: in 3-D a vector of any length but 0 at right angles to its plane.

    Raises:
        BadInput: for a radius that is not positive, a normal without length, a missing one in 3-D and one in 2-D; in
            `crosses` in 3-D.
    """

    _kinds = {"radius": "length", "center": "point", "normal": "direction"}

    def __init__(self, radius: float, center: ArrayLike, normal: ArrayLike | None = None) -> None:
        self.radius = as_number(radius, "radius", positive=True)
        self._set_center(center, normal)

    @property
    def _fills(self) -> bool:
        return False

    def _cure(self) -> str | None:
        return None if self.dimension == 2 else "in 3-D bonds pass by a line; cut with the Disk that it encloses"

    def _crosses(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        start, end = starts - self.center, ends - self.center
        tolerance = self._margins(starts, ends)
        start_height = np.hypot(start[:, 0], start[:, 1]) - self.radius
        end_height = np.hypot(end[:, 0], end[:, 1]) - self.radius
        crossing = on_different_sides(start_height, end_height, tolerance)
        # In and out again: the foot of the center lies on the bond, and inside.
        way = end - start
        between = ((start * way).sum(axis=1) < 0.0) & ((end * way).sum(axis=1) > 0.0)
        length = np.where(between, np.hypot(way[:, 0], way[:, 1]), 1.0)
        depth = self.radius - np.abs(start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]) / length
        crossing |= between & (depth > tolerance) & (start_height >= -tolerance) & (end_height >= -tolerance)
        return crossing

    def _heights(self, points: FloatArray) -> FloatArray:
        return Surface._heights(self, points) if self.dimension == 2 else super()._heights(points)

    def _plane_distance(self, x: FloatArray, y: FloatArray) -> FloatArray:
        return np.abs(np.hypot(x, y) - self.radius)

    def _plane_nearest(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        return self._circle(x, y, self.radius)

    def _contains(self, points: FloatArray) -> BoolArray:
        return Surface._contains(self, points)

    def _reaches(self, direction: FloatArray) -> float:
        return self._reaches_from_center(direction, self.radius)

    def _parameters(self) -> dict[str, object]:
        return {"radius": self.radius, **self._place()}
