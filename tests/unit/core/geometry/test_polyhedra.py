"""Prisms, pyramids, tetrahedra."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import Box, Polygon, Prism, Pyramid, RegularPolygon, Tetrahedron

SQUARE = Polygon([(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)])
L_SHAPE = Polygon([(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)])


@pytest.mark.parametrize("base", [SQUARE, Polygon(SQUARE.points[::-1])], ids=["up", "down"])
@pytest.mark.parametrize("vector", [(0, 0, 3), (0, 0, -3)], ids=["above", "below"])
def test_an_upright_prism_on_a_square_is_a_box(base, vector, rng):
    prism, box = Prism(base, vector), Box.between((0, 0, min(0, vector[2])), (2, 2, max(0, vector[2])))
    points = rng.uniform(-4.0, 4.0, (2000, 3))
    assert prism.distance(points) == pytest.approx(box.distance(points), abs=1e-12)
    assert np.array_equal(prism.contains(points), box.contains(points))
    assert np.allclose(prism.bounds, box.bounds)


def test_a_notch_is_outside():
    prism = Prism(L_SHAPE, (0, 0, 1))
    points = [[0.5, 0.5, 0.5], [1.5, 1.5, 0.5], [1.5, 0.5, 0.5], [1.0, 1.5, 0.5]]
    assert prism.status(points).tolist() == [-1, 1, -1, 0]
    assert prism.distance(points) == pytest.approx([-0.5, 0.5, -0.5, 0.0])


def test_pyramid():
    pyramid = Pyramid(SQUARE, (1, 1, 3))
    assert pyramid.status([[1, 1, 3], [1, 1, 1], [0, 0, 0], [0.1, 0.1, 2.0], [1, 1, -0.1]]).tolist() == [0, -1, 0, 1, 1]
    notched = Pyramid(L_SHAPE, (0.5, 0.5, 3))
    assert notched.contains([[0.5, 0.5, 2.0], [1.5, 1.5, 0.1]]).tolist() == [True, False]


def test_tetrahedron_in_any_order_of_corners(rng):
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
    points = rng.uniform(-0.2, 1.0, (3000, 3))
    expected = (points >= 0.0).all(axis=1) & (points.sum(axis=1) <= 1.0)
    for order in ([0, 1, 2, 3], [1, 0, 2, 3], [3, 2, 1, 0], [2, 3, 0, 1]):
        assert np.array_equal(Tetrahedron(*corners[order]).contains(points), expected)


def test_a_prism_with_many_sides_becomes_a_cylinder():
    base = RegularPolygon(60, (0, 0, 0), (1, 0, 0), (0, 0, 1))
    assert Prism(base, (0, 0, 2)).distance([[0.0, 0.0, 1.0], [3.0, 0.0, 1.0]]) == pytest.approx([-1.0, 2.0], abs=2e-3)


def test_slanted_prisms_and_pyramids_agree_with_their_sections(rng):
    points = rng.uniform(-1.0, 3.0, (5000, 3))
    x, y, z = points.T
    slanted = Prism(SQUARE, (1, 0.5, 2))
    t = z / 2.0
    expected = (t >= 0) & (t <= 1) & (x - t >= 0) & (x - t <= 2) & (y - t / 2 >= 0) & (y - t / 2 <= 2)
    assert np.array_equal(slanted.contains(points), expected)
    assert np.array_equal(slanted.status(points) <= 0, expected)
    tip = np.array([3.0, -1.0, 2.5])
    pyramid, t = Pyramid(SQUARE, tip), z / 2.5
    low_x, low_y, edge = t * tip[0], t * tip[1], 2.0 * (1.0 - t)
    expected = (t >= 0) & (t <= 1) & (x >= low_x) & (x <= low_x + edge) & (y >= low_y) & (y <= low_y + edge)
    assert np.array_equal(pyramid.contains(points), expected)
    assert pyramid.contains([tip, tip + 1e-3, (3.001, -1.0, 2.5)]).tolist() == [True, False, False]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Prism(3, (0, 0, 1)), r"base = 3 is no Polygon"),
        (
            lambda: Prism(Polygon([(0, 0), (1, 0), (0, 1)]), (0, 0, 1)),
            r"lies in 2-D; give its points three",
        ),
        (lambda: Prism(SQUARE, (1, 0, 0)), r"vector = .* lies in the plane of the base, so that no volume is enclosed"),
        (lambda: Prism(SQUARE, (0, 0, 0)), r"vector = .* has no length"),
        (lambda: Pyramid(SQUARE, (9, 9, 0)), r"apex = .* lies in the plane of the base"),
        (lambda: Tetrahedron((0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)), r"d = .* lies in the plane of a, b, c"),
        (lambda: Tetrahedron((0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 0, 1)), r"enclose no area"),
        (lambda: Tetrahedron((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 1)), r"d = .* has 2 components; give 3"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
