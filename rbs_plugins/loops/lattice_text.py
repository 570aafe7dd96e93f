"""Text of bond loops over a lattice: range of cells -> step -> cells.

A step is the same distance for all cells, so the innermost loop runs over neighboring cells with unit stride, for the
bond ahead and the bond back of one step together: no gathers, no branches, no stores but to sums that stay in cache.
LLVM vectorises it without reordering any sum; everything here is strict arithmetic, so nothing depends on threads, and
both ends of a bond get the same stretch to the bit.

With η = u_j - u_i the stretch is η·(ξ + d) / (|d| + |ξ|) / |ξ|, d = ξ + η: exact for small displacements, and exactly
zero at rest. One division serves both this and the direction d / |d|.
"""

from __future__ import annotations

from functools import cache

from rbs_plugins.loops import roots
from rbs_plugins.loops.arguments import Argument
from rbs_plugins.loops.cells import MAY_FAIL
from rbs_plugins.loops.loop import Text
from rbs_plugins.loops.recipe import FAILS, SLOPE_STEP, Body, Recipe, indented, strict

PLAIN = "@njit(error_model='numpy', no_cpython_wrapper=True, no_cfunc_wrapper=True)"
SIDES = ("ahead", "back")
# Cells of a range, all of whose sums stay in the first cache.
CHUNK = 1024


class LatticeBody(Body):
    """Spelling of what belongs to a bond ahead (to cell + step) or back (to cell - step)."""

    hints = {"intel512": ("widest()",)}
    inverse = "inverse"
    size = "size"
    side = "ahead"
    zoned = False  # whether each bond is asked if it may break

    def value(self, argument: Argument) -> str:
        if argument.kind == "bond":
            return f"table_{argument.array}"
        return f"{'here' if argument.name.endswith('_i') else self.side}_{argument.array}[q]"

    @property
    def weight(self) -> str:
        return (" * fraction" if self.recipe.fraction else "") + (
            "" if self.recipe.uniform else f" * {self.side}_volume[q]"
        )

    @property
    def sided(self) -> dict[str, str]:
        """Padded arrays of node fields, and the ends at which they are needed."""
        arrays = {} if self.recipe.uniform else {"volume": "j"}
        for argument in self.used:
            if argument.kind == "node":
                arrays[argument.array] = arrays.get(argument.array, "") + argument.name[-1]
        return arrays

    @property
    def tables(self) -> list[str]:
        """Bond fields with one value per step."""
        return list(dict.fromkeys(a.array for a in self.used if a.kind == "bond"))

    def lines(self, *wanted: str) -> list[str]:
        """Kinematics of the bond of cell q on this side; `d`, `length`, `stretch` and `quotient` = 1 / length."""
        sign = "x" if self.side == "ahead" else "y"
        found = [f"e{k} = {self.side}{k}[q] - here{k}[q]" for k in self.axes]
        kinematics = f"kinematics({self.each(sign + '{k}')}, {self.each('e{k}')}, size, inverse)"
        found.append(f"{self.each('d{k}')}, length, stretch, quotient = {kinematics}")
        names = {a.name for a in self.used} | set(wanted)
        if names & {"reference_length", "extension"}:
            found.append("reference_length = size")
        if "extension" in names:
            found.append("extension = stretch * size")
        return found

    @property
    def held(self) -> list[str]:
        """Says whether the bond holds."""
        return [f"holds = ({self.side}_bits[q] & bit) != 0"]

    @property
    def failing(self) -> str:
        """Source of the question whether a bond that holds fails."""
        return self.fails + (f" & (({self.side}_zone[q] & bit) != 0)" if self.zoned else "")

    # -- the loops around -------------------------------------------------------------------------------------------

    def _slices(self) -> list[tuple[str, str]]:
        """Slices of padded arrays that the bonds of a step need, and their sources."""
        ahead, back, here = "a + s:e + s", "a - s:e - s", "a:e"
        found = [("ahead_bits", f"bits[word, {here}]"), ("back_bits", f"bits[word, {back}]")]
        if self.zoned:
            found += [("ahead_zone", f"zone[word, {here}]"), ("back_zone", f"zone[word, {back}]")]
        for array, ends in self.sided.items():
            found += [(f"here_{array}", f"{array}[{here}]")] if "i" in ends else []
            found += (
                [(f"ahead_{array}", f"{array}[{ahead}]"), (f"back_{array}", f"{array}[{back}]")] if "j" in ends else []
            )
        return found

    def _of_step(self) -> list[tuple[str, str]]:
        """Numbers of a step, and their sources."""
        found = [("bit", "masks[k]"), ("size", "sizes[k]"), ("inverse", "inverses[k]")]
        found += [(f"x{k}", f"vectors[k, {k}]") for k in self.axes]
        found += [("fraction", "volume_fraction[k]")] if self.recipe.fraction else []
        return found + [(f"table_{array}", f"{array}[k]") for array in self.tables]

    def loop(
        self,
        name: str,
        sums: list[str],
        lines: list[str],
        finish: list[str],
        only: str,
        noted: str = "",
        old: bool = False,
    ) -> str:
        """The function of a loop.

        Args:
            name: of the function.
            sums: arrays with one entry per cell of a range, each a row of `scratch`.
            lines: for each cell q of a range and each step; they may set `failing`.
            finish: for a range, behind all steps.
            only: skips steps without work.
            noted: on which other condition a step is noted as failing.
            old: whether the displacements of the force before are needed.
        """
        r = self.recipe
        arrays = ["u", *(["before"] if old else []), "bits", *(["zone"] if self.zoned else []), *self.sided,
                  "steps", "vectors", "masks", "sizes", "inverses", *(["volume_fraction"] if r.fraction else []),
                  *self.tables, "alive", "failed", "scratch", "cells", "first", "out",
                  *(["dissipation"] if old else [])]  # fmt: skip
        parameters = [*arrays, "margin", "last", "width", "settled", *self.numbers]
        moves = {"": "u", **({"old_": "before"} if old else {})}
        passed = {f"{mark}here{k}": f"{array}[{k}, a:e]" for mark, array in moves.items() for k in self.axes}
        passed |= {f"{mark}{side}{k}": f"{array}[{k}, a {sign} s:e {sign} s]" for mark, array in moves.items()
                   for side, sign in (("ahead", "+"), ("back", "-")) for k in self.axes}  # fmt: skip
        passed |= dict(self._slices()) | dict(self._of_step()) | {each: each for each in (*self.numbers, *sums)}
        empty = [line for n, s in enumerate(sums) for line in (f"{s} = scratch[thread, {n}, :e - a]", f"{s}[:] = 0")]
        step = [only, "s, word = steps[k], k // width", f"if sweep({', '.join(passed.values())}){noted}:",
                "    any_failing = True", "    failed[c, k] = 1"]  # fmt: skip
        whole = [f"a = margin + c * {CHUNK}", f"e = min(a + {CHUNK}, last)", *empty, "any_failing = False",
                 "for k in range(steps.size):", *indented(step), *finish]  # fmt: skip
        # a function of its own for the innermost loop: the compiler then unrolls it, which is worth a quarter
        opposite = [f"y{k} = -x{k}" for k in self.axes]
        sweep = [
            *self.head,
            "failing = False",
            *opposite,
            "for q in range(here0.size):",
            *indented(lines),
            "return failing",
        ]
        ranges = [*self.head, "answer = 0", "for c in range(begin, end):", *indented(whole), "return answer"]
        return "\n".join([
            PLAIN, f"def sweep({', '.join(passed)}):", *indented(sweep), "",
            PLAIN, f"def {name}(begin, end, thread, {', '.join(parameters)}):", *indented(ranges)])  # fmt: skip


SKIP = "if alive[c, k] == 0: continue"
ONLY_FAILED = "if failed[c, k] == 0: continue"


def _to_nodes(dense: bool, target: str, *lines: str) -> list[str]:
    """Lines for each node of a range: `rows[i]` its entry in a target, q its cell in the range."""
    own = [] if dense else ["own = cells[first[c]:first[c + 1]]"]
    return [f"rows = {target}[first[c]:first[c + 1]]", *own, "for i in range(rows.shape[0]):",
            *indented(["q = i" if dense else "q = own[i] - a", *lines])]  # fmt: skip


def force(r: Recipe, dense: bool) -> str:
    """Adds force densities; answers 1 if a bond fails, 2 if something is not finite.

    Bonds that may not break are told apart by range and step; where they stand beside others, they may cause a look at
    bonds of which none breaks. Where a bond fails the range adds nothing, to be done again once the bond is broken
    (settled), unless late.
    """
    body, lines = LatticeBody(r, r.of_force), []
    for side in SIDES:
        body.side = side
        count = [f"failing = failing | (holds & {body.failing})"] if r.criterion is not None else []
        pull = f"pull = REAL({body.call('law', r.law_arguments)}){body.weight} * quotient"
        sums = [f"g{k} = fused(pull, d{k}, g{k}) if holds else g{k}" for k in body.axes]
        lines += [*body.lines(), *body.held, *count, pull, *sums]
    sums = [f"f{k}" for k in body.axes]
    start, end = [f"g{k} = f{k}[q]" for k in body.axes], [f"f{k}[q] = g{k}" for k in body.axes]
    finite = " & ".join(f"(abs(f{k}[q]) < inf)" for k in body.axes)
    wait = ["if any_failing:", "    answer |= 1", *([] if r.late else ["    if settled == 0: continue"])]
    finish = [*wait, "wrong = False",
              "for q in range(e - a):", f"    wrong = wrong | (not ({finite}))", "if wrong: answer |= 2",
              *_to_nodes(dense, "out", *(f"rows[i, {k}] += f{k}[q]{body.after}" for k in body.axes))]  # fmt: skip
    return body.loop("force", sums, [*start, *lines, *end], finish, SKIP,
                     f" and alive[c, k] & {MAY_FAIL} != 0" if r.breakable else "")  # fmt: skip


def energy(r: Recipe, dense: bool) -> str:
    """Adds strain energy densities."""
    body, lines = LatticeBody(r, r.of_energy), {}
    for side, name in zip(SIDES, "gh", strict=True):
        body.side = side
        held = f"{name} = REAL(0.5) * {body.potential()}{body.weight} if holds else REAL(0.0)"
        lines[side] = [*body.lines(), *body.held, held]
    finish = _to_nodes(dense, "out", f"rows[i] += total[q]{body.after}")
    return body.loop("energy", ["total"], [*lines["ahead"], *lines["back"], "total[q] += g + h"], finish, SKIP)


def stiffness(r: Recipe, dense: bool) -> str:
    """Adds the sums of |d law / d stretch| / |ξ| β V at rest, of all bonds that were ever there."""
    body, lines = LatticeBody(r, r.law_arguments), {}
    for side, name in zip(SIDES, "gh", strict=True):
        body.side = side
        lines[side] = [*body.held, "reference_length = size", f"{name} = 0.0", "total = 0.0", *body.slope(),
                       f"{name} = total if holds else 0.0"]  # fmt: skip
    finish = _to_nodes(dense, "out", f"rows[i] += sums[q] / {SLOPE_STEP}{body.after}")
    return body.loop("stiffness", ["sums"], [*lines["ahead"], *lines["back"], "sums[q] += g + h"], finish, SKIP)


def record(r: Recipe, dense: bool) -> str:
    """Adds the energy of bonds that fail now, at both ends; looks at steps that have failed only."""
    body, lines = LatticeBody(r, r.of_force), {}
    body.zoned = r.breakable
    for side in SIDES:
        body.side = side
        sign = "x" if side == "ahead" else "y"
        old = f"kinematics({body.each(sign + '{k}')}, {body.each('e{k}')}, size, inverse)"
        lines[side] = [
            *body.lines("reference_length"), *body.held, f"if holds & {body.failing}:", *indented([
                *(f"e{k} = old_{side}{k}[q] - old_here{k}[q]" for k in body.axes),
                f"{body.each('o{k}')}, length_old, stretch_old, quotient_old = {old}",
                "lost = 0.0", *body.record(), "total[q] += lost"])]  # fmt: skip
    finish = _to_nodes(dense, "dissipation", f"rows[i] += total[q]{body.after}")
    return body.loop("record", ["total"], [*lines["ahead"], *lines["back"]], finish, ONLY_FAILED, old=True)


def release(r: Recipe, dense: bool) -> str:
    """Breaks the bonds that fail now; each bit belongs to one range, that of the end from which it leads ahead."""
    body = LatticeBody(r, r.criterion_arguments)
    body.zoned = r.breakable
    lines = [*body.lines(), *body.held, f"if holds & {body.failing}:", "    ahead_bits[q] &= ~bit"]
    return body.loop("release", [], lines, [], ONLY_FAILED)


@cache
def text(name: str, recipe: Recipe, dense: bool) -> Text:
    """The module of one of the loops above."""
    make = {"force": force, "energy": energy, "stiffness": stiffness, "record": record, "release": release}[name]
    return recipe.text(*kinematics(recipe), make(recipe, dense))


def kinematics(r: Recipe) -> list[str]:
    """What the loops call for a bond: d, length, stretch and 1 / length from x = ξ and e = η."""
    body = LatticeBody(r, ())
    arguments = f"{body.each('x{k}')}, {body.each('e{k}')}, size, inverse"
    moved = [f"d{k} = x{k} + e{k}" for k in body.axes]
    if r.newton:
        # with a = (d² - ξ²) / ξ² the stretch is sqrt(1 + a) - 1; near zero it is known to the last digit of 1 only, so
        # it is corrected by a step of Newton's for stretch (2 + stretch) = a
        lines = [f"change = ({body.products('e{k}', '(e{k} + REAL(2.0) * x{k})')}) * (inverse * inverse)",
                 "square = abs(REAL(1.0) + change)", *roots.text("root", "square"),
                 "rough = fused(square, root, REAL(-1.0))", "miss = fused(rough, rough + REAL(2.0), -change)",
                 "stretch = fused(REAL(-0.5) * root, miss, rough)",
                 f"return {body.each('d{k}')}, square * root * size, stretch, root * inverse"]  # fmt: skip
    else:
        lines = [f"length = sqrt({body.products('d{k}')})", "both = length + size",
                 "share = REAL(1.0) / (length * both)",
                 f"stretch = ({body.products('e{k}', '(x{k} + d{k})')}) * (share * length) * inverse",
                 f"return {body.each('d{k}')}, length, stretch, share * both"]  # fmt: skip
    return [strict("kinematics", arguments, *moved, *lines), FAILS]
