"""Grids of axes: graded, with single layers, in straight and in curved coordinates."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rbs_core.errors import BadInput
from rbs_core.space import convert, world
from rbs_core.space.grids import Axis, Graded, edges, graded, uniform
from tests.unit.core.space.test_custom import bend, unbend

PI = np.pi
QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=100)
ROWS = st.lists(st.floats(0.01, 2.0), min_size=1, max_size=6).map(lambda sizes: np.cumsum([-1.0, *sizes]))


def test_points_and_cells_with_x_fastest():
    grid = graded([0.0, 1.0, 3.0], [0.0, 2.0], Axis([0.0, 1.0, 2.0], [0.25, 1.75]))
    assert grid.points().tolist() == [[0.5, 1, 0.25], [2, 1, 0.25], [0.5, 1, 1.75], [2, 1, 1.75]]
    assert grid.measures().tolist() == [2.0, 4.0, 2.0, 4.0]
    assert (len(grid), grid.dimension) == (4, 3)
    assert grid.axis(1).edges.tolist() == [0.0, 2.0]


@QUIET
@given(st.lists(ROWS, min_size=1, max_size=3))
def test_cells_fill_the_box_and_linear_functions_are_integrated_exactly(axes):
    grid = graded(*axes)
    lower, upper = np.array([row[0] for row in axes]), np.array([row[-1] for row in axes])
    measures = grid.measures()
    assert (measures > 0.0).all()
    assert measures.sum() == pytest.approx((upper - lower).prod(), rel=1e-13)
    middle = measures @ grid.points() / measures.sum()
    assert np.allclose(middle, (lower + upper) / 2, rtol=0, atol=1e-13 * 12)


def test_sums_converge_to_integrals_with_second_order():
    def error(count):
        x = edges(0.0, 1.0, 0.2 / count, growth=3.0 ** (1.0 / (3 * count)))
        grid = graded(x, x)
        return np.sum(grid.measures() * np.exp(grid.points().sum(axis=1))) - (np.e - 1.0) ** 2

    assert 3.8 < error(10) / error(20) < 4.2


def test_spacing_is_one_number_where_cells_are_alike():
    assert graded([0.0, 1.0, 2.0]).spacing == 1.0
    assert graded([0.0, 1.0, 2.2]).spacing == pytest.approx(1.1)
    assert graded([0.0, 1.0, 3.0]).spacing is None
    assert graded([0.0, 1.0, 2.0], [0.0, 9.0]).spacing == 1.0  # a single layer has no distance


def test_one_layer_in_z():
    grid = uniform((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), 0.25).with_axis(2, edges=(-0.01, 0.01))
    assert len(grid) == 16
    assert (grid.points()[:, 2] == 0.0).all()
    assert grid.measures().sum() == pytest.approx(0.02, rel=1e-14)
    assert grid.spacing == 0.25


def test_explicit_coordinates_along_one_axis():
    grid = uniform((0.0, 0.0), (1.0, 1.0), 0.5).with_axis(1, coordinates=[0.0, 0.1, 0.4])
    assert grid.points()[::2, 1].tolist() == [0.0, 0.1, 0.4]
    assert grid.axis(1).edges.tolist() == pytest.approx([-0.05, 0.05, 0.25, 0.55])
    both = grid.with_axis(1, edges=[0.0, 0.1, 0.5], coordinates=[0.05, 0.2])
    assert both.points()[::2, 1].tolist() == [0.05, 0.2]
    assert isinstance(both, Graded)


def test_extruded_keeps_the_axes():
    grid = uniform((0.0, 0.0), (1.0, 1.0), 0.5).extruded([0.0, 1.0, 3.0])
    assert isinstance(grid, Graded)
    assert grid.measures().tolist() == [0.25] * 4 + [0.5] * 4
    assert grid.axis(2).coordinates.tolist() == [0.5, 2.0]


def test_sectors_of_tubes():
    """Edges along r, phi and z, in cylindrical coordinates; the volumes are exact for any number of cells."""
    system = world.cylindrical("pipe", (1.0, 0.0, 0.0))
    own = graded(edges(1.0, 2.0, 0.2), edges(0.0, PI / 2, 0.3), [0.0, 0.5])
    grid = own.placed(system)
    assert np.allclose(grid.points(), convert(own.points(), system, world))
    assert grid.measures().sum() == pytest.approx(PI / 4 * 3 * 0.5, rel=1e-13)
    plane = graded([1.0, 2.0], edges(-PI, PI, 0.1)).placed(system)
    assert plane.dimension == 2
    assert plane.measures().sum() == pytest.approx(3 * PI, rel=1e-13)


def test_sectors_of_shells():
    system = world.spherical("globe")
    grid = graded(edges(1.0, 2.0, 0.2), edges(0.0, PI, 0.2), edges(-PI, PI, 0.2)).placed(system)
    assert grid.measures().sum() == pytest.approx(4 / 3 * PI * 7, rel=1e-13)
    assert (np.linalg.norm(grid.points(), axis=1) < 2.0).all()


def test_in_coordinates_of_ones_own():
    grid = graded(edges(-1.0, 1.0, 0.1), [0.0, 0.5], [0.0, 1.0]).placed(world.custom("bent", bend, unbend))
    assert grid.measures().sum() == pytest.approx(2.0 * (2.5**2 - 2.0**2) / 2, rel=1e-12)


def test_in_a_moved_and_stretched_system():
    system = world.child("stretched", (1.0, 0.0), [(0.0, 2.0), (-1.0, 0.0)])
    grid = uniform((0.0, 0.0), (1.0, 1.0), 0.5).placed(system)
    assert np.allclose(grid.points(), [[0.75, 0.5], [0.75, 1.5], [0.25, 0.5], [0.25, 1.5]])
    assert np.allclose(grid.measures(), 0.5)
    assert grid.spacing is None
    twice = uniform((0.0, 0.0), (1.0, 1.0), 0.5).placed(world.child("twice", axes=2 * np.eye(3)))
    assert twice.spacing == pytest.approx(1.0)


def test_repr_can_be_typed_back():
    for grid in (graded([0, 1, 3], [0, 1]), graded(Axis([0.0, 1.0], [0.25]))):
        again = eval(repr(grid))
        assert repr(again) == repr(grid)
        assert np.array_equal(again.points(), grid.points())


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: graded(), r"0 axes were given; give the edges of 1, 2 or 3"),
        (lambda: graded([0, 1], [0, 1], [0, 1], [0, 1]), r"4 axes were given"),
        (lambda: graded([0.0, 1.0], [1.0, 0.0]), r"edges\[1\] = 0.0 is not above edges\[0\] = 1.0"),
        (
            lambda: uniform(0.0, 1.0, 0.1).with_axis(1, edges=[0, 1]),
            r"axis 1 is not there; give one from 0 to 0 \(use ext",
        ),
        (lambda: uniform(0.0, 1.0, 0.1).with_axis(0), r"axis 0 got neither edges nor coordinates; give one of them"),
        (lambda: graded([0, 1]).extruded([0, 1]).extruded([0, 1]).extruded([0, 1]), r"4 axes were given"),
        (lambda: graded([0, 1]).placed(world), r"'world' is a root: it has no parent"),
        (
            lambda: graded([-1.0, 1.0], [0.0, 1.0]).placed(world.cylindrical("a")),
            r"points\[0\] = \(-1.0, 0.0\) has a negative radius",
        ),
        (
            lambda: graded([0.0, 1.0], [0.0, 7.0]).placed(world.cylindrical("a")),
            r"go round from 0 to 7 rad, more than a full turn",
        ),
        (lambda: graded([0.0, 1.0], [0.0, 1.0]).placed(world.spherical("a")), r"have 2 axes; give three: r, theta and"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
