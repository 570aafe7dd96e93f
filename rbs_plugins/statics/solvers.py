"""Linear solvers: which one fits is decided by size and symmetry, unless the user has chosen."""

from __future__ import annotations

import importlib.util
import math
import weakref
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, eye_array
from scipy.sparse.linalg import LinearOperator, gmres, spilu, splu

from rbs_core import BadInput
from rbs_core.report import log
from rbs_plugins.statics.multigrid import Multigrid
from rbs_plugins.statics.problem import Vector
from rbs_plugins.statics.stiffness import Stiffness
from rbs_plugins.statics.vectors import Gradients

SOLVERS = ("auto", "cg", "direct", "gmres", "multigrid", "pardiso")
OPTIONAL = {"pardiso": "pypardiso", "multigrid": "pyamg"}  # the packages that they need
SMALL = 4_000  # unknowns up to which a factorisation takes no longer than the iterations would
TINY = 1e-300
LITTLE = 1e-10  # stiffness by which nodes are held, as a share of the largest one


class Singular(ArithmeticError):
    """A stiffness that has no inverse, as far as a solver can tell."""


class LinearSolver:
    """Solves K x = rhs for the unknowns that are not prescribed.

    Args:
        stiffness: K.
        kind: "cg" for conjugate gradients with products and the diagonal only, no matrix (symmetric K); "direct" for a
            factorisation by SuperLU; "pardiso" for one by Intel's solver, several times as fast, which needs pypardiso
            and gives other bits for other numbers of threads; "gmres" with incomplete factors; "multigrid"
            for conjugate gradients with algebraic multigrid, which needs pyamg (symmetric K); "auto" takes a
            factorisation for small problems, conjugate gradients for large symmetric ones with a factorisation as the
            second try, and a factorisation, or in 3-D gmres, for large ones that are not.
        dimension: of the parts.
        owner: name for messages.

    Attributes:
        holds: whether a factorisation holds every node a little, as bonds that have failed may leave some free in some
            direction; the error of this is taken back as far as forces tell.
        used: names of the solvers that have been used, with how often.
        factorised: how often a matrix has been factorised.
        iterations: of the last solution.
        slow: whether conjugate gradients have given up before; "auto" does not try them again then.

    Raises:
        BadInput: on an unknown name.
    """

    def __init__(self, stiffness: Stiffness, kind: str, dimension: int, owner: str) -> None:
        if kind not in SOLVERS:
            raise BadInput(f"{owner}: solver={kind!r} must be one of {', '.join(SOLVERS)}")
        package = OPTIONAL.get(kind)
        if package is not None and importlib.util.find_spec(package) is None:
            raise BadInput(f"{owner}: solver='{kind}' needs {package}: pip install 'rbs[{kind}]', or take 'auto'")
        self._K, self._kind, self._dimension, self._owner = stiffness, kind, dimension, owner
        self.holds = False
        self.used: dict[str, int] = {}
        self.factorised = 0
        self.iterations = 0
        self._gradients: Gradients | None = None
        self._factor: Any = None
        self.slow = False
        self._exact: csr_array | None = None  # the factorised matrix, where nodes are held in its factors
        self._kept: NDArray[np.bool_] | None = None  # what was prescribed in the factorised matrix

    @property
    def has_factor(self) -> bool:
        """True if a factorisation is there that can be used again."""
        return self._factor is not None

    def forget(self) -> None:
        """Called when K has changed: a factorisation is of no use any more."""
        self._factor = None

    def solve(self, rhs: Vector, fixed: NDArray[np.bool_], tolerance: float) -> Vector:
        """The solution (size,), zero where fixed.

        Args:
            rhs: (size,) right-hand side.
            fixed: (size,) where x is zero and rhs does not count.
            tolerance: of the norm of the rest over that of rhs, for iterations.

        Raises:
            Singular: if K has no inverse, or iterations do not converge.
        """
        kind = self._choose()
        if kind == "cg":
            x = self._cg(rhs, fixed, tolerance)
            if x is not None:
                return x
            if self._kind == "cg":
                raise Singular(
                    f"conjugate gradients gave up after {self.iterations} iterations (the stiffness may be singular, "
                    "or negative along some displacement): take solver='direct'"
                )
            self.slow = True
            log.info("%s: conjugate gradients did not converge in %d iterations, factorising from now on",
                     self._owner, self.iterations)  # fmt: skip
            kind = "direct"
        if kind == "multigrid":
            return self._multigrid(rhs, fixed, tolerance)
        return self._gmres(rhs, fixed, tolerance) if kind == "gmres" else self._direct(rhs, fixed)

    def _choose(self) -> str:
        if self._kind != "auto":
            return self._kind
        if self._factor is not None or self._K.size <= SMALL or self.slow:
            return "direct"
        if self._K.symmetric:
            return "cg"
        return "direct" if self._dimension < 3 else "gmres"

    def _count(self, name: str) -> None:
        self.used[name] = self.used.get(name, 0) + 1

    # -- conjugate gradients ----------------------------------------------------------------------------------------

    def _cg(self, rhs: Vector, fixed: NDArray[np.bool_], tolerance: float) -> Vector | None:
        """None if K bends down along some direction, or after many iterations."""
        self._require_symmetric()
        self._count("cg")
        g = self._gradients = self._gradients or Gradients(self._K.size)
        diagonal = self._K.diagonal()
        if not (diagonal[~fixed] > 0).all():
            self.iterations = 0
            return None
        inverse = np.zeros(self._K.size)
        np.divide(1.0, diagonal, out=inverse, where=~fixed)
        rz, rr = g.start(np.where(fixed, 0.0, rhs), inverse)
        goal = tolerance**2 * rr
        most = 20 + int(60 * math.sqrt(self._K.size)) if self._kind == "cg" else 200 + int(4 * math.sqrt(self._K.size))
        for iteration in range(most):
            self.iterations = iteration
            if rr <= goal or rr < TINY:
                return g.x.copy()
            self._K.multiply(g.p, g.q)
            bend = g.curvature()
            if not bend > 0:
                return None
            before = rz
            rz, rr = g.descend(rz / bend)
            g.turn(rz / before if before else 0.0)
        self.iterations = most
        return None

    def _require_symmetric(self) -> None:
        if not self._K.symmetric:
            raise BadInput(
                f"{self._owner}: solver='{self._kind}' is for symmetric tangents, and this one is not: take 'gmres'"
            )

    def _multigrid(self, rhs: Vector, fixed: NDArray[np.bool_], tolerance: float) -> Vector:
        self._require_symmetric()
        self._count("multigrid")
        if self._factor is None or self._kept is None or not np.array_equal(self._kept, fixed):
            self._factor, self._kept = Multigrid(self._K, fixed, self._dimension), fixed.copy()
        x, self.iterations = self._factor.solve(rhs, tolerance, 500)
        if x is None:
            raise Singular(f"multigrid did not converge in {self.iterations} iterations: take solver='direct'")
        return np.asarray(x)

    # -- factorisation ----------------------------------------------------------------------------------------------

    def _reduced(self, fixed: NDArray[np.bool_]) -> csr_array:
        """The rows and columns of K that are not prescribed."""
        matrix = self._K.matrix()
        free = np.flatnonzero(~fixed)
        return csr_array(matrix[free][:, free]) if len(free) < self._K.size else matrix

    def _direct(self, rhs: Vector, fixed: NDArray[np.bool_]) -> Vector:
        if self._factor is None or self._kept is None or not np.array_equal(self._kept, fixed):
            make = _Pardiso if self._kind == "pardiso" else _SuperLU
            matrix = self._reduced(fixed)
            self._exact = matrix if self.holds else None
            if self.holds:
                matrix = csr_array(matrix + LITTLE * matrix.diagonal().max(initial=0.0) * eye_array(matrix.shape[0]))
            self._factor = _factorised(make, matrix, self._K.symmetric)
            self._kept = fixed.copy()
            self.factorised += 1
        self._count(self._factor.name)
        self.iterations = 1
        x = np.zeros(self._K.size)
        x[~fixed] = self._factor.solve(rhs[~fixed])
        if self._exact is not None:
            x[~fixed] += self._factor.solve(rhs[~fixed] - self._exact @ x[~fixed])
        if not np.isfinite(x).all():
            raise Singular("the factorised stiffness gives displacements that are not finite")
        return x

    def _gmres(self, rhs: Vector, fixed: NDArray[np.bool_], tolerance: float) -> Vector:
        self._count("gmres")
        free, size = ~fixed, self._K.size
        whole, out = np.zeros(size), np.zeros(size)

        def product(v: Vector) -> Vector:
            whole[free] = v.ravel()
            self._K.multiply(whole, out)
            return out[free]

        count = int(free.sum())
        steps = [0]

        def counted(_: Any) -> None:
            steps[0] += 1

        try:
            incomplete = spilu(csc_array(self._reduced(fixed)), drop_tol=1e-4, fill_factor=8)
        except RuntimeError as error:
            raise Singular(str(error)) from None
        x, failed = gmres(
            LinearOperator((count, count), product, dtype=np.float64), rhs[free], rtol=tolerance, restart=60,
            maxiter=20, M=LinearOperator((count, count), incomplete.solve, dtype=np.float64),
            callback=counted, callback_type="pr_norm",
        )  # fmt: skip
        self.iterations = steps[0]
        if failed or not np.isfinite(x).all():
            raise Singular(f"gmres did not converge in {steps[0]} iterations: take solver='direct'")
        result = np.zeros(size)
        result[free] = x
        return result


class _SuperLU:
    name = "SuperLU"

    def __init__(self, matrix: csr_array, symmetric: bool) -> None:
        options = {"SymmetricMode": True} if symmetric else {}
        try:
            self._lu = splu(csc_array(matrix), permc_spec="MMD_AT_PLUS_A" if symmetric else "COLAMD",
                            diag_pivot_thresh=0.01 if symmetric else 1.0, options=options)  # fmt: skip
        except RuntimeError as error:
            raise Singular(str(error)) from None
        self.solve = self._lu.solve


class _Pardiso:
    """Intel's solver, by pypardiso."""

    name = "pardiso"

    def __init__(self, matrix: csr_array, symmetric: bool) -> None:
        from pypardiso import PyPardisoSolver
        from scipy.sparse import csr_matrix, triu

        self._solver = PyPardisoSolver(mtype=-2 if symmetric else 11)
        self._matrix = csr_matrix(triu(matrix, format="csr") if symmetric else matrix)
        self._solver.factorize(self._matrix)
        weakref.finalize(self, self._solver.free_memory, everything=True)

    def solve(self, rhs: Vector) -> Vector:
        """The solution of the factorised matrix."""
        return np.asarray(self._solver.solve(self._matrix, rhs)).ravel()


def _factorised(make: type[_SuperLU] | type[_Pardiso], matrix: csr_array, symmetric: bool) -> _SuperLU | _Pardiso:
    if not matrix.shape[0]:
        raise Singular("every displacement is prescribed: there is nothing to solve")
    return make(matrix, symmetric)
