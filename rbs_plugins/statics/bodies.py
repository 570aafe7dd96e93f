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
    begin, end, thread, u, f, v, rest, load, mass, volume, fixed, keep, push,
    unbalanced, internal, bending, inertia, momentum, power, chunk,
):  # fmt: skip
    """One iteration: v = keep v + push r / λ, u += v with r = f + load, and the sums that tell how to go on.

    Sums of range c, all with volumes: |r|² of what is free, |f|² of all, −v·(r − last r), λ|v|², |λ v|² and v·r, with
    the velocity that led here.
    """
    a = b = c = d = e = p = 0.0
    for i in range(begin, end):
        size, heavy = volume[i], mass[i]
        for k in range(u.shape[1]):
            own, w = f[i, k], v[i, k]
            b += own * own * size * size
            if fixed[i, k] == 0:
                r = own + load[i, k]
                a += r * r * size * size
                c -= size * w * (r - rest[i, k])
                d += size * heavy * w * w
                e += size * heavy * w * size * heavy * w
                p += size * w * r
                rest[i, k] = r
                w = keep * w + push * r / heavy
                v[i, k] = w
                u[i, k] += w
    q = begin // chunk
    unbalanced[q], internal[q], bending[q], inertia[q], momentum[q], power[q] = a, b, c, d, e, p
    return 0


class Body:
    """What one part keeps between iterations.

    Args:
        u, f: (n, d) its displacement and force density.
        volumes: (n,) m^3.
        before: of an earlier part of the run, whose motion goes on.

    Attributes:
        v: (n, d) velocity, m per iteration.
        rest: (n, d) force density that was not balanced, N/m^3.
        load: (n, d) N/m^3.
        fixed: (n, d) whether a displacement is prescribed.
        sums: partial ones of `relax`.
    """

    def __init__(self, u: Array, f: Array, volumes: Array, before: Body | None) -> None:
        self.f, self._mass = f, np.ones(len(u))
        self.v, self.rest, self.load = np.zeros((3, *u.shape))
        if before is not None and before.v.shape == u.shape:
            self.v[...], self.rest[...] = before.v, before.rest
        self.fixed = np.zeros(u.shape, np.uint8)
        self.sums = {name: chunks(len(u)) for name in SUMS}
        arrays = {"u": u, "f": f, "v": self.v, "rest": self.rest, "load": self.load, "mass": self._mass}
        others = {"volume": volumes, "fixed": self.fixed, "keep": 0.0, "push": 0.5, "chunk": CHUNK}
        self._loop = Loop(Text.of(relax), "relax", {**arrays, **others, **self.sums}, len(u), u.size)

    def weigh(self, mass: Array) -> None:
        """Sets the fictitious density (n,), N/m^4: force density per acceleration, the step being 1."""
        self._mass[...] = np.where(mass > 0, mass, NOTHING)

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
        return sum(each.nbytes for each in (self.v, self.rest, self.load, self._mass, self.fixed))
