"""What every geometry can do: say which points are in, how far away they are, move, and join with others."""

from __future__ import annotations

from abc import abstractmethod
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput
from rbs_core.geometry.moving import Movable
from rbs_core.space.checks import BoolArray, Bounds, FloatArray, as_number, as_points

# Part of the size of a geometry that still counts as on its surface.
TOLERANCE = 1e-9

# Part of the largest coordinate that counts as on the surface in any case: what round-off makes of a distance from it.
ROUND_OFF = 16 * float(np.finfo(np.float64).eps)


class Status(IntEnum):
    """Where a point is; the sign of its distance."""

    INSIDE = -1
    ON = 0
    OUTSIDE = 1


class Geometry(Movable):
    """A set of points in 1, 2 or 3 dimensions.

    Joined by operators: `a | b` union, `a & b` intersection, `a - b` difference, `a ^ b` symmetric difference,
    `~a` everything else.

    A geometry of one's own has `dimension`, `bounds`, `_parameters` and `_contains`, and `_distance` where it is known.
    The two functions get float64 points (n, d) that are already checked.
    """

    @property
    @abstractmethod
    def bounds(self) -> Bounds:
        """Smallest and largest coordinates (m), shape (d,) each, -inf and +inf where unbounded.

        All points are within; there need not be points at the bounds. A geometry known to be empty has +inf and -inf.
        Where `dimension` is None the shape is (1,), which broadcasts.
        """

    @property
    def size(self) -> float:
        """Typical length (m): the diagonal of the bounds, of unbounded shapes a thickness, 0 where there is none."""
        lower, upper = self.bounds
        finite = np.isfinite(lower).all() and np.isfinite(upper).all()
        return float(np.linalg.norm(upper - lower)) if finite else 0.0

    def contains(self, points: ArrayLike) -> BoolArray:
        """Which points are in.

        Args:
            points: coordinates (m), shape (n, d).

        Returns:
            True where the point belongs to the geometry, shape (n,).

        Raises:
            BadInput: for points of another dimension or shape, and for NaN or infinity.
        """
        return self._contains(self._checked(points))

    def distance(self, points: ArrayLike) -> FloatArray:
        """Signed distance to the surface (m): negative inside, positive outside.

        Exact for single shapes. For combined geometries, and for those placed with stretched axes, it is a bound: the
        sign is right and the surface is at least so far away.

        Args:
            points: coordinates (m), shape (n, d).

        Returns:
            Distances, shape (n,).

        Raises:
            BadInput: as `contains`, and when the geometry knows no distance.
        """
        return self._distance(self._checked(points))

    def status(self, points: ArrayLike, tolerance: float | None = None) -> NDArray[np.int8]:
        """Whether points are inside, on the surface or outside: the sign of the distance.

        Args:
            points: coordinates (m), shape (n, d).
            tolerance: largest distance from the surface that counts as on it (m); 1e-9 of the size of the geometry,
                and the round-off of the coordinates, if None.

        Returns:
            `Status.INSIDE` (-1), `Status.ON` (0) or `Status.OUTSIDE` (1), shape (n,).

        Raises:
            BadInput: as `distance`, and for a negative tolerance.
        """
        array = self._checked(points)
        if tolerance is None:
            return self._status(array, self._tolerance(array))
        margin = as_number(tolerance, "tolerance")
        if margin < 0.0:
            raise BadInput(f"tolerance = {margin} is negative; give a length from 0, or leave it out")
        return self._status(array, np.full(len(array), margin))

    def projection(self, points: ArrayLike) -> FloatArray:
        """The points of the surface that are nearest to given ones.

        Exact for single shapes; where several are equally near, it is one of them. For combined geometries it is exact
        where the nearest point of a member belongs to the surface of the whole. Elsewhere, and for geometries placed
        with stretched axes, it is searched downhill and may be a point that is nearest only among its neighbors.

        Args:
            points: coordinates (m), shape (n, d).

        Returns:
            Coordinates (m), shape (n, d).

        Raises:
            BadInput: as `distance`, and when the geometry has no surface.
        """
        return self._projection(self._checked(points))

    @abstractmethod
    def _contains(self, points: FloatArray) -> BoolArray:
        """Which of the checked points are in."""

    def _distance(self, points: FloatArray) -> FloatArray:
        """Signed distance of the checked points."""
        raise BadInput(f"{self!r} knows no distance; use a primitive such as Box or Ball, or only contains()")

    def _status(self, points: FloatArray, tolerance: FloatArray) -> NDArray[np.int8]:
        """Status of the checked points; one tolerance for each."""
        distance = self._distance(points)
        return ((distance > tolerance).astype(np.int8) - (distance < -tolerance)).astype(np.int8)

    def _projection(self, points: FloatArray) -> FloatArray:
        """Nearest points of the surface, searched with nothing but the distance."""
        # Here and elsewhere: imported late, because these modules derive from Geometry.
        from rbs_core.geometry.nearest import searched

        return searched([self._distance], points, points, self.size)

    def _reaches(self, direction: FloatArray) -> float:
        """Largest coordinate along a vector (d,), of any length: that of the bounds unless a shape knows better."""
        lower, upper = (np.broadcast_to(side, direction.shape) for side in self.bounds)
        if not (lower <= upper).all():
            return -np.inf
        along = np.flatnonzero(direction)  # a zero component adds nothing, not even 0 times infinity
        ends = np.where(direction > 0.0, upper, lower)
        return float(sum(direction[axis] * ends[axis] for axis in along.tolist()))

    def _inside(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        """Bounds of what of this geometry lies in a box, which may be infinite or empty."""
        own_lower, own_upper = self.bounds
        return np.maximum(lower, own_lower), np.minimum(upper, own_upper)

    def _outside(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        """Bounds of what this geometry leaves of a box."""
        return lower, upper

    def _tolerance(self, points: FloatArray) -> FloatArray:
        """How far from the surface each point still counts as on it."""
        return TOLERANCE * self.size + self._round_off(points)

    def _round_off(self, points: FloatArray) -> FloatArray:
        """What round-off makes of a distance from the surface, for each point."""
        reach = np.full(len(points), self._farthest())
        for column in points.T:
            np.maximum(reach, np.abs(column), out=reach)
        return ROUND_OFF * reach

    def _farthest(self) -> float:
        """Largest absolute coordinate (m) of what it is made of: of the bounds, and of the points it is given by."""
        ends = np.abs(np.concatenate(self.bounds))
        given = [
            np.abs(np.array(value, dtype=np.float64)).max()
            for name, value in self._parameters().items()
            if self._kinds.get(name) in ("point", "points")
        ]
        return float(np.max([*ends[np.isfinite(ends)], *given], initial=0.0))

    def _checked(self, points: ArrayLike) -> FloatArray:
        array = as_points(points)
        self._require_dimension(array.shape[1], "points")
        return array

    # -- joined -------------------------------------------------------------------------------------------------------

    def intersection(self, other: Geometry) -> Geometry:
        """What two single shapes share, as a single shape, or `Nowhere()`.

        `Nowhere()` also where they do share points but no single shape describes them, such as the lens of two balls;
        `a & b` describes these.

        Raises:
            BadInput: for something that is no geometry, and for different dimensions.
        """
        from rbs_core.geometry.meeting import intersection

        return intersection(self, other)

    def projected(self, on: Geometry) -> Geometry:
        """The points of a shape that are nearest to those of this one, as a single shape, or `Nowhere()`.

        `Nowhere()` also where no single shape describes them.

        Args:
            on: point, line or plane; for a point, any shape with a surface.

        Raises:
            BadInput: for something that is no geometry, and for different dimensions.
        """
        from rbs_core.geometry.projecting import projection

        return projection(self, on)

    def _joined(self, operation: str, other: Geometry) -> Geometry:
        from rbs_core.geometry.combined import joined

        return joined(operation, self, other)

    def __or__(self, other: Geometry) -> Geometry:
        return self._joined("union", other)

    def __and__(self, other: Geometry) -> Geometry:
        return self._joined("intersection", other)

    def __sub__(self, other: Geometry) -> Geometry:
        return self._joined("difference", other)

    def __xor__(self, other: Geometry) -> Geometry:
        return self._joined("symmetric difference", other)

    def __invert__(self) -> Geometry:
        from rbs_core.geometry.combined import Complement

        return Complement(self)
