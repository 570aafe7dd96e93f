"""Bond loops over a connection: what its nodes hold is taken from its parts, and what they feel is brought back.

Everything happens in world coordinates. Only nodes with a bond take part, so a small particle in a large matrix costs
what its own bonds cost.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.part import Connection, Part
from rbs_core.space import convert, world
from rbs_plugins.loops import nodes as node_loops
from rbs_plugins.loops.loop import Loop, Text
from rbs_plugins.loops.recipe import Recipe
from rbs_plugins.loops.rows import RowLoops

Ends = Sequence[NDArray[Any]]
PLACES = ("displacement", "reference_position")
FELT = ("out", "dissipation")


class JointLoops:
    """The loops of one force over the bonds of a connection.

    Args:
        recipe: what is computed.
        connection: whose bonds.
        at_nodes: for each part an array, by the names that the loops know them by: displacement, reference position,
            the force density "out", "dissipation", and whatever else lives at nodes.
        others: arrays at bonds, and numbers.
        changing: names of what lives at nodes that relations of the scene change; it is taken anew before every use.

    Attributes:
        visited: directed bonds that the last force has visited.
    """

    def __init__(
        self,
        recipe: Recipe,
        connection: Connection,
        at_nodes: dict[str, Ends],
        others: dict[str, Any],
        changing: Collection[str] = (),
    ) -> None:
        self._connection, self._at_nodes = connection, at_nodes
        self._ends = [End(part) for part in connection.ends]
        stops = np.cumsum([0, *(len(nodes) for nodes in connection.nodes)])
        self._shares = [slice(*map(int, ends)) for ends in pairwise(stops)]
        taken = {name: self._taken(arrays) for name, arrays in at_nodes.items() if name not in (*PLACES, *FELT)}
        felt = {name: self._room(arrays) for name, arrays in at_nodes.items() if name in FELT}
        self._kept = [*taken.values(), *felt.values()]
        self._takes = [loop for name in changing if name in taken for loop in self._taking(name, taken[name])]
        self._rows = RowLoops(recipe, connection, {**others, **taken, **felt}, self._placing)
        self._brings = [loop for name, room in felt.items() for loop in self._bringing(room, at_nodes[name])]
        self._energy: NDArray[np.float64] | None = None
        self._alone = False  # on one thread, since several connections may bring something to one node
        self.visited = self._rows.visited

    # -- from the parts and back ------------------------------------------------------------------------------------

    def _taken(self, arrays: Ends) -> NDArray[np.float64]:
        """One array for the nodes of the connection."""
        each = [array[nodes] for array, nodes in zip(arrays, self._connection.nodes, strict=True)]
        return np.concatenate(each).astype(np.float64)

    def _room(self, arrays: Ends) -> NDArray[np.float64]:
        return np.zeros((len(self._connection), *arrays[0].shape[1:]))

    def _taking(self, name: str, target: NDArray[np.float64]) -> list[Loop]:
        """Loops that take what the nodes hold now."""
        sources = zip(self._shares, self._at_nodes[name], self._connection.nodes, strict=True)
        return [_each("take", target=target[share], source=array, nodes=nodes) for share, array, nodes in sources]

    def _placing(self, target: NDArray[np.float64]) -> list[Loop]:
        """Loops that write the present positions."""
        places = zip(self._ends, self._shares, self._connection.nodes, strict=True)
        return [
            _each("place", out=target[share], reference=self._at_nodes["reference_position"][k],
                  displacement=self._at_nodes["displacement"][k], nodes=nodes, turn=end.turn, origin=end.origin)
            for k, (end, share, nodes) in enumerate(places)
        ]  # fmt: skip

    def _bringing(self, source: NDArray[np.float64], arrays: Ends) -> list[Loop]:
        """Loops that add what the nodes feel to the fields of the parts."""
        found = []
        for end, share, array, nodes in zip(self._ends, self._shares, arrays, self._connection.nodes, strict=True):
            shared = {"target": array, "source": source[share], "nodes": nodes}
            found.append(_each("bring", **shared, turn=end.turn) if array.ndim == 2 else _each("put", **shared))
        return found

    def _prepare(self) -> None:
        """Sees where the parts are, and what their nodes hold."""
        for end in self._ends:
            end.look()
        for loop in self._takes:
            loop()

    # -- as the loops of one part -----------------------------------------------------------------------------------

    @property
    def position(self) -> NDArray[np.float64]:
        """(k, d) of the nodes of the connection at the last force, m, in world coordinates."""
        return self._rows.position

    def begin(self) -> None:
        """Called when a run begins; rows need nothing."""

    def start(self) -> None:
        """Takes the present positions for those of the last force."""
        self._prepare()
        self._rows.start()

    def add(self, time: float, dt: float, start: Any = False) -> bool:
        """Adds the sums of the present displacements to "out"; False if they are not finite."""
        assert not np.any(start)
        self._prepare()
        finite = self._rows.add(time, dt)
        for loop in self._brings:
            loop(alone=self._alone)
        return finite

    def prepare_energy(self, out: NDArray[Any]) -> None:
        """Compiles the loop for energies."""
        self._energy = np.zeros(len(self._connection))
        self._rows.prepare_energy(self._energy)

    def energy(self, out: NDArray[Any], time: float, dt: float, end: int = 0) -> None:
        """Adds the strain energy density (n,) of the present displacements, of one of the parts."""
        if self._energy is None:
            self.prepare_energy(out)
        assert self._energy is not None
        self._prepare()
        self._energy.fill(0.0)
        self._rows.energy(self._energy, time, dt)
        out[self._connection.nodes[end]] += self._energy[self._shares[end]]

    def stiffness(self, out: NDArray[np.float64], end: int = 0) -> None:
        """Adds Σ |d law / d stretch| β V / |ξ| at rest, (n,) for one of the parts."""
        self._prepare()
        joint = np.zeros(len(self._connection))
        self._rows.stiffness(joint)
        out[self._connection.nodes[end]] += joint[self._shares[end]]

    def springs(self, along: NDArray[np.float64], across: NDArray[np.float64], time: float, dt: float) -> bool:
        """Writes what bonds resist with at the present displacements, (m,) each; False if something is not finite."""
        self._prepare()
        return self._rows.springs(along, across, time, dt)

    def gradients(self, gradient: NDArray[np.float64], time: float, dt: float) -> None:
        """Writes (m, d) what bonds add to the total of their nodes, differentiated by the place of the neighbor."""
        self._prepare()
        self._rows.gradients(gradient, time, dt)

    @property
    def turns(self) -> NDArray[np.float64]:
        """(parts, d, d) from components in each part to those in the world, as last looked at."""
        return np.array([end.turn for end in self._ends])

    @property
    def nbytes(self) -> int:
        """Bytes of what belongs to these loops alone."""
        return self._rows.nbytes + sum(array.nbytes for array in self._kept)

    # -- several in one ---------------------------------------------------------------------------------------------

    @property
    def kind(self) -> Hashable:
        """Loops of the same kind can be merged."""
        return len(self._takes), *(loop.kind for loop in (*self._takes, *self._brings)), self._rows.kind

    def merged(self, every: Sequence[JointLoops]) -> JointLoops:
        """The loops of several forces in one; without record of dissipation."""
        result = object.__new__(JointLoops)
        result._alone = True
        result._ends = [end for each in every for end in each._ends if end.may_move]
        for name in ("_takes", "_brings"):
            same = zip(*(getattr(each, name) for each in every), strict=True)
            setattr(result, name, [loops[0].merged(loops[1:]) for loops in same])
        result._rows = self._rows.merged([each._rows for each in every])
        return result


def _each(name: str, **arguments: Any) -> Loop:
    """A loop over the nodes of one end."""
    return Loop(Text.of(getattr(node_loops, name)), name, arguments, len(arguments["nodes"]))


class End:
    """Where the coordinates of a part are in the world.

    Attributes:
        turn: (d, d) from components in the part to components in the world.
        origin: (d,) of the part in the world, m.
        may_move: False for a part in world coordinates.
    """

    def __init__(self, part: Part) -> None:
        self._part, self.may_move = part, part.system is not world
        self.turn, self.origin = np.eye(part.dimension), np.zeros(part.dimension)
        self.look()

    def look(self) -> None:
        """Sees where the system of the part is now."""
        if self.may_move:
            corners = np.vstack([np.zeros_like(self.origin), np.eye(len(self.origin))])
            corners = convert(corners, self._part.system, world)
            self.origin[:] = corners[0]
            self.turn[:] = (corners[1:] - corners[0]).T
