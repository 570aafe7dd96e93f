"""Results are the same to the bit for one, two and four threads, more than the machine has included."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

SCRIPT = """
import hashlib
import numba
import numpy as np
import rbs_core as rbs
from rbs_plugins import (
    BondBased, BoundaryDomain, CriticalStretch, Damage, FractureDissipation, KineticEnergy, StrainEnergy,
    VelocityVerlet,
)
from rbs_plugins.fields import (
    damage, density, displacement, force_density, fracture_dissipation, kinetic_energy, strain_energy, velocity,
)

print("threads", numba.config.NUMBA_NUM_THREADS)
for dimension, storage, precision in (
    (1, "lattice", "double"), (2, "lattice", "double"), (2, "lattice", "single"), (2, "list", "double"),
    (3, "lattice", "double"), (3, "list", "double"),
):
    size = {1: (60_000.0,), 2: (90.0, 80.0), 3: (24.0, 16.0, 16.0)}[dimension]
    part = rbs.Part("body", rbs.Box(size=size), precision=precision).discretize(1.0).connect(3.015, storage=storage)
    part[density] = 1.0
    release = "next step" if dimension == 3 else "at once"
    force = BondBased(part, E=1.0, fracture=CriticalStretch(0.02, mode="both", release=release))
    half = size[0] / 2 - 1
    pulled = [BoundaryDomain(part, lambda X, s=s: s * X[:, 0] > half, velocity=(0.05 * s,) + (None,) * (dimension - 1))
              for s in (1, -1)]
    measures = [Damage(part), KineticEnergy(part), StrainEnergy(part, [force]), FractureDissipation(part)]
    rbs.Analysis([*VelocityVerlet(part).step([force], pulled), *measures]).run(steps=40, progress=False)
    assert part.bonds.has_broken
    digest = hashlib.sha256()
    for field in (displacement, velocity, force_density, damage, kinetic_energy, strain_energy, fracture_dissipation):
        digest.update(np.ascontiguousarray(part[field]).tobytes())
    digest.update(part.bonds.intact.tobytes())
    print(dimension, storage, precision, digest.hexdigest())
"""


def results(threads: int) -> list[str]:
    environment = {**os.environ, "NUMBA_NUM_THREADS": str(threads), "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], env=environment, cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    first, *digests = done.stdout.splitlines()
    assert first == f"threads {threads}"
    return digests


def test_one_two_and_four_threads():
    one, two, four = (results(threads) for threads in (1, 2, 4))
    assert len(one) == 6
    assert one == two == four
