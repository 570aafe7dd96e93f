"""Uniform grids: counts, order, symmetry to the bit."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rbs_core.errors import BadInput
from rbs_core.space.bases import rotation
from rbs_core.space.grids.regular import Grid, rotated, uniform

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


def test_axes_of_a_grid():
    grid = uniform((0.0, 0.0), (1.0, 0.5), 0.25)
    assert grid.axis(0).edges.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert [len(axis) for axis in grid.axes] == [4, 2]
    assert np.array_equal(grid.axis(1).coordinates, grid.coordinates(1))
    assert (grid.measures() == 0.0625).all()


# -- turned ---------------------------------------------------------------------------------------------------------


@QUIET
@given(st.integers(2, 3), st.floats(0.05, 0.4), st.lists(st.floats(0.2, 1.0), min_size=3, max_size=3), st.booleans())
def test_turned_by_nothing_it_is_the_uniform_grid(dimension, spacing, sides, elsewhere):
    lower = [0.3, -0.2, 0.1][:dimension]
    upper = [low + side for low, side in zip(lower, sides, strict=False)]
    center = {"center": [5.0, 4.0, 3.0][:dimension]} if elsewhere else {}
    turned, straight = rotated(lower, upper, spacing, 0.0, **center), uniform(lower, upper, spacing)
    assert len(turned) == len(straight)
    assert np.allclose(turned.points(), straight.points(), rtol=0, atol=1e-14)
    assert np.allclose(turned.measures(), straight.measures())


@QUIET
@given(st.integers(2, 3), st.floats(-7.0, 7.0), st.integers(0, 2**32 - 1), st.booleans())
def test_turned_cells_cover_the_box(dimension, angle, seed, elsewhere):
    """Every point of the box is in a cell: turned back, no component is more than half a spacing from a point."""
    rng = np.random.default_rng(seed)
    lower, upper, spacing = np.zeros(dimension), rng.uniform(0.3, 1.0, dimension), 0.1
    options = {"axis": rng.normal(size=3)} if dimension == 3 else {}
    if elsewhere:
        options["center"] = rng.uniform(-3.0, 3.0, dimension)
    grid = rotated(lower, upper, spacing, angle, **options)
    turn = rotation(angle, options.get("axis", (0.0, 0.0, 1.0)))[:dimension, :dimension]
    corner = np.array(list(np.ndindex(*(2,) * dimension))) * upper
    places = np.vstack([corner, rng.uniform(lower, upper, (60, dimension))])
    apart = np.abs((places[:, None] - grid.points()) @ turn.T).max(axis=2)
    assert apart.min(axis=1).max() <= spacing / 2 + 1e-12
    # it is a lattice with this spacing and direction, around the middle of the box
    steps = (grid.points() - grid.points()[0]) @ turn.T / spacing
    assert np.allclose(steps, np.rint(steps), atol=1e-10)
    assert grid.spacing == spacing
    assert np.allclose(grid.measures(), spacing**dimension, rtol=1e-14)


def test_turned_by_a_right_angle_about_an_axis():
    grid = rotated((0, 0, 0), (1.0, 2.0, 3.0), 1.0, np.pi / 2, axis=(1, 0, 0), center=(0.5, 1.0, 1.5))
    # one cell along y and two along z stick out on both sides of the box: the lattice was laid for the straight box
    assert len(np.unique(np.round(grid.points()[:, 0], 9))) == 1
    assert np.allclose(sorted(set(np.round(grid.points()[:, 1], 9))), [0.0, 1.0, 2.0])
    assert grid.lattice(np.ones(len(grid), bool)) is None


def test_a_turned_grid_is_symmetric_to_its_center():
    points = rotated((-1.0, -1.0), (1.0, 1.0), 0.3, 0.4).points()
    assert {tuple(row) for row in (-points).tolist()} == {tuple(row) for row in points.tolist()}


def test_repr_of_a_turned_grid_can_be_typed_back():
    for grid in (
        rotated((0, 0), (1, 1), 0.5, 0.3),
        rotated((0, 0, 0), (1, 1, 1), 0.5, 0.3, axis=(1, 1, 0), center=(0, 0, 0)),
    ):
        again = eval(repr(grid))
        assert repr(again) == repr(grid)
        assert np.array_equal(again.points(), grid.points())


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
        (lambda: rotated(0.0, 1.0, 0.1, 0.3), r"a grid in 1-D has no axis to turn about: use uniform"),
        (lambda: rotated((0, 0), (1, 1), 0.1, 0.3, axis=(0, 0, 1)), r"a grid in 2-D has no axis .*: leave axis out"),
        (lambda: rotated((0, 0, 0), (1, 1, 1), 0.1, 0.3, axis=(0, 0, 0)), r"axis = .* has no length; give a vector"),
        (lambda: rotated((0, 0), (1, 1), 0.1, 0.3, center=(0, 0, 0)), r"center = .* has 3 components; give 2, as the"),
        (lambda: rotated((0, 0), (1, 1), 0.1, np.nan), r"angle = nan is not finite"),
        (lambda: rotated((0, 0), (1, 0), 0.1, 0.3), r"the box is empty"),
        (lambda: Grid(0.1, (2.5,), np.zeros(1)), r"shape\[0\] = 2.5 is no number of cells"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
