"""Energies as relations: each a number of the part, computed when its trigger says so."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Field, Measure, Part, Trigger, always, is_fictitious
from rbs_core.relation import Fields, Key
from rbs_core.trigger import Clock
from rbs_plugins.constitutive.bond_based import BondBased
from rbs_plugins.constitutive.correspondence import Correspondence
from rbs_plugins.constitutive.pairwise import PairwiseForce
from rbs_plugins.fields import (
    density,
    dissipation_density,
    fracture_dissipation,
    kinetic_energy,
    strain_energy,
    strain_energy_density,
    velocity,
    volume,
)
from rbs_plugins.loops import Loop, Text
from rbs_plugins.loops.loop import CHUNK
from rbs_plugins.loops.nodes import chunks, sum_motion, sum_products

Energetic = PairwiseForce | Correspondence  # forces that know their energy


class KineticEnergy(Measure):
    """T = Σ ½ ρ V |v|², over the nodes of the body: those of fictitious layers are left out."""

    example = {}
    reads = (velocity, density, volume)
    writes = (kinetic_energy,)

    def attach(self) -> None:
        self._partial = chunks(len(self.part))
        arrays = {
            "mass": self[density],
            "volume": body_volumes(self),
            "velocity": self[velocity],
            "partial": self._partial,
        }
        self._loop = Loop(Text.of(sum_motion), "sum_motion", {**arrays, "chunk": CHUNK}, len(self.part))

    def apply(self, clock: Clock) -> None:
        self._loop()
        self[kinetic_energy][...] = 0.5 * self._partial.sum()


def body_volumes(measure: Measure) -> NDArray[np.float64]:
    """Volumes of the nodes, none for those of fictitious layers, so that sums are over the body."""
    volumes = measure[volume]
    return (
        np.where(measure.part[is_fictitious] == 0, volumes, 0).astype(volumes.dtype)
        if measure.part.extended
        else volumes
    )


class _Integral:
    """Sum of a density over the volumes of the nodes, the same for any number of threads."""

    def __init__(self, values: NDArray[np.float64], volumes: NDArray[np.float64]) -> None:
        self._partial = chunks(len(values))
        arrays = {"a": values, "b": volumes, "partial": self._partial, "chunk": CHUNK}
        self._loop = Loop(Text.of(sum_products), "sum_products", arrays, len(values))

    def __call__(self) -> float:
        self._loop()
        return float(self._partial.sum())


class StrainEnergy(Measure):
    """U = Σ W V, W the energy in the intact bonds, half for either end; over the nodes of the body.

    Args:
        part: the part.
        forces: the constitutive relations whose bonds hold the energy.
        when: trigger.
    """

    writes = (strain_energy_density, strain_energy)
    storages = ("list", "lattice")  # what the forces can

    @staticmethod
    def example(part: Part) -> dict[str, Any]:
        """The energy of a linear material."""
        return {"forces": [BondBased(part, E=1e9)]}

    def __init__(self, part: Part, forces: Energetic | Sequence[Energetic], *, when: Trigger = always) -> None:
        super().__init__(part, when=when)
        self._forces = [forces] if isinstance(forces, Energetic) else list(forces)
        for force in self._forces:
            if not hasattr(force, "energy"):
                raise BadInput(f"{self.label}: {force!r} does not know its energy: list constitutive relations")
            if part not in force.ends:
                raise BadInput(f"{self.label}: {force.label} belongs to another part")

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """What the forces read, and the state of their bonds."""
        looked_at: list[Field | Key] = [key for force in self._forces for key in (*force.reads, *force.updates)]
        return tuple(dict.fromkeys([volume, *looked_at]))

    def attach(self) -> None:
        self._total = _Integral(self[strain_energy_density], body_volumes(self))

    def begin(self, clock: Clock) -> None:
        for force in self._forces:
            force.compile_energy(self[strain_energy_density])

    def apply(self, clock: Clock) -> None:
        out = self[strain_energy_density]
        out[...] = 0.0
        for force in self._forces:
            force.energy(out, self.part)
        self[strain_energy][...] = self._total()

    def items(self) -> int:
        return sum(force.items() for force in self._forces)


class FractureDissipation(Measure):
    """Φ = Σ D V: the energy that bonds held when they broke; over the nodes of the body."""

    example = {}
    reads = (dissipation_density, volume)
    writes = (fracture_dissipation,)

    def attach(self) -> None:
        self._total = _Integral(self[dissipation_density], body_volumes(self))

    def apply(self, clock: Clock) -> None:
        self[fracture_dissipation][...] = self._total()
