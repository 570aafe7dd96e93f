"""Loops for the broken share of families, over rows and over a lattice."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.part import Lattice
from rbs_core.part.storage import Storage
from rbs_plugins.loops import cells
from rbs_plugins.loops.loop import Loop, Text
from rbs_plugins.loops.ranges import Cells, scratch
from rbs_plugins.loops.rows import row_ranges


def broken_share_of_rows(begin, end, thread, offsets, neighbors, intact, volume, out):
    """Damage: out = 1 - sum of the intact neighbor volumes over the sum of all."""
    for i in range(begin, end):
        total, left = 0.0, 0.0
        for q in range(offsets[i], offsets[i + 1]):
            size = volume[neighbors[q]]
            total += size
            left += size if intact[q] != 0 else 0.0
        out[i] = 1.0 - left / total if total > 0 else 0.0
    return 0


def damage_loops(
    stored: Storage, intact: NDArray[Any], volume: NDArray[Any], out: NDArray[Any]
) -> tuple[list[Loop], int]:
    """The loops that write damage (n,), one after the other, and the bytes that they keep.

    Bonds are as they are stored, and intact as the store has it. A lattice wants volumes by cell: they are copied in
    front, as a relation may have changed them.
    """
    if isinstance(stored, Lattice):
        held = Cells(stored)
        by_cell = held.padded(volume, np.float64)
        arguments = {**held.tables, "present": stored.present, "bits": intact, "volume": by_cell, "out": out,
                     "scratch": scratch("float64")}  # fmt: skip
        share = Loop(Text.of(cells.broken_share), "broken_share", arguments, held.ranges, len(stored))
        return [held.carry(volume, by_cell), share], by_cell.nbytes
    offsets, neighbors = stored.as_rows()
    arguments = {"offsets": offsets, "neighbors": neighbors, "intact": intact, "volume": volume, "out": out}
    return [
        Loop(Text.of(broken_share_of_rows), "broken_share_of_rows", arguments, row_ranges(len(out)), len(stored))
    ], 0
