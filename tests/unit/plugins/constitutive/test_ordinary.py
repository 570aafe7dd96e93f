"""The linear peridynamic solid: its energy and constants, its bond-based special case, interfaces, fracture."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import Connection
from rbs_plugins import (
    BondBased,
    Criterion,
    CriticalStretch,
    Dilatation,
    FractureDissipation,
    KineticEnergy,
    OrdinaryStateBased,
    StrainEnergy,
    VelocityVerlet,
)
from rbs_plugins.fields import (
    density,
    dilatation,
    displacement,
    force_density,
    fracture_dissipation,
    kinetic_energy,
    strain_energy,
    strain_energy_density,
    velocity,
)

E, DX = 3e9, 0.05
PLANES = {"stress": (2, {"plane": "stress"}), "strain": (2, {"plane": "strain"}), "3-D": (3, {})}


def block(dimension=2, n=13, storage=None, *, name="block", m=3.015, low=0.0, **across):
    middle = [low] + [0.0] * (dimension - 1)
    part = rbs.Part(name, rbs.Box(size=(n * DX,) * dimension, center=middle)).discretize(DX, **across)
    return part.connect(m * DX, storage=storage)


def step(*relations):
    rbs.Analysis(list(relations)).run(steps=1, dt=1e-9, force_dt=True, progress=False)


def classical(case, nu, strain):
    """Energy density of the isotropic solid, J/m^3."""
    shear = E / (2 * (1 + nu))
    lame = E * nu / (1 - nu**2) if case == "stress" else E * nu / ((1 + nu) * (1 - 2 * nu))
    return 0.5 * lame * np.trace(strain) ** 2 + shear * float((strain * strain).sum())


@pytest.mark.parametrize("nu", [-0.9, -0.2, 0.0, 0.2, 0.4, 0.499])
@pytest.mark.parametrize("case", PLANES)
def test_growth_alone_holds_the_classical_energy(case, nu):
    """Exact on any grid, where the families of all neighbors are whole: the weighted volume makes it so."""
    dimension, plane = PLANES[case]
    part = block(dimension, 13)
    part[displacement] = 1e-6 * part.positions
    solid = OrdinaryStateBased(part, E, nu, **plane)
    step(solid, StrainEnergy(part, solid))
    middle = int(np.linalg.norm(part.positions, axis=1).argmin())
    wanted = classical(case, nu, 1e-6 * np.eye(dimension))
    assert part[strain_energy_density][middle] == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("case", PLANES)
def test_any_strain_holds_the_classical_energy_but_for_the_grid(case):
    """The error of the grid is that of its fourth moments; it shrinks with the horizon over the spacing."""
    dimension, plane = PLANES[case]
    strain = 1e-6 * np.random.default_rng(3).uniform(-1, 1, (dimension, dimension))
    strain = 0.5 * (strain + strain.T)
    errors = []
    for m in (2.015, 4.015) if dimension == 3 else (2.015, 6.015):
        part = block(dimension, 17 if dimension == 3 else 25, m=m)
        part[displacement] = part.positions @ strain
        solid = OrdinaryStateBased(part, E, 0.3, **plane)
        step(solid, StrainEnergy(part, solid))
        middle = int(np.linalg.norm(part.positions, axis=1).argmin())
        errors.append(abs(part[strain_energy_density][middle] / classical(case, 0.3, strain) - 1.0))
    assert errors[1] < 0.5 * errors[0]
    assert errors[1] < 0.03


@pytest.mark.parametrize("storage", ["list", "lattice"])
@pytest.mark.parametrize(("case", "nu"), [("stress", 1 / 3), ("strain", 0.25), ("3-D", 0.25)])
def test_the_bond_based_material_is_a_special_case(case, nu, storage):
    """With ω = δ/|ξ| and the weighted volume of a whole family, to round-off, and without any dilatation."""
    dimension, plane = PLANES[case]
    forces = []
    for make in (
        lambda part: BondBased(part, E, **plane),
        lambda part: OrdinaryStateBased(part, E, nu, influence="inverse", weighted_volume="full", **plane),
    ):
        part = block(dimension, 8, storage, **({"thickness": 0.01} if dimension == 2 else {}))
        part[displacement] = np.random.default_rng(1).uniform(-1e-4, 1e-4, part.positions.shape)
        force = make(part)
        assert force.feeders == ()
        step(force)
        forces.append(part[force_density].copy())
        assert dilatation not in part
    np.testing.assert_allclose(forces[0], forces[1], atol=1e-12 * np.abs(forces[0]).max())


@pytest.mark.parametrize("nu", [0.1, 0.4])
def test_two_parts_with_a_connection_are_one_part(nu):
    """Families reach across; forces and energies are those of the whole."""

    def half(name, x):
        part = rbs.Part(name, rbs.Box(size=(4 * DX, 8 * DX), center=(x, 0.0))).discretize(DX)
        return part.connect(3.015 * DX, storage="list")

    whole = rbs.Part("whole", rbs.Box(size=(8 * DX, 8 * DX))).discretize(DX).connect(3.015 * DX, storage="list")
    parts = [half("left", -2 * DX), half("right", 2 * DX)]
    field = np.random.default_rng(2).uniform(-1e-4, 1e-4, whole.positions.shape)
    orders = [[int(np.linalg.norm(whole.positions - x, axis=1).argmin()) for x in part.positions] for part in parts]
    whole[displacement] = field
    for part, order in zip(parts, orders, strict=True):
        part[displacement] = field[order]
    solid = OrdinaryStateBased(whole, E, nu)
    step(solid, StrainEnergy(whole, solid))
    solids = [OrdinaryStateBased(part, E, nu) for part in parts]
    link = OrdinaryStateBased(Connection(*parts, horizon=3.015 * DX), between=solids)
    energies = [StrainEnergy(part, [own, link]) for part, own in zip(parts, solids, strict=True)]
    step(*solids, link, *energies)
    scale = np.abs(whole[force_density]).max()
    for part, order in zip(parts, orders, strict=True):
        np.testing.assert_allclose(part[force_density], whole[force_density][order], atol=1e-11 * scale)
    assert sum(float(part[strain_energy]) for part in parts) == pytest.approx(float(whole[strain_energy]), rel=1e-11)


def test_an_interface_of_two_materials():
    """Constants by node, and two parts with different solids: the same."""
    whole = rbs.Part("whole", rbs.Box(size=(8 * DX, 6 * DX))).discretize(DX).connect(3.015 * DX)
    right = whole.positions[:, 0] > 0
    field = np.random.default_rng(2).uniform(-1e-4, 1e-4, whole.positions.shape)
    whole[displacement] = field
    step(OrdinaryStateBased(whole, np.where(right, 10 * E, E), np.where(right, 0.1, 0.4)))
    parts, solids = [], []
    for name, side, young, nu in (("left", ~right, E, 0.4), ("right", right, 10 * E, 0.1)):
        part = rbs.Part(name, rbs.Everywhere(), dimension=2)
        part.place(whole.positions[side], whole[rbs.volume][side], spacing=DX, thickness=1.0).connect(3.015 * DX)
        part[displacement] = field[side]
        parts.append(part)
        solids.append(OrdinaryStateBased(part, young, nu))
    step(*solids, OrdinaryStateBased(Connection(*parts, horizon=3.015 * DX), between=solids))
    scale = np.abs(whole[force_density]).max()
    for part, side in zip(parts, (~right, right), strict=True):
        np.testing.assert_allclose(part[force_density], whole[force_density][side], atol=1e-11 * scale)


def torn(nu, dt, **options):
    """A plate that flies apart; energies at the start and at the end."""
    part = rbs.Part("plate", rbs.Box(size=(24 * DX, 12 * DX))).discretize(DX).connect(3.015 * DX)
    part[density], part[displacement], part[velocity] = 1000.0, 0.0, part.positions * [60.0, 0.0]
    solid = OrdinaryStateBased(part, 1e9, nu, CriticalStretch(0.01), **options)
    measures = [KineticEnergy(part), StrainEnergy(part, solid), FractureDissipation(part)]
    analysis = rbs.Analysis([*VelocityVerlet(part).step([solid]), *measures])
    kinds = (kinetic_energy, strain_energy, fracture_dissipation)
    analysis.run(steps=1, dt=dt, progress=False)
    start = sum(float(part[kind]) for kind in kinds)
    analysis.run(until=1.2e-3, dt=dt, progress=False)
    return part, start, {kind.name: float(part[kind]) for kind in kinds}


@pytest.mark.parametrize("nu", [0.1, 1 / 3, 0.45])
def test_the_energy_balance_closes_through_fracture(nu):
    part, start, found = torn(nu, 2e-6)
    assert part.bonds.has_broken
    assert found["fracture_dissipation"] > 0.02 * start
    # a failing bond's share of its own dilatation (a few per cent of what it frees) is not counted
    assert sum(found.values()) == pytest.approx(start, rel=0.02)


def test_weighted_volumes_that_follow_the_bonds_run_through_fracture():
    part, _, found = torn(0.2, 2e-6, weighted_volume="intact")
    assert part.bonds.has_broken
    assert all(np.isfinite(value) for value in found.values())


def test_a_criterion_may_look_at_the_dilatation():
    part = block(2, 8)
    part[displacement] = 1e-3 * part.positions

    def grown(dilatation_i, dilatation_j, limit):
        return 0.5 * (dilatation_i + dilatation_j) > limit

    step(OrdinaryStateBased(part, E, 0.2, Criterion(grown, limit=3e-3)))
    assert not part.bonds.has_broken
    step(OrdinaryStateBased(part, E, 0.2, Criterion(grown, limit=1e-3)))
    assert not part.bonds.intact.any()


def test_the_dilatation_may_be_listed_by_hand():
    part = block(2, 8)
    part[displacement] = 1e-4 * part.positions
    solid = OrdinaryStateBased(part, E, 0.2)
    names = [type(r).__name__ for r in rbs.Analysis([solid]).relations]
    assert names == ["Dilatation", "OrdinaryStateBased"]
    listed = rbs.Analysis([solid.dilatation, solid]).relations
    assert listed == [solid.dilatation, solid]


def test_wrong_arguments_are_refused():
    part, other = block(), block(name="other", low=2.0)
    link = Connection(part, other, horizon=30 * DX)
    with pytest.raises(rbs.BadInput, match=r"nu=0\.5 must be between -1 and 0\.5"):
        OrdinaryStateBased(part, E, 0.5)
    with pytest.raises(rbs.BadInput, match="give between=, one each of 'block' and 'other', and neither E nor nu"):
        OrdinaryStateBased(link, E, 0.3)
    with pytest.raises(rbs.BadInput, match="between= is for connections"):
        OrdinaryStateBased(part, between=[OrdinaryStateBased(other, E, 0.3)])
    with pytest.raises(rbs.BadInput, match="plane='strain' must be"):
        OrdinaryStateBased(block(3, 4), E, 0.3, plane="strain")
    mixed = np.full(len(part), 0.3)
    mixed[0] = 0.2
    with pytest.raises(rbs.BadInput, match="nodes of several materials have no common critical stretch"):
        OrdinaryStateBased(part, E, mixed, CriticalStretch(fracture_energy=10.0))
    Dilatation(part, "gaussian")
    with pytest.raises(rbs.BadInput, match="already has another influence function"):
        OrdinaryStateBased(part, E, 0.3, influence="conical")
