"""A factorised stiffness that follows small changes: what failed bonds have carried is taken out of its inverse."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from rbs_core.trigger import Clock
from rbs_plugins.statics.problem import Vector
from rbs_plugins.statics.solvers import LinearSolver, Singular
from rbs_plugins.statics.stiffness import Stiffness

MOST = 60  # rank of the changes from which on a new factorisation is cheaper
SMALL = 1e-12  # entries and eigenvalues below this share of the largest are round-off


class Lowered:
    """Solutions with a symmetric stiffness of which a few bonds are lost from call to call.

    Args:
        stiffness: asked anew in each call.
        solver: of linear equations.

    Attributes:
        fresh: whether the last solution began with a factorisation of its own.

    The change of K is V diag(s) Vᵀ with few columns; (K + V s Vᵀ)⁻¹ follows from K⁻¹ V by the formula of Woodbury.
    """

    def __init__(self, stiffness: Stiffness, solver: LinearSolver) -> None:
        self._K, self._solver = stiffness, solver
        self._matrix: csr_array | None = None
        self._fixed: NDArray[np.bool_] | None = None
        self.fresh = True

    def solve(self, loads: Vector, goal: Vector, fixed: NDArray[np.bool_], clock: Clock) -> Vector:
        """Displacements (size,) under loads (size,), N, where some are prescribed, m.

        Raises:
            Singular: if they are not determined.
        """
        self._K.update(clock)
        matrix = self._K.matrix().copy()
        same = self._fixed is not None and np.array_equal(fixed, self._fixed)
        self.fresh = not same or not self._change(matrix)
        if self.fresh:
            self._begin(matrix, fixed)
        self._matrix = matrix
        known = np.where(fixed, goal, 0.0)
        if fixed.all():
            return known
        rhs = np.where(fixed, 0.0, loads - matrix @ known)
        return known + self._inverse(rhs)

    def forget(self) -> None:
        """The next solution begins with a factorisation."""
        self._fixed = None

    def _begin(self, matrix: csr_array, fixed: NDArray[np.bool_]) -> None:
        self._solver.forget()
        self._fixed = fixed.copy()
        size = len(fixed)
        self._V, self._Z, self._s = np.zeros((size, 0)), np.zeros((size, 0)), np.zeros(0)

    def _change(self, matrix: csr_array) -> bool:
        """Takes a change of K into account; False if it is too large."""
        assert self._matrix is not None
        assert self._fixed is not None
        moved: Any = (matrix - self._matrix).tocoo()
        scale = np.abs(self._matrix.data).max()
        keep = (np.abs(moved.data) > SMALL * scale) & ~self._fixed[moved.row] & ~self._fixed[moved.col]
        rows = np.unique(moved.row[keep])
        if not len(rows):
            return True
        if len(rows) > 4 * MOST:
            return False
        dense = np.zeros((len(rows), len(rows)))
        dense[np.searchsorted(rows, moved.row[keep]), np.searchsorted(rows, moved.col[keep])] = moved.data[keep]
        values, vectors = np.linalg.eigh(0.5 * (dense + dense.T))
        some = np.abs(values) > SMALL * scale
        if len(self._s) + some.sum() > MOST:
            return False
        new = np.zeros((len(self._fixed), int(some.sum())))
        new[rows] = vectors[:, some]
        solved = np.stack([self._solver.solve(column, self._fixed, SMALL) for column in new.T], axis=1)
        self._V, self._Z = np.hstack([self._V, new]), np.hstack([self._Z, solved])
        self._s = np.concatenate([self._s, values[some]])
        return True

    def _inverse(self, rhs: Vector) -> Vector:
        assert self._fixed is not None
        x = self._solver.solve(rhs, self._fixed, SMALL)
        if len(self._s):
            core = np.diag(1.0 / self._s) + self._V.T @ self._Z
            try:
                x = x - self._Z @ np.linalg.solve(core, self._V.T @ x)
            except np.linalg.LinAlgError as error:
                raise Singular(str(error)) from None
        return x
