"""Node loops of the built-in relations: one parallel pass over arrays, nothing allocated."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, prange

CHUNK = 4096  # sums are made chunk by chunk and then in order, so they do not depend on the threads


@njit(parallel=True, cache=True, error_model="numpy")
def add(out: Any, a: Any, b: Any) -> None:
    """Out = a + b, flat arrays."""
    for i in prange(out.size):
        out[i] = a[i] + b[i]


@njit(parallel=True, cache=True, error_model="numpy")
def add_scaled(out: Any, a: Any, factor: float) -> None:
    """Out += factor * a, flat arrays."""
    for i in prange(out.size):
        out[i] += factor * a[i]


@njit(parallel=True, cache=True, error_model="numpy")
def add_divided(out: Any, a: Any, factor: float, divisor: Any) -> None:
    """Out += factor * a / divisor, rows (n, d) and one divisor (n,) per row."""
    for i in prange(out.shape[0]):
        share = factor / divisor[i]
        for k in range(out.shape[1]):
            out[i, k] += share * a[i, k]


@njit(parallel=True, cache=True, error_model="numpy")
def broken_share(offsets: Any, neighbors: Any, intact: Any, volume: Any, out: Any) -> None:
    """Damage: out = 1 - sum of the intact neighbor volumes over the sum of all."""
    for i in prange(out.size):
        total, left = 0.0, 0.0
        for q in range(offsets[i], offsets[i + 1]):
            size = volume[neighbors[q]]
            total += size
            left += size if intact[q] != 0 else 0.0
        out[i] = 1.0 - left / total if total > 0 else 0.0


@njit(parallel=True, cache=True, error_model="numpy")
def sum_products(a: Any, b: Any, partial: Any) -> None:
    """partial[c] = sum of a * b over chunk c, flat arrays."""
    for c in prange(partial.size):
        total = 0.0
        for i in range(c * CHUNK, min((c + 1) * CHUNK, a.size)):
            total += a[i] * b[i]
        partial[c] = total


@njit(parallel=True, cache=True, error_model="numpy")
def sum_motion(mass: Any, volume: Any, velocity: Any, partial: Any) -> None:
    """partial[c] = sum of density * volume * |velocity|^2 over chunk c of nodes."""
    for c in prange(partial.size):
        total = 0.0
        for i in range(c * CHUNK, min((c + 1) * CHUNK, mass.size)):
            square = 0.0
            for k in range(velocity.shape[1]):
                square += velocity[i, k] * velocity[i, k]
            total += mass[i] * volume[i] * square
        partial[c] = total


def chunks(n: int) -> np.ndarray:
    """Room for the partial sums of n items."""
    return np.zeros((n + CHUNK - 1) // CHUNK)
