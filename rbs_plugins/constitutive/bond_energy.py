"""Energies of bonds as fields: the work that each has taken, and what a mean bond of a node holds."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from rbs_core import BadInput, Field, Measure, Part, Relation, Trigger, always
from rbs_core.relation import Fields, Key
from rbs_core.trigger import Clock
from rbs_plugins.constitutive.bonded import BondRelation
from rbs_plugins.fields import (
    bond_energy,
    bond_extension,
    bond_force,
    displacement,
    mean_bond_energy,
    reference_position,
    volume,
)
from rbs_plugins.loops.arguments import fields
from rbs_plugins.loops.recipe import Recipe

if TYPE_CHECKING:
    from rbs_plugins.constitutive.pairwise import PairwiseForce


def one():
    """A bond counts once."""
    return 1.0


def _springs(part: Part) -> dict[str, Any]:
    """The example of both relations."""
    from rbs_plugins.constitutive.bond_based import BondBased

    return {"force": BondBased(part, E=1e9)}


class BondEnergy(BondRelation):
    """Work that the force of each bond has taken since the start, w = ∫ f dℓ, J/m^6, by the trapezoidal rule.

    Args:
        part: connected part.
        force: the constitutive relation whose bonds these are.
        when: trigger.

    Raises:
        BadInput: if the force belongs to another part; at the start, if another BondEnergy has these bonds.

    Stands between drift and force, with the dilatations of the force in front of it; as a feeder of its criterion it
    does so by itself. For a state-based solid f = t_i + t_j, so dw = (T[x]⟨ξ⟩ − T[p]⟨−ξ⟩)·dη (Foster, Silling & Chen
    2011, in the form of Sarego 2016, eq. 1.101). Bonds that are broken go on: what they would have taken means nothing.
    """

    role = "measure"
    storages = ("list",)
    updates: Fields = (bond_energy, bond_force, bond_extension)
    example = staticmethod(_springs)

    def __init__(self, part: Part, force: PairwiseForce, *, when: Trigger = always) -> None:
        super().__init__(part, when=when)
        if force.host is not part:
            raise BadInput(f"{self.label}: {force.label} belongs to another part")
        self.force = force

    @property
    def feeders(self) -> tuple[Relation, ...]:  # type: ignore[override]
        """Those of the force."""
        return tuple(each for each in self.force.feeders if not isinstance(each, BondEnergy))

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """What the law asks for."""
        asked = fields(self.force._law_arguments)
        return tuple(dict.fromkeys(self.asked(displacement, reference_position, volume, *asked)))

    def attach(self) -> None:
        others = [each for each in self._scene if isinstance(each, BondEnergy) and each is not self]
        if any(each.host is self.host for each in others):
            raise BadInput(
                f"{self.label}: the bonds of a part can take the work of one force, and {others[0]!r} has it"
            )
        law = self.force.recipe()
        recipe = Recipe(
            law=law.law,
            law_arguments=law.law_arguments,
            sums="work",
            uniform=law.uniform,
            linear=law.linear,
            **self.processor(),
        )
        self._loops = self.make_loops(recipe, {"out": [np.zeros((len(self.part), self.part.dimension))]})

    def begin(self, clock: Clock) -> None:
        self._loops.begin()

    def apply(self, clock: Clock) -> None:
        self._loops.add(clock.time, clock.dt)

    @property
    def nbytes(self) -> int:
        """What the loops keep."""
        return self._loops.nbytes if hasattr(self, "_loops") else 0

    def items(self) -> int:
        return len(self.host.bonds)


class MeanBondEnergy(Measure):
    """Energy that a mean bond of each node holds: w = 2W / Σ β V, J/m^6, W the strain energy density of one force.

    Args:
        part: connected part.
        force: the constitutive relation whose bonds hold the energy.
        when: trigger.

    Raises:
        BadInput: if the force belongs to another part.

    The sum is over the family as it was connected, broken bonds among it. W is that of the present displacement.
    """

    writes = (mean_bond_energy,)
    storages = ("list", "lattice")
    example = staticmethod(_springs)

    def __init__(self, part: Part, force: PairwiseForce, *, when: Trigger = always) -> None:
        super().__init__(part, when=when)
        if force.host is not part:
            raise BadInput(f"{self.label}: {force.label} belongs to another part")
        self.force = force

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """What the force reads, and the state of its bonds."""
        looked_at: list[Field | Key] = [volume, displacement, *self.force.reads, *self.force.updates]
        return tuple(each for each in dict.fromkeys(looked_at) if each != mean_bond_energy)

    def attach(self) -> None:
        self._shares: Any = None

    def begin(self, clock: Clock) -> None:
        self.force.compile_energy(self[mean_bond_energy])
        self._shares = 2.0 / np.maximum(self._families(), np.finfo(float).tiny)

    def _families(self) -> Any:
        """Σ β V of the families (n,), m^3."""
        sums = np.zeros(len(self.part), self[mean_bond_energy].dtype)
        law = self.force.recipe()
        recipe = replace(
            law, law=one, law_arguments=(), criterion=None, criterion_arguments=(), potential=None,
            potential_arguments=(), surface="", intact=False, breakable=False, dissipation=False, late=False,
            sums="total",
        )  # fmt: skip
        loops = self.force.make_loops(recipe, {"out": [sums]}, False)
        loops.begin()
        loops.add(0.0, 0.0)
        return sums.astype(np.float64)

    def apply(self, clock: Clock) -> None:
        out = self[mean_bond_energy]
        out[...] = 0.0
        self.force.energy(out, self.part)
        out *= self._shares

    def items(self) -> int:
        return self.force.items()
