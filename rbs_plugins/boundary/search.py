"""Search: the bonds of a connection are found again while the nodes move."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Part, Relation, Trigger, every
from rbs_core.part import Connection, to_world
from rbs_core.relation import Fields
from rbs_core.space import world
from rbs_core.trigger import Clock
from rbs_plugins.fields import displacement
from rbs_plugins.loops import Loop, Text
from rbs_plugins.loops.loop import CHUNK
from rbs_plugins.loops.nodes import chunks, largest_distance

OFTEN = every(20)


class Search(Relation):
    """Finds the bonds of a connection again, among the nodes as they are displaced.

    Args:
        connection: whose bonds; made with a horizon.
        when: trigger, e.g. every(20).

    Raises:
        BadInput: if the connection was given pairs of nodes.

    New bonds have the length at which they are found, and are intact: one that had broken may be found again. Whoever
    wants others (contact, bonds that form under a condition) writes a relation of a few lines that calls
    `connection.search` or `connection.take` itself.
    """

    stays = True

    @staticmethod
    def example(part: Part) -> dict[str, Any]:
        """Bonds within the part."""
        return {"connection": Connection(part, horizon=1.5 * (part.spacing or 1.0)), "when": every(2)}

    def __init__(self, connection: Connection, *, when: Trigger = OFTEN) -> None:
        if not isinstance(connection, Connection) or connection.horizon is None:
            raise BadInput(f"Search: give a connection that was made with a horizon, got {connection!r}")
        super().__init__(connection.ends[0], when=when)
        self.connections = (connection,)
        self.connection = connection
        connection.search_during_runs()

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """Displacement of all parts."""
        return tuple((end, displacement) for end in self.connection.ends)

    @property
    def label(self) -> str:
        return f"Search '{self.connection.name}'"

    def reset(self) -> None:
        self.connection.search()

    def apply(self, clock: Clock) -> None:
        self.connection.search([self[end, displacement] for end in self.connection.ends])

    def state(self) -> dict[str, Any]:
        return self.connection.state()

    def restore(self, state: dict[str, Any]) -> None:
        self.connection.restore(state)


class Travel:
    """How far the nodes of a part have come, in the world, since somebody has looked.

    Args:
        part: the part, which may move as a whole with its system.
        displacement: (n, d) of its nodes, as the scene changes it, m.

    Attributes:
        seen: (n, d) the displacement when somebody has looked, m.
        began: (k, d) where the corners of the box around the nodes were in the world then, m.
    """

    def __init__(self, part: Part, displacement: NDArray[Any]) -> None:
        self._part, self._now = part, displacement
        self.seen = displacement.copy()
        self._partial = chunks(len(displacement))
        arrays = {"a": displacement, "b": self.seen, "partial": self._partial, "chunk": CHUNK}
        self._loop = Loop(Text.of(largest_distance), "largest_distance", arrays, len(displacement))
        self.look()

    def look(self, seen: NDArray[Any] | None = None, began: NDArray[np.float64] | None = None) -> None:
        """From now on, the way begins here; or where it began in a run that is resumed."""
        self.seen[...] = self._now if seen is None else seen
        placed = self._part.positions + self.seen
        self._corners = np.array(list(product(*zip(placed.min(axis=0), placed.max(axis=0), strict=True))))
        self.began = to_world(self._part, self._corners) if began is None else began

    def distance(self) -> float:
        """Bound of the longest way of any node, m: what it has come in its system, and what this has moved."""
        self._loop()
        own = float(np.sqrt(self._partial.max(initial=0.0)))
        if self._part.system is world:
            return own
        # no point of a box goes further than the corner that goes furthest
        return own + float(np.linalg.norm(to_world(self._part, self._corners) - self.began, axis=1).max())

    def gap(self, other: Travel) -> float:
        """Distance of the boxes around the nodes of two parts when somebody has looked, m; 0 if they overlap."""
        (low, high), (start, end) = ((each.began.min(axis=0), each.began.max(axis=0)) for each in (self, other))
        return float(np.linalg.norm(np.maximum(np.maximum(start - high, low - end), 0.0)))
