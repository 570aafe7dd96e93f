"""Rings, disks, tubes and cylinders: exact volumes and centers of mass, symmetry, order of sums."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from rbs_core.errors import BadInput
from rbs_core.space.grids import *  # noqa: F403  the names that a repr is made of
from rbs_core.space.grids import Cloud, cylinder, disk, edges, polar, ring, tube

PI = np.pi
QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=100)
INNER, WIDTH = st.floats(0.0, 5.0), st.floats(0.01, 5.0)  # the inner radius in widths


@QUIET
@given(INNER, WIDTH, st.floats(0.04, 2.0))
def test_cells_fill_the_ring_exactly(inner, width, share):
    inner = inner * width
    grid = ring(inner, inner + width, share * width)
    measures, radii = grid.measures(), np.linalg.norm(grid.points(), axis=1)
    assert (measures > 0.0).all()
    assert measures.sum() == pytest.approx(PI * width * (2 * inner + width), rel=1e-13)
    assert (radii > inner).all()
    assert (radii < inner + width).all()
    assert len(grid) == len(measures) == len(radii)


@QUIET
@given(INNER, WIDTH, st.floats(0.04, 0.5), st.floats(0.0, 2 * PI))
def test_linear_functions_are_integrated_exactly_over_quarters(inner, width, share, direction):
    """As points are centers of mass: over a quarter ring the integrals of x and y are (R^3 - r^3)/3."""
    inner = inner * width
    quarter = ring(inner, inner + width, share * width).where(lambda points: (points > 0.0).all(axis=1))
    outer = inner + width
    assert quarter.measures().sum() == pytest.approx(PI / 4 * (outer**2 - inner**2), rel=1e-13)
    moments = quarter.measures() @ quarter.points() @ [np.cos(direction), np.sin(direction)]
    exact = (outer**3 - inner**3) / 3 * (np.cos(direction) + np.sin(direction))
    assert moments == pytest.approx(exact, rel=1e-12, abs=1e-12 * outer**3)


def test_points_are_symmetric_to_axes_and_diagonals_to_the_bit():
    points = disk(1.0, 0.07).points()
    rows = {tuple(row) for row in points.tolist()}
    assert len(rows) == len(points)
    for image in (points * [1, -1], points * [-1, 1], points[:, ::-1]):
        assert {tuple(row) for row in image.tolist()} == rows


def test_cells_are_about_square():
    for grid in (disk(1.0, 0.02), ring(0.9, 1.1, 0.02)):
        assert (grid.measures() > 0.7 * 0.02**2).all()
        assert (grid.measures() < 1.3 * 0.02**2).all()
        nearest = cKDTree(grid.points()).query(grid.points(), k=2)[0][:, 1]
        assert 0.7 * 0.02 < nearest.min() <= nearest.max() < 1.2 * 0.02
        assert grid.spacing == pytest.approx(0.02)


@pytest.mark.parametrize("make", [lambda h: disk(1.0, h), lambda h: ring(0.4, 1.0, h)])
def test_sums_converge_to_integrals_with_second_order(make):
    def error(spacing):
        grid = make(spacing)
        x, y = grid.points().T
        return np.sum(grid.measures() * np.exp(x) * np.cos(2 * y))

    exact = error(0.6 / 384)
    ratio = (error(0.6 / 12) - exact) / (error(0.6 / 24) - exact)
    assert 3.0 < ratio < 5.5  # 4 for the second order; counts of cells jump by four


def test_counts_around_can_be_given():
    grid = ring(0.5, 1.0, 0.25, around=6)
    assert len(grid) == 12
    angles = np.arctan2(*grid.points()[:6, ::-1].T)
    assert np.allclose(np.diff(np.unwrap(angles)), PI / 3)
    assert len(polar([0.0, 1.0, 2.0], (4, 9))) == 13
    assert polar([0.0, 1.0, 2.0], (4, 9)).measures().sum() == pytest.approx(4 * PI, rel=1e-15)


def test_graded_rings():
    grid = polar(edges(0.0, 1.0, 0.2, growth=0.85), center=(3.0, 4.0))
    assert grid.measures().sum() == pytest.approx(PI, rel=1e-13)
    assert np.allclose(grid.measures() @ grid.points() / PI, [3.0, 4.0], rtol=1e-13)
    assert grid.spacing is None


@QUIET
@given(INNER, WIDTH, st.floats(0.1, 3.0), st.floats(0.1, 1.0))
def test_cells_fill_tubes_exactly(inner, width, height, share):
    inner, height = inner * width, height * width
    grid = tube(inner, inner + width, height, share * width, center=(1.0, 2.0, 3.0))
    volume = PI * width * (2 * inner + width) * height
    measures, points = grid.measures(), grid.points() - [1.0, 2.0, 3.0]
    assert measures.sum() == pytest.approx(volume, rel=1e-13)
    assert np.allclose(measures @ points / volume, 0.0, atol=1e-13 * (inner + width + height))
    assert (np.abs(points[:, 2]) < height / 2).all()
    moment = measures @ points[:, 2] ** 2  # of layers: the exact one less that within them
    layers = max(1, round(height / (share * width)))
    assert moment == pytest.approx(volume * height**2 / 12 * (1.0 - 1.0 / layers**2), rel=1e-9, abs=1e-12 * volume)


def test_a_cylinder_is_a_tube_without_a_hole():
    grid = cylinder(0.5, 2.0, 0.1, center=(0.0, 0.0, 1.0))
    assert grid.measures().sum() == pytest.approx(PI / 2, rel=1e-13)
    assert grid.points()[:, 2].min() == pytest.approx(0.05)
    assert grid.spacing == pytest.approx(0.1)
    assert np.array_equal(np.sort(grid.points()[:, 0]), np.sort(-grid.points()[:, 0]))


def test_repr_can_be_typed_back():
    for grid in (
        ring(0.5, 1.0, 0.1, center=(1.0, 2.0)),
        disk(1.0, 0.3),
        ring(0.5, 1.0, 0.25, around=(6, 8)),
        polar([0.0, 1.0, 3.0], 8),
        cylinder(1.0, 1.0, 0.4),
    ):
        again = eval(repr(grid))
        assert repr(again) == repr(grid)
        assert isinstance(again, Cloud)
        assert np.array_equal(again.points(), grid.points())
    assert repr(disk(1, 0.01)) == "ring(0.0, 1.0, 0.01)"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: ring(1.0, 0.5, 0.1), r"inner = 1.0, outer = 0.5 are no radii"),
        (lambda: disk(0.0, 0.1), r"radius = 0.0 is not positive"),
        (lambda: disk(1.0, 0.1, center=(0, 0, 0)), r"center = .* has 3 components; give 2"),
        (lambda: cylinder(1.0, -1.0, 0.1), r"height = -1.0 is not positive"),
        (lambda: tube(0.1, 1.0, 1.0, 0.1, center=(0, 0)), r"center = .* has 2 components; give 3"),
        (
            lambda: ring(0.5, 1.0, 0.1, around=2),
            r"around = 2 are no numbers of cells in 5 rings; give one whole number",
        ),
        (lambda: ring(0.5, 1.0, 0.1, around=[4, 4]), r"around = \[4, 4\] are no numbers of cells in 5 rings"),
        (lambda: ring(0.5, 1.0, 0.1, around=4.5), r"around = 4.5 are no numbers"),
        (
            lambda: ring(0.9, 1.0, 0.1, around=3),
            r"around = 3 is too few for the ring from 0.9 to 1: cells would have their centers of mass outside of it",
        ),
        (lambda: polar([0.0, 1.0, 0.5]), r"edges\[2\] = 0.5 is not above edges\[1\] = 1.0"),
        (lambda: polar(np.linspace(1.0, 1.0 + 1e-6, 3), 2**31), r"radii would make 4.29e\+09 points"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
