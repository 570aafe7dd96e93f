"""Families: the lattice path, the cell list and a search by scipy find the same neighbors, ties included."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

import rbs_core as rbs
from rbs_core import Part
from rbs_core.part import search


def brute(points: np.ndarray, horizon: float, slack: float = 1e-9) -> tuple[np.ndarray, np.ndarray]:
    """Offsets and neighbors from scipy; nodes on the horizon up to one part in 1e9 belong to the family."""
    found = cKDTree(points).query_ball_point(points, horizon * (1 + slack))
    rows = [sorted(set(row) - {node}) for node, row in enumerate(found)]
    return np.cumsum([0, *map(len, rows)]), np.array([j for row in rows for j in row], dtype=np.uint32)


def same(rows, points: np.ndarray, horizon: float) -> None:
    """Asserts that rows hold the families of scipy, in ascending order, with their lengths."""
    offsets, neighbors, inverse = rows
    expected_offsets, expected = brute(points, horizon)
    assert np.array_equal(offsets, expected_offsets)
    assert np.array_equal(neighbors, expected)
    nodes = np.repeat(np.arange(len(points)), np.diff(offsets))
    lengths = np.linalg.norm(points[neighbors] - points[nodes], axis=1)
    # a length comes from coordinates of size 1 and is at least a hundredth: 1e-16 / 1e-2, and a square root
    np.testing.assert_allclose(1.0 / inverse, lengths, rtol=1e-12)


SHAPES = {
    "1-D": rbs.Box(size=1.0),
    "2-D": rbs.Box(size=(1.0, 0.6)),
    "2-D with a hole": rbs.Box(size=(1.0, 1.0)) - rbs.Ball(radius=0.25, center=(0.1, 0.0)),
    "3-D": rbs.Box(size=(0.5, 0.4, 0.3)),
    "3-D with a hole": rbs.Box(size=(0.5, 0.5, 0.5)) - rbs.Ball(radius=0.15, center=(0.05, 0.0, 0.0)),
    "3-D ball": rbs.Ball(radius=0.3, center=(0.0, 0.0, 0.0)),
}


@pytest.mark.parametrize("ratio", [1.0, 1.5, 2.0, 3.0, 3.015])
@pytest.mark.parametrize("shape", SHAPES)
def test_lattice_cloud_and_scipy_agree(shape, ratio):
    """At ratios of exactly 1, 2 and 3 whole shells lie on the horizon: they belong to the family on every path."""
    spacing = 0.05
    part = Part("grid", SHAPES[shape]).discretize(spacing).connect(ratio * spacing)
    rows = (*part.bonds.as_rows(), part.bonds.inverse_lengths)
    same(rows, part.positions, ratio * spacing)
    cloud = search.cloud_rows(part.positions, ratio * spacing)
    assert all(np.array_equal(x, y) for x, y in zip(rows[:2], cloud[:2], strict=True))
    np.testing.assert_allclose(rows[2], cloud[2], rtol=1e-12)


@pytest.mark.parametrize(
    ("dimension", "ratio", "count"),
    [(1, 3.0, 6), (2, 1.0, 4), (2, 3.0, 28), (2, 3.015, 28), (3, 1.0, 6), (3, 2.0, 32), (3, 3.0, 122), (3, 3.015, 122)],
)
@pytest.mark.parametrize("spacing", [0.1, 1e-4, 1 / 3, 7e3])
def test_the_family_of_an_inner_node_has_its_known_size(dimension, ratio, count, spacing):
    """Lattice points in an interval, a disc and a ball of that radius, without the middle; at any spacing."""
    cells = 9
    box = rbs.Box(size=(cells * spacing,) * dimension, center=(0.3 * spacing,) * dimension)
    part = Part("grid", box).discretize(spacing).connect(ratio * spacing)
    middle = (cells**dimension - 1) // 2
    assert part.bonds.counts()[middle] == part.bonds.counts().max() == count


@pytest.mark.parametrize("shape", SHAPES)
def test_every_bond_is_there_from_both_ends(shape):
    part = Part("grid", SHAPES[shape]).discretize(0.05).connect(0.15)
    pairs = set(part.bonds)
    assert len(pairs) == len(part.bonds)
    assert all((j, i) in pairs for i, j in pairs)
    assert all(i != j for i, j in pairs)


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(1, 3), st.integers(1, 120), st.floats(0.01, 2.0), st.floats(-6, 6))
def test_random_clouds(seed, dimension, count, horizon, magnitude):
    """Of any density, flat or stretched; where the last bit decides, both answers are right: not looked at."""
    rng = np.random.default_rng(seed)
    points = rng.random((count, dimension)) ** rng.integers(1, 4)
    points[:, rng.integers(dimension)] *= rng.choice([1.0, 0.0, 30.0])
    scale = 10.0**magnitude
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    off = distances[~np.eye(count, dtype=bool)]
    if (off == 0).any() or (np.abs(off - horizon) < 1e-7 * horizon).any():
        return
    offsets, neighbors, _ = search.cloud_rows(points * scale, horizon * scale)
    expected_offsets, expected = brute(points, horizon)
    assert np.array_equal(offsets, expected_offsets)
    assert np.array_equal(neighbors, expected)


@pytest.mark.parametrize("count", [1, 2])
def test_the_smallest_clouds(count):
    offsets, neighbors, inverse = search.cloud_rows(np.arange(count, dtype=float)[:, None], 1.0)
    assert offsets.tolist() == [0, 0] if count == 1 else [0, 1, 2]
    assert neighbors.tolist() == [1, 0][: 2 * (count - 1)]
    assert inverse.tolist() == [1.0, 1.0][: 2 * (count - 1)]


def test_nodes_that_were_moved_off_their_grid_are_found_where_they_are(rng):
    part = Part("grid", rbs.Box(size=(1.0, 1.0))).discretize(0.1)
    part[rbs.reference_position][:] += 0.05 * rng.random((100, 2))
    part.connect(0.25)
    same((*part.bonds.as_rows(), part.bonds.inverse_lengths), part.positions, 0.25)


def test_a_cloud_far_from_the_origin_and_one_with_an_outlier():
    """Cells must not outgrow the points where one node lies a million horizons away."""
    rng = np.random.default_rng(5)
    points = rng.random((200, 2))
    points[0] = 1e6, -1e6
    same(search.cloud_rows(points, 0.1), points, 0.1)
    far = points[1:] + 1e5
    offsets, neighbors, _ = search.cloud_rows(far, 0.1)
    assert np.array_equal(neighbors, brute(far, 0.1)[1])
    assert offsets[-1] == len(neighbors)


def test_a_huge_horizon_makes_everybody_a_neighbor_of_everybody():
    """Metres typed for millimetres: no table of a billion offsets."""
    part = Part("block", rbs.Box(size=(1.0, 1.0, 1.0))).discretize(0.25).connect(1000.0)
    assert (part.bonds.counts() == 63).all()
    assert len(Part("bar", rbs.Box(size=1.0)).discretize(0.25).connect(1e12).bonds) == 12


def test_the_order_of_the_nodes_does_not_matter(rng):
    points = rng.random((150, 2))
    order = rng.permutation(150)
    place = np.argsort(order)  # where node i has gone
    straight, mixed = search.cloud_rows(points, 0.15), search.cloud_rows(points[order], 0.15)
    for node in range(150):
        family = straight[1][straight[0][node] : straight[0][node + 1]]
        row = slice(mixed[0][place[node]], mixed[0][place[node] + 1])
        assert set(order[mixed[1][row]]) == set(family)
        assert np.array_equal(mixed[1][row], np.sort(place[family]))
    assert math.fsum(straight[2]) == pytest.approx(math.fsum(mixed[2]), rel=1e-14)


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="needs two threads")
def test_two_threads_find_what_one_finds(rng):
    points = rng.random((400, 3))
    ball = Part("ball", SHAPES["3-D with a hole"]).discretize(0.04)

    def found(threads):
        before = numba.get_num_threads()
        numba.set_num_threads(threads)
        try:
            grid = search.lattice_rows(
                ball.positions, np.flatnonzero(ball.geometry.contains(ball.grid.points())), ball.grid.shape, 0.04, 0.12
            )
            return [array.tobytes() for array in (*search.cloud_rows(points, 0.2), *grid)]
        finally:
            numba.set_num_threads(before)

    assert found(1) == found(2)
