"""The checks that make a surface of triangles: each refusal names the triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry.base import TOLERANCE
from rbs_core.geometry.boxtree import BoxTree, Indices, overlapping
from rbs_core.space.checks import BoolArray, FloatArray, as_points, as_text


def as_triangles(vertices: ArrayLike, triangles: ArrayLike) -> tuple[FloatArray, Indices]:
    """Vertices and triangles of a surface, read-only copies.

    Args:
        vertices: (m), shape (n, 3).
        triangles: indices of three vertices each, shape (m, 3).

    Raises:
        BadInput: for other shapes, indices that do not exist, and triangles without area; the message names the first.
    """
    places = as_points(vertices, "vertices").copy()
    if places.shape[1] != 3:
        raise BadInput(f"vertices has shape {places.shape}; give points in 3-D, shape (n, 3)")
    rows = np.array(triangles)
    if rows.ndim != 2 or rows.shape[1] != 3 or not len(rows) or rows.dtype.kind not in "iu":
        raise BadInput(f"triangles has shape {rows.shape} of {rows.dtype}; give three indices of vertices each, (m, 3)")
    wrong = np.flatnonzero(((rows < 0) | (rows >= len(places))).any(axis=1))
    if wrong.size:
        raise BadInput(
            f"triangles[{wrong[0]}] = {as_text(rows[wrong[0]])} names a vertex that is not there; "
            f"give indices from 0 to {len(places) - 1}"
        )
    rows = rows.astype(np.int64)
    corners = places[rows]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.linalg.norm(np.cross(first, second), axis=1)
    longest = np.max([(first**2).sum(axis=1), (second**2).sum(axis=1), ((second - first) ** 2).sum(axis=1)], axis=0)
    wrong = np.flatnonzero(area <= TOLERANCE * longest)
    if wrong.size:
        raise BadInput(
            f"triangles[{wrong[0]}] = {as_text(rows[wrong[0]])} with the corners {as_text(corners[wrong[0]])} has no "
            f"area ({len(wrong)} such triangles); leave it out, and join vertices that coincide"
        )
    places.flags.writeable = rows.flags.writeable = False
    return places, rows


def edges_of(triangles: Indices) -> tuple[Indices, Indices, Indices]:
    """The edges of triangles, as they are gone around.

    Returns:
        Start and end vertex, and the triangle, of each edge, shape (3 m,) each.
    """
    starts, ends = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    return starts, ends, np.repeat(np.arange(len(triangles)), 3)


def require_one_side(vertices: FloatArray, triangles: Indices, closed: bool) -> None:
    """Refuse triangles that do not make a surface with two sides.

    Args:
        vertices: (m), shape (n, 3).
        triangles: shape (m, 3).
        closed: whether every edge must have two triangles.

    Raises:
        BadInput: for an edge that two triangles go along in the same direction, one with more than two triangles, and,
            if it must be closed, one with a single triangle; the message names edge and triangles.
    """
    starts, ends, owners = edges_of(triangles)
    forth, back = starts * len(vertices) + ends, ends * len(vertices) + starts
    keys, first, counts = np.unique(forth, return_index=True, return_counts=True)
    if (counts > 1).any():
        edge = first[np.flatnonzero(counts > 1)[0]]
        both = owners[forth == forth[edge]]
        many = len(both) + np.count_nonzero(back == forth[edge])
        where = _edge_text(vertices, starts[edge], ends[edge])
        if many > 2:
            raise BadInput(
                f"{many} triangles share {where}, such as triangles {both[0]} and {both[1]}; a surface has two there: "
                "give several surfaces"
            )
        raise BadInput(
            f"triangles {both[0]} and {both[1]} go along {where} in the same direction: one of them is turned over; "
            "give all corners counterclockwise, seen from the same side"
        )
    alone = np.flatnonzero(~np.isin(back, keys))
    if closed and alone.size:
        edge = alone[0]
        where = _edge_text(vertices, starts[edge], ends[edge])
        raise BadInput(
            f"the surface is open: triangle {owners[edge]} has no neighbor at {where} ({len(alone)} such edges); close "
            "the hole, join vertices that coincide (read(..., join=)), or cut with a TriangulatedSurface"
        )


def _edge_text(vertices: FloatArray, start: int, end: int) -> str:
    return f"the edge from vertex {start} at {as_text(vertices[start])} to vertex {end} at {as_text(vertices[end])}"


def require_no_crossing(vertices: FloatArray, triangles: Indices, tree: BoxTree) -> None:
    """Refuse triangles that pass through each other.

    Raises:
        BadInput: naming the first two triangles.
    """
    starts, ends, owners = edges_of(triangles)
    a, b = vertices[starts], vertices[ends]
    lower, upper = np.minimum(a, b), np.maximum(a, b)
    edges, others = tree.pairs(
        np.arange(len(starts)),
        lambda rows, low, high: overlapping(lower[rows], upper[rows], low, high),
    )
    apart = ~((triangles[others] == starts[edges, None]) | (triangles[others] == ends[edges, None])).any(axis=1)
    edges, others = edges[apart], others[apart]
    through = _passes(a[edges], b[edges], vertices[triangles[others]])
    if through.any():
        pair = np.flatnonzero(through)[0]
        raise BadInput(
            f"triangles {owners[edges[pair]]} and {others[pair]} pass through each other; give a surface that does not "
            "meet itself, or several surfaces (a | b)"
        )


def _passes(starts: FloatArray, ends: FloatArray, corners: FloatArray) -> BoolArray:
    """Whether segments pass through the inside of triangles, row by row."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    below, above = ((starts - a) * normal).sum(axis=1), ((ends - a) * normal).sum(axis=1)
    way = ends - starts
    sides = np.stack([(np.cross(p - starts, q - starts) * way).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))])
    passes: BoolArray = ((sides > 0.0).all(axis=0) | (sides < 0.0).all(axis=0)) & (below * above < 0.0)
    return passes
