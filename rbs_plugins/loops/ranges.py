"""How the cells of a lattice are cut into pieces of work."""

from __future__ import annotations

from functools import cache
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from rbs_core.part import Lattice
from rbs_core.part.lattice import AT_ONCE
from rbs_plugins.loops import cells
from rbs_plugins.loops.lattice_text import CHUNK
from rbs_plugins.loops.loop import Loop, Text

ALIGNMENT = 64  # bytes, of the widest vectors


@cache
def scratch(kind: str, sums: int = 3) -> NDArray[Any]:
    """Room for the sums of one range per thread, shared by all loops: a loop fills it anew in every range.

    The rows begin where vectors of the machine do. One more than the sums keeps threads apart: what one is about to
    load ahead of itself must not be what another one stores.
    """
    shape = (getattr(numba.config, "NUMBA_NUM_THREADS", 1), max(sums, 3) + 1, CHUNK)
    room = np.zeros(int(np.prod(shape)) * np.dtype(kind).itemsize + ALIGNMENT, np.uint8)
    begin = -room.ctypes.data % ALIGNMENT
    return room[begin : begin + len(room) - ALIGNMENT].view(kind).reshape(shape)


class Cells:
    """The ranges and stripes of a lattice, and the tables that its loops share.

    A range is CHUNK cells. A stripe is a few ranges, at least as many as the longest step can cross: bonds that begin
    in a stripe end in it or in the next one. So stripes of one color, every other one, can be done side by side: no two
    of them add to the same cell, and what is added to a cell, in which order, does not depend on the threads.

    Attributes:
        ranges: (c, 2) tasks, one for each range.
        stripes: (s, 2) tasks, first range and end of each stripe.
        color: (s,) 0 or 1 in turn.
        first: (c+1,) first node of each range.
        reach: how many ranges the longest step can cross.
        tables: what the loops take, by name; numbers as `margin`, too.
    """

    def __init__(self, stored: Lattice, real: Any = np.float64) -> None:
        self.stored = stored
        cells_of_grid = stored.size - 2 * stored.margin
        count = -(-cells_of_grid // CHUNK)
        self.ranges = np.stack([np.arange(count), np.arange(1, count + 1)], axis=1)
        edges = stored.margin + CHUNK * np.arange(count + 1)
        self.first = np.searchsorted(stored.cells, edges).astype(np.int64)
        self.reach = -(-stored.margin // CHUNK)
        self.stripes = _stripes(count, max(self.reach, min(count // 8, 8), 1))
        self.color = np.arange(len(self.stripes)) % 2
        shifts = np.arange(len(stored.steps)) % stored.width
        self.tables: dict[str, Any] = {
            "steps": stored.steps,
            "vectors": np.ascontiguousarray(stored.vectors * stored.spacing, real),
            "masks": (1 << shifts.astype(np.uint64)).astype(stored.present.dtype),
            "sizes": stored.lengths.astype(real),
            "inverses": (1.0 / stored.lengths).astype(real),
            "cells": stored.cells,
            "first": self.first,
            "margin": stored.margin,
            # a whole number of vectors: the few numbers that do not fill one would take as long as many vectors
            "last": stored.margin + -(-cells_of_grid // AT_ONCE) * AT_ONCE,
            "width": stored.width,
            "chunk": CHUNK,
            "start": 0,
        }

    def padded(self, values: NDArray[Any], real: Any) -> NDArray[Any]:
        """(size,) values of nodes at their cells, zero elsewhere."""
        result = np.zeros(self.stored.size, real)
        result[self.stored.cells] = values
        return result

    def carry(self, source: NDArray[Any], target: NDArray[Any]) -> Loop:
        """The loop that copies values of nodes (n,) to their cells (size,)."""
        arguments = {"source": source, "target": target, "cells": self.stored.cells}
        return Loop(Text.of(cells.carry), "carry", arguments, len(self.stored.cells))

    def behind(self, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Ranges from which a bond may lead to one of these, themselves included."""
        place = np.arange(len(chosen))
        return _any_between(chosen, place, np.minimum(place + self.reach + 1, len(chosen)))

    def ahead(self, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Ranges to which a bond may lead from one of these, themselves included."""
        place = np.arange(len(chosen))
        return _any_between(chosen, np.maximum(place - self.reach, 0), place + 1)

    def in_stripes(self, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(s,) stripes that hold one of these ranges."""
        return _any_between(chosen, self.stripes[:, 0], self.stripes[:, 1])


def _stripes(count: int, least: int) -> NDArray[np.int64]:
    """(s, 2) so many ranges in stripes of at least `least`; their number is one that threads can share out evenly."""
    number = max(count // least, 1)
    even = 2 ** max(number.bit_length() - 2, 0)  # number is two to four times as much
    edges = np.linspace(0, count, number - number % even + 1).astype(np.int64)
    return np.stack([edges[:-1], edges[1:]], axis=1)


def _any_between(chosen: NDArray[np.bool_], low: NDArray[np.int64], high: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether any entry from low to high (exclusive) is true, for many pairs at once."""
    before = np.concatenate([[0], np.cumsum(chosen)])
    return np.asarray(before[high] > before[low])
