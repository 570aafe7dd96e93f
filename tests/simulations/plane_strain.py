"""Plates in plane strain by finite elements of second order, for comparison: small strains, a quarter of each plate."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Where = Callable[[np.ndarray], np.ndarray]


class Quarter:
    """A quarter of a plate whose right edge is moved along x and held along y.

    Args:
        mesh: of quadrilaterals, with the axes of symmetry x = 0 and y = 0.
        E, nu: Pa, 1.
        right: x of the edge, m.
        pull: its displacement, m.
        sticks: of points (2, n) on the axis x = 0: whether they are held along x; all of them if not given.
    """

    def __init__(self, mesh, E: float, nu: float, right: float, pull: float, sticks: Where | None = None) -> None:
        from skfem import Basis, BilinearForm, ElementQuad2, ElementVector, condense, solve
        from skfem.helpers import ddot, sym_grad, trace

        lame, G = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
        self.lame, self.G = lame, G
        self.basis = Basis(mesh, ElementVector(ElementQuad2()))

        @BilinearForm
        def stiffness(u, v, w):
            return lame * trace(sym_grad(u)) * trace(sym_grad(v)) + 2 * G * ddot(sym_grad(u), sym_grad(v))

        near = 1e-9 * right
        axis, edge, below = (
            mesh.facets_satisfying(each, boundaries_only=True)
            for each in (
                lambda x: (x[0] < near) & (True if sticks is None else sticks(x)),
                lambda x: x[0] > right - near,
                lambda x: x[1] < near,
            )
        )
        u = np.zeros(self.basis.N)
        moved = self.basis.get_dofs(edge).all(["u^1"])
        u[moved] = pull
        held = [self.basis.get_dofs(axis).all(["u^1"]), moved]
        held += [self.basis.get_dofs(each).all(["u^2"]) for each in (edge, below)]
        self.u = solve(*condense(stiffness.assemble(self.basis), x=u, D=np.unique(np.concatenate(held))))

    def displacement(self, points: np.ndarray) -> np.ndarray:
        """At points (n, 2) of the quarter, (n, 2), m."""
        n = len(points)
        return (self.basis.probes(np.asarray(points).T) @ self.u).reshape(2, n).T

    def stress_along(self, points: np.ndarray, h: float) -> np.ndarray:
        """σ_xx at points (n, 2) of the quarter, from differences over ± h, Pa."""
        step = h * np.eye(2)
        right, left, up, down = (self.displacement(points + move) for move in (step[0], -step[0], step[1], -step[1]))
        e_x, e_y = (right - left)[:, 0] / (2 * h), (up - down)[:, 1] / (2 * h)
        return self.lame * (e_x + e_y) + 2 * self.G * e_x


def around_hole(a: float, b: float, radius: float, along: int = 80, across: int = 40):
    """Mesh of 0 < x < a, 0 < y < b without the disk around the origin, finer towards it."""
    from skfem import MeshQuad

    grid = MeshQuad.init_tensor(np.linspace(0, 1, along + 1), np.linspace(0, 1, across + 1))
    s, t = grid.p[0], grid.p[1] ** 1.6
    corner = round(along * b / (a + b)) / along
    outer = np.where(
        s <= corner, [np.full_like(s, a), b * s / corner], [a * (1 - s) / (1 - corner), np.full_like(s, b)]
    )
    inner = radius * np.array([np.cos(s * np.pi / 2), np.sin(s * np.pi / 2)])
    places = inner + (outer - inner) * t
    return MeshQuad(np.where(np.abs(places) < 1e-12, 0.0, places), grid.t)


def beside_crack(a: float, b: float, crack: float):
    """Mesh of 0 < x < a, 0 < y < b, finer towards (0, crack)."""
    from skfem import MeshQuad

    steps = np.linspace(0, 1, 25) ** 2.5
    return MeshQuad.init_tensor(a * steps, np.concatenate([crack * (1 - steps[::-1]), crack + (b - crack) * steps[1:]]))
