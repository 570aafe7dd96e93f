"""What every grid has, and grids made from others: some of the points, layers, other places."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import Ball, Box
from rbs_core.space import world
from rbs_core.space.grids import Cloud, ball, disk, ring, uniform
from rbs_core.space.grids.cells import require_few, typical

SQUARE = uniform((0.0, 0.0), (1.0, 1.0), 0.25)
ALL = np.ones(16, bool)


def left(points):
    return points[:, 0] < 0.5


def test_a_cloud_is_what_it_was_made_of():
    points = np.array([[0.0, 1.0], [2.0, 3.0]])
    cloud = Cloud(points, [1.0, 2.0], 0.5)
    assert (len(cloud), cloud.dimension, cloud.spacing) == (2, 2, 0.5)
    assert np.array_equal(cloud.points(), points)
    points[0] = cloud.points()[0] = 9.0
    assert cloud.points()[0].tolist() == [0.0, 1.0]
    assert cloud.volumes(0.5).tolist() == [0.5, 1.0]
    assert Cloud(points, 3.0).measures().tolist() == [3.0, 3.0]
    assert repr(cloud) == "<Cloud of 2 points, 2-D>"


def test_volumes_are_measures_times_what_is_across():
    assert (SQUARE.volumes(0.1) == 0.0625 * 0.1).all()
    assert np.array_equal(disk(1.0, 0.2).volumes(0.1), disk(1.0, 0.2).measures() * 0.1)


@pytest.mark.parametrize("region", [Box((0.5, 2.0), (0.25, 0.5)), left, left(SQUARE.points())])
def test_points_of_a_region(region):
    half = SQUARE.where(region)
    assert len(half) == 8
    assert (half.points()[:, 0] < 0.5).all()
    assert half.measures().sum() == 0.5
    assert half.spacing == 0.25


def test_some_points_of_a_lattice_are_still_on_it():
    half = SQUARE.where(left)
    grid, cells = half.lattice(np.ones(8, bool))
    assert grid is SQUARE
    assert np.array_equal(grid.points()[cells], half.points())
    quarter = half.where(lambda points: points[:, 1] > 0.5)
    grid, cells = quarter.lattice(np.array([True, False, True, True]))
    assert np.array_equal(grid.points()[cells], quarter.points()[[0, 2, 3]])
    assert SQUARE.lattice(ALL) == (SQUARE, None)
    assert disk(1.0, 0.5).where(left).lattice(np.ones(7, bool)) is None


def test_extruded():
    tube = ring(0.5, 1.0, 0.25).extruded([0.0, 0.25, 0.5])
    assert tube.dimension == 3
    assert tube.measures().sum() == pytest.approx(np.pi * 0.75 * 0.5, rel=1e-14)
    assert np.unique(tube.points()[:, 2]).tolist() == [0.125, 0.375]
    assert tube.spacing == 0.25
    assert ring(0.5, 1.0, 0.25).extruded([0.0, 9.0]).spacing == 0.25
    assert ring(0.5, 1.0, 0.25).extruded([0.0, 1.0, 2.0]).spacing is None
    assert Cloud([[0.0]], 1.0).extruded([0.0, 2.0]).points().tolist() == [[0.0, 1.0]]


def test_placed():
    system = world.child("lying", (0.0, 0.0, 1.0), [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)])
    tube = ring(0.5, 1.0, 0.25).extruded([0.0, 0.25])
    lying = tube.placed(system)
    assert (lying.points()[:, 0] == 0.125).all()
    assert np.allclose(lying.measures(), tube.measures(), rtol=1e-15)
    assert lying.spacing == 0.25


def test_one_number_for_sizes():
    assert typical([0.1, 0.1]) == 0.1
    assert typical([0.1, 0.14]) == pytest.approx(0.12)
    assert typical([0.1, 0.16]) is None
    assert typical([]) is None


def test_repr_of_what_was_made_from_others():
    half = SQUARE.where(left)
    assert repr(half) == f"{SQUARE!r}.where(left)"
    assert repr(SQUARE.where(Ball(9.0, (0.0, 0.0)))) == f"{SQUARE!r}.where(Ball(radius=9.0, center=(0.0, 0.0)))"
    assert repr(SQUARE.where(ALL)) == f"{SQUARE!r}.where(mask)"
    assert repr(half.extruded([0, 1])) == f"{half!r}.extruded((0.0, 1.0))"
    assert repr(half.placed(world.child("a"))) == f"{half!r}.placed(world.child('a', origin=(0.0, 0.0, 0.0)))"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Cloud(np.zeros((0, 2)), 1.0), r"points is empty; give at least one point"),
        (lambda: Cloud([0.0, 1.0], 1.0), r"points has shape \(2,\); give one row per point"),
        (lambda: Cloud([[0.0], [1.0]], [1.0]), r"measures has shape \(1,\) for 2 points; give one number per point"),
        (lambda: Cloud([[0.0], [1.0]], [1.0, 0.0]), r"measures\[1\] = 0.0 is not positive; give every cell a size"),
        (lambda: Cloud([[0.0], [1.0]], [1.0, np.nan]), r"measures\[1\] = nan is not finite"),
        (lambda: Cloud([[0.0]], 1.0, spacing=-1.0), r"spacing = -1.0 is not positive"),
        (lambda: disk(1.0, 0.5).volumes(0.0), r"across = 0.0 is not positive"),
        (
            lambda: SQUARE.where(3),
            r"region = mask gives int64 of shape \(\) for 16 points; give a geometry, or one truth",
        ),
        (lambda: SQUARE.where(lambda points: points), r"gives float64 of shape \(16, 2\) for 16 points"),
        (lambda: SQUARE.where(np.ones(5, bool)), r"gives bool of shape \(5,\) for 16 points"),
        (
            lambda: SQUARE.where(Ball(0.1, (9, 9))),
            r"none of the 16 points of Grid.* lies in Ball.*; use a smaller spacing",
        ),
        (lambda: SQUARE.where(Ball(0.1, (0, 0, 0))), r"points has 2 columns, but Ball.* has dimension 3"),
        (
            lambda: ball(1.0, 0.5).extruded([0, 1]),
            r"shell\(.*\) has three dimensions; only plane and straight grids can",
        ),
        (lambda: disk(1.0, 0.5).extruded([1, 0]), r"edges\[1\] = 0.0 is not above"),
        (lambda: disk(1.0, 0.5).placed(world), r"'world' is a root"),
        (
            lambda: disk(1.0, 0.5).placed(world.cylindrical("pipe")),
            r"ring\(.*\) cannot be placed in 'world/pipe' .*: only the cells between the edges of axes",
        ),
        (lambda: require_few(5e9, "spacing = 1"), r"spacing = 1 would make 5e\+09 points, more than 4294967295; make"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
