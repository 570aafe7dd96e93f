"""Polylines through nodes beside known curves."""

from __future__ import annotations

import csv

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import CrackPath, Damage, crack_paths
from rbs_plugins.fields import damage


def beside(curve, wide=0.8):
    """Nodes of a grid of spacing 1 that lie beside a curve (k, 2)."""
    x, y = np.meshgrid(np.arange(0.5, 60.0), np.arange(-19.5, 20.0))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    return points[np.linalg.norm(points[:, None] - curve, axis=2).min(axis=1) < wide]


def test_a_curved_crack():
    x = np.linspace(5.0, 50.0, 2000)
    curve = np.stack([x, 8.0 * np.sin(x / 10.0)], axis=1)
    (path,) = crack_paths(beside(curve), 1.0)
    assert path[0, 0] < path[-1, 0]
    assert np.linalg.norm(path[:, None] - curve, axis=2).min(axis=1).max() < 0.8
    assert np.linalg.norm(path[0] - curve[0]) < 1.6
    assert np.linalg.norm(path[-1] - curve[-1]) < 1.6
    sizes = [np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in (path, curve)]
    assert sizes[0] == pytest.approx(sizes[1], rel=0.08)


def test_a_branch_is_a_path_of_its_own():
    stem = np.stack([np.linspace(5.0, 25.0, 500), np.zeros(500)], axis=1)
    arm = np.linspace(0.0, 1.0, 500)[:, None]
    up, down = [25.0, 0.0] + arm * [25.0, 12.0], [25.0, 0.0] + arm * [15.0, -10.0]
    first, second = crack_paths(beside(np.concatenate([stem, up, down])), 1.0)
    assert np.linalg.norm(first[-1] - up[-1]) < 1.6
    assert np.linalg.norm(second[-1] - down[-1]) < 1.6
    assert second[:, 1].max() < 0


def test_few_nodes_are_no_path():
    assert crack_paths(np.zeros((0, 2)), 1.0) == []
    assert crack_paths(np.array([[0.0, 0.0], [1.0, 0.0], [9.0, 9.0]]), 1.0) == []


def test_the_file_holds_the_cut(tmp_path):
    part = rbs.Part("plate", rbs.Box(size=(40.0, 20.0))).discretize(1.0).connect(3.015)
    part.bonds.cut(rbs.Segment((-15.0, 0.0), (12.0, 0.0)))
    path = CrackPath(part, tmp_path / "crack")
    rbs.Analysis([Damage(part), path]).run(steps=1, dt=1.0, progress=False)
    with (tmp_path / "crack_00000001.csv").open(encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    assert head == ["path", "x [m]", "y [m]"]
    points = np.array(rows, float)[:, 1:]
    np.testing.assert_array_equal(points, path.paths[0])
    assert np.abs(points[:, 1]).max() < 0.6
    np.testing.assert_allclose(points[[0, -1], 0], [-15.0, 12.0], atol=1.0)


def test_bad_input_is_refused(tmp_path):
    bar = rbs.Part("bar", rbs.Box(size=(40.0,))).discretize(1.0)
    with pytest.raises(BadInput, match="is a point: take CrackTip"):
        CrackPath(bar, tmp_path / "crack")
    cloud = rbs.Part.from_points("cloud", np.random.default_rng(1).uniform(size=(9, 2)), 1.0)
    with pytest.raises(BadInput, match="distance of neighbors is not known"):
        CrackPath(cloud, tmp_path / "crack")
    cloud[damage] = 0.0
    with pytest.raises(BadInput, match="threshold=-1"):
        CrackPath(cloud, tmp_path / "crack", threshold=-1)
