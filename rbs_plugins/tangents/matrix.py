"""The matrix of a tangent: d × d blocks on a pattern, in compressed rows of numbers as direct solvers want them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from rbs_plugins.tangents.pattern import Pattern, Whole, each_row

SMALL_INDEX = 2**31 - 1


class BlockMatrix:
    """Blocks of a square pattern.

    Args:
        pattern: square, which nodes couple.
        dimension: d.
        nodes: (rows,) ascending numbers of the nodes of the pattern among all nodes; all of them if not given.
        count: number of all nodes.

    Attributes:
        data: the numbers; entry e of block row i holds row a of its block at
            d² starts[i] + a d (starts[i + 1] − starts[i]) + d (e − starts[i]).
    """

    def __init__(self, pattern: Pattern, dimension: int, nodes: Whole | None = None, count: int | None = None) -> None:
        self.pattern, self.dimension = pattern, dimension
        rows, d = pattern.rows, dimension
        nodes = np.arange(rows) if nodes is None else nodes
        self._count = rows if count is None else count
        self.data = np.zeros(len(pattern) * d * d)
        index: type = np.int32 if len(self.data) <= SMALL_INDEX else np.int64
        indices: NDArray[Any] = np.empty(len(self.data), index)
        each_row(number_columns, rows, len(self.data), starts=pattern.starts, columns=pattern.columns, nodes=nodes,
                 indices=indices, d=d)  # fmt: skip
        widths = np.zeros(self._count, np.int64)
        widths[nodes] = np.diff(pattern.starts)
        pointers: NDArray[Any] = np.concatenate([[0], np.cumsum(np.repeat(widths * d, d))]).astype(index)
        size = self._count * d
        self._matrix = csr_array((self.data, indices, pointers), shape=(size, size))
        self._matrix.has_canonical_format = True
        self.data = self._matrix.data

    @property
    def matrix(self) -> csr_array[Any]:
        """The matrix over all nodes, with the present numbers."""
        return self._matrix

    def clear(self) -> None:
        """Sets all numbers to zero."""
        self.data.fill(0.0)

    def turn(self, owners: NDArray[np.uint8], turns: NDArray[np.float64]) -> None:
        """Blocks in other coordinates: that of nodes i and j becomes RᵢᵀB Rⱼ.

        Args:
            owners: (rows,) which of the turns belongs to a node.
            turns: (k, d, d) from local components to those of the blocks.
        """
        each_row(turn_blocks, self.pattern.rows, len(self.data), starts=self.pattern.starts,
                 columns=self.pattern.columns, owners=owners, turns=turns, data=self.data)  # fmt: skip

    @property
    def nbytes(self) -> int:
        """Bytes of the matrix."""
        return self.data.nbytes + self._matrix.indices.nbytes + self._matrix.indptr.nbytes


def number_columns(begin, end, thread, starts, columns, nodes, indices, d):
    """Column numbers of the single entries."""
    for i in range(begin, end):
        first, wide = starts[i], starts[i + 1] - starts[i]
        for a in range(d):
            place = d * d * first + a * d * wide
            for e in range(wide):
                for b in range(d):
                    indices[place + e * d + b] = nodes[columns[first + e]] * d + b
    return 0


def turn_blocks(begin, end, thread, starts, columns, owners, turns, data):
    """Each block becomes R_i^T B R_j."""
    d = turns.shape[1]
    for i in range(begin, end):
        first, wide, own = starts[i], starts[i + 1] - starts[i], owners[i]
        base = d * d * first
        for e in range(wide):
            other = owners[columns[first + e]]
            for a in range(d):  # rows first: B R_j
                place = base + a * d * wide + e * d
                x = data[place]
                y = data[place + 1] if d > 1 else 0.0
                z = data[place + 2] if d > 2 else 0.0
                for b in range(d):
                    total = x * turns[other, 0, b]
                    if d > 1:
                        total += y * turns[other, 1, b]
                    if d > 2:
                        total += z * turns[other, 2, b]
                    data[place + b] = total
            for b in range(d):
                place = base + e * d + b
                x = data[place]
                y = data[place + d * wide] if d > 1 else 0.0
                z = data[place + 2 * d * wide] if d > 2 else 0.0
                for a in range(d):
                    total = x * turns[own, 0, a]
                    if d > 1:
                        total += y * turns[own, 1, a]
                    if d > 2:
                        total += z * turns[own, 2, a]
                    data[place + a * d * wide] = total
    return 0
