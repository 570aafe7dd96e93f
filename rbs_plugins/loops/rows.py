"""Bond loops over compressed rows: one row of neighbors per node.

The hot loop of the force is what LLVM vectorises: no branch, no store, unsigned neighbor indices, the law inlined. It
counts failing bonds only; a row with any is done again by the cold loop behind it, which breaks them. Kinematics, law
and criterion are compiled strictly (no reordering), so both ends of a bond get the same stretch to the bit and break
together; only the sums over a row may be reordered. A row is always summed in the same way, whatever the threads.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.part import Host, Rows
from rbs_plugins.loops.arguments import Argument
from rbs_plugins.loops.loop import Loop, Text
from rbs_plugins.loops.nodes import add
from rbs_plugins.loops.recipe import FAILS, SLOPE_STEP, Body, Recipe, indented, strict

# Sums may be reordered (they vectorise then); NaN and infinity keep their meaning.
SUMS = "@njit(error_model='numpy', fastmath={'reassoc', 'contract', 'nsz'})"
ROWS = 256  # in a range
TENSORS = ("tensor", "moment")
# What functions with sums over rows begin with, by the processor.
HINTS = {"intel512": ("widest()",), "amd": ("narrower()", "no_gathers()")}


class _Body(Body):
    hints = HINTS
    inverse = "row_inverse[q]"
    size = "1.0 / row_inverse[q]"

    def value(self, argument: Argument) -> str:
        if argument.kind == "bond":
            return f"row_{argument.array}[q]"
        return f"here_{argument.array}" if argument.name.endswith("_i") else f"{argument.array}[j]"

    @property
    def weight(self) -> str:
        flags = (("row_volume_fraction[q]", self.recipe.fraction), ("row_stiffness_factor[q]", self.recipe.surface),
                 ("volume[j]", not self.recipe.uniform))  # fmt: skip
        return "".join(f" * {source}" for source, there in flags if there)

    def function(self, name: str, *body: str, more: Sequence[str] = ()) -> str:
        """The whole function: a loop over nodes with the given body."""
        r = self.recipe
        flags = (("intact", r.intact), ("breakable", r.breakable), ("volume_fraction", r.fraction),
                 ("stiffness_factor", r.surface),
                 ("volume", not r.uniform), ("before", r.dissipation), ("dissipation", r.dissipation))  # fmt: skip
        arrays = dict.fromkeys(a.array for a in self.used if a.field is not None)
        flagged = [flag for flag, there in flags if there]
        flagged += ["reference"] if r.linear else []
        start = ["reference_position"] if r.sums in TENSORS else []
        names = ["offsets", "neighbors", "inverse", "y", *start, "out", *flagged, *more, *arrays, *self.numbers]
        loop = [*self.head, "wrong = 0", "for i in range(begin, end):", *indented([*self.row(), *body]), "return wrong"]
        return "\n".join([SUMS, f"def {name}(begin, end, thread, {', '.join(names)}):", *indented(loop)])

    def row(self) -> list[str]:
        """Slices of the row and values at the node."""
        r = self.recipe
        rows = ["neighbors", "inverse", *(["intact"] if r.intact else []), *(["breakable"] if r.breakable else []),
                *(["volume_fraction"] if r.fraction else []), *(["stiffness_factor"] if r.surface else [])]  # fmt: skip
        rows += [a.array for a in self.used if a.kind == "bond" and a.array not in rows]
        lines = ["first, last = offsets[i], offsets[i + 1]"]
        lines += [f"row_{name} = {name}[first:last]" for name in dict.fromkeys(rows)]
        lines += [f"y{k} = y[i, {k}]" for k in self.axes]
        ends = dict.fromkeys(a.array for a in self.used if a.kind == "node" and a.name.endswith("_i"))
        return lines + [f"here_{name} = {name}[i]" for name in ends]

    def kinematics(self, here: str, there: str) -> str:
        """The call for a bond, by patterns for the positions of its ends."""
        ends = [here, there, *(["reference[i, {k}]", "reference[j, {k}]"] if self.recipe.linear else [])]
        return f"kinematics({', '.join(self.each(end) for end in ends)}, row_inverse[q])"

    def bond(self) -> list[str]:
        """Kinematics of bond q of the row: `d`, `length`, `stretch` and `quotient` = 1 / length."""
        found = f"{self.each('d{k}')}, length, stretch, quotient"
        lines = ["j = row_neighbors[q]", f"{found} = {self.kinematics('y{k}', 'y[j, {k}]')}"]
        wanted = {a.name for a in self.used}
        if wanted & {"reference_length", "extension"}:
            lines.append("reference_length = 1.0 / row_inverse[q]")
        if "extension" in wanted:
            lines.append("extension = length - reference_length")
        return lines


def _force(r: Recipe) -> str:
    body = _Body(r, r.of_force)
    zero = [f"f{k} = 0.0" for k in body.axes]
    pull = f"pull = {body.call('law', r.law_arguments)}{body.weight} * quotient"
    sums = [f"f{k} += pull * d{k}" for k in body.axes]
    loop = [*body.bond(), *(["holds = row_intact[q] != 0"] if r.intact else [])]
    keep = ["pull = pull if holds else 0.0"] if r.intact else []
    count, cold = [], []
    if r.criterion is not None:
        fails = body.fails + (" & (row_breakable[q] != 0)" if r.breakable else "")
        count = [f"failing += holds & {fails}"]
        old = body.kinematics("before[i, {k}]", "before[j, {k}]")
        record = [
            f"{body.each('o{k}')}, length_old, stretch_old, _ = {old}",
            "reference_length = 1.0 / row_inverse[q]",
            *body.record(),
        ]
        breaking = ["row_intact[q] = 0", *([] if r.late else ["holds = False"]), *(record if r.dissipation else [])]
        again = [*loop, f"if holds & {fails}:", *indented(breaking), pull, *keep, *sums]
        cold = ["if failing > 0:", *indented([
            *zero, *(["lost = 0.0"] if r.dissipation else []), "for q in range(row_neighbors.size):", *indented(again),
            *([f"dissipation[i] += lost{body.after}"] if r.dissipation else [])])]  # fmt: skip
    return body.function(
        "force", *zero, *(["failing = 0"] if count else []), "for q in range(row_neighbors.size):",
        *indented([*loop, *count, pull, *keep, *sums]), *cold,
        *(f"out[i, {k}] += f{k}{body.after}" for k in body.axes),
        f"if not ({body.each('isfinite(f{k})', ' and ')}):", "    wrong += 1",
    )  # fmt: skip


def _total(r: Recipe) -> str:
    body = _Body(r, r.law_arguments)
    lines = [*body.bond(), f"value = {body.call('law', r.law_arguments)}{body.weight}",
             *(["value = value if row_intact[q] != 0 else 0.0"] if r.intact else []), "total += value"]  # fmt: skip
    return body.function("total", "total = 0.0", "for q in range(row_neighbors.size):", *indented(lines),
                         f"out[i] += total{body.after}", "if not isfinite(total):", "    wrong += 1")  # fmt: skip


def _tensor(r: Recipe) -> str:
    body = _Body(r, r.law_arguments)
    unit, moved = (" * quotient", "d") if r.sums == "moment" else ("", "e")
    pairs = [(k, m) for k in body.axes for m in body.axes]
    lines = [*body.bond(), *(f"x{k} = reference_position[j, {k}] - reference_position[i, {k}]" for k in body.axes),
             *(f"e{k} = d{k} - x{k}" for k in body.axes if moved == "e"),
             f"value = {body.call('law', r.law_arguments)}{body.weight}{unit}",
             *(["value = value if row_intact[q] != 0 else 0.0"] if r.intact else []),
             *(f"t{k}{m} += value * {moved}{k} * x{m}" for k, m in pairs)]  # fmt: skip
    finite = " and ".join(f"isfinite(t{k}{m})" for k, m in pairs)
    return body.function(r.sums, *(f"t{k}{m} = 0.0" for k, m in pairs), "for q in range(row_neighbors.size):",
                         *indented(lines), *(f"out[i, {k}, {m}] += t{k}{m}{body.after}" for k, m in pairs),
                         f"if not ({finite}):", "    wrong += 1")  # fmt: skip


def _work(r: Recipe) -> str:
    """Adds the work of the law since the last call to each bond."""
    body = _Body(r, r.law_arguments)
    own = ["bond_energy", "bond_force", "bond_extension"]
    lines = [*body.bond(), "grown = stretch / row_inverse[q]", f"pull = {body.call('law', r.law_arguments)}",
             "row_bond_energy[q] += 0.5 * (pull + row_bond_force[q]) * (grown - row_bond_extension[q])",
             "row_bond_force[q], row_bond_extension[q] = pull, grown"]  # fmt: skip
    rows = [f"row_{name} = {name}[first:last]" for name in own]
    text = body.function("work", *rows, "for q in range(row_neighbors.size):", *indented(lines), more=own)
    return text.replace(SUMS, "@njit(error_model='numpy')")  # both directions of a bond must get the same to the bit


def _energy(r: Recipe) -> str:
    body = _Body(r, r.of_energy)
    lines = [*body.bond(), f"held = 0.5 * {body.potential()}{body.weight}",
             *(["held = held if row_intact[q] != 0 else 0.0"] if r.intact else []), "total += held"]  # fmt: skip
    return body.function("energy", "total = 0.0", "for q in range(row_neighbors.size):", *indented(lines),
                         f"out[i] += total{body.after}")  # fmt: skip


def _stiffness(r: Recipe) -> str:
    """Sum of |d law / d stretch| / |ξ| β V over the family at rest."""
    body = _Body(r, r.law_arguments)
    lines = ["j = row_neighbors[q]", "reference_length = 1.0 / row_inverse[q]", *body.slope()]
    return body.function("stiffness", "total = 0.0", "for q in range(row_neighbors.size):", *indented(lines),
                         f"out[i] += total / {SLOPE_STEP}{body.after}")  # fmt: skip


def _springs(r: Recipe) -> str:
    """Each bond as a spring, from its pull now and the slope of that by its length: see `rbs_plugins.tangents`."""
    body = _Body(r, (*r.law_arguments, *r.slope_arguments))
    own = ["along", *([] if r.linear else ["across"])]
    size = "cell * cell" if r.uniform else "volume[i]"
    pull = "0.0" if r.linear else f"{body.call('law', r.law_arguments)} * size * quotient"
    lines = [*body.bond(), "reference_length = 1.0 / row_inverse[q]", f"size = {size}{body.weight}",
             *body.steepness(), f"sideways = {pull}",
             "lengthwise = (steepness * size * row_inverse[q] - sideways) * quotient * quotient",
             *(["holds = row_intact[q] != 0", "lengthwise = lengthwise if holds else 0.0",
                "sideways = sideways if holds else 0.0"] if r.intact else []),
             "row_along[q] = lengthwise", *([] if r.linear else ["row_across[q] = sideways"]),
             "wrong += not (isfinite(lengthwise) and isfinite(sideways))"]  # fmt: skip
    rows = [f"row_{name} = {name}[first:last]" for name in own]
    text = body.function("springs", *rows, "for q in range(row_neighbors.size):", *indented(lines), more=own)
    return text.replace(SUMS, "@njit(error_model='numpy')")  # both directions of a bond must get the same to the bit


def _kinematics(r: Recipe) -> list[str]:
    """What the loops call for a bond: d, length, stretch and 1 / length from the positions of its ends."""
    body = _Body(r, ())
    arguments = f"{body.each('a{k}')}, {body.each('b{k}')}, inverse"
    lines = [*(f"d{k} = b{k} - a{k}" for k in body.axes), f"length = sqrt({body.products('d{k}')})",
             "stretch, quotient = length * inverse - 1.0, 1.0 / length"]  # fmt: skip
    if r.linear:
        arguments = f"{body.each('a{k}')}, {body.each('b{k}')}, {body.each('p{k}')}, {body.each('q{k}')}, inverse"
        lines = [*(f"d{k} = q{k} - p{k}" for k in body.axes), *(f"e{k} = (b{k} - a{k}) - d{k}" for k in body.axes),
                 f"stretch = ({body.products('e{k}', 'd{k}')}) * inverse * inverse",
                 "length, quotient = (1.0 + stretch) / inverse, inverse"]  # fmt: skip
    return [strict("kinematics", arguments, *lines, f"return {body.each('d{k}')}, length, stretch, quotient"), FAILS]


@cache
def _text(name: str, recipe: Recipe) -> Text:
    """The module of one of the loops above."""
    make = {"force": _force, "total": _total, "tensor": _tensor, "moment": _tensor, "energy": _energy,
            "stiffness": _stiffness, "work": _work, "springs": _springs}[name]  # fmt: skip
    return recipe.text(*_kinematics(recipe), make(recipe))


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
        self._springs: Loop | None = None

    def _loop(self, name: str, **other: NDArray[Any]) -> Loop:
        return Loop(_text(name, self._recipe.bare), name, {**self._inputs, **other}, self._ranges, self._count)

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

    def springs(self, along: NDArray[np.float64], across: NDArray[np.float64], time: float, dt: float) -> bool:
        """Writes what bonds resist with at the present displacement, (m,) each; False if something is not finite."""
        if self._springs is None:
            self._springs = self._loop("springs", along=along, across=across)
        self.start()
        self._springs.set(along=along, across=across, time=time, dt=dt, y=self.position)
        return not self._springs().any()

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
