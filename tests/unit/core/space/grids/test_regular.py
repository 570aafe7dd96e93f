"""Uniform grids: counts, order, symmetry to the bit."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rbs_core.errors import BadInput
from rbs_core.space.grids.regular import Grid, uniform

QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=200)
SPACINGS = st.floats(1e-9, 10.0)


@pytest.mark.parametrize(
    ("size", "spacing", "cells"),
    [
        (1.0, 0.1, 10),  # 1/0.1 is exact, 0.3/0.1 is not: both mean whole cells
        (0.3, 0.1, 3),
        (0.05 + 6 * 0.05 / 500, 0.05 / 500, 506),
        (1.0 + 1e-8, 0.1, 10),
        (1.0 - 1e-8, 0.1, 10),
        (1.01, 0.1, 11),
        (0.99, 0.1, 10),
        (1e-9, 0.1, 1),
    ],
)
def test_number_of_cells(size, spacing, cells):
    assert uniform(0.0, size, spacing).shape == (cells,)


def test_points_are_cell_middles_with_x_fastest():
    grid = uniform((0.0, 10.0, 20.0), (3.0, 12.0, 24.0), 1.0)
    points = grid.points()
    assert grid.shape == (3, 2, 4)
    assert points.shape == (24, 3)
    assert points.dtype == np.float64
    for iz in range(4):
        for iy in range(2):
            for ix in range(3):
                assert points[ix + iy * 3 + iz * 6].tolist() == [ix + 0.5, iy + 10.5, iz + 20.5]


@QUIET
@given(st.lists(st.integers(1, 9), min_size=1, max_size=3), SPACINGS)
def test_grid_around_zero_is_symmetric_to_the_bit(shape, spacing):
    sides = np.array(shape) * spacing
    grid = uniform(-sides / 2, sides / 2, spacing)
    assert grid.shape == tuple(shape)
    points = grid.points()
    by_axes = points.reshape(*reversed(shape), len(shape))
    for axis in range(len(shape)):
        mirrored = np.flip(by_axes, axis=len(shape) - 1 - axis).copy()
        mirrored[..., axis] *= -1.0
        assert np.array_equal(mirrored, by_axes)


@QUIET
@given(st.floats(-100.0, 100.0), st.floats(0.01, 100.0), st.floats(0.05, 10.0))
def test_cells_cover_the_box_and_overhang_both_sides_alike(lower, size, spacing):
    grid = uniform(lower, lower + size, spacing)
    first, last = grid.points()[[0, -1], 0]
    left = lower - (first - spacing / 2)
    right = (last + spacing / 2) - (lower + size)
    assert left == pytest.approx(right, abs=1e-11)
    assert -1e-6 * spacing <= left <= spacing / 2 + 1e-11


def test_coordinates_are_counted_from_the_center():
    grid = Grid(0.1, (4,), np.array([7.0]))
    expected = [7.0 + (i - 1.5) * 0.1 for i in range(4)]
    assert grid.coordinates(0).tolist() == expected
    assert grid.points()[:, 0].tolist() == expected


def test_cell_volume():
    assert uniform(0.0, 1.0, 0.5).cell_volume() == 0.5
    assert uniform((0, 0), (1, 1), 0.5).cell_volume(thickness=0.1) == 0.25 * 0.1
    grid = uniform((0, 0, 0), (1, 1, 1), 0.5)
    assert grid.cell_volume() * len(grid) == 1.0
    with pytest.raises(BadInput, match=r"thickness = 0.0 is not positive"):
        grid.cell_volume(0.0)


def test_grids_are_immutable_values():
    grid = uniform((0, 0), (1, 1), 0.5)
    assert grid == uniform((0, 0), (1, 1), 0.5)
    assert hash(grid) == hash(uniform((0, 0), (1, 1), 0.5))
    assert grid != uniform((0, 0), (1, 1), 0.25)
    assert grid != 3
    assert (grid.dimension, len(grid)) == (2, 4)
    assert repr(grid) == "Grid(spacing=0.5, shape=(2, 2), center=(0.5, 0.5))"
    assert eval(repr(grid)) == grid
    with pytest.raises(dataclasses.FrozenInstanceError):
        grid.spacing = 1.0
    with pytest.raises(ValueError, match="read-only"):
        grid.center[0] = 1.0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: uniform(0.0, 1.0, 0.0), r"spacing = 0.0 is not positive"),
        (lambda: uniform(0.0, 1.0, -0.1), r"spacing = -0.1 is not positive"),
        (lambda: uniform(0.0, 1.0, np.nan), r"spacing = nan is not finite"),
        (lambda: uniform(0.0, 1.0, np.inf), r"spacing = inf is not finite"),
        (lambda: uniform((0, 0), (1, 0), 0.1), r"upper\[1\] = 0.0 is not above lower\[1\] = 0.0.*give upper above"),
        (lambda: uniform((0, 0), (1, np.inf), 0.1), r"upper\[1\] = inf: .*give a bounded geometry"),
        (lambda: uniform((-np.inf, 0), (1, 1), 0.1), r"lower\[0\] = -inf: .*give a bounded geometry"),
        (lambda: uniform(np.inf, -np.inf, 0.1), r"the box is empty"),
        (lambda: uniform((0, np.nan), (1, 1), 0.1), r"lower\[1\] = nan is not finite"),
        (lambda: uniform((0, 0), (1, 1, 1), 0.1), r"lower = .* has 2 components, upper = .* has 3"),
        (lambda: uniform((0, 0, 0), (1, 1, 1), 1e-4), r"spacing = 0.0001 is too small.*give a larger spacing"),
        (lambda: uniform(0.0, 1.0, 5e-324), r"is too small"),
        (lambda: Grid(0.1, (2, 2), np.zeros(3)), r"shape = \(2, 2\) has 2 axes, center = .* has 3"),
        (lambda: Grid(0.1, (2, 0), np.zeros(2)), r"shape\[1\] = 0 is no number of cells"),
        (lambda: Grid(0.1, (2.5,), np.zeros(1)), r"shape\[0\] = 2.5 is no number of cells"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
