"""Solids around an axis: cylinder, tube, cone, torus; and capsules, which are round in 2-D as well.

The distance from such a solid is the one from its profile in the half plane (r, z) through the point, where r is the
distance from the axis and z the coordinate along it. Profiles that meet the axis are continued to the other side of it:
the axis is no surface.
"""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry import outline
from rbs_core.geometry.described import as_direction, as_place, as_smaller, coordinate_tuple
from rbs_core.geometry.frames import along, directions, lengths, perpendicular, rows_along, unit
from rbs_core.geometry.solid import Solid
from rbs_core.geometry.straight import Segment
from rbs_core.space.checks import BoolArray, FloatArray, as_number, as_text, as_vectors


class Revolved(Solid):
    """A solid around an axis, given by its profile."""

    _origin: FloatArray
    _axis: FloatArray  # of length 1

    @property
    def dimension(self) -> int:
        """3."""
        return 3

    @abstractmethod
    def _profile_distance(self, r: FloatArray, z: FloatArray) -> FloatArray:
        """Signed distance from the profile, r >= 0."""

    @abstractmethod
    def _profile_nearest(self, r: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Nearest points of the profile, r >= 0."""

    def _split(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Vectors from the axis to points, at right angles to it, and coordinates along it."""
        z = along(points, self._origin, self._axis)
        return points - self._origin - rows_along(z, self._axis), z

    def _distance(self, points: FloatArray) -> FloatArray:
        outward, z = self._split(points)
        return self._profile_distance(lengths(outward), z)

    def _projection(self, points: FloatArray) -> FloatArray:
        outward, z = self._split(points)
        r, outward = directions(outward, perpendicular(self._axis))
        nearest_r, nearest_z = self._profile_nearest(r, z)
        return self._origin + nearest_r[:, None] * outward + rows_along(nearest_z, self._axis)

    def _across(self, direction: FloatArray) -> float:
        """Length of the part of a vector that is at right angles to the axis."""
        return float(np.linalg.norm(direction - (direction @ self._axis) * self._axis))


class StraightProfile(Revolved):
    """A solid around the way from one point to another, whose profile has straight edges."""

    start: FloatArray
    end: FloatArray
    _corners: FloatArray  # of the profile, shape (k, 2)

    def _set_axis(self, start: ArrayLike, end: ArrayLike) -> float:
        """Takes the two ends of the axis; returns its length."""
        self.start, self.end = as_place(start, "start", 3), as_place(end, "end", 3)
        length = float(np.linalg.norm(self.end - self.start))
        if length == 0.0:
            raise BadInput(f"start = end = {as_text(self.start)}: no axis; give two different points")
        self._origin, self._axis = self.start, (self.end - self.start) / length
        return length

    def _profile_distance(self, r: FloatArray, z: FloatArray) -> FloatArray:
        return outline.distance_of(self._corners, r, z)

    def _profile_nearest(self, r: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        _, nearest_r, nearest_z = outline.nearest_of(self._corners, r, z)
        return np.abs(nearest_r), nearest_z

    def _contains(self, points: FloatArray) -> BoolArray:
        outward, z = self._split(points)
        return outline.covered_by(self._corners, lengths(outward), z, self._round_off(points))

    def _reaches(self, direction: FloatArray) -> float:
        across, slope = self._across(direction), float(self._axis @ direction)
        return float(
            self.start @ direction + (np.abs(self._corners[:, 0]) * across + self._corners[:, 1] * slope).max()
        )

    def _ends(self) -> dict[str, object]:
        return {"start": coordinate_tuple(self.start), "end": coordinate_tuple(self.end)}


class Cylinder(StraightProfile):
    """A cylinder with flat ends at right angles to its axis (infinite: `Bar`).

    Args:
        radius: (m), positive.
        start: middle of one end (m), shape (3,).
        end: middle of the other end (m).

    Raises:
        BadInput: for a radius that is not positive, and for ends that coincide.
    """

    _kinds = {"radius": "length", "start": "point", "end": "point"}

    def __init__(self, radius: float, start: ArrayLike, end: ArrayLike) -> None:
        self.radius = as_number(radius, "radius", positive=True)
        length = self._set_axis(start, end)
        self._corners = _rectangle(-self.radius, self.radius, length)

    def _parameters(self) -> dict[str, object]:
        return {"radius": self.radius, **self._ends()}


class Tube(StraightProfile):
    """A cylinder with a cylindrical hole along its axis.

    Args:
        outer: outer radius (m), positive.
        inner: inner radius (m), positive, below the outer one.
        start: middle of one end (m), shape (3,).
        end: middle of the other end (m).

    Raises:
        BadInput: for radii that are not positive or in the other order, and for ends that coincide.
    """

    _kinds = {"outer": "length", "inner": "length", "start": "point", "end": "point"}

    def __init__(self, outer: float, inner: float, start: ArrayLike, end: ArrayLike) -> None:
        self.outer = as_number(outer, "outer", positive=True)
        self.inner = as_smaller(inner, self.outer, ("inner", "outer"))
        length = self._set_axis(start, end)
        self._corners = _rectangle(self.inner, self.outer, length)

    def _parameters(self) -> dict[str, object]:
        return {"outer": self.outer, "inner": self.inner, **self._ends()}


class Cone(StraightProfile):
    """A cone, or a frustum: what two radii along an axis make.

    Args:
        radius: at the start (m), positive.
        start: middle of the base (m), shape (3,).
        end: the tip, or the middle of the other end of a frustum (m).
        top: radius at the end (m), 0 for a tip.

    Raises:
        BadInput: for a radius that is not positive, a negative top, and for ends that coincide.
    """

    _kinds = {"radius": "length", "start": "point", "end": "point", "top": "length"}

    def __init__(self, radius: float, start: ArrayLike, end: ArrayLike, top: float = 0.0) -> None:
        self.radius = as_number(radius, "radius", positive=True)
        self.top = as_number(top, "top")
        if self.top < 0.0:
            raise BadInput(f"top = {self.top} is negative; give a radius from 0")
        length = self._set_axis(start, end)
        tip = [[0.0, length]] if self.top == 0.0 else [[self.top, length], [-self.top, length]]
        self._corners = np.array([[-self.radius, 0.0], [self.radius, 0.0], *tip])

    def _parameters(self) -> dict[str, object]:
        return {"radius": self.radius, **self._ends(), **({"top": self.top} if self.top else {})}


class Torus(Revolved):
    """A ring of circular section around an axis.

    Args:
        major: radius of the circle in the middle of the section (m), positive.
        minor: radius of the section (m), positive, below the major one.
        center: middle (m), shape (3,).
        axis: direction of the axis, a vector of any length but 0.

    Raises:
        BadInput: for radii that are not positive or in the other order, and for an axis without length.
    """

    _kinds = {"major": "length", "minor": "length", "center": "point", "axis": "direction"}

    def __init__(self, major: float, minor: float, center: ArrayLike, axis: ArrayLike) -> None:
        self.major = as_number(major, "major", positive=True)
        self.minor = as_smaller(minor, self.major, ("minor", "major"))
        self.center, self.axis = as_place(center, "center", 3), as_direction(axis, "axis", 3)
        self._origin, self._axis = self.center, unit(self.axis)

    def _profile_distance(self, r: FloatArray, z: FloatArray) -> FloatArray:
        return np.hypot(r - self.major, z) - self.minor

    def _profile_nearest(self, r: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        away = np.stack([r - self.major, z], axis=1)
        _, outward = directions(away, np.array([1.0, 0.0]))
        return self.major + self.minor * outward[:, 0], self.minor * outward[:, 1]

    def _reaches(self, direction: FloatArray) -> float:
        reach = self.major * self._across(direction) + self.minor * np.linalg.norm(direction)
        return float(self.center @ direction + reach)

    def _parameters(self) -> dict[str, object]:
        return {
            "major": self.major, "minor": self.minor, "center": coordinate_tuple(self.center),
            "axis": coordinate_tuple(self.axis),
        }  # fmt: skip


class Capsule(Solid):
    """The points around a segment: a cylinder with round ends in 3-D, a stadium in 2-D.

    Args:
        radius: (m), positive.
        start: one end of the segment (m), shape (2,) or (3,).
        end: the other end (m).

    Raises:
        BadInput: for a radius that is not positive, and for ends that coincide (those would be a `Ball`).
    """

    _kinds = {"radius": "length", "start": "point", "end": "point"}

    def __init__(self, radius: float, start: ArrayLike, end: ArrayLike) -> None:
        self.radius = as_number(radius, "radius", positive=True)
        self.start, self.end = as_vectors(start, end, ("start", "end"))
        self._core = Segment(self.start, self.end)

    @property
    def dimension(self) -> int:
        """Number of components of the ends."""
        return self.start.size

    def _distance(self, points: FloatArray) -> FloatArray:
        return self._core._distance(points) - self.radius

    def _projection(self, points: FloatArray) -> FloatArray:
        core = self._core._projection(points)
        _, outward = directions(points - core, perpendicular(self._core._along))
        return core + self.radius * outward

    def _reaches(self, direction: FloatArray) -> float:
        return self._core._reaches(direction) + self.radius * float(np.linalg.norm(direction))

    def _parameters(self) -> dict[str, object]:
        return {"radius": self.radius, "start": coordinate_tuple(self.start), "end": coordinate_tuple(self.end)}


def _rectangle(left: float, right: float, height: float) -> FloatArray:
    """Corners (4, 2) of a rectangle that stands on z = 0."""
    return np.array([[left, 0.0], [right, 0.0], [right, height], [left, height]])
