"""What rings and shells have in common: sectors of a circle, layers between radii, and a center."""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput
from rbs_core.space.checks import FloatArray, as_number, as_text, as_vector
from rbs_core.space.grids.axis import Axis, edges
from rbs_core.space.grids.cells import require_few


def circle(count: int) -> FloatArray:
    """Unit vectors to the middles of equal sectors that begin at the angle 0.

    They are as symmetric as their number allows, to the last bit: all are mirror images of those in an eighth.

    Args:
        count: number of sectors.

    Returns:
        Shape (count, 2).
    """
    steps = 2 * np.arange(count) + 1  # angles in units of pi/count: mirrored without round-off
    upper = np.minimum(steps, 2 * count - steps)
    right = np.minimum(upper, count - upper)
    steep = 4 * right > count
    angles = np.where(steep, count - 2 * right, 2 * right) * (pi / (2 * count))
    cosine, sine = np.cos(angles), np.sin(angles)
    sine = np.where(4 * right == count, cosine, sine)  # on the diagonal they are equal
    x, y = np.where(steep, sine, cosine), np.where(steep, cosine, sine)
    return np.column_stack([np.where(2 * upper > count, -x, x), np.where(steps > count, -y, y)])


def fours(wanted: FloatArray) -> NDArray[np.int64]:
    """The multiples of four that are nearest, from four."""
    return (4 * np.maximum(np.rint(wanted / 4), 1.0)).astype(np.int64)


def layers(inner: float, outer: float, spacing: float, *, dimension: int) -> Axis:
    """Equal layers between two radii, checked.

    Args:
        inner: smallest radius (m).
        outer: largest radius (m).
        spacing: thickness of the layers (m), about.
        dimension: 2 for rings, 3 for shells.

    Raises:
        BadInput: for radii that are negative or not above each other, and for more cells than can be numbered.
    """
    least, most = as_number(inner, "inner"), as_number(outer, "outer")
    thickness = as_number(spacing, "spacing", positive=True)
    if least < 0.0 or most <= least:
        raise BadInput(f"inner = {least}, outer = {most} are no radii; give 0 <= inner < outer")
    measure = (dimension - 1) * 2 * pi / dimension * (most**dimension - least**dimension)
    require_few(measure / thickness / thickness ** (dimension - 1), f"spacing = {thickness}")
    return Axis(edges(least, most, thickness))


def as_center(center: ArrayLike, dimension: int) -> FloatArray:
    """A center from outside, refused unless it has the dimension."""
    middle = as_vector(center, "center")
    if middle.size != dimension:
        raise BadInput(f"center = {as_text(middle)} has {middle.size} components; give {dimension}")
    return middle


def as_radii(radii: ArrayLike) -> Axis:
    """Edges of rings or shells from outside, refused if they are negative or do not rise."""
    axis = Axis(radii)
    if axis.edges[0] < 0.0:
        raise BadInput(f"radii[0] = {axis.edges[0]} is negative; give radii from 0")
    return axis


def center_text(center: FloatArray) -> str:
    """A center as a further argument, nothing where it is the origin."""
    return f", center={as_text(center)}" if center.any() else ""
