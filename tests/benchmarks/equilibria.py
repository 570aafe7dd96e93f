"""Row of the benchmark: assembly, products and solution of one linear equilibrium."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

import rbs_core as rbs

SPACING, RATIO = 1e-3, 3.015  # m; horizon over spacing
Figures = dict[str, float]


def pulled(shape: tuple[int, ...], model: str) -> tuple[rbs.Part, Any, rbs.Analysis]:
    """A plate or cube, clamped on the left and pulled to the right."""
    from rbs_plugins import BondBased, BoundaryDomain, Newton, OrdinaryStateBased

    d = len(shape)
    part = rbs.Part("part", rbs.Box(size=[n * SPACING for n in shape])).discretize(SPACING).connect(RATIO * SPACING)
    x = part.positions[:, 0]
    force: Any = (
        BondBased(part, 1e9, linear=True) if model == "bond-based" else OrdinaryStateBased(part, 1e9, 0.2, linear=True)
    )
    boundaries = [
        BoundaryDomain(part, x < x.min() + 2.5 * SPACING, displacement=[0.0] * d),
        BoundaryDomain(part, x > x.max() - 2.5 * SPACING, displacement=[1e-3 * np.ptp(x), *[0.0] * (d - 1)]),
    ]
    newton = Newton(part, force, boundaries)
    return part, newton, rbs.Analysis([newton], steps=1)


def equilibrium(model: str, *shape: str) -> Figures:
    """Seconds of the parts of one linear solution, its residual, and the size of the matrix."""
    import numba

    sizes = tuple(int(each) for each in shape)
    pulled(tuple(min(each, 12) for each in sizes), model)[2].run(progress=False)  # compiles
    part, newton, analysis = pulled(sizes, model)
    analysis.prepare()
    begin = time.perf_counter()
    analysis.run(progress=False)
    figures: Figures = {"nodes": len(part), "run": time.perf_counter() - begin}
    found, K = newton.history[-1], newton._K
    figures |= {
        "search": found.seconds,
        "residual": found.residuals[-1],
        "linear_iterations": newton._solver.iterations,
    }
    v, out = np.random.default_rng(0).normal(size=K.size), np.zeros(K.size)
    K.matrix()
    works = {"update": lambda: K.update(analysis.clock), "matrix": K.matrix, "product": lambda: K.multiply(v, out)}
    for name, work in works.items():
        for threads in sorted({1, numba.config.NUMBA_NUM_THREADS}):
            numba.set_num_threads(threads)
            figures[f"{name}_{threads}"] = min(_seconds(work) for _ in range(7))
    figures["entries"] = K.matrix().nnz
    return figures


def _seconds(work: Any) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin
