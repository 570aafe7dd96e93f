"""Moved shapes keep their kind where they can."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import Ball, Cylinder, Everywhere, Polygon, Segment, Transformed, Where
from tests.unit.core.geometry.examples import EXAMPLES, above_parabola


@pytest.mark.parametrize("geometry", [each for each in EXAMPLES if each.dimension], ids=repr)
def test_a_shift_keeps_the_kind_and_the_size(geometry):
    moved = geometry.moved(np.arange(1.0, geometry.dimension + 1.0))
    assert type(moved) is type(geometry) or isinstance(moved, Transformed)
    assert moved.size == pytest.approx(geometry.size)
    assert moved.moved(-np.arange(1.0, geometry.dimension + 1.0)).size == pytest.approx(geometry.size)


def test_parameters_follow():
    assert Ball(1.0, (1.0, 0.0)).rotated(np.pi / 2) == Ball(1.0, (0.0, 1.0))
    assert Segment((0, 0), (1, 0)).rotated(np.pi, center=(1.0, 1.0)) == Segment((2, 2), (1, 2))
    assert Cylinder(1.0, (0, 0, 0), (0, 0, 2)).scaled(0.5, (0, 0, 2)) == Cylinder(0.5, (0, 0, 1), (0, 0, 2))
    assert Polygon([(0, 0), (1, 0), (0, 1)]).mirrored((0, 0), (1, 0)) == Polygon([(0, 0), (-1, 0), (0, 1)])
    assert Everywhere().rotated(1.0) == Everywhere()


def test_the_old_geometry_stays_as_it_is():
    ball = Ball(1.0, (1.0, 0.0))
    ball.moved((1.0, 1.0))
    assert ball == Ball(1.0, (1.0, 0.0))


def test_functions_are_wrapped_once():
    moved = Where(above_parabola, dimension=2).moved((0.0, 1.0)).rotated(np.pi)
    assert isinstance(moved, Transformed)
    assert moved.geometry == Where(above_parabola, dimension=2)
    assert moved.contains([[0.0, -1.5], [0.0, -0.5], [1.0, -2.5]]).tolist() == [True, False, True]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Ball(1.0, (0, 0)).moved((1, 2, 3)), r"vector = .* has 3 components, but Ball.* give 2 components"),
        (lambda: Ball(1.0, (0, 0)).mirrored((0, 0, 0), (0, 0, 1)), r"normal has 3 columns, but Ball"),
        (lambda: Ball(1.0, (0, 0, 0)).rotated(1.0), r"axis is missing"),
        (lambda: Ball(1.0, (0, 0)).rotated(1.0, center=(0, 0, 0)), r"center = .* has 3 components; give 2"),
        (lambda: Everywhere().scaled(2.0), r"Everywhere\(\) works in any dimension; give a center"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
