"""Small meshes, of every kind of cells."""

from __future__ import annotations

from itertools import product

import meshio
import numpy as np

# Corners of one cell of each kind, with its measure and centroid, computed by hand.
CELLS = {
    "line": ([[1.0], [3.0]], 2.0, [2.0]),
    "triangle": ([[0, 0], [3, 0], [0, 3]], 4.5, [1, 1]),
    "quad": ([[0, 0], [2, 0], [2, 1], [0, 1]], 2.0, [1.0, 0.5]),
    "tetra": ([[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]], 64 / 6, [1, 1, 1]),
    "pyramid": ([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 1, 3]], 4.0, [1, 1, 0.75]),
    "wedge": ([[0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 2], [3, 0, 2], [0, 3, 2]], 9.0, [1, 1, 1]),
    "hexahedron": (
        [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0, 0, 3], [2, 0, 3], [2, 1, 3], [0, 1, 3]], 6.0, [1, 0.5, 1.5],
    ),
}  # fmt: skip
SECOND = {
    "line": ["line3"],
    "triangle": ["triangle6", "triangle7"],
    "quad": ["quad8", "quad9"],
    "tetra": ["tetra10"],
    "pyramid": ["pyramid13", "pyramid14"],
    "wedge": ["wedge15", "wedge18"],
    "hexahedron": ["hexahedron20", "hexahedron27"],
}


def one_cell(kind: str) -> meshio.Mesh:
    """A mesh of one cell of `CELLS`."""
    points = np.array(CELLS[kind][0], float)
    return meshio.Mesh(np.pad(points, ((0, 0), (0, 3 - points.shape[1]))), [(kind, [list(range(len(points)))])])


def block(nx: int = 2, ny: int = 2, nz: int = 2, **sets) -> meshio.Mesh:
    """Unit cubes (squares if nz is 0), x fastest."""
    axes = [np.arange(n + 1.0) for n in (nx, ny, nz)]
    points = np.array([p[::-1] for p in product(*axes[::-1])])

    def number(i, j, k):
        return i + (nx + 1) * (j + (ny + 1) * k)

    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    cells = [
        [number(i + a, j + b, k + c) for c in ((0, 1) if nz else (0,)) for a, b in square]
        for k, j, i in product(range(max(nz, 1)), range(ny), range(nx))
    ]
    return meshio.Mesh(points, [("hexahedron" if nz else "quad", np.array(cells))], **sets)
