"""Triangulated surfaces: a closed one encloses a solid, any one cuts."""

from __future__ import annotations

from functools import cached_property
from hashlib import sha256
from os import PathLike
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry.base import TOLERANCE, Geometry
from rbs_core.geometry.described import row_tuples
from rbs_core.geometry.facets import Facets
from rbs_core.geometry.reading import read_triangles
from rbs_core.geometry.similarity import Similarity
from rbs_core.geometry.solid import Solid
from rbs_core.geometry.surfaces import Surface, tolerances
from rbs_core.geometry.triangles import require_no_crossing, require_one_side
from rbs_core.space.checks import BoolArray, Bounds, FloatArray

# More triangles than this are not written out by `repr`.
SHOWN = 64


class Triangulated(Geometry):
    """What a closed and an open surface of triangles share.

    Attributes:
        vertices: (m), shape (n, 3), read-only.
        triangles: indices of three vertices each, shape (m, 3), read-only.
    """

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None:
        self._facets = Facets(vertices, triangles)
        self.vertices, self.triangles = self._facets.vertices, self._facets.triangles
        used = self.vertices[np.unique(self.triangles)]
        self._bounds = used.min(axis=0), used.max(axis=0)
        self._size = float(np.linalg.norm(self._bounds[1] - self._bounds[0]))

    @classmethod
    def read(cls, path: str | PathLike[str], *, unit: float = 1.0, join: float = 0.0) -> Self:
        """The surface in a file: STL, PLY, OBJ, VTK, or another one that meshio reads; quadrilaterals are cut in two.

        Args:
            path: the file.
            unit: length of the unit of the file (m), such as 1e-3 for mm.
            join: vertices that are at most so far apart become one (m), for files whose digits are rounded; triangles
                that collapse by it are left out.

        Raises:
            BadInput: for a file that is missing, cannot be read, or holds other cells; and as the class.
        """
        vertices, triangles = read_triangles(path, unit, join)
        try:
            return cls(vertices, triangles)
        except BadInput as error:
            raise BadInput(f"{path}: {error}") from error

    @property
    def dimension(self) -> int:
        """3."""
        return 3

    @property
    def bounds(self) -> Bounds:
        """The box around the triangles."""
        return self._bounds[0].copy(), self._bounds[1].copy()

    @property
    def size(self) -> float:
        """The diagonal of the bounds."""
        return self._size

    def _projection(self, points: FloatArray) -> FloatArray:
        return self._facets.nearest(points)[1]

    def _reaches(self, direction: FloatArray) -> float:
        return float((self._facets.corners @ direction).max())

    def _transformed(self, by: Similarity) -> Geometry:
        triangles = self.triangles[:, ::-1] if by.mirrors else self.triangles
        return type(self)(by.points(self.vertices), triangles)

    def _parameters(self) -> dict[str, object]:
        return {"vertices": row_tuples(self.vertices), "triangles": tuple(map(tuple, self.triangles.tolist()))}

    @cached_property
    def _print(self) -> str:
        """Tells surfaces apart that are too large to be written out."""
        return sha256(self.vertices.tobytes() + self.triangles.tobytes()).hexdigest()[:12]

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self) or not isinstance(other, Triangulated):
            return NotImplemented
        return np.array_equal(self.vertices, other.vertices) and np.array_equal(self.triangles, other.triangles)

    def __hash__(self) -> int:
        return hash((type(self), self._print))

    def __repr__(self) -> str:
        if len(self.triangles) <= SHOWN:
            return super().__repr__()
        return f"<{type(self).__name__} of {len(self.triangles)} triangles, {self._print}>"


class SurfaceMesh(Triangulated, Solid):
    """What a closed surface of triangles encloses, such as the ones that CAD programs write: `SurfaceMesh.read(path)`.

    Several closed surfaces may be given at once: a cavity runs the other way around, and what two of them enclose
    counts once. `repr` writes out up to 64 triangles.

    Args:
        vertices: (m), shape (n, 3).
        triangles: indices of three vertices each, counterclockwise seen from outside, shape (m, 3).

    Attributes:
        volume: what it encloses (m^3).

    Raises:
        BadInput: for indices that do not exist, triangles without area, edges with one triangle or more than two,
            triangles that are turned over, and when the enclosed volume is zero or negative; the message names them.
    """

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None:
        super().__init__(vertices, triangles)
        require_one_side(self.vertices, self.triangles, closed=True)
        self.volume = self._facets.volume
        if abs(self.volume) <= TOLERANCE * self._size**3:
            raise BadInput(f"the surface encloses no volume ({self.volume:.3g} m^3); give one that encloses a solid")
        if self.volume < 0.0:
            raise BadInput(
                f"the surface encloses {self.volume:.6g} m^3: it is inside out; give triangles[:, ::-1], so that they "
                "run counterclockwise seen from outside"
            )

    def _contains(self, points: FloatArray) -> BoolArray:
        return (self._facets.winding(points) > 0) | self._facets.within(points, self._round_off(points))

    def _distance(self, points: FloatArray) -> FloatArray:
        away = self._facets.nearest(points)[0]
        return np.where(self._facets.winding(points) > 0, -away, away)


class TriangulatedSurface(Triangulated, Surface):
    """A surface of triangles that bonds can cross, open or closed.

    The rule of surfaces.py holds for each triangle. Nodes exactly on a fold are on the positive side of both faces, so
    they are cut off from what lies behind either. `repr` writes out up to 64 triangles.

    Args:
        vertices: (m), shape (n, 3).
        triangles: indices of three vertices each, counterclockwise seen from the positive side, shape (m, 3).

    Raises:
        BadInput: for indices that do not exist, triangles without area, edges with more than two triangles, triangles
            that are turned over, and triangles that pass through each other; the message names them.
    """

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None:
        super().__init__(vertices, triangles)
        require_one_side(self.vertices, self.triangles, closed=False)
        require_no_crossing(self.vertices, self.triangles, self._facets.tree)
        self._largest = float(np.abs(self.vertices).max())

    def _margins(self, starts: FloatArray, ends: FloatArray) -> FloatArray:
        return tolerances(starts, ends, self._size, self._largest)

    def _crosses(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        return self._facets.crossed(starts, ends, self._margins(starts, ends))

    def _distance(self, points: FloatArray) -> FloatArray:
        return self._facets.nearest(points)[0]
