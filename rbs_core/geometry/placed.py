"""Geometries whose coordinates are taken elsewhere first: by a similarity, or by a coordinate system."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput
from rbs_core.geometry.base import Geometry
from rbs_core.geometry.described import coordinate_tuple, require_kind, row_tuples
from rbs_core.geometry.similarity import Similarity
from rbs_core.space.checks import BoolArray, Bounds, FloatArray, as_text
from rbs_core.space.mapping import Cartesian
from rbs_core.space.system import CoordinateSystem


class Transformed(Geometry):
    """A geometry after a similarity: x -> factor turn x + shift. Its distance is as exact as that of the geometry.

    What `moved`, `rotated`, `mirrored` and `scaled` give where the parameters of a geometry cannot follow, such as
    those of `Where`.

    Args:
        geometry: what is moved.
        turn: rotation or mirror image, an orthogonal matrix (d, d).
        factor: by which lengths grow, positive.
        shift: (m), shape (d,).

    Raises:
        BadInput: for a matrix that is not orthogonal, a factor that is not positive, and another dimension.
    """

    def __init__(self, geometry: Geometry, turn: ArrayLike, factor: float, shift: ArrayLike) -> None:
        require_kind(geometry, Geometry, "geometry")
        self.geometry = geometry
        self.similarity = Similarity(turn, factor, shift)
        if geometry.dimension not in (None, self.similarity.dimension):
            raise BadInput(
                f"shift = {as_text(self.similarity.shift)} has {self.similarity.dimension} components, but "
                f"{geometry!r} has dimension {geometry.dimension}; give {geometry.dimension}"
            )

    @property
    def dimension(self) -> int:
        """Number of components of the shift."""
        return self.similarity.dimension

    @property
    def bounds(self) -> Bounds:
        """As small a box as the geometry tells."""
        return _hull(self.geometry, self.similarity.factor * self.similarity.turn, self.similarity.shift)

    @property
    def size(self) -> float:
        """That of the geometry, times the factor."""
        return self.similarity.factor * self.geometry.size

    def _contains(self, points: FloatArray) -> BoolArray:
        return self.geometry._contains(self.similarity.back(points))

    def _distance(self, points: FloatArray) -> FloatArray:
        return self.similarity.factor * self.geometry._distance(self.similarity.back(points))

    def _status(self, points: FloatArray, tolerance: FloatArray) -> NDArray[np.int8]:
        return self.geometry._status(self.similarity.back(points), tolerance / self.similarity.factor)

    def _projection(self, points: FloatArray) -> FloatArray:
        return self.similarity.points(self.geometry._projection(self.similarity.back(points)))

    def _reaches(self, direction: FloatArray) -> float:
        own = self.similarity.factor * (direction @ self.similarity.turn)
        return float(self.similarity.shift @ direction) + self.geometry._reaches(own)

    def _transformed(self, by: Similarity) -> Geometry:
        both = by.after(self.similarity)
        return Transformed(self.geometry, both.turn, both.factor, both.shift)

    def _parameters(self) -> dict[str, object]:
        by = self.similarity
        shift = coordinate_tuple(by.shift)
        return {"geometry": self.geometry, "turn": row_tuples(by.turn), "factor": by.factor, "shift": shift}

    def __repr__(self) -> str:
        if self.similarity.straight and self.similarity.factor == 1.0:
            return f"{self.geometry!r}.moved({as_text(self.similarity.shift)})"
        return super().__repr__()


class Placed(Geometry):
    """A geometry whose numbers are coordinates of a system, as a geometry in coordinates of the system's parent.

    Usually written `geometry.placed(system)`. When the system moves, the geometry moves with it. A ball in a system
    with stretched axes is an ellipsoid, a box in a cylindrical one is a sector of a tube. Angles of a geometry may
    start anywhere, such as 0 to 2 pi or -pi to pi, but span one turn at most. Two are equal when the geometry is equal
    and the system is the same one. Where the system keeps no lengths, `status` measures its tolerance in coordinates of
    the system.

    Args:
        geometry: what is placed.
        system: where; not a root.

    Raises:
        BadInput: for a root; in `contains` and `distance` when points in 1-D or 2-D leave their line or plane on the
            way to the system.
    """

    def __init__(self, geometry: Geometry, system: CoordinateSystem) -> None:
        require_kind(geometry, Geometry, "geometry")
        if not isinstance(system, CoordinateSystem):
            raise BadInput(f"system = {system!r} is no CoordinateSystem; make one by world.child(name, ...)")
        if system.parent is None:
            raise BadInput(f"system {system.name!r} is a root; place the geometry in a child of it, or use it as it is")
        self.geometry = geometry
        self.system = system

    @property
    def dimension(self) -> int | None:
        """That of the geometry."""
        return self.geometry.dimension

    @property
    def bounds(self) -> Bounds:
        """As small a box as the geometry tells in a Cartesian system; otherwise what the mapping makes of it."""
        lower, upper = self.geometry.bounds
        mapping, dimension = self.system.mapping, self.geometry.dimension
        if dimension is None or mapping is None or not (lower <= upper).all():
            return lower, upper  # everything, or nothing: it stays so wherever it is placed
        if isinstance(mapping, Cartesian):
            return _hull(self.geometry, mapping.axes[:dimension, :dimension].T, mapping.origin[:dimension])
        low, high = np.zeros(3), np.zeros(3)
        low[:dimension], high[:dimension] = lower, upper
        low, high = mapping.bounds_to_parent(low, high)
        return low[:dimension], high[:dimension]

    def _contains(self, points: FloatArray) -> BoolArray:
        return self.geometry._contains(self._own(points))

    def _own(self, points: FloatArray) -> FloatArray:
        """Points in coordinates of the system; of all angles that mean the same, those the geometry speaks of."""
        lower, upper = self.geometry.bounds
        finite = np.isfinite(lower) & np.isfinite(upper)
        middle = np.full(lower.size, np.nan)
        middle[finite] = (lower[finite] + upper[finite]) / 2
        own = self.system.from_parent(points)
        return self.system.placement()[0].near(own, np.broadcast_to(middle, points.shape[1]))

    def _stretch(self, dimension: int) -> float:
        """Smallest factor by which a length grows on its way out of the system, 0 where none is known."""
        return 0.0 if self.system.mapping is None else self.system.mapping.least_stretch(dimension)

    def _distance(self, points: FloatArray) -> FloatArray:
        factor = self._stretch(points.shape[1])
        if factor == 0.0:
            raise BadInput(f"{self!r} knows no distance: {self.system.mapping!r} keeps no lengths; use only contains()")
        return self.geometry._distance(self._own(points)) * factor

    def _status(self, points: FloatArray, tolerance: FloatArray) -> NDArray[np.int8]:
        return self.geometry._status(self._own(points), tolerance / (self._stretch(points.shape[1]) or 1.0))

    def _projection(self, points: FloatArray) -> FloatArray:
        mapping, dimension = self.system.mapping, points.shape[1]
        if isinstance(mapping, Cartesian) and _keeps_angles(mapping.axes[:dimension, :dimension]):
            return self.system.to_parent(self.geometry._projection(self.system.from_parent(points)))
        return super()._projection(points)

    def _parameters(self) -> dict[str, object]:
        return {"geometry": self.geometry, "system": self.system}

    def __repr__(self) -> str:
        return f"{self.geometry!r}.placed({self.system!r})"


def _hull(geometry: Geometry, matrix: FloatArray, shift: FloatArray) -> Bounds:
    """Bounds of a geometry after x -> matrix x + shift, by how far it reaches along the rows of the matrix."""
    lower, upper = geometry.bounds
    if not (lower <= upper).all():
        return lower, upper
    upper = np.array([geometry._reaches(row) if row.any() else 0.0 for row in matrix])
    lower = np.array([-geometry._reaches(-row) if row.any() else 0.0 for row in matrix])
    return shift + lower, shift + upper


def _keeps_angles(axes: FloatArray) -> bool:
    """Whether axes are at right angles and of one length."""
    products = axes @ axes.T
    return bool(np.abs(products - products[0, 0] * np.eye(len(axes))).max() <= 1e-12 * products[0, 0])
