"""Which steps of whole cells lead to the neighbors of a node on a regular grid, and how many they are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def half_steps(shape: tuple[int, ...], ratio: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Vectors (h, d) within the horizon, and their distances in cell numbers, positive and ascending."""
    # no further than the grid is long, so that a huge horizon (metres for millimetres) costs no memory
    axes = [np.arange(-int(min(ratio, n - 1)), int(min(ratio, n - 1)) + 1) for n in shape]
    vectors = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
    vectors = vectors[(vectors**2).sum(axis=1) <= ratio**2]
    # of two opposite vectors the one whose last component that is not zero is positive
    place = np.array([1, *np.cumprod(2 * np.array(shape[:-1], np.int64) + 1)], np.int64)
    vectors = vectors[vectors @ place > 0]
    steps = vectors @ np.array([1, *np.cumprod(shape[:-1])], np.int64)
    order = np.argsort(steps, kind="stable")
    return vectors[order], steps[order]


def half_family_size(shape: tuple[int, ...], ratio: float) -> float:
    """Half the number of vectors of whole numbers, zero left out, within a ball of that radius and within a grid."""
    reach = [int(min(ratio, n - 1)) for n in shape]
    across = np.zeros(1)
    for most in reach[1:]:  # all but one axis; along that one they are counted in one go
        across = (across[:, None] + np.arange(-most, most + 1.0) ** 2).ravel()
        across = across[across <= ratio**2]
    along = np.minimum(np.sqrt(ratio**2 - across), reach[0])
    return float((2 * np.floor(along) + 1).sum() - 1) / 2
