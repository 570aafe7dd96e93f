"""Correspondence loops over compressed rows: arrays by node, order of the passes, breaking."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.part import Part, Rows
from rbs_plugins.loops import tensor_rows_text
from rbs_plugins.loops.loop import Loop, Text
from rbs_plugins.loops.rows import row_ranges
from rbs_plugins.loops.tensor_recipe import TensorRecipe, entries, packed


class TensorRowLoops:
    """The loops of one correspondence model over bonds held as rows.

    Args:
        recipe: what is computed.
        part: whose bonds.
        inputs: as for TensorLatticeLoops, with "reference_position", "intact" and "breakable" as one number per bond,
            `weights` (m,), and `gain_flat` one number or (n,).
        changing: not needed: fields of nodes are looked at where they are.
    """

    def __init__(
        self, recipe: TensorRecipe, part: Part, inputs: dict[str, Any], changing: Collection[str] = ()
    ) -> None:
        stored = part.bonds.stored
        assert isinstance(stored, Rows)
        offsets, neighbors = stored.as_rows()
        n, d = len(part), recipe.dimension
        self._recipe, self._count, self._ranges = recipe, len(stored), row_ranges(n)
        self._horizon, self._d = float(inputs["horizon"]), d
        self._state = {field.name: inputs[f"state_{field.name}"] for field in recipe.state}
        weights = inputs["weights"]
        if "volume" in inputs:
            weights = weights * (inputs["volume"] / inputs["mean_volume"])[neighbors]
        states = {f"state_{name}": array.reshape(n, -1) for name, array in self._state.items()}
        self._inputs: dict[str, Any] = {
            **{name: value for name, value in inputs.items() if name != "volume"},
            **states,
            **{name.replace("state_", "new_"): np.zeros_like(array) for name, array in states.items()},
            **{f"kept_{letter}": np.zeros((n, d * d + (d < 3))) for letter in recipe.keeps},
            "offsets": offsets,
            "neighbors": neighbors,
            "weights": np.ascontiguousarray(weights),
            "inverses": stored.inverse,
            "X": inputs["reference_position"],
            "u": inputs["displacement"],
            "inverse": np.zeros((n, entries(d))),
            "lean": np.zeros((n, d)),
            "gain": np.zeros(n),
            "gain_flat": np.broadcast_to(inputs["gain_flat"], n).copy(),
            "B": np.zeros((n, d * d)),
            "singular_nodes": np.zeros(n, np.uint8),
            "per_horizon": 1.0 / self._horizon,
            "time": 0.0,
            "dt": 0.0,
        }
        self._shape, self._stress, self._force = (self._loop(name) for name in ("shape", "stress", "force"))
        self._failure = None if recipe.criterion is None else self._loop("failure")
        self._energy: Loop | None = None

    def _loop(self, name: str, **other: Any) -> Loop:
        return self.over(tensor_rows_text.text(name, self._recipe.bare), name, **other)

    def over(self, text: Text, name: str, **other: Any) -> Loop:
        """A loop over the rows that takes what these loops hold, and other arrays."""
        return Loop(text, name, {**self._inputs, **other}, self._ranges, self._count)

    def _with_all_bonds(self, name: str, **other: Any) -> Loop:
        return self._loop(name, **({"intact": np.ones(self._count, np.uint8)} if self._recipe.intact else {}), **other)

    # -- work -------------------------------------------------------------------------------------------------------

    def check_shapes(self) -> NDArray[np.int64]:
        """Nodes whose shape tensor is singular with every bond that was ever there."""
        self._with_all_bonds("shape")()
        return np.flatnonzero(self._inputs["singular_nodes"])

    def begin(self) -> None:
        """Shape tensors of the bonds that there are when a run begins."""
        self._shape()

    @property
    def holds(self) -> NDArray[np.uint8]:
        """(m,) whether a bond is intact."""
        return np.asarray(self._inputs.get("intact", np.ones(self._count, np.uint8)))

    @property
    def largest_stretch(self) -> NDArray[np.float64]:
        """(m,) of softening bonds, as of the last step."""
        return np.asarray(self._inputs["largest_stretch"])

    @property
    def lost(self) -> bool:
        """Whether some node has lost its deformation gradient."""
        return bool(self._inputs["singular_nodes"].any())

    @property
    def singular(self) -> NDArray[np.bool_]:
        """(n,) whether the shape tensor of a node has no inverse."""
        return self._inputs["singular_nodes"].astype(np.bool_)

    def force(self, time: float, dt: float, start: bool = False, hold: bool = False) -> tuple[bool, bool]:
        """Adds the force density of the present displacement to "out".

        Args:
            time: s.
            dt: s.
            start: never true: sums of rows are added.
            hold: no bond fails, and states stay what they are.

        Returns:
            Whether it is finite, and whether bonds have failed.
        """
        assert not start
        if hold:
            return self._trial(time, dt), False
        r, broke = self._recipe, False
        self._stress.set(time=time, dt=dt)
        at_once = self._failure is not None and not r.late
        if at_once and r.early:
            broke = self._break(time, dt) is not None
        self._stress()
        if at_once and not r.early:
            again = self._break(time, dt)
            if again is not None:
                broke = True
                self._stress(again)
        finite = not self._force().any()
        for name, array in self._state.items():
            array[...] = self._inputs[f"new_{name}"].reshape(array.shape)
        if self._failure is not None and r.late:
            broke = self._break(time, dt) is not None
        return finite, broke

    def _trial(self, time: float, dt: float) -> bool:
        """The force as if the last step had come here; whether it is finite."""
        self.evaluate(time, dt)
        largest = self.trial_stretch(time, dt)
        if largest is None:
            return not self._force().any()
        self._force.set(field_largest_stretch=largest)
        finite = not self._force().any()
        self._force.set(field_largest_stretch=self._inputs["largest_stretch"])
        return finite

    def evaluate(self, time: float, dt: float) -> None:
        """Stresses of the present displacement."""
        self._stress.set(time=time, dt=dt)
        self._stress()

    def trial_stretch(self, time: float, dt: float) -> NDArray[np.float64] | None:
        """(m,) largest stretch of every bond so far, the present one included; None if it is not asked for now."""
        r = self._recipe
        if r.softening is None or r.late:
            return None
        assert self._failure is not None
        largest, holds = self._inputs["largest_stretch"].copy(), self._inputs["intact"].copy()
        self._failure.set(largest_stretch=largest, field_largest_stretch=largest, intact=holds, time=time, dt=dt)
        self._failure()
        kept = self._inputs["largest_stretch"]
        self._failure.set(largest_stretch=kept, field_largest_stretch=kept, intact=self._inputs["intact"])
        return np.asarray(largest)

    def _break(self, time: float, dt: float) -> NDArray[np.int64] | None:
        """Breaks the bonds that fail, computes the shape tensors of their ends anew; tasks that hold such ends."""
        assert self._failure is not None
        self._failure.set(time=time, dt=dt)
        failed = self._failure() != 0
        if not failed.any():
            return None
        tasks = self._shape.tasks[failed]
        self._shape(tasks)
        return tasks

    def prepare_energy(self, out: NDArray[Any]) -> None:
        """Compiles the loop for energies."""
        self._energy = self._loop("energy", out=out)

    def energy(self, out: NDArray[Any], time: float, dt: float) -> None:
        """Adds the strain energy density (n,) of the present displacement."""
        if self._energy is None:
            self.prepare_energy(out)
        assert self._energy is not None
        self._energy.set(out=out, time=time, dt=dt)
        self._energy()

    def bound(self, modulus: float) -> NDArray[np.float64]:
        """(n,) bound of the stiffness of the nodes with all bonds, N/m^4, see `Correspondence.squared_frequency`."""
        held, d = self._inputs, self._d
        names = ("B", "inverse", "lean", "gain", "singular_nodes")
        kept = {name: held[name].copy() for name in names}
        self.check_shapes()
        self._with_all_bonds("reach")()
        rows = [sum(held["inverse"][:, packed(d, a, b)] * held["lean"][:, b] for b in range(d)) for a in range(d)]
        own = np.sqrt(sum(row**2 for row in rows))
        held["B"][:, 0] = modulus * (held["B"][:, 0] + own)
        here, out = held["B"][:, 0] * own, np.zeros(len(own))
        self._with_all_bonds("bound", out=out)()
        for name, values in kept.items():
            held[name][...] = values
        return np.asarray((out + here) / self._horizon**2)

    def tensors(self, letter: str, out: NDArray[Any]) -> None:
        """Writes the deformation gradients "F" or stresses "P" (n, d, d) of the last force."""
        out[...] = self._inputs[f"kept_{letter}"][:, : self._d**2].reshape(out.shape)

    @property
    def nbytes(self) -> int:
        """Bytes of what belongs to these loops alone."""
        names = (
            "weights",
            "inverse",
            "lean",
            "gain",
            "B",
            "singular_nodes",
            *(f"kept_{x}" for x in self._recipe.keeps),
        )
        return sum(self._inputs[name].nbytes for name in names)
