"""What two single shapes share, where it is a single shape again."""

from __future__ import annotations

import numpy as np

from rbs_core.errors import BadInput
from rbs_core.geometry.base import ROUND_OFF, TOLERANCE, Geometry
from rbs_core.geometry.box import Box
from rbs_core.geometry.described import common_dimension, require_kind
from rbs_core.geometry.flat import Disk, Flat
from rbs_core.geometry.frames import parallel, perpendicular, square, unit
from rbs_core.geometry.planes import Plane, Point
from rbs_core.geometry.polygon import Rectangle
from rbs_core.geometry.primitives import Ball, Bar, HalfSpace, Slab
from rbs_core.geometry.straight import Line, Ray, Segment, Straight
from rbs_core.geometry.whole import Everywhere, Nowhere
from rbs_core.space.checks import FloatArray

Interval = tuple[float, float]
EMPTY: Interval = (np.inf, -np.inf)
ALL: Interval = (-np.inf, np.inf)


def intersection(a: Geometry, b: Geometry) -> Geometry:
    """What two shapes share, as a single shape; `Nowhere()` where there is none, or no single shape describes it.

    Args:
        a: a geometry.
        b: another one, of the same dimension.

    Raises:
        BadInput: for something that is no geometry, and for different dimensions.
    """
    require_kind(b, Geometry, "other")
    common_dimension(a, b)
    if a == b:
        return a
    a, b = _simpler(a), _simpler(b)
    for first, second in ((a, b), (b, a)):
        found = _shared(first, second)
        if found is not None:
            return found
    return Nowhere()


def _simpler(shape: Geometry) -> Geometry:
    """The same points as a shape for which there are more rules."""
    if shape.dimension == 2 and isinstance(shape, Plane):
        return Line(shape.point, -perpendicular(shape.normal))
    if shape.dimension == 2 and isinstance(shape, Bar):
        return Slab(2.0 * shape.radius, shape.point, perpendicular(shape.axis))
    if shape.dimension == 1 and isinstance(shape, Plane):
        return Point(shape.point)
    if shape.dimension == 1 and isinstance(shape, HalfSpace | Slab | Ball):
        return Box.between(*shape.bounds)
    return shape


def _shared(a: Geometry, b: Geometry) -> Geometry | None:
    """What two shapes share, None where no rule for the first one tells."""
    if isinstance(a, Everywhere):
        return b
    if isinstance(a, Nowhere):
        return a
    if isinstance(a, Point):
        return a if _holds(b, a) else Nowhere()
    if isinstance(a, Straight):
        span = _span(a, b)
        return None if span is None else piece_of(a, *span)
    if isinstance(a, Plane):
        return _of_plane(a, b)
    if isinstance(a, Box):
        return _of_box(a, b)
    if isinstance(a, HalfSpace | Slab) and isinstance(b, HalfSpace | Slab):
        return _of_layers(a, b)
    if isinstance(a, Ball):
        return _of_round(a, a.center, b, None)
    if isinstance(a, Bar):
        return _of_round(a, a.point, b, a._unit)
    return None


def _holds(shape: Geometry, point: Point) -> bool:
    """Whether a point is in or on a shape; without a tolerance if that knows no distance."""
    try:
        return bool(shape.status(point.x[None])[0] <= 0)
    except BadInput:
        return bool(shape.contains(point.x[None])[0])


def margin(*shapes: Geometry) -> float:
    """Length up to which shapes touch (m)."""
    sizes = [shape.size for shape in shapes if shape.size > 0.0]
    largest = max(shape._farthest() for shape in shapes)
    return TOLERANCE * min(sizes, default=0.0) + ROUND_OFF * largest


def piece_of(line: Straight, low: float, high: float) -> Geometry:
    """The part of a line, ray or segment between two coordinates along it."""
    least, most = line._limits
    touch = margin(line)
    low, high = max(low, least), min(high, most)
    if low > high + touch:
        return Nowhere()
    if (low, high) == (least, most):
        return line
    if high - low <= touch:
        return Point(line._middle + (low + high) / 2 * line._along)
    if np.isinf(low) and np.isinf(high):
        return Line(line._middle, line._along)
    if np.isinf(high):
        return Ray(line._middle + low * line._along, line._along)
    if np.isinf(low):
        return Ray(line._middle + high * line._along, -line._along)
    return Segment(line._middle + low * line._along, line._middle + high * line._along)


def _span(line: Straight, b: Geometry) -> Interval | None:
    """Coordinates along a line between which it is in a convex shape; None for a shape of which no rule tells."""
    touch = margin(line, b)
    if isinstance(b, Plane):
        return _between_heights(line, b.point, b._unit, -touch, touch, sharp=True)
    if isinstance(b, HalfSpace):
        return _between_heights(line, b.point, unit(b.normal), 0.0, np.inf)
    if isinstance(b, Slab):
        return _between_heights(line, b.center, b._unit, -b.thickness / 2, b.thickness / 2)
    if isinstance(b, Box):
        spans = [
            _between_heights(line, np.zeros(b.dimension), axis, low, high)
            for axis, low, high in zip(np.eye(b.dimension), b.lower, b.upper, strict=True)
        ]
        return max(low for low, _ in spans), min(high for _, high in spans)
    if isinstance(b, Ball):
        return _chord(line._middle - b.center, line._along, b.radius, touch)
    if isinstance(b, Bar):
        away = line._middle - b.point
        away, slope = away - (away @ b._unit) * b._unit, line._along - (line._along @ b._unit) * b._unit
        return _chord(away, slope, b.radius, touch)
    if isinstance(b, Straight):
        return _common_piece(line, b, touch)
    if isinstance(b, Flat) and b.dimension == 3:
        low, high = _between_heights(line, b._middle, b._normal, -touch, touch, sharp=True)
        if np.isfinite(low):
            place = line._middle + low * line._along
            return (low, high) if b.status(place[None], touch)[0] <= 0 else EMPTY
        if (low, high) == EMPTY:
            return EMPTY
        return _chord(line._middle - b.center, line._along, b.radius, touch) if isinstance(b, Disk) else None
    return None


def _between_heights(
    line: Straight, point: FloatArray, normal: FloatArray, low: float, high: float, sharp: bool = False
) -> Interval:
    """Where a line is between two heights over a plane; where it passes height 0 if `sharp`."""
    height, slope = float((line._middle - point) @ normal), float(line._along @ normal)
    if square(line._along, normal):
        return ALL if low <= height <= high else EMPTY
    if sharp:
        return -height / slope, -height / slope
    first, second = sorted(((low - height) / slope, (high - height) / slope))
    return first, second


def _chord(away: FloatArray, slope: FloatArray, radius: float, touch: float) -> Interval:
    """Where away + t slope is at most a radius long."""
    steep = float(slope @ slope)
    if steep <= 1e-24:
        return ALL if np.linalg.norm(away) <= radius + touch else EMPTY
    middle = -float(away @ slope) / steep
    depth = radius - float(np.linalg.norm(away + middle * slope))
    if depth < -touch:
        return EMPTY
    half = 0.0 if depth <= touch else float(np.sqrt(depth * (2.0 * radius - depth) / steep))
    return middle - half, middle + half


def _common_piece(line: Straight, other: Straight, touch: float) -> Interval:
    """Where two lines meet, as coordinates along the first."""
    between = other._middle - line._middle
    if parallel(line._along, other._along):
        shift = float(between @ line._along)
        if np.linalg.norm(between - shift * line._along) > touch:
            return EMPTY
        sense = 1.0 if line._along @ other._along > 0.0 else -1.0
        first, second = sorted(shift + sense * limit for limit in other._limits)
        return first, second
    lean = float(line._along @ other._along)
    along, along_other = float(between @ line._along), float(between @ other._along)
    t = (along - lean * along_other) / (1.0 - lean**2)
    s = t * lean - along_other
    apart = float(np.linalg.norm(between + s * other._along - t * line._along))
    least, most = other._limits
    return (t, t) if apart <= touch and least - touch <= s <= most + touch else EMPTY


def _of_plane(plane: Plane, b: Geometry) -> Geometry | None:
    """What a plane in 3-D shares with another shape."""
    touch = margin(plane, b)
    if isinstance(b, Plane):
        if parallel(plane._unit, b._unit):
            return plane if b._distance(plane.point[None])[0] <= touch else Nowhere()
        along = unit(np.cross(plane._unit, b._unit))
        # From a point of the first plane within it, at right angles to the line, to the second one.
        way = np.cross(along, plane._unit)
        share = float((b.point - plane.point) @ b._unit) / float(way @ b._unit)
        return Line(plane.point + share * way, along)
    if isinstance(b, HalfSpace | Slab):
        normal = unit(b.normal)
        if not parallel(plane._unit, normal):
            return None
        return plane if b._distance(plane.point[None])[0] <= touch else Nowhere()
    if isinstance(b, Ball):
        height = float(plane._heights(b.center[None])[0])
        return _slice(plane, b.center - height * plane._unit, b.radius - abs(height), b.radius, touch)
    if isinstance(b, Bar) and parallel(plane._unit, b._unit):
        height = float(plane._heights(b.point[None])[0]) / float(plane._unit @ b._unit)
        return Disk(b.radius, b.point - height * b._unit, plane.normal)
    if isinstance(b, Bar) and square(plane._unit, b._unit):
        height = float(plane._heights(b.point[None])[0])
        if abs(height) > b.radius + touch:
            return Nowhere()
        return Line(b.point - height * plane._unit, b.axis) if abs(height) >= b.radius - touch else None
    return None


def _slice(plane: Plane, foot: FloatArray, depth: float, radius: float, touch: float) -> Geometry:
    """What a plane that enters a ball so deep shares with it."""
    if depth < -touch:
        return Nowhere()
    if depth <= touch:
        return Point(foot)
    return Disk(float(np.sqrt(depth * (2.0 * radius - depth))), foot, plane.normal)


def _of_box(box: Box, b: Geometry) -> Geometry | None:
    """What a box along the axes shares with another one, or with what is bounded by planes along the axes."""
    flat = isinstance(b, HalfSpace | Slab) and np.count_nonzero(b.normal) == 1
    if not (isinstance(b, Box) or flat):
        return None
    lower, upper = b._inside(box.lower, box.upper)
    if (lower > upper).any():
        return Nowhere()
    edges = [edge for edge in np.diag(upper - lower) if edge.any()]
    if len(edges) == box.dimension:
        return Box.between(lower, upper)
    if not np.isfinite([lower, upper]).all():
        return None
    if not edges:
        return Point(lower)
    return Segment(lower, upper) if len(edges) == 1 else Rectangle(lower, *edges)


def _of_layers(a: HalfSpace | Slab, b: HalfSpace | Slab) -> Geometry | None:
    """What half spaces and slabs with parallel planes share."""
    normal = unit(a.normal)
    if not parallel(normal, unit(b.normal)):
        return None
    (low, high), (other_low, other_high) = (_layer(shape, normal) for shape in (a, b))
    low, high = max(low, other_low), min(high, other_high)
    touch = margin(a, b)
    if low > high + touch:
        return Nowhere()
    if high - low <= touch:
        return Plane((low + high) / 2 * normal, normal)
    if np.isinf(low):
        return HalfSpace(high * normal, -normal)
    return HalfSpace(low * normal, normal) if np.isinf(high) else Slab(high - low, (low + high) / 2 * normal, normal)


def _layer(shape: HalfSpace | Slab, normal: FloatArray) -> Interval:
    """Heights along a normal between which a half space or slab lies."""
    if isinstance(shape, Slab):
        middle = float(shape.center @ normal)
        return middle - shape.thickness / 2, middle + shape.thickness / 2
    height = float(shape.point @ normal)
    return (height, np.inf) if shape.normal @ normal > 0.0 else (-np.inf, height)


def _of_round(a: Ball | Bar, middle: FloatArray, b: Geometry, axis: FloatArray | None) -> Geometry | None:
    """What a ball or bar shares with a shape that it is inside of, or touches, or does not reach."""
    if not isinstance(b, Ball | Bar | Slab | HalfSpace | Box):
        return None
    if axis is not None:  # as far from the other shape everywhere along the axis, or no rule tells
        alike = isinstance(b, Bar) and parallel(axis, b._unit)
        if not (alike or (isinstance(b, Slab | HalfSpace) and square(axis, unit(b.normal)))):
            return None
    touch = margin(a, b)
    away = float(b._distance(middle[None])[0])
    if away <= touch - a.radius:
        return a
    if away > a.radius + touch:
        return Nowhere()
    if away < a.radius - touch:
        return None
    place = b._projection(middle[None])[0]
    return Point(place) if axis is None else Line(place, axis)
