"""Text of correspondence loops over a lattice: range of cells -> block of cells -> steps -> cells.

Every cell sums over its whole family, ahead and back, so no range writes what another one reads or writes: any number
of threads, and any order of ranges, gives the same bits. A step ahead and the same step back share their products, and
a few steps are taken at once, so that the sums of a cell are loaded and stored once for all of them. A block is so
small that its sums and what it reads of a row of cells stay in the first cache.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from rbs_plugins.loops.arguments import Argument
from rbs_plugins.loops.lattice_text import CHUNK, PLAIN, LatticeBody, kinematics
from rbs_plugins.loops.loop import Text
from rbs_plugins.loops.recipe import indented
from rbs_plugins.loops.tensor_recipe import TensorRecipe, entries, inverse_of_shape, packed
from rbs_plugins.loops.tensor_sweep import Sums


def _numbers(r: TensorRecipe, arguments: tuple[Argument, ...]) -> tuple[str, ...]:
    given = dict.fromkeys(f"p_{a.name}" for a in arguments if a.kind == "parameter")
    return ("per_horizon", "stiff", *given, "time", "dt")


def shape(r: TensorRecipe) -> str:
    """K^-1, Σ μ w ξ and g of every cell; answers 1 if some shape tensor is singular (empty cells are)."""
    d = r.dimension
    count = entries(d)
    sums = Sums(r, "shape", count + d, {}, {"coefficients": d, "squares": count})

    def step(n: int) -> list[str]:
        ones = [line for w, way in (("f", "ahead"), ("b", "back"))
                for line in (f"value = REAL(1.0){sums.volume(n, way)}",
                             f"{w}w{n} = value if {w}{n} else REAL(0.0)")]  # fmt: skip
        both = [f"s{m} += (fw{n} + bw{n}) * squares{n}_{m}" for m in range(count)]
        return [*ones, *both, *(f"s{count + k} += (fw{n} - bw{n}) * coefficients{n}_{k}" for k in range(d))]

    trace = " + ".join(f"i{k}" for k in range(d))
    close = [
        *inverse_of_shape(d, "own{n}[q]"),
        *(f"inverse{n}[q] = i{n}" for n in range(count)),
        *(f"lean{k}[q] = REAL(0.0) if singular else own{count + k}[q]" for k in range(d)),
        "flat = REAL(0.0) if singular else gain_flat",
        f"gain[q] = flat + gain_trace * ({trace})",
        "singular_cells[q] = singular",
        "wrong = wrong | singular",
    ]
    stores = {"inverse": count, "lean": d, "gain": 0, "singular_cells": 0}
    return sums.text(step, close, stores=stores, numbers=("gain_flat", "gain_trace"))


def _differences(r: TensorRecipe, sums: Sums, n: int) -> list[str]:
    """Lines that set x0, ... to μ η ahead minus μ η back of step n, and e0, ... to their sums."""
    lines = []
    for k in range(r.dimension):
        ahead = f"(ahead{n}_u{k}[q] - here_u{k}[q]){sums.volume(n, 'ahead')}"
        back = f"(here_u{k}[q] - back{n}_u{k}[q]){sums.volume(n, 'back')}"
        lines += [f"there, behind = {ahead}, {back}",
                  f"there, behind = there if f{n} else REAL(0.0), behind if b{n} else REAL(0.0)",
                  f"x{k}, e{k} = there + behind, there - behind"]  # fmt: skip
    return lines


def _gradient_step(r: TensorRecipe, sums: Sums) -> Callable[[int], list[str]]:
    d = r.dimension

    def step(n: int) -> list[str]:
        products = [f"s{a * d + b} = fused(x{a}, coefficients{n}_{b}, s{a * d + b})"
                    for a in range(d) for b in range(d)]  # fmt: skip
        return [*_differences(r, sums, n), *products]

    return step


def _node_stores(r: TensorRecipe, arguments: tuple[Argument, ...], *whats: str) -> dict[str, int]:
    """Arrays by cell of states and fields that functions of a node ask for."""
    states = {f"{what}_{field.name}": r.entries_of(field) for what in whats for field in r.state}
    return states | {a.array: 0 for a in arguments if a.kind == "node"}


def _entry(name: str, n: int) -> str:
    return f"{name}{n}[q]" if name.startswith(("state_", "new_")) else f"{name}[q]"


def stress(r: TensorRecipe) -> str:
    """B of every cell, from displacements; new states; F and P where somebody wants them.

    With an even control, Σ μ w 2 g η goes to `targets`: what forces begin with where g is even.
    """
    d = r.dimension
    more = d if r.even else 0
    tables = {"coefficients": d, **({"pulls": 1} if r.even else {})}
    sums = Sums(r, "stress", d * d + more, {"u": (d, "ifb")}, tables)
    inner = _gradient_step(r, sums)

    def step(n: int) -> list[str]:
        pulls = [f"s{d * d + k} = fused(e{k}, pulls{n}_0, s{d * d + k})" for k in range(more)]
        return [*inner(n), *pulls]

    close = [*r.states(_entry), *r.kinematics_of_node("own{n}[q]", "inverse{n}[q]"),
             *r.stress_of_node("inverse{n}[q]", "gain[q]"), *r.new_states(_entry),
             *(f"B{a * d + b}[q] = b{a}{b}" for a in range(d) for b in range(d))]  # fmt: skip
    close += [f"targets{k}[q] = REAL(2.0) * gain[q] * own{d * d + k}[q]" for k in range(more)]
    stores = {"inverse": entries(d), "gain": 0, "B": d * d, **({"targets": d} if more else {}),
              **_node_stores(r, r.at_nodes, "state", "new")}  # fmt: skip
    for letter in r.keeps:
        stores[f"kept_{letter}"] = d * d + (d < 3)
        close += [f"kept_{letter}{a * d + b}[q] = {letter}[{a}][{b}]" for a in range(d) for b in range(d)]
        close += [f"kept_{letter}{d * d}[q] = {letter}[2][2]"] if d < 3 else []
    return sums.text(step, close, stores=stores, numbers=_numbers(r, r.at_nodes))


def energy(r: TensorRecipe) -> str:
    """Strain energy density of every cell: W(F) + ½ g Σ μ w |z|², with Σ μ w |z|² = Σ μ w |η|² − H : N."""
    d = r.dimension
    count = d * d + (1 if r.gain else 0)
    sums = Sums(r, "energy", count, {"u": (d, "ifb")}, {"coefficients": d, "weights": 1})
    inner = _gradient_step(r, sums)

    def step(n: int) -> list[str]:
        lines = inner(n)
        for way, w in (("ahead", "f"), ("back", "b")) if r.gain else ():
            moves = [f"({way}{n}_u{k}[q] - here_u{k}[q])" for k in range(d)]
            square = " + ".join(f"{m} * {m}" for m in moves)
            lines += [f"value = weights{n}_0 * ({square}){sums.volume(n, way)}",
                      f"s{d * d} += value if {w}{n} else REAL(0.0)"]  # fmt: skip
        return lines

    held = []
    if r.gain:
        product = " + ".join(f"h{a}{b} * own{a * d + b}[q]" for a in range(d) for b in range(d))
        held = [f"rest = own{d * d}[q] * per_horizon * per_horizon - ({product}) * per_horizon",
                "held = REAL(0.5) * gain[q] * rest"]  # fmt: skip
    values = [r.value_of(a, "F") for a in r.potential_arguments]
    close = [*r.states(_entry), *r.kinematics_of_node("own{n}[q]", "inverse{n}[q]"), *held,
             f"density0[q] = REAL(potential({', '.join(values)})){' + held' if r.gain else ''}"]  # fmt: skip
    used = (*r.at_nodes, *r.potential_arguments)
    stores = {"inverse": entries(d), "gain": 0, "density": 1, **_node_stores(r, used, "state")}
    return sums.text(step, close, stores=stores, numbers=_numbers(r, used))


def force(r: TensorRecipe) -> str:
    """Force density times horizon of every cell, for a g that differs from cell to cell."""
    return _force(r, "force", r.gain)


def even_force(r: TensorRecipe) -> str:
    """The same where g is the same for the whole family, and `targets` holds the share of the control."""
    return _force(r, "even_force", False)


def _force(r: TensorRecipe, name: str, gain: bool) -> str:
    d = r.dimension
    arrays = {"B": (d * d, "fb"), **({"u": (d, "ifb"), "gain": (0, "ifb")} if gain else {})}
    tables = {"coefficients": d, **({"pulls": 1} if gain else {})}
    sums = Sums(r, name, d, arrays, tables)

    def step(n: int) -> list[str]:
        lines = []
        for way, w in (("ahead", "f"), ("back", "b")):
            if gain:
                lines.append(f"{w}g = (here_gain[q] + {way}{n}_gain[q]) * pulls{n}_0")
            for a in range(d):
                terms = [f"{way}{n}_B{a * d + b}[q] * coefficients{n}_{b}" for b in range(d)]
                value = f"{'' if w == 'f' else '-'}({' + '.join(terms)})"
                if gain:
                    value = f"({w}g * ({way}{n}_u{a}[q] - here_u{a}[q]) + {value})"
                lines += [f"value = {value}{sums.volume(n, way)}", f"s{a} += value if {w}{n} else REAL(0.0)"]
        return lines

    before = r.gain and not gain
    close = []
    for a in range(d):
        own = " + ".join(f"B{a * d + b}[q] * lean{b}[q]" for b in range(d))
        close.append(f"targets{a}[q] {'+=' if before else '='} own{a}[q] + ({own})")
    return sums.text(step, close, stores={"B": d * d, "lean": d, "targets": d})


def reach(r: TensorRecipe) -> str:
    """Σ w |K^-1 ξ| of every cell, over all bonds that were ever there, to B[0]."""
    d = r.dimension
    sums = Sums(r, "reach", 1, {"inverse": (entries(d), "i")}, {"coefficients": d})

    def step(n: int) -> list[str]:
        lines = _dual(d, n, "here_inverse")
        for way, w in (("ahead", "f"), ("back", "b")):
            lines += [f"value = size{sums.volume(n, way)}", f"s0 += value if {w}{n} else REAL(0.0)"]
        return lines

    return sums.text(step, ["B0[q] = own0[q]"], stores={"B": 1})


def bound(r: TensorRecipe) -> str:
    """Σ w [(|Σ w ξ|_j + reach_j) modulus |K_j^-1 ξ| + 2 (g_i + g_j)] of every cell, reach in B[0], to targets[0]."""
    d = r.dimension
    arrays = {"inverse": (entries(d), "fb"), "B": (1, "fb"), "gain": (0, "ifb")}
    sums = Sums(r, "bound", 1, arrays, {"coefficients": d, "weights": 1})

    def step(n: int) -> list[str]:
        lines = []
        for way, w in (("ahead", "f"), ("back", "b")):
            lines += _dual(d, n, f"{way}{n}_inverse")
            value = f"{way}{n}_B0[q] * size + weights{n}_0 * REAL(2.0) * (here_gain[q] + {way}{n}_gain[q])"
            lines += [f"value = ({value}){sums.volume(n, way)}", f"s0 += value if {w}{n} else REAL(0.0)"]
        return lines

    return sums.text(step, ["targets0[q] = own0[q]"], stores={"targets": 1})


def _dual(d: int, n: int, inverse: str) -> list[str]:
    """Lines that set `size` to w |K^-1 ξ|."""
    parts = [" + ".join(f"{inverse}{packed(d, a, b)}[q] * coefficients{n}_{b}" for b in range(d)) for a in range(d)]
    return [*(f"y{a} = {part}" for a, part in enumerate(parts)),
            f"size = sqrt({' + '.join(f'y{a} * y{a}' for a in range(d))})"]  # fmt: skip


# -- failure of bonds ----------------------------------------------------------------------------------------------


class _FailureBody(LatticeBody):
    """As for bonds with a scalar law, and F and P of either end."""

    def _value(self, argument: Argument) -> str:
        if argument.kind != "given":
            return super()._value(argument)
        d, (letter, end) = self.recipe.dimension, argument.name.split("_")
        side = "here" if end == "i" else "ahead"
        entry = f"{side}_kept_{letter}{{n}}[q]"
        return tensor_of(d, entry)

    def _slices(self, zoned: bool) -> list[tuple[str, str]]:
        found, d = super()._slices(zoned), self.recipe.dimension
        for letter in asked(self.recipe):
            for n in range(d * d + (d < 3)):
                found += [(f"here_kept_{letter}{n}", f"kept_{letter}[{n}, a:e]"),
                          (f"ahead_kept_{letter}{n}", f"kept_{letter}[{n}, a + s:e + s]")]  # fmt: skip
        return found


def asked(r: Any) -> list[str]:
    """The tensors that the criterion asks for."""
    return [
        letter for letter in r.keeps if any(a.name in (f"{letter}_i", f"{letter}_j") for a in r.criterion_arguments)
    ]


def tensor_of(d: int, entry: str) -> str:
    """Source of a 3 x 3 tuple from stored entries: d x d, and the one across behind them."""

    def one(a: int, b: int) -> str:
        if a < d and b < d:
            return entry.format(n=a * d + b)
        return "REAL(0.0)" if a != b else entry.format(n=d * d)

    return f"({', '.join('(' + ', '.join(one(a, b) for b in range(3)) + ')' for a in range(3))})"


def failure(r: TensorRecipe) -> str:
    """Breaks the bonds that fail now, each at the end where it begins; answers 1 if there are any."""
    body = _FailureBody(r, r.criterion_arguments)
    passed = {f"here{k}": f"u[{k}, a:e]" for k in body.axes}
    passed |= {f"ahead{k}": f"u[{k}, a + s:e + s]" for k in body.axes}
    passed |= dict(body._slices(r.breakable)) | dict(body._of_step()) | {each: each for each in body.numbers}
    sweep = [*body.head, "failing = False", "for q in range(here0.size):",
             *indented([*body.lines(), f"failing = failing | ({body.failing})"]), "return failing"]  # fmt: skip
    release = ["for q in range(here0.size):", *indented([*body.lines(), f"if {body.failing}:",
               "    here_bits[q] &= ~bit"])]  # fmt: skip
    call = ", ".join(passed.values())
    whole = [*body.head, "answer = 0", "for c in range(begin, end):",
             *indented([f"a = margin + c * {CHUNK}", f"e = min(a + {CHUNK}, last)", "for k in range(breaks):",
                        "    s, word = strides[k], k // width",
                        f"    if sweep({call}):", f"        release({call})", "        answer = 1"]),
             "return answer"]  # fmt: skip
    arrays = ["u", "bits", *(["zone"] if r.breakable else []), *body.by_cell, *(f"kept_{x}" for x in asked(r)),
              "strides", "vectors", "masks", "sizes", "inverses", *body.tables]  # fmt: skip
    names = [*arrays, "margin", "last", "width", "breaks", *body.numbers]
    return "\n\n".join([
        *kinematics(r)[:1],
        "\n".join([PLAIN, f"def sweep({', '.join(passed)}):", *indented(sweep)]),
        "\n".join([PLAIN, f"def release({', '.join(passed)}):", *indented(release)]),
        "\n".join([PLAIN, f"def failure(begin, end, thread, {', '.join(names)}):", *indented(whole)]),
    ])  # fmt: skip


LOOPS = {each.__name__: each for each in (shape, stress, energy, force, even_force, reach, bound, failure)}


@cache
def text(name: str, recipe: TensorRecipe) -> Text:
    """The module of one of the loops above."""
    return recipe.text(LOOPS[name](recipe))
