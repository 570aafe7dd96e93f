"""The text of bond loops over compressed rows.

The hot loop of the force is what LLVM vectorises: no branch, no store, unsigned neighbor indices, the law inlined. It
counts failing bonds only; a row with any is done again by the cold loop behind it, which breaks them. Kinematics, law
and criterion are compiled strictly (no reordering), so both ends of a bond get the same stretch to the bit and break
together; only the sums over a row may be reordered. A row is always summed in the same way, whatever the threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from rbs_plugins.loops.arguments import Argument
from rbs_plugins.loops.loop import Text
from rbs_plugins.loops.recipe import FAILS, SLOPE_STEP, Body, Recipe, indented, strict

# Sums may be reordered (they vectorise then); NaN and infinity keep their meaning.
SUMS = "@njit(error_model='numpy', fastmath={'reassoc', 'contract', 'nsz'})"
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
    lines = [f"size = {size}{body.weight}", f"sideways = {pull}",
             "lengthwise = (steepness * size * row_inverse[q] - sideways) * quotient * quotient",
             *(["lengthwise, sideways = lengthwise if holds else 0.0, sideways if holds else 0.0"] if r.intact else []),
             "row_along[q] = lengthwise", *([] if r.linear else ["row_across[q] = sideways"]),
             "wrong += not (isfinite(lengthwise) and isfinite(sideways))"]  # fmt: skip
    return _by_bond("springs", body, own, lines)


def _gradients(r: Recipe) -> str:
    """What each bond adds to the total of its node, differentiated by the place of its neighbor."""
    body = _Body(r, (*r.law_arguments, *r.slope_arguments))
    lines = [f"slope = steepness * {'cell' if r.uniform else '1.0'}{body.weight} * row_inverse[q] * quotient",
             *(["slope = slope if holds else 0.0"] if r.intact else []),
             *(f"row_gradient[q, {k}] = slope * d{k}" for k in body.axes)]  # fmt: skip
    return _by_bond("gradients", body, ["gradient"], lines)


def _by_bond(name: str, body: _Body, own: list[str], lines: list[str]) -> str:
    """A function that writes arrays of bonds, with `steepness` and `holds` at hand."""
    holds = ["holds = row_intact[q] != 0"] if body.recipe.intact else []
    before = [*body.bond(), "reference_length = 1.0 / row_inverse[q]", *holds, *body.steepness()]
    rows = [f"row_{each} = {each}[first:last]" for each in own]
    text = body.function(name, *rows, "for q in range(row_neighbors.size):", *indented([*before, *lines]), more=own)
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
def text_of(name: str, recipe: Recipe) -> Text:
    """The module of one of the loops above."""
    make = {"force": _force, "total": _total, "tensor": _tensor, "moment": _tensor, "energy": _energy,
            "stiffness": _stiffness, "work": _work, "springs": _springs, "gradients": _gradients}[name]  # fmt: skip
    return recipe.text(*_kinematics(recipe), make(recipe))
