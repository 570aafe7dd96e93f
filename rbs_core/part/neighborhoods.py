"""Bonds of a part: one interface, and the list representation (compressed rows) behind it.

Every bond is stored from both ends (directed), so each node owns its row: loops need no atomics and the order of every
sum is fixed. A second representation for regular grids can stand behind the same interface `Bonds`; what walks along
rows (the loops, damage, the fingerprint of a checkpoint) asks for them by `as_rows`.
"""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.errors import BadInput
from rbs_core.fields import FieldStore, intact
from rbs_core.geometry import Geometry, Surface

Crossing = Surface | Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.bool_]]
NO_CROSSING = "no bond crosses it; check where it lies, in the local coordinates of the part (m)"
_CHUNK = 1 << 20


class Bonds(ABC):
    """The directed bonds of a part, whatever holds them.

    Attributes:
        horizon: radius of a family, m.
        storage: name of the representation.
    """

    storage = "abstract"
    horizon: float

    @abstractmethod
    def __len__(self) -> int:
        """Number of directed bonds."""

    @abstractmethod
    def __iter__(self) -> Iterator[tuple[int, int]]:
        """Pairs (node, neighbor): for looking at small parts, not for work."""

    @abstractmethod
    def family(self, node: int) -> slice:
        """Place of the bonds of a node in the bond fields."""

    @abstractmethod
    def neighbors(self, node: int) -> NDArray[Any]:
        """Neighbors of a node, ascending."""

    @abstractmethod
    def as_rows(self) -> tuple[NDArray[np.int64], NDArray[np.uint32]]:
        """Offsets (n+1,) and neighbors (m,) as compressed rows."""

    @property
    @abstractmethod
    def fields(self) -> FieldStore:
        """The arrays of bond fields."""

    @abstractmethod
    def between(self, geometry: Geometry) -> NDArray[np.bool_]:
        """(m,) True for bonds whose two ends lie in a geometry."""

    @abstractmethod
    def cut(self, surface: Crossing) -> int:
        """Breaks the bonds that cross a surface; they count as damage. Returns how many directed bonds broke.

        Warns:
            UserWarning: if none broke.
        """

    @abstractmethod
    def remove(self, surface: Crossing) -> int:
        """Takes away bonds that cross a surface, as if they had never been. Returns how many directed bonds went.

        Warns:
            UserWarning: if none went.
        """

    @property
    @abstractmethod
    def intact(self) -> NDArray[np.bool_]:
        """(m,) True while a bond holds; writing changes the bonds."""

    @property
    @abstractmethod
    def has_broken(self) -> bool:
        """True if any bond is broken."""

    @property
    @abstractmethod
    def inverse_lengths(self) -> NDArray[np.float64]:
        """(m,) 1 / reference length of each bond, 1/m. Loops multiply by it: a division costs four times as much."""

    @property
    @abstractmethod
    def lengths(self) -> NDArray[np.float64]:
        """(m,) reference length of each bond, m; computed when asked for."""

    @abstractmethod
    def counts(self) -> NDArray[np.int64]:
        """(n,) number of neighbors of each node."""

    @property
    @abstractmethod
    def nbytes(self) -> int:
        """Bytes held, bond fields included."""


class BondList(Bonds):
    """Bonds as compressed rows: for any cloud of points.

    Args:
        owner: name of the part, for messages.
        positions: (n, d) reference positions, m.
        rows: offsets, neighbors, inverse lengths, as the search returns them.
        horizon: m.
    """

    storage = "list"

    def __init__(
        self,
        owner: str,
        positions: NDArray[np.float64],
        rows: tuple[NDArray[np.int64], NDArray[np.uint32], NDArray[np.float64]],
        horizon: float,
    ) -> None:
        self.horizon = horizon
        self._positions = positions
        self._offsets, self._neighbors, self._inverse = rows
        self._fields = FieldStore(f"part '{owner}'", "bond", len(self._neighbors), positions.shape[1])

    def __len__(self) -> int:
        return len(self._neighbors)

    def __iter__(self) -> Iterator[tuple[int, int]]:
        for node in range(len(self._offsets) - 1):
            for neighbor in self.neighbors(node):
                yield node, int(neighbor)

    def __repr__(self) -> str:
        nodes = len(self._offsets) - 1
        return f"<{len(self)} directed bonds of {nodes} nodes, horizon {self.horizon:g} m, stored as list>"

    @property
    def fields(self) -> FieldStore:
        return self._fields

    def family(self, node: int) -> slice:
        return slice(int(self._offsets[node]), int(self._offsets[node + 1]))

    def neighbors(self, node: int) -> NDArray[Any]:
        return self._neighbors[self.family(node)]

    def as_rows(self) -> tuple[NDArray[np.int64], NDArray[np.uint32]]:
        return self._offsets, self._neighbors

    def counts(self) -> NDArray[np.int64]:
        return np.diff(self._offsets)

    @property
    def inverse_lengths(self) -> NDArray[np.float64]:
        return self._inverse

    @property
    def lengths(self) -> NDArray[np.float64]:
        return 1.0 / self._inverse

    @property
    def intact(self) -> NDArray[np.bool_]:
        return self.fields.allocate(intact).view(np.bool_)

    @property
    def has_broken(self) -> bool:
        return intact in self.fields and not self.intact.all()

    def cut(self, surface: Crossing) -> int:
        broken = crossing = 0
        for begin, crossed in self._crossings(surface):
            part = self.intact[begin : begin + len(crossed)]
            broken += int(np.count_nonzero(part & crossed))
            part &= ~crossed
            crossing += int(np.count_nonzero(crossed))
        if not broken:
            why = f"the {crossing} directed bonds that cross it were broken before" if crossing else NO_CROSSING
            self._warn(f"cut({surface!r}) broke nothing: {why}")
        return broken

    def remove(self, surface: Crossing) -> int:
        keep = np.ones(len(self), np.bool_)
        for begin, crossed in self._crossings(surface):
            keep[begin : begin + len(crossed)] = ~crossed
        gone = len(self) - int(np.count_nonzero(keep))
        if gone:
            before = np.concatenate([[0], np.cumsum(keep, dtype=np.int64)])
            self._offsets = before[self._offsets]
            self._neighbors, self._inverse = self._neighbors[keep], self._inverse[keep]
            self.fields.keep(keep)
        else:
            self._warn(f"remove({surface!r}) took nothing away: {NO_CROSSING}")
        return gone

    def _warn(self, text: str) -> None:
        warnings.warn(f"{self.fields.owner}: bonds.{text}", stacklevel=3)

    def ends(self, begin: int, end: int) -> tuple[NDArray[np.int64], NDArray[np.uint32]]:
        """Node and neighbor of the bonds begin..end, as two arrays."""
        nodes = np.searchsorted(self._offsets, np.arange(begin, end), side="right") - 1
        return nodes, self._neighbors[begin:end]

    def between(self, geometry: Geometry) -> NDArray[np.bool_]:
        """(m,) True for bonds whose two ends lie in a geometry."""
        inside = geometry.contains(self._positions)
        return np.repeat(inside, self.counts()) & inside[self._neighbors]

    def _crossings(self, surface: Crossing) -> Iterator[tuple[int, NDArray[np.bool_]]]:
        """(first bond, crossed or not) for runs of bonds that might cross; rows far from the surface are skipped."""
        first, last = 0, len(self._offsets) - 1
        crosses = surface.crosses if isinstance(surface, Surface) else surface
        if not callable(crosses):
            raise BadInput(f"cannot cut with {surface!r}: give a Segment, a Polygon, or a function of starts and ends")
        near = np.ones(last, np.bool_)
        if isinstance(surface, Surface):
            low, high = (np.asarray(b) for b in surface.bounds)
            largest = max(float(np.abs(numbers).max()) for numbers in (low, high, self._positions))
            # surfaces reach beyond their bounds by their tolerance, and somewhat more is searched
            reach = self.horizon * (1 + 1e-5) + 1e-8 * float((high - low).max()) + 1e-14 * largest
            above, below = self._positions >= low - reach, self._positions <= high + reach
            near = np.asarray((above & below).all(axis=1))
        candidates = np.flatnonzero(near)
        if not len(candidates):
            return
        first, last = int(candidates[0]), int(candidates[-1]) + 1
        for begin in range(int(self._offsets[first]), int(self._offsets[last]), _CHUNK):
            end = min(begin + _CHUNK, int(self._offsets[last]))
            nodes, neighbors = self.ends(begin, end)
            crossed = np.zeros(end - begin, np.bool_)
            some = np.flatnonzero(near[nodes])
            starts, stops = self._positions[nodes[some]], self._positions[neighbors[some]]
            crossed[some] = np.asarray(crosses(starts, stops), np.bool_)
            yield begin, crossed

    @property
    def nbytes(self) -> int:
        return self._offsets.nbytes + self._neighbors.nbytes + self._inverse.nbytes + self.fields.nbytes
