"""PairwiseForce: bonds that pull with any plain function of their stretch, length and the fields at their ends."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Hashable, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, BadLaw, Part, Relation, Trigger, always
from rbs_core.part import Connection, Lattice
from rbs_core.relation import Fields, Key
from rbs_core.trigger import Clock
from rbs_plugins.constitutive.bonded import BondLoops, BondRelation, starts_of
from rbs_plugins.constitutive.corrections import set_partial_volume
from rbs_plugins.constitutive.fracture import Criterion
from rbs_plugins.constitutive.record import check_record
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
from rbs_plugins.loops import BATCH_BELOW
from rbs_plugins.loops.arguments import Argument, fields, resolve
from rbs_plugins.loops.joint import JointLoops
from rbs_plugins.loops.lattice import LatticeLoops
from rbs_plugins.loops.recipe import Recipe


def hardening(stretch, c):
    """A bond that gets stiffer as it is stretched: the law of the example."""
    return c * stretch * (1.0 + stretch * stretch)


class PairwiseForce(BondRelation):
    """Bonds whose pairwise force f (N/m^6) along the deformed bond is a plain function.

    Args:
        part: connected part, or a connection of two parts: its bonds act on the nodes of both.
        law: function returning f from what its argument names ask for: stretch, extension, length, reference_length,
            time, dt; parameters given here as keywords; bond fields; node fields with _i or _j behind. Both ends of a
            bond must get the same value, or momentum is not kept.
        fracture: when bonds fail; never if not given.
        potential: energy w(...) of a bond, J/m^6, with dw/d(length) = law; integrated numerically if not given (8
            panels of 5 Gauss points: exact for smooth laws, off by up to 1e-3 of the energy behind a kink).
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
        partial_volume: str = "none",
        surface_correction: str = "none",
        linear: bool = False,
        active: bool | None = None,
        when: Trigger = always,
        **parameters: float,
    ) -> None:
        super().__init__(part, when=when)
        if not callable(law):
            raise BadLaw(f"{self.label}: the law must be a function, got {law!r}")
        if fracture is not None and not isinstance(fracture, Criterion):
            raise BadInput(f"{self.label}: fracture={fracture!r} must be a criterion such as CriticalStretch(0.01)")
        self.adds = self.at_nodes(force_density)
        self._law, self._fracture, self._potential = law, fracture, potential
        self._active, self._linear = active, linear
        self._warned = False  # of a step that is too large for new bonds
        self._called = False  # whether the loops hold the positions of an earlier force
        self._now = [0.0, 0.0]  # time and dt of the last force
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
        self._check_asked(parameters)
        self.surface = SurfaceCorrection(surface_correction, part, partial_volume, law, self._law_arguments)
        if fracture is not None:
            fracture.mark(self)
        self.feeders = () if fracture is None else fracture.feeders(self)

    def _check_asked(self, parameters: dict[str, float]) -> None:
        """A keyword that no function asks for is a misspelt one."""
        everything = (*self._law_arguments, *self._criterion_arguments, *self._potential_arguments)
        asked = list(dict.fromkeys(argument.name for argument in everything if argument.kind == "parameter"))
        unknown = [name for name in parameters if name not in asked and name not in self.own_parameters]
        if unknown:
            raise BadInput(
                f"{self.label}: nobody asks for {', '.join(unknown)} (law, criterion and potential ask for "
                f"{', '.join(asked) or 'no parameter'}): check the spelling"
            )

    def identity(self) -> dict[str, Any]:
        """The parameters, and what a class may fix: functions, the numbers they ask for, where and how bonds fail."""
        arguments = (*self._law_arguments, *self._criterion_arguments, *self._potential_arguments)
        values = {argument.name: argument.value for argument in arguments if argument.kind == "parameter"}
        failure = None if self._fracture is None else (self._fails, repr(self._fracture))
        given = {"law": self._law, "potential": self._potential, "failure": failure, "values": values}
        return {**self.parameters, **given}

    # -- contract ---------------------------------------------------------------------------------------------------

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """Displacement, nodes, bonds, and whatever the functions ask for."""
        asked = fields([*self._law_arguments, *self._criterion_arguments, *self._potential_arguments])
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
        asked = [a.field for a in (*self._law_arguments, *self._criterion_arguments, *self._potential_arguments)]
        bonds = [field for field in asked if field is not None and field.at == "bond"]
        if isinstance(stored, Lattice) and any(stored.fields.raw(field).ndim != 1 for field in bonds):
            return ("list",)
        return ("list",) if any(self.is_changed(field) for field in bonds) else ("list", "lattice")

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

    def attach(self) -> None:
        check_record(self, [each for each in self._scene if isinstance(each, PairwiseForce)])
        self._energies: BondLoops | None = None  # made for the bonds that there are, when somebody asks
        recipe = self.recipe()
        last = getattr(self, "_loops", None)
        felt = {"out": force_density, **({"dissipation": dissipation_density} if recipe.dissipation else {})}
        self._loops = self.make_loops(recipe, felt, self._active)
        if self._called and last is not None and last.position.shape == self._loops.position.shape:
            self._loops.position[...] = last.position  # a run that goes on in the same process

    def recipe(self) -> Recipe:
        """What the loops compute."""
        return Recipe(
            law=self._law,
            law_arguments=self._law_arguments,
            criterion=self._fails,
            criterion_arguments=self._criterion_arguments,
            potential=self._potential,
            potential_arguments=self._potential_arguments,
            intact=self._fracture is not None or self.may_have_broken,
            breakable=self._zoned,
            fraction=self._fraction,
            surface=self.surface.kind,
            uniform=self.uniform(volume) is not None,
            dissipation=self.recording,
            scales=() if self._fracture is None else self._fracture.scales,
            linear=self._linear,
            late=self._fracture is not None and self._fracture.release == "next step",
            **self.processor(),
        )

    def end_factors(self) -> NDArray[np.float64]:
        return self.surface.factors

    def reset(self) -> None:
        self._called = False

    def begin(self, clock: Clock) -> None:
        self._loops.begin()
        if not self._called:
            self._loops.start()

    def state(self) -> dict[str, Any]:
        """The positions of the last force, where the energy of failing bonds is recorded from them."""
        return {"position": self._loops.position} if self._called and self.recording else {}

    def restore(self, state: dict[str, Any]) -> None:
        if "position" in state:
            self._loops.position[...] = state["position"]
            self._called = True

    def apply(self, clock: Clock) -> None:
        if self.outdated_bonds:
            self.attach()
            self._warn_of_step(clock)
        self._called = True
        self._now = [clock.time, clock.dt]
        if not self._loops.add(clock.time, clock.dt, bool(self.starts)):
            raise self.blame()

    def _warn_of_step(self, clock: Clock) -> None:
        """Says once if bonds that were found during the run are too stiff for its step."""
        highest = max((float(each.max(initial=0.0)) for each in self.squared_frequencies().values()), default=0.0)
        if highest * clock.dt**2 > 4.0 and not self._warned:
            self._warned = True
            warnings.warn(
                f"{self.label}: the bonds found at step {clock.step} allow a time step of {2.0 / highest**0.5:.3g} s, "
                f"and it is {clock.dt:.3g} s: the run will blow up; give dt",
                stacklevel=2,
            )

    def can_start(self, key: Key) -> bool:
        return isinstance(self._loops, LatticeLoops)

    def batch_key(self) -> Hashable:
        small = len(self.host) < BATCH_BELOW and not self.host.searched_again
        return (type(self._loops), self._loops.kind) if small and not self.recording else None

    def batch(self, relations: Sequence[Relation]) -> Callable[[Clock], None]:
        forces = [each for each in relations if isinstance(each, PairwiseForce)]
        every: Any = [each._loops for each in forces]
        merged = self._loops.merged(every)

        now = [0.0, 0.0]  # one for all
        start = starts_of(forces)
        for force in forces:
            force._called, force._now = True, now

        def apply(clock: Clock) -> None:
            now[:] = clock.time, clock.dt
            if not merged.add(clock.time, clock.dt, start):
                wrong = [each for each in forces if each.forces_are_finite() is not None]
                raise (wrong or forces)[0].blame()

        return apply

    def compile_energy(self, out: NDArray[np.float64]) -> None:
        """Makes `energy` ready; called after `attach` by whoever will ask for energies.

        Raises:
            BadInput: if this relation is not part of the scene.
        """
        if not hasattr(self, "_loops"):
            raise BadInput(f"{self.label} is asked for its energy and is not in the list of relations: list it")
        self._loops_of_energy().prepare_energy(out)

    def _loops_of_energy(self) -> BondLoops:
        if self._energies is None:
            self._energies = self.energy_loops()
        return self._energies

    def force_state(self) -> tuple[Callable[..., Any], tuple[Argument, ...], float]:
        """The scalar force state t of a node: function, its arguments and a factor; here half of the pairwise force."""
        return self._law, self._law_arguments, 0.5

    @property
    def now(self) -> tuple[float, float]:
        """Time and dt of the last force, s."""
        return self._now[0], self._now[1]

    def energy_loops(self) -> BondLoops:
        """The loops that energies are asked from."""
        return self._loops

    def energy(self, out: NDArray[np.float64], part: Part | None = None) -> None:
        """Adds the strain energy density (J/m^3) of the present displacement to `out` (n,), of the nodes of a part."""
        time, dt = self._now
        loops = self._loops_of_energy()
        if isinstance(loops, JointLoops):
            loops.energy(out, time, dt, self.ends.index(part or self.part))
        else:
            loops.energy(out, time, dt)

    def stiffness_bounds(self) -> dict[Part, NDArray[np.float64]]:
        """Bound of the stiffness at each node, N/m^4: 2 Σ |df/ds| β V / |ξ| at rest (Gershgorin).

        For f = c s the step that follows from it, 2 / sqrt(max / ρ), is sqrt(2ρ / Σ cV/|ξ|) of Silling & Askari (2005).
        """
        found = {}
        for number, end in enumerate(self.ends):
            out = np.zeros(len(end))
            if isinstance(self._loops, JointLoops):
                self._loops.stiffness(out, number)
            else:
                self._loops.stiffness(out)
            found[end] = 2.0 * out
        return found

    @property
    def nbytes(self) -> int:
        """Positions of the last forces, as the loops want them."""
        return self._loops.nbytes + self.surface.nbytes if hasattr(self, "_loops") else 0

    def items(self) -> int:
        return len(self.host.bonds)

    def visited(self) -> int:
        return self._loops.visited
