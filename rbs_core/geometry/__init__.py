"""Which points are in, and which bonds are cut."""

from __future__ import annotations

from rbs_core.geometry.base import Geometry, Status
from rbs_core.geometry.box import Box, Cuboid
from rbs_core.geometry.combined import Combined, Complement
from rbs_core.geometry.cropped import Cropped
from rbs_core.geometry.flat import Circle, Disk, Ring
from rbs_core.geometry.mesh import SurfaceMesh, TriangulatedSurface
from rbs_core.geometry.placed import Placed, Transformed
from rbs_core.geometry.planes import Plane, Point
from rbs_core.geometry.polygon import Polygon, Rectangle, RegularPolygon, Triangle
from rbs_core.geometry.polyhedra import Prism, Pyramid, Tetrahedron
from rbs_core.geometry.primitives import Ball, Bar, HalfSpace, Slab
from rbs_core.geometry.revolved import Capsule, Cone, Cylinder, Torus, Tube
from rbs_core.geometry.solid import Solid
from rbs_core.geometry.straight import Line, Ray, Segment
from rbs_core.geometry.surfaces import Surface, Surfaces
from rbs_core.geometry.whole import Everywhere, Nowhere, Where

__all__ = [
    "Ball",
    "Bar",
    "Box",
    "Capsule",
    "Circle",
    "Combined",
    "Complement",
    "Cone",
    "Cropped",
    "Cuboid",
    "Cylinder",
    "Disk",
    "Everywhere",
    "Geometry",
    "HalfSpace",
    "Line",
    "Nowhere",
    "Placed",
    "Plane",
    "Point",
    "Polygon",
    "Prism",
    "Pyramid",
    "Ray",
    "Rectangle",
    "RegularPolygon",
    "Ring",
    "Segment",
    "Slab",
    "Solid",
    "Status",
    "Surface",
    "SurfaceMesh",
    "Surfaces",
    "Tetrahedron",
    "Torus",
    "Transformed",
    "Triangle",
    "TriangulatedSurface",
    "Tube",
    "Where",
]
