"""Bonds as compressed rows: for any cloud of points.

Every bond is stored from both ends (directed), so each node owns its row: loops need no atomics and the order of every
sum is fixed.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.fields import Field, FieldStore, intact
from rbs_core.part.storage import Crosses, Of, Storage

_CHUNK = 1 << 20


class Rows(Storage):
    """The list representation.

    Args:
        owner: whose they are, for messages: "part 'plate'".
        positions: (n, d) reference positions, m.
        rows: offsets, neighbors, inverse lengths, as the search returns them.
        real: type of bond fields of real numbers.

    Attributes:
        inverse: (m,) 1 / reference length, 1/m. Loops multiply by it: a division costs four times as much.
    """

    name = "list"

    def __init__(
        self,
        owner: str,
        positions: NDArray[np.float64],
        rows: tuple[NDArray[np.int64], NDArray[np.uint32], NDArray[np.float64]],
        real: str = "float64",
    ) -> None:
        self._positions = positions
        self._offsets, self._neighbors, self.inverse = rows
        self.fields = FieldStore(owner, "bond", len(self._neighbors), positions.shape[1], real)

    def __len__(self) -> int:
        return len(self._neighbors)

    def as_rows(self) -> tuple[NDArray[np.int64], NDArray[np.uint32]]:
        return self._offsets, self._neighbors

    def offsets(self) -> NDArray[np.int64]:
        return self._offsets

    def neighbors(self, node: int) -> NDArray[Any]:
        return self._neighbors[self._offsets[node] : self._offsets[node + 1]]

    def inverse_lengths(self) -> NDArray[np.float64]:
        return self.inverse

    def mark(self, field: Field, inside: NDArray[np.bool_]) -> None:
        self.fields.set(field, np.repeat(inside, np.diff(self._offsets)) & inside[self._neighbors])

    def tabulate(self, field: Field, function: Of) -> None:
        values = np.empty(len(self))
        for run, _, _, vectors in self.runs():
            values[run] = function(vectors)
        self.fields.set(field, values)

    def runs(self) -> Iterator[tuple[slice, NDArray[np.int64], NDArray[np.uint32], NDArray[np.float64]]]:
        """The bonds in pieces that fit into memory: which they are, their nodes, neighbors, and ξ (k, d), m."""
        for begin in range(0, len(self), _CHUNK):
            run = slice(begin, min(begin + _CHUNK, len(self)))
            nodes = np.searchsorted(self._offsets, np.arange(run.start, run.stop), side="right") - 1
            others = self._neighbors[run]
            yield run, nodes, others, self._positions[others] - self._positions[nodes]

    def cut(self, crosses: Crosses, near: NDArray[np.bool_]) -> tuple[int, int]:
        broken = crossing = 0
        holds = self.fields.allocate(intact).view(np.bool_)
        for begin, crossed in self._crossings(crosses, near):
            part = holds[begin : begin + len(crossed)]
            broken += int(np.count_nonzero(part & crossed))
            part &= ~crossed
            crossing += int(np.count_nonzero(crossed))
        return broken, crossing

    def remove(self, crosses: Crosses, near: NDArray[np.bool_]) -> int:
        keep = np.ones(len(self), np.bool_)
        for begin, crossed in self._crossings(crosses, near):
            keep[begin : begin + len(crossed)] = ~crossed
        gone = len(self) - int(np.count_nonzero(keep))
        if gone:
            before = np.concatenate([[0], np.cumsum(keep, dtype=np.int64)])
            self._offsets = before[self._offsets]
            self._neighbors, self.inverse = self._neighbors[keep], self.inverse[keep]
            self.fields.keep(keep)
        return gone

    def _crossings(self, crosses: Crosses, near: NDArray[np.bool_]) -> Iterator[tuple[int, NDArray[np.bool_]]]:
        """(first bond, crossed or not) for runs of bonds that might cross."""
        candidates = np.flatnonzero(near)
        if not len(candidates):
            return
        first, last = self._offsets[candidates[0]], self._offsets[candidates[-1] + 1]
        for begin in range(int(first), int(last), _CHUNK):
            end = min(begin + _CHUNK, int(last))
            nodes = np.searchsorted(self._offsets, np.arange(begin, end), side="right") - 1
            some = np.flatnonzero(near[nodes])
            starts = self._positions[nodes[some]]
            stops = self._positions[self._neighbors[begin:end][some]]
            crossed = np.zeros(end - begin, np.bool_)
            crossed[some] = np.asarray(crosses(starts, stops), np.bool_)
            yield begin, crossed

    @property
    def has_broken(self) -> bool:
        return intact in self.fields and not self.fields.get(intact).all()

    def holds(self, nodes: NDArray[np.int64], others: NDArray[np.int64]) -> NDArray[np.bool_]:
        low, high = self._offsets[nodes], self._offsets[nodes + 1]
        ends = high.copy()
        while (low < high).any():  # bisection, in all rows at once
            middle = (low + high) // 2
            before = low < high
            before[before] = self._neighbors[middle[before]] < others[before]
            low, high = np.where(before, middle + 1, low), np.where(before | (low >= high), high, middle)
        found = low < ends
        found[found] = self._neighbors[low[found]] == others[found]
        if intact in self.fields:
            found[found] = self.fields.get(intact)[low[found]] != 0
        return found

    def arrays(self) -> tuple[NDArray[Any], ...]:
        return self._offsets, self._neighbors

    @property
    def nbytes(self) -> int:
        return self._offsets.nbytes + self._neighbors.nbytes + self.inverse.nbytes + self.fields.nbytes
