"""Loops over nodes and entries of arrays, for `loops.Loop`: nothing allocated, no range depends on another."""

from __future__ import annotations

import numpy as np

from rbs_plugins.loops.loop import CHUNK


def add(begin, end, thread, out, a, b):
    """Out = a + b, flat arrays."""
    x, y, z = out[begin:end], a[begin:end], b[begin:end]
    for i in range(x.size):
        x[i] = y[i] + z[i]
    return 0


def add_scaled(begin, end, thread, out, a, factor):
    """Out += factor * a, flat arrays."""
    x, y = out[begin:end], a[begin:end]
    for i in range(x.size):
        x[i] += factor * y[i]
    return 0


def add_divided(begin, end, thread, out, a, factor, divisor):
    """Out += factor * a / divisor, rows (n, d) and one divisor (n,) per row."""
    for i in range(begin, end):
        share = factor / divisor[i]
        for k in range(out.shape[1]):
            out[i, k] += share * a[i, k]
    return 0


def sum_products(begin, end, thread, a, b, partial, chunk):
    """partial[c] = sum of a * b over range c, flat arrays."""
    total = 0.0
    for i in range(begin, end):
        total += a[i] * b[i]
    partial[begin // chunk] = total
    return 0


def sum_motion(begin, end, thread, mass, volume, velocity, partial, chunk):
    """partial[c] = sum of density * volume * |velocity|^2 over range c of nodes."""
    total = 0.0
    for i in range(begin, end):
        square = 0.0
        for k in range(velocity.shape[1]):
            square += velocity[i, k] * velocity[i, k]
        total += mass[i] * volume[i] * square
    partial[begin // chunk] = total
    return 0


def chunks(n: int) -> np.ndarray:
    """Room for the partial sums of n items."""
    return np.zeros((n + CHUNK - 1) // CHUNK)
