"""Cutting surfaces: which bonds cross a crack, a notch or a gap.

The rule, in every dimension. A surface lies in a plane (a line in 2-D, a point in 1-D) that has a positive and a
negative side. Points on the plane, within a tolerance, belong to the positive side. A bond crosses the surface when its
two ends are on different sides and it meets the plane inside the surface or at most a tolerance beside it: a bond
through the tip of a crack crosses, so that symmetric meshes are cut symmetrically. The tolerance belongs to the bond:
1e-9 of the size of the surface, but at most 1e-6 of the length of the bond, and on top of that the round-off of the
coordinates. So it stays far below the spacing, however large the surface is and wherever it lies. A bond and its
reverse get the same answer, always.
"""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry.base import Described, common_dimension, coordinate_tuple, require_kind
from rbs_core.space.checks import BoolArray, Bounds, FloatArray, as_number, as_real, as_text, as_vectors, require_finite

# Part of the size of a surface that still counts as on it, unless that is more than a part of the length of the bond.
TOLERANCE = 1e-9
BOND_TOLERANCE = 1e-6

# Part of the largest coordinate that counts as on the surface in any case: what round-off makes of a distance from it.
ROUND_OFF = 16 * float(np.finfo(np.float64).eps)

# Bonds per round: the temporary arrays of a round stay in the cache, whatever the number of bonds.
ROUND = 1 << 14


class Surface(Described):
    """Something that bonds can cross; `a | b` is several surfaces at once."""

    @property
    @abstractmethod
    def dimension(self) -> int:
        """Number of coordinates of the space that it cuts."""

    @property
    @abstractmethod
    def bounds(self) -> Bounds:
        """Smallest and largest coordinates (m), shape (d,) each."""

    def crosses(self, starts: ArrayLike, ends: ArrayLike) -> BoolArray:
        """Which bonds cross the surface, by the rule at the top of this file.

        Args:
            starts: one end of each bond (m), shape (m, d).
            ends: the other end, shape (m, d).

        Returns:
            True where the bond crosses, shape (m,).

        Raises:
            BadInput: for other shapes or another dimension, and for NaN or infinity.
        """
        first, second = as_real(starts, "starts"), as_real(ends, "ends")
        if first.ndim != 2 or first.shape != second.shape:
            raise BadInput(
                f"starts has shape {first.shape}, ends has {second.shape}; give both one row per bond, "
                f"shape (m, {self.dimension})"
            )
        self._require_dimension(first.shape[1], "starts")
        crossing = np.empty(len(first), dtype=np.bool_)
        for begin in range(0, len(first), ROUND):
            rows = slice(begin, begin + ROUND)
            a, b = np.asarray(first[rows], dtype=np.float64), np.asarray(second[rows], dtype=np.float64)
            require_finite(a, "starts", begin)
            require_finite(b, "ends", begin)
            crossing[rows] = self._crosses(a, b)
        return crossing

    @abstractmethod
    def _crosses(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        """Which of a round of checked bonds cross."""

    def __or__(self, other: Surface) -> Surfaces:
        return Surfaces(self, other)


class Surfaces(Surface):
    """Several surfaces at once: a bond crosses when it crosses any of them; usually written `a | b`.

    Args:
        members: surfaces of the same dimension, one at least.

    Raises:
        BadInput: when there is none, for something that is no surface, and for different dimensions.
    """

    def __init__(self, *members: Surface) -> None:
        if not members:
            raise BadInput("Surfaces() holds no surface; give one at least")
        for index, member in enumerate(members):
            require_kind(member, Surface, f"members[{index}]")
            common_dimension(members[0], member)
        self.members: tuple[Surface, ...] = tuple(
            single for member in members for single in (member.members if isinstance(member, Surfaces) else (member,))
        )

    @property
    def dimension(self) -> int:
        """That of the members."""
        return self.members[0].dimension

    @property
    def bounds(self) -> Bounds:
        """The hull of the members."""
        lowers, uppers = zip(*(member.bounds for member in self.members), strict=True)
        return np.min(lowers, axis=0), np.max(uppers, axis=0)

    def _crosses(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        crossing = self.members[0]._crosses(starts, ends)
        for member in self.members[1:]:
            crossing |= member._crosses(starts, ends)
        return crossing

    def _parameters(self) -> dict[str, object]:
        return {"members": self.members}

    def __repr__(self) -> str:
        return f"Surfaces({', '.join(map(repr, self.members))})"


class Point(Surface):
    """A cut through a line; its positive side is x and above.

    Its size, for the tolerance, is |x| or the length of the bond, whichever is larger; far from 0 the length counts.

    Args:
        x: coordinate (m).
    """

    def __init__(self, x: float) -> None:
        self.x = as_number(x, "x")

    @property
    def dimension(self) -> int:
        """1."""
        return 1

    @property
    def bounds(self) -> Bounds:
        """The point, twice."""
        return np.array([self.x]), np.array([self.x])

    def _crosses(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        start, end = starts[:, 0], ends[:, 0]
        size = np.maximum(np.abs(end - start), abs(self.x))
        return on_different_sides(start - self.x, end - self.x, tolerances(starts, ends, size, abs(self.x)))

    def _parameters(self) -> dict[str, object]:
        return {"x": self.x}


class Segment(Surface):
    """A straight cut through a plane; its positive side is on the left on the way from start to end.

    Its size, for the tolerance, is its length.

    Args:
        start: one tip (m), shape (2,).
        end: the other tip (m), shape (2,).

    Raises:
        BadInput: when the tips are the same point or do not have two components.
    """

    def __init__(self, start: ArrayLike, end: ArrayLike) -> None:
        self.start, self.end = as_vectors(start, end, ("start", "end"))
        if self.start.size != 2:
            raise BadInput(f"start = {as_text(self.start)} has {self.start.size} components; give 2 (3-D: a Polygon)")
        along = self.end - self.start
        length = float(np.hypot(*along))
        if length == 0.0:
            raise BadInput(f"start = end = {as_text(self.start)}: a segment without length; give two different tips")
        # Everything is measured from the middle: a cut that is symmetric about an axis then stays so to the last bit.
        self._middle = (self.start + self.end) / 2
        self._along = along / length
        self._length, self._half = length, length / 2
        self._largest = float(max(np.abs(self.start).max(), np.abs(self.end).max()))

    @property
    def dimension(self) -> int:
        """2."""
        return 2

    @property
    def bounds(self) -> Bounds:
        """The box around both tips."""
        return np.minimum(self.start, self.end), np.maximum(self.start, self.end)

    def _local(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Coordinates along the segment, from its middle, and to its left."""
        x, y = points[:, 0] - self._middle[0], points[:, 1] - self._middle[1]
        return x * self._along[0] + y * self._along[1], y * self._along[0] - x * self._along[1]

    def _crosses(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        (start_along, start_height), (end_along, end_height) = self._local(starts), self._local(ends)
        tolerance = tolerances(starts, ends, self._length, self._largest)
        crossing = on_different_sides(start_height, end_height, tolerance)
        found = np.flatnonzero(crossing)
        tolerance = tolerance[found]
        to_start, to_end = weights(start_height[found], tolerance), weights(end_height[found], tolerance)
        # The bond meets the line at meeting / (to_start + to_end); written so that both ends play the same part.
        meeting = start_along[found] * to_end + end_along[found] * to_start
        crossing[found] = np.abs(meeting) <= (self._half + tolerance) * (to_start + to_end)
        return crossing

    def _parameters(self) -> dict[str, object]:
        return {"start": coordinate_tuple(self.start), "end": coordinate_tuple(self.end)}


def tolerances(starts: FloatArray, ends: FloatArray, size: float | FloatArray, largest: float) -> FloatArray:
    """How far from a surface a point still counts as on it, for each bond; the same for a bond and its reverse.

    Args:
        starts: one end of each bond (m), shape (m, d).
        ends: the other end, shape (m, d).
        size: of the surface (m).
        largest: absolute coordinate of the surface (m).
    """
    length, reach = np.zeros(len(starts)), np.full(len(starts), largest)
    for start, end in zip(starts.T, ends.T, strict=True):  # by columns: a sum over few columns is slow by rows
        length = np.hypot(length, end - start)
        np.maximum(reach, np.maximum(np.abs(start), np.abs(end)), out=reach)
    result: FloatArray = np.minimum(TOLERANCE * size, BOND_TOLERANCE * length) + ROUND_OFF * reach
    return result


def on_different_sides(start_height: FloatArray, end_height: FloatArray, tolerance: FloatArray) -> BoolArray:
    """Whether the ends of bonds, given by their signed distances from a plane, are on different sides of it."""
    different: BoolArray = (start_height >= -tolerance) != (end_height >= -tolerance)
    return different


def weights(height: FloatArray, tolerance: FloatArray) -> FloatArray:
    """Distances from the plane, those of points that count as on it set to 0.

    Of two ends on different sides one is further off than the tolerance, so that the sum of their weights is never 0.
    """
    distance: FloatArray = np.abs(height)
    distance[(height < 0.0) & (height >= -tolerance)] = 0.0
    return distance
