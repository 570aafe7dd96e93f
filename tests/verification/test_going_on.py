"""Runs in pieces, and relations used twice: nothing that an earlier run has left may change the next one."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import BondBased, CriticalStretch, CSVExporter, FractureDissipation, KineticEnergy, SymplecticEuler
from rbs_plugins import VelocityVerlet as Verlet
from rbs_plugins.fields import density, dissipation_density, fracture_dissipation, kinetic_energy, velocity


def breaking(scheme, release="at once"):
    """A small square whose bonds break from the start, with the record of their energy."""
    part = rbs.Part("square", rbs.Box(size=(0.01, 0.01))).discretize(1e-3, thickness=1e-3).connect(3.015e-3)
    part[density] = 8000.0
    part[velocity] = np.random.default_rng(7).uniform(-60, 60, part.positions.shape)
    steel = BondBased(part, E=192e9, fracture=CriticalStretch(0.01, release=release))
    relations = [*scheme(part).step([steel]), FractureDissipation(part)]
    return part, steel, rbs.Analysis(relations, dt=5e-8)


@pytest.mark.parametrize("release", CriticalStretch.RELEASES)
@pytest.mark.parametrize("scheme", [Verlet, SymplecticEuler])
def test_the_record_of_dissipation_in_pieces(scheme, release, tmp_path):
    """The energy of a failing bond needs the positions of the force before, which are not those of the step before."""
    part, _, whole = breaking(scheme, release)
    whole.run(steps=40, progress=False)
    assert part[fracture_dissipation] > 0
    pieces, _, analysis = breaking(scheme, release)
    for steps in (1, 2, 17, 40):
        analysis.run(steps=steps, progress=False)
    assert np.array_equal(pieces[dissipation_density], part[dissipation_density])
    _, _, first = breaking(scheme, release)
    first.append(rbs.Checkpoint(tmp_path / "state.npz", when=rbs.last))
    first.run(steps=23, progress=False)
    again, _, second = breaking(scheme, release)
    second.append(rbs.Checkpoint(tmp_path / "state.npz", when=rbs.last))
    second.run(steps=40, resume=tmp_path / "state.npz", progress=False)
    assert np.array_equal(again[dissipation_density], part[dissipation_density])


def test_the_record_refuses_what_it_cannot_know():
    part, steel, analysis = breaking(Verlet)
    other = BondBased(part, E=1e9)
    analysis.relations = [*Verlet(part).step([steel, other]), FractureDissipation(part)]
    with pytest.raises(rbs.BadInput, match="several forces act on the bonds of one part"):
        analysis.prepare()
    pausing = BondBased(part, E=192e9, fracture=CriticalStretch(0.01), when=rbs.every(2))
    analysis.relations = [*Verlet(part).step([pausing]), FractureDissipation(part)]
    with pytest.raises(rbs.BadInput, match="can only be recorded in every step"):
        analysis.prepare()


def test_a_run_without_steps_changes_nothing():
    part, _, analysis = breaking(Verlet, "next step")
    analysis.run(steps=0, progress=False)
    analysis.run(steps=3, progress=False)
    other, _, whole = breaking(Verlet, "next step")
    whole.run(steps=3, progress=False)
    assert np.array_equal(part[velocity], other[velocity])


def test_a_table_starts_anew_with_the_run(tmp_path):
    part, _, analysis = breaking(Verlet)
    table = CSVExporter(part, kinetic_energy, tmp_path / "table.csv")
    relations = [*analysis.relations, KineticEnergy(part), table]
    for _ in range(2):
        rbs.Analysis(relations, dt=5e-8).run(steps=3, progress=False)
        assert (tmp_path / "table.csv").read_text().count("\n") == 4


def test_a_table_of_other_columns_or_with_missing_rows_is_not_continued(tmp_path):
    def build(*fields):
        part, _, analysis = breaking(Verlet)
        analysis.append(KineticEnergy(part), CSVExporter(part, fields, tmp_path / "table.csv"))
        analysis.append(rbs.Checkpoint(tmp_path / "state.npz", when=rbs.last))
        return analysis

    build(kinetic_energy, fracture_dissipation).run(steps=3, progress=False)
    swapped = build(fracture_dissipation, kinetic_energy)
    with pytest.raises(rbs.BadInput, match="has the columns"):
        swapped.run(steps=5, resume=tmp_path / "state.npz", progress=False)
    (tmp_path / "table.csv").write_text("step,time,kinetic_energy,fracture_dissipation\n1,5e-8,1.0,0.0\n")
    holed = build(kinetic_energy, fracture_dissipation)
    with pytest.raises(rbs.BadInput, match=r"should hold 3 rows .* and holds 1"):
        holed.run(steps=5, resume=tmp_path / "state.npz", progress=False)


def test_two_exporters_of_one_file_are_refused(tmp_path):
    part, _, analysis = breaking(Verlet)
    tables = [CSVExporter(part, kinetic_energy, tmp_path / name) for name in ("t.csv", "./t.csv")]
    analysis.append(KineticEnergy(part), *tables)
    with pytest.raises(rbs.BadInput, match=r"both write .*t\.csv"):
        analysis.prepare()
