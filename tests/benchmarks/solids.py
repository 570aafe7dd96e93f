"""Row of the benchmark: the passes of a state-based solid, its whole step and its memory."""

from __future__ import annotations

import os
import resource
import time

import numba
import numpy as np
from machine import sample
from rows import DIMENSION, Figures, body, brittle, of_steps, shake

import rbs_core as rbs


def solid(model: str, what: str, size: str, storage: str) -> Figures:
    """The passes of a state-based solid with breaking bonds, its whole step and memory, of a plate or cube; seconds."""
    from rbs_plugins import VelocityVerlet
    from rbs_plugins.fields import displacement, velocity

    dimension, n = DIMENSION[what], int(size)
    part, *_ = body((n,) * dimension, storage)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    force = brittle(part, model)
    figures: Figures = {"nodes": len(part), "bonds": len(part.bonds)}
    with rbs.Analysis(VelocityVerlet(part).step([force])) as analysis:
        begin = time.perf_counter()
        dt = 0.5 * analysis.stable_dt()
        figures["prepare"] = time.perf_counter() - begin
        shake(part)
        passes = {}
        for relation in (*force.feeders, force):
            relation.begin(analysis.clock)
            names = ("failure", "stress", "force") if model == "correspondence" else ("sum",)
            owner = "" if len(names) > 1 else f"{type(relation).__name__}_"
            passes |= {f"{owner}{name}": getattr(relation._loops, f"_{name}") for name in names}
        for threads in sorted({1, os.cpu_count() or 1}):
            numba.set_num_threads(threads)
            for name, loop in passes.items():
                figures[f"{name}_{threads}_best"] = sample(loop, int(np.clip(2e8 / len(part.bonds), 7, 40)))["best"]
        part[displacement] = 0.0
        part[velocity] = 1e-3 * np.random.default_rng(1).standard_normal(part.positions.shape)
        figures.update(of_steps(analysis, dt, int(np.clip(3e7 / len(part.bonds), 2, 50))))
        figures["held_per_bond"] = analysis.nbytes / len(part.bonds)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return {**figures, "search_GiB": before / 2**20, "peak_GiB": peak / 2**20}
