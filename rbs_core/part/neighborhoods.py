"""Bonds: the neighborhoods of a part as everybody sees them, however they are held.

Two representations stand behind it: compressed rows (`Rows`) for any cloud of points, and a table of steps with one bit
per bond (`Lattice`) for regular grids. Only loops over bonds look behind it, at `stored`.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput
from rbs_core.fields import Field, FieldStore, intact
from rbs_core.geometry import Geometry, Surface
from rbs_core.memory import require_memory
from rbs_core.part.estimate import CONVERTED
from rbs_core.part.lattice import Lattice, LatticeFields
from rbs_core.part.rows import Rows
from rbs_core.part.storage import Crosses, Of, Storage

Crossing = Surface | Crosses
NO_CROSSING = "no bond crosses it; check where it lies (m), in local coordinates of a part or in the world"


class Bonds:
    """The directed bonds of a part.

    Args:
        owner: whose they are, for messages: "part 'plate'".
        positions: (n, d) reference positions, m.
        horizon: radius of a family, m.
        stored: the representation.
        chosen: whether the user has chosen it; otherwise a lattice becomes a list where a scene needs one.
        reach: radius within which nodes are bonded, m; the horizon if not given.

    Attributes:
        positions, horizon, stored, chosen, reach: as given.
    """

    def __init__(
        self,
        owner: str,
        positions: NDArray[np.float64],
        horizon: float,
        stored: Storage,
        chosen: bool = False,
        reach: float | None = None,
    ) -> None:
        self.horizon, self.stored, self.chosen = horizon, stored, chosen
        self.reach = horizon if reach is None else reach
        self._owner, self.positions = owner, positions
        self._first: NDArray[np.int64] | None = None

    def __len__(self) -> int:
        return len(self.stored)

    def __iter__(self) -> Iterator[tuple[int, int]]:
        """Pairs (node, neighbor): for looking at small parts, not for work."""
        for node in range(len(self.positions)):
            for neighbor in self.neighbors(node):
                yield node, int(neighbor)

    def __repr__(self) -> str:
        nodes = len(self.positions)
        radius = f"horizon {self.horizon:g} m" + (f", reach {self.reach:g} m" if self.reach > self.horizon else "")
        return f"<{len(self)} directed bonds of {nodes} nodes, {radius}, stored as {self.storage}>"

    @property
    def storage(self) -> str:
        """Name of the representation, "list" or "lattice"."""
        return self.stored.name

    @property
    def fields(self) -> FieldStore:
        """The arrays of bond fields."""
        return self.stored.fields

    def _offsets(self) -> NDArray[np.int64]:
        if self._first is None:
            self._first = self.stored.offsets()
        return self._first

    def family(self, node: int) -> slice:
        """Place of the bonds of a node in the bond fields."""
        return slice(int(self._offsets()[node]), int(self._offsets()[node + 1]))

    def counts(self) -> NDArray[np.int64]:
        """(n,) number of neighbors of each node."""
        # to be looked at once, when the part is connected: not worth the memory to keep the offsets of a lattice
        return np.diff(self.stored.offsets() if self._first is None else self._first)

    def neighbors(self, node: int) -> NDArray[Any]:
        """Neighbors of a node, ascending."""
        return self.stored.neighbors(node)

    def as_rows(self) -> tuple[NDArray[np.int64], NDArray[np.uint32]]:
        """Offsets (n+1,) and neighbors (m,) as compressed rows; a lattice makes them for the occasion."""
        return self.stored.as_rows()

    @property
    def lengths(self) -> NDArray[np.float64]:
        """(m,) reference length of each bond, m; computed when asked for."""
        return 1.0 / self.stored.inverse_lengths()

    @property
    def inverse_lengths(self) -> NDArray[np.float64]:
        """(m,) 1 / reference length of each bond, 1/m."""
        return self.stored.inverse_lengths()

    @property
    def intact(self) -> NDArray[np.bool_]:
        """(m,) True while a bond holds. To look at: `part[intact] = ...` changes it."""
        holds = self.fields.allocate(intact).view(np.bool_)
        holds.flags.writeable = False
        return holds

    @property
    def has_broken(self) -> bool:
        """True if any bond is broken."""
        return self.stored.has_broken

    def holds(self, nodes: ArrayLike, others: ArrayLike) -> NDArray[np.bool_]:
        """(k,) True for pairs of nodes between which there is a bond, and it is intact."""
        return self.stored.holds(np.asarray(nodes, np.int64), np.asarray(others, np.int64))

    def mark(self, field: Field, region: Geometry | NDArray[np.bool_]) -> None:
        """Sets a bond field of the type uint8 to 1 for bonds with both ends in a geometry or mask (n,), else to 0."""
        self.stored.mark(field, region.contains(self.positions) if isinstance(region, Geometry) else region)

    def tabulate(self, field: Field, function: Of) -> None:
        """Sets a bond field to a function of the reference bonds ξ, (k, d) -> (k,), m; called several times."""
        self.stored.tabulate(field, function)

    def cut(self, surface: Crossing) -> int:
        """Breaks the bonds that cross a surface; they count as damage. Returns how many directed bonds broke.

        Warns:
            UserWarning: if none broke.
        """
        broken, crossing = self.stored.cut(*self._crosses(surface))
        if not broken:
            why = f"the {crossing} directed bonds that cross it were broken before" if crossing else NO_CROSSING
            self._warn(f"cut({surface!r}) broke nothing: {why}")
        return broken

    def remove(self, surface: Crossing) -> int:
        """Takes away bonds that cross a surface, as if they had never been. Returns how many directed bonds went.

        Warns:
            UserWarning: if none went.
        """
        gone = self.stored.remove(*self._crosses(surface))
        self._first = None
        if not gone:
            self._warn(f"remove({surface!r}) took nothing away: {NO_CROSSING}")
        return gone

    def _warn(self, text: str) -> None:
        warnings.warn(f"{self._owner}: bonds.{text}", stacklevel=3)

    def _crosses(self, surface: Crossing) -> tuple[Crosses, NDArray[np.bool_]]:
        """The function that tells whether bonds cross, and the nodes near enough to ask."""
        crosses = surface.crosses if isinstance(surface, Surface) else surface
        if not callable(crosses):
            raise BadInput(
                f"cannot cut with {surface!r}: give a Segment, a Polygon, another surface, or a function of starts and "
                "ends"
            )
        near = np.ones(len(self.positions), np.bool_)
        if isinstance(surface, Surface):
            surface.crosses(self.positions[:0], self.positions[:0])  # refuses what bonds of this part cannot cross
            low, high = (np.asarray(b) for b in surface.bounds)
            sizes, ends = high - low, np.abs([low, high])
            largest = max(float(np.abs(self.positions).max()), float(np.max(ends, initial=0.0, where=ends < np.inf)))
            # surfaces reach beyond their bounds by their tolerance, and somewhat more is searched; that of infinite
            # ones is a part of the length of the bond
            reach = self.reach * (1 + 1e-5) + 1e-8 * float(np.max(sizes, initial=0.0, where=sizes < np.inf))
            reach += 1e-14 * largest
            above, below = self.positions >= low - reach, self.positions <= high + reach
            near = np.asarray((above & below).all(axis=1))
        return crosses, near

    # -- representations --------------------------------------------------------------------------------------------

    def need_list(self, who: str) -> None:
        """Becomes a list, for somebody who can work with nothing else; what is held is kept.

        Raises:
            BadInput: if the user has chosen the lattice, or the list does not fit into memory.
        """
        if not isinstance(self.stored, Lattice):
            return
        if self.chosen:
            raise BadInput(
                f"{who} needs the bonds of {self._owner} as list, and they are stored as lattice: "
                "part.connect(horizon, storage='list'), or leave storage out"
            )
        lattice = self.stored
        require_memory(
            float(CONVERTED * len(lattice)),
            f"{self._owner}: its bonds as list, for {who}",
            "use relations that can work with a lattice, take a smaller horizon or a larger spacing",
        )
        rows = (*lattice.as_rows(), lattice.inverse_lengths())
        self.stored = Rows(self._owner, self.positions, rows, lattice.fields.real)
        for field in lattice.fields:
            self.stored.fields.set(field, lattice.fields.get(field))
        self.stored.fields.given = set(lattice.fields.given)

    def set(self, field: Field, value: ArrayLike) -> None:
        """Sets every entry of a bond field: a number or an array (m,)."""
        fields = self.fields
        if isinstance(fields, LatticeFields) and not fields.fits(field, value):
            self.need_list(f"the field '{field.name}', which differs from bond to bond,")
        self.fields.set(field, value)

    @property
    def nbytes(self) -> int:
        """Bytes held, bond fields included."""
        return self.stored.nbytes
