"""Solids with flat faces: prism, pyramid, tetrahedron."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry import outline
from rbs_core.geometry.base import TOLERANCE
from rbs_core.geometry.described import as_direction, as_place, coordinate_tuple, require_kind
from rbs_core.geometry.frames import lengths, rows_along
from rbs_core.geometry.polygon import Polygon
from rbs_core.geometry.solid import Solid
from rbs_core.space.checks import BoolArray, FloatArray, as_text

# Part of the size up to which a point is near enough to the surface to ask for its distance.
NEAR = 1e-6


class Polyhedron(Solid):
    """What flat faces enclose: each a polygon whose positive side is outside; the first is the base."""

    base: Polygon
    _rise: float  # of the other end over the base, along its normal
    _faces: tuple[Polygon, ...]

    @property
    def dimension(self) -> int:
        """3."""
        return 3

    def _set_faces(self, rows: list[FloatArray]) -> None:
        """Takes the corners of the faces, in an order that is counterclockwise seen from outside if it rises."""
        self._faces = tuple(Polygon(row if self._rise > 0.0 else row[::-1]) for row in rows)

    def _share(self, points: FloatArray) -> FloatArray:
        """How far points are on the way from the base (0) to the other end (1)."""
        share: FloatArray = self.base._heights(points) / self._rise
        return share

    @abstractmethod
    def _covers(self, points: FloatArray, margin: FloatArray) -> BoolArray:
        """Which points are inside, or hardly more than a margin (n,) beside."""

    def _over_base(self, feet: FloatArray, margin: FloatArray) -> BoolArray:
        """Which feet of points in the plane of the base are in the base, or at most a margin beside."""
        x, y = (self.base._along(feet, direction) for direction in (self.base._first, self.base._second))
        return outline.covered_by(self.base._outline, x, y, margin)

    def _contains(self, points: FloatArray) -> BoolArray:
        inside = self._covers(points, np.zeros(len(points)))
        beside = np.flatnonzero(~inside)
        margin = self._round_off(points[beside])
        # The section of a slender solid is known less well than its faces: these decide, for the few points near them.
        close = self._covers(points[beside], margin + NEAR * self.size)
        beside, margin = beside[close], margin[close]
        inside[beside] = self._from_faces(points[beside]) <= margin
        return inside

    def _from_faces(self, points: FloatArray) -> FloatArray:
        """Distance from the nearest face."""
        away = self._faces[0]._distance(points)
        for face in self._faces[1:]:
            np.minimum(away, face._distance(points), out=away)
        return away

    def _distance(self, points: FloatArray) -> FloatArray:
        away = self._from_faces(points)
        inside = self._covers(points, np.zeros(len(points)))
        signed: FloatArray = np.where(inside & (away > 0.0), -away, away)  # never -0.0
        return signed

    def _projection(self, points: FloatArray) -> FloatArray:
        distances = np.array([face._distance(points) for face in self._faces])
        candidates = np.array([face._projection(points) for face in self._faces])
        nearest: FloatArray = candidates[distances.argmin(axis=0), np.arange(len(points))]
        return nearest

    def _reaches(self, direction: FloatArray) -> float:
        return max(face._reaches(direction) for face in self._faces)


class Pointed(Polyhedron):
    """What the straight ways from an apex to the points of a polygon fill."""

    _tip: FloatArray

    def _set_sides(self, base: Polygon, tip: FloatArray, what: str) -> None:
        """Takes base and tip."""
        self.base, self._tip = base, tip
        self._rise = _rise(base, tip - base._middle, what)
        corners = base.points
        after = np.roll(np.arange(len(corners)), -1)
        self._set_faces([corners[::-1], *(np.array([corners[i], corners[j], tip]) for i, j in enumerate(after))])

    def _covers(self, points: FloatArray, margin: FloatArray) -> BoolArray:
        share = self._share(points)
        beside = margin / abs(self._rise)
        covered = (share >= -beside) & (share <= 1.0 + beside)
        candidates = np.flatnonzero(covered)
        left = np.maximum(1.0 - share[candidates], 1e-12)  # of the way to the tip; there the section is a point
        off, margin = points[candidates] - self._tip, margin[candidates]
        covered[candidates] = self._over_base(self._tip + off / left[:, None], margin / left) | (lengths(off) <= margin)
        return covered


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
        self._rise = _rise(base, self.vector, f"vector = {as_text(self.vector)} lies in the plane of the base")
        bottom, top = base.points, base.points + self.vector
        after = np.roll(np.arange(len(bottom)), -1)
        sides = [np.array([bottom[i], bottom[j], top[j], top[i]]) for i, j in enumerate(after)]
        self._set_faces([bottom[::-1], top, *sides])

    def _covers(self, points: FloatArray, margin: FloatArray) -> BoolArray:
        share = self._share(points)
        beside = margin / abs(self._rise)
        covered = (share >= -beside) & (share <= 1.0 + beside)
        candidates = np.flatnonzero(covered)
        feet = points[candidates] - rows_along(share[candidates], self.vector)
        covered[candidates] = self._over_base(feet, margin[candidates])
        return covered

    def _parameters(self) -> dict[str, object]:
        return {"base": self.base, "vector": coordinate_tuple(self.vector)}


class Pyramid(Pointed):
    """What the straight ways from an apex to the points of a polygon fill.

    Args:
        base: a polygon in 3-D.
        apex: the tip (m), shape (3,), off the plane of the base.

    Raises:
        BadInput: for something else than a polygon in 3-D, and for an apex in its plane.
    """

    _kinds = {"base": "geometry", "apex": "point"}

    def __init__(self, base: Polygon, apex: ArrayLike) -> None:
        self.apex = as_place(apex, "apex", 3)
        self._set_sides(_base(base), self.apex, f"apex = {as_text(self.apex)} lies in the plane of the base")

    def _parameters(self) -> dict[str, object]:
        return {"base": self.base, "apex": coordinate_tuple(self.apex)}


class Tetrahedron(Pointed):
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
        what = f"d = {as_text(self.corners[3])} lies in the plane of a, b, c"
        self._set_sides(Polygon(self.corners[:3]), self.corners[3], what)

    def _parameters(self) -> dict[str, object]:
        return dict(zip("abcd", map(coordinate_tuple, self.corners), strict=True))


def _base(base: Polygon) -> Polygon:
    require_kind(base, Polygon, "base")
    if base.dimension != 3:
        raise BadInput(f"base = {base!r} lies in 2-D; give its points three coordinates")
    return base


def _rise(base: Polygon, vector: FloatArray, what: str) -> float:
    """How far a vector leads out of the plane of a base, refused if it does not."""
    height = float(base._normal @ vector)
    if abs(height) <= TOLERANCE * max(base.size, float(np.linalg.norm(vector))):
        raise BadInput(f"{what}, so that no volume is enclosed; lead out of the plane")
    return height
