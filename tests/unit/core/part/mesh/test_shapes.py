"""Measures and centroids of cells, against numbers by hand, quadrature, and each other."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.part.mesh.shapes import KINDS, kind_of, measured
from tests.unit.core.part.mesh.blocks import CELLS, SECOND

SOLIDS = ["tetra", "pyramid", "wedge", "hexahedron"]


@pytest.fixture
def random():
    return np.random.default_rng(7)


def alone(points, kind):
    """Measure, centroid and flatness of one cell."""
    points = np.asarray(points, float)
    size, centroid, flat = measured(points, np.arange(len(points))[None], kind)
    return size[0], centroid[0], flat[0]


@pytest.mark.parametrize("name", CELLS)
def test_measures_and_centroids_are_those_computed_by_hand(name):
    points, size, centroid = CELLS[name]
    found = alone(points, KINDS[name])
    assert found[0] == pytest.approx(size, rel=1e-14)
    assert found[1] == pytest.approx(centroid, rel=1e-14)
    assert not found[2]


@pytest.mark.parametrize("name", CELLS)
def test_they_move_with_the_cell(name, random):
    """Under an affine map the measure grows by its determinant, and the centroid moves along."""
    points, size, centroid = CELLS[name]
    d = len(centroid)
    turn = np.eye(d) + 0.3 * random.standard_normal((d, d))
    shift = random.standard_normal(d)
    found = alone(np.array(points) @ turn.T + shift, KINDS[name])
    grown = np.linalg.det(turn) * size
    assert found[0] == pytest.approx(abs(grown) if d == 1 else grown, rel=1e-12)
    assert found[1] == pytest.approx(turn @ np.array(centroid, float) + shift, rel=1e-12)


@pytest.mark.parametrize("name", [name for name in CELLS if name != "line"])
def test_a_mirrored_cell_is_negative_at_the_same_place(name):
    points, size, centroid = CELLS[name]
    flip = np.ones(len(centroid))
    flip[0] = -1.0
    found = alone(points * flip, KINDS[name])
    assert found[0] == pytest.approx(-size, rel=1e-14)
    assert found[1] == pytest.approx(flip * centroid, rel=1e-14)


def test_warped_hexahedra_have_the_volume_of_the_trilinear_map(random):
    """By Gauss quadrature of the Jacobian determinant, whose degree is 2 in each direction."""
    cube = np.array(CELLS["hexahedron"][0]) / [2, 1, 3]
    points = cube + random.uniform(-0.2, 0.2, (8, 3))
    at, weights = np.polynomial.legendre.leggauss(2)
    at, weights = (at + 1) / 2, weights / 2
    total = 0.0
    for place in np.stack(np.meshgrid(at, at, at), axis=-1).reshape(-1, 3):
        factors = np.where(cube, place, 1 - place)
        slopes = np.where(cube, 1.0, -1.0)
        jacobian = [(points * (np.prod(np.delete(factors, k, 1), 1) * slopes[:, k])[:, None]).sum(0) for k in range(3)]
        total += np.linalg.det(jacobian) * weights[0] ** 3
    assert alone(points, KINDS["hexahedron"])[0] == pytest.approx(total, rel=1e-13)


def test_warped_cells_fill_a_cube_without_gaps(random):
    """A point inside is moved: eight hexahedra still share all of the volume and of its first moment."""
    side = np.arange(3.0)
    points = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1).reshape(-1, 3)
    points[13] += [0.3, -0.2, 0.25]
    cube = np.array(CELLS["hexahedron"][0]) / [2, 1, 3]
    corners = [[(np.array(c) + o) @ [9, 3, 1] for c in cube] for o in np.ndindex(2, 2, 2)]
    sizes, centroids, flat = measured(points, np.array(corners, int), KINDS["hexahedron"])
    assert sizes.sum() == pytest.approx(8.0, rel=1e-14)
    assert sizes @ centroids == pytest.approx([8.0] * 3, rel=1e-14)
    assert not flat.any()
    assert np.ptp(sizes) > 0.1


@pytest.mark.parametrize("name", SOLIDS)
def test_sides_close_the_cell(name):
    """Every edge is passed once in either direction."""
    edges = [pair for side in KINDS[name].sides for pair in zip(side, [*side[1:], side[0]], strict=True)]
    assert sorted(edges) == sorted((b, a) for a, b in edges)
    assert len(set(edges)) == len(edges)


def test_a_collapsed_hexahedron_is_a_wedge():
    one, two, three, four, five, six = CELLS["wedge"][0]
    found = alone([one, two, three, three, four, five, six, six], KINDS["hexahedron"])
    assert found[0] == pytest.approx(9.0, rel=1e-14)
    assert found[1] == pytest.approx([1, 1, 1], rel=1e-14)


@pytest.mark.parametrize("shift", [0.0, 1e6])
@pytest.mark.parametrize("name", CELLS)
def test_flat_cells_are_told_from_thin_ones(name, shift):
    points = np.array(CELLS[name][0], float)
    thin, flat = points.copy(), points.copy()
    thin[:, 0] *= 1e-8 if shift == 0.0 else 1e-2
    flat[:, 0] = 0.0
    assert not alone(thin + shift, KINDS[name])[2]
    assert alone(flat + shift, KINDS[name])[2]


def test_a_bow_tie_is_flat():
    assert alone([[0, 0], [1, 1], [1, 0], [0, 1]], KINDS["quad"])[2]


@pytest.mark.parametrize("name", CELLS)
def test_cells_of_second_order_count_as_their_corners(name):
    for second in SECOND[name]:
        assert kind_of(second, int("".join(filter(str.isdigit, second)))) is KINDS[name]
    assert kind_of(name, KINDS[name].corners) is KINDS[name]


def test_other_names():
    polygon = kind_of("polygon", 5)
    angles = 2 * np.pi * np.arange(5) / 5
    size, centroid, _ = alone(np.stack([2 + np.cos(angles), np.sin(angles)], axis=1), polygon)
    assert size == pytest.approx(2.5 * np.sin(2 * np.pi / 5), rel=1e-14)
    assert centroid == pytest.approx([2.0, 0.0], abs=1e-14)
    assert kind_of("VTK_LAGRANGE_HEXAHEDRON", 27) is KINDS["hexahedron"]
    assert kind_of("vertex", 1) is KINDS["vertex"]
    assert kind_of("polyhedron20", 20) is None
    assert kind_of("tetra", 3) is None


def test_many_cells_are_taken_in_several_goes(monkeypatch, random):
    points = random.uniform(size=(40, 2))
    corners = random.permuted(np.tile(np.arange(40), (10, 1)), axis=1)[:, :3]
    whole = measured(points, corners, KINDS["triangle"])
    monkeypatch.setattr("rbs_core.part.mesh.shapes._AT_ONCE", 3)
    for one, two in zip(whole, measured(points, corners, KINDS["triangle"]), strict=True):
        assert np.array_equal(one, two)
