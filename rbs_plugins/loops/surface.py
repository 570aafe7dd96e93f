"""The factor of a bond from factors of its ends: source for a lattice, where it is computed anew, arrays for a list."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rbs_core.part import Rows
from rbs_core.part.storage import Storage
from rbs_plugins.loops.recipe import Recipe, strict

VOLUMES = "volumes"  # 2 / (a + b), for the shares a and b of whole families that the ends have
DIRECTIONS = "directions"  # [Σ (n / k)²]^(-1/2) with the mean k of the factors of both ends, for each axis


def at_nodes(recipe: Recipe) -> list[str]:
    """Names of the arrays of nodes that loops over a lattice take."""
    count = {"": 0, VOLUMES: 1, DIRECTIONS: recipe.dimension}[recipe.surface]
    return [f"surface{k}" for k in range(count)]


def weight(recipe: Recipe) -> str:
    """Source of the factor of the bond from cell q of a range, " * ..." or nothing."""
    ends = [f"{end}_{name}[q]" for end in ("here", "ahead") for name in at_nodes(recipe)]
    way = [*(f"x{k}" for k in range(recipe.dimension)), "inverse"] if recipe.surface == DIRECTIONS else []
    return f" * surface({', '.join([*ends, *way])})" if ends else ""


def definition(recipe: Recipe) -> list[str]:
    """Source of the function that `weight` calls, if it does."""
    if recipe.surface == VOLUMES:
        return [strict("surface", "a, b", "return REAL(2.0) / (a + b)")]
    if recipe.surface == DIRECTIONS:
        axes = range(recipe.dimension)
        names = [f"{letter}{k}" for letter in "abx" for k in axes]
        parts = [f"t{k} = x{k} * inverse / (a{k} + b{k})" for k in axes]
        square = " + ".join(f"t{k} * t{k}" for k in axes)
        return [strict("surface", ", ".join([*names, "inverse"]), *parts, f"return REAL(0.5) / sqrt({square})")]
    return []


def inputs(recipe: Recipe, stored: Storage, ends: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """What loops take for (n, q) factors of the ends of bonds, by name."""
    if isinstance(stored, Rows):
        return {"stiffness_factor": bond_factors(recipe.surface, stored, ends)}
    return dict(zip(at_nodes(recipe), np.ascontiguousarray(ends.T), strict=True))


def bond_factors(kind: str, stored: Rows, ends: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m,) factors of the bonds of a list from (n, q) factors of their ends; the same from either end, to the bit."""
    factors = np.empty(len(stored))
    for run, nodes, others, bonds in stored.runs():
        factors[run] = factors_between(kind, ends[nodes] + ends[others], bonds * stored.inverse[run][:, None])
    return factors


def factors_between(kind: str, both: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m,) factors of bonds from sums (m, q) of the factors of their ends, and directions (m, d) of length 1."""
    if kind == VOLUMES:
        return np.asarray(2.0 / both[:, 0])
    way = directions / both
    return np.asarray(0.5 / np.sqrt((way * way).sum(axis=1)))
