"""The loops over a lattice against those over rows, and what only a lattice can do."""

from __future__ import annotations

import numba
import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import BondBased, CriticalStretch, FractureDissipation, PairwiseForce, StrainEnergy, VelocityVerlet
from rbs_plugins.fields import (
    density,
    displacement,
    dissipation_density,
    force_density,
    intact,
    strain_energy_density,
    velocity,
    volume,
)

# Positions of a list round by eps |X| / 2 at either end; the largest stretches here are about a hundredth.
AGREE = 16 * np.finfo(float).eps * 20 / 1e-2

warmth = rbs.Field("warmth", "node", "scalar", "K", "T", "A test.")
grade = rbs.Field("grade", "bond", "scalar", "1", "g", "A test.")


def body(storage, dimension=2, *, hole=True, uneven=False, precision="double"):
    shape = {1: (30,), 2: (36, 31), 3: (9, 8, 7)}[dimension]
    box = rbs.Box(size=[float(n) for n in shape])
    geometry = box - rbs.Ball(2.2, [1.0] * dimension) if hole and dimension > 1 else box
    part = rbs.Part("body", geometry, precision=precision).discretize(1.0).connect(3.015, storage=storage)
    x = part.positions[:, 0]
    part.bonds.cut(
        lambda starts, ends: (
            (starts[:, 0] > 0) != (ends[:, 0] > 0)
            if dimension == 1
            else ((starts[:, 0] > 0) != (ends[:, 0] > 0)) & (np.abs(starts[:, 1] + ends[:, 1]) < 4)
        )
    )
    part[density] = 1000.0 + 10 * np.sin(x)
    part[warmth] = np.cos(x)
    if uneven:
        part[volume] = 1.0 + 0.3 * np.sin(3 * x)
    part[displacement] = 1e-2 * np.random.default_rng(3).standard_normal(part.positions.shape)
    return part


def linear(stretch, c):
    return c * stretch


def warm(stretch, warmth_i, warmth_j, c):
    """Expands with the mean temperature of its ends."""
    return c * (stretch - 1e-3 * (warmth_i + warmth_j))


def graded(extension, length, reference_length, grade, time, c):
    if extension > 0.01:
        return c * grade * (0.01 + 0.5 * (extension - 0.01)) * reference_length / length
    return c * grade * extension * (1.0 + time)


CASES = {
    "elastic": lambda part: PairwiseForce(part, linear, c=2.0),
    "brittle": lambda part: PairwiseForce(part, linear, CriticalStretch(0.01), c=2.0),
    "late": lambda part: PairwiseForce(part, linear, CriticalStretch(0.01, mode="both", release="next step"), c=2.0),
    "no-fail zone": lambda part: PairwiseForce(
        part, linear, CriticalStretch(0.01, within=rbs.Box(size=[9.0] * part.dimension)), c=2.0
    ),
    "partial volume": lambda part: BondBased(part, E=1e3, fracture=CriticalStretch(0.01), partial_volume="linear"),
    "fields of nodes": lambda part: PairwiseForce(part, warm, CriticalStretch(0.01), c=2.0),
    "everything": lambda part: PairwiseForce(part, graded, CriticalStretch(0.012), c=2.0),
}


def outcome(make, part, dissipation=False):
    part[grade] = 1.0
    part.bonds.tabulate(grade, lambda bonds: 1.0 + np.linalg.norm(bonds, axis=1))
    force = make(part)
    measures = [StrainEnergy(part, [force]), *([FractureDissipation(part)] if dissipation else [])]
    analysis = rbs.Analysis([force, *measures])
    analysis.run(steps=2, dt=0.1, force_dt=True, progress=False)
    part[displacement] *= 1.3
    analysis.run(steps=3, dt=0.1, force_dt=True, progress=False)
    fields = [force_density, strain_energy_density, *([dissipation_density] if dissipation else [])]
    return {**{f.name: part[f].copy() for f in fields}, "frequency": force.squared_frequency()}


@pytest.mark.parametrize(
    ("case", "dimension", "uneven"),
    [
        ("partial volume", 1, False),
        ("late", 2, False),
        ("fields of nodes", 2, False),
        ("no-fail zone", 2, False),
        ("everything", 3, True),
    ],
)
def test_both_representations_agree(case, dimension, uneven):
    parts = [body(storage, dimension, uneven=uneven) for storage in ("list", "lattice")]
    breaking = case not in ("elastic",)
    one, two = (outcome(CASES[case], part, dissipation=breaking) for part in parts)
    assert [part.bonds.storage for part in parts] == ["list", "lattice"]
    assert np.array_equal(parts[0].bonds.intact, parts[1].bonds.intact)
    assert not breaking or parts[0].bonds.has_broken
    for name, values in one.items():
        assert np.abs(values).max() > 0, name
        np.testing.assert_allclose(two[name], values, rtol=0, atol=AGREE * np.abs(values).max(), err_msg=name)


@pytest.mark.parametrize("case", ["elastic", "brittle", "fields of nodes"])
def test_cells_without_nodes_have_no_say(case):
    """Margins and holes are filled with NaN between two forces: nothing of that comes out."""
    part = body("lattice")
    part.bonds.tabulate(grade, lambda bonds: np.linalg.norm(bonds, axis=1))
    force = CASES[case](part)
    analysis = rbs.Analysis([force])
    analysis.run(steps=1, dt=0.1, force_dt=True, progress=False)
    clean = part[force_density].copy()
    empty = np.ones(part.bonds.stored.size, bool)
    empty[part.bonds.stored.cells] = False
    assert empty.any()
    part[force_density] = 0.0
    force._loops.position[:, empty] = np.nan
    assert force._loops.add(0.1, 0.1)
    np.testing.assert_array_equal(part[force_density], clean)


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="one core")
def test_threads_do_not_matter():
    found, before = [], numba.get_num_threads()
    for threads in (1, 2):
        numba.set_num_threads(threads)
        part = body("lattice")
        found.append((outcome(CASES["brittle"], part, dissipation=True), part.bonds.intact))
    numba.set_num_threads(before)
    assert all(np.array_equal(found[0][0][name], found[1][0][name]) for name in found[0][0])
    assert np.array_equal(found[0][1], found[1][1])


def hit(active, n=120, steps=80):
    """A plate with a notch whose corner is hit: a wave runs through it, and bonds break."""
    part = rbs.Part("plate", rbs.Box(size=(float(n), float(n)))).discretize(1.0).connect(3.015, storage="lattice")
    part.bonds.cut(rbs.Segment((-n / 2, 0.2), (0.0, 0.2)))
    part[density] = 1.0
    part[velocity] = lambda points: np.where(points.sum(axis=1) < 6 - n, 0.1, 0.0)[:, None] * np.ones(2)
    force = BondBased(part, E=1.0, fracture=CriticalStretch(0.02), active=active)
    report = rbs.Analysis(VelocityVerlet(part).step([force])).run(steps=steps, progress=False)
    return part, next(row for row in report.rows if row.name.startswith("BondBased"))


def test_skipping_what_nothing_has_reached_changes_no_bit():
    (every, all_of_it), (some, fewer), (chosen, _) = hit(False), hit(True), hit(None)
    assert all_of_it.saved == 0.0
    assert 0.05 < fewer.saved < 1.0
    assert every.bonds.has_broken
    for part in (some, chosen):
        for field in (displacement, velocity, force_density):
            assert np.array_equal(part[field], every[field])
        assert np.array_equal(part.raw(intact), every.raw(intact))


def test_a_body_whose_bonds_are_all_broken_costs_nothing():
    part = body("lattice")
    part[intact] = 0
    force = PairwiseForce(part, linear, c=2.0, active=False)
    rbs.Analysis([force]).run(steps=1, dt=0.1, force_dt=True, progress=False)
    assert force.visited() == 0
    assert not part[force_density].any()


@pytest.mark.parametrize(
    ("storage", "law", "why"),
    [
        ("list", linear, "the bonds are stored as list"),
        ("lattice", warm, "its law depends on more than the bond's own deformation"),
        ("lattice", lambda stretch, c: c * (stretch + 1.0), "its law is 2.0 at rest"),
    ],
)
def test_what_cannot_be_skipped_is_refused(storage, law, why):
    force = PairwiseForce(body(storage), law, active=True, c=2.0)
    with pytest.raises(BadInput, match=why):
        rbs.Analysis([force]).prepare()


def test_rest_is_rest():
    """Of a displaced and of an undisplaced body, stretches are exactly zero where neighbors move alike."""
    part = body("lattice")
    part[displacement] = 3.7
    force = PairwiseForce(part, linear, c=1e20, active=False)
    rbs.Analysis([force]).run(steps=1, dt=0.1, force_dt=True, progress=False)
    assert not part[force_density].any()


def test_single_precision_is_good_to_five_digits():
    one, two = (body("lattice", precision=precision) for precision in ("double", "single"))
    found = [outcome(CASES["brittle"], part, dissipation=True) for part in (one, two)]
    assert np.array_equal(one.bonds.intact, two.bonds.intact)
    for name, values in found[0].items():
        assert found[1][name].dtype == (np.float64 if name == "frequency" else np.float32)
        np.testing.assert_allclose(found[1][name], values, rtol=0, atol=1e-5 * np.abs(values).max(), err_msg=name)


def test_parameters_beyond_single_precision_are_refused():
    part = body("lattice", precision="single")
    with pytest.raises(BadInput, match=r"single precision, in which c = 1e\+40 cannot be computed with"):
        rbs.Analysis([PairwiseForce(part, linear, c=1e40)]).prepare()


@pytest.mark.parametrize("precision", ["double", "single"])
def test_several_forces_on_one_part_add_up(precision):
    """The first of them sets the force density, where nothing has been reached included; the others add."""

    def run(*factors):
        part = rbs.Part("sheet", rbs.Box(size=(60.0, 50.0)), precision=precision).discretize(1.0)
        part.connect(3.015, storage="lattice")
        part[displacement] = np.where(part.positions[:, :1] < -20, 1e-3 * np.sin(part.positions), 0.0)
        forces = [PairwiseForce(part, linear, c=factor) for factor in factors]
        for _ in range(2):  # what an earlier run has left does not count
            part[force_density] = 5.0
            rbs.Analysis(forces).run(steps=2, dt=0.1, force_dt=True, progress=False)
        return part[force_density]

    np.testing.assert_allclose(run(2.0, 1.0, 4.0), run(7.0), rtol=0, atol=1e-6 if precision == "single" else 1e-15)
