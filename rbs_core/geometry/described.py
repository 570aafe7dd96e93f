"""Things that are known by their parameters, and what their texts, equality and checks are made of."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.space.checks import Bounds, FloatArray, as_number, as_text, as_vector


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


def as_place(values: ArrayLike, what: str, dimension: int) -> FloatArray:
    """A point or vector of a given dimension, read-only.

    Raises:
        BadInput: for another number of components, and for NaN or infinity.
    """
    place = as_vector(values, what)
    if place.size != dimension:
        raise BadInput(f"{what} = {as_text(place)} has {place.size} components; give {dimension}")
    return place


def as_direction(values: ArrayLike, what: str, dimension: int) -> FloatArray:
    """A vector of any length but zero, read-only.

    Raises:
        BadInput: as `as_place`, and for a vector without length.
    """
    direction = as_place(values, what, dimension)
    if not direction.any():
        raise BadInput(f"{what} = {as_text(direction)} has no length; give a vector of any length but 0")
    return direction


def as_smaller(value: float, limit: float, names: tuple[str, str]) -> float:
    """A positive number below another one.

    Raises:
        BadInput: when it is not positive, or not below.
    """
    number = as_number(value, names[0], positive=True)
    if number >= limit:
        raise BadInput(f"{names[0]} = {number} is not below {names[1]} = {limit}; give the smaller number here")
    return number


def coordinate_tuple(vector: FloatArray) -> tuple[float, ...]:
    """A vector as a tuple of plain numbers, which can be compared and hashed."""
    return tuple(vector.tolist())


def row_tuples(rows: FloatArray) -> tuple[tuple[float, ...], ...]:
    """Points as a tuple of tuples of plain numbers."""
    return tuple(tuple(row) for row in rows.tolist())


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
