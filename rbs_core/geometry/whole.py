"""All of space, nothing, and what a plain function says."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rbs_core.errors import BadInput
from rbs_core.geometry.base import Geometry
from rbs_core.geometry.described import empty_bounds, no_bounds
from rbs_core.geometry.similarity import Similarity
from rbs_core.space.checks import BoolArray, Bounds, FloatArray


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

    def _outside(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        return empty_bounds(lower.size)

    def _contains(self, points: FloatArray) -> BoolArray:
        return np.ones(len(points), dtype=np.bool_)

    def _distance(self, points: FloatArray) -> FloatArray:
        return np.full(len(points), -np.inf)

    def _projection(self, points: FloatArray) -> FloatArray:
        raise BadInput(f"{self!r} has no surface to project on; give a geometry that has one")

    def _transformed(self, by: Similarity) -> Geometry:
        return self

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

    def _inside(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        return empty_bounds(lower.size)

    def _contains(self, points: FloatArray) -> BoolArray:
        return np.zeros(len(points), dtype=np.bool_)

    def _distance(self, points: FloatArray) -> FloatArray:
        return np.full(len(points), np.inf)

    def _projection(self, points: FloatArray) -> FloatArray:
        raise BadInput(f"{self!r} has no surface to project on; give a geometry that has one")

    def _transformed(self, by: Similarity) -> Geometry:
        return self

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
