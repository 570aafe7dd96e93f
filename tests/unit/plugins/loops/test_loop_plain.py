"""With compilation switched off the loops run as plain Python: for a debugger, and with the same results."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import numpy as np
import pytest

SCENE = """
import json, sys
import numpy as np
import rbs_core as rbs
from rbs_plugins import CriticalStretch, Damage, FractureDissipation, PairwiseForce, StrainEnergy, VelocityVerlet
from rbs_plugins.fields import (damage, density, displacement, dissipation_density, force_density,
                                strain_energy_density, velocity)

warmth = rbs.Field("warmth", "node", "scalar", "K", "T", "Made up for this test.")


def warm(stretch, warmth_i, warmth_j, c):
    return c * (stretch - 1e-3 * (warmth_i + warmth_j)) if stretch < 0.01 else c * 0.01


def stiffening(stretch, c):
    return c * stretch * (1.0 + 3.0 * stretch)


def body(name, storage, precision="double"):
    part = rbs.Part(name, rbs.Box(size=(5.0, 4.0)) - rbs.Ball(0.8, (1.0, 1.0)), precision=precision)
    part.discretize(1.0).connect(2.1, storage=storage)
    part[density] = 1.0
    part[warmth] = np.cos(part.positions[:, 0])
    part[velocity] = 0.0
    part[displacement] = 0.01 * np.random.default_rng(3).standard_normal(part.positions.shape)
    return part


def one(storage, precision="double"):
    part = body("body", storage, precision)
    force = PairwiseForce(part, warm, CriticalStretch(0.02, release="next step"), c=2.0)
    measures = [StrainEnergy(part, [force]), FractureDissipation(part), Damage(part)]
    rbs.Analysis([*VelocityVerlet(part).step([force]), *measures]).run(steps=3, dt=0.1, force_dt=True, progress=False)
    found = {f.name: part[f].tolist() for f in (force_density, strain_energy_density, dissipation_density, damage)}
    return {**found, "frequency": force.squared_frequency().tolist(), "intact": part.bonds.intact.tolist()}


def several(storage):
    parts = [body(f"body {number}", storage) for number in range(4)]
    scene = []
    for number, part in enumerate(parts):
        scene += VelocityVerlet(part).step([PairwiseForce(part, (warm, stiffening)[number % 2], c=1.0 + number)])
    rbs.Analysis(scene).run(steps=2, dt=0.1, force_dt=True, progress=False)
    return {part.name: part[force_density].tolist() for part in parts}


print(json.dumps({"one": one, "several": several}[sys.argv[1]](*sys.argv[2:])))
"""


@pytest.mark.parametrize(
    ("scene", "digits"),
    [
        ("one list", 1e-13),  # the compiler may fuse products and sums, and reorder sums over rows
        ("one lattice", 1e-13),
        ("one lattice single", 1e-4),
        ("several list", 1e-13),
        ("several lattice", 1e-13),
    ],
)
def test_plain_python_gives_the_same_numbers(tmp_path, scene, digits):
    script = tmp_path / "scene.py"
    script.write_text(SCENE, encoding="utf-8")
    found = []
    for plain in ("0", "1"):
        environment = {**os.environ, "NUMBA_DISABLE_JIT": plain}
        command = [sys.executable, str(script), *scene.split()]
        done = subprocess.run(command, capture_output=True, text=True, env=environment)
        assert done.returncode == 0, done.stderr
        found.append(json.loads(done.stdout.splitlines()[-1]))
    compiled, python = found
    assert compiled.keys() == python.keys()
    for name, values in compiled.items():
        if name == "intact":
            assert values == python[name]
            assert 0 < sum(values) < len(values)
            continue
        assert np.any(values), name
        scale = np.abs(values).max()
        np.testing.assert_allclose(python[name], values, rtol=0, atol=digits * scale, err_msg=name)
