"""The projection of one single shape on another, where it is a single shape again."""

from __future__ import annotations

import numpy as np

from rbs_core.geometry.base import Geometry
from rbs_core.geometry.box import Box
from rbs_core.geometry.described import common_dimension, require_kind
from rbs_core.geometry.flat import Circle, Disk, Flat, Ring
from rbs_core.geometry.frames import parallel, square, unit
from rbs_core.geometry.meeting import piece_of
from rbs_core.geometry.planes import Plane, Point
from rbs_core.geometry.polygon import Polygon
from rbs_core.geometry.primitives import Ball, Bar, HalfSpace, Slab
from rbs_core.geometry.solid import Solid
from rbs_core.geometry.straight import Line, Ray, Segment, Straight
from rbs_core.geometry.whole import Everywhere, Nowhere


def projection(a: Geometry, on: Geometry) -> Geometry:
    """The points of `on` nearest to those of `a`, as a single shape; `Nowhere()` where no single shape describes them.

    Args:
        a: a single shape.
        on: point, line, ray, segment or plane; for a point, any shape with a surface.

    Raises:
        BadInput: for something that is no geometry, and for different dimensions.
    """
    require_kind(on, Geometry, "on")
    common_dimension(a, on)
    if isinstance(a, Nowhere) or isinstance(on, Nowhere | Everywhere):
        return Nowhere()
    if isinstance(a, Point):
        return Point(on._projection(a.x[None])[0])
    if isinstance(on, Point) or isinstance(a, Everywhere):
        return on if isinstance(on, Point | Straight | Plane) else Nowhere()
    if isinstance(on, Plane) and on.dimension == 2:
        on = Line(on.point, (-on.normal[1], on.normal[0]))
    if isinstance(on, Straight):
        return _on_straight(a, on)
    if isinstance(on, Plane):
        return Point(on.point) if on.dimension == 1 else _on_plane(a, on)
    return Nowhere()


def _on_straight(a: Geometry, line: Straight) -> Geometry:
    """Between the ends of a connected shape, seen along the line; beyond the end of the line it is the end."""
    if not isinstance(a, Straight | Flat | Plane | HalfSpace | Box | Solid):
        return Nowhere()
    start = float(line._middle @ line._along)
    low, high = -a._reaches(-line._along) - start, a._reaches(line._along) - start
    least, most = line._limits
    return piece_of(line, float(np.clip(low, least, most)), float(np.clip(high, least, most)))


def _on_plane(a: Geometry, plane: Plane) -> Geometry:
    """On a plane in 3-D."""
    normal = plane._unit
    if isinstance(a, Straight):
        return _straight_on_plane(a, plane)
    if isinstance(a, Plane):
        if not square(normal, a._unit):
            return plane
        return Line(plane._projection(a.point[None])[0], np.cross(normal, a._unit))
    if isinstance(a, HalfSpace | Slab):
        return Nowhere() if square(normal, unit(a.normal)) else plane
    if isinstance(a, Ball):
        return Disk(a.radius, plane._projection(a.center[None])[0], plane.normal)
    if isinstance(a, Bar) and parallel(normal, a._unit):
        return Disk(a.radius, plane._projection(a.point[None])[0], plane.normal)
    if isinstance(a, Flat):
        return _flat_on_plane(a, plane)
    return Nowhere()


def _straight_on_plane(a: Straight, plane: Plane) -> Geometry:
    middle = plane._projection(a._middle[None])[0]
    if parallel(a._along, plane._unit):
        return Point(middle)
    along = a._along - (a._along @ plane._unit) * plane._unit
    if isinstance(a, Segment):
        return Segment(*plane._projection(np.array([a.start, a.end])))
    return Ray(middle, along) if isinstance(a, Ray) else Line(middle, along)


def _flat_on_plane(a: Flat, plane: Plane) -> Geometry:
    if square(a._normal, plane._unit):  # seen from the side
        edge = Line(plane._projection(a._middle[None])[0], np.cross(plane._unit, a._normal))
        return _on_straight(a, edge)
    if isinstance(a, Polygon):
        return Polygon(plane._projection(a.points))
    if not parallel(a._normal, plane._unit):
        return Nowhere()
    center = plane._projection(a._middle[None])[0]
    if isinstance(a, Ring):
        return Ring(a.outer, a.inner, center, plane.normal)
    if isinstance(a, Circle):
        return Circle(a.radius, center, plane.normal)
    return Disk(a.radius, center, plane.normal) if isinstance(a, Disk) else Nowhere()
