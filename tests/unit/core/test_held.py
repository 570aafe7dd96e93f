"""What a scene holds, and what would not fit."""

from __future__ import annotations

import pytest

from rbs_core import Analysis, BadInput
from rbs_core.fields import Field, intact
from rbs_core.held import held, require_fields
from rbs_plugins.fields import damage, displacement, strain_energy
from tests.scenes import bar, plate
from tests.unit.core.toys import Toy, a, line

reference_length = Field("reference_length", "bond", "scalar", "m", "|ξ|", "Distance of the ends.")


def test_everything_that_is_held_has_a_row_and_the_largest_comes_first():
    scene = plate(n=12)
    analysis = scene.analysis()
    report = analysis.run(steps=1, progress=False)
    assert sum(each.nbytes for each in report.memory) == report.nbytes == analysis.nbytes
    sizes = [each.nbytes for each in report.memory]
    assert sizes == sorted(sizes, reverse=True)
    found = {(each.owner, each.name): each for each in report.memory}
    nodes = len(scene.part)
    assert found["plate", "displacement"].nbytes == 16 * nodes
    assert found["plate", "damage"].nbytes == 8 * nodes
    assert found["plate", "intact"].at == "bond"
    assert found["plate", "bonds"].nbytes > 0
    assert ("BondBased 'plate'", "loops") in found


def test_a_part_without_bonds():
    part = line()
    Analysis([Toy(part, updates=(a,))]).prepare()
    assert {each.name: each.nbytes for each in held([part], [])} == {
        "reference_position": 32, "volume": 32, "a": 32
    }  # fmt: skip


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_the_size_of_a_field_is_known_before_it_is_made(storage):
    part = plate(n=12).part.connect(horizon=0.0126, storage=storage)
    assert part.bonds.storage == storage
    for field in (displacement, damage, intact, reference_length, strain_energy):
        size = part.store(field.at).size(field)
        assert part.raw(field).nbytes == size


def test_fields_that_do_not_fit_are_refused_before_they_are_made(monkeypatch):
    scene = bar(n=1000)
    analysis = scene.analysis()
    monkeypatch.setenv("RBS_MEMORY", "20kB")
    with pytest.raises(BadInput) as caught:
        analysis.prepare()
    assert str(caught.value) == (
        "the fields of this scene ('force_density' of 'bar' 8 kB, 'velocity' of 'bar' 8 kB, 'displacement' of 'bar' "
        "8 kB) would need 24 kB of memory, and 20 kB are free: take a larger spacing, Part(..., precision='single'), "
        "or a list of relations that needs fewer fields"
    )
    assert displacement not in scene.part
    monkeypatch.setenv("RBS_MEMORY", "25kB")
    analysis.prepare()


def test_fields_that_are_there_need_nothing(monkeypatch):
    part = line()
    monkeypatch.setenv("RBS_MEMORY", "10B")
    require_fields([])
    with pytest.raises(BadInput):
        require_fields([(part, damage)])
    part.raw(damage)
    require_fields([(part, damage)])
