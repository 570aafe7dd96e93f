"""OrdinaryStateBased: the linear peridynamic solid, with any Poisson's ratio."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core import BadInput, Field, Part, Trigger, always
from rbs_core.part import Connection
from rbs_plugins.constitutive.bond_based import plane_of
from rbs_plugins.constitutive.bonded import Arrays, BondLoops, precision_of, require_bonds, unbreaking
from rbs_plugins.constitutive.dilatation import Dilatation, PresentDilatation
from rbs_plugins.constitutive.fracture import Criterion
from rbs_plugins.constitutive.influence import Influence, influence_at
from rbs_plugins.constitutive.linear_solid import (
    beyond,
    beyond_in_tension,
    constants,
    freed,
    held,
    linear_solid,
    moduli,
    of_one_material,
    own_pull,
    stiffest,
)
from rbs_plugins.constitutive.pairwise import PairwiseForce
from rbs_plugins.constitutive.separation import fracture_energy_of_unit_stretch
from rbs_plugins.fields import deviatoric_modulus, dilatation, dilatational_modulus
from rbs_plugins.loops.arguments import Argument, resolve
from rbs_plugins.loops.recipe import Recipe
from rbs_plugins.tangents import Tangent
from rbs_plugins.tangents.ordinary import OrdinaryTangent, require_both
from rbs_plugins.tangents.pairwise import SpringTangent


class OrdinaryStateBased(PairwiseForce):
    """Linear peridynamic solid (Silling et al. 2007), brittle if a criterion is given.

    Args:
        part: connected part, or a connection of two parts that have such solids.
        E: Young's modulus, Pa; a number, or one for each node (n,).
        nu: Poisson's ratio between −1 and 1/2; a number, or one for each node. Not for 1-D parts.
        fracture: when bonds fail.
        plane: "stress" (default) or "strain", 2-D parts only.
        influence: ω, see Dilatation.
        weighted_volume: "initial", "intact" or "full", see Dilatation.
        partial_volume: as of PairwiseForce.
        linear: small displacements, see PairwiseForce: the linearised solid.
        between: the solids of the two parts, for a connection; it has no constants of its own.
        active: as of PairwiseForce.
        when: trigger.
        **parameters: numbers that the criterion asks for.

    Attributes:
        dilatation: the relation that sums the dilatation; it runs in front of the forces (`feeders`).
        E, nu: as given, (n,) or numbers.

    Raises:
        BadInput: on constants that no stable solid has, naming the node; on a connection without `between`.

    The force density is L_i = Σ_j μ β (t_i + t_j) V_j d/|d| with t_i = ω (κ ϑ_i |ξ| + α m e)/m_i; in 3-D κ = 3K − 5μ
    and α m = 15μ, the same as t = 3Kθ/m ω|ξ| + α ω e^d. Each node gives a bond the share of its own material. Where κ
    is zero (1-D, and the Poisson's ratio of a bond-based material) nobody needs the dilatation, and it is not computed.
    """

    holds_beyond = {"tension": beyond_in_tension, "both": beyond}

    @staticmethod
    def example(part: Part) -> dict[str, Any]:
        """A material that no pair force makes; a bar has no Poisson's ratio."""
        return {"E": 1e9} if part.dimension == 1 else {"E": 1e9, "nu": 0.2}

    def __init__(
        self,
        part: Part | Connection,
        E: ArrayLike | None = None,
        nu: ArrayLike | None = None,
        fracture: Criterion | None = None,
        *,
        plane: str | None = None,
        influence: Influence | str = "constant",
        weighted_volume: str = "initial",
        partial_volume: str = "none",
        linear: bool = False,
        between: Sequence[OrdinaryStateBased] = (),
        active: bool | None = None,
        when: Trigger = always,
        **parameters: float,
    ) -> None:
        name = type(self).__name__
        require_bonds(name, part)
        self.case = plane_of(name, part, plane)
        self._between = _solids(name, part, between, E, nu)
        if not self._between:
            self.E, self.nu = constants(name, self.case, part, E, nu)
            self.gamma, self.pull = moduli(self.case, self.E, self.nu)
        self.dilatation: Dilatation = Dilatation(
            part, influence, weighted_volume=weighted_volume, partial_volume=partial_volume, linear=linear,
            within=[each.dilatation for each in self._between], when=when,
        )  # fmt: skip
        self._fixed = {**self._moduli(part), **self.dilatation.given}
        law = of_one_material if "deviatoric_modulus_i" in self._fixed else linear_solid
        numbers: dict[str, Any] = {**self._fixed, **parameters}
        super().__init__(
            part, law, fracture, potential=held, partial_volume=partial_volume, linear=linear, active=active, when=when,
            **numbers,
        )  # fmt: skip
        self.feeders = (*((self.dilatation,) if self.path_dependent else ()), *self.feeders)

    # -- constants --------------------------------------------------------------------------------------------------

    @property
    def solids(self) -> tuple[OrdinaryStateBased, ...]:
        """Whose constants the nodes have: itself, or the solids of the parts that a connection joins."""
        return self._between or (self,)

    def _moduli(self, host: Part | Connection) -> dict[str, float]:
        """The moduli as numbers if they are the same everywhere; otherwise they become fields of the parts."""
        fields = {
            dilatational_modulus: [s.gamma / host.dimension for s in self.solids],
            deviatoric_modulus: [s.pull for s in self.solids],
        }
        distinct = {field: np.unique(np.concatenate([np.ravel(v) for v in values])) for field, values in fields.items()}
        given = {}
        if all(len(each) == 1 for each in distinct.values()):
            given = {f"{field.name}_{end}": float(each[0]) for field, each in distinct.items() for end in "ij"}
        else:
            for field, values in fields.items():
                for end, value in zip(host.ends if isinstance(host, Connection) else [host], values, strict=True):
                    end[field] = value
        if not distinct[dilatational_modulus].any():
            given |= {"dilatation_i": 0.0, "dilatation_j": 0.0}
        return given

    @property
    def path_dependent(self) -> bool:  # type: ignore[override]
        """True if bonds feel the dilatation, which goes back when others break."""
        return "dilatation_i" not in self._fixed

    def critical_stretch(self, fracture_energy: float) -> float:
        """Critical stretch for a fracture energy G0, J/m^2, by the work of pulling a body apart along a plane.

        Of a whole family, see `fracture_energy_of_unit_stretch`. For a bond-based Poisson's ratio and ω = δ/|ξ| it is
        that of BondBased.
        """
        first = self.solids[0]
        if any(np.ndim(s.E) or np.ndim(s.nu) or (s.E, s.nu) != (first.E, first.nu) for s in self.solids):
            raise BadInput(f"{self.label}: nodes of several materials have no common critical stretch: give s0 instead")
        horizon, part = self.host.bonds.horizon, self.part
        omega = influence_at(self.dilatation.influence, horizon, part.spacing, self.label)
        across = part.thickness or part.area or 1.0
        unit = fracture_energy_of_unit_stretch(
            part.dimension, horizon, across, omega, float(first.gamma), float(first.pull)
        )
        return float(np.sqrt(fracture_energy / unit))

    # -- loops ------------------------------------------------------------------------------------------------------

    def attach(self) -> None:
        if not self.path_dependent and isinstance(self.host, Part):
            self.dilatation.weigh()  # nobody runs it
        super().attach()

    def recipe(self) -> Recipe:
        recipe = super().recipe()
        scales = ("inverse_weighted_volume", "influence", "dilatational_modulus", "deviatoric_modulus")
        return replace(
            recipe, freed=freed if self.recording else None, still=("dilatation",), scales=(*recipe.scales, *scales)
        )

    @property
    def proportional(self) -> bool:
        return True

    def tangent(self) -> Tangent:
        if isinstance(self.host, Connection):
            require_both(self.host, self.label)
        elif self.path_dependent:
            return OrdinaryTangent(self)
        return SpringTangent(self)

    def force_state(self) -> tuple[Callable[..., Any], tuple[Argument, ...], float]:
        """The scalar force state t of a node, by its own material and dilatation."""
        return own_pull, tuple(resolve(own_pull, self.host, self._fixed)), 1.0

    def present(self) -> tuple[Callable[[float, float], None], dict[Field, Arrays]]:
        if not self.path_dependent:
            return super().present()
        found = PresentDilatation(self._scene, self.ends)
        return found.refresh, {dilatation: found.arrays}

    def energy_loops(self) -> BondLoops:
        """Loops with dilatations of their own: those of the present displacement, whenever somebody asks."""
        self._refresh, arrays = self.present()
        recipe = replace(super().recipe(), dissipation=False)  # only the force breaks bonds
        loops = self.make_loops(recipe, {"out": self._unused()}, instead=arrays)
        loops.begin()
        return loops

    def energy(self, out: NDArray[np.float64], part: Part | None = None) -> None:
        self._loops_of_energy()
        self._refresh(*self._now)
        super().energy(out, part)

    def _unused(self) -> list[NDArray[Any]]:
        """Room for forces that nobody asks for."""
        return [np.zeros((len(end), end.dimension), precision_of(end)) for end in self.ends]

    def stiffness_bounds(self) -> dict[Part, NDArray[np.float64]]:
        """Bound of the stiffness at each node, N/m^4, from bonds that are at least as stiff.

        γ S²/m² <= max(γ, 0)/m Σ ω e² V by Cauchy and Schwarz, so springs with α m + max(γ, 0) in place of α m hold more
        energy than the solid in any displacement; the bound is theirs.
        """
        bounds = [s.pull + np.maximum(s.gamma, 0.0) for s in self.solids]
        uniform = "deviatoric_modulus_i" in self._fixed
        numbers = {f"deviatoric_modulus_{end}": float(np.max(bounds[0])) for end in "ij"} if uniform else {}
        arguments = resolve(stiffest, self.host, {**self.dilatation.given, **numbers})
        recipe = unbreaking(self.recipe(), sums="total", law=stiffest, law_arguments=tuple(arguments), intact=False)
        sums = [np.zeros(len(end), precision_of(end)) for end in self.ends]
        arrays = [
            np.broadcast_to(b, (len(end),)).astype(precision_of(end)) for b, end in zip(bounds, self.ends, strict=True)
        ]
        loops = self.make_loops(recipe, {"out": sums}, False, {} if uniform else {deviatoric_modulus: arrays})
        loops.begin()
        loops.add(0.0, 0.0)
        return {end: 2.0 * total for end, total in zip(self.ends, sums, strict=True)}


def _solids(
    name: str, host: Part | Connection, between: Sequence[OrdinaryStateBased], E: Any, nu: Any
) -> tuple[OrdinaryStateBased, ...]:
    """The solids of the ends of a connection, in their order; nothing for a part."""
    if isinstance(host, Part):
        if between:
            raise BadInput(f"{name} '{host.name}': between= is for connections")
        return ()
    found = [each for end in host.ends for each in between if each.host is end]
    if len(found) != len(host.ends) or len(found) != len(between) or E is not None or nu is not None:
        raise BadInput(
            f"{name} '{host.name}': a connection takes its constants from the solids of its parts: give between=, one "
            f"each of {' and '.join(repr(end.name) for end in host.ends)}, and neither E nor nu"
        )
    return tuple(found)
