"""A geometry moved by a vector, or placed by a coordinate system: turned, stretched, mirrored, sheared."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry.base import Geometry, coordinate_tuple, require_kind
from rbs_core.space.checks import BoolArray, Bounds, FloatArray, as_text, as_vector
from rbs_core.space.system import CoordinateSystem


class Moved(Geometry):
    """A geometry shifted by a vector; usually written `geometry.moved(vector)`.

    Args:
        geometry: what is shifted.
        vector: by how much (m), shape (d,).

    Raises:
        BadInput: for a vector of another dimension.
    """

    def __init__(self, geometry: Geometry, vector: ArrayLike) -> None:
        require_kind(geometry, Geometry, "geometry")
        self.geometry = geometry
        self.vector = as_vector(vector, "vector")
        if geometry.dimension not in (None, self.vector.size):
            raise BadInput(
                f"vector = {as_text(self.vector)} has {self.vector.size} components, but {geometry!r} has dimension "
                f"{geometry.dimension}; give {geometry.dimension} components"
            )

    @property
    def dimension(self) -> int:
        """Number of components of the vector."""
        return self.vector.size

    @property
    def bounds(self) -> Bounds:
        """Those of the geometry, shifted."""
        lower, upper = self.geometry.bounds
        return lower + self.vector, upper + self.vector

    def _contains(self, points: FloatArray) -> BoolArray:
        return self.geometry._contains(points - self.vector)

    def _distance(self, points: FloatArray) -> FloatArray:
        return self.geometry._distance(points - self.vector)

    def _parameters(self) -> dict[str, object]:
        return {"geometry": self.geometry, "vector": coordinate_tuple(self.vector)}

    def __repr__(self) -> str:
        return f"{self.geometry!r}.moved({as_text(self.vector)})"


class Placed(Geometry):
    """A geometry whose numbers are coordinates of a system, as a geometry in coordinates of the system's parent.

    Usually written `geometry.placed(system)`. When the system moves, the geometry moves with it. A ball in a system
    with stretched axes is an ellipsoid, a box in a cylindrical one is a sector of a tube. Angles of a geometry may
    start anywhere, such as 0 to 2 pi or -pi to pi, but span one turn at most. Two are equal when the geometry is equal
    and the system is the same one.

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
        """A box around the image of the geometry's own bounds; infinite where the system does not know one."""
        lower, upper = self.geometry.bounds
        mapping, dimension = self.system.mapping, self.geometry.dimension
        if dimension is None or mapping is None or not (lower <= upper).all():
            return lower, upper  # everything, or nothing: it stays so wherever it is placed
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

    def _distance(self, points: FloatArray) -> FloatArray:
        mapping = self.system.mapping
        factor = 0.0 if mapping is None else mapping.least_stretch(points.shape[1])
        if factor == 0.0:
            raise BadInput(f"{self!r} knows no distance: {mapping!r} keeps no lengths; use only contains()")
        return self.geometry._distance(self._own(points)) * factor

    def _parameters(self) -> dict[str, object]:
        return {"geometry": self.geometry, "system": self.system}

    def __repr__(self) -> str:
        return f"{self.geometry!r}.placed({self.system!r})"
