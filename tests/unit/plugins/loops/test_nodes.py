"""Node loops against numpy."""

from __future__ import annotations

import numba
import numpy as np
import pytest

from rbs_plugins.loops import Loop, Text, nodes

SIZES = [1, 7, nodes.CHUNK, nodes.CHUNK + 1, 3 * nodes.CHUNK - 1]


def run(function, count, **arguments):
    """Compiles and runs a loop."""
    Loop(Text.of(function), function.__name__, arguments, count)()


def test_add(rng):
    a, b, out = rng.normal(size=(3, 50))
    run(nodes.add, 50, out=out, a=a, b=b)
    assert np.array_equal(out, a + b)


def test_add_scaled(rng):
    out, a = rng.normal(size=(2, 50))
    wanted = out + 0.3 * a
    run(nodes.add_scaled, 50, out=out, a=a, factor=0.3)
    np.testing.assert_allclose(out, wanted, rtol=4e-16, atol=4e-16)  # fused or not: one rounding of each product


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_add_divided(rng, dimension):
    out, a = rng.normal(size=(2, 50, dimension))
    divisor = rng.uniform(1.0, 2.0, 50)
    wanted = out + 0.3 * a / divisor[:, None]
    run(nodes.add_divided, 50, out=out, a=a, factor=0.3, divisor=divisor)
    np.testing.assert_allclose(out, wanted, rtol=1e-15, atol=1e-15)


@pytest.mark.parametrize("size", SIZES)
def test_sums_by_chunks(rng, size):
    a, b = rng.normal(size=(2, size))
    partial = nodes.chunks(size)
    assert len(partial) == -(-size // nodes.CHUNK)
    run(nodes.sum_products, size, a=a, b=b, partial=partial, chunk=nodes.CHUNK)
    scale = np.abs(a * b).sum()
    assert abs(partial.sum() - np.sum(a * b)) <= 1e-13 * scale  # a chunk of 4096 terms loses at most 4096 ulp of it
    mass, volume = rng.uniform(1.0, 2.0, (2, size))
    velocity = rng.normal(size=(size, 3))
    partial[:] = np.nan
    run(nodes.sum_motion, size, mass=mass, volume=volume, velocity=velocity, partial=partial, chunk=nodes.CHUNK)
    wanted = np.sum(mass * volume * (velocity**2).sum(axis=1))
    assert partial.sum() == pytest.approx(wanted, rel=1e-12)


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="one core")
def test_sums_do_not_depend_on_threads(rng):
    a, b = rng.normal(size=(2, 50_000))
    before, found = numba.get_num_threads(), []
    for threads in (1, 2):
        numba.set_num_threads(threads)
        partial = nodes.chunks(len(a))
        run(nodes.sum_products, len(a), a=a, b=b, partial=partial, chunk=nodes.CHUNK)
        found.append(partial.sum())
    numba.set_num_threads(before)
    assert found[0] == found[1]
