"""Chains: the part of a tangent that goes through sums at nodes, Σ_p L_pᵀ G_p C_p, L = C unless forces fade.

A node p has a sum of q numbers of the displacements of its family, with the derivative C_p, and an energy whose second
derivative by that sum is G_p: so are made the volume part of the ordinary state-based solid (q = 1, the dilatation) and
correspondence models (q = d², the deformation gradient).
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_plugins.loops.loop import Loop, Text
from rbs_plugins.loops.recipe import indented
from rbs_plugins.loops.rows import row_ranges
from rbs_plugins.loops.rows_text import SUMS
from rbs_plugins.tangents.matrix import BlockMatrix
from rbs_plugins.tangents.pattern import Pattern, threads

Array = NDArray[np.float64]


class Chain:
    """Σ_p L_pᵀ G_p C_p over rows p of a pattern whose columns are nodes.

    Args:
        pattern: which nodes the sum of each row takes, itself among them if it does.
        dimension: d.
        size: q, how many numbers the sum of a row has.
        gradient: True if the sum is a gradient, with q = d²: number c d + k is Σ v_c g_k, with one vector g for an
            entry in place of a block.
        apart: whether L is not C: forces then are not those of an energy.

    Attributes:
        blocks: (e, q, d), or (e, d) the vectors of a gradient: C, to be filled in by the owner before use.
        left: L, of the same shape; C itself unless it is apart.
        weights: (rows, q, q): G, to be filled in, too. It need not be symmetric.
    """

    def __init__(
        self, pattern: Pattern, dimension: int, size: int, *, gradient: bool = False, apart: bool = False
    ) -> None:
        assert not gradient or size == dimension**2
        self.pattern, self.dimension, self.size, self._gradient = pattern, dimension, size, gradient
        self.blocks = np.zeros((len(pattern), dimension) if gradient else (len(pattern), size, dimension))
        self.left = np.zeros_like(self.blocks) if apart else self.blocks
        self.weights = np.zeros((pattern.rows, size, size))
        self._room = np.zeros((pattern.rows, size))
        self._turned: Array | None = None  # L in the order in which products read it, made when one is asked for
        self._stale = True
        self._loops: dict[str, Loop] = {}

    def changed(self) -> None:
        """Called by the owner when it has filled in blocks anew."""
        self._stale = True

    def _loop(self, name: str, rows: int, work: int, **arguments: Any) -> Loop:
        """The loop of a name, with other arrays of the same shapes from the second time on."""
        if name not in self._loops:
            back, back_rows, back_entries = self.pattern.transposed
            given = {"starts": self.pattern.starts, "columns": self.pattern.columns, "back": back, "rows": back_rows,
                     "entries": back_entries, "blocks": self.blocks, "left": self.left,
                     "weights": self.weights, "room": self._room, **arguments}  # fmt: skip
            text = _text(name, self.dimension, self.size, self._gradient)
            self._loops[name] = Loop(text, name, given, row_ranges(rows), work)
        loop = self._loops[name]
        loop.set(**arguments)
        return loop

    def add_to(self, matrix: BlockMatrix) -> None:
        """Adds the blocks to a matrix whose pattern has at least those of `pattern.normal`."""
        found = matrix.pattern
        where = np.zeros((threads(), found.rows), np.uint32)
        work = len(self.pattern) * max(len(self.pattern) // max(self.pattern.rows, 1), 1)
        self._loop("fill", found.rows, work, found_starts=found.starts, found=found.columns, where=where,
                   data=matrix.data)()  # fmt: skip

    def multiply(self, v: Array, out: Array) -> None:
        """Adds the product with v, (d columns,), to `out`."""
        if self._stale:
            self._turned = np.empty_like(self.left) if self._turned is None else self._turned
            np.take(self.left, self.pattern.transposed[2], axis=0, out=self._turned, mode="clip")
            self._stale = False
        self._loop("gather", self.pattern.rows, len(self.pattern), v=v)()
        self._loop("spread", self.pattern.width, len(self.pattern), turned=self._turned, out=out)()

    def diagonal(self, out: Array) -> None:
        """Adds the diagonal to `out`, (d columns,)."""
        self._loop("diagonal", self.pattern.width, len(self.pattern), out=out)()

    def sums(self, v: Array) -> Array:
        """(rows, q) C v; the array is the chain's own, and holds G C v after a product."""
        self._loop("total", self.pattern.rows, len(self.pattern), v=v)()
        return self._room

    @property
    def nbytes(self) -> int:
        """Bytes of blocks and weights."""
        left = 0 if self.left is self.blocks else self.left.nbytes
        left += 0 if self._turned is None else self._turned.nbytes
        return self.blocks.nbytes + left + self.weights.nbytes + self._room.nbytes


class _Write:
    """Pieces of source for some d and q: all blocks are written out, number by number."""

    def __init__(self, d: int, q: int, gradient: bool) -> None:
        self.d, self.q, self.gradient = range(d), range(q), gradient
        self._wide = d

    def terms(self, entry: str, s: int, a: int, of: str = "blocks") -> str | None:
        """Source of C[entry][s, a], or of L; None where it is zero by structure."""
        if not self.gradient:
            return f"{of}[{entry}, {s}, {a}]"
        return f"{of}[{entry}, {s % self._wide}]" if s // self._wide == a else None

    def total(self, pairs: list[tuple[str | None, str]]) -> str:
        return " + ".join(f"{one} * {two}" for one, two in pairs if one is not None)

    def weighted(self) -> list[str]:
        """Lines that set w, the d × q numbers of L[e]ᵀ G of row p."""
        return [
            f"w{a}_{s} = " + self.total([(self.terms("e", r, a, "left"), f"weights[p, {r}, {s}]") for r in self.q])
            for a in self.d
            for s in self.q
        ]

    def block(self, a: int, b: int, entry: str) -> str:
        """(w C[entry])[a, b]."""
        return self.total([(self.terms(entry, s, b), f"w{a}_{s}") for s in self.q])

    def sums(self) -> list[str]:
        """Lines that set s, the q numbers of C_p v."""
        columns = [f"v{a} = v[{len(self.d)} * columns[f] + {a}]" for a in self.d]
        added = [f"s{s} += " + self.total([(self.terms("f", s, a), f"v{a}") for a in self.d]) for s in self.q]
        return [*(f"s{s} = 0.0" for s in self.q), "for f in range(starts[p], starts[p + 1]):",
                *indented([*columns, *added])]  # fmt: skip


@cache
def _text(name: str, d: int, q: int, gradient: bool) -> Text:
    """The module of one of the loops of a chain."""
    write = _Write(d, q, gradient)
    given = {"fill": "starts, columns, back, rows, entries, blocks, left, weights, found_starts, found, where, data",
             "gather": "starts, columns, blocks, weights, room, v", "total": "starts, columns, blocks, room, v",
             "spread": "back, rows, turned, room, out",
             "diagonal": "back, rows, entries, blocks, left, weights, out"}[name]  # fmt: skip
    if name in ("gather", "total"):
        weighted = [" + ".join(f"weights[p, {r}, {s}] * s{s}" for s in write.q) for r in write.q]
        kept = weighted if name == "gather" else [f"s{s}" for s in write.q]
        kept = [f"room[p, {s}] = {source}" for s, source in enumerate(kept)]
        body = ["for p in range(begin, end):", *indented([*write.sums(), *kept])]
    else:
        inner = {"fill": _fill, "spread": _spread, "diagonal": _diagonal}[name](write, d)
        body = ["for i in range(begin, end):", *indented(inner)]
    return Text("\n".join([SUMS, f"def {name}(begin, end, thread, {given}):", *indented([*body, "return 0"])]) + "\n")


def _fill(write: _Write, d: int) -> list[str]:
    adding = [f"data[place + {a} * step + {b}] += {write.block(a, b, 'f')}" for a in write.d for b in write.d]
    return [
        "first = found_starts[i]",
        f"base, step = {d * d} * first, {d} * (found_starts[i + 1] - first)",
        "for t in range(first, found_starts[i + 1]):",
        f"    where[thread, found[t]] = {d} * (t - first)",
        "for t in range(back[i], back[i + 1]):",
        *indented(["p, e = rows[t], entries[t]", *write.weighted(), "for f in range(starts[p], starts[p + 1]):",
                   *indented(["place = base + where[thread, columns[f]]", *adding])]),
    ]  # fmt: skip


def _spread(write: _Write, d: int) -> list[str]:
    terms = {a: [(write.terms("t", s, a, "turned"), f"room[p, {s}]") for s in write.q] for a in write.d}
    added = [f"o{a} += {write.total(pairs)}" for a, pairs in terms.items()]
    return [*(f"o{a} = 0.0" for a in write.d), "for t in range(back[i], back[i + 1]):",
            *indented(["p = rows[t]", *added]),
            *(f"out[{d} * i + {a}] += o{a}" for a in write.d)]  # fmt: skip


def _diagonal(write: _Write, d: int) -> list[str]:
    return [*(f"o{a} = 0.0" for a in write.d), "for t in range(back[i], back[i + 1]):",
            *indented(["p, e = rows[t], entries[t]", *write.weighted(),
                       *(f"o{a} += {write.block(a, a, 'e')}" for a in write.d)]),
            *(f"out[{d} * i + {a}] += o{a}" for a in write.d)]  # fmt: skip
