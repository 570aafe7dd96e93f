"""How a system is placed in its parent: mappings of points, bases and boxes on (n, 3) arrays, and the straight one."""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.space.bases import combined, orthonormal, rotation, three_axes
from rbs_core.space.checks import Bounds, FloatArray, as_text, as_vector


class Mapping(ABC):
    """How the coordinates of a system and of its parent belong together.

    A kind of coordinates (Cartesian, cylindrical, ...) is a subclass with two functions on arrays of shape (n, 3);
    the tree of systems knows nothing else about it. The other methods have defaults that say what cannot be done.

    Attributes:
        maker: the method of a system that makes a child of this kind, None where only `mapped` does.
    """

    maker: str | None = None

    @abstractmethod
    def to_parent(self, points: FloatArray) -> FloatArray:
        """Points (n, 3) in own coordinates, in those of the parent (a new array)."""

    @abstractmethod
    def from_parent(self, points: FloatArray) -> FloatArray:
        """Points (n, 3) in the parent's coordinates, in own ones (a new array)."""

    def basis(self, points: FloatArray) -> FloatArray:
        """The basis of vectors at points: how the parent's coordinates change per unit along each basis vector.

        Args:
            points: own coordinates, shape (n, 3).

        Returns:
            Three rows per point, shape (n, 3, 3).

        Raises:
            BadInput: where a kind has no basis.
        """
        raise BadInput(f"{self!r} has no basis, so that vectors have no components: give its class a method basis")

    def scales(self, points: FloatArray) -> FloatArray:
        """By how many basis vectors a point moves per unit of each own coordinate, shape (n, 3).

        It is 1 where the basis vectors lead from one whole number of a coordinate to the next, and the radius for an
        angle whose basis vector has the length of one meter.

        Args:
            points: own coordinates, shape (n, 3).
        """
        return np.ones_like(points)

    def near(self, points: FloatArray, middle: FloatArray) -> FloatArray:
        """Other coordinates for the same points, as near to a middle as can be: angles are turned by whole turns.

        Args:
            points: own coordinates, shape (n, d).
            middle: own coordinates, shape (d,), NaN where it does not matter.
        """
        return points

    def bounds_to_parent(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        """A box in the parent's coordinates around the image of a box; all of space unless a kind knows better.

        Args:
            lower: smallest own coordinates, shape (3,), may be -inf.
            upper: largest own coordinates, shape (3,), may be +inf.

        Returns:
            Smallest and largest coordinates in the parent, shape (3,) each.
        """
        return np.full(3, -np.inf), np.full(3, np.inf)

    def cell_volumes(self, lower: FloatArray, upper: FloatArray) -> FloatArray:
        """What cells between coordinates measure in the parent: their volume, in 2-D their area, in 1-D their length.

        Args:
            lower: smallest own coordinates of each cell, shape (n, d).
            upper: largest own coordinates of each cell, shape (n, d).

        Returns:
            Shape (n,), m^d where the parent's coordinates are lengths.

        Raises:
            BadInput: where a kind does not know it.
        """
        raise BadInput(f"{self!r} knows no volumes of cells: give its class a method cell_volumes")

    def least_stretch(self, dimension: int) -> float:
        """Smallest factor by which a length grows on its way to the parent; 0 where no such factor is known.

        Args:
            dimension: 1, 2 or 3; only the first so many coordinates vary.
        """
        return 0.0

    def translated(self, vector: ArrayLike) -> Mapping:
        """The same mapping for a system that was shifted.

        Args:
            vector: by how much, in the parent's coordinates (m), 1 to 3 components, missing ones are 0.

        Raises:
            BadInput: where a kind cannot be moved.
        """
        raise BadInput(f"{self!r} cannot be moved by itself: assign another mapping to the system")

    def rotated(self, angle: float, axis: ArrayLike = (0.0, 0.0, 1.0), center: ArrayLike | None = None) -> Mapping:
        """The same mapping for a system that was turned.

        Args:
            angle: rad; by the rule of the right hand about the axis.
            axis: in the parent's coordinates, of any length but zero.
            center: a point of the axis in the parent's coordinates (m); the own origin if not given.

        Raises:
            BadInput: for an axis without length, and where a kind cannot be moved.
        """
        raise BadInput(f"{self!r} cannot be moved by itself: assign another mapping to the system")

    def arguments(self) -> str:
        """The arguments as they could be typed."""
        return ""

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.arguments()})"


class Cartesian(Mapping):
    """Straight axes: parent = origin + x axes[0] + y axes[1] + z axes[2].

    Args:
        origin: own origin in the parent's coordinates (m), 1 to 3 components; missing ones are 0.
        axes: three vectors in the parent's coordinates: where one unit along x, y and z leads. Any length but zero
            and any angles: long axes stretch, oblique axes shear. Two vectors are enough: the third is their
            normalised cross product. Vectors of two components get a third of 0. None: the parent's own axes.

    Raises:
        BadInput: when an axis has no length or the axes are linearly dependent; the message names them.
    """

    maker = "child"

    def __init__(self, origin: ArrayLike = (0.0, 0.0, 0.0), axes: Sequence[ArrayLike] | None = None) -> None:
        self._still = np.eye(3) if axes is None else three_axes(axes)  # the axes before all rotations
        self._turn = np.eye(3)
        self._place(padded(origin, "origin"))

    def _place(self, origin: FloatArray) -> None:
        self.origin: FloatArray = origin
        self.axes: FloatArray = self._still @ self._turn
        self._inverse: FloatArray = np.asarray(np.linalg.inv(self.axes), dtype=np.float64)
        self._shift_only = bool(np.array_equal(self.axes, np.eye(3)))
        self.origin.flags.writeable = self.axes.flags.writeable = False

    def to_parent(self, points: FloatArray) -> FloatArray:
        turned = points if self._shift_only else combined(points, self.axes)
        return turned + self.origin

    def from_parent(self, points: FloatArray) -> FloatArray:
        shifted = points - self.origin
        return shifted if self._shift_only else combined(shifted, self._inverse)

    def basis(self, points: FloatArray) -> FloatArray:
        """The axes, with the lengths they have, shape (n, 3, 3)."""
        return np.broadcast_to(self.axes, (len(points), 3, 3))

    def bounds_to_parent(self, lower: FloatArray, upper: FloatArray) -> Bounds:
        """The smallest box in the parent's coordinates around the image of a box (the hull of its corners)."""
        least, most = self.origin.copy(), self.origin.copy()
        for axis, low, high in zip(self.axes, lower, upper, strict=True):
            for component in np.flatnonzero(axis):  # a zero component adds nothing, not even 0 times infinity
                ends = sorted((low * axis[component], high * axis[component]))
                least[component] += ends[0]
                most[component] += ends[1]
        return least, most

    def cell_volumes(self, lower: FloatArray, upper: FloatArray) -> FloatArray:
        """The product of the sides, times that of one unit cube."""
        volumes: FloatArray = (upper - lower).prod(axis=1) * self.volume_factor(lower.shape[1])
        return volumes

    def volume_factor(self, dimension: int) -> float:
        """By which volumes (areas, lengths) grow on their way to the parent.

        Args:
            dimension: 1, 2 or 3; only the first so many coordinates vary.
        """
        return abs(float(np.linalg.det(self.axes[:dimension, :dimension])))

    def least_stretch(self, dimension: int) -> float:
        """Smallest factor by which a length grows on its way to the parent."""
        block = self.axes[:dimension, :dimension]
        if np.abs(block @ block.T - np.eye(dimension)).max() <= 1e-14:  # turned only: no round-off in the factor
            return 1.0
        return float(np.linalg.svd(block, compute_uv=False)[-1])

    def translated(self, vector: ArrayLike) -> Cartesian:
        moved = copy.copy(self)
        moved._place(self.origin + padded(vector, "vector"))
        return moved

    def rotated(self, angle: float, axis: ArrayLike = (0.0, 0.0, 1.0), center: ArrayLike | None = None) -> Cartesian:
        """The same mapping for a system that was turned; lengths and angles of the axes stay, however often."""
        matrix = rotation(angle, axis)
        middle = self.origin if center is None else padded(center, "center")
        moved = copy.copy(self)
        moved._turn = orthonormal(self._turn @ matrix)
        moved._place(middle + combined((self.origin - middle)[None, :], matrix)[0])
        return moved

    def arguments(self) -> str:
        """The arguments as they could be typed, axes left out where they are the parent's."""
        axes = "" if self._shift_only else f", axes={as_text(self.axes)}"
        return f"origin={as_text(self.origin)}{axes}"


class Framed(Mapping):
    """Coordinates of their own in a frame of straight axes: parent = origin + straight(own) @ axes.

    A kind has two functions between own coordinates and the straight ones of its frame; the frame does the rest, and
    moves as a Cartesian system does.

    Args:
        origin: own origin in the parent's coordinates (m), 1 to 3 components; missing ones are 0.
        axes: of the frame, in the parent's coordinates, as those of `Cartesian`.

    Attributes:
        frame: the frame, a `Cartesian`.

    Raises:
        BadInput: as `Cartesian`.
    """

    def __init__(self, origin: ArrayLike = (0.0, 0.0, 0.0), axes: Sequence[ArrayLike] | None = None) -> None:
        self.frame = Cartesian(origin, axes)

    @abstractmethod
    def _straight(self, points: FloatArray) -> FloatArray:
        """Points (n, 3) in own coordinates, in those of the frame."""

    @abstractmethod
    def _own(self, points: FloatArray) -> FloatArray:
        """Points (n, 3) in the frame's coordinates, in own ones."""

    @abstractmethod
    def _tangents(self, points: FloatArray) -> FloatArray:
        """The basis (n, 3, 3) at points in own coordinates, in coordinates of the frame."""

    def to_parent(self, points: FloatArray) -> FloatArray:
        return self.frame.to_parent(self._straight(points))

    def from_parent(self, points: FloatArray) -> FloatArray:
        return self._own(self.frame.from_parent(points))

    def basis(self, points: FloatArray) -> FloatArray:
        tangents = self._tangents(points)
        return combined(tangents.reshape(-1, 3), self.frame.axes).reshape(tangents.shape)

    def translated(self, vector: ArrayLike) -> Framed:
        return self._in(self.frame.translated(vector))

    def rotated(self, angle: float, axis: ArrayLike = (0.0, 0.0, 1.0), center: ArrayLike | None = None) -> Framed:
        return self._in(self.frame.rotated(angle, axis, center))

    def _in(self, frame: Cartesian) -> Framed:
        """The same coordinates in another frame."""
        moved = copy.copy(self)
        moved.frame = frame
        return moved

    def arguments(self) -> str:
        return self.frame.arguments()


def padded(vector: ArrayLike, what: str) -> FloatArray:
    """A vector of 1 to 3 components from outside with zeros for the missing ones, shape (3,).

    Raises:
        BadInput: as `as_vector`.
    """
    given = as_vector(vector, what)
    full: FloatArray = np.zeros(3)
    full[: given.size] = given
    return full
