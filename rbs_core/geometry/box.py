"""Boxes along the axes, and turned ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry.base import Geometry
from rbs_core.geometry.described import as_direction, as_place, coordinate_tuple
from rbs_core.geometry.frames import along, rows_along, square, unit
from rbs_core.geometry.similarity import Similarity
from rbs_core.geometry.solid import Solid
from rbs_core.space.checks import BoolArray, Bounds, FloatArray, as_text, as_vectors


class Box(Geometry):
    """Interval, rectangle or cuboid along the axes; closed: its surface belongs to it.

    Two boxes are equal when their bounds are.

    Args:
        size: edges (m), positive, +inf for a bar or a slab; shape (d,), or one number for all components of `center`.
        center: middle (m), shape (d,), or one number for all components of `size`. Both numbers: an interval in 1-D.

    Raises:
        BadInput: for a size that is not positive and for different numbers of components.
    """

    def __init__(self, size: ArrayLike, center: ArrayLike = 0.0) -> None:
        edges, middle = as_vectors(size, center, ("size", "center"), infinite=True)
        for axis, (edge, place) in enumerate(zip(edges.tolist(), middle.tolist(), strict=True)):
            if edge <= 0.0:
                raise BadInput(f"size[{axis}] = {edge} is not positive; give the full edge of the box, above 0")
            if not np.isfinite(place):
                raise BadInput(f"center[{axis}] = {place} is not finite; use Box.between for a half-infinite box")
        self._set(middle - edges / 2, middle + edges / 2)
        self._text = f"Box(size={as_text(edges)}, center={as_text(middle)})"

    @classmethod
    def between(cls, lower: ArrayLike, upper: ArrayLike) -> Box:
        """The box between two corners.

        Args:
            lower: smallest coordinates (m), shape (d,) or one number, may be -inf.
            upper: largest coordinates (m), shape (d,) or one number, may be +inf.

        Raises:
            BadInput: when upper is not above lower.
        """
        low, high = as_vectors(lower, upper, ("lower", "upper"), infinite=True)
        for axis, (least, most) in enumerate(zip(low.tolist(), high.tolist(), strict=True)):
            if most <= least:
                raise BadInput(f"upper[{axis}] = {most} is not above lower[{axis}] = {least}; give upper above lower")
        box = cls.__new__(cls)
        box._set(low, high)
        box._text = f"Box.between(lower={as_text(low)}, upper={as_text(high)})"
        return box

    def _set(self, lower: FloatArray, upper: FloatArray) -> None:
        self.lower, self.upper = lower, upper
        lower.flags.writeable = upper.flags.writeable = False

    @property
    def dimension(self) -> int:
        """Number of edges."""
        return self.lower.size

    @property
    def bounds(self) -> Bounds:
        """The two corners."""
        return self.lower.copy(), self.upper.copy()

    @property
    def size(self) -> float:
        """The diagonal of the finite edges."""
        edges = self.upper - self.lower
        return float(np.linalg.norm(edges[np.isfinite(edges)]))

    def _contains(self, points: FloatArray) -> BoolArray:
        inside = np.ones(len(points), dtype=np.bool_)
        for axis in range(self.dimension):
            inside &= points[:, axis] >= self.lower[axis]
            inside &= points[:, axis] <= self.upper[axis]
        return inside

    def _distance(self, points: FloatArray) -> FloatArray:
        return distance_of_box(points, self.lower, self.upper)

    def _projection(self, points: FloatArray) -> FloatArray:
        return nearest_of_box(points, self.lower, self.upper)

    def _reaches(self, direction: FloatArray) -> float:
        along = np.flatnonzero(direction).tolist()  # a zero component adds nothing, not even 0 times infinity
        ends = np.where(direction > 0.0, self.upper, self.lower)
        return float(sum(direction[axis] * ends[axis] for axis in along))

    def _transformed(self, by: Similarity) -> Geometry:
        edges = np.abs(by.turn)
        if ((edges == 0.0) | (edges == 1.0)).all():  # along the axes again
            return Box.between(*_image(self.lower, self.upper, by))
        if not np.isfinite([self.lower, self.upper]).all():
            return super()._transformed(by)
        corner = by.points(self.lower[None])[0]
        edges = by.vectors(np.diag(self.upper - self.lower))
        if self.dimension == 2:
            from rbs_core.geometry.polygon import Rectangle  # late: polygons are made of surfaces, those of geometries

            return Rectangle(corner, *edges)
        return Cuboid(corner, *edges)

    def _parameters(self) -> dict[str, object]:
        return {"lower": coordinate_tuple(self.lower), "upper": coordinate_tuple(self.upper)}

    def __repr__(self) -> str:
        return self._text


class Cuboid(Solid):
    """A box in any direction: three edges at right angles from one corner.

    Args:
        corner: one of the corners (m), shape (3,).
        first: edge from there (m), a vector, shape (3,).
        second: edge at right angles to the first.
        third: edge at right angles to both.

    Raises:
        BadInput: for edges without length or not at right angles, and for other numbers of components.
    """

    _kinds = {"corner": "point", "first": "vector", "second": "vector", "third": "vector"}

    def __init__(self, corner: ArrayLike, first: ArrayLike, second: ArrayLike, third: ArrayLike) -> None:
        names = ("first", "second", "third")
        self.corner = as_place(corner, "corner", 3)
        self.edges = [as_direction(edge, name, 3) for name, edge in zip(names, (first, second, third), strict=True)]
        require_right_angles(self.edges, names, "a Prism")
        self._axes = np.array([unit(edge) for edge in self.edges])
        self._middle: FloatArray = self.corner + sum(self.edges) / 2
        self._half = np.array([float(np.linalg.norm(edge)) / 2 for edge in self.edges])

    @property
    def dimension(self) -> int:
        """3."""
        return 3

    def _local(self, points: FloatArray) -> FloatArray:
        """Coordinates along the edges, from the middle."""
        return np.stack([along(points, self._middle, axis) for axis in self._axes], axis=1)

    def _distance(self, points: FloatArray) -> FloatArray:
        return distance_of_box(self._local(points), -self._half, self._half)

    def _projection(self, points: FloatArray) -> FloatArray:
        nearest = nearest_of_box(self._local(points), -self._half, self._half)
        return self._middle + sum(rows_along(nearest[:, axis], self._axes[axis]) for axis in range(3))

    def _reaches(self, direction: FloatArray) -> float:
        return float(self._middle @ direction + sum(abs(edge @ direction) for edge in self.edges) / 2)

    def _parameters(self) -> dict[str, object]:
        edges = zip(("first", "second", "third"), map(coordinate_tuple, self.edges), strict=True)
        return {"corner": coordinate_tuple(self.corner), **dict(edges)}


def require_right_angles(edges: list[FloatArray], names: tuple[str, ...], instead: str) -> None:
    """Refuse edges that are not at right angles to each other.

    Raises:
        BadInput: with the two edges, and what can have any angles.
    """
    for i, edge in enumerate(edges):
        for j in range(i):
            if not square(unit(edges[j]), unit(edge)):
                raise BadInput(
                    f"{names[j]} = {as_text(edges[j])} and {names[i]} = {as_text(edge)} are not at right angles; "
                    f"give edges that are, or {instead}"
                )


def distance_of_box(points: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Signed distance of points (n, d) from a box along the axes."""
    beyond = np.maximum(lower - points, points - upper)
    outside: FloatArray = np.sqrt((np.maximum(beyond, 0.0) ** 2).sum(axis=1))
    outside += np.minimum(beyond.max(axis=1), 0.0)
    return outside


def nearest_of_box(points: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Nearest points of the surface of a box along the axes."""
    nearest = np.clip(points, lower, upper)
    inside = np.flatnonzero((nearest == points).all(axis=1))
    depth = np.concatenate([points[inside] - lower, upper - points[inside]], axis=1)
    face = depth.argmin(axis=1)
    axis = face % points.shape[1]
    nearest[inside, axis] = np.where(face < points.shape[1], lower[axis], upper[axis])
    return nearest


def _image(lower: FloatArray, upper: FloatArray, by: Similarity) -> Bounds:
    """The corners of a box after quarter turns, mirror images, shifts and changes of size; they may be infinite."""
    low, high = np.empty_like(lower), np.empty_like(upper)
    for axis, row in enumerate(by.turn):
        source = int(np.flatnonzero(row)[0])
        ends = sorted((row[source] * lower[source], row[source] * upper[source]))
        low[axis], high[axis] = (by.factor * end + by.shift[axis] for end in ends)
    return low, high
