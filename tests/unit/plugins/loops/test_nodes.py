"""Node loops against numpy."""

from __future__ import annotations

import numba
import numpy as np
import pytest

from rbs_plugins.loops import nodes

SIZES = [1, 7, nodes.CHUNK, nodes.CHUNK + 1, 3 * nodes.CHUNK - 1]


def test_add(rng):
    a, b, out = rng.normal(size=(3, 50))
    nodes.add(out, a, b)
    assert np.array_equal(out, a + b)


def test_add_scaled(rng):
    out, a = rng.normal(size=(2, 50))
    wanted = out + 0.3 * a
    nodes.add_scaled(out, a, 0.3)
    np.testing.assert_allclose(out, wanted, rtol=4e-16, atol=4e-16)  # fused or not: one rounding of each product


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_add_divided(rng, dimension):
    out, a = rng.normal(size=(2, 50, dimension))
    divisor = rng.uniform(1.0, 2.0, 50)
    wanted = out + 0.3 * a / divisor[:, None]
    nodes.add_divided(out, a, 0.3, divisor)
    np.testing.assert_allclose(out, wanted, rtol=1e-15, atol=1e-15)


@pytest.mark.parametrize("size", SIZES)
def test_sums_by_chunks(rng, size):
    a, b = rng.normal(size=(2, size))
    partial = nodes.chunks(size)
    assert len(partial) == -(-size // nodes.CHUNK)
    nodes.sum_products(a, b, partial)
    scale = np.abs(a * b).sum()
    assert abs(partial.sum() - np.sum(a * b)) <= 1e-13 * scale  # a chunk of 4096 terms loses at most 4096 ulp of it
    mass, volume = rng.uniform(1.0, 2.0, (2, size))
    velocity = rng.normal(size=(size, 3))
    partial[:] = np.nan
    nodes.sum_motion(mass, volume, velocity, partial)
    wanted = np.sum(mass * volume * (velocity**2).sum(axis=1))
    assert partial.sum() == pytest.approx(wanted, rel=1e-12)


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="one core")
def test_sums_do_not_depend_on_threads(rng):
    a, b = rng.normal(size=(2, 50_000))
    before, found = numba.get_num_threads(), []
    for threads in (1, 2):
        numba.set_num_threads(threads)
        partial = nodes.chunks(len(a))
        nodes.sum_products(a, b, partial)
        found.append(partial.sum())
    numba.set_num_threads(before)
    assert found[0] == found[1]


def test_broken_share():
    """Three nodes: both bonds of the first hold, one of two of the second is broken, the third has none."""
    offsets = np.array([0, 2, 4, 4])
    neighbors = np.array([1, 2, 0, 2], np.uint32)
    intact = np.array([1, 1, 0, 1], np.uint8)
    volume = np.array([1.0, 2.0, 3.0])
    out = np.full(3, np.nan)
    nodes.broken_share(offsets, neighbors, intact, volume, out)
    assert out.tolist() == [0.0, 0.25, 0.0]
