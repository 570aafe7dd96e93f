"""Pictures of frames, without a screen."""

from __future__ import annotations

import builtins

import numpy as np
import pytest

from rbs_core import BadInput
from rbs_core.command.picture import SIZE, draw

POINTS = np.stack([*np.meshgrid(np.arange(10.0), np.arange(5.0)), np.zeros((5, 10))], axis=-1).reshape(-1, 3)


@pytest.mark.parametrize(
    "points", [POINTS, POINTS[:, [0, 2, 1]], POINTS[:10], POINTS[:1]], ids=["xy", "xz", "x", "one"]
)
def test_a_picture(points, tmp_path):
    draw(points, np.arange(len(points), dtype=float), "damage [1]", "strip, t = 1 s", tmp_path / "a.png")
    pixels = pytest.importorskip("matplotlib.image").imread(tmp_path / "a.png")
    assert pixels.shape[:2] == SIZE[::-1]
    assert len(np.unique(pixels.reshape(-1, pixels.shape[2]), axis=0)) > 8  # colours of nodes, bar and text


def test_where_no_picture_can_be_drawn(monkeypatch, tmp_path):
    load = builtins.__import__

    def refuse(name, *rest, **more):
        if name.startswith("pyvista"):
            raise ImportError("libGL.so.1 is missing")
        return load(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(
        BadInput, match=r"no picture can be drawn here \(libGL.so.1 is missing\): open the frames in Para"
    ):
        draw(POINTS, POINTS[:, 0], "x [m]", "strip", tmp_path / "a.png")
    assert not list(tmp_path.iterdir())


def test_where_no_file_can_be_written(tmp_path):
    (tmp_path / "a.png").mkdir()
    with pytest.raises(BadInput, match=r"cannot write .*a.png \(.*\): choose another place"):
        draw(POINTS, POINTS[:, 0], "x [m]", "strip", tmp_path / "a.png")
