"""Many triangles: nearest, around, through."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.geometry.facets import Facets, nearest_on
from tests.unit.core.geometry.examples import FACES, OCTAHEDRON

BODY = Facets(OCTAHEDRON, FACES)


def test_nearest_points_of_one_triangle():
    corners = np.broadcast_to([(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0)], (5, 3, 3))
    points = np.array([(0.5, 0.5, 3.0), (-1.0, -1.0, 1.0), (1.0, -2.0, 0.0), (2.0, 2.0, 5.0), (9.0, -1.0, 0.0)])
    expected = [(0.5, 0.5, 0.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (2.0, 0.0, 0.0)]
    assert nearest_on(points, corners) == pytest.approx(np.array(expected))


def test_needles_keep_their_digits():
    corners = np.array([[(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, 1e-7, 0.0)]])
    nearest = nearest_on(np.array([[0.5, 0.5e-7, 1.0]]), corners)
    assert nearest == pytest.approx(np.array([[0.5, 0.5e-7, 0.0]]), abs=1e-15)


def test_nearest_is_that_of_all_triangles(rng):
    points = rng.uniform(-1.5, 1.5, (300, 3))
    away, nearest = BODY.nearest(points)
    each = np.stack([nearest_on(points, np.broadcast_to(corners, (300, 3, 3))) for corners in BODY.corners])
    assert away == pytest.approx(np.linalg.norm(each - points, axis=2).min(axis=0), abs=1e-14)
    assert np.linalg.norm(points - nearest, axis=1) == pytest.approx(away)
    assert np.array_equal(BODY.within(points, np.full(300, 0.2)), away <= 0.2)


def test_winding_counts_rays_through_edges_and_corners_once(rng):
    points = np.round(rng.uniform(-1.0, 1.0, (20000, 3)) * 10.0) / 10.0  # many under edges and corners
    depth = np.abs(points).sum(axis=1) - 0.9
    clear = np.abs(depth) > 1e-9
    assert np.array_equal(BODY.winding(points)[clear], (depth < 0.0)[clear].astype(int))
    twice = Facets(np.vstack([OCTAHEDRON, 2.0 * OCTAHEDRON]), np.vstack([FACES, np.array(FACES) + 6]))
    assert twice.winding(np.array([[0.0, 0.0, 0.0], [0.9, 0.3, 0.0], [9.0, 0.0, 0.0]])).tolist() == [2, 1, 0]


def test_volume_far_from_the_origin():
    exact = 4.0 / 3.0 * 0.729
    assert BODY.volume == pytest.approx(exact)
    assert Facets(OCTAHEDRON + 1e6, FACES).volume == pytest.approx(exact, rel=1e-9)
    assert Facets(OCTAHEDRON, np.array(FACES)[:, ::-1]).volume == pytest.approx(-exact)


def test_bonds_that_pass_through(rng):
    starts, ends = rng.uniform(-1.0, 1.0, (2, 2000, 3))
    tolerance = np.full(2000, 1e-12)
    crossed = BODY.crossed(starts, ends, tolerance)
    assert np.array_equal(crossed, BODY.crossed(ends, starts, tolerance))
    start_in, end_in = (np.abs(side).sum(axis=1) < 0.9 for side in (starts, ends))
    assert crossed[start_in != end_in].all()
    assert not crossed[start_in & end_in].any()  # the body is convex
    share = np.linspace(0.0, 1.0, 300)[:, None, None]
    through = (np.abs(starts * (1.0 - share) + ends * share).sum(axis=2) < 0.9).any(axis=0)
    outside = ~start_in & ~end_in
    assert crossed[outside & through].all()
    assert (crossed & outside & ~through).sum() <= 4  # corners cut between two of the 300 places
