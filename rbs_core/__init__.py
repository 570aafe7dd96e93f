"""The kernel of RBS: coordinate systems, geometries, parts, relations and the analysis that runs them.

It knows no peridynamics: constitutive models, integrators, boundary domains and exporters are plugins.
"""

import os as _os

# Threads that wait for the next loop spin for about 0.1 ms and sleep then: to wake them takes as long, several times a
# step, and endless spinning on a busy machine slows every loop by milliseconds. (GNU's OpenMP; others sleep at once.)
_os.environ.setdefault("OMP_WAIT_POLICY", "passive")
_os.environ.setdefault("GOMP_SPINCOUNT", "5000")

from rbs_core.analysis import Analysis
from rbs_core.checkpoint import Checkpoint
from rbs_core.errors import (
    BadCheckpoint,
    BadInput,
    BadLaw,
    DishonestRelation,
    FieldClash,
    MissingField,
    NotConverged,
    NotFinite,
    RBSError,
    UndeclaredField,
    UnstableStep,
)
from rbs_core.fields import Field, intact, is_fictitious, reference_position, volume
from rbs_core.geometry import (
    Ball,
    Bar,
    Box,
    Capsule,
    Circle,
    Cone,
    Cuboid,
    Cylinder,
    Disk,
    Everywhere,
    Geometry,
    HalfSpace,
    Line,
    Nowhere,
    Plane,
    Point,
    Polygon,
    Prism,
    Pyramid,
    Ray,
    Rectangle,
    RegularPolygon,
    Ring,
    Segment,
    Slab,
    Status,
    Surface,
    SurfaceMesh,
    Tetrahedron,
    Torus,
    Triangle,
    TriangulatedSurface,
    Tube,
    Where,
)
from rbs_core.hookspecs import hookimpl
from rbs_core.part import Bonds, Connection, FictitiousLayer, Neighborhood, Node, Part
from rbs_core.plugins import registry
from rbs_core.relation import Relation
from rbs_core.report import Report, configure_logging
from rbs_core.roles import Boundary, Constitutive, Exporter, Integrator, Measure, Statics
from rbs_core.space import CoordinateSystem, convert, convert_vectors, grids, world
from rbs_core.trigger import Clock, Trigger, always, at, between, every, last, once, realtime

__version__ = "0.1.0"

__all__ = [
    "Analysis",
    "BadCheckpoint",
    "BadInput",
    "BadLaw",
    "Ball",
    "Bar",
    "Bonds",
    "Boundary",
    "Box",
    "Capsule",
    "Checkpoint",
    "Circle",
    "Clock",
    "Cone",
    "Connection",
    "Constitutive",
    "CoordinateSystem",
    "Cuboid",
    "Cylinder",
    "DishonestRelation",
    "Disk",
    "Everywhere",
    "Exporter",
    "FictitiousLayer",
    "Field",
    "FieldClash",
    "Geometry",
    "HalfSpace",
    "Integrator",
    "Line",
    "Measure",
    "MissingField",
    "Neighborhood",
    "Node",
    "NotConverged",
    "NotFinite",
    "Nowhere",
    "Part",
    "Plane",
    "Point",
    "Polygon",
    "Prism",
    "Pyramid",
    "RBSError",
    "Ray",
    "Rectangle",
    "RegularPolygon",
    "Relation",
    "Report",
    "Ring",
    "Segment",
    "Slab",
    "Statics",
    "Status",
    "Surface",
    "SurfaceMesh",
    "Tetrahedron",
    "Torus",
    "Triangle",
    "TriangulatedSurface",
    "Trigger",
    "Tube",
    "UndeclaredField",
    "UnstableStep",
    "Where",
    "always",
    "at",
    "between",
    "configure_logging",
    "convert",
    "convert_vectors",
    "every",
    "grids",
    "hookimpl",
    "intact",
    "is_fictitious",
    "last",
    "once",
    "realtime",
    "reference_position",
    "registry",
    "volume",
    "world",
]
