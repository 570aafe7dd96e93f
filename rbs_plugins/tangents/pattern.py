"""Who couples with whom: the sparsity of matrices with one block for a pair of nodes, in compressed rows."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from rbs_plugins.loops.loop import Loop, Text
from rbs_plugins.loops.rows import row_ranges

Whole = NDArray[np.int64]
Columns = NDArray[np.uint32]
WHOLE = np.array([[0, 1]])  # one range: for loops that only one thread can do


def threads() -> int:
    """How many threads may come: loops with scratch of their own need so many."""
    return int(getattr(numba.config, "NUMBA_NUM_THREADS", 1))


def each_row(function: Any, rows: int, work: int, /, **arguments: Any) -> NDArray[np.int64]:
    """Calls a function of the loops below for all rows."""
    return Loop(Text.of(function), function.__name__, arguments, row_ranges(rows), work)()


class Pattern:
    """Block entries (row, column), rows after each other, columns of a row in ascending order.

    Args:
        starts: (rows + 1,) first entry of each row.
        columns: (e,) column of each entry.
        width: number of columns.
    """

    def __init__(self, starts: Whole, columns: Columns, width: int) -> None:
        self.starts, self.columns, self.width = starts, columns, width

    @classmethod
    def of_families(cls, offsets: Whole, neighbors: Columns) -> Pattern:
        """Each node with itself and the ends of its bonds."""
        rows = len(offsets) - 1
        starts = offsets + np.arange(rows + 1)
        columns = np.empty(len(neighbors) + rows, np.uint32)
        each_row(with_itself, rows, len(columns), offsets=offsets, neighbors=neighbors, starts=starts, columns=columns)
        return cls(starts, columns, rows)

    def __len__(self) -> int:
        return len(self.columns)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.starts) - 1

    @cached_property
    def transposed(self) -> tuple[Whole, Columns, Columns]:
        """The entries of each column, from the first row to the last: where a column begins, rows, entries."""
        starts = np.zeros(self.width + 1, np.int64)
        rows, entries = np.empty(len(self), np.uint32), np.empty(len(self), np.uint32)
        arguments = {"starts": self.starts, "columns": self.columns, "back": starts, "rows": rows, "entries": entries}
        Loop(Text.of(transpose), "transpose", {**arguments, "next": starts[1:].copy()}, WHOLE, 0)()
        return starts, rows, entries

    @cached_property
    def normal(self) -> Pattern:
        """The pattern of CᵀC, if this is that of C: columns that meet in some row."""
        back, rows, _ = self.transposed
        work = int((np.diff(back)).sum())
        given = {"starts": self.starts, "columns": self.columns, "back": back, "rows": rows}
        counts = np.zeros(self.width + 1, np.int64)
        seen = np.zeros((threads(), self.width), np.int64)
        each_row(count_met, self.width, work, **given, seen=seen, counts=counts)
        starts = np.cumsum(counts)
        found = np.empty(starts[-1], np.uint32)
        seen.fill(0)
        each_row(list_met, self.width, work, **given, seen=seen, found_starts=starts, found=found)
        return Pattern(starts, found, self.width)

    def find(self, rows: NDArray[Any], columns: NDArray[Any]) -> Whole:
        """(k,) entries of rows and columns; they must be there."""
        keys = np.repeat(np.arange(self.rows), np.diff(self.starts)) * self.width + self.columns
        return np.asarray(np.searchsorted(keys, rows * self.width + columns))

    @property
    def nbytes(self) -> int:
        """Bytes of the tables that have been made."""
        made = [self.starts, self.columns, *self.__dict__.get("transposed", ())]
        return sum(array.nbytes for array in made)


def with_itself(begin, end, thread, offsets, neighbors, starts, columns):
    """Families with the node itself among them, at its place."""
    for i in range(begin, end):
        place, there = starts[i], False
        for q in range(offsets[i], offsets[i + 1]):
            if not there and neighbors[q] > i:
                columns[place] = i
                place, there = place + 1, True
            columns[place] = neighbors[q]
            place += 1
        if not there:
            columns[place] = i
    return 0


def transpose(begin, end, thread, starts, columns, back, rows, entries, next):
    """The entries sorted by column; `next` is room, one number per column."""
    for e in range(columns.size):
        back[columns[e] + 1] += 1
    for c in range(next.size):
        back[c + 1] += back[c]
        next[c] = back[c]
    for p in range(starts.size - 1):
        for e in range(starts[p], starts[p + 1]):
            c = columns[e]
            rows[next[c]], entries[next[c]] = p, e
            next[c] += 1
    return 0


def count_met(begin, end, thread, starts, columns, back, rows, seen, counts):
    """counts[i + 1] = how many columns share a row with column i; seen[thread] is zero at first."""
    for i in range(begin, end):
        total = 0
        for t in range(back[i], back[i + 1]):
            for e in range(starts[rows[t]], starts[rows[t] + 1]):
                if seen[thread, columns[e]] != i + 1:
                    seen[thread, columns[e]] = i + 1
                    total += 1
        counts[i + 1] = total
    return 0


def list_met(begin, end, thread, starts, columns, back, rows, seen, found_starts, found):
    """The same columns, sorted."""
    for i in range(begin, end):
        first = found_starts[i]
        place = first
        for t in range(back[i], back[i + 1]):
            for e in range(starts[rows[t]], starts[rows[t] + 1]):
                if seen[thread, columns[e]] != i + 1:
                    seen[thread, columns[e]] = i + 1
                    found[place] = columns[e]
                    place += 1
        gap = 1
        while gap < (place - first) // 3:
            gap = 3 * gap + 1
        while gap > 0:  # Shell's sort: rows are short, and made of a few sorted pieces
            for k in range(first + gap, place):
                value, hole = found[k], k
                while hole >= first + gap and found[hole - gap] > value:
                    found[hole] = found[hole - gap]
                    hole -= gap
                found[hole] = value
            gap //= 3
    return 0
