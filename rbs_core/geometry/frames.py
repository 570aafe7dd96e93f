"""Directions and coordinates along them, summed in one order: a point gets the same bits in any array."""

from __future__ import annotations

import numpy as np

from rbs_core.space.checks import FloatArray


def unit(vector: FloatArray) -> FloatArray:
    """A vector of length 1 in the same direction."""
    result: FloatArray = vector / np.linalg.norm(vector)
    return result


def along(points: FloatArray, origin: FloatArray, direction: FloatArray) -> FloatArray:
    """Coordinates (n,) of points (n, d) along a direction (d,), from an origin (d,)."""
    result: FloatArray = (points[:, 0] - origin[0]) * direction[0]
    for axis in range(1, points.shape[1]):
        result += (points[:, axis] - origin[axis]) * direction[axis]
    return result


def lengths(vectors: FloatArray) -> FloatArray:
    """Lengths (n,) of vectors (n, d)."""
    squares: FloatArray = vectors[:, 0] ** 2
    for axis in range(1, vectors.shape[1]):
        squares += vectors[:, axis] ** 2
    return np.sqrt(squares, out=squares)


def dots(a: FloatArray, b: FloatArray) -> FloatArray:
    """Scalar products (n,) of vectors (n, 3), row by row."""
    products: FloatArray = a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] + a[:, 2] * b[:, 2]
    return products


def rows_along(distances: FloatArray, direction: FloatArray) -> FloatArray:
    """Vectors (n, d) of given lengths (n,) along a direction (d,)."""
    result: FloatArray = distances[:, None] * direction
    return result


def directions(vectors: FloatArray, instead: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lengths (n,) and unit vectors (n, d) of vectors (n, d); where there is no length, the vector `instead` (d,)."""
    length = lengths(vectors)
    nothing = length == 0.0
    return length, np.where(nothing[:, None], instead, vectors / np.where(nothing, 1.0, length)[:, None])


def perpendicular(direction: FloatArray) -> FloatArray:
    """A unit vector at right angles to a unit vector: turned to the left in 2-D, along an axis in 3-D if one is."""
    if direction.size == 2:
        return np.array([-direction[1], direction[0]])
    least = np.zeros(3)
    least[np.argmin(np.abs(direction))] = 1.0
    return unit(least - (least @ direction) * direction)


def parallel(a: FloatArray, b: FloatArray) -> bool:
    """Whether two unit vectors lie on one line, up to round-off."""
    return float(np.linalg.norm(b - (a @ b) * a)) <= FINE


def square(a: FloatArray, b: FloatArray) -> bool:
    """Whether two unit vectors are at right angles, up to round-off."""
    return abs(float(a @ b)) <= FINE


# What is left of a right angle or of a parallel after a few turns.
FINE = 1e-12
