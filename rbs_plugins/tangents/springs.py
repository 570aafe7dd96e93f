"""Springs: bonds by themselves, each with a stiffness along itself and one across.

A bond of node i with node j adds −B to the block of the two, and B to that of node i, with B = a d⊗d + t I, d the way
from i to j. For a pull P (N) and its slope k (N/m) by the length, t = P/|d| and a = (k − t)/|d|²: along the bond B is
k, across it t. Where a pull depends on more than the length of its bond, a d gives way to a vector of its own.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_plugins.loops import machine
from rbs_plugins.loops.loop import Loop, Text
from rbs_plugins.loops.recipe import indented
from rbs_plugins.loops.rows import row_ranges
from rbs_plugins.loops.rows_text import HINTS, SUMS
from rbs_plugins.tangents.matrix import BlockMatrix
from rbs_plugins.tangents.pattern import Columns, Whole

Array = NDArray[np.float64]


class Springs:
    """The bonds of some nodes as springs.

    Args:
        offsets: (n + 1,) first bond of each node.
        neighbors: (m,) node at the other end of each bond, in ascending order for each node.
        place: (n, d) where the nodes are; read anew at every use.
        straight: True if bonds resist along themselves only.
        apart: True if what a change of length does is no pull along the bond: B = l⊗d + t I.

    Attributes:
        along: (m,) a, N/m^3, to be filled in by the owner before use.
        across: (m,) t, N/m; of one number, and not used, if straight.
        left: (m, d) l, N/m^2, to be filled in, too; there, and in place of `along`, if apart.
    """

    def __init__(
        self, offsets: Whole, neighbors: Columns, place: Array, *, straight: bool = False, apart: bool = False
    ) -> None:
        self.along = np.zeros(1 if apart else len(neighbors))
        self.left = np.zeros((len(neighbors) if apart else 1, place.shape[1]))
        self.across = np.zeros(1 if straight else len(neighbors))
        self._given: dict[str, Any] = {"offsets": offsets, "neighbors": neighbors, "place": place, "along": self.along,
                       "across": self.across, "left": self.left}  # fmt: skip
        self._rows, self._dimension, self._kind = len(offsets) - 1, place.shape[1], (straight, apart)
        self._count, self._loops = len(neighbors), dict[str, Loop]()

    def _run(self, name: str, **arguments: Any) -> None:
        if name not in self._loops:
            text = _text(name, self._dimension, *self._kind, machine.processor())
            given = {**self._given, **arguments}
            self._loops[name] = Loop(text, name, given, row_ranges(self._rows), self._count)
        loop = self._loops[name]
        loop.set(**arguments)
        loop()

    def add_to(self, matrix: BlockMatrix, *, afresh: bool = False) -> None:
        """Adds the blocks to a matrix whose first rows are these nodes, with themselves and their neighbors in them.

        Args:
            matrix: is changed.
            afresh: whether what these rows hold is forgotten before.
        """
        found = matrix.pattern
        self._run("fill", found_starts=found.starts, found=found.columns, data=matrix.data, afresh=int(afresh))

    def multiply(self, v: Array, out: Array) -> None:
        """Adds the product with v to `out`; numbers behind those of the nodes are left alone."""
        self._run("product", v=v, out=out)

    def diagonal(self, out: Array) -> None:
        """Adds the diagonal to `out`."""
        self._run("diagonal", out=out)

    @property
    def nbytes(self) -> int:
        """Bytes of the stiffnesses."""
        return self.along.nbytes + self.across.nbytes + self.left.nbytes


@cache
def _text(name: str, d: int, straight: bool, apart: bool, processor: str) -> Text:
    """The module of one of the loops of springs."""
    own = {"fill": "found_starts, found, data, afresh", "product": "v, out", "diagonal": "out"}[name]
    inner = {"fill": _fill, "product": _product, "diagonal": _diagonal}[name](d, straight, apart)
    row = ["first, last = offsets[i], offsets[i + 1]",
           *(f"row_{each} = {each}[first:last]" for each in ("neighbors", "left" if apart else "along")),
           *([] if straight else ["row_across = across[first:last]"]),
           *(f"x{k} = place[i, {k}]" for k in range(d))]  # fmt: skip
    hints = HINTS.get(processor, ()) if name == "product" else ()
    lines = [*hints, "for i in range(begin, end):", *indented([*row, *inner]), "return 0"]
    return Text("\n".join([
        f"from rbs_plugins.loops.machine import {', '.join(hint.rstrip('()') for hint in hints)}" if hints else "",
        SUMS, f"def {name}(begin, end, thread, offsets, neighbors, place, along, across, left, {own}):",
        *indented(lines), "",
    ]))  # fmt: skip


def _bond(d: int) -> list[str]:
    return ["j = row_neighbors[q]", *(f"d{k} = place[j, {k}] - x{k}" for k in range(d))]


def _block(a: int, b: int, straight: bool, apart: bool) -> str:
    """Source of B[a, b]."""
    return f"{_left(a, apart)} * d{b}" + (" + row_across[q]" if a == b and not straight else "")


def _left(a: int, apart: bool) -> str:
    """Source of what d is multiplied by from the left."""
    return f"row_left[q, {a}]" if apart else f"row_along[q] * d{a}"


def _product(d: int, straight: bool, apart: bool) -> list[str]:
    axes = range(d)
    dot = " + ".join(f"d{k} * w{k}" for k in axes)
    across = "" if straight else " + row_across[q] * w{k}"
    bond = [*_bond(d), *(f"w{k} = v{k} - v[{d} * j + {k}]" for k in axes), f"s = {dot}",
            *(f"f{k} += {_left(k, apart)} * s" + across.format(k=k) for k in axes)]  # fmt: skip
    return [*(f"v{k}, f{k} = v[{d} * i + {k}], 0.0" for k in axes), "for q in range(row_neighbors.size):",
            *indented(bond), *(f"out[{d} * i + {k}] += f{k}" for k in axes)]  # fmt: skip


def _diagonal(d: int, straight: bool, apart: bool) -> list[str]:
    axes = range(d)
    sums = [f"f{k} += {_block(k, k, straight, apart)}" for k in axes]
    return [*(f"f{k} = 0.0" for k in axes), "for q in range(row_neighbors.size):", *indented([*_bond(d), *sums]),
            *(f"out[{d} * i + {k}] += f{k}" for k in axes)]  # fmt: skip


def _fill(d: int, straight: bool, apart: bool) -> list[str]:
    """Neighbors and columns are both sorted: one walk along the row finds all places."""
    axes = range(d)
    pairs = [(a, b) for a in axes for b in axes]
    upper = [(a, b) for a, b in pairs if a <= b or apart]
    bond = [*_bond(d), *(f"b{a}{b} = {_block(a, b, straight, apart)}" for a, b in upper),
            *(f"t{a}{b} += b{a}{b}" for a, b in upper),
            "while found[entry] != j:", "    entry += 1", f"place_of = base + {d} * (entry - begins)",
            *(f"data[place_of + {a} * step + {b}] -= b{_entry(a, b, apart)}" for a, b in pairs)]  # fmt: skip
    return [
        "begins = found_starts[i]", f"base, step = {d * d} * begins, {d} * (found_starts[i + 1] - begins)",
        "if afresh != 0:", f"    data[base : base + {d} * step] = 0.0",
        *(f"t{a}{b} = 0.0" for a, b in upper), "entry = begins", "for q in range(row_neighbors.size):", *indented(bond),
        "entry = begins", "while found[entry] != i:", "    entry += 1", f"place_of = base + {d} * (entry - begins)",
        *(f"data[place_of + {a} * step + {b}] += t{_entry(a, b, apart)}" for a, b in pairs),
    ]  # fmt: skip


def _entry(a: int, b: int, apart: bool) -> str:
    """Name of an entry: of the upper half if B is symmetric."""
    return f"{a}{b}" if apart else f"{min(a, b)}{max(a, b)}"
