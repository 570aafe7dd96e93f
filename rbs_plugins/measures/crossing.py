"""The peridynamic stress tensor: every bond that passes a cell adds to the stress there."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from rbs_core import Part, Trigger, always
from rbs_core.relation import Fields
from rbs_core.trigger import Clock
from rbs_plugins.constitutive.bond_based import BondBased
from rbs_plugins.constitutive.pairwise import PairwiseForce
from rbs_plugins.fields import displacement, intact, peridynamic_stress, reference_position, volume, volume_fraction
from rbs_plugins.loops.source import compilable
from rbs_plugins.loops.surface import factors_between
from rbs_plugins.measures.family import FamilyMeasure, checked_forces
from rbs_plugins.measures.stress import require_listed

AT_ONCE = 2**18  # bonds, so that what a measure needs beside the fields stays in tens of megabytes
SAMPLES = 8  # along a bond between nodes that are on no grid

Numbers = NDArray[np.int64]
# adds to (n, d, d) what the bonds from nodes i (k,) to nodes j (k,) with moments (k, d, d) give to the cells
Deposit = Callable[[NDArray[np.float64], Numbers, Numbers, NDArray[np.float64]], None]


class PeridynamicStress(FamilyMeasure):
    """Peridynamic stress tensor of Lehoucq & Silling (2008), its mean over the cell of each node.

    Args:
        part: connected part.
        forces: the constitutive relations whose bonds carry the stress, all on the bonds of this part.
        when: trigger.

    Raises:
        BadInput: on forces that are not on the bonds of the part.

    The tensor at x sums the bonds through x: ν(x) = ½ ∫∫ f⊗ξ ∫₀¹ δ(x − X − λξ) dλ dV dV', f = T⟨ξ⟩ − T'⟨−ξ⟩,
    ξ = X' − X; it is written here with a Dirac δ in place of their spherical coordinates. Its mean over the cell of
    node k, of volume V_k, is

        ν_k = 1/V_k Σ f⊗ξ β V_i V_j s   over all intact bonds i-j, each once,

    s the share of the bond that lies inside the cell. On a grid the shares are exact; for other nodes the share is
    that of 8 equidistant points of the bond to which node k is the nearest one. What lies in cells without a node (a
    bond across the mouth of a notch) is left out. It is a first Piola-Kirchhoff stress, N per reference area, first
    index of the force.

    Unlike the collapsed stress it balances the forces, div ν = −L, also near surfaces, loads and cracks: the mean of
    ν·n over a section is the force through it. In a uniform deformation both are equal away from surfaces. One call
    takes as long as some hundred forces, on one thread: give it a trigger.
    """

    @staticmethod
    def example(part: Part) -> dict[str, Any]:
        """The stress of a linear material."""
        return {"forces": [BondBased(part, E=1e9)]}

    writes = (peridynamic_stress,)

    def __init__(self, part: Part, forces: PairwiseForce | Sequence[PairwiseForce], *, when: Trigger = always) -> None:
        super().__init__(part, when=when)
        self._forces = checked_forces(self.label, part, forces)

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """What the forces read, and the state of their bonds."""
        own = [displacement, reference_position, volume, *([intact] if self.may_have_broken else [])]
        return tuple(dict.fromkeys([*own, *self.of_forces(self._forces)]))

    def begin(self, clock: Clock) -> None:
        for force in self._forces:
            require_listed(force)
        self._pulls = [_Pull(self, force) for force in self._forces]
        self._deposit: Deposit | None = None
        self._made = self.part.version

    def apply(self, clock: Clock) -> None:
        if self._made != self.part.version:
            self.begin(clock)
        if self._deposit is None:
            self._deposit = grid_cells(self.part) if self.part.grid is not None else nearest_cells(self.part)
        part = self.part
        u, sizes = self[displacement].astype(np.float64), self[volume].astype(np.float64)
        for pull in self._pulls:
            pull.refresh()
        total = np.zeros((len(part), part.dimension, part.dimension))
        for bonds, i, j in self._bonds():
            xi, eta = part.positions[j] - part.positions[i], u[j] - u[i]
            force = np.sum([pull(bonds, i, j, xi, eta) for pull in self._pulls], axis=0)
            moment = (sizes[i] * sizes[j])[:, None, None] * force[:, :, None] * xi[:, None, :]
            self._deposit(total, i, j, moment)
        self[peridynamic_stress][...] = total / sizes[:, None, None]

    def _bonds(self) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]]:
        """Intact bonds, each once, a few at a time: their numbers, nodes and neighbors."""
        offsets, neighbors = self.part.bonds.as_rows()
        holds = self[intact] if intact in self.reads else None
        widest = int(np.diff(offsets).max(initial=1)) or 1
        step = max(AT_ONCE // widest, 1)
        for first in range(0, len(self.part), step):
            last = min(first + step, len(self.part))
            bonds = np.arange(offsets[first], offsets[last])
            i = np.repeat(np.arange(first, last), np.diff(offsets[first : last + 1]))
            j = neighbors[bonds].astype(np.int64)
            once = (i < j) if holds is None else (i < j) & (holds[bonds] != 0)
            yield bonds[once], i[once], j[once]


class _Pull:
    """The pairwise force of bonds, with their volume fractions and stiffness factors, N/m^6.

    Args:
        measure: whose contract names what the force reads.
        force: attached.
    """

    def __init__(self, measure: PeridynamicStress, force: PairwiseForce) -> None:
        recipe = force.recipe()
        self._force, self._arguments, self._recipe = force, recipe.law_arguments, recipe
        self._law = elementwise(recipe.law)
        self._refresh, self._instead = force.present()
        self._fraction = measure[volume_fraction] if recipe.fraction else None
        self._arrays: dict[Any, NDArray[Any]] = {
            a.field: self._instead[a.field][0] if a.field in self._instead else measure[a.field]
            for a in self._arguments
            if a.field is not None
        }

    def refresh(self) -> None:
        """Sees to what depends on the displacement of all nodes."""
        self._refresh(*self._force.now)

    def __call__(self, bonds: Numbers, i: Numbers, j: Numbers, xi: Any, eta: Any) -> NDArray[np.float64]:
        """(k, d) forces on nodes i."""
        rest, d = np.linalg.norm(xi, axis=1), xi if self._recipe.linear else xi + eta
        length = np.linalg.norm(d, axis=1)
        # exact for small displacements
        stretch = np.einsum("bk,bk->b", eta, xi + d) / ((length + rest) * rest)
        weight = np.ones_like(rest) if self._fraction is None else self._fraction[bonds].astype(np.float64)
        if self._recipe.surface:
            ends = self._force.end_factors()
            weight *= factors_between(self._recipe.surface, ends[i] + ends[j], xi / rest[:, None])
        pull = self._law_of(bonds, i, j, rest, stretch)
        return np.asarray((pull * weight / length)[:, None] * d)

    def _law_of(self, bonds: Numbers, i: Numbers, j: Numbers, rest: Any, stretch: Any) -> Any:
        length = (1.0 + stretch) * rest
        known = {"stretch": stretch, "extension": stretch * rest, "length": length, "reference_length": rest}
        known |= dict(zip(("time", "dt"), self._force.now, strict=True))
        values = []
        for a in self._arguments:
            if a.field is None:
                values.append(a.value if a.kind == "parameter" else known[a.name])
            else:
                place = bonds if a.kind == "bond" else i if a.name.endswith("_i") else j
                values.append(self._arrays[a.field][place].astype(np.float64))
        return self._law(*values)


@cache
def elementwise(law: Callable[..., Any]) -> Callable[..., Any]:
    """A law that takes arrays."""
    if getattr(numba.config, "DISABLE_JIT", False):
        return np.vectorize(law, otypes=[float])
    return numba.vectorize(compilable(law))


def grid_cells(part: Part) -> Deposit:
    """Shares the moments of bonds between nodes of a grid among the cells that they pass."""
    assert part.spacing is not None
    index = np.rint((part.positions - part.positions.min(axis=0)) / part.spacing).astype(np.int64)
    margin = round(part.bonds.horizon / part.spacing) + 1  # a code then names one step only
    width = index.max(axis=0) + 1 + 2 * margin
    strides = np.cumprod([1, *width[:-1]])
    code = (index + margin) @ strides
    nodes = np.full(int(np.prod(width)), -1)
    nodes[code] = np.arange(len(index))

    def deposit(total: NDArray[np.float64], i: Numbers, j: Numbers, moments: NDArray[np.float64]) -> None:
        steps, starts, group = np.unique(code[j] - code[i], return_index=True, return_inverse=True)
        order = np.argsort(group, kind="stable")
        edges = np.searchsorted(group[order], np.arange(len(steps) + 1))
        for k, start in enumerate(starts):
            chosen = order[edges[k] : edges[k + 1]]
            begins, values = code[i[chosen]], moments[chosen]
            for shift, share in passed(tuple((index[j[start]] - index[i[start]]).tolist())):
                cells = nodes[begins + shift @ strides]
                there = cells >= 0
                # bonds of one step begin at different nodes: no cell comes twice
                total[cells[there]] += share * values[there]

    return deposit


@cache
def passed(step: tuple[int, ...]) -> list[tuple[NDArray[np.int64], float]]:
    """Cells that a straight line passes from the center of one to that of another, as steps; shares of its length."""
    cuts = {0.0, 1.0}
    for size in step:
        cuts |= {(k + 0.5) / abs(size) for k in range(abs(size))}
    edges = np.array(sorted(cuts))
    edges = edges[np.concatenate([[True], np.diff(edges) > 1e-12])]
    middles = 0.5 * (edges[1:] + edges[:-1])
    cells = np.rint(middles[:, None] * np.array(step)).astype(np.int64)
    return list(zip(cells, np.diff(edges).tolist(), strict=True))


def nearest_cells(part: Part) -> Deposit:
    """The same for other nodes: a place belongs to the nearest node."""
    tree = cKDTree(part.positions)

    def deposit(total: NDArray[np.float64], i: Numbers, j: Numbers, moments: NDArray[np.float64]) -> None:
        start, end = part.positions[i], part.positions[j]
        for k in range(SAMPLES):
            nearest = tree.query(start + (k + 0.5) / SAMPLES * (end - start))[1]
            np.add.at(total, nearest, moments / SAMPLES)

    return deposit
