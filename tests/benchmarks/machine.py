"""Limits of this machine, measured beside the loops: memory bandwidth and the rate of vectorised sqrt + division."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable

import numba
import numpy as np
from numba import njit, prange


@njit(parallel=True)
def _triad(a, b, c):
    for i in prange(a.size):
        a[i] = b[i] + 3.0 * c[i]


@njit(parallel=True, error_model="numpy")
def _root_and_quotient(x, y, repeats):
    for lane in prange(x.shape[0]):
        a, b = x[lane], y[lane]
        for r in range(repeats):
            for i in range(a.size):
                b[i] = (a[i] + a[r & 1023]) / math.sqrt(a[i] + a[r & 1023])


@njit(parallel=True, error_model="numpy")
def _gather(table, places, sums):
    for lane in prange(places.shape[0]):
        total = 0.0
        for place in places[lane]:
            total += table[place]
        sums[lane] = total


def spread(seconds: list[float]) -> dict[str, float]:
    """Best, median and largest of measured seconds."""
    return {"best": min(seconds), "median": statistics.median(seconds), "largest": max(seconds)}


def sample(function: Callable[[], object], repeats: int) -> dict[str, float]:
    """Seconds of a call: best, median and largest of the repeats, after one call that does not count."""
    function()
    seconds = []
    for _ in range(repeats):
        begin = time.perf_counter()
        function()
        seconds.append(time.perf_counter() - begin)
    return spread(seconds)


def limits(threads: int) -> dict[str, float]:
    """Triad in GB/s (from memory, and from cache) and seconds per sqrt + division."""
    numba.set_num_threads(threads)
    found = {}
    for name, size in (("memory", 20_000_000), ("cache", 50_000)):
        a, b, c = (np.ones(size) for _ in range(3))
        found[f"triad_{name}_GB_per_s"] = 24 * size / sample(lambda a=a, b=b, c=c: _triad(a, b, c), 9)["best"] / 1e9
    for name, kind in (("", np.float64), ("single_", np.float32)):
        x = (np.random.default_rng(1).random((threads, 1024)) + 1).astype(kind)
        y = np.zeros_like(x)
        best = sample(lambda x=x, y=y: _root_and_quotient(x, y, 2000), 7)["best"]
        found[f"{name}sqrt_and_division_ns"] = best / (2000 * 1024 * threads) * 1e9
    for mebibytes in (2, 8, 128):
        table = np.ones(mebibytes * 2**17)
        places = np.random.default_rng(2).integers(0, len(table), (threads, 200_000))
        sums = np.zeros(threads)
        best = sample(lambda t=table, p=places, s=sums: _gather(t, p, s), 7)["best"]
        found[f"gather_{mebibytes}_MiB_ns"] = best / places.size * 1e9
    return found
