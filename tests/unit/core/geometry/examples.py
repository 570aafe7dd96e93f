"""One or more examples of every geometry, with the length, area or volume that they enclose where it is finite."""

from __future__ import annotations

import numpy as np

from rbs_core.geometry import (
    Ball,
    Bar,
    Box,
    Capsule,
    Circle,
    Combined,
    Complement,
    Cone,
    Cropped,
    Cuboid,
    Cylinder,
    Disk,
    Everywhere,
    Geometry,
    HalfSpace,
    Line,
    Nowhere,
    Placed,
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
    SurfaceMesh,
    Surfaces,
    Tetrahedron,
    Torus,
    Transformed,
    Triangle,
    TriangulatedSurface,
    Tube,
    Where,
)
from rbs_core.space import uniform, world


def above_parabola(points):
    return points[:, 1] > points[:, 0] ** 2


STRETCHED = world.child("stretched", (0.1, 0.2, 0.0), [(1.5, 0.2, 0.0), (-0.1, 0.7, 0.0), (0.0, 0.3, 1.0)])
TURNED = world.child("turned", (0.1, 0.2, 0.0), [(0.6, 0.8, 0.0), (-0.8, 0.6, 0.0), (0.0, 0.0, 1.0)])

L_SHAPE = np.array([(0.0, 0.0), (1.2, 0.0), (1.2, 0.5), (0.5, 0.5), (0.5, 1.1), (0.0, 1.1)])
L_AREA = 1.2 * 0.5 + 0.5 * 0.6
OCTAHEDRON = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]) * 0.9
FACES = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]


def in_space(corners: np.ndarray) -> np.ndarray:
    """Corners of a plane figure in a tilted plane in space."""
    return np.array([0.1, -0.2, 0.3]) + corners @ np.array([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0]])


TRIANGLE_3D = Triangle(*in_space(L_SHAPE[[0, 1, 5]]))
L_3D = Polygon(in_space(L_SHAPE))

# Solids and regions with what they enclose.
FILLED: list[tuple[Geometry, float]] = [
    (Ball(0.7, 0.3), 1.4),
    (Ball(0.7, (0.3, -0.1)), np.pi * 0.49),
    (Ball(0.7, (0.3, -0.1, 0.2)), 4 / 3 * np.pi * 0.343),
    (Box(1.3, 0.2), 1.3),
    (Box((1.3, 0.7), (0.1, 0.2)), 0.91),
    (Box.between((-0.5, -0.4, 0.1), (0.6, 0.3, 0.9)), 1.1 * 0.7 * 0.8),
    (Slab(0.8, 0.3, -2.0), 0.8),
    (Cuboid((0.1, 0.0, -0.2), (0.6, 0.0, 0.8), (0.0, 1.2, 0.0), (-0.4, 0.0, 0.3)), 1.0 * 1.2 * 0.5),
    (Rectangle((0.1, -0.2), (0.6, 0.8), (-0.4, 0.3)), 0.5),
    (Triangle((0.0, 0.0), (1.5, 0.2), (0.3, 1.1)), 0.5 * (1.5 * 1.1 - 0.2 * 0.3)),
    (Polygon(L_SHAPE), L_AREA),
    (Polygon(L_SHAPE[::-1]), L_AREA),
    (RegularPolygon(5, (0.1, 0.2), (0.9, 0.3)), 2.5 * 0.65 * np.sin(0.4 * np.pi)),
    (Disk(0.8, (0.1, 0.2)), np.pi * 0.64),
    (Ring(0.9, 0.4, (0.1, 0.2)), np.pi * (0.81 - 0.16)),
    (Capsule(0.3, (-0.2, 0.1), (0.5, 0.4)), np.pi * 0.09 + 0.6 * np.hypot(0.7, 0.3)),
    (Capsule(0.3, (-0.2, 0.1, 0.0), (0.4, 0.4, 0.6)), np.pi * 0.09 * (0.9 + 0.4)),
    (Cylinder(0.5, (0.0, 0.1, -0.4), (0.6, 0.1, 0.4)), np.pi * 0.25),
    (Tube(0.7, 0.4, (0.0, 0.1, -0.4), (0.6, 0.1, 0.4)), np.pi * 0.33),
    (Cone(0.6, (0.0, 0.1, -0.4), (0.6, 0.1, 0.4)), np.pi * 0.36 / 3),
    (Cone(0.6, (0.0, 0.1, -0.4), (0.6, 0.1, 0.4), top=0.3), np.pi * (0.36 + 0.18 + 0.09) / 3),
    (Torus(0.7, 0.25, (0.1, 0.0, 0.2), (1.0, 2.0, 2.0)), 2 * np.pi**2 * 0.7 * 0.0625),
    (Prism(L_3D, (-0.8, 0.2, 0.6)), L_AREA),
    (Prism(Polygon(in_space(L_SHAPE)[::-1]), (-0.8, 0.2, 0.6)), L_AREA),
    (Prism(RegularPolygon(6, (0, 0, 0), (0.6, 0, 0), (0, 0, 1)), (0, 0, 0.7)), 1.5 * np.sqrt(3) * 0.36 * 0.7),
    (Pyramid(L_3D, in_space(L_SHAPE)[0] + np.array((-0.8, 0.2, 0.6))), L_AREA / 3),
    (Tetrahedron((0, 0, 0), (1.1, 0, 0.1), (0.2, 1.2, 0), (0.1, 0.3, 1.0)), 1.2780 / 6),
    (SurfaceMesh(OCTAHEDRON, FACES), 4 / 3 * 0.729),
    (Ball(0.8, (0.0, 0.0)) - Box(0.5, (0.0, 0.0)), np.pi * 0.64 - 0.25),
    (Combined("symmetric difference", Box((1.0, 1.0)), Box((1.0, 1.0), (0.5, 0.0))), 1.0),
    (Box(1.2, (0, 0, 0)) & HalfSpace((0.0, 0.0, 0.0), (1.0, 2.0, 2.0)), 1.2**3 / 2),
    (Box((1.2, 0.6)).placed(TURNED), 0.72),
    (Ball(0.8, (0.0, 0.0)).placed(STRETCHED), np.pi * 0.64 * (1.5 * 0.7 + 0.1 * 0.2)),
    (Transformed(Box((1.2, 0.6)), [[0.6, -0.8], [0.8, 0.6]], 0.5, (0.1, 0.2)), 0.18),
    (Combined("intersection", Where(above_parabola), Box.between((-1, 0), (1, 1))), 4 / 3),
]

# Lines and faces: sets of points without an inside.
THIN: list[Geometry] = [
    Point(0.25),
    Point((0.25, -0.5)),
    Point((0.25, -0.5, 0.125)),
    Segment((-0.4, -0.3), (0.6, 0.5)),
    Segment((-0.4, -0.3, 0.1), (0.6, 0.5, 0.2)),
    Ray((0.1, 0.2), (-3.0, 1.0)),
    Ray((0.1, 0.2, 0.0), (0.0, 0.0, -2.0)),
    Line((0.1, 0.2), (1.0, 2.0)),
    Line((0.1, 0.2, 0.3), (1.0, 2.0, -1.0)),
    Plane(0.3, -1.0),
    Plane((0.1, 0.2), (1.0, 2.0)),
    Plane((0.1, 0.2, 0.3), (0.0, 0.0, -1.0)),
    Circle(0.6, (0.1, 0.2)),
    Circle(0.6, (0.1, 0.2, 0.3), (1.0, 0.0, 2.0)),
    Disk(0.8, (0.1, 0.2, 0.3), (1.0, 0.0, 2.0)),
    Ring(0.8, 0.3, (0.1, 0.2, 0.3), (0.0, 0.0, 2.0)),
    L_3D,
    TRIANGLE_3D,
    Rectangle((0.1, 0.0, -0.2), (0.6, 0.0, 0.8), (0.0, 1.2, 0.0)),
    RegularPolygon(6, (0.1, 0.2, 0.3), (0.9, 0.2, 0.3), (0.0, 1.0, 1.0)),
    TriangulatedSurface(OCTAHEDRON, FACES[:5]),
    Surfaces(Segment((0.0, 0.0), (0.5, 0.0)), Segment((0.5, 0.0), (0.5, 0.8))),
    Cropped(Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), Ball(0.7, (0.0, 0.0, 0.2))),
    Segment((-1.0, 0.1), (1.0, 0.1)) - Ball(0.4, (0.0, 0.0)),
]

# Without bounds, or without points.
INFINITE: list[Geometry] = [
    HalfSpace(0.3, 1.0),
    HalfSpace((0.1, 0.2), (1.0, 2.0)),
    HalfSpace((0.1, 0.2, 0.3), (0.0, -2.0, 0.0)),
    Slab(0.6, (0.1, 0.2), (1.0, 2.0)),
    Slab(0.6, (0.1, 0.2, 0.3), (0.0, 0.0, 1.0)),
    Bar(0.4, (0.1, 0.2), (1.0, 2.0)),
    Bar(0.4, (0.1, 0.2, 0.3), (1.0, 2.0, 2.0)),
    Bar(0.4, (0.1, 0.2, 0.3), (0.0, 0.0, 1.0)),
    Box((np.inf, 0.8), (0.0, 0.1)),
    Box.between((0.1, -np.inf, -0.5), (np.inf, np.inf, 0.5)),
    Complement(Ball(0.6, (0.1, 0.2))),
    Everywhere(),
    Nowhere(),
]

EXAMPLES: list[Geometry] = [*(geometry for geometry, _ in FILLED), *THIN, *INFINITE]
MEASURING = [geometry for geometry in EXAMPLES if "Where" not in repr(geometry)]  # those that know a distance
WITH_SURFACE = [geometry for geometry in MEASURING if not isinstance(geometry, Everywhere | Nowhere)]
KINDS = {type(geometry) for geometry in EXAMPLES} | {Where, Placed}


def counting_error(geometry: Geometry, exact: float, spacing: float, rng: np.random.Generator) -> float:
    """Relative error of the size by counted cells: root mean square over four grids that begin anywhere."""
    lower, upper = geometry.bounds
    errors = []
    for _ in range(4):
        start = lower - spacing * rng.uniform(0.0, 1.0, lower.size)
        cells = np.ceil((upper - start) / spacing)
        grid = uniform(start, start + spacing * cells, spacing)
        errors.append(geometry.contains(grid.points()).sum() * grid.cell_volume() / exact - 1.0)
    return float(np.sqrt(np.mean(np.square(errors))))


def cloud(geometry: Geometry, count: int = 400, seed: int = 7) -> np.ndarray:
    """Points in and around an example; half of them are multiples of 1/8 and often exactly on a surface."""
    dimension = geometry.dimension or 2
    points = np.random.default_rng(seed).uniform(-1.6, 1.6, (count, dimension))
    points[::2] = np.round(8 * points[::2]) / 8
    return points


def measured(geometry: Geometry, spacing: float) -> float:
    """Length, area or volume by counting the cells whose middle is in."""
    lower, upper = geometry.bounds
    finite = np.isfinite([lower, upper]).all()
    lower, upper = (lower, upper) if finite else (np.full(lower.size, -1.7), np.full(lower.size, 1.7))
    grid = uniform(lower - 0.013, upper + 0.007, spacing)
    return geometry.contains(grid.points()).sum() * grid.cell_volume()
