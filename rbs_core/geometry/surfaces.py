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
from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput
from rbs_core.geometry.base import ROUND_OFF, TOLERANCE, Geometry
from rbs_core.geometry.described import common_dimension, require_kind
from rbs_core.geometry.similarity import Similarity
from rbs_core.space.checks import BoolArray, Bounds, FloatArray, as_real, require_finite

# Part of the length of a bond up to which its distance from a surface may count as none.
BOND_TOLERANCE = 1e-6

# Bonds per round: the temporary arrays of a round stay in the cache, whatever the number of bonds.
ROUND = 1 << 14


class Surface(Geometry):
    """Something that bonds can cross: a point in 1-D, a line in 2-D, a face in 3-D; `a | b` is several at once.

    It is a set of points too: those nearer than the tolerance of `status` are in. Its distance is never negative, and
    no point is inside. `surface & region` and `surface - region` are the part of it in a region or beside it, and can
    be crossed as well. Shapes of the same names that bonds cannot cross, such as a segment in 3-D, say so; a polygon in
    2-D fills a region, and is joined with others as one.
    """

    @property
    def _fills(self) -> bool:
        """Whether it fills a region, of which the distance is negative inside."""
        return False

    @property
    @abstractmethod
    def dimension(self) -> int:
        """Number of coordinates of the space that it lies in."""

    def crosses(self, starts: ArrayLike, ends: ArrayLike) -> BoolArray:
        """Which bonds cross the surface, by the rule at the top of this file.

        Args:
            starts: one end of each bond (m), shape (m, d).
            ends: the other end, shape (m, d).

        Returns:
            True where the bond crosses, shape (m,).

        Raises:
            BadInput: for other shapes or another dimension, for NaN or infinity, and for what bonds cannot cross.
        """
        first, second = as_real(starts, "starts"), as_real(ends, "ends")
        if first.ndim != 2 or first.shape != second.shape:
            raise BadInput(
                f"starts has shape {first.shape}, ends has {second.shape}; give both one row per bond, "
                f"shape (m, {self.dimension})"
            )
        self._require_dimension(first.shape[1], "starts")
        self._require_crossing()
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

    def _cure(self) -> str | None:
        """Why no bond can cross it, and what to cut with instead; None if bonds can."""
        return None

    def _require_crossing(self) -> None:
        """Refuse to cut with what bonds cannot cross."""
        cure = self._cure()
        if cure is not None:
            raise BadInput(f"no bond can cross {self!r}: {cure}")

    def _heights(self, points: FloatArray) -> FloatArray:
        """Signed distances of points from the plane of a flat surface."""
        raise BadInput(f"{self!r} lies in no plane, so no region can crop it; cut with the whole of it")

    def _margins(self, starts: FloatArray, ends: FloatArray) -> FloatArray:
        """The tolerance of each bond."""
        return tolerances(starts, ends, self.size or np.inf, 0.0)

    def _meetings(self, starts: FloatArray, ends: FloatArray) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
        """Bonds that cross a flat surface: their indices (k,), where they meet it (k, d), and their tolerances (k,)."""
        found = np.flatnonzero(self._crosses(starts, ends))
        starts, ends = starts[found], ends[found]
        tolerance = self._margins(starts, ends)
        to_start = weights(self._heights(starts), tolerance)[:, None]
        to_end = weights(self._heights(ends), tolerance)[:, None]
        # Written so that both ends play the same part: a bond and its reverse meet the plane in the same bits.
        return found, (starts * to_end + ends * to_start) / (to_start + to_end), tolerance

    def _contains(self, points: FloatArray) -> BoolArray:
        near: BoolArray = self._distance(points) <= self._tolerance(points)
        return near

    @overload
    def __or__(self, other: Surface) -> Surface: ...
    @overload
    def __or__(self, other: Geometry) -> Geometry: ...
    def __or__(self, other: Geometry) -> Geometry:
        return self._joined("union", other)


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

    def _require_crossing(self) -> None:
        for member in self.members:
            member._require_crossing()

    def _contains(self, points: FloatArray) -> BoolArray:
        return np.asarray(np.array([member._contains(points) for member in self.members]).any(axis=0))

    def _distance(self, points: FloatArray) -> FloatArray:
        distance: FloatArray = np.array([member._distance(points) for member in self.members]).min(axis=0)
        return distance

    def _status(self, points: FloatArray, tolerance: FloatArray) -> NDArray[np.int8]:
        status: NDArray[np.int8] = np.array([member._status(points, tolerance) for member in self.members]).min(axis=0)
        return status

    def _projection(self, points: FloatArray) -> FloatArray:
        distances = np.array([member._distance(points) for member in self.members])
        candidates = np.array([member._projection(points) for member in self.members])
        nearest: FloatArray = candidates[distances.argmin(axis=0), np.arange(len(points))]
        return nearest

    def _reaches(self, direction: FloatArray) -> float:
        return max(member._reaches(direction) for member in self.members)

    def _transformed(self, by: Similarity) -> Geometry:
        return Surfaces(*by.image(self.members, "geometries"))

    def _parameters(self) -> dict[str, object]:
        return {"members": self.members}

    def __repr__(self) -> str:
        return f"Surfaces({', '.join(map(repr, self.members))})"


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
