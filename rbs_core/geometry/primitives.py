"""The geometries that others are made of: half space, slab, bar, ball."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry.base import Geometry
from rbs_core.geometry.described import as_direction, coordinate_tuple, no_bounds
from rbs_core.geometry.frames import along, directions, lengths, parallel, perpendicular, rows_along, square, unit
from rbs_core.geometry.planes import left_by
from rbs_core.geometry.solid import Solid
from rbs_core.space.checks import BoolArray, Bounds, FloatArray, as_number, as_text, as_vector, as_vectors


class HalfSpace(Geometry):
    """The points on one side of a plane (of a line in 2-D, of a point in 1-D), the plane included.

    Args:
        point: any point of the plane (m), shape (d,), or one number for all components.
        normal: vector of any length but 0, pointing into the half space, shape (d,).

    Raises:
        BadInput: for a normal without length and for different numbers of components.
    """

    _kinds = {"point": "point", "normal": "direction"}

    def __init__(self, point: ArrayLike, normal: ArrayLike) -> None:
        self.point, inward = as_vectors(point, normal, ("point", "normal"))
        self.normal = as_direction(inward, "normal", inward.size)
        self._length = float(np.linalg.norm(self.normal))

    @property
    def dimension(self) -> int:
        """Number of components of `point`."""
        return self.point.size

    @property
    def bounds(self) -> Bounds:
        """Finite on one side where the normal is along an axis, otherwise infinite."""
        return self._inside(*no_bounds(self.dimension))

    def _height(self, points: FloatArray) -> FloatArray:
        """Signed distance from the plane times the length of the normal, positive inside."""
        return along(points, self.point, self.normal)

    def _contains(self, points: FloatArray) -> BoolArray:
        return self._height(points) >= 0.0

    def _distance(self, points: FloatArray) -> FloatArray:
        return -self._height(points) / self._length

    def _projection(self, points: FloatArray) -> FloatArray:
        return points - rows_along(self._height(points) / self._length, self.normal / self._length)

    def _reaches(self, direction: FloatArray) -> float:
        outward = -self.normal / self._length
        leads_out = parallel(outward, unit(direction)) and outward @ direction > 0.0
        return float(self.point @ direction) if leads_out else np.inf

    def _inside(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        return left_by(lower, upper, self.point, self.normal)

    def _outside(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        return left_by(lower, upper, self.point, -self.normal)

    def _parameters(self) -> dict[str, object]:
        return {"point": coordinate_tuple(self.point), "normal": coordinate_tuple(self.normal)}


class Slab(Solid):
    """The points between two parallel planes: an infinite plate in 3-D, a strip in 2-D, an interval in 1-D.

    Args:
        thickness: distance of the two planes (m), positive.
        center: any point halfway between them (m), shape (d,), or one number for all components.
        normal: vector of any length but 0, at right angles to the planes, shape (d,).

    Raises:
        BadInput: for a thickness that is not positive, a normal without length, and different numbers of components.
    """

    _kinds = {"thickness": "length", "center": "point", "normal": "direction"}

    def __init__(self, thickness: float, center: ArrayLike, normal: ArrayLike) -> None:
        self.thickness = as_number(thickness, "thickness", positive=True)
        self.center, across = as_vectors(center, normal, ("center", "normal"))
        self.normal = as_direction(across, "normal", across.size)
        self._unit = unit(self.normal)

    @property
    def dimension(self) -> int:
        """Number of components of `center`."""
        return self.center.size

    @property
    def size(self) -> float:
        """The thickness."""
        return self.thickness

    def _distance(self, points: FloatArray) -> FloatArray:
        return np.abs(along(points, self.center, self._unit)) - self.thickness / 2

    def _projection(self, points: FloatArray) -> FloatArray:
        height = along(points, self.center, self._unit)
        return points + rows_along(np.copysign(self.thickness / 2, height) - height, self._unit)

    def _reaches(self, direction: FloatArray) -> float:
        if not parallel(self._unit, unit(direction)):
            return np.inf
        return float(self.center @ direction + self.thickness / 2 * np.linalg.norm(direction))

    def _inside(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        for side in (-self._unit, self._unit):
            lower, upper = left_by(lower, upper, self.center + self.thickness / 2 * side, -side)
        return lower, upper

    def _parameters(self) -> dict[str, object]:
        return {
            "thickness": self.thickness, "center": coordinate_tuple(self.center),
            "normal": coordinate_tuple(self.normal),
        }  # fmt: skip


class Bar(Solid):
    """The points around a line: an infinite cylinder in 3-D, a strip in 2-D.

    Args:
        radius: (m), positive.
        point: any point of the axis (m), shape (2,) or (3,).
        axis: direction of the axis, a vector of any length but 0, of the same shape.

    Raises:
        BadInput: for a radius that is not positive, an axis without length, and other numbers of components.
    """

    _kinds = {"radius": "length", "point": "point", "axis": "direction"}

    def __init__(self, radius: float, point: ArrayLike, axis: ArrayLike) -> None:
        self.radius = as_number(radius, "radius", positive=True)
        self.point, line = as_vectors(point, axis, ("point", "axis"))
        if self.point.size == 1:
            raise BadInput(f"point = {as_text(self.point)} has 1 component; give 2 or 3 (in 1-D: a Slab or a Box)")
        self.axis = as_direction(line, "axis", line.size)
        self._unit = unit(self.axis)

    @property
    def dimension(self) -> int:
        """Number of components of `point`."""
        return self.point.size

    @property
    def size(self) -> float:
        """The diameter."""
        return 2.0 * self.radius

    def _from_axis(self, points: FloatArray) -> FloatArray:
        """Vectors from the axis to points, at right angles to it."""
        return points - self.point - rows_along(along(points, self.point, self._unit), self._unit)

    def _distance(self, points: FloatArray) -> FloatArray:
        return lengths(self._from_axis(points)) - self.radius

    def _projection(self, points: FloatArray) -> FloatArray:
        length, outward = directions(self._from_axis(points), perpendicular(self._unit))
        return points + (self.radius - length)[:, None] * outward

    def _reaches(self, direction: FloatArray) -> float:
        if not square(self._unit, unit(direction)):
            return np.inf
        return float(self.point @ direction + self.radius * np.linalg.norm(direction))

    def _parameters(self) -> dict[str, object]:
        return {
            "radius": self.radius, "point": coordinate_tuple(self.point), "axis": coordinate_tuple(self.axis),
        }  # fmt: skip


class Ball(Solid):
    """Interval, disk or ball; closed: its surface belongs to it.

    Args:
        radius: (m), positive.
        center: middle (m), shape (d,); its components make the dimension, a number means 1-D.

    Raises:
        BadInput: for a radius that is not positive and for a center of more than 3 components.
    """

    _kinds = {"radius": "length", "center": "point"}

    def __init__(self, radius: float, center: ArrayLike) -> None:
        self.radius = as_number(radius, "radius", positive=True)
        self.center = as_vector(center, "center")

    @property
    def dimension(self) -> int:
        """Number of components of `center`."""
        return self.center.size

    @property
    def bounds(self) -> Bounds:
        """The cube around the ball."""
        return self.center - self.radius, self.center + self.radius

    def _from_center(self, points: FloatArray) -> FloatArray:
        """Distance from the center."""
        squares: FloatArray = (points[:, 0] - self.center[0]) ** 2
        for axis in range(1, self.dimension):
            squares += (points[:, axis] - self.center[axis]) ** 2
        return np.sqrt(squares, out=squares)

    def _contains(self, points: FloatArray) -> BoolArray:
        return self._from_center(points) <= self.radius

    def _distance(self, points: FloatArray) -> FloatArray:
        return self._from_center(points) - self.radius

    def _projection(self, points: FloatArray) -> FloatArray:
        _, outward = directions(points - self.center, np.eye(self.dimension)[0])
        return self.center + self.radius * outward

    def _reaches(self, direction: FloatArray) -> float:
        return float(self.center @ direction + self.radius * np.linalg.norm(direction))

    def _parameters(self) -> dict[str, object]:
        return {"radius": self.radius, "center": coordinate_tuple(self.center)}
