"""The geometries that others are made of: half space, box, ball, everything, nothing, any predicate."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry.base import Geometry, coordinate_tuple, empty_bounds, no_bounds
from rbs_core.space.checks import BoolArray, Bounds, FloatArray, as_number, as_text, as_vector, as_vectors


class HalfSpace(Geometry):
    """The points on one side of a plane (of a line in 2-D, of a point in 1-D), the plane included.

    Args:
        point: any point of the plane (m), shape (d,), or one number for all components.
        normal: vector of any length but 0, pointing into the half space, shape (d,).

    Raises:
        BadInput: for a normal without length and for different numbers of components.
    """

    def __init__(self, point: ArrayLike, normal: ArrayLike) -> None:
        self.point, self.normal = as_vectors(point, normal, ("point", "normal"))
        if not self.normal.any():
            raise BadInput(f"normal = {as_text(self.normal)} has no length; point it into the half space")

    @property
    def dimension(self) -> int:
        """Number of components of `point`."""
        return self.point.size

    @property
    def bounds(self) -> Bounds:
        """Finite on one side where the normal is along an axis, otherwise infinite."""
        lower, upper = no_bounds(self.dimension)
        along = np.flatnonzero(self.normal)
        if along.size == 1:
            side = lower if self.normal[along[0]] > 0.0 else upper
            side[along] = self.point[along]
        return lower, upper

    def _height(self, points: FloatArray) -> FloatArray:
        """Signed distance from the plane times the length of the normal, positive inside."""
        height: FloatArray = (points[:, 0] - self.point[0]) * self.normal[0]
        for axis in range(1, self.dimension):
            height += (points[:, axis] - self.point[axis]) * self.normal[axis]
        return height

    def _contains(self, points: FloatArray) -> BoolArray:
        return self._height(points) >= 0.0

    def _distance(self, points: FloatArray) -> FloatArray:
        return -self._height(points) / float(np.linalg.norm(self.normal))

    def _parameters(self) -> dict[str, object]:
        return {"point": coordinate_tuple(self.point), "normal": coordinate_tuple(self.normal)}


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

    def _contains(self, points: FloatArray) -> BoolArray:
        inside = np.ones(len(points), dtype=np.bool_)
        for axis in range(self.dimension):
            inside &= points[:, axis] >= self.lower[axis]
            inside &= points[:, axis] <= self.upper[axis]
        return inside

    def _distance(self, points: FloatArray) -> FloatArray:
        beyond = np.maximum(self.lower - points, points - self.upper)
        outside: FloatArray = np.sqrt((np.maximum(beyond, 0.0) ** 2).sum(axis=1))
        outside += np.minimum(beyond.max(axis=1), 0.0)
        return outside

    def _parameters(self) -> dict[str, object]:
        return {"lower": coordinate_tuple(self.lower), "upper": coordinate_tuple(self.upper)}

    def __repr__(self) -> str:
        return self._text


class Ball(Geometry):
    """Interval, disk or ball; closed: its surface belongs to it.

    Args:
        radius: (m), positive.
        center: middle (m), shape (d,); its components make the dimension, a number means 1-D.

    Raises:
        BadInput: for a radius that is not positive and for a center of more than 3 components.
    """

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

    def _parameters(self) -> dict[str, object]:
        return {"radius": self.radius, "center": coordinate_tuple(self.center)}


class Everywhere(Geometry):
    """All points, in any dimension."""

    @property
    def dimension(self) -> None:
        """Any."""
        return

    @property
    def bounds(self) -> Bounds:
        """Infinite."""
        return no_bounds(None)

    def _contains(self, points: FloatArray) -> BoolArray:
        return np.ones(len(points), dtype=np.bool_)

    def _distance(self, points: FloatArray) -> FloatArray:
        return np.full(len(points), -np.inf)

    def _parameters(self) -> dict[str, object]:
        return {}


class Nowhere(Geometry):
    """No points, in any dimension."""

    @property
    def dimension(self) -> None:
        """Any."""
        return

    @property
    def bounds(self) -> Bounds:
        """Those of nothing: +inf and -inf."""
        return empty_bounds(None)

    def _contains(self, points: FloatArray) -> BoolArray:
        return np.zeros(len(points), dtype=np.bool_)

    def _distance(self, points: FloatArray) -> FloatArray:
        return np.full(len(points), np.inf)

    def _parameters(self) -> dict[str, object]:
        return {}


class Where(Geometry):
    """The points for which a plain function is true: `Where(lambda points: points[:, 1] > points[:, 0] ** 2)`.

    It has no bounds (intersect it with a Box to discretize it) and knows no distance.

    Args:
        predicate: function of an array of points (n, d) that returns an array of n truth values.
        dimension: the dimension it works in, None for any.

    Raises:
        BadInput: for something that cannot be called, and in `contains` when the result is not n truth values.
    """

    def __init__(self, predicate: Callable[[FloatArray], BoolArray], dimension: int | None = None) -> None:
        if not callable(predicate):
            raise BadInput(f"predicate = {predicate!r} cannot be called; give a function of points (n, d)")
        if dimension not in (None, 1, 2, 3):
            raise BadInput(f"dimension = {dimension!r} is not 1, 2 or 3; leave it out for any")
        self.predicate = predicate
        self._dimension = dimension

    @property
    def dimension(self) -> int | None:
        """As given."""
        return self._dimension

    @property
    def bounds(self) -> Bounds:
        """Infinite: a function does not tell."""
        return no_bounds(self._dimension)

    def _contains(self, points: FloatArray) -> BoolArray:
        lent = points.view()
        lent.flags.writeable = False
        inside = np.asarray(self.predicate(lent))
        if inside.shape != (len(points),) or inside.dtype != np.bool_:
            raise BadInput(
                f"{self!r} returned {inside.dtype} of shape {inside.shape} for {len(points)} points; "
                f"return one truth value per point, shape ({len(points)},)"
            )
        return inside

    def _parameters(self) -> dict[str, object]:
        return {"predicate": self.predicate} | ({} if self._dimension is None else {"dimension": self._dimension})
