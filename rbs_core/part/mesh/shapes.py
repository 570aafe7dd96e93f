"""Kinds of cells, and what cells measure: lengths, areas and volumes that are exact, and centroids."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Corners = NDArray[np.int64]

_AT_ONCE = 1 << 18
_FLAT = 1e-12  # what a cell measures, as part of its extent to the power of its dimension, below which it has none


@dataclass(frozen=True)
class Kind:
    """A kind of cells with straight edges.

    Attributes:
        name: as meshio calls the one of first order.
        dimension: 0 to 3.
        corners: how many points of a cell are corners; they come first.
        sides: for each side, which corners it has; in 3-D in the order that is counterclockwise from outside.
    """

    name: str
    dimension: int
    corners: int
    sides: tuple[tuple[int, ...], ...]


KINDS = {
    kind.name: kind
    for kind in (
        Kind("vertex", 0, 1, ()),
        Kind("line", 1, 2, ((0,), (1,))),
        Kind("triangle", 2, 3, ((0, 1), (1, 2), (2, 0))),
        Kind("quad", 2, 4, ((0, 1), (1, 2), (2, 3), (3, 0))),
        Kind("tetra", 3, 4, ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))),
        Kind("pyramid", 3, 5, ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4))),
        Kind("wedge", 3, 6, ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))),
        Kind(
            "hexahedron", 3, 8,
            ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
        ),
    )
}  # fmt: skip
_OTHER = {
    "VTK_LAGRANGE_CURVE": "line",
    "VTK_LAGRANGE_TRIANGLE": "triangle",
    "VTK_LAGRANGE_QUADRILATERAL": "quad",
    "VTK_LAGRANGE_TETRAHEDRON": "tetra",
    "VTK_LAGRANGE_HEXAHEDRON": "hexahedron",
}


def kind_of(name: str, points: int) -> Kind | None:
    """The kind of a meshio type, such as "tetra10", with so many points in a cell; None if it is not known."""
    if name == "polygon":
        sides = tuple((k, (k + 1) % points) for k in range(points))
        return Kind(name, 2, points, sides)
    kind = KINDS.get(_OTHER.get(name, re.sub(r"\d+$", "", name)))
    return kind if kind is not None and kind.corners <= points else None


def measured(points: Points, corners: Corners, kind: Kind) -> tuple[Points, Points, NDArray[np.bool_]]:
    """What cells measure, and their centroids.

    Polygons by the shoelace formula; solids as polyhedra whose sides of four corners are four triangles around the mean
    of the corners, so that neighbors share them and cells fill the body without gaps. With warped sides, too, the
    volume is then that of the isoparametric cell.

    Args:
        points: (p, d) coordinates, with d the dimension of the cells.
        corners: (k, c) the points that the cells have as corners.
        kind: of the cells.

    Returns:
        Measures (k,) in m^d, negative for cells turned inside out (lines have no inside); centroids (k, d), m, of those
        that are not flat; and which are flat (k,), up to round-off.
    """
    measures, centroids, flat = np.empty(len(corners)), np.empty((len(corners), kind.dimension)), []
    rounding = 8 * np.finfo(np.float64).eps * float(np.abs(points).max(initial=0.0))
    for begin in range(0, len(corners), _AT_ONCE):
        some = slice(begin, begin + _AT_ONCE)
        places = points[corners[some]]
        middle = places.mean(axis=1)
        size, moment = _MOMENTS[kind.dimension](places - middle[:, None], kind)
        extent = np.ptp(places, axis=1).max(axis=1)
        none = np.abs(size) <= (_FLAT * extent + rounding) * extent ** (kind.dimension - 1)
        measures[some] = size
        centroids[some] = middle + moment / np.where(none, 1.0, size)[:, None]
        flat.append(none)
    return measures, centroids, np.concatenate([np.empty(0, np.bool_), *flat])


def _line(places: Points, kind: Kind) -> tuple[Points, Points]:
    """Measures (k,) and first moments (k, d) of cells with corners (k, c, d)."""
    return np.abs(places[:, 1, 0] - places[:, 0, 0]), np.zeros((len(places), 1))


def _polygon(places: Points, kind: Kind) -> tuple[Points, Points]:
    following = np.roll(places, -1, axis=1)
    cross = places[..., 0] * following[..., 1] - places[..., 1] * following[..., 0]
    return cross.sum(axis=1) / 2, ((places + following) * cross[..., None]).sum(axis=1) / 6


def _solid(places: Points, kind: Kind) -> tuple[Points, Points]:
    """Sums of tetrahedra between the origin and the triangles of the sides."""
    volume, moment = np.zeros(len(places)), np.zeros((len(places), 3))
    for side in kind.sides:
        corners = [places[:, corner] for corner in side]
        if len(side) == 3:
            triangles = [(corners[0], corners[1], corners[2])]
        else:
            top = places[:, list(side)].mean(axis=1)
            triangles = [(one, two, top) for one, two in zip(corners, [*corners[1:], corners[0]], strict=True)]
        for one, two, three in triangles:
            part = np.einsum("ij,ij->i", one, np.cross(two, three)) / 6
            volume += part
            moment += (one + two + three) * part[:, None] / 4
    return volume, moment


_MOMENTS = {1: _line, 2: _polygon, 3: _solid}
