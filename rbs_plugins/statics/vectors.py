"""Loops over the unknowns of linear solvers: one pass each, and the same sums for any number of threads."""

from __future__ import annotations

import numpy as np

from rbs_plugins.loops import Loop, Text
from rbs_plugins.loops.loop import CHUNK
from rbs_plugins.statics.problem import Vector


def dot(begin, end, thread, a, b, partial, chunk):
    """partial[c] = Σ a b over range c."""
    total = 0.0
    for i in range(begin, end):
        total += a[i] * b[i]
    partial[begin // chunk] = total
    return 0


def descend(begin, end, thread, x, r, z, p, q, inverse, alpha, partial, squares, chunk):
    """One step of conjugate gradients: x += α p, r −= α q, z = r / diagonal; sums of r z and r r over the range.

    Where the inverse of the diagonal is zero nothing moves.
    """
    total = size = 0.0
    for i in range(begin, end):
        x[i] += alpha * p[i]
        rest = r[i] - alpha * q[i] if inverse[i] != 0.0 else 0.0
        r[i] = rest
        z[i] = rest * inverse[i]
        total += rest * z[i]
        size += rest * rest
    partial[begin // chunk] = total
    squares[begin // chunk] = size
    return 0


def turn(begin, end, thread, p, z, beta):
    """New direction: p = z + β p."""
    for i in range(begin, end):
        p[i] = z[i] + beta * p[i]
    return 0


class Gradients:
    """The vectors and loops of conjugate gradients with the diagonal as preconditioner.

    Args:
        size: number of unknowns.

    Attributes:
        x, r, z, p, q: solution, rest, rest over diagonal, direction, K times direction.
    """

    def __init__(self, size: int) -> None:
        self.x, self.r, self.z, self.p, self.q, self.inverse = np.zeros((6, size))
        ranges = -(-size // CHUNK)
        self._sums, self._squares = np.zeros((2, max(ranges, 1)))
        own = {"x": self.x, "r": self.r, "z": self.z, "p": self.p, "q": self.q, "inverse": self.inverse}
        sums = {"partial": self._sums, "squares": self._squares, "chunk": CHUNK}
        self._dot = Loop(Text.of(dot), "dot", {"a": self.p, "b": self.q, **sums}, size)
        self._descend = Loop(Text.of(descend), "descend", {**own, **sums, "alpha": 0.0}, size)
        self._turn = Loop(Text.of(turn), "turn", {**own, "beta": 0.0}, size)

    def start(self, rhs: Vector, inverse: Vector) -> tuple[float, float]:
        """Begins at x = 0; r·z and r·r."""
        self.inverse[...] = inverse
        self.x.fill(0.0)
        self.r[...] = rhs
        self.p.fill(0.0)
        self.q.fill(0.0)
        sums = self.descend(0.0)
        self.p[...] = self.z
        return sums

    def curvature(self) -> float:
        """p·K p, once q is K p."""
        self._dot()
        return float(self._sums.sum())

    def descend(self, alpha: float) -> tuple[float, float]:
        """One step along the direction; r·z and r·r behind it."""
        self._descend.set(alpha=alpha)
        self._descend()
        return float(self._sums.sum()), float(self._squares.sum())

    def turn(self, beta: float) -> None:
        """The next direction."""
        self._turn.set(beta=beta)
        self._turn()
