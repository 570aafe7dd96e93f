"""PairwiseForce: bonds that pull with any plain function of their stretch, length and the fields at their ends."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, BadLaw, Part, Trigger, always
from rbs_core.part import Connection, Lattice
from rbs_core.relation import Fields
from rbs_plugins.constitutive.bond_force import BondForce
from rbs_plugins.constitutive.corrections import set_partial_volume
from rbs_plugins.constitutive.fracture import Criterion
from rbs_plugins.constitutive.surface import SurfaceCorrection
from rbs_plugins.fields import (
    breakable,
    displacement,
    dissipation_density,
    force_density,
    intact,
    reference_position,
    volume,
    volume_fraction,
)
from rbs_plugins.loops.arguments import Argument, fields, resolve
from rbs_plugins.loops.recipe import Recipe
from rbs_plugins.tangents.pairwise import pulls_alike


def hardening(stretch, c):
    """A bond that gets stiffer as it is stretched: the law of the example."""
    return c * stretch * (1.0 + stretch * stretch)


class PairwiseForce(BondForce):
    """Bonds whose pairwise force f (N/m^6) along the deformed bond is a plain function.

    Args:
        part: connected part, or a connection of two parts: its bonds act on the nodes of both.
        law: function returning f from what its argument names ask for: stretch, extension, length, reference_length,
            time, dt; parameters given here as keywords; bond fields; node fields with _i or _j behind. Both ends of a
            bond must get the same value, or momentum is not kept.
        fracture: when bonds fail; never if not given.
        potential: energy w(...) of a bond, J/m^6, with dw/d(length) = law; integrated numerically if not given (8
            panels of 5 Gauss points: exact for smooth laws, off by up to 1e-3 of the energy behind a kink).
        slope: d law / d stretch, for tangents; by differences if not given, off by 1e-10 of it, more near a kink.
        partial_volume: "none", "linear" for the linear band at the edge of the horizon, or "exact" for the share of
            each cell that lies within.
        surface_correction: "none", "volume", "force density" or "energy": a factor λ of bonds near surfaces, see
            SurfaceCorrection.
        linear: True for small displacements: the extension is η·ξ/|ξ| with η = u_j − u_i, and forces act along ξ. A
            rotation then stretches bonds, in second order.
        active: True skips nodes that nothing has reached yet, which changes no result: for bonds stored as lattice, and
            laws that are zero at rest; None (default) does so wherever it can be done, False never.
        when: trigger.
        **parameters: numbers that law, criterion and potential ask for.

    Raises:
        BadLaw: if an argument name is unknown, or (at the start of the run) if a function cannot be compiled.
        BadInput: if the part is not connected, on an unknown name of a partial volume or a surface correction, or a
            parameter that no function asks for.

    The force density is L_i = Σ_j μ λ f β V_j d/|d| with d = y_j − y_i (Silling 2000; Silling & Askari 2005).
    """

    adds: Fields = (force_density,)
    own_parameters: ClassVar[tuple[str, ...]] = ()  # computed by a subclass for laws that want them
    # functions that are true if the bond holds more than w0 at present, by the modes of CriticalBondEnergy
    holds_beyond: ClassVar[dict[str, Callable[..., Any]] | None] = None
    path_dependent = True  # whether what a bond takes until it fails may differ from what it holds then
    example: ClassVar[Any] = {"law": hardening, "c": 1e18}

    def __init__(
        self,
        part: Part | Connection,
        law: Callable[..., Any],
        fracture: Criterion | None = None,
        *,
        potential: Callable[..., Any] | None = None,
        slope: Callable[..., Any] | None = None,
        partial_volume: str = "none",
        surface_correction: str = "none",
        linear: bool = False,
        active: bool | None = None,
        when: Trigger = always,
        **parameters: float,
    ) -> None:
        super().__init__(part, linear=linear, active=active, when=when)
        if not callable(law):
            raise BadLaw(f"{self.label}: the law must be a function, got {law!r}")
        if fracture is not None and not isinstance(fracture, Criterion):
            raise BadInput(f"{self.label}: fracture={fracture!r} must be a criterion such as CriticalStretch(0.01)")
        self.adds = self.at_nodes(force_density)
        self._law, self._fracture, self._potential, self._slope = law, fracture, potential, slope
        self._fraction = set_partial_volume(part, partial_volume)
        limits = {} if fracture is None else fracture.parameters(self)
        self._fails = None if fracture is None else fracture.function_for(self)
        for name in limits.keys() & parameters.keys():
            if limits[name] != parameters[name]:
                raise BadLaw(f"{self.label}: law and criterion both have a parameter {name}, with different values")
        values = {**parameters, **limits}
        self._law_arguments = tuple(resolve(law, part, values))
        self._criterion_arguments = () if self._fails is None else tuple(resolve(self._fails, part, values))
        self._potential_arguments = () if potential is None else tuple(resolve(potential, part, values))
        self._slope_arguments = () if slope is None else tuple(resolve(slope, part, values))
        self._check_asked(parameters)
        self.surface = SurfaceCorrection(surface_correction, part, partial_volume, law, self._law_arguments)
        if fracture is not None:
            fracture.mark(self)
        self.feeders = () if fracture is None else fracture.feeders(self)

    @property
    def _arguments(self) -> tuple[Argument, ...]:
        """What all functions ask for."""
        return (*self._law_arguments, *self._criterion_arguments, *self._potential_arguments, *self._slope_arguments)

    def _check_asked(self, parameters: dict[str, float]) -> None:
        """A keyword that no function asks for is a misspelt one."""
        asked = list(dict.fromkeys(argument.name for argument in self._arguments if argument.kind == "parameter"))
        unknown = [name for name in parameters if name not in asked and name not in self.own_parameters]
        if unknown:
            raise BadInput(
                f"{self.label}: nobody asks for {', '.join(unknown)} (law, criterion and potential ask for "
                f"{', '.join(asked) or 'no parameter'}): check the spelling"
            )

    def identity(self) -> dict[str, Any]:
        """The parameters, and what a class may fix: functions, the numbers they ask for, where and how bonds fail."""
        values = {argument.name: argument.value for argument in self._arguments if argument.kind == "parameter"}
        failure = None if self._fracture is None else (self._fails, repr(self._fracture))
        given = {"law": self._law, "potential": self._potential, "failure": failure, "values": values}
        return {**self.parameters, **given}

    # -- contract ---------------------------------------------------------------------------------------------------

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """Displacement, nodes, bonds, and whatever the functions ask for."""
        asked = fields(self._arguments)
        more = [*([volume_fraction] if self._fraction else []), *([breakable] if self._zoned else [])]
        if self._fracture is None and self.may_have_broken:
            more.append(intact)
        return tuple(dict.fromkeys(self.asked(displacement, reference_position, volume, *more, *asked)))

    @property
    def updates(self) -> Fields:  # type: ignore[override]
        """The state of the bonds, if they can fail."""
        return () if self._fracture is None else self.at_bonds(intact)

    @property
    def offers(self) -> Fields:  # type: ignore[override]
        """The energy of failing bonds."""
        return () if self._fracture is None else self.at_nodes(dissipation_density)

    @property
    def storages(self) -> tuple[str, ...]:  # type: ignore[override]
        """The list always; the lattice unless a law asks for a bond field that differs from bond to bond."""
        stored = self.host.bonds.stored
        asked = [a.field for a in self._arguments]
        bonds = [field for field in asked if field is not None and field.at == "bond"]
        if isinstance(stored, Lattice) and any(stored.fields.raw(field).ndim != 1 for field in bonds):
            return ("list",)
        return ("list",) if any(self.is_changed(field) for field in bonds) else ("list", "lattice")

    @property
    def fracture(self) -> Criterion | None:
        """When bonds fail."""
        return self._fracture

    @property
    def _zoned(self) -> bool:
        return self._fracture is not None and self._fracture.within is not None

    @property
    def recording(self) -> bool:
        """True if somebody wants to know the energy of the bonds that fail here."""
        return self._fracture is not None and any(self.wants((end, dissipation_density)) for end in self.ends)

    def critical_stretch(self, fracture_energy: float) -> float:
        """Critical stretch for a fracture energy G0, J/m^2; only models with known constants can tell."""
        raise BadInput(f"{self.label} does not know how the fracture energy gives a critical stretch: give s0 instead")

    # -- loops ------------------------------------------------------------------------------------------------------

    def recipe(self) -> Recipe:
        """What the loops compute."""
        return Recipe(
            law=self._law,
            law_arguments=self._law_arguments,
            criterion=self._fails,
            criterion_arguments=self._criterion_arguments,
            potential=self._potential,
            potential_arguments=self._potential_arguments,
            slope=self._slope,
            slope_arguments=self._slope_arguments,
            intact=self._fracture is not None or self.may_have_broken,
            breakable=self._zoned,
            fraction=self._fraction,
            surface=self.surface.kind,
            uniform=self.uniform(volume) is not None,
            dissipation=self.recording,
            scales=() if self._fracture is None else self._fracture.scales,
            linear=self.linear,
            late=self._fracture is not None and self._fracture.release == "next step",
            **self.processor(),
        )

    def end_factors(self) -> NDArray[np.float64]:
        return self.surface.factors

    @property
    def nbytes(self) -> int:
        """Positions of the last forces, and the factors of the surface."""
        return super().nbytes + (self.surface.nbytes if hasattr(self, "_loops") else 0)

    @property
    def follows_potential(self) -> bool:
        return super().follows_potential and pulls_alike(self._law, self._law_arguments)

    def force_state(self) -> tuple[Callable[..., Any], tuple[Argument, ...], float]:
        """The scalar force state t of a node: function, its arguments and a factor; here half of the pairwise force."""
        return self._law, self._law_arguments, 0.5
