"""The plate with a pre-existing crack, small: energy balance, symmetry, threads, resumed runs."""

from __future__ import annotations

import itertools

import numba
import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import (
    BondBased,
    BoundaryDomain,
    CriticalStretch,
    CSVExporter,
    FractureDissipation,
    KineticEnergy,
    StrainEnergy,
    VelocityVerlet,
    read_table,
)
from rbs_plugins.fields import (
    damage,
    density,
    displacement,
    external_work,
    force_density,
    fracture_dissipation,
    kinetic_energy,
    strain_energy,
    velocity,
)
from tests.scenes import plate

ENERGIES = (kinetic_energy, strain_energy, external_work, fracture_dissipation)


def balance(path, *, share, s0=0.02, release="at once", end=2.5e-5, n=40):
    """Work that is in no energy, over the work, in every step; and the dissipated share of the work at the end."""
    side = 0.05
    spacing = side / n
    part = rbs.Part("plate", rbs.Box(size=(side, side + 6 * spacing))).discretize(spacing, thickness=spacing)
    part.connect(3.015 * spacing)
    part.bonds.cut(rbs.Segment((-side / 10, 0.0), (side / 10, 0.0)))
    part[density] = 8000.0
    fracture = CriticalStretch(s0, within=rbs.Box(size=(side, side / 2)), release=release)
    steel = BondBased(part, E=192e9, fracture=fracture)
    grips = [
        BoundaryDomain(part, rbs.HalfSpace((0, sign * side / 2), (0, sign)), velocity=(None, sign * 20.0))
        for sign in (1, -1)
    ]
    measures = [KineticEnergy(part), StrainEnergy(part, [steel]), FractureDissipation(part)]
    analysis = rbs.Analysis([*VelocityVerlet(part).step([steel], grips), *measures, CSVExporter(part, ENERGIES, path)])
    steps = round(end / (share * analysis.stable_dt()))
    analysis.run(steps=steps, dt=end / steps, progress=False)
    kinetic, strain, work, lost = (np.array(read_table(path)[field.name]) for field in ENERGIES)
    return (work - kinetic - strain - lost) / work, lost[-1] / work[-1]


@pytest.mark.parametrize("release", CriticalStretch.RELEASES)
def test_work_is_kinetic_strain_and_fracture_energy(tmp_path, release):
    """To 0.5 % at the end, at half of the stable step, with a quarter of the work and more gone into fracture."""
    error, lost = balance(tmp_path / "energies.csv", share=0.5, release=release)
    assert lost > 0.25
    assert abs(error[-1]) < 5e-3


def test_balance_of_the_elastic_plate_closes_with_order_two(tmp_path):
    """The clamps start with a jump, and all the same the error goes with dt²: 3.9 to 4.1 for half the step."""
    errors = [abs(balance(tmp_path / "e.csv", share=share, s0=10.0)[0][-1]) for share in (0.4, 0.2, 0.1)]
    assert errors[0] < 1e-4
    for coarse, fine in itertools.pairwise(errors):
        assert coarse / fine == pytest.approx(4.0, abs=0.2)


def test_balance_of_the_brittle_plate_improves_faster_than_the_step(tmp_path):
    """Which bonds break, and when, changes with the step; so no exact order, but more than the first is seen."""
    errors = [abs(balance(tmp_path / "e.csv", share=share)[0][-1]) for share in (0.4, 0.2, 0.1)]
    assert errors[1] < errors[0] / 2.5
    assert errors[2] < errors[1] / 2.5


# -- symmetry ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed", [20.0, 50.0])
def test_symmetric_about_both_axes(speed):
    """Which bonds are broken is symmetric to the bit; displacements to round-off, as rows are summed in other orders.

    Round-off of 150 steps: each adds an ulp or so of the coordinates, 0.03 m, to displacements of 1e-4 m: 1e-13 of
    them a step at most, and waves spread it.
    """
    n = 40
    scene = plate(n=n, speed=speed, s0=0.02)
    scene.analysis().run(steps=150, dt=scene.dt, progress=False)
    shape = (n + 6, n)
    broken = scene.part[damage].reshape(shape)
    assert np.count_nonzero(broken > 0.3) > 40
    assert np.array_equal(broken, broken[:, ::-1])
    assert np.array_equal(broken, broken[::-1])
    for field in (displacement, velocity):
        values = scene.part[field].reshape(*shape, 2)
        limit = 1e-11 * np.abs(values).max()
        assert np.abs(values - values[:, ::-1] * [-1, 1]).max() < limit
        assert np.abs(values - values[::-1] * [1, -1]).max() < limit


def test_both_ends_of_every_bond_break_together():
    scene = plate(n=40, speed=50.0, s0=0.02)
    scene.analysis().run(steps=150, dt=scene.dt, progress=False)
    offsets, j = scene.part.bonds.as_rows()
    i = np.repeat(np.arange(len(scene.part)), np.diff(offsets))
    holds = scene.part.bonds.intact
    assert np.count_nonzero(~holds) > 1000
    assert np.array_equal(holds[np.lexsort((j, i))], holds[np.lexsort((i, j))])


def test_no_bond_breaks_outside_of_the_region():
    scene = plate(n=40, speed=50.0, s0=0.005)
    scene.analysis().run(steps=120, dt=scene.dt, progress=False)
    outside = np.abs(scene.part.positions[:, 1]) > 0.0125
    reach = 3.015 * 0.05 / 40
    assert scene.part[damage][~outside].max() > 0.5
    assert not scene.part[damage][np.abs(scene.part.positions[:, 1]) > 0.0125 + reach].any()
    offsets, j = scene.part.bonds.as_rows()
    i = np.repeat(np.arange(len(scene.part)), np.diff(offsets))
    assert scene.part.bonds.intact[outside[i] | outside[j.astype(int)]].all()


# -- the same to the bit -------------------------------------------------------------------------------------------

STATE = (displacement, velocity, force_density, damage, *ENERGIES)


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="one core")
def test_threads_change_nothing(tmp_path):
    """One thread and two, over a run with fracture: every field, and the table of energies, to the bit."""
    before, found = numba.get_num_threads(), []
    for threads in (1, 2):
        scene = plate(n=50, s0=0.02, energies=tmp_path / f"{threads}.csv")
        assert len(scene.part.bonds) > 50_000  # so that two threads are used
        numba.set_num_threads(threads)
        try:
            scene.analysis().run(steps=120, dt=scene.dt, progress=False)
        finally:
            numba.set_num_threads(before)
        found.append(scene.part)
    one, two = found
    assert np.count_nonzero(~one.bonds.intact) > 1000
    assert np.array_equal(one.bonds.intact, two.bonds.intact)
    for field in STATE:
        assert np.array_equal(one[field], two[field]), field.name
    assert (tmp_path / "1.csv").read_bytes() == (tmp_path / "2.csv").read_bytes()


def test_resumed_run_is_the_uninterrupted_one(tmp_path):
    """Stopped while bonds break, resumed in new objects: every field, and the table of energies, to the bit."""

    def scene(name):
        return plate(n=40, s0=0.02, energies=tmp_path / f"{name}.csv")

    whole = scene("whole")
    whole.analysis().run(steps=140, dt=whole.dt, progress=False)
    first = scene("parts")
    first.analysis(rbs.Checkpoint(tmp_path / "save.npz", when=rbs.at(85 * first.dt))).run(
        steps=97, dt=first.dt, progress=False
    )
    broken = np.count_nonzero(~first.part.bonds.intact)
    second = scene("parts")
    report = second.analysis(rbs.Checkpoint(tmp_path / "save.npz", when=rbs.last)).run(
        steps=140, dt=second.dt, progress=False, resume=tmp_path / "save.npz"
    )
    assert report.steps == 140 - 85
    assert 300 < broken < np.count_nonzero(~whole.part.bonds.intact)
    assert np.array_equal(whole.part.bonds.intact, second.part.bonds.intact)
    for field in STATE:
        assert np.array_equal(whole.part[field], second.part[field]), field.name
    assert (tmp_path / "whole.csv").read_bytes() == (tmp_path / "parts.csv").read_bytes()
