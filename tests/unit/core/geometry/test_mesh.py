"""Surfaces of triangles as solids and as cuts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rbs_core.errors import BadInput
from rbs_core.geometry import Ball, Box, SurfaceMesh, Tetrahedron, TriangulatedSurface
from tests.unit.core.geometry.examples import FACES, OCTAHEDRON, measured

CUBE = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CUBE_FACES = np.array([row for a, b, c, d in SIDES for row in ((a, b, c), (a, c, d))])


def sphere(rounds: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of a ball of radius 1, 8 * 4 ** rounds triangles."""
    vertices, triangles = list(OCTAHEDRON / 0.9), [tuple(row) for row in FACES]
    for _ in range(rounds):
        middles: dict[tuple[int, int], int] = {}

        def middle(a: int, b: int, middles=middles) -> int:
            key = (min(a, b), max(a, b))
            if key not in middles:
                place = vertices[a] + vertices[b]
                middles[key] = len(vertices)
                vertices.append(place / np.linalg.norm(place))
            return middles[key]

        finer = []
        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = finer
    return np.array(vertices), np.array(triangles)


def test_a_cube_of_triangles_is_a_box(rng):
    cube, box = SurfaceMesh(CUBE, CUBE_FACES), Box.between((0, 0, 0), (1, 1, 1))
    points = np.vstack([rng.uniform(-0.5, 1.5, (1000, 3)), np.round(rng.uniform(-0.5, 1.5, (1000, 3)) * 4) / 4])
    assert np.array_equal(cube.contains(points), box.contains(points))
    assert cube.distance(points) == pytest.approx(box.distance(points), abs=1e-14)
    assert np.array_equal(cube.status(points), box.status(points))
    assert np.array_equal(cube.bounds, box.bounds)
    assert cube.volume == pytest.approx(1.0)


def test_a_fine_surface_becomes_the_ball_that_it_stands_for(rng):
    points = rng.uniform(-1.2, 1.2, (500, 3))
    exact = Ball(1.0, (0, 0, 0))
    errors = []
    for rounds in (1, 2, 3):
        mesh = SurfaceMesh(*sphere(rounds))
        errors.append([np.abs(mesh.distance(points) - exact.distance(points)).max(), 4 / 3 * np.pi - mesh.volume])
    assert np.log2(np.divide(errors[0], errors[1])) == pytest.approx(2.0, abs=0.4)
    assert np.log2(np.divide(errors[1], errors[2])) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("spacing", [0.1, 0.05])
def test_counted_volume(spacing):
    mesh = SurfaceMesh(*sphere(2))
    assert measured(mesh, spacing) == pytest.approx(mesh.volume, rel=0.3 * spacing)


@settings(derandomize=True, deadline=None, database=None, max_examples=60)
@given(st.lists(st.tuples(*[st.integers(-4, 4)] * 3), min_size=4, max_size=4, unique=True))
def test_any_tetrahedron_agrees_with_its_surface(corners):
    corners = np.array(corners, dtype=float)
    height = np.linalg.det(corners[1:] - corners[0])
    if abs(height) < 0.5:
        return
    faces = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    mesh = SurfaceMesh(corners, faces if height > 0 else faces[:, ::-1])
    solid = Tetrahedron(*corners)
    points = np.random.default_rng(1).integers(-8, 9, (300, 3)) / 2.0
    assert np.array_equal(mesh.status(points), solid.status(points))
    assert np.array_equal(mesh.contains(points), solid.contains(points))
    assert mesh.volume == pytest.approx(abs(height) / 6.0)


def test_a_cavity_runs_the_other_way_around():
    vertices = np.vstack([CUBE, CUBE * 0.5 + 0.25])
    shell = SurfaceMesh(vertices, np.vstack([CUBE_FACES, CUBE_FACES[:, ::-1] + 8]))
    assert shell.volume == pytest.approx(0.875)
    assert shell.contains([[0.5, 0.5, 0.5], [0.1, 0.5, 0.5], [2.0, 0.5, 0.5]]).tolist() == [False, True, False]


def test_what_two_surfaces_enclose_counts_once():
    two = SurfaceMesh(np.vstack([CUBE, CUBE + 0.5]), np.vstack([CUBE_FACES, CUBE_FACES + 8]))
    points = [[0.25, 0.25, 0.25], [0.75, 0.75, 0.75], [1.25, 1.25, 1.25], [1.25, 0.25, 0.25]]
    assert two.contains(points).tolist() == [True, True, True, False]


def test_moved_meshes_stay_the_right_way_out():
    mesh = SurfaceMesh(OCTAHEDRON, FACES)
    for moved in (mesh.mirrored((0, 0, 0), (1, 0, 0)), mesh.rotated(0.4, (1, 1, 0)), mesh.moved((1, 0, 0))):
        assert isinstance(moved, SurfaceMesh)
        assert moved.volume == pytest.approx(mesh.volume)
    assert mesh.scaled(2.0).volume == pytest.approx(8.0 * mesh.volume)


def test_meshes_join_with_other_geometries():
    half = SurfaceMesh(CUBE, CUBE_FACES) - Box.between((0.5, -1, -1), (2, 2, 2))
    assert half.contains([[0.25, 0.5, 0.5], [0.75, 0.5, 0.5]]).tolist() == [True, False]
    assert measured(half, 0.05) == pytest.approx(0.5, rel=0.1)


def test_large_meshes_are_fast_and_shown_short():
    vertices, triangles = sphere(5)
    mesh = SurfaceMesh(vertices, triangles)
    assert len(mesh.triangles) == 8192
    assert repr(mesh).startswith("<SurfaceMesh of 8192 triangles, ")
    assert mesh == SurfaceMesh(vertices, triangles) != SurfaceMesh(2.0 * vertices, triangles)
    assert hash(mesh) == hash(SurfaceMesh(vertices, triangles))
    points = np.random.default_rng(2).uniform(-1.0, 1.0, (100_000, 3))  # takes part of a second
    inside, away = mesh.contains(points), np.linalg.norm(points, axis=1)
    assert inside[away < 0.998].all()
    assert not inside[away > 1.0].any()


def test_an_open_surface_cuts(rng):
    faces = [face for face in FACES if 4 in face]  # a roof
    roof = TriangulatedSurface(OCTAHEDRON, faces)
    starts, ends = (
        [[0.1, 0.2, 2.0], [0.1, 0.2, 0.1], [0.1, 0.2, 2.0]],
        [[0.1, 0.2, 0.0], [0.1, 0.2, -2.0], [2.0, 0.2, 2.0]],
    )
    assert roof.crosses(starts, ends).tolist() == [True, False, False]
    starts, ends = rng.uniform(-1.0, 1.0, (2, 2000, 3))
    assert np.array_equal(roof.crosses(starts, ends), roof.crosses(ends, starts))
    both = roof | TriangulatedSurface(OCTAHEDRON, [face for face in FACES if 5 in face])
    whole = TriangulatedSurface(OCTAHEDRON, FACES)
    assert np.array_equal(both.crosses(starts, ends), whole.crosses(starts, ends))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: SurfaceMesh(OCTAHEDRON, FACES[1:]), r"the surface is open: triangle \d has no neighbor at the edge"),
        (
            lambda: SurfaceMesh(OCTAHEDRON, np.array(FACES)[:, ::-1]),
            r"encloses -0.972 m\^3: it is inside out; give triangles\[:, ::-1\]",
        ),
        (
            lambda: SurfaceMesh(OCTAHEDRON[:3], [(0, 1, 2), (2, 1, 0)]),
            r"the surface encloses no volume \(0 m\^3\); give one that encloses a solid",
        ),
        (lambda: SurfaceMesh(CUBE, [*CUBE_FACES, (0, 0, 1)]), r"triangles\[12\] = \(0, 0, 1\) .* has no area"),
        (lambda: TriangulatedSurface(np.eye(2), [(0, 1, 1)]), r"vertices has shape \(2, 2\); give points in 3-D"),
        (lambda: SurfaceMesh.read("nowhere.stl"), r"there is no file nowhere.stl"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
