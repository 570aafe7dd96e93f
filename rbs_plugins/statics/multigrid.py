"""Conjugate gradients with algebraic multigrid, by pyamg: for large problems of elasticity that crawl otherwise."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_array, csr_array, diags_array

from rbs_plugins.statics.problem import Vector
from rbs_plugins.statics.stiffness import Stiffness


class Multigrid:
    """K with levels of coarser problems, made of aggregates of nodes that know the rigid motions.

    Args:
        stiffness: symmetric K.
        fixed: (size,) where displacements are prescribed; there K is replaced by its diagonal.
        dimension: of the parts.

    Runs give the same bits for any number of threads, as long as BLAS has as many of its own: the coarsest problem is
    dense.
    """

    def __init__(self, stiffness: Stiffness, fixed: NDArray[np.bool_], dimension: int) -> None:
        import pyamg
        from scipy.sparse import bsr_matrix

        self._K, self._free = stiffness, (~fixed).astype(np.float64)
        keep = diags_array(self._free)
        size = float(np.abs(stiffness.diagonal()).max())
        held = csr_array(keep @ stiffness.matrix() @ keep + diags_array(size * fixed))
        blocks = bsr_matrix(bsr_array(held, blocksize=(dimension, dimension)))
        motions = stiffness.rigid_motions() * self._free[:, None]
        with _same_random_numbers():
            levels = pyamg.smoothed_aggregation_solver(blocks, B=motions, max_coarse=300)
        self._precondition: Any = levels.aspreconditioner().matvec

    def solve(self, rhs: Vector, tolerance: float, most: int) -> tuple[Vector | None, int]:
        """The solution, zero where prescribed, and the iterations that it took; None if so many were not enough."""
        x, r = np.zeros_like(rhs), rhs * self._free
        goal = tolerance**2 * _dot(r, r)
        z = self._precondition(r) * self._free
        p, rz, q = z.copy(), _dot(r, z), np.zeros_like(r)
        for iteration in range(most):
            if _dot(r, r) <= goal:
                return x, iteration
            self._K.multiply(p, q)
            q *= self._free
            bend = _dot(p, q)
            if not bend > 0:
                break
            x += rz / bend * p
            r -= rz / bend * q
            z = self._precondition(r) * self._free
            rz, before = _dot(r, z), rz
            p = z + rz / before * p
        return None, most


@contextmanager
def _same_random_numbers() -> Iterator[None]:
    """For pyamg, which begins estimates of eigenvalues with those of numpy: each run shall give the same bits."""
    before = np.random.get_state()  # noqa: NPY002
    np.random.seed(0)  # noqa: NPY002
    try:
        yield
    finally:
        np.random.set_state(before)  # noqa: NPY002


def _dot(a: Vector, b: Vector) -> float:
    """The product, summed by numpy: no second pool of threads, and the same to the bit for any number of them."""
    return float(np.sum(a * b))
