"""Rotations, reciprocal bases, and vectors that cannot be turned about. Axes from outside: see test_mapping.py."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.space.bases import combined, orthonormal, reciprocal, rotation, three_axes


def test_a_rotation_follows_the_rule_of_the_right_hand():
    assert np.allclose(np.eye(3) @ rotation(np.pi / 2), [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-15)
    assert np.allclose([[0.0, 1.0, 0.0]] @ rotation(np.pi / 2, (7.0, 0.0, 0.0)), [[0, 0, 1]], atol=1e-15)
    assert np.allclose([[1.0, 0.0, 0.0]] @ rotation(2 * np.pi / 3, (1, 1, 1)), [[0, 1, 0]], atol=1e-15)
    assert np.array_equal(rotation(0.0, (0.3, 0.2)), np.eye(3))


@pytest.mark.parametrize("angle", [1e-9, 1e-3, 0.3, 2.0, np.pi, -40.0])
def test_a_rotation_keeps_its_axis_lengths_and_orientation(angle, rng):
    axis = rng.normal(size=3)
    matrix = rotation(angle, axis)
    assert np.allclose(axis @ matrix, axis, rtol=1e-15)
    assert np.abs(matrix @ matrix.T - np.eye(3)).max() < 5e-16
    assert np.linalg.det(matrix) == pytest.approx(1.0, rel=1e-15)
    assert np.trace(matrix) == pytest.approx(1.0 + 2.0 * np.cos(angle), abs=1e-15)
    assert np.allclose(matrix @ rotation(-angle, axis), np.eye(3), atol=1e-15)


def test_small_angles_keep_their_digits():
    """The part along the axis to the point is 1 - cos(angle), which plain arithmetic would lose altogether."""
    assert rotation(1e-9)[0, 1] == pytest.approx(1e-9, rel=1e-15)
    assert (rotation(1e-5)[0, 0] - 1.0) == pytest.approx(-5e-11, rel=1e-5)  # what one unit of round-off allows


def test_a_hundred_thousand_rotations_stay_orthonormal(rng):
    matrix, step = np.eye(3), rotation(0.01, rng.normal(size=3))
    for _ in range(100_000):
        matrix = orthonormal(matrix @ step)
    assert np.abs(matrix @ matrix.T - np.eye(3)).max() < 1e-15


def test_components_are_scalar_products_with_the_reciprocal_basis(rng):
    basis = rng.normal(size=(50, 3, 3)) * rng.uniform(1e-6, 1e6, (50, 3, 1))
    components = rng.normal(size=(50, 3))
    vectors = (components[:, :, None] * basis).sum(axis=1)
    found = (vectors[:, None, :] * reciprocal(basis)).sum(axis=2)
    size = np.linalg.norm(vectors, axis=1)[:, None] / np.linalg.norm(basis, axis=2)
    assert (np.abs(found - components) < 1e-13 * size * np.linalg.cond(basis)[:, None]).all()


def test_vectors_in_a_plane_have_no_reciprocal_basis():
    flat = np.array([[[1.0, 0, 0], [0, 1, 0], [1, 1, 0]], np.eye(3), np.zeros((3, 3))])
    assert np.isnan(reciprocal(flat)).all(axis=(1, 2)).tolist() == [True, False, True]


def test_products_have_the_same_bits_in_any_array(rng):
    points, rows = rng.normal(size=(101, 3)), rng.normal(size=(3, 3))
    together = combined(points, rows)
    assert np.array_equal(together, np.vstack([combined(points[i : i + 1], rows) for i in range(101)]))
    assert np.allclose(together, points @ rows, rtol=1e-14)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: rotation(0.1, (0, 0, 0)),
            r"axis = \(0.0, 0.0, 0.0\) has no length; give a vector of any other length",
        ),
        (lambda: rotation(0.1, 2.0), r"axis = \(2.0,\) has one component; give 3"),
        (lambda: rotation(np.nan), r"angle = nan is not finite"),
        (lambda: rotation(0.1, (0, 0, np.inf)), r"axis\[2\] = inf is not finite"),
        (lambda: three_axes([(1, 0), (0, 0)]), r"axes\[1\] = .* has no length"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
