"""Loops for the broken share of families, over rows and over a lattice."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.part import Connection, Lattice, Part
from rbs_core.part.storage import Storage
from rbs_plugins.fields import volume as volume_field
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


def family_volumes(stored: Storage, volume: NDArray[Any]) -> NDArray[np.float64]:
    """(n,) volumes of all neighbors that each node ever had, m^3."""
    if isinstance(stored, Lattice):
        by_cell = Cells(stored).padded(volume, np.float64)
        return np.asarray(
            sum(by_cell[stored.cells + shift] * there for shift, there in stored.directed(stored.present))
        )
    offsets, neighbors = stored.as_rows()
    starts = np.repeat(np.arange(len(volume)), np.diff(offsets))
    return np.asarray(np.bincount(starts, volume[neighbors], len(volume)), np.float64)


class JointShare:
    """What the bonds of a connection are to the nodes of one of its parts.

    Args:
        connection: whose bonds.
        part: one of its ends.
        intact: of its bonds.

    Attributes:
        nodes: of the part that have such bonds.
    """

    def __init__(self, connection: Connection, part: Part, intact: NDArray[Any]) -> None:
        offsets, neighbors = connection.bonds.as_rows()
        starts = np.repeat(np.arange(len(connection)), np.diff(offsets))
        side = connection.ends.index(part)
        begin = sum(len(nodes) for nodes in connection.nodes[:side])
        self.nodes = connection.nodes[side]
        own = (starts >= begin) & (starts < begin + len(self.nodes))
        volumes = np.concatenate([e[volume_field][n] for e, n in zip(connection.ends, connection.nodes, strict=True)])
        self._own, self._intact = np.flatnonzero(own), intact
        self._starts, self._volumes = starts[own] - begin, volumes[neighbors[own]].astype(np.float64)

    def left(self, *, everything: bool = False) -> NDArray[np.float64]:
        """Volumes of the neighbors across, of all or of those whose bonds hold, m^3."""
        held = self._volumes if everything else self._volumes * (self._intact[self._own] != 0)
        return np.asarray(np.bincount(self._starts, held, len(self.nodes)), np.float64)


class JointDamage:
    """Damage over the bonds of a part and of its connections.

    Args:
        volumes: of the families of the part alone.
        shares: of the connections.
    """

    def __init__(self, volumes: NDArray[np.float64], shares: Sequence[JointShare]) -> None:
        self._own, self._shares = volumes, shares
        self._total = volumes.copy()
        for share in shares:
            self._total[share.nodes] += share.left(everything=True)

    def add(self, damage: NDArray[Any]) -> None:
        """Turns the damage of the families of the part alone into that of all bonds."""
        left = (1.0 - damage) * self._own
        for share in self._shares:
            left[share.nodes] += share.left()
        damage[...] = 1.0 - np.divide(left, self._total, out=np.ones_like(left), where=self._total > 0)
