"""Which points are in, and which bonds are cut."""

from __future__ import annotations

from rbs_core.geometry.base import Geometry
from rbs_core.geometry.combined import Combined, Complement
from rbs_core.geometry.placed import Moved, Placed
from rbs_core.geometry.polygon import Polygon
from rbs_core.geometry.primitives import Ball, Box, Everywhere, HalfSpace, Nowhere, Where
from rbs_core.geometry.surfaces import Point, Segment, Surface, Surfaces

__all__ = [
    "Ball",
    "Box",
    "Combined",
    "Complement",
    "Everywhere",
    "Geometry",
    "HalfSpace",
    "Moved",
    "Nowhere",
    "Placed",
    "Point",
    "Polygon",
    "Segment",
    "Surface",
    "Surfaces",
    "Where",
]
