"""Set operations on geometries: exact `contains`, `distance` as a bound."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import TypeAlias, TypeGuard

import numpy as np
from numpy.typing import NDArray

from rbs_core.errors import BadInput
from rbs_core.geometry.base import Geometry
from rbs_core.geometry.cropped import Cropped
from rbs_core.geometry.described import common_dimension, empty_bounds, no_bounds, require_kind
from rbs_core.geometry.frames import lengths
from rbs_core.geometry.nearest import nearest_among, searched, shared, surroundings
from rbs_core.geometry.similarity import Similarity
from rbs_core.geometry.surfaces import Surface, Surfaces
from rbs_core.geometry.whole import Everywhere, Nowhere
from rbs_core.space.checks import BoolArray, Bounds, FloatArray

SYMBOLS = {"union": "|", "intersection": "&", "difference": "-", "symmetric difference": "^"}

# How many tolerances away the surroundings of a point are probed where two surfaces meet.
PROBE = 8.0

# What a geometry, or its complement, leaves of a box.
Condition: TypeAlias = Callable[[FloatArray, FloatArray], Bounds]


def joined(operation: str, a: Geometry, b: Geometry) -> Geometry:
    """What an operator makes of two geometries: surfaces stay surfaces where bonds can still cross the result."""
    require_kind(b, Geometry, "b")
    if operation == "union" and _is_thin(a) and _is_thin(b):
        return Surfaces(a, b)
    if operation == "intersection" and _is_thin(b) and not _is_thin(a):
        a, b = b, a
    if operation in ("intersection", "difference") and _is_thin(a) and not _is_thin(b):
        region = b if operation == "intersection" else ~b
        members = a.members if isinstance(a, Surfaces) else (a,)
        parts = [Cropped(member, region) for member in members]
        return parts[0] if len(parts) == 1 else Surfaces(*parts)
    return Combined(operation, a, b)


def _is_thin(geometry: Geometry) -> TypeGuard[Surface]:
    """Whether it is a surface and fills nothing, as a polygon in 2-D does."""
    return isinstance(geometry, Surface) and not geometry._fills


class Combined(Geometry):
    """Two geometries joined by a set operation; usually written `a | b`, `a & b`, `a - b`, `a ^ b`.

    `contains` is exact. `distance` has the right sign, and the surface is at least so far away.

    Args:
        operation: "union", "intersection", "difference" or "symmetric difference".
        a: left geometry.
        b: right geometry, of the same dimension.

    Raises:
        BadInput: for an unknown operation, something that is no geometry, and different dimensions.
    """

    def __init__(self, operation: str, a: Geometry, b: Geometry) -> None:
        if operation not in SYMBOLS:
            raise BadInput(f"operation = {operation!r} is unknown; give one of {', '.join(map(repr, SYMBOLS))}")
        require_kind(a, Geometry, "a")
        require_kind(b, Geometry, "b")
        self._dimension = common_dimension(a, b)
        self.operation, self.a, self.b = operation, a, b

    @property
    def dimension(self) -> int | None:
        """That of the two geometries."""
        return self._dimension

    @property
    def bounds(self) -> Bounds:
        """Union and symmetric difference: the hull; intersection and difference: what half spaces and slabs leave."""
        return self._inside(*no_bounds(self._dimension))

    @property
    def size(self) -> float:
        """The diagonal of the bounds; where they are infinite, the larger of both sizes."""
        return super().size or max(self.a.size, self.b.size)

    def _inside(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        if self.operation in ("union", "symmetric difference"):
            return _hull(self.a._inside(lower, upper), self.b._inside(lower, upper))
        return _both(
            self.a._inside, self.b._outside if self.operation == "difference" else self.b._inside, lower, upper
        )

    def _outside(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        if self.operation == "union":
            return _both(self.a._outside, self.b._outside, lower, upper)
        if self.operation == "symmetric difference":
            return lower, upper
        other = self.b._inside if self.operation == "difference" else self.b._outside
        return _hull(self.a._outside(lower, upper), other(lower, upper))

    def _reaches(self, direction: FloatArray) -> float:
        a, b, within = self.a._reaches(direction), self.b._reaches(direction), super()._reaches(direction)
        if self.operation == "difference":
            return min(a, within)
        return min(min(a, b) if self.operation == "intersection" else max(a, b), within)

    def _contains(self, points: FloatArray) -> BoolArray:
        a, b = self.a._contains(points), self.b._contains(points)
        if self.operation == "union":
            return a | b
        if self.operation == "intersection":
            return a & b
        if self.operation == "difference":
            return a & ~b
        return a ^ b

    def _distance(self, points: FloatArray) -> FloatArray:
        a, b = self.a._distance(points), self.b._distance(points)
        if self.operation == "union":
            return np.minimum(a, b)
        if self.operation == "intersection":
            return np.maximum(a, b)
        if self.operation == "difference":
            return np.maximum(a, -b)
        return np.maximum(np.minimum(a, b), -np.maximum(a, b))

    def _status(self, points: FloatArray, tolerance: FloatArray) -> NDArray[np.int8]:
        a, b = self.a._status(points, tolerance), self.b._status(points, tolerance)
        if self.operation == "union":
            status = np.minimum(a, b)
        elif self.operation == "intersection":
            status = np.maximum(a, b)
        elif self.operation == "difference":
            status = np.maximum(a, -b)
        else:
            status = a * b
        # Where both surfaces pass, the surroundings decide: two boxes side by side have no surface between them.
        both = np.flatnonzero((a == 0) & (b == 0))
        if both.size:
            reach = PROBE * np.maximum(tolerance, self._tolerance(points))[both]
            status[both] = self._surroundings(points[both], reach)
        return status

    def _surroundings(self, points: FloatArray, reach: FloatArray) -> NDArray[np.int8]:
        """Status of points by whether they and all of their surroundings are in, or none."""
        every, some = self._contains(points), self._contains(points)
        for step in product((-1.0, 0.0, 1.0), repeat=points.shape[1]):
            way = np.array(step)
            inside = self._contains(points + reach[:, None] * way / max(1.0, float(np.linalg.norm(way))))
            every &= inside
            some |= inside
        return (~some).astype(np.int8) - every.astype(np.int8)

    def _projection(self, points: FloatArray) -> FloatArray:
        """The nearest of what the members project to, if it is on the surface; searched where that may not be all."""
        least = np.abs(self._distance(points))
        if not np.isfinite(least).all():
            raise BadInput(f"{self!r} has no surface to project on; give a geometry that has one")
        found, away = points.copy(), np.full(len(points), np.inf)
        for member in (self.a, self.b):
            if not isinstance(member, Everywhere | Nowhere):
                self._offer(member._projection(points), points, found, away)
        rest = np.flatnonzero(away > least + self._tolerance(points))  # nothing is nearer than the distance
        if rest.size:
            found[rest] = self._searched(points[rest], found[rest], away[rest])
        return found

    def _offer(self, candidates: FloatArray, points: FloatArray, found: FloatArray, away: FloatArray) -> None:
        """Takes candidates that lie on the surface, and nearer than what has been found so far."""
        on = self._status(candidates, self._tolerance(candidates)) == 0
        reached = np.where(on, lengths(points - candidates), np.inf)
        better = reached < away
        found[better], away[better] = candidates[better], reached[better]

    def _searched(self, points: FloatArray, found: FloatArray, away: FloatArray) -> FloatArray:
        """The best of several searches, and of what has been found before."""
        anywhere = searched([self._distance], points, points, self.size)
        self._offer(anywhere, points, found, away)
        edges = [self.a._distance, self.b._distance]
        self._offer(searched(edges, points, anywhere, self.size), points, found, away)
        # The nearest point is the nearest one of the other side, which two regions share.
        a, b = (~self.a, ~self.b) if self.operation == "union" else (self.a, self.b)
        b = ~b if self.operation == "difference" else b
        for convex in (True, False):
            self._offer(shared(a, b, points, convex), points, found, away)
        lost = np.flatnonzero(np.isinf(away))
        if lost.size:
            found[lost] = self._sampled(points[lost], anywhere[lost])
        return found

    def _sampled(self, points: FloatArray, instead: FloatArray) -> FloatArray:
        """The nearest of many points of the surface, and what is downhill from there; `instead` where there is none."""
        candidates = surroundings(points, self.bounds, self.size)
        some = np.concatenate([
            member._projection(candidates)
            for member in (self.a, self.b)
            if not isinstance(member, Everywhere | Nowhere)
        ])  # fmt: skip
        some = some[self._status(some, self._tolerance(some)) == 0]
        if not len(some):
            return instead
        found = nearest_among(points, some)
        away = lengths(points - found)
        self._offer(searched([self._distance], points, found, self.size), points, found, away)
        return found

    def _transformed(self, by: Similarity) -> Geometry:
        return Combined(self.operation, self.a._transformed(by), self.b._transformed(by))

    def _parameters(self) -> dict[str, object]:
        return {"operation": self.operation, "a": self.a, "b": self.b}

    def __repr__(self) -> str:
        return f"({self.a!r} {SYMBOLS[self.operation]} {self.b!r})"


class Complement(Geometry):
    """Everything but a geometry; usually written `~a`. Without the surface where `a` has it.

    Args:
        a: what is left out.

    Raises:
        BadInput: for something that is no geometry.
    """

    _kinds = {"a": "geometry"}

    def __init__(self, a: Geometry) -> None:
        require_kind(a, Geometry, "a")
        self.a = a

    @property
    def dimension(self) -> int | None:
        """That of the geometry left out."""
        return self.a.dimension

    @property
    def bounds(self) -> Bounds:
        """Infinite, but for what is left out is half of space or more."""
        return self._inside(*no_bounds(self.dimension))

    @property
    def size(self) -> float:
        """That of the geometry left out: the surface is the same."""
        return self.a.size

    def _inside(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        return self.a._outside(lower, upper)

    def _outside(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        return self.a._inside(lower, upper)

    def _contains(self, points: FloatArray) -> BoolArray:
        return ~self.a._contains(points)

    def _distance(self, points: FloatArray) -> FloatArray:
        return -self.a._distance(points)

    def _status(self, points: FloatArray, tolerance: FloatArray) -> NDArray[np.int8]:
        return -self.a._status(points, tolerance)

    def _round_off(self, points: FloatArray) -> FloatArray:
        return self.a._round_off(points)

    def _projection(self, points: FloatArray) -> FloatArray:
        return self.a._projection(points)

    def _parameters(self) -> dict[str, object]:
        return {"a": self.a}

    def __invert__(self) -> Geometry:
        return self.a

    def __repr__(self) -> str:
        return f"(~{self.a!r})"


def _hull(a: Bounds, b: Bounds) -> Bounds:
    """The bounds of two boxes, of which either may be empty."""
    if not (a[0] <= a[1]).all():
        return b
    if not (b[0] <= b[1]).all():
        return a
    return np.minimum(a[0], b[0]), np.maximum(a[1], b[1])


def _both(first: Condition, second: Condition, lower: FloatArray, upper: FloatArray) -> Bounds:
    """What two conditions leave of a box; the first once more, since it may do better with what the second has left."""
    for condition in (first, second, first):
        lower, upper = condition(lower, upper)
        if not (lower <= upper).all():
            return empty_bounds(lower.size)
    return lower, upper
