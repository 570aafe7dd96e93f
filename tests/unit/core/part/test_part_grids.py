"""Nodes of a part from grids of all kinds."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, Box, Everywhere, Part, volume

SQUARE = Box(size=(1.0, 1.0))


def test_nodes_can_be_the_points_of_any_grid():
    ring = rbs.Ball(radius=1.0, center=(0.0, 0.0)) - rbs.Ball(radius=0.5, center=(0.0, 0.0))
    grid = rbs.grids.ring(0.5, 1.0, spacing=0.05)
    part = Part("ring", ring).discretize(grid, thickness=0.1)
    assert np.array_equal(part.positions, grid.points())
    assert part[volume].sum() == pytest.approx(np.pi * 0.75 * 0.1, rel=1e-13)
    assert (part.spacing, part.thickness, part.grid) == (grid.spacing, 0.1, None)
    ball = Part("ball", Everywhere(), dimension=3).discretize(rbs.grids.ball(1.0, 0.2))
    assert ball[volume].sum() == pytest.approx(4 / 3 * np.pi, rel=1e-13)
    graded = Part("bar", Box.between(0.0, 7.0)).discretize(rbs.grids.graded([0.0, 1.0, 3.0, 7.0]), area=0.5)
    assert graded[volume].tolist() == [0.5, 1.0, 2.0]
    assert (graded.spacing, graded.area) == (None, 0.5)


def test_the_geometry_takes_whole_cells_of_a_grid():
    grid = rbs.grids.disk(1.0, 0.1)
    part = Part("half", rbs.HalfSpace((0.0, 0.0), (1.0, 0.0)), dimension=2).discretize(grid)
    assert (part.positions[:, 0] > 0.0).all()
    assert part[volume].sum() == pytest.approx(np.pi / 2, rel=1e-13)


def test_a_uniform_grid_is_the_one_that_a_spacing_makes():
    one = Part("plate", SQUARE).discretize(0.25, thickness=0.1)
    two = Part("plate", SQUARE).discretize(one.grid, thickness=0.1)
    assert np.array_equal(one.positions, two.positions)
    assert np.array_equal(one[volume], two[volume])
    assert (one.grid, one.spacing) == (two.grid, two.spacing)
    some = Part("some", Everywhere(), dimension=2).discretize(one.grid.where(lambda points: points[:, 1] > 0.0))
    assert some.grid is one.grid
    assert np.array_equal(some.connect(0.5).bonds.counts()[:4], [4, 6, 6, 4])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Part("p", Box(size=1.0)).discretize("0.1"), "spacing = '0.1' does not hold real numbers"),
        (lambda: Part("p", Box(size=1.0)).discretize(rbs.grids.disk(1.0, 0.5)), r"is 1-D, but the grid has 2: ring\("),
        (
            lambda: Part("p", SQUARE.moved((9.0, 9.0))).discretize(rbs.grids.disk(1.0, 0.5)),
            r"part 'p' is empty: none of the 12 points of ring\(0.0, 1.0, 0.5\) lies in Box",
        ),
    ],
)
def test_impossible_grids(make, message):
    with pytest.raises(BadInput, match=message):
        make()
