"""Cylindrical and spherical coordinates, each in a frame of straight axes."""

from __future__ import annotations

from math import atan2, ceil, cos, floor, hypot, inf, pi

import numpy as np

from rbs_core.errors import BadInput
from rbs_core.space.checks import Bounds, FloatArray, as_text
from rbs_core.space.mapping import Framed

# By how much an angle may be beyond its range and still mean its end: sums of angles arrive with round-off.
ROUNDED = 1e-12


class Cylindrical(Framed):
    """Distance from an axis, angle about it, height along it: (r, phi, z); in 2-D polar coordinates (r, phi).

    In the frame x = r cos(phi), y = r sin(phi). Any phi is taken; the one that comes back is in (-pi, pi], and 0 on
    the axis, where the angle is undetermined. Components of vectors belong to the unit vectors along r, phi and z, so
    on the axis to those for the phi of the point: coming from other systems to those of the frame.

    Args:
        origin: a point of the axis in the parent's coordinates (m), 1 to 3 components; missing ones are 0.
        axes: of the frame: phi = 0 is along the first, z along the third; as those of `Cartesian`. Their lengths
            stretch the cylinder, and the unit vectors with it.

    Raises:
        BadInput: for axes without length or linearly dependent ones; in `to_parent` for a negative radius.
    """

    maker = "cylindrical"

    def _straight(self, points: FloatArray) -> FloatArray:
        _require_radius(self, points)
        radius, angle = points[:, 0], points[:, 1]
        return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), points[:, 2]])

    def _own(self, points: FloatArray) -> FloatArray:
        return np.column_stack([np.hypot(points[:, 0], points[:, 1]), _azimuth(points), points[:, 2]])

    def _tangents(self, points: FloatArray) -> FloatArray:
        cosine, sine = np.cos(points[:, 1]), np.sin(points[:, 1])
        tangents = np.zeros((len(points), 3, 3))
        tangents[:, 0, 0], tangents[:, 0, 1] = cosine, sine
        tangents[:, 1, 0], tangents[:, 1, 1] = -sine, cosine
        tangents[:, 2, 2] = 1.0
        return tangents

    def scales(self, points: FloatArray) -> FloatArray:
        ones = np.ones(len(points))
        return np.column_stack([ones, points[:, 0], ones])

    def near(self, points: FloatArray, middle: FloatArray) -> FloatArray:
        return _wound(points, middle, 1)

    def cell_volumes(self, lower: FloatArray, upper: FloatArray) -> FloatArray:
        _require_radius(self, lower)
        _require_one_turn(self, lower, upper, 1)
        sides = upper - lower
        sides[:, 0] *= (lower[:, 0] + upper[:, 0]) / 2 if lower.shape[1] > 1 else 1.0
        volumes: FloatArray = sides.prod(axis=1) * self.frame.volume_factor(lower.shape[1])
        return volumes

    def bounds_to_parent(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        """The smallest box in the parent's coordinates around the image of a box."""
        least_r, most_r = max(float(lower[0]), 0.0), float(upper[0])
        if most_r < least_r:
            return np.full(3, inf), np.full(3, -inf)  # radii are not negative: no point
        low, high = self.frame.origin.copy(), self.frame.origin.copy()
        for component in range(3):
            x, y, z = self.frame.axes[:, component].tolist()
            slowest, fastest = cosine_range(float(lower[1]) - atan2(y, x), float(upper[1]) - atan2(y, x))
            amplitude = hypot(x, y)
            along = sorted((times(z, float(lower[2])), times(z, float(upper[2]))))
            low[component] += min(times(amplitude * slowest, r) for r in (least_r, most_r)) + along[0]
            high[component] += max(times(amplitude * fastest, r) for r in (least_r, most_r)) + along[1]
        return low, high


class Spherical(Framed):
    """Distance from a point, angle from the z axis, angle about it: (r, theta, phi).

    In the frame x = r sin(theta) cos(phi), y = r sin(theta) sin(phi), z = r cos(theta), with theta from 0 to pi. Any
    phi is taken; the one that comes back is in (-pi, pi], and 0 on the z axis, where it is undetermined; theta is 0
    in the origin. Components of vectors belong to the unit vectors along r, theta and phi, so on the z axis to those
    for the angles of the point: coming from other systems to those for phi = 0.

    Args:
        origin: the point in the parent's coordinates (m), 1 to 3 components; missing ones are 0.
        axes: of the frame: theta = 0 is along the third, theta = pi/2 with phi = 0 along the first; as those of
            `Cartesian`. Their lengths stretch the sphere, and the unit vectors with it.

    Raises:
        BadInput: for axes without length or linearly dependent ones; in `to_parent` for a negative radius and for a
            theta outside of 0 to pi.
    """

    maker = "spherical"

    def _straight(self, points: FloatArray) -> FloatArray:
        _require_radius(self, points)
        _require_polar(self, points)
        radius, polar, azimuth = points.T
        flat = radius * np.sin(polar)
        return np.column_stack([flat * np.cos(azimuth), flat * np.sin(azimuth), radius * np.cos(polar)])

    def _own(self, points: FloatArray) -> FloatArray:
        flat = np.hypot(points[:, 0], points[:, 1])
        polar = np.arctan2(flat, points[:, 2] + 0.0)  # + 0.0: no angle of pi from a zero with a sign
        return np.column_stack([np.hypot(flat, points[:, 2]), polar, _azimuth(points)])

    def _tangents(self, points: FloatArray) -> FloatArray:
        upright, level = np.cos(points[:, 1]), np.sin(points[:, 1])
        cosine, sine = np.cos(points[:, 2]), np.sin(points[:, 2])
        rows = (
            (level * cosine, level * sine, upright),
            (upright * cosine, upright * sine, -level),
            (-sine, cosine, np.zeros(len(points))),
        )
        return np.stack([np.stack(row, axis=1) for row in rows], axis=1)

    def scales(self, points: FloatArray) -> FloatArray:
        radius = points[:, 0]
        return np.column_stack([np.ones(len(points)), radius, radius * np.sin(points[:, 1])])

    def near(self, points: FloatArray, middle: FloatArray) -> FloatArray:
        return _wound(points, middle, 2)

    def cell_volumes(self, lower: FloatArray, upper: FloatArray) -> FloatArray:
        if lower.shape[1] < 3:
            raise BadInput(f"cells in {self!r} have {lower.shape[1]} axes; give three: r, theta and phi")
        for ends in (lower, upper):
            _require_radius(self, ends)
            _require_polar(self, ends)
        _require_one_turn(self, lower, upper, 2)
        inner, outer = lower[:, 0], upper[:, 0]
        shell = (outer - inner) * (outer**2 + outer * inner + inner**2) / 3
        middle, half = (upper[:, 1] + lower[:, 1]) / 2, (upper[:, 1] - lower[:, 1]) / 2
        band = 2.0 * np.sin(middle) * np.sin(half)  # a difference of cosines, without its loss of digits
        return shell * band * (upper[:, 2] - lower[:, 2]) * self.frame.volume_factor(3)

    def bounds_to_parent(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        """The smallest box in the parent's coordinates around the image of a box."""
        least_r, most_r = max(float(lower[0]), 0.0), float(upper[0])
        least_polar, most_polar = max(float(lower[1]), 0.0), min(float(upper[1]), pi)
        if most_r < least_r or most_polar < least_polar:
            return np.full(3, inf), np.full(3, -inf)  # there are no such radii or angles: no point
        low, high = self.frame.origin.copy(), self.frame.origin.copy()
        for component in range(3):
            x, y, z = self.frame.axes[:, component].tolist()
            slowest, fastest = cosine_range(float(lower[2]) - atan2(y, x), float(upper[2]) - atan2(y, x))
            ends = []
            for level in (hypot(x, y) * slowest, hypot(x, y) * fastest):  # level sin(theta) + z cos(theta)
                phase = atan2(level, z)
                ends += [hypot(level, z) * end for end in cosine_range(least_polar - phase, most_polar - phase)]
            low[component] += min(times(ends[0], r) for r in (least_r, most_r))
            high[component] += max(times(ends[3], r) for r in (least_r, most_r))
        return low, high


def _require_radius(mapping: Framed, points: FloatArray) -> None:
    """Refuse negative radii: they would come back as other coordinates."""
    wrong = np.flatnonzero(points[:, 0] < 0.0)
    if wrong.size:
        raise BadInput(
            f"points[{wrong[0]}] = {as_text(points[wrong[0]])} has a negative radius in {mapping!r}; give radii from "
            "0, and turn the angle by pi for the opposite side"
        )


def _require_polar(mapping: Framed, points: FloatArray) -> None:
    """Refuse angles from the axis that no point has; degrees are among them."""
    polar = points[:, 1]
    wrong = np.flatnonzero((polar < -ROUNDED) | (polar > pi + ROUNDED))
    if wrong.size:
        raise BadInput(
            f"points[{wrong[0]}] = {as_text(points[wrong[0]])} has theta = {polar[wrong[0]]:.6g} in {mapping!r}; "
            "give it in rad, from 0 (on the z axis) to pi"
        )


def _require_one_turn(mapping: Framed, lower: FloatArray, upper: FloatArray, column: int) -> None:
    """Refuse cells that lie over each other because their angles go round more than once."""
    if lower.shape[1] <= column or not len(lower):
        return
    least, most = lower[:, column].min(), upper[:, column].max()
    if most - least > 2 * pi + ROUNDED:
        raise BadInput(
            f"cells in {mapping!r} go round from {least:.6g} to {most:.6g} rad, more than a full turn, and lie over "
            "each other; give angles in rad that span 2 pi at most"
        )


def _azimuth(points: FloatArray) -> FloatArray:
    """Angles of the first two coordinates in (-pi, pi]; 0 on the axis, whatever the signs of the zeros."""
    angle: FloatArray = np.arctan2(points[:, 1] + 0.0, points[:, 0] + 0.0)
    return angle


def _wound(points: FloatArray, middle: FloatArray, column: int) -> FloatArray:
    """Points with the angle of one column turned by whole turns to within half a turn of a middle."""
    if column >= points.shape[1] or not np.isfinite(middle[column]):
        return points
    turns = np.rint((middle[column] - points[:, column]) / (2 * pi))
    if not turns.any():
        return points
    result = points.copy()
    result[:, column] += turns * (2 * pi)
    return result


def cosine_range(start: float, stop: float) -> tuple[float, float]:
    """Smallest and largest cosine of the angles (rad) between two; of all angles where the interval is infinite."""
    if not stop - start < 2 * pi:
        return -1.0, 1.0
    ends = cos(start), cos(stop)
    crest = ceil(start / (2 * pi)) * 2 * pi <= stop
    trough = (2 * floor((stop - pi) / (2 * pi)) + 1) * pi >= start
    return -1.0 if trough else min(ends), 1.0 if crest else max(ends)


def times(factor: float, bound: float) -> float:
    """A product in which nothing of infinity is nothing."""
    return 0.0 if factor == 0.0 else factor * bound
