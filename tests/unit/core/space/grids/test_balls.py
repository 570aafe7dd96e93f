"""Shells and balls: exact volumes and centers of mass, symmetry, order of sums."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from rbs_core.errors import BadInput
from rbs_core.space.grids import ball, edges, shell, spherical

PI = np.pi
QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=60)


@QUIET
@given(st.floats(0.0, 3.0), st.floats(0.1, 3.0), st.floats(0.15, 2.0))
def test_cells_fill_the_shell_exactly(inner, width, share):
    inner = inner * width
    outer = inner + width
    grid = shell(inner, outer, share * width)
    measures, radii = grid.measures(), np.linalg.norm(grid.points(), axis=1)
    assert (measures > 0.0).all()
    assert measures.sum() == pytest.approx(4 / 3 * PI * (outer**3 - inner**3), rel=1e-13)
    assert (radii > inner).all()
    assert (radii < outer).all()


@QUIET
@given(st.floats(0.0, 3.0), st.floats(0.1, 3.0), st.floats(0.1, 1.0))
def test_linear_functions_are_integrated_exactly_over_octants(inner, width, share):
    """As points are centers of mass: over an octant the integrals of x, y and z are pi (R^4 - r^4)/16."""
    inner = inner * width
    outer = inner + width
    octant = shell(inner, outer, share * width).where(lambda points: (points > 0.0).all(axis=1))
    assert octant.measures().sum() == pytest.approx(PI / 6 * (outer**3 - inner**3), rel=1e-13)
    assert np.allclose(octant.measures() @ octant.points(), PI / 16 * (outer**4 - inner**4), rtol=1e-12)


def test_each_point_is_the_center_of_mass_of_its_cell():
    """Against sums over a fine mesh of the cells of one shell: those that a pole, and that the equator bounds."""
    inner, outer = 0.8, 1.0
    grid = shell(inner, outer, 0.2)
    heights = np.sort(np.unique(np.round(grid.points()[:, 2], 12)))[::-1]
    counts = np.array([np.count_nonzero(np.abs(grid.points()[:, 2] - height) < 1e-9) for height in heights])
    cosines = 1.0 - 2.0 * np.concatenate([[0], np.cumsum(counts)]) / counts.sum()
    start = 0
    for band, count in enumerate(counts):
        r = inner + (outer - inner) * (np.arange(60) + 0.5) / 60
        c = cosines[band] + (cosines[band + 1] - cosines[band]) * (np.arange(4000) + 0.5) / 4000
        phi = 2 * PI / count * (np.arange(60) + 0.5) / 60
        s = np.sqrt(1.0 - c**2)
        radius = (r**3).sum() / (r**2).sum()
        x, y = (np.mean(np.outer(s, wave(phi))) * radius for wave in (np.cos, np.sin))
        assert np.allclose(grid.points()[start], [x, y, c.mean() * radius], atol=2e-4)
        start += count


def test_all_cells_of_a_shell_have_the_same_volume_and_shells_have_about_the_same():
    grid = ball(1.0, 0.05)
    measures, radii = grid.measures(), np.linalg.norm(grid.points(), axis=1)
    assert len(np.unique(measures)) == 20
    assert (measures[radii > 0.1] > 0.8 * 0.05**3).all()
    assert (measures < 1.3 * 0.05**3).all()
    nearest = cKDTree(grid.points()).query(grid.points(), k=2)[0][:, 1]
    assert 0.6 * 0.05 < nearest.min() <= nearest.max() < 1.25 * 0.05
    assert grid.spacing == pytest.approx(0.05)


def test_points_are_symmetric_to_the_planes_of_the_axes_to_the_bit():
    points = ball(1.0, 0.1).points()
    rows = {tuple(row) for row in points.tolist()}
    assert len(rows) == len(points)
    for signs in ([-1, 1, 1], [1, -1, 1], [1, 1, -1]):
        assert {tuple(row) for row in (points * signs).tolist()} == rows
    assert {tuple(row) for row in points[:, [1, 0, 2]].tolist()} == rows


def test_sums_converge_to_integrals_with_second_order():
    """Over the ball the integral of exp(z) is 4 pi (cosh 1 - sinh 1)."""

    def error(layers):
        grid = ball(1.0, 1.0 / layers)
        return np.sum(grid.measures() * np.exp(grid.points()[:, 2])) - 4 * PI * (np.cosh(1.0) - np.sinh(1.0))

    assert 3.5 < error(8) / error(16) < 4.5


def test_graded_shells_elsewhere():
    center = np.array([1.0, -2.0, 3.0])
    grid = spherical(edges(0.2, 1.0, 0.05, growth=1.3), center=center)
    volume = 4 / 3 * PI * (1.0 - 0.008)
    assert grid.measures().sum() == pytest.approx(volume, rel=1e-13)
    assert np.allclose(grid.measures() @ grid.points() / volume, center, rtol=1e-13)
    assert grid.spacing is None


def test_the_smallest_ball_is_eight_octants():
    grid = ball(2.0, 9.0)
    assert len(grid) == 8
    assert np.allclose(np.abs(grid.points()), 2.0 * 3 / 8, rtol=1e-15)


def test_repr_can_be_typed_back():
    for grid in (ball(1.0, 0.5), shell(0.5, 1.0, 0.5, center=(0.0, 0.0, 2.0)), spherical([0.0, 0.5, 2.0])):
        again = eval(repr(grid))
        assert repr(again) == repr(grid)
        assert np.array_equal(again.points(), grid.points())


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: shell(1.0, 0.5, 0.1), r"inner = 1.0, outer = 0.5 are no radii"),
        (lambda: ball(-1.0, 0.1), r"radius = -1.0 is not positive"),
        (lambda: ball(1.0, 0.0), r"spacing = 0.0 is not positive"),
        (lambda: ball(1.0, 0.1, center=(0, 0)), r"center = .* has 2 components; give 3"),
        (lambda: spherical([-1.0, 1.0]), r"radii\[0\] = -1.0 is negative"),
        (lambda: spherical([1.0, 1.00001]), r"radii would make 1.26e\+11 points, more than"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
