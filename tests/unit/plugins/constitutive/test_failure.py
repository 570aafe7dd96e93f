"""Criteria of energy: what they refuse, which form they take, and both directions of a bond."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import (
    BondBased,
    BondEnergy,
    CriticalBondEnergy,
    CriticalNodalEnergy,
    CriticalStretch,
    FractureDissipation,
    MeanBondEnergy,
    OrdinaryStateBased,
    PairwiseForce,
    StrainEnergy,
    critical_bond_energy,
)
from rbs_plugins.fields import (
    bond_energy,
    breakable,
    displacement,
    fracture_dissipation,
    mean_bond_energy,
    strain_energy,
    strain_energy_density,
    volume,
    volume_fraction,
)


def plate(storage=None, horizon=3.015):
    part = rbs.Part("plate", rbs.Box(size=(9.0, 8.0))).discretize(1.0, thickness=2.0).connect(horizon, storage=storage)
    part[displacement] = np.random.default_rng(5).uniform(-1e-3, 1e-3, part.positions.shape)
    return part


def step(*relations, steps=1):
    rbs.Analysis(list(relations)).run(steps=steps, dt=1.0, force_dt=True, progress=False)


@pytest.mark.parametrize(("dimension", "across"), [(1, 2.0), (2, 0.1), (3, 1.0)])
def test_bonds_through_a_plane(dimension, across):
    """G0 = w0 ∫ dz ∫ dV, integrated over caps of families that lie beyond the plane."""
    horizon, count = 1.5, 2000
    depths = (np.arange(count) + 0.5) * horizon / count
    beyond = {
        1: horizon - depths,
        2: horizon**2 * np.arccos(depths / horizon) - depths * np.sqrt(horizon**2 - depths**2),
        3: math.pi * (horizon - depths) ** 2 * (2 * horizon + depths) / 3,
    }[dimension]
    crossing = across ** (dimension < 3) * float(beyond.sum()) * horizon / count
    assert critical_bond_energy(7.0, dimension, horizon, across) == pytest.approx(7.0 / crossing, rel=1e-4)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "either the energy w0 of a bond or the fracture_energy"),
        ({"w0": 1.0, "fracture_energy": 1.0}, "either the energy w0 of a bond or the fracture_energy"),
        ({"w0": -1.0}, "w0=-1.0 must be positive"),
        ({"fracture_energy": math.inf}, "fracture_energy=inf must be positive"),
        ({"w0": 1.0, "mode": "shear"}, "must be one of tension, both"),
        ({"w0": 1.0, "form": "tangent"}, "form='tangent' must be 'incremental' or 'secant'"),
        ({"w0": 1.0, "release": "later"}, "release='later' must be one of"),
    ],
)
def test_what_is_refused(given, words):
    with pytest.raises(BadInput, match=words):
        CriticalBondEnergy(**given)


def test_forms():
    part = plate()
    springs = BondBased(part, E=1e9)
    solid = OrdinaryStateBased(part, E=1e9, nu=0.2)
    like_springs = OrdinaryStateBased(part, E=1e9, nu=1 / 3)
    other = PairwiseForce(part, lambda stretch: 1e9 * stretch)
    forms = [CriticalBondEnergy(1.0).form_for(force) for force in (springs, solid, like_springs, other)]
    assert forms == ["secant", "incremental", "secant", "incremental"]
    assert CriticalBondEnergy(1.0, form="secant").form_for(solid) == "secant"
    with pytest.raises(BadInput, match="form='secant' is for BondBased"):
        CriticalBondEnergy(1.0, form="secant").form_for(other)
    with pytest.raises(BadInput, match="depends on the path"):
        CriticalBondEnergy(fracture_energy=1.0, form="secant").form_for(solid)


@pytest.mark.parametrize("make", [lambda p, c: BondBased(p, 1e9, c), lambda p, c: OrdinaryStateBased(p, 1e9, 0.1, c)])
def test_work_of_bonds(make):
    """Both directions of a bond take the same work to the bit, and all together the energy of the solid."""
    part = plate("list")
    force = make(part, CriticalBondEnergy(1e9, form="incremental"))
    step(force, StrainEnergy(part, [force]))
    offsets, neighbors = part.bonds.as_rows()
    ends = np.repeat(np.arange(len(part)), np.diff(offsets))
    work = dict(zip(zip(ends.tolist(), neighbors.tolist(), strict=True), part[bond_energy].tolist(), strict=True))
    assert all(work[i, j] == work[j, i] for i, j in work)
    total = 0.5 * (part[bond_energy] * part[volume][ends] * part[volume][neighbors]).sum()
    assert total == pytest.approx((part[strain_energy_density] * part[volume]).sum(), rel=1e-12)


@pytest.mark.parametrize("mode", ["tension", "both"])
@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_secant_and_incremental_break_the_same_springs(mode, storage):
    broken = []
    for form, store in (("secant", storage), ("incremental", "list")):
        part = plate(store)
        step(BondBased(part, E=1e9, fracture=CriticalBondEnergy(5.0, mode=mode, form=form)))
        broken.append(~part.bonds.intact)
    assert np.array_equal(*broken)
    assert 0.1 < broken[0].mean() < 0.9


@pytest.mark.parametrize("storage", ["list", "lattice"])
@pytest.mark.parametrize("partial", ["none", "linear"])
def test_mean_energy_of_nodes(storage, partial):
    part = plate(storage)
    force = OrdinaryStateBased(part, E=1e9, nu=0.2, fracture=CriticalNodalEnergy(1e30), partial_volume=partial)
    step(force, StrainEnergy(part, [force]))
    offsets, neighbors = part.bonds.as_rows()
    shares = part[volume_fraction] if partial == "linear" else np.ones(len(neighbors))
    family = np.add.reduceat(shares * part[volume][neighbors], offsets[:-1])
    assert part[mean_bond_energy] == pytest.approx(2 * part[strain_energy_density] / family, rel=1e-10)
    limit = float(np.median(part[mean_bond_energy]))
    force = OrdinaryStateBased(part, 1e9, 0.2, CriticalNodalEnergy(limit, mode="both"), partial_volume=partial)
    means = part[mean_bond_energy].copy()
    step(force)
    ends = np.repeat(np.arange(len(part)), np.diff(offsets))
    assert np.array_equal(~part.bonds.intact, 0.5 * (means[ends] + means[neighbors]) > limit)


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_energies_of_a_solid_whose_dissipation_is_recorded(storage):
    part = plate(storage)
    solid = OrdinaryStateBased(part, E=1e9, nu=0.2, fracture=CriticalStretch(1e-4))
    step(solid, StrainEnergy(part, [solid]), FractureDissipation(part))
    assert part[strain_energy] > 0
    assert part[fracture_dissipation] > 0


def test_within():
    part = plate()
    region = rbs.HalfSpace((0.0, 0.0), normal=(1.0, 0.0))
    step(BondBased(part, E=1e9, fracture=CriticalBondEnergy(1e-9, mode="both", within=region)))
    assert np.array_equal(part.bonds.intact, part[breakable] == 0)


def test_surface_corrections_are_refused():
    for criterion in (CriticalNodalEnergy(1.0), CriticalBondEnergy(1.0), CriticalBondEnergy(1.0, form="incremental")):
        with pytest.raises(BadInput, match="does not know the factors of a surface correction"):
            BondBased(plate(), E=1e9, fracture=criterion, surface_correction="volume")


def test_one_work_for_the_bonds_of_a_part():
    part = plate("list")
    forces = [BondBased(part, E=1e9, fracture=CriticalBondEnergy(1.0, form="incremental")) for _ in range(2)]
    with pytest.raises(BadInput, match="the work of one force"):
        step(*forces)


def test_other_parts_and_connections_are_refused():
    part, other = plate(), plate()
    force = BondBased(part, E=1e9)
    for relation in (BondEnergy, MeanBondEnergy):
        with pytest.raises(BadInput, match="belongs to another part"):
            relation(other, force)
    link = rbs.Connection(part, pairs=[[0, 50]])
    for criterion in (CriticalNodalEnergy(1.0), CriticalBondEnergy(1.0, form="incremental")):
        with pytest.raises(BadInput, match="is for bonds within a part"):
            BondBased(link, c=1.0, fracture=criterion)
