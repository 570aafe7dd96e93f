"""Collapsed stress against sums written out in numpy, classical stress, energy, and rotations."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import BondBased, Correspondence, Damage, OrdinaryStateBased, PeridynamicStress, StrainEnergy, Stress
from rbs_plugins.constitutive.stress import saint_venant_kirchhoff
from rbs_plugins.fields import displacement, peridynamic_stress, strain_energy_density, stress, volume
from rbs_plugins.testing import CLOUDS, body, ends, rotation

E = 1e9


def run(*relations):
    rbs.Analysis(list(relations)).run(steps=1, dt=1.0, force_dt=True, progress=False)


def block(dimension, storage="lattice", ratio=3.015):
    """15 nodes along each axis, so that the family of the families of the middle one is whole."""
    part = rbs.Part("block", rbs.Box(size=[15e-3] * dimension)).discretize(1e-3)
    part.connect(ratio * 1e-3, storage=storage)
    return part, len(part) // 2


def classical(eps, nu):
    """Hooke's law, in plane stress for a plane."""
    d = len(eps)
    if d == 1:
        return E * eps
    lame = E * nu / (1 - nu**2) if d == 2 else E * nu / (1 + nu) / (1 - 2 * nu)
    return E / (1 + nu) * eps + lame * np.trace(eps) * np.eye(d)


@pytest.mark.parametrize("cloud", CLOUDS)
@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_it_is_the_sum_that_it_says(dimension, cloud, rng):
    part = body(dimension, cloud)
    part[displacement] = rng.uniform(-1e-5, 1e-5, part.positions.shape)
    steel = BondBased(part, E=E)
    run(steel, Stress(part, steel))
    i, j = ends(part)
    xi = part.positions[j] - part.positions[i]
    d = xi + (part[displacement][j] - part[displacement][i]).astype(float)
    rest, length = np.linalg.norm(xi, axis=1), np.linalg.norm(d, axis=1)
    pull = 0.5 * steel.c * (length / rest - 1) / length * part[volume][j] * part.bonds.intact
    wanted = np.zeros(part[stress].shape)
    np.add.at(wanted, i, pull[:, None, None] * d[:, :, None] * xi[:, None, :])
    limit = 1e-5 if cloud == "single" else 1e-11
    np.testing.assert_allclose(part[stress], wanted, atol=limit * np.abs(wanted).max())


@pytest.mark.parametrize("storage", ["list", "lattice"])
@pytest.mark.parametrize(("dimension", "model", "nu", "limit"), [
    (1, OrdinaryStateBased, 0.0, 1e-9),
    (2, BondBased, 1 / 3, 0.042), (2, OrdinaryStateBased, 0.2, 0.019),
    (3, BondBased, 1 / 4, 0.083), (3, OrdinaryStateBased, 0.2, 0.042),
])  # fmt: skip
def test_in_a_uniform_strain_it_is_the_classical_stress(dimension, model, nu, limit, storage, rng):
    """To the lattice error at m = 3.015 without partial volumes; both stresses agree to rounding."""
    part, middle = block(dimension, storage)
    gradient = np.random.default_rng(1).normal(size=(dimension, dimension)) * 1e-7
    part[displacement] = part.positions @ gradient.T
    force = model(part, E=E, **({} if dimension == 1 or model is BondBased else {"nu": nu}))
    run(*force.feeders, force, Stress(part, [force]), PeridynamicStress(part, [force]))
    wanted = classical(0.5 * (gradient + gradient.T), nu)
    assert np.abs(part[stress][middle] - wanted).max() < limit * np.abs(wanted).max()
    np.testing.assert_allclose(part[peridynamic_stress][middle], part[stress][middle], atol=1e-8 * np.abs(wanted).max())


@pytest.mark.parametrize("model", [BondBased, OrdinaryStateBased])
def test_it_is_the_derivative_of_the_energy(model):
    """dW = P : dF at a finite uniform deformation."""
    part, middle = block(2)
    force = model(part, E=E, **({} if model is BondBased else {"nu": 0.1}))
    F, dF = np.array([[1.02, 0.03], [-0.01, 0.97]]), np.array([[0.3, -0.5], [0.7, 0.2]])
    energies = []
    for step in (-1e-6, 1e-6, 0.0):
        part[displacement] = part.positions @ (F + step * dF - np.eye(2)).T
        run(*force.feeders, force, StrainEnergy(part, force), Stress(part, force))
        energies.append(part[strain_energy_density][middle])
    rate = (energies[1] - energies[0]) / 2e-6
    assert np.sum(part[stress][middle] * dF) == pytest.approx(rate, rel=1e-7)


@pytest.mark.parametrize("dimension", [2, 3])
def test_it_turns_with_the_body(dimension):
    """P' = R P and σ' = R σ Rᵀ; σ is symmetric."""
    part, middle = block(dimension)
    steel, R = BondBased(part, E=E), rotation(dimension)
    U = np.eye(dimension) + 0.02 * np.random.default_rng(3).normal(size=(dimension, dimension))
    found = []
    for F in (U, R @ U):
        part[displacement] = part.positions @ (F - np.eye(dimension)).T
        for kind in ("first Piola-Kirchhoff", "Cauchy"):
            run(steel, Stress(part, steel, kind))
            found.append(part[stress][middle].copy())
    piola, cauchy, piola_turned, cauchy_turned = found
    size = np.abs(piola).max()
    np.testing.assert_allclose(piola_turned, R @ piola, atol=1e-11 * size)
    np.testing.assert_allclose(cauchy_turned, R @ cauchy @ R.T, atol=1e-11 * size)
    np.testing.assert_allclose(cauchy, piola @ U.T / np.linalg.det(U), atol=1e-11 * size)
    np.testing.assert_allclose(cauchy, cauchy.T, atol=1e-11 * size)


@pytest.mark.parametrize(("nu", "cells", "E_error", "nu_error"), [
    (0.1, 3, 1.96, -17.65), (0.1, 5, 0.14, -1.29), (0.2, 3, 2.14, -8.57), (0.4, 5, 0.18, -0.27),
])  # fmt: skip
def test_constants_of_a_plate_from_stress_and_strain(nu, cells, E_error, nu_error):
    """Sarego (2016, eq. 4.17), recomputed by its rule of volumes: errors of E and ν in percent, for ω = 1."""
    part = rbs.Part("plate", rbs.Box(size=(27e-3, 27e-3))).discretize(1e-3)
    part.connect(cells * 1e-3, reach=(cells + 0.5) * 1e-3)
    force = OrdinaryStateBased(part, E=E, nu=nu, partial_volume="linear")
    eps = np.diag([1e-7, 3e-8])
    part[displacement] = part.positions @ eps
    run(*force.feeders, force, Stress(part, force))
    sxx, syy = np.diag(part[stress][len(part) // 2])
    found = np.linalg.solve([[syy, eps[0, 0]], [sxx, eps[1, 1]]], [sxx, syy])
    errors = 100 * (found[::-1] / [E, nu] - 1)
    np.testing.assert_allclose(errors, [E_error, nu_error], atol=0.05)


def test_bad_input_is_refused():
    part, other = body(2), body(2)
    with pytest.raises(BadInput, match="no force is given"):
        Stress(part, [])
    with pytest.raises(BadInput, match="no force state"):
        Stress(part, [Damage(part)])
    with pytest.raises(BadInput, match="offers its own stress"):
        Stress(part, [Correspondence(part, saint_venant_kirchhoff, E=E, nu=0.3)])
    with pytest.raises(BadInput, match="other bonds"):
        Stress(part, BondBased(other, E=E))
    with pytest.raises(BadInput, match="kind='Kirchhoff' must be one of"):
        Stress(part, BondBased(part, E=E), "Kirchhoff")
    part[displacement] = 0.0
    alone = Stress(part, BondBased(part, E=E))
    with pytest.raises(BadInput, match="not in the list of relations"):
        run(alone)
