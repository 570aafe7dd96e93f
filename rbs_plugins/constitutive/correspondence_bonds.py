"""What correspondence models give their loops: arrays, numbers and the recipe."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Field
from rbs_core.part import Lattice, Part, Rows
from rbs_plugins.constitutive.bond_based import across_of
from rbs_plugins.constitutive.bonded import BondRelation
from rbs_plugins.constitutive.fracture import Criterion
from rbs_plugins.constitutive.influence import Influence, influences
from rbs_plugins.constitutive.moduli import Moduli
from rbs_plugins.constitutive.softening import BondSoftening
from rbs_plugins.constitutive.stabilization import ZeroEnergyControl
from rbs_plugins.constitutive.stress import LAWS, linear_elastic
from rbs_plugins.fields import (
    deformation_gradient,
    displacement,
    force_density,
    largest_stretch,
    reference_position,
    stress,
    volume,
    volume_fraction,
)
from rbs_plugins.loops.arguments import Argument
from rbs_plugins.loops.tensor_lattice import TensorLatticeLoops
from rbs_plugins.loops.tensor_recipe import TensorRecipe
from rbs_plugins.loops.tensor_rows import TensorRowLoops
from rbs_plugins.tangents.correspondence import CorrespondenceTangent

TENSORS = {deformation_gradient: "F", stress: "P"}  # what is offered of each node, and its letter in the loops


class CorrespondenceBonds(BondRelation):
    """The loops of a correspondence model, made from what its arguments have become.

    Attributes:
        case: "1-D", "stress", "strain" or "3-D".
        moduli: elastic constants.
        horizon: δ, m.
    """

    part: Part
    case: str
    moduli: Moduli
    horizon: float
    _law: Callable[..., Any]
    _potential: Callable[..., Any] | None
    _thickness: Callable[..., Any] | None
    _influence: Influence
    _fracture: Criterion | None
    _softening: BondSoftening | None
    _control: ZeroEnergyControl | None
    _state: tuple[Field, ...]
    _fraction: bool
    _law_arguments: tuple[Argument, ...]
    _across_arguments: tuple[Argument, ...]
    _potential_arguments: tuple[Argument, ...]
    _criterion_arguments: tuple[Argument, ...]
    _soft_arguments: tuple[Argument, ...]
    _wanted: dict[Field, str]
    _now: tuple[float, float]

    @property
    def _arguments(self) -> tuple[Argument, ...]:
        nodes = (*self._law_arguments, *self._across_arguments, *self._potential_arguments)
        return (*nodes, *self._criterion_arguments, *self._soft_arguments)

    @property
    def _zoned(self) -> bool:
        return self._fracture is not None and self._fracture.within is not None

    def choose_storage(self) -> None:
        super().choose_storage()
        if self._control is not None and self._control.by_family:
            self.part.bonds.need_list(f"{self.label}, {self._control!r},")

    def attach(self) -> None:
        if self.is_changed(volume):
            raise BadInput(f"{self.label}: some relation changes the volumes, and shape tensors are computed once")
        criterion = self._criterion_arguments
        self._wanted = {field: letter for field, letter in TENSORS.items() if self.wants(field)}
        asked = "".join(letter for letter in "FP" if any(a.name in (f"{letter}_i", f"{letter}_j") for a in criterion))
        keeps = "".join(letter for letter in "FP" if letter in asked or letter in self._wanted.values())
        self._recipe = TensorRecipe(
            law=self._law,
            law_arguments=self._law_arguments,
            criterion=None if self._fracture is None else self._fracture.function,
            criterion_arguments=criterion,
            potential=self._potential,
            potential_arguments=self._potential_arguments,
            intact=self._fracture is not None or self.may_have_broken,
            breakable=self._zoned,
            uniform=self.uniform(volume) is not None,
            late=self._fracture is not None and self._fracture.release == "next step",
            case=self.case,
            state=self._state,
            thickness=self._thickness,
            thickness_arguments=self._across_arguments,
            gain=self._control is not None,
            even=self._control is not None and self._control.even and isinstance(self.part.bonds.stored, Lattice),
            softening=None if self._softening is None else self._softening.softening,
            soft_arguments=self._soft_arguments,
            keeps=keeps,
            early=not asked,
            **self.processor(),
        )
        self._bound = self.host.version
        inputs, changing = self._inputs(), [a.array for a in self._arguments if a.kind == "node"]
        changing = [a.array for a in self._arguments if a.kind == "node" and a.field and self.is_changed(a.field)]
        lattice = isinstance(self.part.bonds.stored, Lattice)
        make = TensorLatticeLoops if lattice else TensorRowLoops
        self._loops = make(self._recipe, self.part, inputs, list(dict.fromkeys(changing)))
        self._refuse_singular()

    def _inputs(self) -> dict[str, Any]:
        """Arrays and numbers, by the names that the loops know them by."""
        part, r = self.part, self._recipe
        stored, volumes = part.bonds.stored, self[volume]
        if isinstance(stored, Lattice):
            lengths, shares = stored.lengths, part.raw(volume_fraction) if self._fraction else 1.0
        else:
            lengths, shares = 1.0 / stored.inverse_lengths(), self[volume_fraction] if self._fraction else 1.0
        omega = influences(self._influence, lengths, self.horizon, part.spacing, self.label)
        mean = float(omega.mean()) if omega.size else 1.0
        if not mean > 0:
            raise BadInput(f"{self.label}: the influence '{self._influence.__name__}' is zero for all bonds")
        mean_volume = float(volumes.mean())
        unit, across = mean_volume * self.horizon**2, across_of(self.label, part)
        flat: float | NDArray[np.float64]
        flat, by_trace = (0.0, 0.0)
        if self._control is not None:
            flat, by_trace = self._control.gains(self.moduli, self.case, self.horizon, across, unit)
            if self._control.by_family:
                assert isinstance(stored, Rows)
                flat = flat / weighted_volumes(stored, omega / mean * shares, volumes)
        named: dict[str, Any] = {
            "displacement": self[displacement],
            "reference_position": self[reference_position],
            "out": self[force_density],
            "weights": omega / mean * shares,
            "horizon": self.horizon,
            "mean_volume": mean_volume,
            "gain_flat": flat,
            "gain_trace": by_trace,
            "stiff": self.moduli.E if self.case == "1-D" else self.moduli.lame + 2 * self.moduli.G,
            **{f"state_{field.name}": self[field] for field in self._state},
            **{field.name: self.raw(field) for field in r.bond_fields},
        }
        if not r.uniform:
            named["volume"] = volumes
        if self._softening is not None:
            named["largest_stretch"] = self[largest_stretch]
        for argument in self._arguments:
            if argument.kind == "parameter":
                named[f"p_{argument.name}"] = argument.value
            elif argument.field is not None:
                named[argument.array] = self.raw(argument.field)
        return named

    def tangent(self) -> CorrespondenceTangent:
        """How the forces resist a change of the present displacement; asked for after `attach`.

        Raises:
            BadInput: if this relation is not part of the scene, or its bonds are stored as lattice.
        """
        if self.part.bonds.storage != "list":
            raise BadInput(f"{self.label}: a tangent needs bonds as list: part.connect(..., storage='list')")
        if not hasattr(self, "_loops"):
            raise BadInput(f"{self.label} is asked for its tangent and is not in the list of relations: list it")
        assert isinstance(self._loops, TensorRowLoops)
        even = self._law in LAWS or (self._potential is not None and not self._state)
        soft = self._softening
        made = CorrespondenceTangent(
            self.part, self._recipe, self._loops, self[volume].astype(np.float64), even=even,
            slope=None if soft is None else soft.slope, now=lambda: self._now,
        )  # fmt: skip
        made.constant = self._law is linear_elastic and soft is None
        return made

    def _refuse_singular(self) -> None:
        bad = self._loops.check_shapes()
        if len(bad):
            node, counts = int(bad[0]), self.part.bonds.counts()
            raise BadInput(
                f"{self.label}: the shape tensor of {len(bad)} nodes is singular, first of node {node} at "
                f"{self.part.positions[node].tolist()}, which has {counts[node]} bonds, in one plane or line if there "
                "are any: take a larger horizon, more nodes across thin places, or another influence function"
            )


def weighted_volumes(stored: Rows, weights: NDArray[np.float64], volumes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Σ ωβV of each node over all bonds that it ever had, (n,), m^3; 1 where it has none."""
    offsets, neighbors = stored.as_rows()
    nodes = np.repeat(np.arange(len(volumes)), np.diff(offsets))
    sums = np.bincount(nodes, weights * volumes[neighbors], minlength=len(volumes))
    return np.where(sums > 0, sums, 1.0)
