"""What dynamic relaxation keeps of each part, and its loop: one pass over the arrays for each iteration."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rbs_plugins.loops import Loop, Text
from rbs_plugins.loops.loop import CHUNK
from rbs_plugins.loops.nodes import chunks

NOTHING = 1e200  # fictitious density where nothing pulls, and nothing moves
SUMS = ("unbalanced", "internal", "bending", "inertia", "momentum", "power")
Array = NDArray[np.float64]


def relax(
    begin, end, thread, u, f, v, rest, load, inverse, size, weight, keep, push,
    unbalanced, internal, bending, inertia, momentum, power, chunk,
):  # fmt: skip
    """One iteration: v = keep v + push r / λ, u += v with r = f + load, and the sums that tell how to go on.

    Flat arrays; `size` is the volume V, `weight` λV, zero where nothing moves, as is 1/λ. Sums of range c: |V r|² of
    what moves, |V f|² of all, −v·V(r − last r), v·λV v, |λV v|² and v·V r, with the velocity that led here.
    """
    a = b = c = d = e = p = 0.0
    for i in range(begin, end):
        own, w, s, m = f[i], v[i], size[i], weight[i]
        r = own + load[i] if m > 0.0 else 0.0
        b += (s * own) * (s * own)
        a += (s * r) * (s * r)
        c -= s * w * (r - rest[i])
        d += m * w * w
        e += (m * w) * (m * w)
        p += s * w * r
        rest[i] = r
        w = keep * w + push * r * inverse[i]
        v[i] = w
        u[i] += w
    q = begin // chunk
    unbalanced[q], internal[q], bending[q], inertia[q], momentum[q], power[q] = a, b, c, d, e, p
    return 0


class Body:
    """What one part keeps between iterations; flat arrays (n d,).

    Args:
        u, f: (n, d) its displacement and force density.
        volumes: (n,) m^3.
        before: of an earlier part of the run, whose motion goes on.

    Attributes:
        v: velocity, m per iteration.
        rest: force density that was not balanced, N/m^3.
        load: N/m^3.
        sums: partial ones of `relax`.
    """

    def __init__(self, u: Array, f: Array, volumes: Array, before: Body | None) -> None:
        self._dimension, self._f = u.shape[1], f.reshape(-1)
        self._size = np.repeat(volumes, self._dimension)
        self.v, self.rest, self.load, self._inverse, self._weight = np.zeros((5, u.size))
        if before is not None and before.v.shape == self.v.shape:
            self.v[...], self.rest[...] = before.v, before.rest
        self.sums = {name: chunks(u.size) for name in SUMS}
        arrays = {"u": u.reshape(-1), "f": self._f, "v": self.v, "rest": self.rest, "load": self.load}
        others = {"inverse": self._inverse, "size": self._size, "weight": self._weight, "keep": 0.0, "push": 0.5}
        self._loop = Loop(Text.of(relax), "relax", {**arrays, **others, **self.sums, "chunk": CHUNK}, u.size)

    def weigh(self, mass: Array, fixed: NDArray[np.bool_]) -> None:
        """Sets the fictitious density (n,), N/m^4 (force density per acceleration, the step being 1), and what stays.

        Args:
            mass: where it is zero nothing pulls, and nothing moves.
            fixed: (n d,) prescribed displacements.
        """
        heavy = np.repeat(np.where(mass > 0, mass, NOTHING), self._dimension)
        np.divide(1.0, heavy, out=self._inverse)
        np.multiply(heavy, self._size, out=self._weight)
        self._inverse[fixed] = self._weight[fixed] = self.v[fixed] = 0.0

    def take_load(self) -> None:
        """The load is what the force density holds now."""
        self.load[...] = self._f

    def stop(self) -> None:
        """At rest."""
        self.v.fill(0.0)
        self.rest.fill(0.0)

    def move(self, keep: float, push: float) -> list[float]:
        """One iteration; the sums of `relax`, in its order."""
        self._loop.set(keep=keep, push=push)
        self._loop()
        return [float(each.sum()) for each in self.sums.values()]

    @property
    def nbytes(self) -> int:
        """Bytes held."""
        return sum(a.nbytes for a in (self.v, self.rest, self.load, self._inverse, self._size, self._weight))
