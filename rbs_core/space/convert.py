"""Mappings between the coordinates of a system and those of its parent, on (n, 3) arrays."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.space.checks import Bounds, FloatArray, as_real, as_text, as_vector, require_finite

# Smallest singular value of the normalised axes below which three vectors count as linearly dependent:
# an inverse would then lose ten of the sixteen digits.
INDEPENDENCE = 1e-10


class Mapping(ABC):
    """How the coordinates of a system and of its parent belong together.

    A kind of coordinates (Cartesian, cylindrical, ...) is a subclass with two functions on arrays of shape (n, 3);
    the tree of systems knows nothing else about it.
    """

    @abstractmethod
    def to_parent(self, points: FloatArray) -> FloatArray:
        """Points (n, 3) in own coordinates, in those of the parent (a new array)."""

    @abstractmethod
    def from_parent(self, points: FloatArray) -> FloatArray:
        """Points (n, 3) in the parent's coordinates, in own ones (a new array)."""

    def bounds_to_parent(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        """A box in the parent's coordinates around the image of a box; all of space unless a kind knows better.

        Args:
            lower: smallest own coordinates, shape (3,), may be -inf.
            upper: largest own coordinates, shape (3,), may be +inf.

        Returns:
            Smallest and largest coordinates in the parent, shape (3,) each.
        """
        return np.full(3, -np.inf), np.full(3, np.inf)

    def least_stretch(self, dimension: int) -> float:
        """Smallest factor by which a length grows on its way to the parent; 0 where no such factor is known.

        Args:
            dimension: 1, 2 or 3; only the first so many coordinates vary.
        """
        return 0.0


class Cartesian(Mapping):
    """Straight axes: parent = origin + x axes[0] + y axes[1] + z axes[2].

    Args:
        origin: own origin in the parent's coordinates (m), 1 to 3 components; missing ones are 0.
        axes: three vectors in the parent's coordinates: where one unit along x, y and z leads. Any length but zero
            and any angles: long axes stretch, oblique axes shear. Two vectors are enough: the third is their
            normalised cross product. Vectors of two components get a third of 0. None: the parent's own axes.

    Raises:
        BadInput: when an axis has no length or the axes are linearly dependent; the message names them.
    """

    def __init__(self, origin: ArrayLike = (0.0, 0.0, 0.0), axes: Sequence[ArrayLike] | None = None) -> None:
        given = as_vector(origin, "origin")
        self.origin: FloatArray = np.zeros(3)
        self.origin[: given.size] = given
        self.axes = np.eye(3) if axes is None else _three_axes(axes)
        self._inverse: FloatArray = np.asarray(np.linalg.inv(self.axes), dtype=np.float64)
        self._shift_only = bool(np.array_equal(self.axes, np.eye(3)))
        self.origin.flags.writeable = self.axes.flags.writeable = False

    def to_parent(self, points: FloatArray) -> FloatArray:
        """Points (n, 3) in own coordinates, in those of the parent (a new array)."""
        turned = points if self._shift_only else _combined(points, self.axes)
        return turned + self.origin

    def from_parent(self, points: FloatArray) -> FloatArray:
        """Points (n, 3) in the parent's coordinates, in own ones (a new array)."""
        shifted = points - self.origin
        return shifted if self._shift_only else _combined(shifted, self._inverse)

    def bounds_to_parent(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        """The smallest box in the parent's coordinates around the image of a box (the hull of its corners)."""
        least, most = self.origin.copy(), self.origin.copy()
        for axis, low, high in zip(self.axes, lower, upper, strict=True):
            for component in np.flatnonzero(axis):  # a zero component adds nothing, not even 0 times infinity
                ends = sorted((low * axis[component], high * axis[component]))
                least[component] += ends[0]
                most[component] += ends[1]
        return least, most

    def least_stretch(self, dimension: int) -> float:
        """Smallest factor by which a length grows on its way to the parent."""
        block = self.axes[:dimension, :dimension]
        if np.abs(block @ block.T - np.eye(dimension)).max() <= 1e-14:  # turned only: no round-off in the factor
            return 1.0
        return float(np.linalg.svd(block, compute_uv=False)[-1])

    def __repr__(self) -> str:
        return f"Cartesian({self.arguments()})"

    def arguments(self) -> str:
        """The arguments as they could be typed, axes left out where they are the parent's."""
        axes = "" if self._shift_only else f", axes={as_text(self.axes)}"
        return f"origin={as_text(self.origin)}{axes}"


def _combined(points: FloatArray, rows: FloatArray) -> FloatArray:
    """The product points @ rows in one order of summation: a point maps to the same bits in any array."""
    result: FloatArray = points[:, 0:1] * rows[0]
    result += points[:, 1:2] * rows[1]
    result += points[:, 2:3] * rows[2]
    return result


def _three_axes(axes: Sequence[ArrayLike]) -> FloatArray:
    """The 3 x 3 matrix of axes as rows, checked."""
    rows = list(axes)
    if len(rows) not in (2, 3):
        raise BadInput(f"axes has {len(rows)} vectors; give 3, or 2 (the third is their normalised cross product)")
    matrix = np.zeros((len(rows), 3))
    for index, row in enumerate(rows):
        vector = np.asarray(as_real(row, f"axes[{index}]"), dtype=np.float64)
        if vector.shape not in ((2,), (3,)):
            raise BadInput(f"axes[{index}] has shape {vector.shape}; give 3 components (or 2: the third is then 0)")
        require_finite(vector, f"axes[{index}]")
        matrix[index, : vector.size] = vector
    lengths = np.linalg.norm(matrix, axis=1)
    for index, length in enumerate(lengths.tolist()):
        if length == 0.0:
            raise BadInput(f"axes[{index}] = {as_text(matrix[index])} has no length; give a vector of any other length")
    unit = matrix / lengths[:, None]
    if len(rows) == 2:
        _require_independent(matrix, unit)
        normal = np.cross(unit[0], unit[1])
        return np.vstack([matrix, normal / np.linalg.norm(normal)])
    _require_independent(matrix, unit)
    return matrix


def _require_independent(matrix: FloatArray, unit: FloatArray) -> None:
    """Refuse axes that span less than a space of their number; name the fewest that are to blame."""
    count = len(matrix)
    pairs = [(i, j) for i in range(count) for j in range(i + 1, count)]
    for group in (*pairs, tuple(range(count))):
        rows = list(group)
        if np.linalg.svd(unit[rows], compute_uv=False)[-1] < INDEPENDENCE:
            named = ", ".join(f"axes[{index}] = {as_text(matrix[index])}" for index in rows)
            lie = "are parallel" if len(rows) == 2 else "lie in one plane"
            raise BadInput(f"{named} {lie}; give linearly independent axes")
