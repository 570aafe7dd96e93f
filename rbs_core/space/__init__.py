"""Where points live: coordinate systems, the way between them, and grids."""

from __future__ import annotations

from rbs_core.space import grids
from rbs_core.space.convert import convert, convert_vectors
from rbs_core.space.curved import Cylindrical, Spherical
from rbs_core.space.custom import Custom
from rbs_core.space.grids import Cells, Grid, uniform
from rbs_core.space.mapping import Cartesian, Mapping
from rbs_core.space.system import CoordinateSystem, world

__all__ = [
    "Cartesian",
    "Cells",
    "CoordinateSystem",
    "Custom",
    "Cylindrical",
    "Grid",
    "Mapping",
    "Spherical",
    "convert",
    "convert_vectors",
    "grids",
    "uniform",
    "world",
]
