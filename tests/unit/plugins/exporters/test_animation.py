"""Animations: all frames of a run, whatever ends it, in one space and one scale of colors."""

from __future__ import annotations

import logging
import sys

import numpy as np
import pytest
from PIL import Image, ImageSequence

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import AnimationExporter
from rbs_plugins.exporters import animation
from rbs_plugins.exporters.drawing import draw
from rbs_plugins.fields import damage, displacement, kinetic_energy


class Grow(rbs.Integrator):
    """Damage from 0 to the number of the step, and a plate that becomes wider."""

    updates = (displacement, damage)

    def apply(self, clock):
        positions = self.part.positions
        self[damage][...] = (positions[:, 0] > 0) * clock.step
        self[displacement][...] = 0.1 * clock.step * positions


def scene(folder, steps, *more, field=damage, name="run.gif", when=rbs.always, **options):
    part = rbs.Part("plate", rbs.Box(size=(2.0, 1.0))).discretize(0.1)
    exporter = AnimationExporter(part, field, folder / name, when=when, **{"size": (120, 100), **options})
    return exporter, rbs.Analysis([Grow(part), exporter, *more], dt=1.0, steps=steps)


def frames_of(path):
    """(frames, height, width, 3) of a GIF."""
    with Image.open(path) as movie:
        return np.array([np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(movie)])


@pytest.fixture(autouse=True)
def _needs_graphics(tmp_path):
    exporter, analysis = scene(tmp_path / "probe", 1)
    analysis.run(progress=False)
    if not exporter._able:
        pytest.skip("no picture can be drawn on this machine")


def test_a_movie_of_all_frames_and_their_pictures(tmp_path):
    _, analysis = scene(tmp_path / "out", 6, when=rbs.every(2), fps=5)
    analysis.run(progress=False)
    frames = frames_of(tmp_path / "out" / "run.gif")
    assert frames.shape == (3, 100, 120, 3)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["run.gif", "run.gif.frames"]
    pictures = sorted((tmp_path / "out" / "run.gif.frames").iterdir())
    assert [path.name for path in pictures] == [f"run_{step:06d}.png" for step in (2, 4, 6)]
    for frame, picture in zip(frames, pictures, strict=True):
        with Image.open(picture) as image:
            assert np.abs(frame.astype(int) - np.asarray(image)).mean() < 2.0
    with Image.open(tmp_path / "out" / "run.gif") as movie:
        assert movie.info["duration"] == 200


def sketches(monkeypatch):
    """Collects what is drawn."""
    found = []
    monkeypatch.setattr(animation, "draw", lambda sketch: found.append(sketch) or draw(sketch))
    return found


def test_colors_and_space_are_those_of_the_frames_so_far(tmp_path, monkeypatch):
    found = sketches(monkeypatch)
    scene(tmp_path, 3)[1].run(progress=False)
    assert [sketch.limits for sketch in found] == [(0.0, 1.0), (0.0, 2.0), (0.0, 3.0)]
    assert [sketch.high[0] for sketch in found] == pytest.approx([0.95 * 1.1, 0.95 * 1.2, 0.95 * 1.3])
    assert all((sketch.low == -sketch.high).all() for sketch in found)


def test_given_colors(tmp_path, monkeypatch):
    found = sketches(monkeypatch)
    scene(tmp_path, 2, limits=(0.0, 9.0), field=displacement, component="x", scale=2.0)[1].run(progress=False)
    assert [sketch.limits for sketch in found] == [(0.0, 9.0)] * 2
    assert found[1].title == "displacement x\n[m]"
    assert found[1].high[0] == pytest.approx(0.95 * 1.4)


def test_a_resumed_run_goes_on_with_its_movie(tmp_path, monkeypatch):
    def run(folder, steps, **options):
        scene(folder, steps, rbs.Checkpoint(folder / "save.npz", when=rbs.every(2)))[1].run(progress=False, **options)

    run(tmp_path / "whole", 5)
    run(tmp_path / "parts", 3)
    assert len(frames_of(tmp_path / "parts" / "run.gif")) == 3
    found = sketches(monkeypatch)
    run(tmp_path / "parts", 5, resume=tmp_path / "parts" / "save.npz")
    assert [sketch.limits for sketch in found] == [(0.0, 3.0), (0.0, 4.0), (0.0, 5.0)]
    assert (tmp_path / "parts" / "run.gif").read_bytes() == (tmp_path / "whole" / "run.gif").read_bytes()


def test_the_movie_of_a_process_that_was_killed_is_made_by_the_run_that_goes_on(tmp_path, monkeypatch):
    monkeypatch.setattr(AnimationExporter, "close", lambda _: None)
    save = rbs.Checkpoint(tmp_path / "save.npz")
    scene(tmp_path, 2, save)[1].run(progress=False)
    monkeypatch.undo()
    assert not (tmp_path / "run.gif").exists()
    scene(tmp_path, 2, save)[1].run(progress=False, resume=tmp_path / "save.npz")
    assert len(frames_of(tmp_path / "run.gif")) == 2


def test_an_error_leaves_a_movie_of_the_frames_so_far(tmp_path):
    class Fail(rbs.Measure):
        """Breaks in step 3."""

        def apply(self, clock):
            if clock.step == 3:
                raise RuntimeError("broken on purpose")

    exporter, analysis = scene(tmp_path, 5)
    analysis.append(Fail(exporter.part))
    with pytest.raises(RuntimeError, match="on purpose"):
        analysis.run(progress=False)
    assert len(frames_of(tmp_path / "run.gif")) == 3


def test_pictures_of_an_earlier_run_are_not_in_the_movie(tmp_path):
    scene(tmp_path, 5)[1].run(progress=False)
    scene(tmp_path, 2)[1].run(progress=False)
    assert len(frames_of(tmp_path / "run.gif")) == len(list((tmp_path / "run.gif.frames").iterdir())) == 2


def test_one_analysis_that_runs_twice_has_one_movie(tmp_path):
    _, analysis = scene(tmp_path, 4)
    analysis.run(steps=2, progress=False)
    analysis.run(steps=4, progress=False)
    assert len(frames_of(tmp_path / "run.gif")) == 4


@pytest.mark.parametrize(
    ("spoil", "options", "message"),
    [
        (lambda folder: (folder / "run_000001.png").unlink(), {}, r"1 of its pictures are not in .*run_000001.png"),
        (lambda folder: None, {"size": (100, 120)}, r"have the size \(120, 100\) instead of \(100, 120\)"),
    ],
)
def test_a_movie_that_cannot_go_on_is_refused_before_the_first_step(tmp_path, spoil, options, message):
    save = rbs.Checkpoint(tmp_path / "save.npz")
    scene(tmp_path, 2, save)[1].run(progress=False)
    before = (tmp_path / "run.gif").read_bytes()
    spoil(tmp_path / "run.gif.frames")
    _, analysis = scene(tmp_path, 4, save, **options)
    with pytest.raises(BadInput, match=message):
        analysis.run(progress=False, resume=tmp_path / "save.npz")
    assert analysis.report.steps == 0
    assert (tmp_path / "run.gif").read_bytes() == before


def test_mp4(tmp_path):
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    scene(tmp_path, 3, name="run.mp4")[1].run(progress=False)
    assert imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "run.mp4"))[0] == 3


def test_an_mp4_that_cannot_be_encoded_is_refused_before_the_run(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    _, analysis = scene(tmp_path, 3, name="run.mp4")
    with pytest.raises(BadInput, match=r"AnimationExporter 'plate' run.mp4: an MP4 needs imageio-ffmpeg"):
        analysis.prepare()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"name": "run.avi"}, "must end with .gif or .mp4"),
        ({"name": "run"}, "must end with .gif or .mp4"),
        ({"fps": 0}, "must lie between 0.1 and 50 for .gif"),
        ({"fps": 60}, "must lie between 0.1 and 50 for .gif"),
        ({"fps": float("nan")}, "must lie between"),
        ({"fps": "fast"}, "must lie between"),
        ({"name": "run.mp4", "size": (101, 100)}, "must be even numbers for an MP4"),
        ({"component": "y"}, "has no component 'y'"),
        ({"field": kinetic_energy}, "is no node field"),
        ({"field": "damag"}, "the nearest names are damage"),
        ({"configuration": "past"}, "must be one of current, reference"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path, options, message):
    with pytest.raises(BadInput, match=message):
        scene(tmp_path, 1, **options)


def test_a_run_goes_on_where_no_picture_can_be_drawn(tmp_path, monkeypatch, caplog):
    def refuse(sketch):
        raise RuntimeError("no graphics")

    monkeypatch.setattr(animation, "draw", refuse)
    with caplog.at_level(logging.WARNING, logger="rbs"):
        assert scene(tmp_path, 3)[1].run(progress=False).steps == 3
    assert [record.message for record in caplog.records if "cannot draw" in record.message] == [
        "AnimationExporter 'plate' run.gif cannot draw (no graphics): the run goes on without pictures"
    ]
    assert not (tmp_path / "run.gif").exists()


def test_a_movie_that_cannot_be_written_says_where_the_pictures_are(tmp_path, monkeypatch):
    def full(*_):
        raise OSError("no space left")

    monkeypatch.setattr(animation, "write_movie", full)
    with pytest.raises(OSError, match=r"run.gif cannot write .* \(no space left\): .* are in .*run.gif.frames"):
        scene(tmp_path, 1)[1].run(progress=False)
