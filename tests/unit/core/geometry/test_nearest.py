"""Nearest points by searching, against those of formulas."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.geometry import Ball, Box, HalfSpace
from rbs_core.geometry.nearest import nearest_among, searched, shared, surroundings


def ellipse(points: np.ndarray) -> np.ndarray:
    """A bound of the distance from an ellipse with the half axes 2 and 1."""
    return np.linalg.norm(points / [2.0, 1.0], axis=1) - 1.0


def test_nearest_points_of_an_ellipse(rng):
    points = rng.uniform(-3.0, 3.0, (40, 2))
    angle = np.linspace(0.0, 2.0 * np.pi, 200001)
    curve = np.stack([2.0 * np.cos(angle), np.sin(angle)], axis=1)
    nearest = nearest_among(points, curve)
    found = searched([ellipse], points, points, 4.0)
    assert ellipse(found) == pytest.approx(0.0, abs=1e-12)
    outside = ellipse(points) > 0.0  # inside there are several that are nearest among their neighbors
    ways, shortest = (np.linalg.norm(points - each, axis=1)[outside] for each in (found, nearest))
    assert ways == pytest.approx(shortest, abs=1e-8)


def test_nearest_points_of_an_edge():
    ball, plane = Ball(1.0, (0.0, 0.0, 0.0)), HalfSpace((0.0, 0.0, 0.6), (0.0, 0.0, 1.0))
    point = np.array([[3.0, 4.0, 5.0]])
    found = searched([ball._distance, plane._distance], point, point, 1.0)
    assert found == pytest.approx(np.array([[0.48, 0.64, 0.6]]), abs=1e-7)


def test_turns_between_convex_regions_lead_to_the_nearest_point_that_they_share():
    a, b = Box.between((0.0, 0.0), (2.0, 2.0)), HalfSpace((1.0, 0.0), (-1.0, -1.0))
    point = np.array([[3.0, 1.0]])
    assert shared(a, b, point, convex=True) == pytest.approx(np.array([[1.0, 0.0]]), abs=1e-9)
    anywhere = shared(a, b, point, convex=False)
    assert a.distance(anywhere)[0] <= 1e-9
    assert b.distance(anywhere)[0] <= 1e-9
    assert shared(a, b, np.array([[0.25, 0.25]]), convex=True).tolist() == [[0.25, 0.25]]


def test_surroundings_fill_finite_bounds_and_what_is_near_in_infinite_ones():
    points = np.array([[0.0, 5.0]])
    lattice = surroundings(points, (np.array([-1.0, -np.inf]), np.array([1.0, 6.0])), 2.0)
    assert lattice.min(axis=0).tolist() == [-1.0, 3.0]
    assert lattice.max(axis=0).tolist() == [1.0, 6.0]


def test_no_points_no_search():
    assert searched([ellipse], np.zeros((0, 2)), np.zeros((0, 2)), 1.0).shape == (0, 2)
