"""Correspondence loops over a lattice: arrays by cell, order of the passes, breaking."""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from rbs_core.part import Lattice, Part
from rbs_plugins.loops import cells, tensor_cells, tensor_lattice_text
from rbs_plugins.loops.loop import Loop, Text
from rbs_plugins.loops.ranges import ALIGNMENT, Cells
from rbs_plugins.loops.tensor_recipe import TensorRecipe, entries, packed
from rbs_plugins.loops.tensor_sweep import AT_ONCE, BLOCK

ROOM_ROWS = 12  # sums of a cell, at most


class TensorLatticeLoops:
    """The loops of one correspondence model over bonds held as lattice.

    Args:
        recipe: what is computed.
        part: whose bonds.
        inputs: arrays and numbers by the names that the loops know them by; "displacement", the force density as
            "out", states as "state_NAME", "intact" and "breakable" as bits; `weights` (h,), influence times partial
            volume of each step; `horizon`, m, and `mean_volume`, m^3; `gain_flat` and `gain_trace`, Pa: g of a node in
            units of 1/(V0 δ²) is the first plus the second times the trace of its K^-1.
        changing: names of inputs that relations of the scene change; they are copied to cells before every use.

    Attributes:
        lost: whether some node has lost its deformation gradient.
    """

    def __init__(
        self, recipe: TensorRecipe, part: Part, inputs: dict[str, Any], changing: Collection[str] = ()
    ) -> None:
        stored = part.bonds.stored
        assert isinstance(stored, Lattice)
        self._recipe, self._stored, self._count = recipe, stored, len(stored)
        self._real, self._horizon = inputs["out"].dtype, float(inputs["horizon"])
        self._cells = Cells(stored, self._real)
        d, size = recipe.dimension, stored.size
        self._state = {field.name: inputs[f"state_{field.name}"] for field in recipe.state}
        self._inputs: dict[str, Any] = {
            **self._numbers_and_nodes(inputs),
            **self._cells.tables,
            **self._tables(inputs["weights"]),
            "bits": inputs.get("intact", stored.present),
            "singular_cells": np.zeros(size, np.uint8),
            "room": _room(self._real.name, BLOCK[d]),
            "per_horizon": self._real.type(1.0 / self._horizon),
            "cell": self._real.type(1.0 / self._horizon),  # what forces are multiplied by at the end
            "time": self._real.type(0),
            "dt": self._real.type(0),
            "gain": np.zeros(size, self._real),
            **{name: np.zeros((rows, size), self._real) for name, rows in self._rows().items()},
        }
        if recipe.breakable:
            self._inputs["zone"] = inputs["breakable"]
        moved = np.zeros(len(self._cells.ranges), np.uint8)
        gather = cells.gather_dense if stored.dense else cells.gather
        arrays = {"source": inputs["displacement"], "target": self._inputs["u"], "moved": moved}
        self._gather = self._over(Text.of(gather), gather.__name__, **arrays)
        self._carries = [self._cells.carry(inputs[name], self._inputs[name]) for name in changing]
        self._takes = [self._state_loop(name, "take_state", "state") for name in self._state]
        self._keeps = [self._state_loop(name, "keep_state", "new") for name in self._state]
        self._shape, self._stress = self._own("shape"), self._own("stress")
        self._force = self._own("even_force" if recipe.even or not recipe.gain else "force")
        self._suspects, self.lost = np.zeros(len(self._cells.ranges), np.bool_), False
        self._uneven: tuple[NDArray[np.int64], NDArray[np.int64]] | None = None
        self._failure = None if recipe.criterion is None else self._own("failure")
        self._finish = self._finisher(inputs["out"])
        self._energy: list[Loop] = []

    # -- what the loops take ----------------------------------------------------------------------------------------

    def _rows(self) -> dict[str, int]:
        """Arrays by cell with several rows."""
        r, d = self._recipe, self._recipe.dimension
        found = {"u": d, "inverse": entries(d), "lean": d, "B": d * d, "targets": d}
        for field in r.state:
            found |= dict.fromkeys((f"state_{field.name}", f"new_{field.name}"), r.entries_of(field))
        return found | {f"kept_{letter}": d * d + (d < 3) for letter in r.keeps}

    def _numbers_and_nodes(self, inputs: dict[str, Any]) -> dict[str, Any]:
        """Fields of nodes by cell, numbers in the precision of the fields, tables of bond fields as they are."""
        nodes = {a.array for a in (*self._recipe.at_nodes, *self._recipe.arguments) if a.kind == "node"}
        result: dict[str, Any] = {}
        for name, value in inputs.items():
            if name in nodes or name == "volume":
                scale = 1.0 / float(inputs["mean_volume"]) if name == "volume" else 1.0
                result[name] = self._cells.padded(value * scale, self._real)
            elif not isinstance(value, np.ndarray):
                result[name] = self._real.type(value)
            elif name.startswith("field_"):
                result[name] = value
        return result

    def _tables(self, weights: NDArray[np.float64]) -> dict[str, Any]:
        """Numbers of each step, filled up to a whole number of those that are taken at once by steps without bonds."""
        stored, d = self._stored, self._recipe.dimension
        more = -len(weights) % AT_ONCE[d]
        axes = stored.vectors * (stored.spacing / self._horizon)
        pairs = [(a, a) for a in range(d)] + [(a, b) for a in range(d) for b in range(a + 1, d)]
        squares = np.stack([axes[:, a] * axes[:, b] for a, b in pairs], axis=1)
        columns = {"coefficients": axes, "squares": squares, "weights": np.ones((len(axes), 1)),
                   "pulls": np.full((len(axes), 1), 1.0 / self._horizon)}  # fmt: skip
        made = {
            name: np.ascontiguousarray(np.pad(column * weights[:, None], ((0, more), (0, 0))), self._real)
            for name, column in columns.items()
        }
        masks = self._cells.tables["masks"]
        words = np.arange(len(weights)) // stored.width
        return {**made, "steps": np.pad(stored.steps, (0, more)), "masks": np.pad(masks, (0, more)),
                "words": np.pad(words, (0, more)), "strides": stored.steps, "breaks": len(weights)}  # fmt: skip

    def _over(self, text: Text, name: str, **other: Any) -> Loop:
        return Loop(text, name, {**self._inputs, **other}, self._cells.ranges, self._count)

    def _own(self, name: str, **other: Any) -> Loop:
        return self._over(tensor_lattice_text.text(name, self._recipe.bare), name, **other)

    def _finisher(self, out: NDArray[Any], **other: Any) -> Loop:
        function = cells.finish_dense if self._stored.dense else cells.finish
        return self._over(Text.of(function), function.__name__, out=out.reshape(len(out), -1), **other)

    def _state_loop(self, name: str, function: str, which: str) -> Loop:
        field = self._state[name].reshape(len(self._stored.cells), -1)
        arrays = {"field": field, "by_cell": self._inputs[f"{which}_{name}"], "cells": self._stored.cells}
        return Loop(Text.of(getattr(tensor_cells, function)), function, arrays, len(field))

    # -- work -------------------------------------------------------------------------------------------------------

    def check_shapes(self) -> NDArray[np.int64]:
        """Nodes whose shape tensor is singular with every bond that was ever there."""
        self._shape.set(bits=self._stored.present)
        self._shape()
        self._shape.set(bits=self._inputs["bits"])
        return np.flatnonzero(self._inputs["singular_cells"][self._stored.cells])

    def begin(self) -> None:
        """Shape tensors of the bonds that there are when a run begins."""
        self._suspects[:] = self._shape() != 0
        self._look_at_singular()

    def _look_at_singular(self) -> None:
        """Finds nodes without gradient, and the ranges in whose reach g is not even because of them."""
        first, cells = self._cells.first, self._stored.cells
        found = np.zeros(len(self._suspects), np.bool_)
        for c in np.flatnonzero(self._suspects):  # empty cells are singular, too
            found[c] = self._inputs["singular_cells"][cells[first[c] : first[c + 1]]].any()
        self.lost, self._uneven = bool(found.any()), None
        if self._recipe.even and self.lost:
            near = self._cells.ahead(found) | self._cells.behind(found)
            self._uneven = self._force.tasks[near], self._force.tasks[~near]

    def _forces(self) -> None:
        if self._uneven is None:
            self._force()
            return
        near, far = self._uneven
        self._force(far)
        self._nodal(near)

    @cached_property
    def _nodal(self) -> Loop:
        """The loop for a g that differs; compiled when the first shape tensor becomes singular."""
        return self._own("force")

    @property
    def singular(self) -> NDArray[np.bool_]:
        """(n,) whether the shape tensor of a node has no inverse."""
        return np.asarray(self._inputs["singular_cells"][self._stored.cells], np.bool_)

    def _take(self) -> None:
        for loop in (*self._carries, *self._takes):
            loop()
        self._gather()

    def force(self, time: float, dt: float, start: bool = False, hold: bool = False) -> tuple[bool, bool]:
        """Adds the force density of the present displacement to "out", or sets it.

        Args:
            time: s.
            dt: s.
            start: whether it is set.
            hold: no bond fails, and states stay what they are.

        Returns:
            Whether it is finite, and whether bonds have failed.
        """
        r, broke = self._recipe, False
        self._take()
        self._stress.set(time=time, dt=dt)
        fails = self._failure is not None and not hold
        at_once = fails and not r.late
        if at_once and r.early:
            broke = self._break(time, dt) is not None
        self._stress()
        if at_once and not r.early:
            again = self._break(time, dt)
            if again is not None:
                broke = True
                self._stress(again)
        self._forces()
        for loop in () if hold else self._keeps:
            loop()
        self._finish.set(start=start)
        finite = not self._finish().any()
        if fails and r.late:
            broke = self._break(time, dt) is not None
        return finite, broke

    def _break(self, time: float, dt: float) -> NDArray[np.int64] | None:
        """Breaks the bonds that fail, computes the shape tensors of their ends anew; tasks that hold such ends."""
        assert self._failure is not None
        self._failure.set(time=time, dt=dt)
        failed = self._failure() != 0
        if not failed.any():
            return None
        tasks = self._shape.tasks[self._cells.ahead(failed)]
        self._suspects[tasks[:, 1]] = self._shape(tasks) != 0
        self._look_at_singular()
        return tasks

    def prepare_energy(self, out: NDArray[Any]) -> None:
        """Compiles the loop for energies."""
        # displacements of its own: those of the force must stay what they were at its last call
        u, density = np.zeros_like(self._inputs["u"]), np.zeros((1, self._stored.size), self._real)
        gather = cells.gather_dense if self._stored.dense else cells.gather
        moved = np.zeros(len(self._cells.ranges), np.uint8)
        arrays = {"source": self._gather._held[0]["source"], "target": u, "moved": moved}
        self._energy = [
            self._over(Text.of(gather), gather.__name__, **arrays),
            self._own("energy", u=u, density=density),
            self._finisher(out, targets=density, cell=self._real.type(1)),
        ]

    def energy(self, out: NDArray[Any], time: float, dt: float) -> None:
        """Adds the strain energy density (n,) of the present displacement."""
        if not self._energy:
            self.prepare_energy(out)
        for loop in (*self._carries, *self._takes):
            loop()
        gather, sweep, finish = self._energy
        gather()
        sweep.set(time=time, dt=dt)
        sweep()
        finish.set(out=out.reshape(len(out), 1))
        finish()

    def bound(self, modulus: float) -> NDArray[np.float64]:
        """(n,) bound of the stiffness of the nodes with all bonds, N/m^4, see `Correspondence.squared_frequency`."""
        held, d = self._inputs, self._recipe.dimension
        kept = {name: held[name].copy() for name in ("B", "inverse", "lean", "gain", "singular_cells")}
        self.check_shapes()
        self._own("reach", bits=self._stored.present)()
        own = np.sqrt(sum(_row(held["inverse"], held["lean"], d, a) ** 2 for a in range(d)))
        held["B"][0] = modulus * (held["B"][0] + own)
        here = held["B"][0] * own
        self._own("bound", bits=self._stored.present)()
        found = (held["targets"][0] + here)[self._stored.cells].astype(np.float64) / self._horizon**2
        held["targets"][...] = 0
        for name, values in kept.items():
            held[name][...] = values
        return np.asarray(found)

    def tensors(self, letter: str, out: NDArray[Any]) -> None:
        """Writes the deformation gradients "F" or stresses "P" (n, d, d) of the last force."""
        d, kept = self._recipe.dimension, self._inputs[f"kept_{letter}"]
        out[...] = kept[: d * d, self._stored.cells].T.reshape(out.shape)

    @property
    def nbytes(self) -> int:
        """Bytes of what belongs to these loops alone."""
        names = (*self._rows(), "gain", "singular_cells", "volume")
        return sum(self._inputs[name].nbytes for name in names if name in self._inputs)


def _row(inverse: NDArray[Any], lean: NDArray[Any], d: int, a: int) -> NDArray[Any]:
    """Row a of K^-1 Σ w ξ."""
    return np.asarray(sum(inverse[packed(d, a, b)] * lean[b] for b in range(d)))


def _room(kind: str, block: int) -> NDArray[Any]:
    """Room for the sums of one block per thread; the last rows keep threads apart."""
    shape = (getattr(numba.config, "NUMBA_NUM_THREADS", 1), ROOM_ROWS, block)
    room = np.zeros(int(np.prod(shape)) * np.dtype(kind).itemsize + ALIGNMENT, np.uint8)
    begin = -room.ctypes.data % ALIGNMENT
    return room[begin : begin + len(room) - ALIGNMENT].view(kind).reshape(shape)
