"""Similarities: shifts, turns, mirror images and changes of size, which change all lengths alike."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry.described import as_direction, as_place, coordinate_tuple, row_tuples
from rbs_core.space.checks import FloatArray, as_number, as_real, as_text, as_vector, as_vectors

# How far the product of a turn with its transpose may be from one: what a chain of turns gathers as round-off.
ORTHOGONAL = 1e-9

# An angle so near to a quarter turn (in quarter turns) is meant to be one: numbers like pi arrive with round-off.
QUARTER = 1e-15


class Similarity:
    """x -> factor turn x + shift.

    Args:
        turn: rotation or mirror image, an orthogonal matrix (d, d).
        factor: by which lengths grow, positive.
        shift: (m), shape (d,).

    Raises:
        BadInput: for a matrix that is not orthogonal, a factor that is not positive, and other shapes.
    """

    def __init__(self, turn: ArrayLike, factor: float, shift: ArrayLike) -> None:
        self.shift = as_vector(shift, "shift")
        size = self.shift.size
        matrix = np.array(as_real(turn, "turn"), dtype=np.float64)
        if matrix.shape != (size, size):
            raise BadInput(f"turn has shape {matrix.shape}, shift has {size} components; give ({size}, {size})")
        if not np.abs(matrix @ matrix.T - np.eye(size)).max() <= ORTHOGONAL:
            raise BadInput(
                f"turn = {as_text(matrix)} stretches or shears; give an orthogonal matrix (place the geometry in a "
                "coordinate system with stretched axes instead: geometry.placed(system))"
            )
        matrix.flags.writeable = False
        self.turn: FloatArray = matrix
        self.factor = as_number(factor, "factor", positive=True)
        self.straight = bool(np.array_equal(matrix, np.eye(size)))
        self.mirrors = bool(np.linalg.det(matrix) < 0.0)

    @property
    def dimension(self) -> int:
        """Number of coordinates."""
        return self.shift.size

    def points(self, points: FloatArray) -> FloatArray:
        """Images of points (n, d)."""
        return self.vectors(points) + self.shift

    def vectors(self, vectors: FloatArray) -> FloatArray:
        """Images of vectors (n, d), which are turned and stretched but not shifted."""
        turned = vectors if self.straight else _product(vectors, self.turn)
        return turned if self.factor == 1.0 else self.factor * turned

    def back(self, points: FloatArray) -> FloatArray:
        """The points (n, d) whose images are given."""
        shifted = points - self.shift
        if self.factor != 1.0:
            shifted /= self.factor
        return shifted if self.straight else _product(shifted, self.turn.T)

    def after(self, first: Similarity) -> Similarity:
        """The similarity that does `first` and then this one."""
        shift = self.points(first.shift[None])[0]
        return Similarity(self.turn @ first.turn, self.factor * first.factor, shift)

    def image(self, value: Any, kind: str) -> Any:
        """The image of a parameter of a geometry.

        Args:
            value: number, tuple of numbers, tuple of points, geometry, or None, which stays None.
            kind: "point", "points", "vector", "direction" (keeps its length), "length", "geometry", "geometries", or
                "number" (stays as it is).
        """
        if value is None or kind == "number":
            return value
        if kind == "length":
            return self.factor * value
        if kind == "geometry":
            return value._transformed(self)
        if kind == "geometries":
            return tuple(each._transformed(self) for each in value)
        if kind == "points":
            return row_tuples(self.points(np.array(value)))
        row = np.array(value, dtype=np.float64).reshape(1, -1)  # a coordinate in 1-D may be a plain number
        if kind == "point":
            return coordinate_tuple(self.points(row)[0])
        if kind == "direction":
            return coordinate_tuple(row[0] if self.straight else _product(row, self.turn)[0])
        return coordinate_tuple(self.vectors(row)[0])


def shift(vector: ArrayLike) -> Similarity:
    """A shift by a vector (m), shape (d,)."""
    by = as_vector(vector, "vector")
    return Similarity(np.eye(by.size), 1.0, by)


def rotation(angle: float, axis: ArrayLike | None, center: ArrayLike | None, dimension: int | None) -> Similarity:
    """A turn about a point (2-D) or about an axis through a point (3-D), counterclockwise seen against the axis.

    Args:
        angle: (rad); quarter turns are exact.
        axis: direction of the axis, shape (3,), for 3-D alone.
        center: a point that stays where it is (m), shape (d,); the origin if None.
        dimension: 2 or 3; None: 3 with an axis, otherwise that of the center, otherwise 2.

    Raises:
        BadInput: in 1-D, for an axis in 2-D and none in 3-D, and for an axis without length.
    """
    if dimension is None:
        dimension = 3 if axis is not None else 2 if center is None else as_vector(center, "center").size
    if dimension == 1:
        raise BadInput("nothing turns in 1-D; use mirrored(point, normal) for the other direction")
    if dimension == 2 and axis is not None:
        raise BadInput(f"axis = {axis!r}: in 2-D everything turns in the plane; leave the axis out")
    if dimension == 3 and axis is None:
        raise BadInput("axis is missing: in 3-D give the direction of the axis, such as axis=(0, 0, 1)")
    middle = np.zeros(dimension) if center is None else as_place(center, "center", dimension)
    cosine, sine = cosine_and_sine(as_number(angle, "angle"))
    if dimension == 2:
        turn = np.array([[cosine, -sine], [sine, cosine]])
    else:
        given = as_direction([] if axis is None else axis, "axis", 3)
        x, y, z = given / np.linalg.norm(given)
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        turn = np.eye(3) + sine * cross + (1.0 - cosine) * (cross @ cross)
    return Similarity(turn, 1.0, middle - _product(middle[None], turn)[0])


def mirror(point: ArrayLike, normal: ArrayLike) -> Similarity:
    """The mirror image at a plane (a line in 2-D, a point in 1-D).

    Args:
        point: any point of the plane (m), shape (d,), or one number for all components.
        normal: vector of any length but 0, at right angles to the plane, shape (d,).

    Raises:
        BadInput: for a normal without length and for different numbers of components.
    """
    place, across = as_vectors(point, normal, ("point", "normal"))
    unit = as_direction(across, "normal", across.size)
    unit = unit / np.linalg.norm(unit)
    turn = np.eye(unit.size) - 2.0 * np.outer(unit, unit)
    return Similarity(turn, 1.0, 2.0 * float(place @ unit) * unit)


def scaling(factor: float, center: ArrayLike | None, dimension: int) -> Similarity:
    """A change of size about a point.

    Args:
        factor: by which lengths grow, positive.
        center: the point that stays where it is (m), shape (d,); the origin if None.
        dimension: 1, 2 or 3.

    Raises:
        BadInput: for a factor that is not positive, and a center of another dimension.
    """
    middle = np.zeros(dimension) if center is None else as_place(center, "center", dimension)
    by = as_number(factor, "factor")
    if by <= 0.0:
        raise BadInput(f"factor = {by} is not positive; give a number above 0 (mirrored() turns things around)")
    return Similarity(np.eye(dimension), by, middle - by * middle)


def cosine_and_sine(angle: float) -> tuple[float, float]:
    """Cosine and sine of an angle (rad), exact for quarter turns."""
    quarters = angle / (np.pi / 2)
    whole = round(quarters)
    if abs(quarters - whole) <= QUARTER * max(1.0, abs(quarters)):
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[whole % 4]
    return float(np.cos(angle)), float(np.sin(angle))


def _product(points: FloatArray, matrix: FloatArray) -> FloatArray:
    """Matrix times each point, in one order of summation: a point maps to the same bits in any array."""
    result: FloatArray = points[:, 0:1] * matrix[:, 0]
    for axis in range(1, points.shape[1]):
        result += points[:, axis : axis + 1] * matrix[:, axis]
    return result
