"""What every geometry can do: say which points are in, how far away they are, and join with others."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.space.checks import BoolArray, Bounds, FloatArray, as_points, as_text
from rbs_core.space.system import CoordinateSystem

if TYPE_CHECKING:
    from rbs_core.geometry.combined import Combined
    from rbs_core.geometry.placed import Moved, Placed


class Described(ABC):
    """Something immutable that is known by its parameters: they make its `repr`, its equality and its hash."""

    @property
    @abstractmethod
    def dimension(self) -> int | None:
        """Number of coordinates of its points, None where it works in any dimension."""

    @abstractmethod
    def _parameters(self) -> dict[str, object]:
        """Arguments that make an equal object: numbers, tuples of numbers, hashable objects."""

    def _require_dimension(self, columns: int, what: str) -> None:
        """Refuse points of another dimension."""
        if self.dimension is not None and columns != self.dimension:
            raise BadInput(
                f"{what} has {columns} column{'s' if columns > 1 else ''}, but {self!r} has dimension "
                f"{self.dimension}; give points of shape (n, {self.dimension}), or a geometry of dimension {columns}"
            )

    def __repr__(self) -> str:
        arguments = ", ".join(f"{name}={_typed(value)}" for name, value in self._parameters().items())
        return f"{type(self).__name__}({arguments})"

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self) or not isinstance(other, Described):
            return NotImplemented
        return self._parameters() == other._parameters()

    def __hash__(self) -> int:
        return hash((type(self), *self._parameters().items()))


class Geometry(Described):
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

        Exact for primitives. For combined geometries, and for those placed with stretched axes, it is a bound: the sign
        is right and the surface is at least so far away.

        Args:
            points: coordinates (m), shape (n, d).

        Returns:
            Distances, shape (n,).

        Raises:
            BadInput: as `contains`, and when the geometry knows no distance.
        """
        return self._distance(self._checked(points))

    @abstractmethod
    def _contains(self, points: FloatArray) -> BoolArray:
        """Which of the checked points are in."""

    def _distance(self, points: FloatArray) -> FloatArray:
        """Signed distance of the checked points."""
        raise BadInput(f"{self!r} knows no distance; use a primitive such as Box or Ball, or only contains()")

    def _checked(self, points: ArrayLike) -> FloatArray:
        array = as_points(points)
        self._require_dimension(array.shape[1], "points")
        return array

    def moved(self, vector: ArrayLike) -> Moved:
        """The same shape, shifted by a vector (m), shape (d,)."""
        # Here and below: imported late, because these modules derive from Geometry.
        from rbs_core.geometry.placed import Moved

        return Moved(self, vector)

    def placed(self, system: CoordinateSystem) -> Placed:
        """This shape, its numbers understood in `system`, as a geometry in coordinates of the parent of `system`."""
        from rbs_core.geometry.placed import Placed

        return Placed(self, system)

    def _joined(self, operation: str, other: Geometry) -> Combined:
        from rbs_core.geometry.combined import Combined

        return Combined(operation, self, other)

    def __or__(self, other: Geometry) -> Combined:
        return self._joined("union", other)

    def __and__(self, other: Geometry) -> Combined:
        return self._joined("intersection", other)

    def __sub__(self, other: Geometry) -> Combined:
        return self._joined("difference", other)

    def __xor__(self, other: Geometry) -> Combined:
        return self._joined("symmetric difference", other)

    def __invert__(self) -> Geometry:
        from rbs_core.geometry.combined import Complement

        return Complement(self)


def common_dimension(a: Described, b: Described) -> int | None:
    """The dimension that two things share, None where both work in any.

    Raises:
        BadInput: when they have different dimensions.
    """
    if a.dimension is None or b.dimension is None or a.dimension == b.dimension:
        return b.dimension if a.dimension is None else a.dimension
    raise BadInput(f"{a!r} has dimension {a.dimension}, {b!r} has {b.dimension}; join only what has the same dimension")


def require_kind(thing: object, kind: type, what: str) -> None:
    """Refuse something of another kind, such as a number where a geometry belongs.

    Raises:
        BadInput: when `thing` is no `kind`.
    """
    if not isinstance(thing, kind):
        raise BadInput(f"{what} = {thing!r} is no {kind.__name__}; give one of rbs_core.geometry")


def coordinate_tuple(vector: FloatArray) -> tuple[float, ...]:
    """A vector as a tuple of plain numbers, which can be compared and hashed."""
    return tuple(vector.tolist())


def no_bounds(dimension: int | None) -> Bounds:
    """Bounds of all of space."""
    size = dimension or 1
    return np.full(size, -np.inf), np.full(size, np.inf)


def empty_bounds(dimension: int | None) -> Bounds:
    """Bounds of nothing: their hull with any others is the others."""
    lower, upper = no_bounds(dimension)
    return upper, lower


def _typed(value: object) -> str:
    """A parameter as it could be typed; a function by its name."""
    name = getattr(value, "__qualname__", None)
    return name if isinstance(name, str) else as_text(value)
