"""Three vectors that span space: axes from outside, rotations, and the bases of curved coordinates, one per point."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.space.checks import FloatArray, as_number, as_real, as_text, as_vector, require_finite

# Smallest singular value of the normalised axes below which three vectors count as linearly dependent:
# an inverse would then lose ten of the sixteen digits.
INDEPENDENCE = 1e-10


def three_axes(axes: Sequence[ArrayLike]) -> FloatArray:
    """Axes from outside as the rows of a matrix.

    Args:
        axes: three vectors of 2 or 3 components (a missing third is 0) of any length but zero, or two of them.

    Returns:
        Shape (3, 3); where two axes were given, the third row is their normalised cross product.

    Raises:
        BadInput: when an axis has no length or the axes are linearly dependent; the message names them.
    """
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
    _require_independent(matrix, unit)
    if len(rows) == 2:
        normal = np.cross(unit[0], unit[1])
        return np.vstack([matrix, normal / np.linalg.norm(normal)])
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


def combined(points: FloatArray, rows: FloatArray) -> FloatArray:
    """The product points @ rows in one order of summation: a point maps to the same bits in any array.

    Args:
        points: shape (n, 3).
        rows: three vectors, the same for all points, shape (3, 3), or other ones for each, shape (3, n, 3).
    """
    result: FloatArray = points[:, 0:1] * rows[0]
    result += points[:, 1:2] * rows[1]
    result += points[:, 2:3] * rows[2]
    return result


def reciprocal(basis: FloatArray) -> FloatArray:
    """The reciprocal bases: components of a vector are its scalar products with their vectors.

    Args:
        basis: three vectors per point as rows, shape (n, 3, 3).

    Returns:
        Shape (n, 3, 3); NaN where the three vectors are linearly dependent.
    """
    volume = np.linalg.norm(basis, axis=2).prod(axis=1)
    dual = np.stack([np.cross(basis[:, (k + 1) % 3], basis[:, (k + 2) % 3]) for k in range(3)], axis=1)
    spanned = (basis[:, 0] * dual[:, 0]).sum(axis=1)
    independent = np.abs(spanned) > INDEPENDENCE * volume
    dual[~independent] = np.nan
    dual[independent] /= spanned[independent, None, None]
    return dual


def rotation(angle: float, axis: ArrayLike = (0.0, 0.0, 1.0)) -> FloatArray:
    """A rotation as a matrix, to be used as `points @ matrix`: its rows are where the axes are turned to.

    Args:
        angle: rad; by the rule of the right hand about the axis.
        axis: 3 components (or 2: the third is then 0), of any length but zero.

    Raises:
        BadInput: for an axis without length, and for numbers that are not finite.
    """
    turn = as_number(angle, "angle")
    given = as_vector(axis, "axis")
    if given.size == 1:
        raise BadInput(f"axis = {as_text(given)} has one component; give 3, such as (0, 0, 1)")
    vector: FloatArray = np.zeros(3)
    vector[: given.size] = given
    if not vector.any():
        raise BadInput(f"axis = {as_text(given)} has no length; give a vector of any other length")
    x, y, z = vector / np.linalg.norm(vector)
    across = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])  # points @ across = axis x point
    half = 2.0 * np.sin(turn / 2) ** 2  # 1 - cos, without its loss of digits at small angles
    return orthonormal(np.eye(3) + np.sin(turn) * across + half * (across @ across))


def orthonormal(matrix: FloatArray) -> FloatArray:
    """The orthonormal matrix beside one that has round-off, so that many rotations in a row do not add it up."""
    result: FloatArray = 1.5 * matrix - 0.5 * (matrix @ matrix.T @ matrix)  # a step of Newton: errors are squared
    return result
