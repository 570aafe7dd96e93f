"""Stress laws as plain Python: derivatives of their energies, objectivity, closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_plugins import tensors
from rbs_plugins.constitutive import stress

LAME, G = 1.3, 0.8
K = LAME + 2 * G / 3
ZERO = ((0.0,) * 3,) * 3
HYPERELASTIC = [law for law, known in stress.LAWS.items() if not known.state]


def nested(array):
    return tuple(map(tuple, np.asarray(array).tolist()))


def random_gradient(rng, size=0.1):
    return np.eye(3) + size * rng.standard_normal((3, 3))


def rotation(rng):
    q, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    return q * np.sign(np.linalg.det(q))


@pytest.mark.parametrize("law", HYPERELASTIC)
def test_stress_is_the_derivative_of_the_energy(law, rng):
    energy = stress.LAWS[law].potential
    F = random_gradient(rng)
    slope = np.empty((3, 3))
    for index in np.ndindex(3, 3):
        step = np.zeros((3, 3))
        step[index] = 1e-6
        slope[index] = (energy(nested(F + step), LAME, G) - energy(nested(F - step), LAME, G)) / 2e-6
    np.testing.assert_allclose(law(nested(F), LAME, G), slope, atol=1e-9)
    assert np.abs(law(nested(np.eye(3)), LAME, G)).max() == 0.0


@pytest.mark.parametrize("law", HYPERELASTIC[1:])
def test_stress_turns_with_the_body(law, rng):
    F, turn = random_gradient(rng), rotation(rng)
    np.testing.assert_allclose(law(nested(turn @ F), LAME, G), turn @ law(nested(F), LAME, G), atol=1e-13)


@pytest.mark.parametrize("law", HYPERELASTIC)
def test_small_strains_are_those_of_hooke(law, rng):
    H = 1e-7 * rng.standard_normal((3, 3))
    strain = (H + H.T) / 2
    expected = LAME * np.trace(strain) * np.eye(3) + 2 * G * strain
    np.testing.assert_allclose(law(nested(np.eye(3) + H), LAME, G), expected, atol=1e-12)


def test_hencky_of_a_pure_stretch_by_hand():
    a, b, c = 1.5, 0.8, 1.1
    logs = np.log([a, b, c])
    expected = np.diag((LAME * logs.sum() + 2 * G * logs) / [a, b, c])
    np.testing.assert_allclose(stress.hencky(nested(np.diag([a, b, c])), LAME, G), expected, atol=1e-14)


def test_plastic_flow_stays_on_the_yield_surface(rng):
    strain, alpha, flow = np.zeros((3, 3)), 0.0, ZERO
    direction = rng.standard_normal((3, 3))
    for step in range(20):
        F = nested(np.eye(3) + 0.05 * (step + 1) * (direction + direction.T))
        P, flow, alpha = stress.j2_plasticity(F, flow, alpha, K, G, 0.05, 0.3)
        strain = np.array(P) - np.trace(P) / 3 * np.eye(3)
        assert np.sqrt(1.5) * np.linalg.norm(strain) == pytest.approx(0.05 + 0.3 * alpha, rel=1e-12)
        assert np.trace(flow) == pytest.approx(0.0, abs=1e-14)


def test_tensor_functions_against_numpy(rng):
    for _ in range(100):
        A, B = rng.standard_normal((2, 3, 3))
        np.testing.assert_allclose(tensors.product(nested(A), nested(B)), A @ B, atol=1e-14)
        np.testing.assert_allclose(tensors.inverse(nested(A)), np.linalg.inv(A), rtol=1e-9, atol=1e-9)
        assert tensors.determinant(nested(A)) == pytest.approx(np.linalg.det(A), rel=1e-9, abs=1e-12)
        assert tensors.inner(nested(A), nested(B)) == pytest.approx((A * B).sum(), abs=1e-13)
        values, rows = tensors.principal(nested(A + A.T))
        np.testing.assert_allclose(sorted(values), np.linalg.eigvalsh(A + A.T), atol=1e-13)
        np.testing.assert_allclose(tensors.spectral(values, rows), A + A.T, atol=1e-13)
    assert tensors.principal(nested(np.eye(3)))[0] == (1.0, 1.0, 1.0)
