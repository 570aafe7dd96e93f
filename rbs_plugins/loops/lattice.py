"""Bond loops over a lattice: buffers, ranges that have work, breaking, and the calls of the compiled loops."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence
from functools import cache
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput
from rbs_core.part import Lattice, Part
from rbs_plugins.loops import cells, lattice_text
from rbs_plugins.loops.lattice_text import CHUNK
from rbs_plugins.loops.loop import Loop, Text
from rbs_plugins.loops.recipe import Recipe

ALIGNMENT = 64  # bytes, of the widest vectors


@cache
def scratch(kind: str) -> NDArray[Any]:
    """Room for the sums of one range per thread, shared by all loops: a loop fills it anew in every range.

    The rows begin where vectors of the machine do. The fourth one keeps threads apart: what one is about to load ahead
    of itself must not be what another one stores.
    """
    shape = (getattr(numba.config, "NUMBA_NUM_THREADS", 1), 4, CHUNK)
    room = np.zeros(int(np.prod(shape)) * np.dtype(kind).itemsize + ALIGNMENT, np.uint8)
    begin = -room.ctypes.data % ALIGNMENT
    return room[begin : begin + len(room) - ALIGNMENT].view(kind).reshape(shape)


class Cells:
    """The ranges of a lattice and the tables that its loops share.

    Attributes:
        ranges: (c, 2) tasks, one for each range of CHUNK cells.
        first: (c+1,) first node of each range.
        reach: how many ranges the longest step can cross.
        tables: what the loops take, by name; numbers as `margin`, too.
    """

    def __init__(self, stored: Lattice, real: Any = np.float64) -> None:
        self.stored = stored
        count = -(-(stored.size - 2 * stored.margin) // CHUNK)
        self.ranges = np.stack([np.arange(count), np.arange(1, count + 1)], axis=1)
        edges = stored.margin + CHUNK * np.arange(count + 1)
        self.first = np.searchsorted(stored.cells, edges).astype(np.int64)
        self.reach = -(-stored.margin // CHUNK)
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
            "last": stored.size - stored.margin,
            "width": stored.width,
            "chunk": CHUNK,
            "settled": 0,
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

    def near(self, moved: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Ranges that a bond connects with a range where something is true."""
        before = np.concatenate([[0], np.cumsum(moved)])
        place = np.arange(len(moved))
        low, high = np.maximum(place - self.reach, 0), np.minimum(place + self.reach + 1, len(moved))
        return np.asarray(before[high] > before[low])


class LatticeLoops:
    """The loops of one force over bonds held as lattice.

    Args:
        recipe: what is computed.
        part: whose bonds.
        inputs: arrays and numbers by the names that the loops know them by; displacement as "displacement", the force
            density as "out", "intact" and "breakable" as bits, other bond fields as one value per step.
        quiet: whether bonds feel nothing and do not fail as long as nothing is displaced; ranges without displacement
            are left out then.
        changing: names of inputs that relations of the scene change; they are copied to cells before every use.

    Attributes:
        position: displacement by cell at the last force.
        visited: directed bonds that the last force has visited.
    """

    def __init__(
        self, recipe: Recipe, part: Part, inputs: dict[str, Any], quiet: bool, changing: Collection[str] = ()
    ) -> None:
        stored = part.bonds.stored
        assert isinstance(stored, Lattice)
        self._recipe, self._stored, self._quiet, self._name = recipe, stored, quiet, part.name
        self._real = inputs["out"].dtype
        self._cells = Cells(stored, self._real)
        count = len(self._cells.ranges)
        self._moved = np.zeros(count, np.bool_)
        self._alive = np.zeros((count, max(len(stored.steps), 1)), np.uint8)
        self.position = np.zeros((part.dimension, stored.size), self._real)
        by_cell = self._of_cells(inputs)
        self._inputs: dict[str, Any] = {
            **by_cell,
            **self._cells.tables,
            "u": self.position,
            "bits": inputs.get("intact", stored.present),
            "alive": self._alive,
            "failed": np.zeros_like(self._alive),
            "scratch": scratch(self._real.name),
        }
        # where no bond is spared, those that hold are those that may fail
        self._inputs["zone"] = inputs["breakable"] if recipe.breakable else self._inputs["bits"]
        if recipe.dissipation:
            self._inputs["before"] = np.zeros_like(self.position)
        self._survey = self._fixed(cells.survey)
        self._carries = [
            self._cells.carry(inputs[each], by_cell[each])
            for each in changing
            if by_cell.get(each) is not inputs.get(each)
        ]
        self._gather = self._gatherer(self.position)
        self._force = self._loop("force")
        self._breaking = [self._loop(name) for name in ("record", "release") if name in self._needed]
        self._energy: Loop | None = None
        self._count = self.visited = len(stored)

    @property
    def _needed(self) -> list[str]:
        r = self._recipe
        return [*(["record"] if r.dissipation else []), *(["release"] if r.criterion is not None else [])]

    def _of_cells(self, inputs: dict[str, Any]) -> dict[str, Any]:
        """Arrays of nodes by cell, numbers in the precision of the fields."""
        nodes = {argument.array for argument in self._recipe.arguments if argument.kind == "node"}
        result: dict[str, Any] = {}
        for name, value in inputs.items():
            if name in nodes or name == "volume":
                result[name] = self._cells.padded(value, self._real)
            elif isinstance(value, np.ndarray):
                result[name] = value
            else:
                result[name] = self._number(name, value)
        return {**result, "time": self._real.type(0), "dt": self._real.type(0)}

    def _number(self, name: str, value: float) -> Any:
        limits = np.finfo(self._real)
        if not (value == 0 or float(limits.tiny) <= abs(value) <= float(limits.max) / 1e3):
            raise BadInput(
                f"part '{self._name}' has single precision, in which {name.removeprefix('p_')} = {value:g} cannot be "
                "computed with: make it with precision='double'"
            )
        return self._real.type(value)

    def _loop(self, name: str, **other: Any) -> Loop:
        text = lattice_text.text(name, self._recipe.bare, self._stored.dense)
        return Loop(text, name, {**self._inputs, **other}, self._cells.ranges, len(self._stored))

    def _fixed(self, function: Any, **other: Any) -> Loop:
        inputs = {**self._inputs, **other}
        return Loop(Text.of(function), function.__name__, inputs, self._cells.ranges, len(self._stored))

    def _gatherer(self, target: NDArray[Any]) -> Loop:
        function = cells.gather_dense if self._stored.dense else cells.gather
        moved = self._moved.view(np.uint8)
        return self._fixed(function, source=self._inputs["displacement"], target=target, moved=moved)

    def _carry(self) -> None:
        """Brings fields of nodes that have changed to their cells."""
        for loop in self._carries:
            loop()

    def begin(self) -> None:
        """Looks at the bonds that there are when a run begins."""
        self._survey()

    def start(self) -> None:
        """Takes the present displacement for that of the last force."""
        self._gather()

    def force(self, time: float, dt: float) -> bool:
        """Adds the force density of the present displacement to "out"; False if it is not finite."""
        if "before" in self._inputs:
            self.position, old = self._inputs["before"], self.position
            self._inputs.update(u=self.position, before=old)
            for loop in (self._force, *self._breaking):
                loop.set(u=self.position, before=old)
            self._gather.set(target=self.position)
        self._carry()
        self._gather()
        tasks = self._busy()
        self.visited = self._count * len(tasks) // max(len(self._force.tasks), 1)
        self._force.set(time=time, dt=dt)
        answers = self._force(tasks)
        failing = tasks[(answers & 1) != 0]
        finite = not (answers & 2).any()
        if len(failing):
            failing = failing.copy()
            for loop in self._breaking:
                loop.set(time=time, dt=dt)
                loop(failing)
            self._survey(failing)
            if not self._recipe.late:
                self._force.set(settled=1)
                finite = not (self._force(failing) & 2).any() and finite
                self._force.set(settled=0)
        return finite

    def _busy(self) -> NDArray[np.int64]:
        """Ranges with bonds, and, of a law that is quiet at rest, something displaced within reach."""
        busy = self._alive.any(axis=1)
        if self._quiet:
            busy &= self._cells.near(self._moved)
        return self._force.tasks[busy]

    def prepare_energy(self, out: NDArray[Any]) -> None:
        """Compiles the loop for energies."""
        # displacements of its own: those of the force must stay what they were at its last call
        target = np.zeros_like(self.position)
        self._energy_gather = self._gatherer(target)
        self._energy = self._loop("energy", u=target, out=out)

    def energy(self, out: NDArray[Any], time: float, dt: float) -> None:
        """Adds the strain energy density (n,) of the present displacement."""
        if self._energy is None:
            self.prepare_energy(out)
        assert self._energy is not None
        self._energy.set(out=out, time=time, dt=dt)
        self._carry()
        self._energy_gather()
        self._energy()

    def stiffness(self, out: NDArray[np.float64]) -> None:
        """Adds Σ |d law / d stretch| β V / |ξ| at rest, (n,)."""
        slopes = self._recipe.slopes(self._stored.lengths) if self._recipe.uniform else None
        if slopes is not None:
            shares = self._inputs["volume_fraction"] if self._recipe.fraction else 1.0
            out += self._stored.weigh(slopes / self._stored.lengths * shares) * float(self._inputs["cell"])
            return
        self._carry()
        everything = np.ones_like(self._alive)
        self._loop("stiffness", out=out, bits=self._stored.present, alive=everything)()

    @property
    def nbytes(self) -> int:
        """Bytes of what belongs to these loops alone."""
        energy = 0 if self._energy is None else self.position.nbytes
        names = ("u", "before", "volume", "alive", "failed")
        held = [self._inputs[name] for name in names if isinstance(self._inputs.get(name), np.ndarray)]
        return energy + self._moved.nbytes + sum(array.nbytes for array in held)

    @property
    def kind(self) -> Hashable:
        """Loops of the same kind can be merged."""
        return tuple(loop.kind for loop in (self._survey, *self._carries, self._gather, self._force, *self._breaking))

    def merged(self, every: Sequence[LatticeLoops]) -> LatticeLoops:
        """The loops of several forces in one; without record of dissipation, and nothing is skipped."""

        def together(loops: Sequence[Loop]) -> Loop:
            return loops[0].merged(loops[1:])

        result = object.__new__(LatticeLoops)
        result._inputs, result._quiet, result._recipe = {}, False, self._recipe
        result._count = sum(each._count for each in every)
        result._alive = np.ones((sum(len(each._alive) for each in every), 1), np.uint8)
        result._survey = together([each._survey for each in every])
        result._carries = [together(loops) for loops in zip(*(each._carries for each in every), strict=True)]
        result._gather = together([each._gather for each in every])
        result._force = together([each._force for each in every])
        result._breaking = [together(loops) for loops in zip(*(each._breaking for each in every), strict=True)]
        return result
