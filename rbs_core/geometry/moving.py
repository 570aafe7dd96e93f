"""Shifts, turns, mirror images and changes of size: every one gives a new shape, the old one stays as it is."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.geometry import similarity as similar
from rbs_core.geometry.described import Described
from rbs_core.geometry.similarity import Similarity
from rbs_core.space.checks import as_text
from rbs_core.space.system import CoordinateSystem

if TYPE_CHECKING:
    from rbs_core.geometry.base import Geometry
    from rbs_core.geometry.placed import Placed


class Movable(Described):
    """What can be put somewhere else; the part of a geometry that does so.

    A subclass says in `_kinds` what its parameters mean (see `Similarity.image`), if a similarity can change them.
    """

    _kinds: dict[str, str] = {}

    @property
    def _itself(self) -> Geometry:
        return cast("Geometry", self)  # nothing else derives from Movable

    def moved(self, vector: ArrayLike) -> Geometry:
        """The same shape, shifted by a vector (m), shape (d,)."""
        by = similar.shift(vector)
        if self.dimension not in (None, by.dimension):
            raise BadInput(
                f"vector = {as_text(by.shift)} has {by.dimension} components, but {self!r} has dimension "
                f"{self.dimension}; give {self.dimension} components"
            )
        return self._transformed(by)

    def rotated(self, angle: float, axis: ArrayLike | None = None, center: ArrayLike | None = None) -> Geometry:
        """The same shape, turned counterclockwise: about a point in 2-D, about an axis in 3-D.

        Args:
            angle: (rad); quarter turns are exact.
            axis: direction of the axis, shape (3,), in 3-D alone; the turn is counterclockwise seen against it.
            center: a point that stays where it is (m), shape (d,); the origin if None.

        Raises:
            BadInput: in 1-D, for an axis in 2-D and none in 3-D, and for an axis without length.
        """
        return self._transformed(similar.rotation(angle, axis, center, self.dimension))

    def mirrored(self, point: ArrayLike, normal: ArrayLike) -> Geometry:
        """The mirror image at a plane (a line in 2-D, a point in 1-D).

        Args:
            point: any point of the plane (m), shape (d,), or one number for all components.
            normal: vector of any length but 0, at right angles to the plane, shape (d,).

        Raises:
            BadInput: for a normal without length, and for another dimension.
        """
        image = similar.mirror(point, normal)
        self._require_dimension(image.dimension, "normal")
        return self._transformed(image)

    def scaled(self, factor: float, center: ArrayLike | None = None) -> Geometry:
        """The same shape in another size.

        Args:
            factor: by which lengths grow, positive.
            center: the point that stays where it is (m), shape (d,); the origin if None.

        Raises:
            BadInput: for a factor that is not positive, and when neither the geometry nor a center tells the dimension.
        """
        dimension = self.dimension if center is None or self.dimension is not None else np.size(center)
        if dimension is None:
            raise BadInput(f"{self!r} works in any dimension; give a center, which tells the dimension")
        return self._transformed(similar.scaling(factor, center, dimension))

    def placed(self, system: CoordinateSystem) -> Placed:
        """This shape, its numbers understood in `system`, as a geometry in coordinates of the parent of `system`."""
        from rbs_core.geometry.placed import Placed

        return Placed(self._itself, system)

    def _transformed(self, by: Similarity) -> Geometry:
        """The image: of the same kind where the parameters can follow, otherwise wrapped."""
        from rbs_core.geometry.placed import Transformed

        shape = self._itself
        if not self._kinds:
            return Transformed(shape, by.turn, by.factor, by.shift)
        images = {name: by.image(value, self._kinds[name]) for name, value in self._parameters().items()}
        return type(shape)(**images)
