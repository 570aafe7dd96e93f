"""Looking into series of frames, tables and folders of pictures."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core import Analysis, BadInput, Box, Measure, Part, every, world
from rbs_core.command.frames import ManyFiles, OneFile, RunFile, magnitudes, pictures_of, series_of, table_of
from rbs_plugins import HDF5Exporter, VTKExporter, VTKHDFExporter
from rbs_plugins.fields import displacement, velocity
from tests.scenes import plate

KINDS = {"frames.vtkhdf": (VTKHDFExporter, OneFile), "frames.pvd": (VTKExporter, ManyFiles)}


class Keeper(Measure):
    """Remembers what the frames should hold."""

    reads = (displacement, velocity)

    def __init__(self, part, held, *, when):
        super().__init__(part, when=when)
        self.held = held

    def apply(self, clock):
        self.held.append((self.part.positions + self[displacement], self[velocity].copy()))


@pytest.fixture(params=KINDS)
def written(request, tmp_path):
    """A file of three frames, what they hold, and the class that reads it."""
    exporter, reader = KINDS[request.param]
    scene, held = plate(n=8), []
    writer = exporter(scene.part, [displacement, velocity], tmp_path / "frames", configuration="current", when=every(2))
    keeper = Keeper(scene.part, held, when=every(2))
    Analysis([*scene.relations, writer, keeper], dt=scene.dt).run(steps=6, progress=False)
    return tmp_path / request.param, held, reader, scene.dt


def test_frames_come_back(written):
    path, held, reader, dt = written
    (series,) = series_of(path.parent)
    assert isinstance(series, reader)
    assert series.times == pytest.approx([2 * dt, 4 * dt, 6 * dt])
    for number, (positions, speeds) in enumerate(held):
        points, fields = series.read(number)
        assert list(fields) == ["displacement", "velocity"]
        np.testing.assert_array_equal(points[:, :2], positions)
        np.testing.assert_array_equal(fields["velocity"][:, :2], speeds)


def test_a_file_of_a_whole_run_with_two_parts(tmp_path):
    turned = world.child("turned", origin=(1.0, 0.0), axes=[(0.0, 1.0), (-1.0, 0.0)])
    one, two = plate(n=6), Part("two", Box(size=(0.1, 0.1)), system=turned).discretize(0.05)
    two[velocity] = (1.0, 2.0)
    writer = HDF5Exporter(one.part, [displacement, velocity, (two, velocity)], tmp_path / "run", when=every(2))
    Analysis([*one.relations, writer], dt=one.dt).run(steps=4, progress=False)
    (series,) = series_of(tmp_path)
    assert isinstance(series, RunFile)
    assert series.times == pytest.approx([2 * one.dt, 4 * one.dt])
    points, held = series.read(1)
    assert list(held) == ["velocity"]  # the displacement of one of them only
    assert len(points) == len(held["velocity"]) == len(one.part) + 4
    np.testing.assert_array_equal(points[: len(one.part), :2], one.part.positions)
    np.testing.assert_allclose(sorted(points[len(one.part) :].tolist())[0], [0.975, -0.025, 0.0])
    np.testing.assert_array_equal(held["velocity"][: len(one.part)], one.part[velocity])


def test_numbers_of_frames(written):
    path, _, reader, _ = written
    series = reader(path)
    assert [series.number(n) for n in (0, 2, -1, -3)] == [0, 2, 2, 0]
    for wrong in (3, -4):
        with pytest.raises(BadInput, match=rf"has no frame {wrong}: it has frames 0 to 2 \(-1 is the last\)"):
            series.number(wrong)


def test_files_that_are_not_what_their_names_say(tmp_path):
    for name, kind in (("a.vtkhdf", OneFile), ("b.pvd", ManyFiles), ("c.h5", RunFile)):
        (tmp_path / name).write_text("not this")
        with pytest.raises(BadInput, match=rf"{name} cannot be read \(.*\): is it complete, or still being written\?"):
            kind(tmp_path / name)


def test_a_frame_that_was_moved_away(tmp_path):
    scene = plate(n=6)
    writer = VTKExporter(scene.part, [displacement], tmp_path / "frames")
    Analysis([*scene.relations, writer], dt=scene.dt).run(steps=2, progress=False)
    (tmp_path / "frames_000001.vtu").unlink()
    series = ManyFiles(tmp_path / "frames.pvd")
    series.read(1)
    with pytest.raises(BadInput, match=r"names frames_000001.vtu, which is not there: was it moved or deleted\?"):
        series.read(0)


def test_pictures_in_the_order_of_their_steps(tmp_path):
    for name in ("damage_9.png", "damage_10.png", "damage_100.png", "other.txt", "aa.png"):
        (tmp_path / name).touch()
    assert [path.name for path in pictures_of(tmp_path)] == [
        "aa.png",
        "damage_9.png",
        "damage_10.png",
        "damage_100.png",
    ]


def test_tables(tmp_path):
    (tmp_path / "a.csv").write_text("step,time\n1,0.5\n2,1.0\n")
    assert table_of(tmp_path / "a.csv") == (["step", "time"], 2)
    (tmp_path / "a.csv").write_text("")
    assert table_of(tmp_path / "a.csv") == ([], 0)


def test_magnitudes():
    assert magnitudes(np.array([1, 2], np.uint8)).tolist() == [1.0, 2.0]
    assert magnitudes(np.array([[3.0, 4.0, 0.0]])).tolist() == [5.0]
    assert magnitudes(np.full((2, 3, 3), 1.0)).tolist() == [3.0, 3.0]
