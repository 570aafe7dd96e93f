"""Nearest points of what no formula describes: searched with nothing but distances and projections of its parts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from rbs_core.geometry.base import Geometry
from rbs_core.geometry.frames import lengths
from rbs_core.space.checks import Bounds, FloatArray

Distance: TypeAlias = Callable[[FloatArray], FloatArray]

# Parts of the size of a geometry: how near to the surface is on it, the step of a difference quotient, and the way
# along the surface that is still worth going.
REACHED, STEP, WORTH = 1e-13, 1e-6, 1e-8

# Most steps of a search, and most turns between two regions.
STEPS, TURNS = 60, 100

# Coordinates along each axis of a lattice in 1-D, 2-D, 3-D: odd, so that middles are among them.
SAMPLES = (101, 51, 15)

# Shortest and longest step, as parts of the way to the foot of the perpendicular on the tangent.
LENGTHS = (1e-3, 10.0)

# Slopes below this are none; slopes whose directions differ by less count as one.
FLAT = 1e-3


def searched(distances: Sequence[Distance], points: FloatArray, start: FloatArray, size: float) -> FloatArray:
    """Points where all of some distances are 0, near given points: to the surface, then downhill along it.

    Args:
        distances: signed distances of points (n, d), or bounds of them: of one surface, or of two that meet in an edge.
        points: to which the way shall be short, shape (n, d).
        start: where to begin, shape (n, d).
        size: typical length of the geometry (m), 0 where there is none.

    Returns:
        Points, shape (n, d); each is nearest among its neighbors if the surfaces are smooth there.
    """
    if not len(points):
        return points.copy()
    scale = size or float(np.abs(points).max()) or 1.0
    found = _settled(distances, start, scale)
    step, away = np.ones(len(points)), lengths(points - found)
    before, last = found.copy(), np.zeros_like(found)
    for _ in range(STEPS):
        slopes = _slopes(distances, found, scale)
        to_point = points - found
        sideways = to_point - _product(_inverse(slopes), _product(slopes, to_point))
        # What the last step has changed tells the curvature, and with it how long the next one should be (Barzilai and
        # Borwein 1988).
        moved = found - before
        bend = np.einsum("ni,ni->n", moved, last - sideways)
        told = bend > 0.0
        step[told] = np.clip(np.einsum("ni,ni->n", moved, moved)[told] / bend[told], *LENGTHS)
        before, last = found.copy(), sideways
        active = np.flatnonzero(step * lengths(sideways) > WORTH * scale)
        if not active.size:
            break
        tried = _settled(distances, found[active] + step[active, None] * sideways[active], scale)
        reached = lengths(points[active] - tried)
        better = reached < away[active]
        found[active[better]], away[active[better]] = tried[better], reached[better]
        step[active] = np.where(better, np.minimum(1.5 * step[active], 1.0), 0.4 * step[active])
    return found


def shared(first: Geometry, second: Geometry, points: FloatArray, convex: bool) -> FloatArray:
    """Points of the second of two geometries and, if the turns between them end, of the first as well.

    Args:
        first: any geometry with a projection.
        second: another one.
        points: where to begin, shape (n, d).
        convex: whether to give back what each has taken away before it is asked again (Dykstra's algorithm): the turns
            then lead to the nearest of the points that two convex geometries share. Otherwise they lead to any.

    Returns:
        Points, shape (n, d).
    """
    found, owed = points.copy(), [np.zeros_like(points), np.zeros_like(points)]
    for _ in range(TURNS):
        before = found
        for part, geometry in enumerate((first, second)):
            wanted = found + owed[part]
            found = wanted.copy()
            outside = np.flatnonzero(~geometry._contains(wanted))
            found[outside] = geometry._projection(wanted[outside])
            if convex:
                owed[part] = wanted - found
        if np.array_equal(before, found):
            break
    return found


def surroundings(points: FloatArray, bounds: Bounds, size: float) -> FloatArray:
    """A lattice over bounds (where these are infinite, over the points and somewhat more), some thousand points."""
    dimension = points.shape[1]
    lower, upper = (np.broadcast_to(side, dimension) for side in bounds)
    lower = np.where(np.isfinite(lower), lower, points.min(axis=0) - size)
    upper = np.where(np.isfinite(upper), upper, points.max(axis=0) + size)
    axes = [np.linspace(lower[axis], upper[axis], SAMPLES[dimension - 1]) for axis in range(dimension)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, dimension)


def nearest_among(points: FloatArray, some: FloatArray) -> FloatArray:
    """For each point (n, d) the nearest of some others (k, d), k > 0."""
    from scipy.spatial import cKDTree  # late: few geometries need it

    return np.asarray(some[cKDTree(some).query(points)[1]])


def _settled(distances: Sequence[Distance], points: FloatArray, scale: float) -> FloatArray:
    """Points moved to the surface along the slopes of the distances, as in Newton's method."""
    result = points.copy()
    active = np.arange(len(points))
    for _ in range(STEPS):
        heights = np.stack([distance(result[active]) for distance in distances], axis=1)
        off = np.abs(heights).max(axis=1) > REACHED * scale
        active, heights = active[off], heights[off]
        if not active.size:
            break
        result[active] -= _product(_inverse(_slopes(distances, result[active], scale)), heights)
    return result


def _slopes(distances: Sequence[Distance], points: FloatArray, scale: float) -> FloatArray:
    """Difference quotients (n, m, d) of the distances; in the middle between parts of a surface some direction."""
    slopes = np.empty((len(points), len(distances), points.shape[1]))
    step = STEP * scale
    for axis in range(points.shape[1]):
        ahead, behind = points.copy(), points.copy()
        ahead[:, axis] += step
        behind[:, axis] -= step
        for part, distance in enumerate(distances):
            slopes[:, part, axis] = (distance(ahead) - distance(behind)) / (2.0 * step)
    slopes[(slopes**2).sum(axis=2) < FLAT**2, 0] = 1.0
    return slopes


def _inverse(slopes: FloatArray) -> FloatArray:
    """What leads from heights (n, m) to the shortest steps that make up for them, shape (n, d, m)."""
    return np.asarray(np.linalg.pinv(slopes, rcond=FLAT))


def _product(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """Matrices (n, i, j) times vectors (n, j), row by row."""
    return np.asarray(np.einsum("nij,nj->ni", matrices, vectors))
