"""A run in one file: what is in it, how it is continued and refused, and what a killed process leaves."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import HDF5Exporter, read_run
from rbs_plugins.exporters import growing, hdf5
from rbs_plugins.fields import damage, displacement, kinetic_energy, reference_position, volume

stress = rbs.Field("stress", "node", "tensor", "Pa", "s", "A test.")
ends = rbs.Field("ends", "part", "vector", "m", "e", "A test.")


class Move(rbs.Integrator):
    """Displaces node i by (i + 1) t along x, and counts."""

    updates = (displacement, damage, kinetic_energy, ends)

    def apply(self, clock):
        self[displacement][:, 0] = np.arange(1, len(self.part) + 1) * clock.time
        self[damage][...] = clock.step
        self[kinetic_energy][...] = -clock.step
        self[ends][...] = clock.step / 3


def scene(path, dimension=2, precision="double", steps=3, when=rbs.always, name="body", **options):
    part = rbs.Part(name, rbs.Box(size=[4.0] * dimension), precision=precision).discretize(1.0)
    part[stress] = np.arange(dimension**2).reshape(dimension, dimension)
    fields = [displacement, damage, stress, kinetic_energy, ends]
    exporter = HDF5Exporter(part, fields, path / "run", when=when, **options)
    checkpoint = rbs.Checkpoint(path / "state.npz", when=rbs.every(2))
    return part, rbs.Analysis([Move(part), exporter, checkpoint], dt=0.5, steps=steps)


def contents(path):
    """Every array and attribute of a file, by name."""
    found = {}

    def look(name, item):
        found.update({f"{name}.{key}": value for key, value in item.attrs.items()})
        if isinstance(item, h5py.Dataset):
            found[name] = item[()]

    with h5py.File(path / "run.h5") as file:
        file.visititems(look)
        found.update(file.attrs)
    return found


def same(one, two):
    return one.keys() == two.keys() and all(np.array_equal(one[name], two[name]) for name in one)


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("compression", ["gzip", "lzf", None])
def test_the_file_holds_every_frame(tmp_path, dimension, compression, monkeypatch):
    monkeypatch.setattr(hdf5, "ROWS", 3)  # chunks that do not fit the nodes
    part, analysis = scene(tmp_path, dimension, compression=compression)
    analysis.run(progress=False)
    found = contents(tmp_path)
    assert (found["format"], found["version"], found["frames"]) == ("rbs run", 1, 3)
    assert found["time"].tolist() == [0.5, 1.0, 1.5]
    assert found["step"].tolist() == [1, 2, 3]
    assert found["parts/body.dimension"] == dimension
    assert np.array_equal(found["parts/body/position"], part.positions)
    assert np.array_equal(found["parts/body/volume"], part[volume])
    moved = np.arange(1, len(part) + 1) * found["time"][:, None]
    assert np.array_equal(found["parts/body/fields/displacement"][..., 0], moved)
    assert found["parts/body/fields/displacement"].shape == (3, len(part), dimension)
    assert np.array_equal(found["parts/body/fields/damage"], np.outer([1, 2, 3], np.ones(len(part))))
    assert np.array_equal(found["parts/body/fields/stress"], np.broadcast_to(part[stress], (3, *part[stress].shape)))
    assert found["parts/body/fields/kinetic_energy"].tolist() == [-1, -2, -3]
    assert np.array_equal(found["parts/body/fields/ends"], np.outer([1 / 3, 2 / 3, 1.0], np.ones(dimension)))
    told = {key: found[f"parts/body/fields/stress.{key}"] for key in ("at", "shape", "unit", "symbol", "doc")}
    assert told == {"at": "node", "shape": "tensor", "unit": "Pa", "symbol": "s", "doc": "A test."}


def test_files_are_compressed(tmp_path):
    part = rbs.Part("body", rbs.Box(size=[200.0, 100.0])).discretize(1.0)
    part[displacement] = 1.0
    sizes = {}
    for compression in ("gzip", "lzf", None):
        exporter = HDF5Exporter(part, displacement, tmp_path / "run", compression=compression)
        rbs.Analysis([exporter]).run(steps=2, dt=1.0, progress=False)
        sizes[compression] = (tmp_path / "run.h5").stat().st_size
    assert sizes["gzip"] < sizes[None] / 10
    assert sizes["lzf"] < sizes[None] / 5
    assert sizes[None] > 2 * part[displacement].nbytes


@pytest.mark.parametrize(
    ("precision", "of_part", "size"), [(None, "double", 8), (None, "single", 4), ("single", "double", 4)]
)
def test_precision(tmp_path, precision, of_part, size):
    part = rbs.Part("body", rbs.Box(size=[4.0, 4.0]), precision=of_part).discretize(1.0)
    part[displacement] = 1 / 3
    exporter = HDF5Exporter(part, [displacement, reference_position], tmp_path / "run", precision=precision)
    rbs.Analysis([exporter]).run(steps=1, dt=1.0, progress=False)
    found = contents(tmp_path)
    assert (found["parts/body/fields/displacement"] == np.dtype(f"f{size}").type(1 / 3)).all()
    assert found["parts/body/fields/displacement"].dtype.itemsize == size
    assert found["parts/body/position"].dtype == np.float64
    assert found["parts/body/fields/reference_position"].dtype.itemsize == (4 if precision == "single" else 8)


def test_several_parts_in_one_file(tmp_path):
    bar = rbs.Part("bar", rbs.Box(size=3.0)).discretize(1.0)
    ball = rbs.Part("ball", rbs.Ball(1.5, center=(0.0, 0.0, 0.0))).discretize(1.0)
    bar[damage], ball[damage] = 0.25, 0.75
    exporter = HDF5Exporter(bar, [damage, (ball, damage)], tmp_path / "run.hdf5")
    assert exporter.path == tmp_path / "run.hdf5"
    assert exporter.label == "HDF5Exporter 'bar' run.hdf5"
    assert exporter.parts == [bar, ball]
    assert set(exporter.reads) == {
        damage, reference_position, volume, (ball, damage), (ball, reference_position), (ball, volume)
    }  # fmt: skip
    rbs.Analysis([exporter]).run(steps=2, dt=1.0, progress=False)
    run = read_run(tmp_path / "run.hdf5")
    assert run.parts == ("ball", "bar")
    assert (run["bar"]["damage"][:] == 0.25).all()
    assert run["ball"]["damage"].shape == (2, len(ball))
    assert np.array_equal(run["ball"].positions, ball.positions)
    single = HDF5Exporter(bar, (ball, damage), tmp_path / "ball")
    assert single.written == [ball]


def test_nothing_to_export_are_positions_and_volumes(tmp_path):
    bar = rbs.Part("bar", rbs.Box(size=3.0)).discretize(1.0)
    rbs.Analysis([HDF5Exporter(bar, (), tmp_path / "run")]).run(steps=2, dt=1.0, progress=False)
    run = read_run(tmp_path / "run.h5")
    assert (len(run), run["bar"].fields) == (2, ())
    assert np.array_equal(run["bar"].positions, bar.positions)


# -- continued ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("compression", ["gzip", "lzf", None])
@pytest.mark.parametrize("was_closed", [True, False])
def test_a_resumed_run_continues_its_file(tmp_path, compression, was_closed, monkeypatch):
    for folder in ("whole", "parts"):
        (tmp_path / folder).mkdir()
    scene(tmp_path / "whole", steps=5, compression=compression)[1].run(progress=False)
    scene(tmp_path / "parts", steps=3, compression=compression)[1].run(progress=False)  # a frame more than saved
    monkeypatch.setattr(growing, "was_closed", lambda _: was_closed)
    _, analysis = scene(tmp_path / "parts", steps=5, compression=compression)
    analysis.run(progress=False, resume=tmp_path / "parts" / "state.npz")
    assert same(contents(tmp_path / "whole"), contents(tmp_path / "parts"))


def test_frames_behind_the_checkpoint_go_before_the_first_step(tmp_path):
    scene(tmp_path, steps=3)[1].run(progress=False)
    scene(tmp_path, steps=2)[1].run(progress=False, resume=tmp_path / "state.npz")
    found = contents(tmp_path)
    assert found["frames"] == len(found["time"]) == len(found["parts/body/fields/damage"]) == 2


def test_a_new_run_begins_a_new_file_with_its_first_frame(tmp_path, monkeypatch):
    scene(tmp_path, steps=4)[1].run(progress=False)
    scene(tmp_path, steps=1, when=rbs.every(2))[1].run(progress=False)
    assert contents(tmp_path)["frames"] == 4
    monkeypatch.setattr(growing, "put_numbers", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        scene(tmp_path, steps=1)[1].run(progress=False)
    assert contents(tmp_path)["frames"] == 4
    monkeypatch.undo()
    scene(tmp_path, steps=1)[1].run(progress=False)
    assert contents(tmp_path)["frames"] == 1
    assert {path.name for path in tmp_path.iterdir()} == {"run.h5", "state.npz"}


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda path: path.unlink(), "is not there"),
        (lambda path: path.write_text("no HDF5"), "cannot be continued"),
        (lambda path: h5py.File(path, "w").close(), "is no run of format 1"),
        (lambda path: other(path, dimension=1), r"has nodes {'body': 4} instead of {'body': 16}"),
        (lambda path: other(path, name="disk"), r"has nodes {'disk': 16} instead of {'body': 16}"),
        (lambda path: other(path, precision="single"), r"holds .*float32.* instead of .*float64"),
        (lambda path: other(path, compression=None), r"holds .*compression None.* instead of .*compression gzip"),
        (lambda path: other(path, steps=1), "holds 1:"),
        (lambda path: other(path, when=rbs.every(2), steps=4), "holds the time 1.0 s instead of 0.5 s"),
    ],
)
def test_a_foreign_file_is_refused_before_the_first_step(tmp_path, spoil, message):
    scene(tmp_path, steps=2)[1].run(progress=False)
    spoil(tmp_path / "run.h5")
    _, analysis = scene(tmp_path, steps=5)
    with pytest.raises(BadInput, match=message):
        analysis.run(progress=False, resume=tmp_path / "state.npz")
    assert analysis.report.steps == 0


def other(path, **options):
    """Puts the file of another scene in the place of a file."""
    folder = path.with_name("other")
    folder.mkdir()
    scene(folder, **options)[1].run(progress=False)
    (folder / "run.h5").replace(path)


@pytest.mark.parametrize("compression", ["gzip", None])
@pytest.mark.parametrize("moment", ["values", "index", "header"])
def test_a_killed_process_leaves_its_frames_and_can_be_resumed(tmp_path, monkeypatch, moment, compression):
    path, left, header = tmp_path / "run.h5", tmp_path / "left", []
    _, analysis = scene(tmp_path, steps=2, compression=compression)
    analysis.run(progress=False)
    original = growing.resized

    def look(file, name, rows):
        """The file on the disk at some moment of the third frame."""
        header[:] = header or [path.read_bytes()[:48]]
        if moment == "values" and name == "step":
            left.write_bytes(path.read_bytes())
        elif moment != "values" and name == "time":
            file.flush()
            whole = path.read_bytes()
            left.write_bytes(header[0] + whole[48:] if moment == "index" else whole)  # HDF5 writes its header last
        return original(file, name, rows)

    monkeypatch.setattr(growing, "resized", look)
    analysis.run(steps=3, progress=False)
    monkeypatch.undo()
    left.replace(path)
    run = read_run(path)
    assert run.times.tolist() == [0.5, 1.0]
    assert (run["body"]["damage"][-1] == 2).all()
    scene(tmp_path, steps=5, compression=compression)[1].run(progress=False, resume=tmp_path / "state.npz")
    (tmp_path / "whole").mkdir()
    scene(tmp_path / "whole", steps=5, compression=compression)[1].run(progress=False)
    assert same(contents(tmp_path / "whole"), contents(tmp_path))


def test_a_file_that_goes_away_is_an_error_that_names_it(tmp_path):
    _, analysis = scene(tmp_path)
    analysis.run(steps=1, progress=False)
    (tmp_path / "run.h5").unlink()
    with pytest.raises(OSError, match=r"HDF5Exporter 'body' run.h5 cannot write .*run.h5"):
        analysis.relations[1].apply(analysis.clock)


# -- what it takes --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("displacment", "is no node field and no number of the part: .*nearest names are displacement"),
        ([rbs.intact], "is no node field and no number of the part"),
        ([("body", damage)], r"must be a field or a pair \(part, field\)"),
        (3, "3 is no node field"),
    ],
)
def test_what_is_no_field_is_refused(given, message, tmp_path):
    part = rbs.Part("body", rbs.Box(size=[4.0, 4.0])).discretize(1.0).connect(1.0)
    with pytest.raises(BadInput, match=message):
        HDF5Exporter(part, given, tmp_path / "run")


@pytest.mark.parametrize(("name", "value"), [("precision", "half"), ("compression", "zip")])
def test_unknown_options(tmp_path, name, value):
    with pytest.raises(BadInput, match=f"{name}='{value}' must be one of"):
        scene(tmp_path, **{name: value})


def test_a_part_whose_name_is_a_path_is_refused(tmp_path):
    with pytest.raises(BadInput, match="'a/b' has no place in HDF5: rename it"):
        scene(tmp_path, name="a/b")


def test_a_folder_that_cannot_be_written_is_an_error_before_the_run(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(BadInput, match="cannot write into the folder"):
        scene(tmp_path / "file")[1].prepare()
