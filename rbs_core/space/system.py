"""A tree of coordinate systems: straight, cylindrical, spherical and others, each placed in its parent and movable."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count
from weakref import WeakValueDictionary

from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.space.checks import FloatArray
from rbs_core.space.curved import Cylindrical, Spherical
from rbs_core.space.custom import BoundsFunction, Custom, Function
from rbs_core.space.mapping import Cartesian, Mapping


class CoordinateSystem:
    """A named system of coordinates, placed in its parent by a mapping.

    Use `world.child(...)` rather than the constructor. Without a parent the system is the root of a tree of its own.
    Children hold their parents; a parent only remembers its children as long as somebody else uses them.

    Args:
        name: what it is called; not empty, without "/".
        parent: the system it is placed in, None for a root.
        mapping: how its coordinates relate to the parent's, None for a root.

    Attributes:
        name: what it is called.
        parent: the system it is placed in, or None.
        depth: number of systems above it.

    Raises:
        BadInput: for a name that cannot stand in a path, and for a parent without a mapping or the reverse.
    """

    def __init__(self, name: str, parent: CoordinateSystem | None = None, mapping: Mapping | None = None) -> None:
        if not isinstance(name, str) or not name or "/" in name:
            raise BadInput(f"name {name!r} cannot stand in a path; give a text that is not empty and has no '/'")
        if (parent is None) != (mapping is None):
            raise BadInput(f"system {name!r} needs both a parent and a mapping, or neither; use parent.child({name!r})")
        self.name = name
        self.parent = parent
        self.depth: int = 0 if parent is None else parent.depth + 1
        self._mapping = mapping
        self._children: WeakValueDictionary[int, CoordinateSystem] = WeakValueDictionary()
        self._numbers = count()
        if parent is not None:
            parent._children[next(parent._numbers)] = self

    def child(
        self, name: str, origin: ArrayLike = (0.0, 0.0, 0.0), axes: Sequence[ArrayLike] | None = None
    ) -> CoordinateSystem:
        """A Cartesian system placed in this one.

        Args:
            name: what it is called.
            origin: its origin in coordinates of this system (m), 1 to 3 components, missing ones are 0.
            axes: three linearly independent vectors in coordinates of this system, where one unit along x, y, z of
                the child leads; any lengths and angles. Two are completed by their normalised cross product.

        Returns:
            The child; keep it, the tree does not.

        Raises:
            BadInput: for a bad name, and for axes without length or linearly dependent ones.
        """
        return self.mapped(name, Cartesian(origin, axes))

    def cylindrical(
        self, name: str, origin: ArrayLike = (0.0, 0.0, 0.0), axes: Sequence[ArrayLike] | None = None
    ) -> CoordinateSystem:
        """A system of coordinates (r, phi, z) placed in this one; in 2-D polar coordinates (r, phi).

        Args:
            name: what it is called.
            origin: a point of the axis in coordinates of this system (m).
            axes: phi = 0 is along the first, z along the third; this system's own if not given. See `Cylindrical`.

        Returns:
            The child; keep it, the tree does not.

        Raises:
            BadInput: as `child`.
        """
        return self.mapped(name, Cylindrical(origin, axes))

    def spherical(
        self, name: str, origin: ArrayLike = (0.0, 0.0, 0.0), axes: Sequence[ArrayLike] | None = None
    ) -> CoordinateSystem:
        """A system of coordinates (r, theta, phi) placed in this one: theta from the z axis, phi about it, in rad.

        Args:
            name: what it is called.
            origin: the center in coordinates of this system (m).
            axes: theta = 0 is along the third, phi = 0 at the side of the first; this system's own if not given. See
                `Spherical`.

        Returns:
            The child; keep it, the tree does not.

        Raises:
            BadInput: as `child`.
        """
        return self.mapped(name, Spherical(origin, axes))

    def custom(
        self,
        name: str,
        to_parent: Function,
        from_parent: Function,
        origin: ArrayLike = (0.0, 0.0, 0.0),
        axes: Sequence[ArrayLike] | None = None,
        *,
        samples: ArrayLike | None = None,
        jacobian: Function | None = None,
        bounds: BoundsFunction | None = None,
    ) -> CoordinateSystem:
        """A system of coordinates of one's own: this system's = origin + to_parent(own) @ axes.

        Args:
            name: what it is called.
            to_parent: function of points (n, 3) in own coordinates.
            from_parent: its inverse.
            origin: of the axes, in coordinates of this system (m).
            axes: three vectors of any length but zero; this system's own if not given.
            samples: points (n, 3) in own coordinates where the functions are checked to be inverse.
            jacobian: derivatives of `to_parent`, (n, 3, 3), for vectors; differences if not given.
            bounds: function that puts a box around the image of a box. For all of these see `Custom`.

        Returns:
            The child; keep it, the tree does not.

        Raises:
            BadInput: as `child`, and where the functions are not inverse to each other.
        """
        mapping = Custom(to_parent, from_parent, origin, axes, samples=samples, jacobian=jacobian, bounds=bounds)
        return self.mapped(name, mapping)

    def mapped(self, name: str, mapping: Mapping) -> CoordinateSystem:
        """A system of any kind placed in this one; its coordinates relate to these by `mapping`."""
        return CoordinateSystem(name, self, mapping)

    @property
    def mapping(self) -> Mapping | None:
        """How its coordinates relate to the parent's; assign another to move the system and all below it."""
        return self._mapping

    @mapping.setter
    def mapping(self, mapping: Mapping) -> None:
        self.placement()
        if not isinstance(mapping, Mapping):
            raise BadInput(f"mapping = {mapping!r} of {self.path!r} is no Mapping; give one such as Cartesian(origin)")
        self._mapping = mapping

    def translate(self, vector: ArrayLike) -> None:
        """Shifts the system, and all below it with their parts and geometries.

        Args:
            vector: by how much, in coordinates of the parent (m), 1 to 3 components, missing ones are 0.

        Raises:
            BadInput: for a root.
        """
        self._mapping = self.placement()[0].translated(vector)

    def rotate(self, angle: float, axis: ArrayLike = (0.0, 0.0, 1.0), center: ArrayLike | None = None) -> None:
        """Turns the system, and all below it with their parts and geometries.

        The lengths and angles of the axes stay what they are to the last digits, however many rotations are made. The
        angle adds up their round-off; a motion that is a function of time loses nothing when it starts from the first
        mapping in each step: `system.mapping = first.rotated(speed * time)`.

        Args:
            angle: rad; by the rule of the right hand about the axis.
            axis: in coordinates of the parent, of any length but zero.
            center: a point of the axis in coordinates of the parent (m); the own origin if not given.

        Raises:
            BadInput: for a root, and for an axis without length.
        """
        self._mapping = self.placement()[0].rotated(angle, axis, center)

    @property
    def children(self) -> tuple[CoordinateSystem, ...]:
        """The children that somebody still uses, oldest first."""
        return tuple(self._children.values())

    @property
    def path(self) -> str:
        """Names from the root down to this system, such as "world/plate"."""
        return self.name if self.parent is None else f"{self.parent.path}/{self.name}"

    def placement(self) -> tuple[Mapping, CoordinateSystem]:
        """How it is placed, and in what.

        Raises:
            BadInput: for a root.
        """
        if self.parent is None or self._mapping is None:
            raise BadInput(f"{self.name!r} is a root: it has no parent and cannot be moved; use a child of it")
        return self._mapping, self.parent

    def to_parent(self, points: ArrayLike) -> FloatArray:
        """Points of this system in coordinates of its parent; shapes and errors as in `convert`."""
        from rbs_core.space.convert import convert  # late: it knows what a system is

        return convert(points, self, self.placement()[1])

    def from_parent(self, points: ArrayLike) -> FloatArray:
        """Points of the parent in coordinates of this system; shapes and errors as in `convert`."""
        from rbs_core.space.convert import convert

        return convert(points, self.placement()[1], self)

    def __repr__(self) -> str:
        if self.parent is None:
            return self.name if self is world else f"CoordinateSystem({self.name!r})"
        if self._mapping is not None and self._mapping.maker is not None:
            return f"{self.parent!r}.{self._mapping.maker}({self.name!r}, {self._mapping.arguments()})"
        return f"{self.parent!r}.mapped({self.name!r}, {self._mapping!r})"


world = CoordinateSystem("world")
