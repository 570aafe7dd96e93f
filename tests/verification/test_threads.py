"""Results are the same to the bit for one, two and four threads, more than the machine has included."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

SCRIPT = """
import hashlib, sys
import numba
import numpy as np
import rbs_core as rbs
from rbs_plugins import (
    BondBased, BoundaryDomain, CriticalStretch, Damage, FractureDissipation, JIntegral, KineticEnergy,
    PeridynamicStress, ReactionForce, Strain, StrainEnergy, Stress, VelocityVerlet,
)
from rbs_plugins.fields import (
    damage, density, displacement, force_density, fracture_dissipation, j_integral, kinetic_energy, peridynamic_stress,
    reaction_force, strain, strain_energy, stress, velocity,
)

print("threads", numba.config.NUMBA_NUM_THREADS)
for kind in sys.argv[1:]:
    dimension, storage, precision = kind.split("-")
    dimension = int(dimension)
    size = {1: (60_000.0,), 2: (90.0, 80.0), 3: (24.0, 16.0, 16.0)}[dimension]
    part = rbs.Part("body", rbs.Box(size=size), precision=precision).discretize(1.0).connect(3.015, storage=storage)
    part[density] = 1.0
    release = "next step" if dimension == 3 else "at once"
    force = BondBased(part, E=1.0, fracture=CriticalStretch(0.02, mode="both", release=release))
    half = size[0] / 2 - 1
    pulled = [BoundaryDomain(part, lambda X, s=s: s * X[:, 0] > half, velocity=(0.05 * s,) + (None,) * (dimension - 1))
              for s in (1, -1)]
    measures = [Damage(part), KineticEnergy(part), StrainEnergy(part, [force]), FractureDissipation(part)]
    late = {"when": rbs.last}
    measures += [Strain(part, **late), Stress(part, force, "Cauchy", **late), ReactionForce(part, pulled[0], **late)]
    measures += [PeridynamicStress(part, force, **late)] if dimension < 3 else []
    measures += [JIntegral(part, force, (0, 0), (1, 0), inner=7, outer=12, **late)] if dimension == 2 else []
    rbs.Analysis([*VelocityVerlet(part).step([force], pulled), *measures]).run(steps=40, progress=False)
    assert part.bonds.has_broken
    digest = hashlib.sha256()
    looked_at = [displacement, velocity, force_density, damage, kinetic_energy, strain_energy, fracture_dissipation]
    looked_at += [strain, stress, reaction_force]
    for field in looked_at + [each for each in (peridynamic_stress, j_integral) if each in part.fields]:
        digest.update(np.ascontiguousarray(part[field]).tobytes())
    digest.update(part.bonds.intact.tobytes())
    print(dimension, storage, precision, digest.hexdigest())
"""


KINDS = [
    "1-lattice-double",
    "2-lattice-double",
    "2-lattice-single",
    "2-list-double",
    "3-lattice-double",
    "3-list-double",
]


def results(threads: int, kinds: list[str]) -> list[str]:
    environment = {**os.environ, "NUMBA_NUM_THREADS": str(threads), "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *kinds], env=environment, cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    first, *digests = done.stdout.splitlines()
    assert first == f"threads {threads}"
    return digests


@pytest.mark.parametrize(
    "kinds", [["2-lattice-double", "3-list-double"], pytest.param(KINDS, marks=pytest.mark.verify)]
)
def test_one_two_and_four_threads(kinds):
    one, two, four = (results(threads, kinds) for threads in (1, 2, 4))
    assert len(one) == len(kinds)
    assert one == two == four
