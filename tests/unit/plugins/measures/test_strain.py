"""Strains of affine and rotated bodies in closed form, singular families, and what is refused."""

from __future__ import annotations

import numba
import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import BondBased, Strain
from rbs_plugins.fields import deformation_gradient, displacement, singular_families, strain
from rbs_plugins.testing import CLOUDS, body, rotation


class Look(rbs.Measure):
    """Wants the deformation gradient."""

    reads = (deformation_gradient,)


def run(*relations):
    rbs.Analysis(list(relations)).run(steps=1, dt=1.0, force_dt=True, progress=False)


def affine(part, F):
    return (part.positions - part.positions[0]) @ (F - np.eye(part.dimension)).T


@pytest.mark.parametrize("cloud", CLOUDS)
@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("influence", ["constant", "conical"])
def test_affine_deformations_are_exact_also_at_surfaces_and_cracks(dimension, cloud, influence, rng):
    part = body(dimension, cloud)
    F = np.eye(dimension) + 0.1 * rng.normal(size=(dimension, dimension))
    part[displacement] = affine(part, F)
    run(Strain(part, influence=influence), Look(part))
    wanted = np.broadcast_to(F, (len(part), dimension, dimension))
    # single precision: displacements have 24 bits, and are differenced
    limit = 2e-5 if cloud == "single" else 1e-12
    np.testing.assert_allclose(part[deformation_gradient], wanted, atol=limit)
    np.testing.assert_allclose(part[strain], 0.5 * (wanted + wanted.swapaxes(1, 2)) - np.eye(dimension), atol=limit)
    assert part[singular_families] == 0


@pytest.mark.parametrize("dimension", [2, 3])
def test_green_lagrange_does_not_see_a_rotation(dimension, rng):
    part = body(dimension)
    U = np.eye(dimension) + 0.05 * np.diag(rng.normal(size=dimension))
    R = rotation(dimension)
    part[displacement] = affine(part, R @ U)
    run(Strain(part, "Green-Lagrange"))
    wanted = np.broadcast_to(0.5 * (U @ U - np.eye(dimension)), (len(part), dimension, dimension))
    np.testing.assert_allclose(part[strain], wanted, atol=1e-12)


def test_a_small_strain_keeps_its_digits():
    """1e-12 far from the origin: on a lattice the sums see the displacements, not the positions."""
    part = body(2, "lattice")
    part[displacement] = 1e-12 * part.positions
    run(Strain(part))
    np.testing.assert_allclose(part[strain][:, 0, 0], 1e-12, rtol=1e-11)


def test_families_that_span_no_volume_have_no_strain_and_are_counted():
    """Three nodes in a row in a plane, one alone, and a triangle far away."""
    points = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [50.0, 0.0], [90.0, 0.0], [91.0, 0.0], [90.0, 1.0]]
    part = rbs.Part.from_points("few", points, 1.0, spacing=1.0)
    with pytest.warns(UserWarning, match="no bond"):
        part.connect(1.5)
    F = np.array([[1.1, 0.2], [0.0, 0.9]])
    part[displacement] = part.positions @ (F - np.eye(2)).T
    run(Strain(part), Look(part))
    assert part[singular_families] == 4
    assert not part[strain][:4].any()
    np.testing.assert_array_equal(part[deformation_gradient][:4], np.broadcast_to(np.eye(2), (4, 2, 2)))
    np.testing.assert_allclose(part[deformation_gradient][4:], np.broadcast_to(F, (3, 2, 2)), atol=1e-13)


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_the_strain_is_the_same_for_any_number_of_threads(storage, rng):
    found = []
    part = rbs.Part("plate", rbs.Box(size=(0.2, 0.2))).discretize(1e-3).connect(3.015e-3, storage=storage)
    part[displacement] = rng.normal(size=part.positions.shape) * 1e-6
    before = numba.get_num_threads()
    for threads in (1, before):
        numba.set_num_threads(threads)
        run(Strain(part))
        found.append(part[strain].copy())
    assert np.array_equal(found[0], found[1])


def test_bad_input_is_refused():
    part = body(2)
    with pytest.raises(BadInput, match="kind='large' must be one of small, Green-Lagrange"):
        Strain(part, "large")
    with pytest.raises(BadInput, match="must be a Part"):
        Strain(BondBased(part, E=1e9))
    with pytest.raises(BadInput, match="the part has no bonds"):
        Strain(rbs.Part("loose", rbs.Box(size=(1.0, 1.0))).discretize(0.5))


def test_families_of_layers_are_not_counted():
    part = rbs.Part("plate", rbs.Box(size=(3.0, 3.0))).discretize(1.0)
    part.extend("nail", rbs.Box(size=(2.0, 0.5), center=(2.6, 0.0)))
    part.connect(1.0)
    part[displacement] = 0.0
    run(Strain(part))
    assert part[singular_families] == 0
