"""Strain of families, from the shape tensor."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from rbs_core import BadInput, Part, Trigger, always
from rbs_core.relation import Fields
from rbs_core.trigger import Clock
from rbs_plugins.constitutive.influence import Influence
from rbs_plugins.fields import deformation_gradient, singular_families, strain
from rbs_plugins.measures.family import DisplacementGradient, FamilyMeasure

KINDS = ("small", "Green-Lagrange")


class Strain(FamilyMeasure):
    """Strain of each family, from F = [Σ ω Y⊗ξ β V] K⁻¹ with the shape tensor K = Σ ω ξ⊗ξ β V over intact bonds.

    Args:
        part: connected part.
        kind: "small" (default), ε = sym(F) − I, or "Green-Lagrange", E = ½(FᵀF − I).
        influence: ω, a plain function or the name of one, see Dilatation.
        partial_volume: as of PairwiseForce; None (default) for the volume fractions that the bonds have, if any.
        when: trigger.

    Raises:
        BadInput: on an unknown kind, or a part that is not connected.

    F is that of Silling et al. (2007), their correspondence of states and tensors; it is offered as
    `deformation_gradient`. Both are exact in an affine deformation, also at surfaces and beside cracks. The small
    strain of a rotated body is not zero, the other one is.
    Where the bonds of a node do not span the space (bonds in nearly one plane, or along one line: det K is not above
    1e-3 in 2-D, 1e-4 in 3-D of (tr K / d)^d, as in Correspondence), there is no F: the strain is zero there, F the
    identity, and `singular_families` counts such nodes.
    """

    example: ClassVar[Any] = {}
    writes = (strain, singular_families)
    offers = (deformation_gradient,)

    def __init__(
        self,
        part: Part,
        kind: str = "small",
        *,
        influence: Influence | str = "constant",
        partial_volume: str | None = None,
        when: Trigger = always,
    ) -> None:
        super().__init__(part, influence, partial_volume=partial_volume, when=when)
        if kind not in KINDS:
            raise BadInput(f"{self.label}: kind={kind!r} must be one of {', '.join(KINDS)}")
        self.kind = kind

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """Displacement, nodes and bonds."""
        return self.of_family

    def attach(self) -> None:
        self._gradient = DisplacementGradient(self)

    def apply(self, clock: Clock) -> None:
        if self.outdated_bonds:
            self.attach()
        moved = self._gradient.find(clock.time, clock.dt)
        turned = np.swapaxes(moved, 1, 2)
        found = moved + turned
        if self.kind == "Green-Lagrange":
            found += np.matmul(turned, moved)
        self[strain][...] = 0.5 * found
        self[singular_families][...] = self._gradient.singular
        if self.wants(deformation_gradient):
            self[deformation_gradient][...] = moved + np.eye(self.part.dimension)

    @property
    def nbytes(self) -> int:
        """What the sums keep."""
        return self._gradient.nbytes if hasattr(self, "_gradient") else 0
