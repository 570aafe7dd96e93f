"""Polygons: regions of the plane with straight edges, and flat faces in space that bonds can cross."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry import outline
from rbs_core.geometry.base import TOLERANCE
from rbs_core.geometry.box import require_right_angles
from rbs_core.geometry.described import as_direction, as_place, coordinate_tuple, row_tuples
from rbs_core.geometry.flat import Flat
from rbs_core.geometry.frames import unit
from rbs_core.geometry.similarity import cosine_and_sine
from rbs_core.space.checks import BoolArray, Bounds, FloatArray, as_number, as_points, as_text, as_vector


class Polygon(Flat):
    """What straight edges enclose, convex or not: a region of the plane in 2-D, a face in 3-D that cuts.

    In 3-D, seen from its positive side the points run counterclockwise. The size, for the tolerance, is the diagonal
    of the bounds.

    Args:
        points: corners in order (m), shape (n, 2) or (n, 3), n >= 3; the last is joined to the first.

    Raises:
        BadInput: when there are less than 3 points, when two that follow each other are the same, when they enclose no
            area, when one lies off the plane of the others, or when edges cross or touch; the message names them.
    """

    _kinds = {"points": "points"}

    def __init__(self, points: ArrayLike) -> None:
        self._set_corners(points)

    def _set_corners(self, points: ArrayLike) -> None:
        corners = as_points(points).copy()
        if corners.shape[1] == 1 or len(corners) < 3:
            raise BadInput(
                f"points has shape {corners.shape}; give 3 points or more in 2-D or 3-D, shape (n, 2) or (n, 3)"
            )
        corners.flags.writeable = False
        self.points = corners
        size = float(np.linalg.norm(np.ptp(corners, axis=0)))
        self._size = size
        flatness = TOLERANCE * size  # of the corners; what counts as on the polygon depends on the bond
        _require_edges(corners, flatness)
        # From the middle, as for a segment: symmetric shapes stay symmetric to the last bit.
        middle: FloatArray = corners.mean(axis=0)
        around = corners - middle
        normal = _area_vector(around)
        area = float(np.linalg.norm(normal))
        if area <= flatness * size:
            flat = _flattened(around)
            if np.ptp(flat[:, 1]) > flatness:  # no line, so that parts of it must count against each other
                _require_no_crossing(corners, outline.first_crossing(flat, flatness))
            raise BadInput(
                f"the points {as_text(corners)} enclose no area; give corners that do not lie on a line, "
                "in order along the outline"
            )
        self.area = area
        largest = float(np.abs(corners).max())
        if corners.shape[1] == 2:
            self._set_frame(middle, np.array([1.0, 0.0]), None, largest)
        else:
            normal = normal / area
            if np.abs(around @ normal).max() > flatness:
                raise BadInput(_off_plane(corners, flatness))
            first = corners[1] - corners[0]
            first = first - (first @ normal) * normal
            self._set_frame(middle, first / np.linalg.norm(first), normal, largest)
        self._outline = np.stack([around @ self._first, around @ self._second], axis=1)
        _require_no_crossing(corners, outline.first_crossing(self._outline, flatness))

    @property
    def bounds(self) -> Bounds:
        """The box around the corners."""
        return self.points.min(axis=0), self.points.max(axis=0)

    @property
    def size(self) -> float:
        """The diagonal of the bounds."""
        return self._size

    def _covers(self, x: FloatArray, y: FloatArray, tolerance: FloatArray) -> BoolArray:
        inside = np.zeros(len(x), dtype=np.bool_)
        near = np.zeros(len(x), dtype=np.bool_)
        for (x0, y0), (x1, y1) in outline.edges_of(self._outline):
            along_x, along_y = x1 - x0, y1 - y0
            from_x, from_y = x - x0, y - y0
            share = (from_x * along_x + from_y * along_y) / (along_x**2 + along_y**2)
            share = np.clip(share, 0.0, 1.0)
            near |= (from_x - share * along_x) ** 2 + (from_y - share * along_y) ** 2 <= tolerance**2
            if y0 != y1:
                # A ray towards +x flips inside and outside at every edge; the half-open rule counts a corner once.
                inside ^= ((y0 <= y) != (y1 <= y)) & (from_x < from_y * (along_x / along_y))
        return inside | near

    def _contains(self, points: FloatArray) -> BoolArray:
        if self.dimension == 3:
            return super()._contains(points)
        x, y = self._along(points, self._first), self._along(points, self._second)
        return outline.covered_by(self._outline, x, y, self._round_off(points))

    def _plane_distance(self, x: FloatArray, y: FloatArray) -> FloatArray:
        return outline.distance_of(self._outline, x, y)

    def _plane_nearest(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        return outline.nearest_of(self._outline, x, y)[1:]

    def _reaches(self, direction: FloatArray) -> float:
        return float((self.points @ direction).max())

    def _parameters(self) -> dict[str, object]:
        return {"points": row_tuples(self.points)}


class Triangle(Polygon):
    """A triangle: a region of the plane in 2-D, a face in 3-D; seen from its positive side a, b, c counterclockwise.

    Args:
        a: first corner (m), shape (2,) or (3,).
        b: second corner (m).
        c: third corner (m).

    Raises:
        BadInput: as `Polygon`.
    """

    _kinds = {"a": "point", "b": "point", "c": "point"}

    def __init__(self, a: ArrayLike, b: ArrayLike, c: ArrayLike) -> None:
        first = as_vector(a, "a")
        self._set_corners([first, as_place(b, "b", first.size), as_place(c, "c", first.size)])

    def _parameters(self) -> dict[str, object]:
        return dict(zip("abc", row_tuples(self.points), strict=True))


class Rectangle(Polygon):
    """A rectangle in any direction, by two edges at right angles from one corner (along the axes in 2-D: `Box`).

    A region of the plane in 2-D. In 3-D a face; its positive side is the one to which first x second points.

    Args:
        corner: one of the corners (m), shape (2,) or (3,).
        first: edge from there (m), a vector.
        second: edge at right angles to it (m).

    Raises:
        BadInput: for edges without length or not at right angles, and for different numbers of components.
    """

    _kinds = {"corner": "point", "first": "vector", "second": "vector"}

    def __init__(self, corner: ArrayLike, first: ArrayLike, second: ArrayLike) -> None:
        self.corner = as_vector(corner, "corner")
        size = self.corner.size
        self.first, self.second = as_direction(first, "first", size), as_direction(second, "second", size)
        require_right_angles([self.first, self.second], ("first", "second"), "a Polygon")
        ways = (np.zeros(size), self.first, self.first + self.second, self.second)
        self._set_corners([self.corner + way for way in ways])

    def _parameters(self) -> dict[str, object]:
        return {
            "corner": coordinate_tuple(self.corner), "first": coordinate_tuple(self.first),
            "second": coordinate_tuple(self.second),
        }  # fmt: skip


class RegularPolygon(Polygon):
    """A polygon with equal edges and angles: a region of the plane in 2-D, a face in 3-D.

    Args:
        sides: number of edges, 3 or more.
        center: middle (m), shape (2,) or (3,).
        corner: one of the corners (m).
        normal: in 3-D the direction of the positive side, a vector at right angles to the way to the corner.

    Raises:
        BadInput: for less than 3 sides, a corner at the center, a normal that is missing in 3-D, given in 2-D, without
            length or not at right angles.
    """

    _kinds = {"sides": "number", "center": "point", "corner": "point", "normal": "direction"}

    def __init__(self, sides: int, center: ArrayLike, corner: ArrayLike, normal: ArrayLike | None = None) -> None:
        count = as_number(sides, "sides")
        if count < 3 or count != int(count):
            raise BadInput(f"sides = {sides} is no number of edges; give a whole number from 3")
        self.sides = int(count)
        self.center = as_vector(center, "center")
        size = self.center.size
        self.corner = as_place(corner, "corner", size)
        out = self.corner - self.center
        if not out.any():
            raise BadInput(f"corner = center = {as_text(self.center)}; give a corner away from the center")
        self.normal = None
        if size == 3:
            if normal is None:
                raise BadInput("normal is missing: in 3-D give the direction in which the face looks")
            self.normal = as_direction(normal, "normal", 3)
            require_right_angles([out, self.normal], ("corner - center", "normal"), "move the corner")
            left = np.cross(unit(self.normal), out)
        elif size == 2 and normal is None:
            left = np.array([-out[1], out[0]])
        else:
            raise BadInput(f"center has {size} components, normal = {normal!r}; give 2 without a normal, or 3 with one")
        turns = np.array([cosine_and_sine(2.0 * np.pi * side / self.sides) for side in range(self.sides)])
        self._set_corners(self.center + turns[:, :1] * out + turns[:, 1:] * left)

    def _parameters(self) -> dict[str, object]:
        normal = {} if self.normal is None else {"normal": coordinate_tuple(self.normal)}
        center, corner = coordinate_tuple(self.center), coordinate_tuple(self.corner)
        return {"sides": self.sides, "center": center, "corner": corner, **normal}


def _require_edges(corners: FloatArray, tolerance: float) -> None:
    """Refuse a corner that repeats the one before it."""
    lengths = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    for index, length in enumerate(lengths.tolist()):
        if length <= tolerance:
            before = (index - 1) % len(corners)
            raise BadInput(
                f"points[{index}] = {as_text(corners[index])} repeats points[{before}]; "
                "leave it out (the outline closes by itself)"
            )


def _area_vector(around: FloatArray) -> FloatArray:
    """Normal of the polygon, as long as its area; right for any outline, convex or not."""
    full = np.zeros((len(around), 3))
    full[:, : around.shape[1]] = around
    area: FloatArray = np.cross(full, np.roll(full, -1, axis=0)).sum(axis=0) / 2
    return area


def _flattened(around: FloatArray) -> FloatArray:
    """Corners in the plane that is nearest to them, shape (k, 2)."""
    flat: FloatArray = around @ np.linalg.svd(around)[2][:2].T
    return flat


def _require_no_crossing(corners: FloatArray, edges: tuple[int, int] | None) -> None:
    """Refuse an outline of which two edges cross or touch."""
    if edges is None:
        return
    named = (f"points[{edge}] to points[{(edge + 1) % len(corners)}]" for edge in edges)
    raise BadInput(
        f"the edges {' and '.join(named)} cross or touch; give the corners in order along an outline that does not "
        "meet itself, or several polygons (a | b)"
    )


def _off_plane(corners: FloatArray, tolerance: float) -> str:
    """Message about the first corner that is not in the plane of those before it."""
    for count in range(4, len(corners) + 1):
        some = corners[:count] - corners[:count].mean(axis=0)
        if np.abs(some @ np.linalg.svd(some)[2][-1]).max() > tolerance:
            break
    before = corners[: count - 1] - corners[: count - 1].mean(axis=0)
    normal = np.linalg.svd(before)[2][-1]
    off = abs(float((corners[count - 1] - corners[: count - 1].mean(axis=0)) @ normal))
    return (
        f"points[{count - 1}] = {as_text(corners[count - 1])} lies {off:.3g} m off the plane of the points before it; "
        "move it into that plane, or cut with several polygons (a | b)"
    )
