"""Rings of cells around a point of a plane: rings and disks, and in layers tubes and cylinders."""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput
from rbs_core.space.checks import FloatArray, as_number, as_text
from rbs_core.space.grids.axis import Axis, edges
from rbs_core.space.grids.cells import Cells, Cloud, require_few, typical
from rbs_core.space.grids.circles import as_center, as_radii, center_text, circle, fours, layers


def polar(radii: ArrayLike, around: ArrayLike | None = None, *, center: ArrayLike = (0.0, 0.0)) -> Cells:
    """Rings between given radii, each cut into equal sectors; points lie in the centers of mass of their cells.

    Sums over the points of volume times a linear function are therefore exact integrals. Cells begin at the angle 0:
    with a multiple of four around, as is the rule, the points are symmetric to both axes and both diagonals to the last
    bit (around the center 0), and `where` can take quarters that are exact.

    Args:
        radii: edges of the rings (m), rising from 0 or more, shape (k + 1,).
        around: number of cells in each ring, one number from 3 or shape (k,); the multiple of four that makes cells
            nearest to squares if not given.
        center: of the rings (m), shape (2,).

    Raises:
        BadInput: for radii that are negative or do not rise, and for too few cells around.
    """
    rings, middle = as_radii(radii), as_center(center, 2)
    return _laid(rings, around, middle, f"polar({rings!r}{_options(around, middle)})")


def ring(
    inner: float, outer: float, spacing: float, *, around: ArrayLike | None = None, center: ArrayLike = (0.0, 0.0)
) -> Cells:
    """A plane ring of cells that are about square and fill it exactly, as `polar` lays them.

    Args:
        inner: inner radius (m), 0 for a disk.
        outer: outer radius (m).
        spacing: width of the rings of cells (m), about: a whole number of them fills the ring.
        around: number of cells in each ring, from 3; about square cells if not given.
        center: (m), shape (2,).

    Raises:
        BadInput: for an outer radius that is not above the inner one, a negative inner one, and as `polar`.
    """
    rings, middle = layers(inner, outer, spacing, dimension=2), as_center(center, 2)
    text = f"ring({float(inner)}, {float(outer)}, {float(spacing)}{_options(around, middle)})"
    return _laid(rings, around, middle, text)


def disk(radius: float, spacing: float, *, around: ArrayLike | None = None, center: ArrayLike = (0.0, 0.0)) -> Cells:
    """A disk of cells that are about square and fill it exactly; the innermost are four quarters.

    Args:
        radius: (m).
        spacing: width of the rings of cells (m), about.
        around: number of cells in each ring, from 3; about square cells if not given.
        center: (m), shape (2,).

    Raises:
        BadInput: for a radius that is not positive, and as `polar`.
    """
    return ring(0.0, as_number(radius, "radius", positive=True), spacing, around=around, center=center)


def tube(
    inner: float,
    outer: float,
    height: float,
    spacing: float,
    *,
    around: ArrayLike | None = None,
    center: ArrayLike = (0.0, 0.0, 0.0),
) -> Cells:
    """A tube along z of cells that are about cubes and fill it exactly: layers of `ring`.

    Other layers are made by `ring(...).extruded(edges)`, other directions by `placed`.

    Args:
        inner: inner radius (m), 0 for a cylinder.
        outer: outer radius (m).
        height: (m).
        spacing: edge of the cells (m), about.
        around: number of cells in each ring, from 3; about cubes if not given.
        center: (m), shape (3,).

    Raises:
        BadInput: as `ring`, and for a height that is not positive.
    """
    middle, half = as_center(center, 3), as_number(height, "height", positive=True) / 2
    base = ring(inner, outer, spacing, around=around, center=middle[:2])
    return base.extruded(middle[2] + edges(-half, half, spacing))


def cylinder(
    radius: float,
    height: float,
    spacing: float,
    *,
    around: ArrayLike | None = None,
    center: ArrayLike = (0.0, 0.0, 0.0),
) -> Cells:
    """A solid cylinder along z of cells that are about cubes and fill it exactly: layers of `disk`.

    Args:
        radius: (m).
        height: (m).
        spacing: edge of the cells (m), about.
        around: number of cells in each ring, from 3; about cubes if not given.
        center: (m), shape (3,).

    Raises:
        BadInput: for a radius or height that is not positive, and as `ring`.
    """
    solid = as_number(radius, "radius", positive=True)
    return tube(0.0, solid, height, spacing, around=around, center=center)


def _laid(rings: Axis, around: ArrayLike | None, middle: FloatArray, text: str) -> Cells:
    """The cells of rings, in the order of the rings and of the angles."""
    counts = fours(2 * pi * rings.coordinates / rings.sizes) if around is None else _counts(around, rings)
    require_few(float(counts.sum()), "radii")
    inner, outer = rings.edges[:-1], rings.edges[1:]
    half = pi / counts
    areas = half * (outer - inner) * (outer + inner)
    masses = 2 / 3 * (inner**2 + inner * outer + outer**2) / (inner + outer) * np.sin(half) / half
    hollow = np.flatnonzero(masses <= inner)
    if hollow.size:
        raise BadInput(
            f"around = {counts[hollow[0]]} is too few for the ring from {inner[hollow[0]]:.6g} to "
            f"{outer[hollow[0]]:.6g}: cells would have their centers of mass outside of it; give more"
        )
    points = np.vstack([mass * circle(int(count)) for mass, count in zip(masses, counts, strict=True)]) + middle
    return Cloud(points, np.repeat(areas, counts), typical(rings.sizes.tolist()), text)


def _counts(around: ArrayLike, rings: Axis) -> NDArray[np.int64]:
    given = np.asarray(around)
    if given.dtype.kind not in "iu" or given.shape not in ((), (len(rings),)) or (given < 3).any():
        raise BadInput(
            f"around = {around!r} are no numbers of cells in {len(rings)} rings; give one whole number from 3, or one "
            "per ring"
        )
    return np.broadcast_to(given, len(rings)).astype(np.int64)


def _options(around: ArrayLike | None, middle: FloatArray) -> str:
    """The arguments that were given by name, as they could be typed."""
    return ("" if around is None else f", around={as_text(np.asarray(around))}") + center_text(middle)
