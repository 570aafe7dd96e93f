"""Collapsed stress: the first moments of force states."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Field, Part, Trigger, always
from rbs_core.relation import Fields
from rbs_core.trigger import Clock
from rbs_plugins.constitutive.bond_based import BondBased
from rbs_plugins.constitutive.bonded import precision_of, unbreaking
from rbs_plugins.constitutive.influence import Influence
from rbs_plugins.constitutive.pairwise import PairwiseForce
from rbs_plugins.fields import stress, volume
from rbs_plugins.measures.family import DisplacementGradient, FamilyMeasure, checked_forces
from rbs_plugins.measures.places import place_for

KINDS = ("first Piola-Kirchhoff", "Cauchy")


class Stress(FamilyMeasure):
    """Collapsed stress of each node: ν = Σ_j T⟨ξ⟩⊗ξ β V_j over intact bonds, T = t d/|d| the force state of the node.

    Args:
        part: connected part.
        forces: the constitutive relations whose bonds carry the stress, all on the bonds of this part.
        kind: "first Piola-Kirchhoff" (default), ν itself, N per reference area, first index of the force; or "Cauchy",
            σ = ν Fᵀ / det F with the F of Strain. In 2-D det F is that of the plane: σ is then per present length of
            the plane and reference thickness.
        influence: ω of F, for "Cauchy".
        partial_volume: of F, as of Strain.
        field: where to write it; another tensor field of nodes if there are several stresses.
        when: trigger.

    Attributes:
        singular: for "Cauchy", how many nodes had a singular F at the last look, see Strain.

    Raises:
        BadInput: on an unknown kind, or forces that are not on the bonds of the part.

    A pair force f gives either end t = f/2; the ordinary state-based solid each end its own t. In a uniform deformation
    of a body without surface ν is the first Piola-Kirchhoff stress (Silling et al. 2007; Lehoucq & Silling 2008), and
    equals the peridynamic stress tensor. It is smaller within a horizon of surfaces and cracks, whose nodes have fewer
    bonds. Collapsed and Cauchy stress follow Sarego (2016, eqs. 4.10 and 4.13); where F is singular (see Strain) F
    counts as the identity.
    """

    @staticmethod
    def example(part: Part) -> dict[str, Any]:
        """The stress of a linear material."""
        return {"forces": [BondBased(part, E=1e9)], "kind": "Cauchy"}

    def __init__(
        self,
        part: Part,
        forces: PairwiseForce | Sequence[PairwiseForce],
        kind: str = "first Piola-Kirchhoff",
        *,
        influence: Influence | str = "constant",
        partial_volume: str | None = None,
        field: Field = stress,
        when: Trigger = always,
    ) -> None:
        super().__init__(part, influence, partial_volume=partial_volume, when=when)
        if kind not in KINDS:
            raise BadInput(f"{self.label}: kind={kind!r} must be one of {', '.join(KINDS)}")
        self.kind = kind
        self._forces = checked_forces(self.label, part, forces)
        self._turned = kind == "Cauchy"
        self.singular = 0
        self.field = place_for(self.label, field, stress)
        self.writes = (field,)

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """What the forces read, the state of their bonds, and what F needs."""
        return tuple(dict.fromkeys([volume, *self.of_forces(self._forces), *(self.of_family if self._turned else ())]))

    def begin(self, clock: Clock) -> None:
        self._moments = [Moment(force) for force in self._forces]
        self._gradient = DisplacementGradient(self) if self._turned else None
        self._made = self.part.version

    def apply(self, clock: Clock) -> None:
        if self._made != self.part.version:
            self.begin(clock)
        total = np.zeros(self[self.field].shape)
        for moment in self._moments:
            total += moment.find()
        if self._gradient is not None:
            deformed = self._gradient.find(clock.time, clock.dt) + np.eye(self.part.dimension)
            volumes = np.linalg.det(deformed)[:, None, None]
            total = np.matmul(total, np.swapaxes(deformed, 1, 2)) / np.where(volumes == 0, 1.0, volumes)
            self.singular = self._gradient.singular
        self[self.field][...] = total

    def items(self) -> int:
        return sum(force.items() for force in self._forces)


class Moment:
    """Σ T⊗ξ β V of one force, of the present displacement.

    Args:
        force: attached, in the list of relations.

    Raises:
        BadInput: if it is not in the list.
    """

    def __init__(self, force: PairwiseForce) -> None:
        part, self._force = force.part, force
        require_listed(force)
        law, arguments, self._factor = force.force_state()
        self._out = np.zeros((len(part), part.dimension, part.dimension), precision_of(part))
        self._refresh, instead = force.present()
        recipe = unbreaking(force.recipe(), sums="moment", law=law, law_arguments=arguments)
        self._loops = force.make_loops(recipe, {"out": [self._out]}, False, instead)

    def find(self) -> NDArray[np.float64]:
        """(n, d, d), Pa."""
        self._refresh(*self._force.now)
        self._out.fill(0.0)
        self._loops.begin()
        self._loops.add(*self._force.now)
        return self._factor * self._out.astype(np.float64)


def require_listed(force: PairwiseForce) -> None:
    """Raises BadInput if a force is not part of the scene."""
    if not hasattr(force, "_loops"):
        raise BadInput(f"{force.label} is asked for its stress and is not in the list of relations: list it")
