"""Energies against sums written out in numpy."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, MissingField
from rbs_plugins import BondBased, CriticalStretch, Damage, FractureDissipation, KineticEnergy, StrainEnergy
from rbs_plugins.fields import (
    density,
    displacement,
    dissipation_density,
    fracture_dissipation,
    kinetic_energy,
    strain_energy,
    strain_energy_density,
    velocity,
    volume,
)
from rbs_plugins.testing import MANY, body, ends


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("shape", [None, "many"])
def test_kinetic_energy(dimension, shape, rng):
    part = body(dimension, shape=MANY[dimension] if shape else None)
    part[velocity] = rng.normal(size=part.positions.shape)
    rbs.Analysis([KineticEnergy(part)]).run(steps=1, dt=1.0, progress=False)
    wanted = math.fsum(0.5 * part[density] * part[volume] * (part[velocity] ** 2).sum(axis=1))
    assert part[kinetic_energy] == pytest.approx(wanted, rel=1e-13)  # positive terms: an ulp per level of the sum


def test_energies_are_those_of_the_body():
    """Of a bar of six nodes and a layer of two that all move alike: 6 ½ ρ V v², and the energy of their halves."""
    part = rbs.Part("bar", rbs.Box(size=6.0)).discretize(1.0)
    part.extend("clamp", "-x", 2.0)
    part.connect(2.0)
    part[density], part[velocity], part[dissipation_density] = 2.0, 3.0, 5.0
    part[displacement] = 1e-3 * part.positions
    force = BondBased(part, E=1.0)
    relations = [force, KineticEnergy(part), StrainEnergy(part, [force]), FractureDissipation(part)]
    rbs.Analysis(relations).run(steps=1, dt=1e-9, progress=False)
    assert part[kinetic_energy] == 6 * 0.5 * 2.0 * 9.0
    assert part[fracture_dissipation] == 6 * 5.0
    assert part[strain_energy] == pytest.approx(part[strain_energy_density][part.body].sum(), rel=1e-14)
    assert part[strain_energy_density][:2].min() > 0.0


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_strain_energy_of_a_brittle_body(dimension, rng):
    """W_i = ½ Σ μ ½ c s² |ξ| V_j and U = Σ W V, broken bonds left out."""
    part = body(dimension)
    part[displacement] = rng.uniform(-5e-5, 5e-5, part.positions.shape)
    steel = BondBased(part, E=1e9, fracture=CriticalStretch(0.05))
    rbs.Analysis([steel, StrainEnergy(part, [steel])]).run(steps=1, dt=1.0, force_dt=True, progress=False)
    i, j = ends(part)
    X, y = part.positions, part.positions + part[displacement]
    rest = np.linalg.norm(X[j] - X[i], axis=1)
    s = np.linalg.norm(y[j] - y[i], axis=1) / rest - 1
    holds = part.bonds.intact
    assert 0 < np.count_nonzero(holds) < len(holds)
    held = holds * 0.25 * steel.c * s**2 * rest * part[volume][j]
    wanted = np.bincount(i, held, len(part))
    np.testing.assert_allclose(part[strain_energy_density], wanted, rtol=1e-11)
    assert part[strain_energy] == pytest.approx(math.fsum(wanted * part[volume]), rel=1e-11)


def test_strain_energy_is_that_of_now_even_where_the_force_is_older():
    """Behind a drift the force is of the step before, the energy is not."""
    part = body(1, notched=False)
    part[displacement] = 0.0
    steel = BondBased(part, E=1e9)

    class Pull(rbs.Boundary):
        """Stretches by one part in a thousand."""

        updates = (displacement,)

        def apply(self, clock):
            self[displacement][...] = 1e-3 * self.part.positions

    measure = StrainEnergy(part, [steel])
    rbs.Analysis([steel, Pull(part), measure]).run(steps=1, dt=1.0, force_dt=True, progress=False)
    i, j = ends(part)
    rest = np.abs(part.positions[j] - part.positions[i])[:, 0]
    wanted = math.fsum(0.25 * steel.c * 1e-6 * rest * part[volume][j] * part[volume][i])
    assert part[strain_energy] == pytest.approx(wanted, rel=1e-9)  # a stretch of 1e-3 has thirteen digits


def test_strain_energy_of_what_has_none_is_refused():
    part, other = body(1), body(1)
    with pytest.raises(BadInput, match="does not know its energy"):
        StrainEnergy(part, [Damage(part)])
    with pytest.raises(BadInput, match="belongs to another part"):
        StrainEnergy(part, [BondBased(other, E=1e9)])


def test_fracture_dissipation(rng):
    part = body(2)
    part[dissipation_density] = rng.uniform(size=len(part))
    rbs.Analysis([FractureDissipation(part)]).run(steps=1, dt=1.0, progress=False)
    assert part[fracture_dissipation] == pytest.approx(math.fsum(part[dissipation_density] * part[volume]), rel=1e-13)


def test_fracture_dissipation_without_fracture_is_a_gap():
    part = body(2)
    part[displacement] = 0.0
    with pytest.raises(MissingField, match="'dissipation_density'"):
        rbs.Analysis([BondBased(part, E=1e9), FractureDissipation(part)]).prepare()
