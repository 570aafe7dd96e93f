"""How wide nodes are drawn: they touch, in pictures of any shape and in bodies that are turned."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins.exporters.drawing import WIDEST, Sketch, _point_size, _widening


def sketch(low, high, spacing, size=(1000, 1000)):
    low, high = np.array([*low, 0.0]), np.array([*high, 0.0])
    points = np.stack([low, high])
    return Sketch(points, np.zeros(2), spacing, low, high, True, "", "", None, size, "viridis")


@pytest.mark.parametrize("size", [(1000, 1000), (1600, 500), (500, 1600)])
@pytest.mark.parametrize("high", [(1.0, 1.0), (4.0, 0.5), (0.5, 4.0)])
def test_nodes_of_a_grid_touch_in_pictures_of_any_shape(size, high):
    drawn = sketch((0.0, 0.0), high, 0.05, size)
    pixels = _point_size(drawn) / 0.05  # per m
    width, height = (pixels * each for each in high)
    assert width <= 0.85 * size[0] * (1 + 1e-9)
    assert height <= 0.92 * size[1] * (1 + 1e-9)
    assert max(width / (0.85 * size[0]), height / (0.92 * size[1])) == pytest.approx(1 / 1.04)


def test_nodes_of_a_turned_body_are_drawn_wider():
    part = rbs.Part("block", rbs.Box([1.0, 0.5])).discretize(0.1).connect(horizon=0.2015)
    still = np.column_stack([part.positions, np.zeros(len(part))])
    assert _widening(part, still) == 1.0
    assert _widening(part, 1.01 * still) == pytest.approx(1.01)
    turned = still[:, [1, 0, 2]] * np.array([-1.0, 1.0, 1.0])
    assert _widening(part, turned) == 1.0 + WIDEST
