"""Solids with flat faces: prism, pyramid, tetrahedron."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry.base import TOLERANCE
from rbs_core.geometry.described import as_direction, as_place, coordinate_tuple, require_kind
from rbs_core.geometry.frames import lengths
from rbs_core.geometry.polygon import Polygon
from rbs_core.geometry.solid import Solid
from rbs_core.space.checks import BoolArray, FloatArray, as_text

# Points per round of the sum over the faces.
ROUND = 1 << 16


class Polyhedron(Solid):
    """What flat faces enclose: each a polygon whose positive side is outside."""

    _faces: tuple[Polygon, ...]

    @property
    def dimension(self) -> int:
        """3."""
        return 3

    def _set_faces(self, rows: list[FloatArray], outward: bool) -> None:
        """Takes the corners of the faces, in an order that is counterclockwise seen from outside or from inside."""
        self._faces = tuple(Polygon(row if outward else row[::-1]) for row in rows)

    def _distance(self, points: FloatArray) -> FloatArray:
        away: FloatArray = np.array([face._distance(points) for face in self._faces]).min(axis=0)
        signed: FloatArray = np.where(self._winding(points), -away, away)
        return signed

    def _winding(self, points: FloatArray) -> BoolArray:
        """Whether the faces go around points: they are then seen under the full solid angle."""
        angle = np.zeros(len(points))
        for begin in range(0, len(points), ROUND):
            rows = slice(begin, begin + ROUND)
            for face in self._faces:
                # A fan from the first corner; where it leaves the face, its triangles cancel each other.
                for second, third in zip(face.points[1:-1], face.points[2:], strict=True):
                    angle[rows] += solid_angles(points[rows], face.points[0], second, third)
        inside: BoolArray = angle > 2.0 * np.pi
        return inside

    def _projection(self, points: FloatArray) -> FloatArray:
        distances = np.array([face._distance(points) for face in self._faces])
        candidates = np.array([face._projection(points) for face in self._faces])
        nearest: FloatArray = candidates[distances.argmin(axis=0), np.arange(len(points))]
        return nearest

    def _reaches(self, direction: FloatArray) -> float:
        return max(face._reaches(direction) for face in self._faces)


class Prism(Polyhedron):
    """What a polygon passes over when it is moved along a vector, at right angles to it or not.

    Args:
        base: a polygon in 3-D.
        vector: the way (m), shape (3,), out of the plane of the base.

    Raises:
        BadInput: for something else than a polygon in 3-D, and for a vector in its plane.
    """

    _kinds = {"base": "geometry", "vector": "vector"}

    def __init__(self, base: Polygon, vector: ArrayLike) -> None:
        self.base = _base(base)
        self.vector = as_direction(vector, "vector", 3)
        height = _height(base, self.vector, f"vector = {as_text(self.vector)} lies in the plane of the base")
        bottom, top = base.points, base.points + self.vector
        after = np.roll(np.arange(len(bottom)), -1)
        sides = [np.array([bottom[i], bottom[j], top[j], top[i]]) for i, j in enumerate(after)]
        self._set_faces([bottom[::-1], top, *sides], outward=height > 0.0)

    def _parameters(self) -> dict[str, object]:
        return {"base": self.base, "vector": coordinate_tuple(self.vector)}


class Pyramid(Polyhedron):
    """What the straight ways from an apex to the points of a polygon fill.

    Args:
        base: a polygon in 3-D.
        apex: the tip (m), shape (3,), off the plane of the base.

    Raises:
        BadInput: for something else than a polygon in 3-D, and for an apex in its plane.
    """

    _kinds = {"base": "geometry", "apex": "point"}

    def __init__(self, base: Polygon, apex: ArrayLike) -> None:
        self.base = _base(base)
        self.apex = as_place(apex, "apex", 3)
        up = self.apex - base._middle
        height = _height(base, up, f"apex = {as_text(self.apex)} lies in the plane of the base")
        corners = base.points
        after = np.roll(np.arange(len(corners)), -1)
        sides = [np.array([corners[i], corners[j], self.apex]) for i, j in enumerate(after)]
        self._set_faces([corners[::-1], *sides], outward=height > 0.0)

    def _parameters(self) -> dict[str, object]:
        return {"base": self.base, "apex": coordinate_tuple(self.apex)}


class Tetrahedron(Polyhedron):
    """What four points enclose.

    Args:
        a: first corner (m), shape (3,).
        b: second corner (m).
        c: third corner (m).
        d: fourth corner (m), off the plane of the others.

    Raises:
        BadInput: for corners that lie in one plane or on a line.
    """

    _kinds = {"a": "point", "b": "point", "c": "point", "d": "point"}

    def __init__(self, a: ArrayLike, b: ArrayLike, c: ArrayLike, d: ArrayLike) -> None:
        named = zip("abcd", (a, b, c, d), strict=True)
        self.corners = np.array([as_place(corner, name, 3) for name, corner in named])
        base = Polygon(self.corners[:3])
        height = _height(
            base, self.corners[3] - base._middle, f"d = {as_text(self.corners[3])} lies in the plane of a, b, c"
        )
        sides = [self.corners[[i, j, 3]] for i, j in ((0, 1), (1, 2), (2, 0))]
        self._set_faces([self.corners[[2, 1, 0]], *sides], outward=height > 0.0)

    def _parameters(self) -> dict[str, object]:
        return dict(zip("abcd", map(coordinate_tuple, self.corners), strict=True))


def solid_angles(points: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Solid angles (n,) of a triangle seen from points (n, 3), positive seen from the side on which it runs clockwise.

    tan(angle / 2) = a.(b x c) / (|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|), with the vectors from the point to the
    corners (van Oosterom and Strackee 1983).
    """
    to_a, to_b, to_c = a - points, b - points, c - points
    far_a, far_b, far_c = lengths(to_a), lengths(to_b), lengths(to_c)
    volume = (to_a * np.cross(to_b, to_c)).sum(axis=1)
    rest = far_a * far_b * far_c
    rest += (to_a * to_b).sum(axis=1) * far_c + (to_b * to_c).sum(axis=1) * far_a + (to_c * to_a).sum(axis=1) * far_b
    angle: FloatArray = 2.0 * np.arctan2(volume, rest)
    return angle


def _base(base: Polygon) -> Polygon:
    require_kind(base, Polygon, "base")
    if base.dimension != 3:
        raise BadInput(f"base = {base!r} lies in 2-D; give its points three coordinates")
    return base


def _height(base: Polygon, vector: FloatArray, what: str) -> float:
    """How far a vector leads out of the plane of a base, refused if it does not."""
    height = float(base._normal @ vector)
    if abs(height) <= TOLERANCE * max(base.size, float(np.linalg.norm(vector))):
        raise BadInput(f"{what}, so that no volume is enclosed; lead out of the plane")
    return height
