"""Shells of cells around a point in space, each cut into bands and these into sectors of the same volume."""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.space.checks import FloatArray, as_number
from rbs_core.space.grids.axis import Axis
from rbs_core.space.grids.cells import Cells, Cloud, require_few, typical
from rbs_core.space.grids.circles import as_center, as_radii, center_text, circle, fours, layers


def spherical(radii: ArrayLike, *, center: ArrayLike = (0.0, 0.0, 0.0)) -> Cells:
    """Shells between given radii, each cut into cells of the same volume that are about cubes.

    A shell is cut by an even number of circles around z into bands, a band into a multiple of four sectors, with the
    circles where all cells of the shell span the same solid angle. Points lie in the centers of mass of their cells, so
    that sums over them of volume times a linear function are exact integrals. They are symmetric to the three planes of
    the axes to the last bit (around the center 0), and `where` can take octants that are exact.

    Args:
        radii: edges of the shells (m), rising from 0 or more, shape (k + 1,).
        center: (m), shape (3,).

    Raises:
        BadInput: for radii that are negative or do not rise.
    """
    shells, middle = as_radii(radii), as_center(center, 3)
    return _laid(shells, middle, f"spherical({shells!r}{center_text(middle)})")


def shell(inner: float, outer: float, spacing: float, *, center: ArrayLike = (0.0, 0.0, 0.0)) -> Cells:
    """A hollow ball of cells that are about cubes and fill it exactly, as `spherical` lays them.

    Args:
        inner: inner radius (m), 0 for a ball.
        outer: outer radius (m).
        spacing: thickness of the shells of cells (m), about: a whole number of them fills the hollow ball.
        center: (m), shape (3,).

    Raises:
        BadInput: for an outer radius that is not above the inner one, and a negative inner one.
    """
    shells, middle = layers(inner, outer, spacing, dimension=3), as_center(center, 3)
    return _laid(shells, middle, f"shell({float(inner)}, {float(outer)}, {float(spacing)}{center_text(middle)})")


def ball(radius: float, spacing: float, *, center: ArrayLike = (0.0, 0.0, 0.0)) -> Cells:
    """A ball of cells that are about cubes and fill it exactly; the innermost are eight octants.

    Args:
        radius: (m).
        spacing: thickness of the shells of cells (m), about.
        center: (m), shape (3,).

    Raises:
        BadInput: for a radius that is not positive.
    """
    return shell(0.0, as_number(radius, "radius", positive=True), spacing, center=center)


def _laid(shells: Axis, middle: FloatArray, text: str) -> Cells:
    """The cells of shells, in the order of the shells, of the bands from north to south, and of the angles."""
    inner, outer = shells.edges[:-1], shells.edges[1:]
    wanted = pi * shells.coordinates / shells.sizes  # cells from pole to pole
    require_few(float((4 / pi * wanted**2).sum()), "radii")
    directions = [_sphere(2 * max(1, round(bands / 2))) for bands in wanted.tolist()]
    counts = np.array([len(vectors) for vectors in directions])
    volumes = (outer - inner) * (outer**2 + outer * inner + inner**2) / 3
    masses = (outer - inner) * (outer + inner) * (outer**2 + inner**2) / 4 / volumes
    points = np.vstack([mass * vectors for mass, vectors in zip(masses, directions, strict=True)]) + middle
    return Cloud(points, np.repeat(4 * pi * volumes / counts, counts), typical(shells.sizes.tolist()), text)


def _sphere(bands: int) -> FloatArray:
    """Means of the unit vectors over cells of the same solid angle, shape (n, 3); `bands` is even."""
    polar = (np.arange(bands // 2) + 0.5) * (pi / bands)
    counts = fours(2 * bands * np.sin(polar))  # per band, from the north pole to the equator
    before = np.concatenate([[0], np.cumsum(counts)])
    heights = 1.0 - before / before[-1]  # cosines of the angles of the circles: equal areas are equal differences
    levels = np.sqrt(before / before[-1] * (1.0 + heights))  # their sines
    angles = np.arctan2(levels, heights)
    # Integrals over a band, divided by its area: of z, and of the distance from the z axis.
    upright = (heights[:-1] + heights[1:]) / 2
    squares = (np.diff(angles) - np.diff(levels * heights)) / 2
    level = squares / -np.diff(heights) * np.sinc(1.0 / counts)
    north = [
        np.column_stack([outward * circle(int(count)), np.full(count, height)])
        for count, outward, height in zip(counts, level, upright, strict=True)
    ]
    south = [band * [1.0, 1.0, -1.0] for band in reversed(north)]
    return np.vstack([*north, *south])
