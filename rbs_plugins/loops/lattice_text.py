"""Text of bond loops over a lattice: range of cells -> step -> cells.

A step is the same distance for all cells, so the innermost loop runs over neighboring cells with unit stride: no
gathers, no branches. Each bond is computed once, at the end from which it leads ahead, for both of its ends. What it
gives the cell where it begins goes to sums of the range, which stay in the first cache; what it gives the cell to which
it leads goes to `targets`, one entry per cell of the lattice, which a few ranges ahead are in use at a time. LLVM
vectorises that without reordering any sum; everything here is strict arithmetic.

With η = u_j - u_i the stretch is η·(ξ + d) / (|d| + |ξ|) / |ξ|, d = ξ + η: exact for small displacements, and exactly
zero at rest. One division serves both this and the direction d / |d|.
"""

from __future__ import annotations

from functools import cache

from rbs_plugins.loops import roots, surface
from rbs_plugins.loops.arguments import Argument
from rbs_plugins.loops.loop import Text
from rbs_plugins.loops.recipe import FAILS, SLOPE_STEP, Body, Recipe, indented, strict

PLAIN = "@njit(error_model='numpy', no_cpython_wrapper=True, no_cfunc_wrapper=True)"
# Cells of a range, all of whose sums stay in the first cache.
CHUNK = 1024


def components(r: Recipe) -> int:
    """How many numbers the sums give a node."""
    return {"force": r.dimension, "total": 1}.get(r.sums, r.dimension**2)


class LatticeBody(Body):
    """Spelling of what belongs to the bond from cell q of a range to the cell ahead."""

    hints = {"intel512": ("widest()",)}
    inverse = "inverse"
    size = "size"

    def value(self, argument: Argument) -> str:
        if argument.kind == "bond":
            return f"table_{argument.array}"
        return f"{'here' if argument.name.endswith('_i') else 'ahead'}_{argument.array}[q]"

    @property
    def weight(self) -> str:
        return (" * fraction" if self.recipe.fraction else "") + surface.weight(self.recipe)

    @property
    def by_cell(self) -> dict[str, str]:
        """Arrays of nodes by cell, and the ends at which they are needed."""
        arrays = {} if self.recipe.uniform else {"volume": "ij"}
        arrays |= dict.fromkeys(surface.at_nodes(self.recipe), "ij")
        for argument in self.used:
            if argument.kind == "node":
                ends = argument.name[-1] if self.recipe.sums == "force" else "ij"
                arrays[argument.array] = arrays.get(argument.array, "") + ends
        return arrays

    @property
    def tables(self) -> list[str]:
        """Bond fields with one value per step."""
        return list(dict.fromkeys(a.array for a in self.used if a.kind == "bond"))

    def lines(self, *wanted: str) -> list[str]:
        """Kinematics of the bond and whether it holds: `d`, `length`, `stretch`, `quotient` = 1 / length, `holds`."""
        found = [f"e{k} = ahead{k}[q] - here{k}[q]" for k in self.axes]
        kinematics = f"kinematics({self.each('x{k}')}, {self.each('e{k}')}, size, inverse)"
        found.append(f"{self.each('d{k}')}, length, stretch, quotient = {kinematics}")
        names = {a.name for a in self.used} | set(wanted)
        if names & {"reference_length", "extension"}:
            found.append("reference_length = size")
        if "extension" in names:
            found.append("extension = stretch * size")
        return [*found, "holds = (here_bits[q] & bit) != 0"]

    @property
    def failing(self) -> str:
        """Source of the question whether a bond fails now."""
        return f"holds & {self.fails}" + (" & ((here_zone[q] & bit) != 0)" if self.recipe.breakable else "")

    def both(self, value: str, back: str | None = None) -> list[str]:
        """Lines that add a value, times the volume of the other end, to the sums of either end, if `counts` says so.

        Args:
            value: for the end where the bond begins.
            back: for the other one; the same if not given.
        """
        here, ahead = ("", "") if self.recipe.uniform else (" * ahead_volume[q]", " * here_volume[q]")
        return [
            f"own0[q] = own0[q] + {value}{here} if counts else own0[q]",
            f"other0[q] = other0[q] + {back or value}{ahead} if counts else other0[q]",
        ]

    # -- the loops around -------------------------------------------------------------------------------------------

    def _slices(self, zoned: bool) -> list[tuple[str, str]]:
        """Slices of arrays by cell that the bonds of a step need, and their sources."""
        found = [("here_bits", "bits[word, a:e]"), *([("here_zone", "zone[word, a:e]")] if zoned else [])]
        for array, ends in self.by_cell.items():
            found += [(f"here_{array}", f"{array}[a:e]")] if "i" in ends else []
            found += [(f"ahead_{array}", f"{array}[a + s:e + s]")] if "j" in ends else []
        return found

    def _of_step(self) -> list[tuple[str, str]]:
        """Numbers of a step, and their sources."""
        found = [("bit", "masks[k]"), ("size", "sizes[k]"), ("inverse", "inverses[k]")]
        found += [(f"x{k}", f"vectors[k, {k}]") for k in self.axes]
        found += [("fraction", "volume_fraction[k]")] if self.recipe.fraction else []
        return found + [(f"table_{array}", f"{array}[k]") for array in self.tables]

    def loop(self, name: str, sums: int, lines: list[str], only: str, zoned: bool = False, old: bool = False) -> str:
        """The function of a loop over the ranges of a stripe; it answers 1 if some line has set `failing`.

        Args:
            name: of the function.
            sums: how many a cell has: those of the range are `own0`, ..., those of cells ahead `other0`, ...
            lines: for each cell q of a range and each step.
            only: skips steps without work.
            zoned: whether each bond is asked if it may break.
            old: whether the displacements of the force before are needed.
        """
        arrays = ["u", *(["before"] if old else []), "bits", *(["zone"] if zoned else []), *self.by_cell,
                  "steps", "vectors", "masks", "sizes", "inverses",
                  *(["volume_fraction"] if self.recipe.fraction else []), *self.tables, "busy", "alive", "failed",
                  *(["targets", "scratch"] if sums else [])]  # fmt: skip
        parameters = [*arrays, "margin", "last", "width", *self.numbers]
        moves = {"": "u", **({"old_": "before"} if old else {})}
        passed = {f"{mark}here{k}": f"{array}[{k}, a:e]" for mark, array in moves.items() for k in self.axes}
        passed |= {f"{mark}ahead{k}": f"{array}[{k}, a + s:e + s]" for mark, array in moves.items() for k in self.axes}
        passed |= dict(self._slices(zoned)) | dict(self._of_step()) | {each: each for each in self.numbers}
        passed |= {f"own{n}": f"own{n}" for n in range(sums)}
        passed |= {f"other{n}": f"targets[{n}, a + s:e + s]" for n in range(sums)}
        step = [only, "s, word = steps[k], k // width", f"if sweep({', '.join(passed.values())}):",
                "    answer, failed[c, k] = 1, 1"]  # fmt: skip
        whole = ["if busy[c] == 0: continue", f"a = margin + c * {CHUNK}", f"e = min(a + {CHUNK}, last)",
                 *(line for n in range(sums) for line in (f"own{n} = scratch[thread, {n}, :e - a]", f"own{n}[:] = 0")),
                 "for k in range(steps.size):", *indented(step),
                 *(f"flush(targets[{n}, a:e], own{n})" for n in range(sums))]  # fmt: skip
        # a function of its own for the innermost loop: the compiler then unrolls it, which is worth a quarter
        sweep = [*self.head, "failing = False", "for q in range(here0.size):", *indented(lines), "return failing"]
        stripe = [*self.head, "answer = 0", "for c in range(begin, end):", *indented(whole), "return answer"]
        return "\n".join([
            PLAIN, f"def sweep({', '.join(passed)}):", *indented(sweep), "",
            PLAIN, f"def {name}(begin, end, thread, {', '.join(parameters)}):", *indented(stripe)])  # fmt: skip


SKIP = "if alive[c, k] == 0: continue"
ONLY_FAILED = "if failed[c, k] == 0: continue"
FLUSH = strict("flush", "total, part", "for q in range(total.size):", "    total[q] += part[q]")


def force(r: Recipe) -> str:
    """Adds forces by cell; answers 1 if a bond fails. Bonds that fail now carry nothing any more, unless late."""
    body = LatticeBody(r, r.of_force)
    here, ahead = ("", "") if r.uniform else (" * ahead_volume[q]", " * here_volume[q]")
    lines = [*body.lines(), f"pull = REAL({body.call('law', r.law_arguments)}){body.weight} * quotient"]
    if r.criterion is not None:
        lines += [f"fails_now = {body.failing}", "failing = failing | fails_now"]
    counts = "holds" if r.criterion is None or r.late else "holds & (not fails_now)"
    lines += [f"counts = {counts}", f"pull_here, pull_ahead = pull{here}, -(pull{ahead})"]
    for k in body.axes:
        lines += [f"own{k}[q] = fused(pull_here, d{k}, own{k}[q]) if counts else own{k}[q]",
                  f"other{k}[q] = fused(pull_ahead, d{k}, other{k}[q]) if counts else other{k}[q]"]  # fmt: skip
    return body.loop("force", r.dimension, lines, SKIP, zoned=r.breakable)


def total(r: Recipe) -> str:
    """Adds sums of a scalar law by cell."""
    body = LatticeBody(r, r.law_arguments)
    lines = [*body.lines(), "counts = holds", f"value = REAL({body.call('law', r.law_arguments)}){body.weight}"]
    swapped = body.swapped(r.law_arguments)
    if swapped:
        lines.append(f"back = REAL({body.call('law', r.law_arguments, **swapped)}){body.weight}")
    return body.loop("total", 1, [*lines, *body.both("value", "back" if swapped else None)], SKIP)


def tensor(r: Recipe) -> str:
    """Adds sums of a scalar law times η⊗ξ, or d/|d|⊗ξ, by cell: both ends see the same product."""
    body = LatticeBody(r, r.law_arguments)
    unit, moved = (" * quotient", "d") if r.sums == "moment" else ("", "e")
    here, ahead = ("", "") if r.uniform else (" * ahead_volume[q]", " * here_volume[q]")
    back = body.call("law", r.law_arguments, **body.swapped(r.law_arguments))
    lines = [*body.lines(), "counts = holds",
             f"value = REAL({body.call('law', r.law_arguments)}){body.weight}{unit}{here}",
             f"back = REAL({back}){body.weight}{unit}{ahead}"]  # fmt: skip
    for k in body.axes:
        for m in body.axes:
            n = k * r.dimension + m
            lines += [f"product = {moved}{k} * x{m}",
                      f"own{n}[q] = fused(value, product, own{n}[q]) if counts else own{n}[q]",
                      f"other{n}[q] = fused(back, product, other{n}[q]) if counts else other{n}[q]"]  # fmt: skip
    return body.loop(r.sums, components(r), lines, SKIP)


def energy(r: Recipe) -> str:
    """Adds strain energy densities by cell."""
    body = LatticeBody(r, r.of_energy)
    held = f"held = REAL(0.5) * {body.potential()}{body.weight}"
    return body.loop("energy", 1, [*body.lines(), held, "counts = holds", *body.both("held")], SKIP)


def stiffness(r: Recipe) -> str:
    """Adds the sums of |d law / d stretch| / |ξ| β V at rest by cell, of all bonds that were ever there."""
    body = LatticeBody(r, r.law_arguments)
    lines = ["counts = (here_bits[q] & bit) != 0", "reference_length = size", "total = 0.0", *body.slope(),
             f"total = total / {SLOPE_STEP}", *body.both("total")]  # fmt: skip
    return body.loop("stiffness", 1, lines, SKIP)


def record(r: Recipe) -> str:
    """Adds the energy of bonds that fail now by cell; looks at steps that have failed only."""
    body = LatticeBody(r, r.of_force)
    old = f"kinematics({body.each('x{k}')}, {body.each('e{k}')}, size, inverse)"
    lines = [
        *body.lines("reference_length"), f"counts = {body.failing}", "if counts:", *indented([
            *(f"e{k} = old_ahead{k}[q] - old_here{k}[q]" for k in body.axes),
            f"{body.each('o{k}')}, length_old, stretch_old, quotient_old = {old}",
            "lost = 0.0", *body.record(), *body.both("lost")])]  # fmt: skip
    return body.loop("record", 1, lines, ONLY_FAILED, zoned=r.breakable, old=True)


def release(r: Recipe) -> str:
    """Breaks the bonds that fail now."""
    body = LatticeBody(r, r.criterion_arguments)
    lines = [*body.lines(), f"if {body.failing}:", "    here_bits[q] &= ~bit"]
    return body.loop("release", 0, lines, ONLY_FAILED, zoned=r.breakable)


LOOPS = {
    "force": force, "total": total, "tensor": tensor, "moment": tensor,
    "energy": energy, "stiffness": stiffness, "record": record, "release": release,
}  # fmt: skip


@cache
def text(name: str, recipe: Recipe) -> Text:
    """The module of one of the loops above."""
    return recipe.text(*kinematics(recipe), *surface.definition(recipe), FLUSH, LOOPS[name](recipe))


def kinematics(r: Recipe) -> list[str]:
    """What the loops call for a bond: d, length, stretch and 1 / length from x = ξ and e = η."""
    body = LatticeBody(r, ())
    arguments = f"{body.each('x{k}')}, {body.each('e{k}')}, size, inverse"
    moved = [f"d{k} = x{k} + e{k}" for k in body.axes]
    if r.linear:
        lines = [f"stretch = ({body.products('e{k}', 'x{k}')}) * (inverse * inverse)",
                 f"return {body.each('d{k}')}, size * (REAL(1.0) + stretch), stretch, inverse"]  # fmt: skip
        moved = [f"d{k} = x{k}" for k in body.axes]
    elif r.newton:
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
