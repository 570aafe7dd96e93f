"""Grids: points with the exact volumes of their cells, from which a part takes its nodes.

`part.discretize(grids.ball(0.01, spacing=0.001))`. Each kind can be restricted by `where`, and most be made anew by
`extruded`, `placed` and `jittered`.
"""

from __future__ import annotations

from rbs_core.space.grids.axis import Axis, edges
from rbs_core.space.grids.balls import ball, shell, spherical
from rbs_core.space.grids.cells import Cells, Cloud
from rbs_core.space.grids.jitter import jittered
from rbs_core.space.grids.polar import cylinder, disk, polar, ring, tube
from rbs_core.space.grids.product import Graded, Product, graded
from rbs_core.space.grids.regular import Grid, rotated, uniform

__all__ = [
    "Axis",
    "Cells",
    "Cloud",
    "Graded",
    "Grid",
    "Product",
    "ball",
    "cylinder",
    "disk",
    "edges",
    "graded",
    "jittered",
    "polar",
    "ring",
    "rotated",
    "shell",
    "spherical",
    "tube",
    "uniform",
]
