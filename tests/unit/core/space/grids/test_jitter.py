"""Displaced points stay in their cells and keep their volumes."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.space.grids import ball, disk, graded, jittered, uniform

GRIDS = {
    "line": uniform(0.0, 1.0, 0.1),
    "square": uniform((0.0, 0.0), (1.0, 1.0), 0.1),
    "graded": graded([0.0, 0.1, 0.3, 0.7], [0.0, 0.2, 0.4]),
    "disk": disk(1.0, 0.1),
    "ball": ball(1.0, 0.2),
}


@pytest.mark.parametrize("name", GRIDS)
def test_points_move_by_a_share_of_their_cells_at_most(name):
    grid = GRIDS[name]
    moved = jittered(grid, 0.3, seed=7)
    edge = grid.measures() ** (1 / grid.dimension)
    shift = (moved.points() - grid.points()) / edge[:, None]
    assert np.abs(shift).max() <= 0.3 + 1e-12
    assert np.abs(shift).max() > 0.2
    assert abs(shift.mean()) < 0.3 * 3 / np.sqrt(3 * shift.size)  # three standard deviations of a uniform spread
    assert np.array_equal(moved.measures(), grid.measures())
    assert moved.spacing == grid.spacing


def test_the_same_seed_gives_the_same_points():
    grid = GRIDS["square"]
    points = [jittered(grid, 0.2, seed=seed).points() for seed in (1, 1, 2)]
    assert np.array_equal(points[0], points[1])
    assert not np.array_equal(points[0], points[2])
    assert np.array_equal(jittered(grid, 0.0).points(), grid.points())


def test_displaced_points_are_no_lattice():
    grid = GRIDS["square"]
    assert grid.lattice(np.ones(100, bool)) == (grid, None)
    assert jittered(grid, 0.1).lattice(np.ones(100, bool)) is None


def test_repr_can_be_typed_back():
    moved = jittered(disk(1.0, 0.5), 0.2, seed=3)
    assert repr(moved) == "jittered(ring(0.0, 1.0, 0.5), 0.2, seed=3)"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: jittered(GRIDS["disk"], 0.5),
            r"amount = 0.5 would let points leave their cells .*; give a share from 0",
        ),
        (lambda: jittered(GRIDS["disk"], -0.1), r"amount = -0.1 would"),
        (lambda: jittered(GRIDS["disk"], np.nan), r"amount = nan is not finite"),
        (lambda: jittered(0.1, 0.1), r"grid = 0.1 is no grid; give one of rbs_core.grids"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
