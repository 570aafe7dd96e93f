"""One row of the benchmark, in a process of its own: prints its figures as JSON."""

from __future__ import annotations

import json
import os
import resource
import statistics
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np

import rbs_core as rbs

SPACING = 1e-4


def scene(dimension: int, n: int, storage: str, precision: str) -> dict[str, float]:
    """Force loop, whole step, search, compilation and memory of a square or cube with breaking bonds and m = 3.015."""
    import numba
    from machine import sample

    from rbs_plugins import BondBased, CriticalStretch, VelocityVerlet
    from rbs_plugins.fields import density, displacement, velocity

    part = rbs.Part("part", rbs.Box(size=(n * SPACING,) * dimension), precision=precision).discretize(SPACING)
    seconds = []
    for _ in range(2 if dimension == 2 or n <= 50 else 1):
        begin = time.perf_counter()
        part.connect(3.015 * SPACING, storage=storage)
        seconds.append(time.perf_counter() - begin)
    first, again = seconds[0], seconds[-1]
    part[density] = 8000.0
    force = BondBased(part, E=192e9, fracture=CriticalStretch(0.04472), active=None if storage == "list" else False)
    verlet = VelocityVerlet(part)
    figures = {"nodes": len(part), "bonds": len(part.bonds), "search_first": first, "search": again}
    with rbs.Analysis(verlet.step([force])) as analysis:
        begin = time.perf_counter()
        dt = 0.5 * analysis.stable_dt()
        figures["prepare"] = time.perf_counter() - begin
        figures["compile"] = figures["prepare"] + first - figures["search"]
        part[displacement] = 1e-3 * SPACING * np.random.default_rng(0).standard_normal(part.positions.shape)
        force.begin(analysis.clock)  # a lattice looks at its bonds then
        cores = os.cpu_count() or 1
        for threads in sorted({1, cores}):
            numba.set_num_threads(threads)
            loop = sample(force._loops._force, 25 if dimension == 2 else 5)
            figures.update({f"force_{threads}_{which}": value for which, value in loop.items()})
        part[displacement] = 0.0
        part[velocity] = 1e-3 * np.random.default_rng(1).standard_normal(part.positions.shape)
        # the relation also makes positions from displacements: that belongs to the step, not to the loop over bonds
        move = sample(force._loops.start, 15)["median"]
        steps, seconds, ratios = (20 if dimension == 2 else 3), [], []
        for run in range(1, 10):
            report = analysis.run(steps=run * steps, dt=dt, progress=False)
            loop = next(row.seconds for row in report.rows if row.name == force.label)
            seconds.append(report.seconds / steps)
            ratios.append(report.seconds / (loop - steps * move))
        figures.update(step_best=min(seconds), step_median=statistics.median(seconds), step_largest=max(seconds))
        figures["step_over_force"] = statistics.median(ratios)
    figures["bytes_per_bond"] = part.bonds.nbytes / len(part.bonds)
    figures["peak_GiB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    return figures


def main() -> None:
    what, size = sys.argv[1], int(sys.argv[2])
    if what == "limits":
        from machine import limits

        figures = limits(size)
    else:
        figures = scene({"plate": 2, "cube": 3}[what], size, *sys.argv[3:])
    print(json.dumps(figures))


if __name__ == "__main__":
    main()
