"""Small displacements: forces are a linear function of displacements, the slope of those of large ones."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import (
    BondBased,
    CriticalStretch,
    FractureDissipation,
    KineticEnergy,
    OrdinaryStateBased,
    StrainEnergy,
    VelocityVerlet,
)
from rbs_plugins.fields import (
    density,
    displacement,
    force_density,
    fracture_dissipation,
    kinetic_energy,
    strain_energy,
    velocity,
)

DX = 0.1
MODELS = {
    "bonds": lambda part, **more: BondBased(part, 1e9, **more),
    "solid": lambda part, **more: OrdinaryStateBased(part, 1e9, 0.1, **more),
}


def force(model, u, storage, **options):
    part = rbs.Part("plate", rbs.Box(size=(6 * DX, 5 * DX))).discretize(DX).connect(3.015 * DX, storage=storage)
    part[displacement] = u
    made = MODELS[model](part, **options)
    energy = StrainEnergy(part, made)
    rbs.Analysis([made, energy]).run(steps=1, dt=1e-9, force_dt=True, progress=False)
    return part[force_density].copy(), float(part[strain_energy])


@pytest.mark.parametrize("storage", ["list", "lattice"])
@pytest.mark.parametrize("model", MODELS)
def test_forces_are_the_slope_of_those_of_large_displacements(model, storage):
    u = np.random.default_rng(4).uniform(-1, 1, (30, 2)) * DX
    exact, energy = force(model, u, storage, linear=True)
    there, back = (force(model, sign * 1e-5 * u, storage)[0] for sign in (1, -1))
    np.testing.assert_allclose(exact, (there - back) / 2e-5, atol=1e-7 * np.abs(exact).max())
    twice, fourfold = force(model, 2 * u, storage, linear=True)
    np.testing.assert_allclose(twice, 2 * exact, rtol=1e-9, atol=1e-12 * np.abs(exact).max())
    assert fourfold == pytest.approx(4 * energy, rel=1e-10)
    # of a linear force, half of the work is the energy
    assert -0.5 * float((exact * u).sum()) * DX**2 == pytest.approx(energy, rel=1e-10)


@pytest.mark.parametrize("model", MODELS)
def test_list_and_lattice_agree(model):
    u = np.random.default_rng(4).uniform(-1, 1, (30, 2)) * DX
    one, two = (force(model, u, storage, linear=True)[0] for storage in ("list", "lattice"))
    np.testing.assert_allclose(one, two, atol=1e-12 * np.abs(one).max())


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_the_energy_balance_closes_through_fracture(storage):
    part = rbs.Part("plate", rbs.Box(size=(24 * DX, 8 * DX))).discretize(DX).connect(3.015 * DX, storage=storage)
    part[density], part[displacement], part[velocity] = 1000.0, 0.0, part.positions * [30.0, 0.0]
    bonds = BondBased(part, 1e9, CriticalStretch(0.01), linear=True)
    measures = [KineticEnergy(part), StrainEnergy(part, bonds), FractureDissipation(part)]
    analysis = rbs.Analysis([*VelocityVerlet(part).step([bonds]), *measures])
    analysis.run(steps=1, dt=4e-6, progress=False)
    start = float(part[kinetic_energy])
    analysis.run(until=2.4e-3, dt=4e-6, progress=False)
    found = [float(part[kind]) for kind in (kinetic_energy, strain_energy, fracture_dissipation)]
    assert found[2] > 0.02 * start
    assert sum(found) == pytest.approx(start, rel=2e-3)
