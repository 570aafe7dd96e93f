"""Movies: what other programs find in them, frame by frame."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from PIL import Image, ImageSequence

from rbs_core import BadInput
from rbs_plugins.exporters.movie import need_encoder, write_movie

COLORS = ((68, 1, 84), (253, 231, 37), (255, 255, 255), (0, 0, 0))  # both ends of viridis, white and black


@pytest.fixture
def pictures(tmp_path):
    """Four pictures of 32 x 16 pixels, each with a bar of a color of its own on the ones before."""
    files, image = [], np.full((16, 32, 3), 255, np.uint8)
    for number, color in enumerate(COLORS):
        image[:, 8 * number : 8 * number + 8] = color
        files.append(tmp_path / f"picture_{number}.png")
        Image.fromarray(image).save(files[-1])
    return files


def test_a_gif_has_all_frames_with_their_colors_and_their_pause(pictures, tmp_path):
    path = tmp_path / "movie.gif"
    write_movie(path, pictures, 10.0, "viridis")
    with Image.open(path) as movie:
        assert (movie.format, movie.size, movie.n_frames) == ("GIF", (32, 16), 4)
        assert movie.info["loop"] == 0
        for picture, frame in zip(pictures, ImageSequence.Iterator(movie), strict=True):
            assert frame.info["duration"] == 100
            with Image.open(picture) as wanted:
                difference = np.asarray(frame.convert("RGB")).astype(int) - np.asarray(wanted)
            assert np.abs(difference).max() <= 4  # half of the colors of the map, and grays
    assert not list(tmp_path.glob(".*partial"))


def test_one_picture_is_a_movie_too(pictures, tmp_path):
    write_movie(tmp_path / "movie.gif", pictures[:1], 50.0, "gray")
    with Image.open(tmp_path / "movie.gif") as movie:
        assert (movie.n_frames, movie.info["duration"]) == (1, 20)


def test_a_movie_that_cannot_be_finished_leaves_the_old_one(pictures, tmp_path):
    (tmp_path / "movie.gif").write_bytes(b"old")
    with pytest.raises(FileNotFoundError):
        write_movie(tmp_path / "movie.gif", [*pictures, tmp_path / "gone.png"], 10.0, "viridis")
    assert (tmp_path / "movie.gif").read_bytes() == b"old"
    assert not list(tmp_path.glob(".*partial"))


def test_an_mp4_has_all_frames(pictures, tmp_path):
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "movie.mp4"
    write_movie(path, pictures, 10.0, "viridis")
    need_encoder("test", path)
    assert imageio_ffmpeg.count_frames_and_secs(str(path)) == (4, pytest.approx(0.4, abs=0.01))
    assert path.read_bytes()[4:8] == b"ftyp"
    assert not list(tmp_path.glob(".*partial"))


def test_without_an_encoder_the_cure_is_said(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(BadInput, match=r"^me: an MP4 needs imageio-ffmpeg, .*'rbs\[movie\]', or write .*a\.gif'"):
        need_encoder("me", tmp_path / "a.mp4")
    need_encoder("me", tmp_path / "a.gif")
