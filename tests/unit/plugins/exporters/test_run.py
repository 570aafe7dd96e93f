"""Reading a run: indexed as numpy does, read only where it is looked at, and xarray if it is there."""

from __future__ import annotations

import sys

import h5py
import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import HDF5Exporter, Rotation, Translation, read_run
from rbs_plugins.fields import damage, displacement, kinetic_energy
from tests.unit.plugins.exporters.moving import Carry, carried

stress = rbs.Field("stress", "node", "tensor", "Pa", "σ", "A test.")


class Shake(rbs.Integrator):
    """Other numbers in every frame."""

    updates = (displacement, damage, stress, kinetic_energy)

    def apply(self, clock):
        rng = np.random.default_rng(clock.step)
        for field in self.updates:
            self[field][...] = rng.normal(size=self[field].shape)


@pytest.fixture
def made(tmp_path):
    """A run of five frames, and the arrays that it should hold."""
    part = rbs.Part("plate", rbs.Box(size=(4.0, 2.0))).discretize(1.0)
    exporter = HDF5Exporter(part, Shake.updates, tmp_path / "run")
    kept = []

    class Keep(rbs.Measure):
        """Remembers."""

        reads = Shake.updates

        def apply(self, clock):
            kept.append([self[field].copy() for field in self.reads])

    rbs.Analysis([Shake(part), Keep(part), exporter]).run(steps=5, dt=0.5, progress=False)
    arrays = {field.name: np.array([row[k] for row in kept]) for k, field in enumerate(Shake.updates)}
    return read_run(tmp_path / "run.h5"), arrays, part


def test_what_a_run_says_about_itself(made):
    run, arrays, part = made
    assert run.times.tolist() == [0.5, 1.0, 1.5, 2.0, 2.5]
    assert run.steps.tolist() == [1, 2, 3, 4, 5]
    assert (len(run), run.parts, list(run)) == (5, ("plate",), ["plate"])
    assert repr(run) == "<Run run.h5, 5 frames, 0.5 to 2.5 s, parts plate>"
    plate = run["plate"]
    assert (plate.name, plate.dimension, len(plate)) == ("plate", 2, 8)
    assert set(plate.fields) == set(plate) == set(arrays)
    assert repr(plate).startswith("<part 'plate', 2-D, 8 nodes, fields ")
    assert np.array_equal(plate.positions, part.positions)
    assert np.array_equal(plate.volumes, part[rbs.volume])
    field = plate["stress"]
    assert (field.name, field.unit, field.symbol, field.doc) == ("stress", "Pa", "σ", "A test.")
    assert (field.shape, field.ndim, len(field), field.dtype) == ((5, 8, 2, 2), 4, 5, np.float64)
    assert field.dims == ("time", "node", "axis", "column")
    assert plate["kinetic_energy"].dims == ("time",)
    assert repr(field) == "<field 'stress' [Pa], (5, 8, 2, 2) of float64: A test.>"


@pytest.mark.parametrize(
    "key",
    [
        0,
        -1,
        np.int64(2),
        slice(None),
        slice(1, 4, 2),
        slice(None, None, -1),
        slice(3, 3),
        [0, 3, 1],
        np.array([True, False, True, False, False]),
        ...,
        (),
        (2, 5),
        (slice(None), 5),
        (slice(None), -1, 0),
        (slice(1, 3), slice(2, 6), 1),
        (slice(None), slice(None, None, -2)),
        (-1, [5, 2, 2]),
        (slice(None), [5, 2, 2], 1),
        (..., 0),
        (0, ...),
        (0, ..., 1),
        (slice(None), None, 3),
    ],
    ids=str,
)
def test_frames_are_indexed_as_numpy_does(made, key):
    run, arrays, _ = made
    found = run["plate"]["displacement"][key]
    wanted = arrays["displacement"][key]
    assert found.shape == wanted.shape
    assert found.dtype == wanted.dtype
    assert np.array_equal(found, wanted)


def test_other_shapes(made):
    run, arrays, _ = made
    plate = run["plate"]
    assert np.array_equal(plate["stress"][..., 0, 1], arrays["stress"][..., 0, 1])
    assert np.array_equal(plate["damage"][:, 3], arrays["damage"][:, 3])
    assert plate["kinetic_energy"][2] == arrays["kinetic_energy"][2]
    assert np.array_equal(plate["kinetic_energy"][1:], arrays["kinetic_energy"][1:])
    assert np.array_equal(plate["damage"][[0, 2], 1:3], arrays["damage"][[0, 2], 1:3])
    assert all(np.array_equal(np.asarray(plate[name]), arrays[name]) for name in plate)
    assert [frame.shape for frame in plate["damage"]] == [(8,)] * 5


@pytest.mark.parametrize("key", [5, -6, (0, 8), (0, 0, 2), (0, 0, 0, 0)])
def test_what_is_not_there_is_an_index_error(made, key):
    with pytest.raises(IndexError):
        made[0]["plate"]["displacement"][key]


def test_the_nearest_frame(made):
    run, arrays, _ = made
    assert [run.at(time) for time in (-1.0, 0.5, 0.74, 0.76, 2.4, 9.0)] == [0, 0, 0, 1, 4, 4]
    assert np.array_equal(run["plate"]["damage"].at(1.6), arrays["damage"][2])


def test_fields_are_found_by_themselves_too(made):
    plate = made[0]["plate"]
    assert plate[displacement].name == "displacement"
    assert displacement in plate
    assert "displacement" in plate
    assert "velocity" not in plate


def test_only_what_is_looked_at_is_read(made, monkeypatch):
    run, _, _ = made
    read = []
    original = h5py.Dataset.__getitem__
    monkeypatch.setattr(h5py.Dataset, "__getitem__", lambda self, key: read.append(key) or original(self, key))
    assert run["plate"]["displacement"].shape == (5, 8, 2)
    assert read == []
    run["plate"]["displacement"][1:3, 4]
    assert read == [(1, 4), (2, 4)]


def test_frames_that_do_not_count_are_not_there(made):
    run, arrays, _ = made
    with h5py.File(run.path, "r+") as file:
        file.attrs.modify("frames", np.int64(3))
    again = read_run(run.path)
    assert len(again) == len(again["plate"]["damage"]) == 3
    assert np.array_equal(again["plate"]["damage"][-1], arrays["damage"][2])


def test_a_run_can_go_on_while_it_is_looked_at(tmp_path):
    part = rbs.Part("plate", rbs.Box(size=(4.0, 2.0))).discretize(1.0)
    analysis = rbs.Analysis([Shake(part), HDF5Exporter(part, damage, tmp_path / "run")])
    analysis.run(steps=2, dt=0.5, progress=False)
    run = read_run(tmp_path / "run.h5")
    first = run["plate"]["damage"][0]
    analysis.run(steps=4, dt=0.5, progress=False)
    assert len(run) == 2
    assert np.array_equal(run["plate"]["damage"][0], first)
    assert len(read_run(tmp_path / "run.h5")) == 4


def test_points_in_the_world_follow_the_coordinate_system(tmp_path):
    part, places = carried()
    exporter = HDF5Exporter(part, [displacement], tmp_path / "run")
    rbs.Analysis([Carry(part), exporter]).run(steps=3, dt=1.0, progress=False)
    plate = read_run(tmp_path / "run.h5")["plate"]
    for frame in range(3):
        points, moved = places(frame + 1)
        np.testing.assert_allclose(plate.in_world(plate.positions, frame), points, atol=1e-15)
        current = plate.positions + plate["displacement"][frame]
        np.testing.assert_allclose(plate.in_world(current, frame - 3), points + moved, atol=1e-15)
    with pytest.raises(BadInput, match=r"points must have the shape \(n, 2\), got \(2, 3\)"):
        plate.in_world(np.zeros((2, 3)))
    with pytest.raises(IndexError):
        plate.in_world(plate.positions, 3)


def test_they_are_continued_by_a_resumed_run(tmp_path):
    def scene(folder, steps):
        part = rbs.Part("tool", rbs.Box(size=(2.0, 1.0)), system=rbs.world.child("tool")).discretize(1.0)
        relations = [
            Rotation(part, velocity=0.3),
            Translation(part, velocity=(1.0, 0.1)),
            HDF5Exporter(part, (), folder / "run"),
            rbs.Checkpoint(folder / "save.npz", when=rbs.every(2)),
        ]
        return rbs.Analysis(relations, dt=0.5, steps=steps)

    (tmp_path / "whole").mkdir()
    (tmp_path / "parts").mkdir()
    scene(tmp_path / "whole", 5).run(progress=False)
    scene(tmp_path / "parts", 3).run(progress=False)
    scene(tmp_path / "parts", 5).run(progress=False, resume=tmp_path / "parts" / "save.npz")
    tools = [read_run(tmp_path / folder / "run.h5")["tool"] for folder in ("whole", "parts")]
    for frame in range(5):
        one, two = (tool.in_world(tool.positions, frame) for tool in tools)
        assert np.array_equal(one, two)
        assert np.linalg.norm(one[1] - one[0]) == pytest.approx(1.0)


def test_what_is_missing_is_named_with_what_is_near(made, tmp_path):
    run = made[0]
    with pytest.raises(BadInput, match="holds no part 'plat': the nearest names are plate"):
        run["plat"]
    with pytest.raises(BadInput, match=r"part 'plate' of .* has no field 'damaged': the nearest names are damage"):
        run["plate"]["damaged"]
    with pytest.raises(BadInput, match=r"there is no file .*rum.h5: the nearest names are run.h5"):
        read_run(tmp_path / "rum.h5")
    with pytest.raises(BadInput, match=r"there is no file .*: there are none in"):
        read_run(tmp_path / "nowhere" / "run.h5")


def test_other_files_are_refused(tmp_path):
    (tmp_path / "text.h5").write_text("no HDF5")
    with pytest.raises(BadInput, match="is damaged or no HDF5 file"):
        read_run(tmp_path / "text.h5")
    h5py.File(tmp_path / "empty.h5", "w").close()
    with pytest.raises(BadInput, match="is no run of format 1 that HDF5Exporter has written"):
        read_run(tmp_path / "empty.h5")


def test_xarray(made):
    pytest.importorskip("xarray")
    run, arrays, part = made
    data = run["plate"].to_xarray()
    assert set(data.data_vars) == set(arrays)
    found = data["displacement"].sel(time=1.6, method="nearest").sel(axis="y")
    assert np.array_equal(found, arrays["displacement"][2, :, 1])
    assert data["stress"].attrs == {"units": "Pa", "long_name": "A test.", "symbol": "σ"}
    assert np.array_equal(data["reference_position"], part.positions)
    assert list(run["plate"].to_xarray("damage").data_vars) == ["damage"]


def test_without_xarray_the_cure_is_said(made, monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(BadInput, match="pip install xarray"):
        made[0]["plate"].to_xarray()
