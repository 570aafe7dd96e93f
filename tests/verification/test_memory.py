"""A scene pays for what it declares: nothing is allocated that no relation names."""

from __future__ import annotations

import gc
import tracemalloc

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import BondBased, CriticalStretch, Damage, FractureDissipation, StrainEnergy, VelocityVerlet
from rbs_plugins.fields import density

# What grows with no part: objects, code, the tables of a few hundred ranges.
SLACK = 2_000_000


def scene(n, dimension, storage, *, brittle=False, precision="double"):
    part = rbs.Part("body", rbs.Box(size=(float(n),) * dimension), precision=precision)
    part.discretize(1.0).connect(3.0, storage=storage)
    part[density] = 1.0
    force = BondBased(part, E=1.0, fracture=CriticalStretch(0.1) if brittle else None)
    measures = [Damage(part), StrainEnergy(part, [force]), FractureDissipation(part)] if brittle else []
    return rbs.Analysis([*VelocityVerlet(part).step([force]), *measures])


def traced(make):
    """What a scene holds after three steps, the most that it held on the way, and itself; bytes."""
    gc.collect()
    tracemalloc.start()
    try:
        analysis = make()
        tracemalloc.reset_peak()
        analysis.run(steps=3, progress=False)
        gc.collect()
        held, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    return held, peak, analysis


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize(("dimension", "n"), [(1, 300_000), (2, 400), (3, 40)])
@pytest.mark.parametrize("storage", ["list", "lattice"])
@pytest.mark.parametrize("brittle", [False, True])
def test_a_scene_holds_what_it_declares(storage, dimension, n, brittle, precision):
    scene(9, dimension, storage, brittle=brittle, precision=precision).run(steps=1, progress=False)  # compiles
    held, peak, analysis = traced(lambda: scene(n, dimension, storage, brittle=brittle, precision=precision))
    assert held <= analysis.nbytes + SLACK
    assert held >= analysis.nbytes - SLACK
    # on the way it looks at its state: at what a step begins with, whether forces are finite, how stiff nodes are
    (part,) = analysis.parts
    assert peak <= analysis.nbytes + 60 * len(part) + SLACK


def test_an_elastic_bar_has_six_fields_of_one_dimension():
    """No damage, no state of bonds, no dilatation, and no second dimension."""
    analysis = scene(1000, 1, None)
    analysis.run(steps=3, progress=False)
    (part,) = analysis.parts
    fields = {field.name: part[field].shape for field in part.fields}
    vectors = ("reference_position", "velocity", "force_density", "displacement")
    assert fields == {**dict.fromkeys(vectors, (1000, 1)), "volume": (1000,), "density": (1000,)}
    assert part.bonds.stored.nbytes <= 1000 * 8 + 1200  # a number of each node, three bits of each cell
    assert analysis.nbytes <= 1000 * (6 * 8 + 8) + 1200 * (1 + 2 * 8)  # displacement and force by cell


def test_each_part_has_its_precision():
    halves = [traced(lambda p=p: scene(300, 2, "lattice", precision=p))[0] for p in ("double", "single")]
    assert np.diff(halves)[0] < -(300**2) * (3 * 2 * 4 + 2 * 4)  # u, v and f; density and volume
