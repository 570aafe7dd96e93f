"""Correspondence: bonds whose force state comes from a classical stress law (non-ordinary state-based peridynamics)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, BadLaw, Field, Part, Trigger, always
from rbs_core.part import Connection, Lattice
from rbs_core.relation import Fields, Key
from rbs_core.report import log
from rbs_core.trigger import Clock
from rbs_plugins.constitutive.bond_based import plane_of
from rbs_plugins.constitutive.corrections import set_partial_volume
from rbs_plugins.constitutive.correspondence_bonds import TENSORS, CorrespondenceBonds
from rbs_plugins.constitutive.fracture import Criterion
from rbs_plugins.constitutive.influence import Influence, influence_function
from rbs_plugins.constitutive.moduli import Moduli
from rbs_plugins.constitutive.softening import BondSoftening
from rbs_plugins.constitutive.stabilization import SillingControl, ZeroEnergyControl
from rbs_plugins.constitutive.stress import LAWS, Known, saint_venant_kirchhoff
from rbs_plugins.fields import (
    breakable,
    displacement,
    force_density,
    intact,
    largest_stretch,
    reference_position,
    volume,
    volume_fraction,
)
from rbs_plugins.loops.arguments import fields, names_of
from rbs_plugins.loops.tensor_arguments import resolve_bond, resolve_node
from rbs_plugins.loops.tensor_lattice import TensorLatticeLoops

CONSTANTS = ("E", "nu", "K", "G", "lame")


class Correspondence(CorrespondenceBonds):
    """Bonds whose force state is that of a classical stress law: T⟨ξ⟩ = ω P K^-1 ξ + ω g z (Silling et al. 2007).

    Args:
        part: connected part; no connection.
        law: plain function P(F, ...) of the deformation gradient, see `rbs_plugins.constitutive.stress`.
        fracture: when bonds fail; never if not given. Its function may ask for F_i, F_j, P_i and P_j of the two ends,
            3 x 3 tuples, beside what laws of bonds may ask for; end i is the one with the lower number.
        E, nu, K, G: two elastic constants, Pa; in 1-D E alone is enough. Laws ask for them by name.
        plane: "stress" (default) or "strain", 2-D parts only.
        influence: plain function ω(reference_length, horizon), or the name of one in
            `rbs_plugins.constitutive.influence`.
        stabilization: control of zero-energy modes; None for none. SillingControl() if not given.
        potential: energy density W(F, ...) of the law, J/m^3; known for the laws of this package.
        state: fields of nodes that the law takes along: it asks for them by name, and returns (P, new state, ...).
            Tensors (d x d) are filled up to 3 x 3 without trace.
        partial_volume: "none" or "linear".
        when: trigger.
        **parameters: numbers that law, criterion and potential ask for.

    Attributes:
        hold: while true, `apply` is a trial from the state of the last step: no bond breaks, and the states of the law
            and of softening bonds enter as they are and stay so.

    Raises:
        BadLaw: if a function asks for something that nobody knows, or (at the start of the run) cannot be compiled.
        BadInput: on a connection, wrong constants, an unknown name; at the start of the run, if the shape tensor of a
            node is singular although no bond is broken.

    K = Σ μωβV ξ⊗ξ is the shape tensor, F = (Σ μωβV Y⊗ξ) K^-1, and L_i = Σ μβV (T_i⟨ξ⟩ − T_j⟨−ξ⟩). Broken bonds leave
    all sums; K is computed once, and anew for the ends of bonds that fail. A node whose K becomes singular in that way
    (bonds in nearly one plane or line, or none) has F = I and no stress or control of its own from then on; its bonds
    carry what their other end gives them. `singular_nodes` names such nodes, and the log says when there are any.

    F is offered as `deformation_gradient`, P as `stress`: the collapsed stress Σ T⟨ξ⟩⊗ξ V is P, to which a control adds
    nothing.
    """

    adds: Fields = (force_density,)
    example = {"law": saint_venant_kirchhoff, "E": 1e9, "nu": 0.3}

    def __init__(
        self,
        part: Part,
        law: Callable[..., Any],
        fracture: Criterion | None = None,
        *,
        E: float | None = None,
        nu: float | None = None,
        K: float | None = None,
        G: float | None = None,
        plane: str | None = None,
        influence: Influence | str = "constant",
        stabilization: ZeroEnergyControl | str | None = "silling",
        potential: Callable[..., Any] | None = None,
        state: tuple[Field, ...] | None = None,
        partial_volume: str = "none",
        when: Trigger = always,
        **parameters: float,
    ) -> None:
        if isinstance(part, Connection):
            raise BadInput(
                "Correspondence: a deformation gradient needs the whole family of a node, and a connection has only "
                "its bonds to the other part: put both bodies into one part, or use PairwiseForce on the connection"
            )
        super().__init__(part, when=when)
        if not callable(law):
            raise BadLaw(f"{self.label}: the law must be a function, got {law!r}")
        if fracture is not None and not isinstance(fracture, Criterion):
            raise BadInput(f"{self.label}: fracture={fracture!r} must be a criterion such as CriticalStretch(0.01)")
        if stabilization == "silling":
            stabilization = SillingControl()
        if stabilization is not None and not isinstance(stabilization, ZeroEnergyControl):
            raise BadInput(
                f"{self.label}: stabilization={stabilization!r} must be SillingControl(), WanControl() or None"
            )
        self.case = plane_of(type(self).__name__, part, plane)
        if self.case == "1-D" and nu is None and K is None and G is None:
            nu = 0.0
        self.moduli = Moduli.of(self.label, E, nu, K, G)
        self.horizon = part.bonds.horizon
        self._law, self._fracture, self._control = law, fracture, stabilization
        self._influence = influence_function(influence, self.label)
        known = LAWS.get(law, Known())
        self._potential = potential if potential is not None else known.potential
        self._state = known.state if state is None else tuple(state)
        self._thickness = known.thickness if self.case == "stress" else None
        self._softening = fracture if isinstance(fracture, BondSoftening) else None
        self._fraction = set_partial_volume(part, partial_volume)
        self._now, self.hold = (0.0, 0.0), False
        self._resolve(parameters)
        self._warned = False
        if fracture is not None:
            fracture.mark(self)  # type: ignore[arg-type]

    def _resolve(self, parameters: dict[str, float]) -> None:
        """Says where the arguments of all functions come from."""
        constants = {name: getattr(self.moduli, name) for name in CONSTANTS}
        values = {**constants, **parameters}
        limits = {} if self._fracture is None else self._fracture.parameters(self)  # type: ignore[arg-type]
        twice = sorted(limits.keys() & values.keys())
        if twice:
            raise BadLaw(f"{self.label}: law and criterion both have a parameter {twice[0]}: rename one")
        part, state = self.part, self._state
        self._law_arguments = resolve_node(self._law, part, values, state)
        self._across_arguments = () if self._thickness is None else resolve_node(self._thickness, part, values, state)
        self._potential_arguments = (
            () if self._potential is None else resolve_node(self._potential, part, values, state)
        )
        criterion, soften = self._fracture, self._softening
        own = {**limits, **parameters}
        self._criterion_arguments = () if criterion is None else resolve_bond(criterion.function, part, own)
        self._soft_arguments = () if soften is None else resolve_bond(soften.softening, part, own)
        asked = {a.name for a in self._arguments if a.kind == "parameter"}
        unknown = sorted(parameters.keys() - asked)
        if unknown:
            raise BadInput(
                f"{self.label}: nobody asks for {', '.join(unknown)} (law, criterion and potential ask for "
                f"{', '.join(sorted(asked)) or 'no parameter'}): check the spelling"
            )
        missing = [field.name for field in state if field.name not in names_of(self._law)]
        if missing:
            raise BadLaw(f"{self.label}: the law does not ask for its state {', '.join(missing)}: name it in front")

    def identity(self) -> dict[str, Any]:
        values = {argument.name: argument.value for argument in self._arguments if argument.kind == "parameter"}
        failure = None if self._fracture is None else (self._fracture.function, repr(self._fracture))
        return {**self.parameters, "failure": failure, "control": repr(self._control), "values": values}

    # -- contract ---------------------------------------------------------------------------------------------------

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """Displacement, nodes, bonds, and whatever the functions ask for."""
        flags = ((volume_fraction, self._fraction), (breakable, self._zoned),
                 (intact, self._fracture is None and self.may_have_broken))  # fmt: skip
        more = [field for field, there in flags if there]
        asked = [field for field in fields(self._arguments) if field not in self._state]
        return tuple(dict.fromkeys([displacement, reference_position, volume, *more, *asked]))

    @property
    def updates(self) -> Fields:  # type: ignore[override]
        """States of the law, and of the bonds if they can fail."""
        bonds = (*([intact] if self._fracture else []), *([largest_stretch] if self._softening else []))
        return (*self._state, *bonds)

    @property
    def offers(self) -> Fields:  # type: ignore[override]
        """The deformation gradient, and P."""
        return tuple(TENSORS)

    @property
    def storages(self) -> tuple[str, ...]:  # type: ignore[override]
        """The list always; the lattice unless a bond has something of its own beside being intact."""
        stored = self.part.bonds.stored
        bonds = [field for field in fields(self._arguments) if field.at == "bond"]
        own = isinstance(stored, Lattice) and any(stored.fields.raw(field).ndim != 1 for field in bonds)
        changed = any(self.is_changed(field) for field in bonds)
        return ("list",) if own or changed or self._softening is not None else ("list", "lattice")

    # -- work -------------------------------------------------------------------------------------------------------

    def reset(self) -> None:
        self._warned = False

    def begin(self, clock: Clock) -> None:
        self._loops.begin()
        self._report()

    def apply(self, clock: Clock) -> None:
        self._now = (clock.time, clock.dt)
        finite, broke = self._loops.force(clock.time, clock.dt, bool(self.starts), self.hold)
        if not finite:
            raise self.blame()
        if broke and self._loops.lost:
            self._report()
        for field, letter in self._wanted.items():
            self._loops.tensors(letter, self[field])

    @property
    def singular_nodes(self) -> NDArray[np.int64]:
        """Nodes whose bonds that are left give no deformation gradient."""
        return np.flatnonzero(self._loops.singular)

    def _report(self) -> None:
        """Says once that there are such nodes."""
        if self._warned or not self._loops.lost:
            return
        self._warned, found = True, self.singular_nodes
        log.warning(
            "%s: so many bonds are broken that %d nodes have no deformation gradient any more (first %d at %s): "
            "they have no stress of their own from now on; see singular_nodes",
            self.label, len(found), found[0], self.part.positions[found[0]].tolist(),
        )  # fmt: skip

    def can_start(self, key: Key) -> bool:
        return isinstance(self._loops, TensorLatticeLoops)

    def compile_energy(self, out: NDArray[np.float64]) -> None:
        """Makes `energy` ready; called after `attach` by whoever will ask for energies.

        Raises:
            BadInput: if this relation is not part of the scene, or its law has no potential.
        """
        if not hasattr(self, "_loops"):
            raise BadInput(f"{self.label} is asked for its energy and is not in the list of relations: list it")
        if self._potential is None:
            raise BadInput(f"{self.label}: the energy of law '{self._law.__name__}' is not known: give potential=...")
        self._loops.prepare_energy(out)

    def energy(self, out: NDArray[np.float64], part: Part | None = None) -> None:
        """Adds the energy density (J/m^3) of the present displacement, that of the control included, to `out` (n,)."""
        self._loops.energy(out, *self._now)

    def critical_stretch(self, fracture_energy: float) -> float:
        """Critical stretch for G0, J/m^2, as if bonds were those of a bond-based material of the same bulk modulus.

        sqrt(5G0/(9Kδ)) in 3-D, sqrt(πG0/(3K'δ)) in 2-D, sqrt(3G0/(Eδ)) in 1-D (Hashim 2021, eq. 2.26 for 3-D).
        """
        factor = {"3-D": 5 / 9, "1-D": 3.0}.get(self.case, np.pi / 3)
        return float(np.sqrt(factor * fracture_energy / (self.moduli.bulk(self.case) * self.horizon)))

    def stiffness_bounds(self) -> dict[Part, NDArray[np.float64]]:
        """Bound of the stiffness at each node, N/m^4.

        With h_ij = ωβV_j K_i^-1 ξ, s_i = Σ_j h_ij and a_i = Σ_j |h_ij|, the rows of the stiffness at rest are bounded
        (Gershgorin) by M (|s_i| + a_i) |s_i| + Σ_j M (|s_j| + a_j) |h_ji| V_j/V_i + 2 Σ_j ωβV_j (g_i + g_j), M the
        largest eigenvalue of the elastic constants, and by that of their control. Where bonds may break it is no less
        than (2c/r)², c the speed of pressure waves and r the shortest bond: a family of few bonds has this frequency.
        """
        m, d = self.moduli, self.part.dimension
        plane = m.plane_lame(self.case)
        modulus = m.E if d == 1 else max(d * plane + 2 * m.G, 2 * m.G)
        found = self._loops.bound(modulus)
        if self._fracture is not None and len(self.part.bonds):
            shortest = 1.0 / self.part.bonds.stored.inverse_lengths().max()
            found = np.maximum(found, 4 * (plane + 2 * m.G) / shortest**2)
        return {self.part: found}

    @property
    def nbytes(self) -> int:
        """Arrays that the loops keep from step to step."""
        return self._loops.nbytes if hasattr(self, "_loops") else 0

    def items(self) -> int:
        return len(self.part.bonds)
