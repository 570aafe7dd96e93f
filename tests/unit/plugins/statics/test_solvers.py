"""Linear solvers: all solve, each says what it cannot, and the one that fits is taken."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_array, diags_array

from rbs_core import BadInput
from rbs_plugins.statics import solvers
from rbs_plugins.statics.solvers import LinearSolver, Singular


class Matrix:
    """A stiffness that is a matrix; counts products."""

    def __init__(self, matrix, symmetric=True):
        self._matrix, self.symmetric, self.size, self.products = csr_array(matrix), symmetric, matrix.shape[0], 0

    def multiply(self, v, out):
        self.products += 1
        out[...] = self._matrix @ v

    def diagonal(self):
        return self._matrix.diagonal()

    def matrix(self):
        return self._matrix


def chain(n, skew=0.0):
    """Springs in a row, the first held softly."""
    return diags_array([-1.0 - skew, 2.01, -1.0 + skew], offsets=[-1, 0, 1], shape=(n, n)).tocsr()


def fixed_ends(n):
    fixed = np.zeros(n, bool)
    fixed[[0, -1]] = True
    return fixed


@pytest.mark.parametrize("kind", ["auto", "cg", "direct", "gmres"])
def test_every_solver_solves(kind):
    n, matrix = 60, chain(60)
    fixed, rhs = fixed_ends(n), np.sin(np.arange(n))
    x = LinearSolver(Matrix(matrix), kind, 2, "somebody").solve(rhs, fixed, 1e-12)
    assert (x[fixed] == 0).all()
    assert (matrix @ x)[~fixed] == pytest.approx(rhs[~fixed], abs=1e-9)


@pytest.mark.parametrize(
    ("size", "symmetric", "dimension", "used"),
    [(60, True, 2, "SuperLU"), (60, False, 3, "SuperLU"), (5000, True, 2, "cg"), (5000, False, 2, "SuperLU"),
     (5000, False, 3, "gmres")],
)  # fmt: skip
def test_auto_takes_the_one_that_fits(size, symmetric, dimension, used):
    matrix = chain(size, 0.0 if symmetric else 0.2) + diags_array(np.ones(size))
    solver = LinearSolver(Matrix(matrix, symmetric), "auto", dimension, "somebody")
    x = solver.solve(np.ones(size), fixed_ends(size), 1e-10)
    assert solver.used == {used: 1}
    assert (matrix @ x)[1:-1] == pytest.approx(np.ones(size - 2), abs=1e-6)


def test_where_gradients_crawl_a_factorisation_takes_over_for_good(monkeypatch):
    monkeypatch.setattr(solvers, "SMALL", 10)
    size = 5000
    matrix = diags_array([-1.0, 2.0 + 1e-9, -1.0], offsets=[-1, 0, 1], shape=(size, size)).tocsr()
    stiffness = Matrix(matrix)
    solver = LinearSolver(stiffness, "auto", 2, "somebody")
    for count in (1, 2):
        solver.solve(np.ones(size), fixed_ends(size), 1e-12)
        assert solver.used == {"cg": 1, "SuperLU": count}
    once = stiffness.products
    solver.solve(np.ones(size), fixed_ends(size), 1e-12)
    assert stiffness.products == once


def test_a_factor_is_kept_until_it_is_forgotten():
    stiffness = Matrix(chain(60))
    solver = LinearSolver(stiffness, "direct", 2, "somebody")
    solver.solve(np.ones(60), fixed_ends(60), 1e-12)
    assert solver.has_factor
    stiffness._matrix = 2 * stiffness._matrix
    old = solver.solve(np.ones(60), fixed_ends(60), 1e-12)
    solver.forget()
    assert solver.solve(np.ones(60), fixed_ends(60), 1e-12) == pytest.approx(0.5 * old)


def test_what_has_no_inverse_is_told():
    indefinite = chain(60) - 3.0 * diags_array(np.ones(60))
    with pytest.raises(Singular, match="gave up after 0 iterations"):
        LinearSolver(Matrix(indefinite), "cg", 2, "somebody").solve(np.ones(60), fixed_ends(60), 1e-12)
    empty = csr_array((60, 60))
    with pytest.raises(Singular, match="singular"):
        LinearSolver(Matrix(empty), "direct", 2, "somebody").solve(np.ones(60), fixed_ends(60), 1e-12)


def test_wrong_names_and_wrong_solvers_are_refused():
    with pytest.raises(
        BadInput, match="somebody: solver='mumps' must be one of auto, cg, direct, gmres, multigrid, pardiso"
    ):
        LinearSolver(Matrix(chain(9)), "mumps", 2, "somebody")
    with pytest.raises(BadInput, match="solver='cg' is for symmetric tangents"):
        LinearSolver(Matrix(chain(9), False), "cg", 2, "somebody").solve(np.ones(9), fixed_ends(9), 1e-9)


@pytest.mark.parametrize("kind", ["auto", "direct"])
def test_what_no_bond_holds_stays_where_it_is_if_asked_for(kind):
    """As a node beside a crack that hangs on bonds of one direction does."""
    n = 60
    matrix = chain(n).tolil()
    matrix[30, :] = matrix[:, 30] = 0.0
    rhs = np.sin(np.arange(n))
    rhs[30] = 0.0
    solver = LinearSolver(Matrix(matrix), kind, 2, "somebody")
    with pytest.raises(Singular):
        solver.solve(rhs, fixed_ends(n), 1e-12)
    solver.holds = True
    x = solver.solve(rhs, fixed_ends(n), 1e-12)
    assert x[30] == 0
    assert (matrix.tocsr() @ x)[1:-1] == pytest.approx(rhs[1:-1], abs=1e-12)


def test_random_numbers_of_multigrid_are_the_same_in_each_run_and_those_of_others_go_on():
    from rbs_plugins.statics.multigrid import _same_random_numbers

    np.random.seed(5)  # noqa: NPY002
    expected = np.random.rand(2).tolist()  # noqa: NPY002
    np.random.seed(5)  # noqa: NPY002
    found, inside = [], []
    for _ in range(2):
        with _same_random_numbers():
            inside.append(np.random.rand())  # noqa: NPY002
        found.append(np.random.rand())  # noqa: NPY002
    assert inside[0] == inside[1]
    assert found == expected
