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


def resist(begin, end, thread, out, velocity, coefficient):
    """Out -= coefficient * velocity, rows (n, d) and one coefficient (n,) per row."""
    for i in range(begin, end):
        for k in range(out.shape[1]):
            out[i, k] -= coefficient[i] * velocity[i, k]
    return 0


def sum_resistance(begin, end, thread, velocity, coefficient, volume, displacement, path, past, partial, chunk):
    """partial[c] = work against the resistance over range c since the last call, by the trapezoidal rule.

    Path and past, the displacement and velocity of then, become those of now.
    """
    total = 0.0
    for i in range(begin, end):
        work = 0.0
        for k in range(velocity.shape[1]):
            work += (past[i, k] + velocity[i, k]) * (displacement[i, k] - path[i, k])
            past[i, k] = velocity[i, k]
            path[i, k] = displacement[i, k]
        total += 0.5 * coefficient[i] * volume[i] * work
    partial[begin // chunk] = total
    return 0


def take(begin, end, thread, target, source, nodes):
    """Target = source[nodes], one number each."""
    for i in range(begin, end):
        target[i] = source[nodes[i]]
    return 0


def put(begin, end, thread, target, source, nodes):
    """Target[nodes] += source, one number each, and clears the source; no node twice."""
    for i in range(begin, end):
        target[nodes[i]] += source[i]
        source[i] = 0.0
    return 0


def place(begin, end, thread, out, reference, displacement, nodes, turn, origin):
    """Out = origin + turn (X + u) of some nodes: their positions in other coordinates, rows (n, d)."""
    for i in range(begin, end):
        for k in range(out.shape[1]):
            total = 0.0
            for m in range(out.shape[1]):
                total += turn[k, m] * (reference[nodes[i], m] + displacement[nodes[i], m])
            out[i, k] = total + origin[k]
    return 0


def bring(begin, end, thread, target, source, nodes, turn):
    """Target[nodes] += turn^T source, and clears the source: vectors (n, d), back in coordinates of a part.

    No node twice.
    """
    for i in range(begin, end):
        for k in range(target.shape[1]):
            total = 0.0
            for m in range(target.shape[1]):
                total += turn[m, k] * source[i, m]
            target[nodes[i], k] += total
        for k in range(target.shape[1]):
            source[i, k] = 0.0
    return 0


def largest_distance(begin, end, thread, a, b, partial, chunk):
    """partial[c] = largest |a - b|^2 over range c, rows (n, d)."""
    largest = 0.0
    for i in range(begin, end):
        square = 0.0
        for k in range(a.shape[1]):
            square += (a[i, k] - b[i, k]) ** 2
        largest = max(largest, square)
    partial[begin // chunk] = largest
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
