"""Where points live: coordinate systems, the way between them, and grids."""

from __future__ import annotations

from rbs_core.space.convert import Cartesian, Mapping
from rbs_core.space.grid import Grid, uniform
from rbs_core.space.system import CoordinateSystem, convert, world

__all__ = ["Cartesian", "CoordinateSystem", "Grid", "Mapping", "convert", "uniform", "world"]
