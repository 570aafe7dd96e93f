"""Bond loops over a lattice: buffers, ranges that have work, breaking, and the calls of the compiled loops."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput
from rbs_core.part import Lattice, Part
from rbs_plugins.loops import cells, lattice_text, surface
from rbs_plugins.loops.loop import Loop, Text
from rbs_plugins.loops.ranges import Cells, scratch
from rbs_plugins.loops.recipe import Recipe


class LatticeLoops:
    """The loops of one force, or of another sum, over bonds held as lattice.

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
        self._color, self._everything = self._cells.color, False
        count = len(self._cells.ranges)
        self._moved, self._busy = np.zeros(count, np.bool_), np.ones(count, np.bool_)
        self._alive = np.zeros((count, max(len(stored.steps), 1)), np.uint8)
        self.position = np.zeros((part.dimension, stored.size), self._real)
        self._targets = np.zeros((lattice_text.components(recipe), stored.size), self._real)
        by_cell = self._of_cells(inputs)
        self._inputs: dict[str, Any] = {
            **by_cell,
            **self._cells.tables,
            "u": self.position,
            "targets": self._targets,
            "bits": inputs.get("intact", stored.present),
            "busy": self._busy.view(np.uint8),
            "alive": self._alive,
            "failed": np.zeros_like(self._alive),
            "scratch": scratch(self._real.name, lattice_text.components(recipe)),
        }
        if recipe.breakable:
            self._inputs["zone"] = inputs["breakable"]
        if recipe.dissipation:
            self._inputs["before"] = np.zeros_like(self.position)
        self._survey = self._of_ranges(cells.survey)
        copied = [each for each in changing if by_cell.get(each) is not inputs.get(each)]
        still = [f"field_{name}" for name in recipe.still]
        self._carries = [self._cells.carry(inputs[each], by_cell[each]) for each in copied if each not in still]
        self._gather = self._gatherer(self._inputs["displacement"], self.position, self._moved)
        self._felt = np.zeros_like(self._moved)
        self._feel = [
            self._gatherer(inputs[each][:, None], by_cell[each][None, :], self._felt)
            for each in still
            if each in copied
        ]
        self._sum, self._finish = self._sweep(recipe.sums), self._finisher(self._inputs["out"])
        self._every: Sequence[LatticeLoops] = ()
        self._energy: tuple[Loop, Loop, Loop] | None = None
        self._count = self.visited = len(stored)

    # -- what the loops take ----------------------------------------------------------------------------------------

    def _of_cells(self, inputs: dict[str, Any]) -> dict[str, Any]:
        """Arrays of nodes by cell, numbers in the precision of the fields."""
        nodes = {argument.array for argument in self._recipe.arguments if argument.kind == "node"}
        nodes |= {"volume", *surface.at_nodes(self._recipe)}
        result: dict[str, Any] = {}
        for name, value in inputs.items():
            if name in nodes:
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

    def _sweep(self, name: str, **other: Any) -> Loop:
        """A loop over bonds, stripe by stripe."""
        text = lattice_text.text(name, self._recipe.bare)
        return Loop(text, name, {**self._inputs, **other}, self._cells.stripes, len(self._stored))

    def _of_ranges(self, function: Any, **other: Any) -> Loop:
        inputs = {**self._inputs, **other}
        return Loop(Text.of(function), function.__name__, inputs, self._cells.ranges, len(self._stored))

    def _gatherer(self, source: NDArray[Any], target: NDArray[Any], moved: NDArray[np.bool_]) -> Loop:
        function = cells.gather_dense if self._stored.dense else cells.gather
        return self._of_ranges(function, source=source, target=target, moved=moved.view(np.uint8))

    def _finisher(self, out: NDArray[Any]) -> Loop:
        """What brings sums by cell to the nodes."""
        function = cells.finish_dense if self._stored.dense else cells.finish
        rows = out.reshape(len(out), -1)
        return self._of_ranges(function, targets=self._targets[: rows.shape[1]], out=rows)

    # -- work -------------------------------------------------------------------------------------------------------

    def _carry(self) -> None:
        """Brings fields of nodes that have changed to their cells."""
        for loop in (*self._carries, *self._feel):
            loop()

    def begin(self) -> None:
        """Looks at the bonds that there are when a run begins."""
        self._look_at_bonds()

    def _look_at_bonds(self, tasks: NDArray[np.int64] | None = None) -> None:
        self._survey(tasks)
        if not self._everything:
            self._holding = np.asarray(self._alive.any(axis=1))
            self._at_most = self._with_stripes(self._holding)

    def _with_stripes(self, busy: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], ...]:
        """Ranges that begin bonds, the stripes that hold them, and the ranges to which these bonds lead."""
        return busy, self._cells.in_stripes(busy), self._cells.ahead(busy)

    def start(self) -> None:
        """Takes the present displacement for that of the last force."""
        self._gather()

    def _by_color(self, loop: Loop, work: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Does the stripes that have work; which of them have answered something."""
        answered = np.zeros(len(work), np.bool_)
        for color in (0, 1):
            chosen = np.flatnonzero(work & (self._color == color))
            if len(chosen):
                answered[chosen] = loop(loop.tasks[chosen]) != 0
        return answered

    def _look(self) -> tuple[NDArray[np.bool_], NDArray[np.int64] | None]:
        """Finds ranges with bonds that may feel something: stripes that hold them, ranges that they lead to."""
        if self._everything:
            return np.ones(len(self._color), np.bool_), None
        found = self._at_most
        moved = self._moved | self._felt if self._feel else self._moved
        if self._quiet and not moved.all():
            found = self._with_stripes(self._holding & self._cells.behind(moved))
        self._busy[:], work, touched = found
        self.visited = self._count * int(np.count_nonzero(self._busy)) // max(len(self._busy), 1)
        return work, self._finish.tasks[touched]

    def add(self, time: float, dt: float, start: bool | NDArray[np.bool_] = False) -> bool:
        """Adds the sums of the present displacement to "out", or sets it; False if they are not finite."""
        if "before" in self._inputs:
            self.position, old = self._inputs["before"], self.position
            self._inputs.update(u=self.position, before=old)
            for loop in (self._sum, *self.__dict__.get("_breaking", ())):
                loop.set(u=self.position, before=old)
            self._gather.set(target=self.position)
        self._carry()
        self._gather()
        work, touched = self._look()
        self._sum.set(time=time, dt=dt)
        failing = self._by_color(self._sum, work)
        self._finish.set(start=start)
        finite = not self._finish(None if np.any(start) else touched).any()
        if failing.any():
            self._break(failing, time, dt)
        return finite

    def _break(self, failing: NDArray[np.bool_], time: float, dt: float) -> None:
        """Records and breaks the bonds of these stripes that fail now."""
        for loop in self._breaking:
            loop.set(time=time, dt=dt)
        release, *recording = self._breaking
        if recording:
            record, finish = recording
            self._by_color(record, failing)
            finish(finish.tasks[self._cells.ahead(np.repeat(failing, np.diff(self._cells.stripes)[:, 0]))])
        self._by_color(release, failing)
        self._look_at_bonds(release.tasks[failing])

    @cached_property
    def _breaking(self) -> list[Loop]:
        """The loop that breaks bonds, and, if it is wanted, that for their energy and what brings it to the nodes.

        They are compiled when the first bond fails; their laws are those of the force, which has been compiled.
        """
        if self._every:
            releases = [each._breaking[0] for each in self._every]
            return [releases[0].merged(releases[1:])]
        if not self._recipe.dissipation:
            return [self._sweep("release")]
        record = self._sweep("record", targets=self._targets[:1])
        return [self._sweep("release"), record, self._finisher(self._inputs["dissipation"])]

    def prepare_energy(self, out: NDArray[Any]) -> None:
        """Compiles the loop for energies."""
        # displacements of its own: those of the force must stay what they were at its last call
        target = np.zeros_like(self.position)
        sweep = self._sweep("energy", u=target, targets=self._targets[:1], busy=np.ones_like(self._busy, np.uint8))
        gather = self._gatherer(self._inputs["displacement"], target, np.zeros_like(self._moved))
        self._energy = gather, sweep, self._finisher(out)

    def energy(self, out: NDArray[Any], time: float, dt: float) -> None:
        """Adds the strain energy density (n,) of the present displacement."""
        if self._energy is None:
            self.prepare_energy(out)
        assert self._energy is not None
        gather, sweep, finish = self._energy
        self._carry()
        gather()
        sweep.set(time=time, dt=dt)
        self._by_color(sweep, np.ones(len(self._color), np.bool_))
        finish.set(out=out.reshape(len(out), 1))
        finish()

    def stiffness(self, out: NDArray[np.float64]) -> None:
        """Adds Σ |d law / d stretch| β V / |ξ| at rest, (n,)."""
        alike = self._recipe.uniform and not self._recipe.surface
        slopes = self._recipe.slopes(self._stored.lengths) if alike else None
        if slopes is not None:
            shares = self._inputs["volume_fraction"] if self._recipe.fraction else 1.0
            out += self._stored.weigh(slopes / self._stored.lengths * shares) * float(self._inputs["cell"])
            return
        self._carry()
        everything = {"alive": np.ones_like(self._alive), "busy": np.ones_like(self._busy, np.uint8)}
        sweep = self._sweep("stiffness", bits=self._stored.present, targets=self._targets[:1], **everything)
        self._by_color(sweep, np.ones(len(self._color), np.bool_))
        self._finisher(out)()

    @property
    def nbytes(self) -> int:
        """Bytes of what belongs to these loops alone."""
        energy = 0 if self._energy is None else self.position.nbytes
        names = ("u", "targets", "before", "volume", "alive", "failed", *surface.at_nodes(self._recipe))
        held = [self._inputs[name] for name in names if isinstance(self._inputs.get(name), np.ndarray)]
        return energy + self._moved.nbytes + self._busy.nbytes + sum(array.nbytes for array in held)

    # -- several in one ---------------------------------------------------------------------------------------------

    @property
    def _mergeable(self) -> list[Loop]:
        return [self._survey, *self._carries, *self._feel, self._gather, self._sum, self._finish]

    @property
    def kind(self) -> Hashable:
        """Loops of the same kind can be merged."""
        return tuple(loop.kind for loop in self._mergeable)

    def merged(self, every: Sequence[LatticeLoops]) -> LatticeLoops:
        """The loops of several forces in one; without record of dissipation, and nothing is skipped."""
        loops = [each._mergeable for each in every]
        together = [same[0].merged(same[1:]) for same in zip(*loops, strict=True)]
        for each in every:
            each._busy[:], each._quiet = True, False  # also if one is called alone, as for the forces at the start
        result = object.__new__(LatticeLoops)
        result._inputs, result._every, result._everything = {}, every, True
        result._count = result.visited = sum(each._count for each in every)
        result._color = np.concatenate([each._color for each in every])
        result._survey, *result._carries, result._gather, result._sum, result._finish = together
        result._feel = []
        return result
