"""Set operations on geometries: exact `contains`, `distance` as a bound."""

from __future__ import annotations

import numpy as np

from rbs_core.errors import BadInput
from rbs_core.geometry.base import Geometry, common_dimension, empty_bounds, no_bounds, require_kind
from rbs_core.space.checks import BoolArray, Bounds, FloatArray

SYMBOLS = {"union": "|", "intersection": "&", "difference": "-", "symmetric difference": "^"}


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
        """Union and symmetric difference: the hull; intersection: the overlap; difference: those of the first."""
        (a_lower, a_upper), (b_lower, b_upper) = self.a.bounds, self.b.bounds
        if self.operation == "difference":
            everything = no_bounds(self._dimension)  # gives bounds of any dimension the shape of this one
            return np.maximum(a_lower, everything[0]), np.minimum(a_upper, everything[1])
        if self.operation == "intersection":
            lower, upper = np.maximum(a_lower, b_lower), np.minimum(a_upper, b_upper)
            return (lower, upper) if (lower <= upper).all() else empty_bounds(self._dimension)
        return np.minimum(a_lower, b_lower), np.maximum(a_upper, b_upper)

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

    def __init__(self, a: Geometry) -> None:
        require_kind(a, Geometry, "a")
        self.a = a

    @property
    def dimension(self) -> int | None:
        """That of the geometry left out."""
        return self.a.dimension

    @property
    def bounds(self) -> Bounds:
        """Infinite."""
        return no_bounds(self.dimension)

    def _contains(self, points: FloatArray) -> BoolArray:
        return ~self.a._contains(points)

    def _distance(self, points: FloatArray) -> FloatArray:
        return -self.a._distance(points)

    def _parameters(self) -> dict[str, object]:
        return {"a": self.a}

    def __invert__(self) -> Geometry:
        return self.a

    def __repr__(self) -> str:
        return f"(~{self.a!r})"
