"""Text of correspondence loops over compressed rows: one row of neighbors per node.

Every node sums over its own row, so threads share nothing. Sums of a row may be reordered, in the same way whatever the
threads; stretch and criterion are compiled strictly, and ask for the two ends in the order of their numbers, so both
directed halves of a bond get the same answer to the bit.
"""

from __future__ import annotations

from functools import cache

from rbs_plugins.loops.arguments import Argument
from rbs_plugins.loops.lattice_text import kinematics
from rbs_plugins.loops.loop import Text
from rbs_plugins.loops.recipe import Body, indented
from rbs_plugins.loops.rows_text import SUMS
from rbs_plugins.loops.tensor_lattice_text import asked, tensor_of
from rbs_plugins.loops.tensor_recipe import TensorRecipe, entries, inverse_of_shape, packed


def function(r: TensorRecipe, name: str, sums: int, bond: list[str], close: list[str], arrays: list[str],
              numbers: list[str], first: tuple[str, ...] = ()) -> str:  # fmt: skip
    """A loop over nodes i and their bonds q: `first`, sums s0, ... of what `bond` adds, then `close`.

    `bond` finds j, x0, ... = ξ/δ, e0, ... = η, and w, zero for a broken bond.
    """
    d = r.dimension
    lines = ["j = neighbors[q]", "w = weights[q]", *(["w = w if intact[q] != 0 else 0.0"] if r.intact else []),
             *(f"x{k} = (X[j, {k}] - X[i, {k}]) * per_horizon" for k in range(d)),
             *(f"e{k} = 1.0 * u[j, {k}] - 1.0 * u[i, {k}]" for k in range(d)), *bond]  # fmt: skip
    node = [*first, *(f"s{n} = 0.0" for n in range(sums)), "for q in range(offsets[i], offsets[i + 1]):",
            *indented(lines), *close]  # fmt: skip
    names = dict.fromkeys(["offsets", "neighbors", "weights", *(["intact"] if r.intact else []), "X", "u", *arrays,
                           "per_horizon", *numbers])  # fmt: skip
    whole = ["wrong = 0", "for i in range(begin, end):", *indented(node), "return wrong"]
    return "\n".join([SUMS, f"def {name}(begin, end, thread, {', '.join(names)}):", *indented(whole)])


def entry(name: str, n: int) -> str:
    """Source of component n of an array of nodes."""
    return f"{name}[i, {n}]" if name.startswith(("state_", "new_")) else f"{name}[i]"


def numbers(arguments: tuple[Argument, ...]) -> list[str]:
    """What functions of a node take beside arrays."""
    given = dict.fromkeys(f"p_{a.name}" for a in arguments if a.kind == "parameter")
    return ["stiff", *given, "time", "dt"]


def of_nodes(r: TensorRecipe, arguments: tuple[Argument, ...], *whats: str) -> list[str]:
    """Arrays of the fields that functions of a node ask for."""
    states = [f"{what}_{field.name}" for what in whats for field in r.state]
    return [*states, *(a.array for a in arguments if a.kind == "node")]


def shape(r: TensorRecipe) -> str:
    """K^-1, Σ μ w ξ and g of every node."""
    d, count = r.dimension, entries(r.dimension)
    pairs = [(a, a) for a in range(d)] + [(a, b) for a in range(d) for b in range(a + 1, d)]
    bond = [*(f"s{n} += w * (x{a} * x{b})" for n, (a, b) in enumerate(pairs)),
            *(f"s{count + k} += w * x{k}" for k in range(d))]  # fmt: skip
    close = [*inverse_of_shape(d, "s{n}"), *(f"inverse[i, {n}] = i{n}" for n in range(count)),
             *(f"lean[i, {k}] = 0.0 if singular else s{count + k}" for k in range(d)),
             f"gain[i] = (0.0 if singular else gain_flat[i]) + gain_trace * ({' + '.join(f'i{k}' for k in range(d))})",
             "singular_nodes[i] = singular"]  # fmt: skip
    return function(r, "shape", count + d, bond, close, ["inverse", "lean", "gain", "gain_flat", "singular_nodes"],
                     ["gain_trace"])  # fmt: skip


def sums_of_gradient(d: int) -> list[str]:
    """Lines that add what a bond adds to Σ μ w η⊗ξ."""
    return [f"s{a * d + b} += w * (e{a} * x{b})" for a in range(d) for b in range(d)]


def stress(r: TensorRecipe) -> str:
    """B of every node, from displacements; new states; F and P where somebody wants them."""
    d = r.dimension
    close = [*r.states(entry), *r.kinematics_of_node("s{n}", "inverse[i, {n}]"),
             *r.stress_of_node("inverse[i, {n}]", "gain[i]"), *r.new_states(entry),
             *(f"B[i, {a * d + b}] = b{a}{b}" for a in range(d) for b in range(d))]  # fmt: skip
    for letter in r.keeps:
        close += [f"kept_{letter}[i, {a * d + b}] = {letter}[{a}][{b}]" for a in range(d) for b in range(d)]
        close += [f"kept_{letter}[i, {d * d}] = {letter}[2][2]"] if d < 3 else []
    arrays = ["inverse", "gain", "B", *of_nodes(r, r.at_nodes, "state", "new"), *(f"kept_{x}" for x in r.keeps)]
    return function(r, "stress", d * d, sums_of_gradient(d), close, arrays, numbers(r.at_nodes))


def energy(r: TensorRecipe) -> str:
    """Strain energy density of every node: W(F) + ½ g Σ μ w |z|², with Σ μ w |z|² = Σ μ w |η|² − H : N."""
    d = r.dimension
    square = " + ".join(f"e{k} * e{k}" for k in range(d))
    product = " + ".join(f"h{a}{b} * s{a * d + b}" for a in range(d) for b in range(d))
    values = [r.value_of(a, "F") for a in r.potential_arguments]
    close = [*r.states(entry), *r.kinematics_of_node("s{n}", "inverse[i, {n}]"),
             f"rest = s{d * d} * per_horizon * per_horizon - ({product}) * per_horizon",
             f"out[i] += potential({', '.join(values)}) + 0.5 * gain[i] * rest"]  # fmt: skip
    used = (*r.at_nodes, *r.potential_arguments)
    return function(r, "energy", d * d + 1, [*sums_of_gradient(d), f"s{d * d} += w * ({square})"], close,
                     ["inverse", "gain", "out", *of_nodes(r, used, "state")], numbers(used))  # fmt: skip


def force(r: TensorRecipe) -> str:
    """Adds the force density of every node; answers how many are not finite."""
    d = r.dimension
    bond, soft = [], r.softening is not None
    if soft:
        values = [f"p_{a.name}" if a.kind == "parameter" else f"{a.array}[q]" for a in r.soft_arguments]
        bond.append(f"w = w * soften({', '.join(values)})")
    bond.append("pull = (here + gain[j]) * per_horizon")
    for a in range(d):
        terms = [f"(b{a * d + b} + B[j, {a * d + b}]) * x{b}" for b in range(d)]
        bond.append(f"s{a} += w * ({' + '.join(terms)} + pull * e{a})")
    close = [*(f"out[i, {a}] += s{a} * per_horizon" for a in range(d)),
             f"if not ({' and '.join(f'isfinite(s{a})' for a in range(d))}):", "    wrong += 1"]  # fmt: skip
    first = ("here = gain[i]", *(f"b{n} = B[i, {n}]" for n in range(d * d)))
    fields = [a.array for a in r.soft_arguments if a.field is not None]
    given = [f"p_{a.name}" for a in r.soft_arguments if a.kind == "parameter"]
    return function(r, "force", d, bond, close, ["B", "gain", "out", *fields], given, first)


def _dual(d: int, node: str) -> list[str]:
    """Lines that set `size` to w |K^-1 ξ|."""
    parts = [" + ".join(f"inverse[{node}, {packed(d, a, b)}] * x{b}" for b in range(d)) for a in range(d)]
    return [*(f"y{a} = {part}" for a, part in enumerate(parts)),
            f"size = w * sqrt({' + '.join(f'y{a} * y{a}' for a in range(d))})"]  # fmt: skip


def reach(r: TensorRecipe) -> str:
    """Σ w |K^-1 ξ| of every node, to B[:, 0]."""
    return function(r, "reach", 1, [*_dual(r.dimension, "i"), "s0 += size"], ["B[i, 0] = s0"], ["inverse", "B"], [])


def bound(r: TensorRecipe) -> str:
    """Σ w [B_j |K_j^-1 ξ| + 2 (g_i + g_j)] of every node, B what is in B[:, 0], to `out`."""
    bond = [*_dual(r.dimension, "j"), "s0 += B[j, 0] * size + w * 2.0 * (gain[i] + gain[j])"]
    return function(r, "bound", 1, bond, ["out[i] = s0"], ["inverse", "B", "gain", "out"], [])


class _FailureBody(Body):
    """Spelling of what belongs to the bond q from the end `low` to the end `high`."""

    size = "size"
    inverse = "inverses[q]"
    weight = ""

    def value(self, argument: Argument) -> str:
        if argument.kind == "bond":
            return f"{argument.array}[q]"
        return f"{argument.array}[{'low' if argument.name.endswith('_i') else 'high'}]"

    def _value(self, argument: Argument) -> str:
        if argument.kind != "given":
            return super()._value(argument)
        letter, end = argument.name.split("_")
        return tensor_of(self.recipe.dimension, f"kept_{letter}[{'low' if end == 'i' else 'high'}, {{n}}]")


def failure(r: TensorRecipe) -> str:
    """Breaks the bonds that fail now, each in its own row; answers how many."""
    body, soft = _FailureBody(r, r.criterion_arguments), r.softening is not None
    d = r.dimension
    found = f"{body.each('d{k}')}, length, stretch, quotient"
    call = f"kinematics({body.each('x{k}')}, {body.each('e{k}')}, size, inverses[q])"
    lines = ["if intact[q] == 0: continue", "j = neighbors[q]", "low, high = min(i, j), max(i, j)",
             "size = 1.0 / inverses[q]", "reference_length = size",
             *(f"x{k} = X[j, {k}] - X[i, {k}]" for k in range(d)),
             *(f"e{k} = 1.0 * u[j, {k}] - 1.0 * u[i, {k}]" for k in range(d)),
             f"{found} = {call}", "extension = stretch * size",
             *(["largest_stretch[q] = max(largest_stretch[q], stretch)"] if soft else []),
             f"if {body.fails}{' & (breakable[q] != 0)' if r.breakable else ''}:",
             "    intact[q] = 0", "    broke += 1"]  # fmt: skip
    node = ["broke = 0", "for i in range(begin, end):", "    for q in range(offsets[i], offsets[i + 1]):",
            *indented(lines, 2), "return broke"]  # fmt: skip
    arrays = ["offsets", "neighbors", "intact", *(["breakable"] if r.breakable else []), "X", "u", "inverses",
              *(["largest_stretch"] if soft else []), *(f"kept_{x}" for x in asked(r)),
              *(a.array for a in r.criterion_arguments if a.field is not None)]  # fmt: skip
    names = [*dict.fromkeys(arrays), *body.numbers[:-3], "time", "dt"]
    head = "@njit(error_model='numpy')"
    return "\n\n".join([kinematics(r)[0], "\n".join([head, f"def failure(begin, end, thread, {', '.join(names)}):",
                                                     *indented(node)])])  # fmt: skip


LOOPS = {each.__name__: each for each in (shape, stress, energy, force, reach, bound, failure)}


@cache
def text(name: str, recipe: TensorRecipe) -> Text:
    """The module of one of the loops above."""
    return recipe.text(LOOPS[name](recipe))
