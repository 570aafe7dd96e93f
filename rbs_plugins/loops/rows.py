"""Bond loops over compressed rows: one row of neighbors per node, see `rows_text`."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.part import Host, Rows
from rbs_plugins.loops.loop import Loop, Text
from rbs_plugins.loops.nodes import add
from rbs_plugins.loops.recipe import Recipe
from rbs_plugins.loops.rows_text import text_of

ROWS = 256  # in a range


def row_ranges(nodes: int) -> NDArray[np.int64]:
    """(k, 2) ranges of rows."""
    begins = np.arange(0, nodes, ROWS)
    return np.stack([begins, np.minimum(begins + ROWS, nodes)], axis=1)


class RowLoops:
    """The loops of one force over bonds held as rows.

    Args:
        recipe: what is computed.
        host: whose bonds.
        inputs: arrays and numbers by the names that the loops know them by; displacement and reference position as
            "displacement" and "reference_position", the force density as "out".
        movers: makes the loops that write present positions into an array; from the inputs if not given.

    Attributes:
        position: of the nodes at the last force.
        visited: directed bonds that the last force has visited.
    """

    def __init__(
        self,
        recipe: Recipe,
        host: Host,
        inputs: dict[str, Any],
        movers: Callable[[NDArray[np.float64]], list[Loop]] | None = None,
    ) -> None:
        stored = host.bonds.stored
        assert isinstance(stored, Rows)
        offsets, neighbors = stored.as_rows()
        self._recipe, self._count = recipe, len(stored)
        self.visited = len(stored)
        self._ranges = row_ranges(len(host))
        self.position = np.empty((len(host), host.dimension))
        before = {"before": np.empty_like(self.position)} if recipe.dissipation else {}
        if recipe.linear:
            inputs = {**inputs, "reference": host.positions}
        rows = {"offsets": offsets, "neighbors": neighbors, "inverse": stored.inverse, "y": self.position}
        self._inputs = {**inputs, **rows, **before, "time": 0.0, "dt": 0.0}
        self._movers = self._adding if movers is None else movers
        self._moves = [self._movers(target) for target in (self.position, *before.values())]
        self._sum = self._loop(recipe.sums)
        self._energy: list[Loop] = []
        self._slopes: dict[str, Loop] = {}

    def _loop(self, name: str, **other: NDArray[Any]) -> Loop:
        return Loop(text_of(name, self._recipe.bare), name, {**self._inputs, **other}, self._ranges, self._count)

    def _adding(self, target: NDArray[np.float64]) -> list[Loop]:
        moved, start = (self._inputs[name].reshape(-1) for name in ("displacement", "reference_position"))
        return [Loop(Text.of(add), "add", {"out": target.reshape(-1), "a": start, "b": moved}, moved.size)]

    def begin(self) -> None:
        """Called when a run begins; rows need nothing."""

    def start(self) -> None:
        """Takes the present positions for those of the last force."""
        for move in self._moves[0]:
            move()

    def add(self, time: float, dt: float, start: bool = False) -> bool:
        """Adds the sums of the present displacement to "out"; False if they are not finite."""
        assert not start
        if "before" in self._inputs:
            self.position, old = self._inputs["before"], self.position
            self._inputs.update(y=self.position, before=old)
            self._sum.set(y=self.position, before=old)
            self._moves.reverse()
        self.start()
        self._sum.set(time=time, dt=dt)
        return not self._sum().any()

    def prepare_energy(self, out: NDArray[Any]) -> None:
        """Compiles the loop for energies."""
        # positions of its own: those of the force must stay what they were at its last call
        target = np.empty_like(self.position)
        self._energy = [*self._movers(target), self._loop("energy", y=target, out=out)]

    def energy(self, out: NDArray[Any], time: float, dt: float) -> None:
        """Adds the strain energy density (n,) of the present displacement."""
        if not self._energy:
            self.prepare_energy(out)
        self._energy[-1].set(out=out, time=time, dt=dt)
        for loop in self._energy:
            loop()

    def stiffness(self, out: NDArray[np.float64]) -> None:
        """Adds Σ |d law / d stretch| β V / |ξ| at rest, (n,)."""
        self._loop("stiffness", out=out)()

    def gradients(self, gradient: NDArray[np.float64], time: float, dt: float) -> None:
        """Writes (m, d) what bonds add to the total of their nodes, differentiated by the place of the neighbor."""
        self._differentiated("gradients", time, dt, gradient=gradient)

    def springs(self, along: NDArray[np.float64], across: NDArray[np.float64], time: float, dt: float) -> bool:
        """Writes what bonds resist with at the present displacement, (m,) each; False if something is not finite."""
        return self._differentiated("springs", time, dt, along=along, across=across)

    def _differentiated(self, name: str, time: float, dt: float, **out: NDArray[np.float64]) -> bool:
        if name not in self._slopes:
            self._slopes[name] = self._loop(name, **out)
        self.start()
        self._slopes[name].set(**out, time=time, dt=dt, y=self.position)
        return not self._slopes[name]().any()

    @property
    def nbytes(self) -> int:
        """Bytes of what belongs to these loops alone."""
        copies = 1 + ("before" in self._inputs) + bool(self._energy)
        factors = self._inputs["stiffness_factor"].nbytes if self._recipe.surface else 0
        return copies * self.position.nbytes + self._ranges.nbytes + int(factors)

    @property
    def kind(self) -> Hashable:
        """Loops of the same kind can be merged."""
        return (*(move.kind for move in self._moves[0]), self._sum.kind)

    def merged(self, every: Sequence[RowLoops]) -> RowLoops:
        """The loops of several forces in one; without record of dissipation."""
        result = object.__new__(RowLoops)
        result._inputs, result._count = {}, sum(each._count for each in every)
        same = zip(*(each._moves[0] for each in every), strict=True)
        result._moves = [[loops[0].merged(loops[1:]) for loops in same]]
        result._sum = every[0]._sum.merged([each._sum for each in every[1:]])
        return result
