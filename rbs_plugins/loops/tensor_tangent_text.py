"""Text of what the consistent tangent of a correspondence model needs from its nodes and bonds, for rows.

With N_i = Σ_j μ w_ij (u_j − u_i)⊗ξ / δ in the terms of `tensor_recipe` (ξ in δ), H_i = N_i K_i^-1, and the force on
nodes is f = −Γ^T V (P K^-1 − g N K^-1) + springs, Γ the map from u to N, and springs of stiffness
V_i μ w_ij (g_i + g_j)/δ² for every component between the ends of a bond: Σ μ w |z|² = Σ μ w |η|² − N K^-1 : N, where
broken bonds leave all sums alike. So −df/du = Γ^T G Γ + springs with

    G_(aB)(cD) = V [Σ_EF K^-1_BE A_(aE)(cF) K^-1_FD − g δ_ac K^-1_BD]        A = ∂P/∂F

which is zero where K is singular. A is found by central differences of what the force calls, so it is the derivative
with the stretch across a plate or bar free, and that of a return mapping from the state of the last step.
"""

from __future__ import annotations

from functools import cache

from rbs_plugins.loops.loop import Text
from rbs_plugins.loops.recipe import indented
from rbs_plugins.loops.tensor_recipe import TensorRecipe, gradient, packed
from rbs_plugins.loops.tensor_rows_text import entry, function, numbers, of_nodes, sums_of_gradient

STEP = 2.0**-22  # of F: errors of both kinds are then below one part in a million down to strains of 1e-4


def moduli(r: TensorRecipe) -> str:
    """G of every node, rows and columns in the order of the entries of F."""
    d = r.dimension
    q = d * d
    pairs = [(a, b) for a in range(d) for b in range(d)]
    moved = [f"m{a}{b} = h{a}{b} + (move if n == {a * d + b} else 0.0)" for a, b in pairs]
    if r.across:
        passed = [*(f"m{a}{b}" for a, b in pairs), "stiff", *r.passed()]
        moved.append(f"across = stretch_across({', '.join(passed)})")
    results = ", ".join(["P", *(f"next_{field.name}" for field in r.state)])
    each = [f"n, move = m // 2, ({STEP!r} if m % 2 == 0 else {-STEP!r})", *moved,
            f"F = {gradient(d, 'm{a}{b}', 'across' if r.across else '1.0', r.case)}",
            f"{results} = {r.call_law('F')}",
            *(f"G[i, {(a * d + b) * q} + n] += P[{a}][{b}] * (0.5 / move)" for a, b in pairs)]  # fmt: skip
    close = [*r.states(entry), *r.kinematics_of_node("s{n}", "inverse[i, {n}]"),
             f"for m in range({q * q}):", "    G[i, m] = 0.0",
             f"for m in range({2 * q}):", *indented(each), *_between_inverses(r)]  # fmt: skip
    arrays = ["inverse", "gain", "cells", "G", *of_nodes(r, r.at_nodes, "state")]
    return function(r, "moduli", q, sums_of_gradient(d), close, arrays, [*numbers(r.at_nodes), "even"])


def _between_inverses(r: TensorRecipe) -> list[str]:
    """Lines from A to G; A is replaced by its symmetric part if `even` is not zero."""
    d = r.dimension
    q = d * d
    each = range(d)
    inverse = [[f"inverse[i, {packed(d, a, b)}]" for b in each] for a in each]

    def product(place: str) -> list[str]:
        """K^-1 times the d numbers whose pattern this is."""
        sums = [" + ".join(f"{inverse[k][m]} * y{m}" for m in each) for k in each]
        return [*(f"y{k} = {place.format(k=k)}" for k in each),
                *(f"{place.format(k=k)} = {total}" for k, total in enumerate(sums))]  # fmt: skip

    control = [f"G[i, (a * {d} + {k}) * {q} + a * {d} + {m}] -= gain[i] * {inverse[k][m]}" for k in each for m in each]
    return [
        "if even != 0:", f"    for n in range({q}):", "        for m in range(n):",
        f"            mean = 0.5 * (G[i, n * {q} + m] + G[i, m * {q} + n])",
        f"            G[i, n * {q} + m], G[i, m * {q} + n] = mean, mean",
        f"for n in range({q * d}):", *indented(product(f"G[i, n * {d} + {{k}}]")),
        f"for a in range({d}):", f"    for n in range({q}):",
        *indented(product(f"G[i, (a * {d} + {{k}}) * {q} + n]"), 2), *indented(control),
        f"for n in range({q * q}):", "    G[i, n] *= cells[i]",
    ]  # fmt: skip


def fading(r: TensorRecipe) -> str:
    """What the bonds that soften have left: `left` of `blocks`, `across` of `pulls`, and `tilt`.

    A bond pulls with T_s t. Beside T_s times the derivative of t, that by the displacement of the neighbor has
    t⊗∂T_s/∂u = `tilt`⊗d, d the way between the nodes: tilt = T_s' t/(|ξ| |d|) while the bond loads, zero otherwise.
    """
    d = r.dimension
    values = ", ".join(f"p_{a.name}" if a.kind == "parameter" else f"{a.array}[q]" for a in r.soft_arguments)
    bond = ["e = starts[i] + (q - offsets[i]) + (1 if j > i else 0)",
            f"share, steep = soften({values}), (slope({values}) if loading[q] != 0 else 0.0)",
            *(f"left[e, {k}] = blocks[e, {k}] * share" for k in range(d)),
            *(f"s{k} += left[e, {k}]" for k in range(d)), "across[q] = pulls[q] * share",
            *(f"y{k} = x{k} / per_horizon + e{k}" for k in range(d)),
            f"steep = steep * inverses[q] / sqrt({' + '.join(f'y{k} * y{k}' for k in range(d))})"]  # fmt: skip
    for a in range(d):
        terms = [f"(B[i, {a * d + b}] + B[j, {a * d + b}]) * blocks[e, {b}]" for b in range(d)]
        bond.append(f"tilt[q, {a}] = steep * (cells[i] * ({' + '.join(terms)}) + pulls[q] * e{a})")
    close = ["e = own[i]", *(f"left[e, {k}] = -s{k}" for k in range(d))]
    fields = [a.array for a in r.soft_arguments if a.field is not None]
    given = [f"p_{a.name}" for a in r.soft_arguments if a.kind == "parameter"]
    arrays = ["starts", "own", "blocks", "left", "pulls", "across", "tilt", "cells", "B", "loading", "inverses"]
    return function(r, "fading", d, bond, close, [*arrays, *fields], given)


LOOPS = {each.__name__: each for each in (moduli, fading)}


@cache
def text(name: str, recipe: TensorRecipe) -> Text:
    """The module of one of the loops above."""
    return recipe.text(LOOPS[name](recipe))


def arms(
    begin, end, thread, offsets, neighbors, weights, intact, X, gain, cells, starts, own, blocks, pulls, per_horizon
):
    """Of every bond what Γ has of its neighbor, `blocks`, with what it has of the node itself, and its spring."""
    for i in range(begin, end):
        place = own[i]
        for k in range(X.shape[1]):
            blocks[place, k] = 0.0
        for q in range(offsets[i], offsets[i + 1]):
            j = neighbors[q]
            e = starts[i] + (q - offsets[i]) + (1 if j > i else 0)
            w = weights[q] * per_horizon * per_horizon if intact[q] != 0 else 0.0
            pulls[q] = cells[i] * w * (gain[i] + gain[j])
            for k in range(X.shape[1]):
                blocks[e, k] = w * (X[j, k] - X[i, k])
                blocks[place, k] -= blocks[e, k]
    return 0
