"""One file with all frames: looked at during a run, left by a killed process, continued or refused."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins.exporters import growing, series
from tests.unit.plugins.exporters.moving import contents, reading, scene


def test_a_viewer_that_has_the_file_open_does_not_stop_the_run(tmp_path):
    fcntl = pytest.importorskip("fcntl")
    _, analysis = scene(tmp_path, steps=4)
    analysis.run(steps=2, progress=False)
    with (tmp_path / "frames.vtkhdf").open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_SH)  # as HDF5 does it for a reader
        analysis.run(progress=False)
    assert reading(tmp_path / "frames.vtkhdf").GetNumberOfSteps() == 4


def killed(tmp_path, monkeypatch, moment, **options):
    """What a process that is killed at some moment of its third frame leaves on the disk: the file at that moment."""
    path, left, header = tmp_path / "frames.vtkhdf", tmp_path / "left", []
    _, analysis = scene(tmp_path, steps=2, **options)
    analysis.run(progress=False)
    original = growing.resized

    def look(file, name, rows):
        header[:] = header or [path.read_bytes()[:48]]
        if moment == "values" and name == "VTKHDF/Steps/NumberOfParts":  # they are there, and no index knows them
            left.write_bytes(path.read_bytes())
        elif moment != "values" and name == "VTKHDF/Steps/Values":  # all is there, and does not count yet
            whole = path.read_bytes()
            left.write_bytes(header[0] + whole[48:] if moment == "index" else whole)  # HDF5 writes its header last
        return original(file, name, rows)

    monkeypatch.setattr(growing, "resized", look)
    analysis.run(steps=3, progress=False)
    monkeypatch.undo()
    left.replace(path)
    return path


@pytest.mark.parametrize("compression", [None, "gzip"])
@pytest.mark.parametrize("configuration", ["reference", "current"])
@pytest.mark.parametrize("moment", ["values", "index", "header"])
def test_a_killed_process_leaves_its_frames_and_can_be_resumed(
    tmp_path, monkeypatch, moment, configuration, compression
):
    options = {"configuration": configuration, "compression": compression}
    path = killed(tmp_path, monkeypatch, moment, **options)
    assert moment == "values" or growing.was_closed(path) == (moment == "header")
    reader = reading(path)
    assert reader.GetNumberOfSteps() == 2
    for step in (0, 1):
        reader.SetStep(step)
        reader.Update()
        assert reader.GetOutput().GetPointData().GetArray("damage").GetValue(0) == step + 1
    scene(tmp_path, steps=5, **options)[1].run(progress=False, resume=tmp_path / "state.npz")
    assert growing.was_closed(path)
    (tmp_path / "whole").mkdir()
    scene(tmp_path / "whole", steps=5, **options)[1].run(progress=False)
    one, two = contents(tmp_path / "whole"), contents(tmp_path)
    assert one.keys() == two.keys()
    assert all(np.array_equal(one[name], two[name]) for name in one)


def test_frames_behind_the_checkpoint_go_before_the_first_step(tmp_path):
    scene(tmp_path, steps=3)[1].run(progress=False)
    assert contents(tmp_path)["steps"] == 3
    part, analysis = scene(tmp_path, steps=2)
    analysis.run(progress=False, resume=tmp_path / "state.npz")  # there is no step to do
    found = contents(tmp_path)
    assert found["steps"] == len(found["VTKHDF/Steps/Values"]) == 2
    assert len(found["VTKHDF/PointData/damage"]) == 2 * len(part)


def test_an_old_file_stays_until_the_first_frame_of_a_new_run(tmp_path, monkeypatch):
    scene(tmp_path, steps=3)[1].run(progress=False)
    scene(tmp_path, steps=1, when=rbs.every(2))[1].run(progress=False)
    monkeypatch.setattr(series, "append", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        scene(tmp_path, steps=1)[1].run(progress=False)
    monkeypatch.undo()
    assert contents(tmp_path)["steps"] == 3
    assert {path.name for path in tmp_path.iterdir()} == {"frames.vtkhdf", "state.npz"}


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda path: path.write_text("no HDF5"), "cannot be continued"),
        (lambda path: h5py.File(path, "w").close(), "is no series of frames"),
        (lambda path: other(path, dimension=1), "has 4 nodes instead of 16"),
        (lambda path: other(path, precision="single"), r"holds .*float32.* instead of .*float64"),
        (lambda path: other(path, steps=1), "holds 1:"),
        (lambda path: other(path, when=rbs.every(2), steps=4), "holds the time 1.0 s instead of 0.5 s"),
    ],
)
def test_a_foreign_file_is_refused_before_the_first_step(tmp_path, spoil, message):
    scene(tmp_path, steps=2)[1].run(progress=False)
    spoil(tmp_path / "frames.vtkhdf")
    before = (tmp_path / "frames.vtkhdf").read_bytes()
    _, analysis = scene(tmp_path, steps=5)
    with pytest.raises(BadInput, match=message):
        analysis.run(progress=False, resume=tmp_path / "state.npz")
    assert analysis.report.steps == 0
    assert (tmp_path / "frames.vtkhdf").read_bytes() == before


def other(path, **options):
    """Puts the file of another scene in the place of a file."""
    folder = path.with_name("other")
    folder.mkdir()
    scene(folder, **options)[1].run(progress=False)
    (folder / "frames.vtkhdf").replace(path)


def test_a_file_that_goes_away_is_an_error_that_names_it(tmp_path):
    _, analysis = scene(tmp_path)
    analysis.run(steps=1, progress=False)
    exporter = analysis.relations[1]
    (tmp_path / "frames.vtkhdf").unlink()
    with pytest.raises(OSError, match=r"VTKHDFExporter 'body' frames.vtkhdf cannot write .*frames.vtkhdf"):
        exporter.apply(analysis.clock)
