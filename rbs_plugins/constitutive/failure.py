"""Failure by energy: a bond breaks once it has taken a critical energy, or the nodes at its ends hold too much."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from rbs_core import BadInput, Geometry, Part, Relation
from rbs_plugins.constitutive.bond_energy import BondEnergy, MeanBondEnergy
from rbs_plugins.constitutive.fracture import Criterion

if TYPE_CHECKING:
    from rbs_plugins.constitutive.pairwise import PairwiseForce


def taken_in_tension(bond_energy, stretch, w0):
    """True for a lengthened bond that has taken more than w0."""
    return (bond_energy > w0) & (stretch > 0.0)


def taken(bond_energy, w0):
    """True for a bond that has taken more than w0."""
    return bond_energy > w0


def held_at_nodes_in_tension(mean_bond_energy_i, mean_bond_energy_j, stretch, w0):
    """True for a lengthened bond between nodes whose bonds hold more than w0 on average."""
    return (0.5 * (mean_bond_energy_i + mean_bond_energy_j) > w0) & (stretch > 0.0)


def held_at_nodes(mean_bond_energy_i, mean_bond_energy_j, w0):
    """True for a bond between nodes whose bonds hold more than w0 on average."""
    return 0.5 * (mean_bond_energy_i + mean_bond_energy_j) > w0


def critical_bond_energy(fracture_energy: float, dimension: int, horizon: float, across: float = 1.0) -> float:
    """Energy w0 of a bond, J/m^6, with which all bonds through a unit area take the fracture energy.

    Args:
        fracture_energy: G0, J/m^2.
        dimension: 1, 2 or 3.
        horizon: δ, m.
        across: area A (1-D, m^2) or thickness h (2-D, m).

    G0 is w0 times the bonds that cross a unit area, ∫ dz ∫ dV over depths z and the parts of families beyond the plane:
    w0 = 4G0/(πδ⁴) in 3-D (Foster, Silling & Chen 2011), 3G0/(2hδ³) in 2-D (Sarego 2016, eq. 1.100), 2G0/(Aδ²) in 1-D.
    """
    crossing = {1: across * horizon**2 / 2, 2: 2 * across * horizon**3 / 3, 3: math.pi * horizon**4 / 4}[dimension]
    return fracture_energy / crossing


class _Energetic(Criterion):
    """What both criteria have in common: the limit w0, and whether shortened bonds fail, too."""

    FUNCTIONS: dict[str, Callable[..., Any]]

    def __init__(self, w0: float | None, mode: str, within: Geometry | str | None, release: str) -> None:
        name = type(self).__name__
        if mode not in self.FUNCTIONS:
            raise BadInput(f"{name}: mode={mode!r} must be one of {', '.join(self.FUNCTIONS)}")
        _require_positive(name, "w0", w0)
        super().__init__(self.FUNCTIONS[mode], within=within, release=release)
        self.w0, self.mode = w0, mode


class CriticalBondEnergy(_Energetic):
    """A bond fails once the work of its force has reached a limit (Foster, Silling & Chen 2011).

    Args:
        w0: critical energy of a bond, J/m^6; or give the fracture energy instead.
        fracture_energy: G0, J/m^2, see `critical_bond_energy`.
        mode: "tension" (default) for bonds that are longer than at the start, "both" for shortened ones, too, as in the
            source.
        form: "incremental", the work w = ∫ (t_i + t_j) dℓ since the start, summed by a BondEnergy in front of the force
            (bonds stored as list); or "secant", the energy that the bond holds at present, ½ (t_i + t_j) e, which is no
            state of the bond and costs nothing more (list and lattice). Secant if not given where they are the same:
            linear springs, that is BondBased, and OrdinaryStateBased with the Poisson's ratio of springs.
        within, release: as of Criterion.

    Raises:
        BadInput: unless exactly one of w0 and fracture_energy is given and positive; on an unknown mode or form. Where
            the force is made: for a form that it does not have, and for a fracture energy with the secant form where
            that depends on the path.

    The work of the tractions on a plane along which a body is pulled apart is the sum of the work of its bonds, so with
    the incremental form it is G0 whatever the law and the order of failure. With the secant form of a state-based solid
    it is not: the dilatation goes back when bonds break, and takes energy with it. Surface corrections are refused.
    """

    FUNCTIONS = {"tension": taken_in_tension, "both": taken}
    FORMS = (None, "incremental", "secant")

    def __init__(
        self,
        w0: float | None = None,
        *,
        fracture_energy: float | None = None,
        mode: str = "tension",
        form: str | None = None,
        within: Geometry | str | None = None,
        release: str = "at once",
    ) -> None:
        name = type(self).__name__
        if (w0 is None) == (fracture_energy is None):
            raise BadInput(f"{name}: give either the energy w0 of a bond or the fracture_energy, not both or none")
        if form not in self.FORMS:
            raise BadInput(f"{name}: form={form!r} must be 'incremental' or 'secant'")
        _require_positive(name, "fracture_energy", fracture_energy)
        super().__init__(w0, mode, within, release)
        self.fracture_energy, self.form = fracture_energy, form

    def form_for(self, force: PairwiseForce) -> str:
        """The form for a force.

        Raises:
            BadInput: if it does not have the chosen one.
        """
        if self.form == "incremental":
            return "incremental"
        if force.holds_beyond is None:
            if self.form is None:
                return "incremental"
            raise BadInput(f"{force.label}: form='secant' is for BondBased (f = c s) and OrdinaryStateBased")
        if self.form is None:
            return "incremental" if force.path_dependent else "secant"
        if self.fracture_energy is not None and force.path_dependent:
            raise BadInput(
                f"{force.label}: what the secant form takes depends on the path, and is not the fracture_energy: give "
                "w0, or form='incremental'"
            )
        return "secant"

    def function_for(self, force: PairwiseForce) -> Callable[..., Any]:
        if self.form_for(force) == "incremental":
            return self.function
        assert force.holds_beyond is not None
        return force.holds_beyond[self.mode]

    def parameters(self, force: PairwiseForce) -> dict[str, float]:
        if self.w0 is not None:
            return {"w0": self.w0}
        assert self.fracture_energy is not None
        host = force.host
        across = host.thickness or host.area or 1.0
        return {"w0": critical_bond_energy(self.fracture_energy, host.dimension, host.bonds.horizon, across)}

    def feeders(self, force: PairwiseForce) -> tuple[Relation, ...]:
        _require_no_factors(self, force)
        if self.form_for(force) == "secant":
            return ()
        return (BondEnergy(_part(self, force), force, when=force.when),)

    def __repr__(self) -> str:
        limit = f"{self.w0!r}" if self.w0 is not None else f"fracture_energy={self.fracture_energy!r}"
        form = "" if self.form is None else f", form={self.form!r}"
        return f"CriticalBondEnergy({limit}, mode={self.mode!r}{form}{self._options})"


class CriticalNodalEnergy(_Energetic):
    """A bond fails once the nodes at its ends hold more than a limit, on the average (Sarego 2016, eq. 1.102).

    Args:
        w0: critical energy, J/m^6, of a mean bond.
        mode: "tension" (default) for bonds that are longer than at the start, "both" for all, as in the source.
        within, release: as of Criterion.

    Raises:
        BadInput: if w0 is not positive; on an unknown mode; where the force is made, if it is on a connection.

    What is compared is ½ (w_i + w_j), with w = 2W / Σ β V, the energy of a mean bond of a node, from its strain energy
    density W: the source compares W itself with w0, whose unit is another one. A MeanBondEnergy in front of the force
    computes w at the present displacement, so a step costs about twice as much.

    It takes no fracture energy: beside a crack only part of a family is strained, so several times more energy is
    needed than that for which `critical_bond_energy` gives w0, and bonds that are hardly strained fail with the others.
    """

    FUNCTIONS = {"tension": held_at_nodes_in_tension, "both": held_at_nodes}

    def __init__(
        self, w0: float, *, mode: str = "tension", within: Geometry | str | None = None, release: str = "at once"
    ) -> None:
        super().__init__(w0, mode, within, release)

    def parameters(self, force: PairwiseForce) -> dict[str, float]:
        assert self.w0 is not None
        return {"w0": self.w0}

    def feeders(self, force: PairwiseForce) -> tuple[Relation, ...]:
        _require_no_factors(self, force)
        return (MeanBondEnergy(_part(self, force), force, when=force.when),)

    def __repr__(self) -> str:
        return f"CriticalNodalEnergy({self.w0!r}, mode={self.mode!r}{self._options})"


def _part(criterion: Criterion, force: PairwiseForce) -> Part:
    if not isinstance(force.host, Part):
        raise BadInput(f"{force.label}: {criterion!r} is for bonds within a part: take a critical stretch here")
    return force.host


def _require_no_factors(criterion: Criterion, force: PairwiseForce) -> None:
    if force.surface.kind:
        raise BadInput(f"{force.label}: {criterion!r} does not know the factors of a surface correction: leave it out")


def _require_positive(name: str, what: str, value: float | None) -> None:
    if value is not None and not (np.isfinite(value) and value > 0):
        raise BadInput(f"{name}: {what}={value} must be positive and finite")
