"""Numbers from outside: made into float64 arrays, or refused with what is wrong, where, and the cure."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput

FloatArray: TypeAlias = NDArray[np.float64]
BoolArray: TypeAlias = NDArray[np.bool_]
Bounds: TypeAlias = tuple[FloatArray, FloatArray]


def as_text(values: object) -> str:
    """Numbers, arrays and nested tuples as a person would type them.

    Args:
        values: a number, an array, or a tuple of those; anything else falls back to its `repr`.

    Returns:
        Text that evaluates to equal numbers, without the names of numpy types.
    """
    if isinstance(values, np.ndarray | np.generic):
        values = values.tolist()
    if isinstance(values, list | tuple):
        return f"({', '.join(as_text(value) for value in values)}{',' if len(values) == 1 else ''})"
    if isinstance(values, float) and not np.isfinite(values):
        return f"float('{values}')"
    return repr(values)


def as_real(values: ArrayLike, what: str) -> NDArray[np.number | np.bool_]:
    """An array of real numbers of any shape, not copied and not converted.

    Args:
        values: numbers.
        what: name of the argument, for the message.

    Raises:
        BadInput: when the values are no real numbers, or rows have different lengths.
    """
    try:
        array = np.asarray(values)
    except ValueError as reason:
        raise BadInput(f"{what} is no array ({reason}); give every row the same number of components") from None
    if array.dtype.kind not in "biuf":
        shown = repr(values) if array.size < 10 else f"an array of {array.dtype}"
        raise BadInput(f"{what} = {shown} does not hold real numbers; give numbers (SI units)")
    return array


def require_finite(array: FloatArray, what: str, first: int = 0) -> None:
    """Refuse NaN and infinity.

    Args:
        array: numbers of any shape.
        what: name of the argument, for the message.
        first: index of the first row of `array` in what the caller was given.

    Raises:
        BadInput: with index and value of the first number that is not finite.
    """
    finite = np.isfinite(array)
    if finite.all():
        return
    where = tuple(int(index) for index in np.argwhere(~finite)[0])
    value = array[where]
    shown = ", ".join(str(index) for index in (where[0] + first, *where[1:])) if where else ""
    raise BadInput(f"{what}{f'[{shown}]' if shown else ''} = {value} is not finite; give finite numbers only")


def as_number(value: ArrayLike, what: str, *, positive: bool = False) -> float:
    """One finite number.

    Args:
        value: the number.
        what: name of the argument, for the message.
        positive: whether zero and negative numbers are refused.

    Raises:
        BadInput: when it is no number, not finite, or not positive although it must be.
    """
    array = as_real(value, what)
    if array.ndim:
        raise BadInput(f"{what} has shape {array.shape}; give a single number")
    number = float(array)
    require_finite(np.asarray(number), what)
    if positive and number <= 0.0:
        raise BadInput(f"{what} = {number} is not positive; give a number above 0")
    return number


def as_vector(values: ArrayLike, what: str, *, infinite: bool = False) -> FloatArray:
    """A vector of 1 to 3 components; a single number is a vector of one component.

    Args:
        values: shape (d,) or a number.
        what: name of the argument, for the message.
        infinite: whether infinities are allowed (NaN never is).

    Returns:
        A read-only copy, shape (d,).

    Raises:
        BadInput: for other shapes, other things than real numbers, and numbers that are not finite.
    """
    vector = np.array(as_real(values, what), dtype=np.float64, ndmin=1)
    if vector.ndim != 1 or not 1 <= vector.size <= 3:
        raise BadInput(f"{what} has shape {vector.shape}; give 1, 2 or 3 components")
    require_finite(np.where(np.isinf(vector), 0.0, vector) if infinite else vector, what)
    vector.flags.writeable = False
    return vector


def as_vectors(first: ArrayLike, second: ArrayLike, names: tuple[str, str], *, infinite: bool = False) -> Bounds:
    """Two vectors of the same dimension; a single number stands for as many components as the other has.

    Args:
        first: shape (d,) or a number.
        second: shape (d,) or a number.
        names: names of the two arguments, for the message.
        infinite: whether infinities are allowed.

    Returns:
        Two read-only copies, shape (d,) each.

    Raises:
        BadInput: as `as_vector`, and when the numbers of components differ.
    """
    a, b = as_vector(first, names[0], infinite=infinite), as_vector(second, names[1], infinite=infinite)
    if a.size != b.size and np.ndim(first) == 0:
        a = as_vector(np.full(b.size, a[0]), names[0], infinite=infinite)
    elif a.size != b.size and np.ndim(second) == 0:
        b = as_vector(np.full(a.size, b[0]), names[1], infinite=infinite)
    if a.size != b.size:
        raise BadInput(
            f"{names[0]} = {as_text(a)} has {a.size} components, {names[1]} = {as_text(b)} has {b.size}; "
            "give both the same number of components"
        )
    return a, b


def as_points(points: ArrayLike, what: str = "points") -> FloatArray:
    """Many points as rows.

    Args:
        points: shape (n, d), d = 1, 2 or 3.
        what: name of the argument, for the message.

    Returns:
        float64 array (n, d); not a copy where none is needed.

    Raises:
        BadInput: for other shapes, other things than real numbers, and numbers that are not finite.
    """
    array = np.asarray(as_real(points, what), dtype=np.float64)
    if array.ndim != 2 or not 1 <= array.shape[1] <= 3:
        raise BadInput(
            f"{what} has shape {array.shape}; give one row per point, shape (n, 1), (n, 2) or (n, 3) "
            "(a single point as [[x, y]])"
        )
    require_finite(array, what)
    return array
