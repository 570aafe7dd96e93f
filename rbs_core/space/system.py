"""A tree of coordinate systems, and points converted between any two systems of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import count
from typing import TypeAlias
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.space.checks import FloatArray, as_real, require_finite
from rbs_core.space.convert import Cartesian, Mapping

# A component is dropped on the way back to 1-D or 2-D when it is below this fraction of the largest coordinate met.
FLATNESS = 1e-12

Step: TypeAlias = Callable[[FloatArray], FloatArray]


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

    def mapped(self, name: str, mapping: Mapping) -> CoordinateSystem:
        """A system of any kind placed in this one; its coordinates relate to these by `mapping`."""
        return CoordinateSystem(name, self, mapping)

    @property
    def mapping(self) -> Mapping | None:
        """How its coordinates relate to the parent's; assign another to move the system and all below it."""
        return self._mapping

    @mapping.setter
    def mapping(self, mapping: Mapping) -> None:
        if self.parent is None:
            raise BadInput(f"{self.name!r} is a root and cannot be moved; move a child of it")
        self._mapping = mapping

    @property
    def children(self) -> tuple[CoordinateSystem, ...]:
        """The children that somebody still uses, oldest first."""
        return tuple(self._children.values())

    @property
    def path(self) -> str:
        """Names from the root down to this system, such as "world/plate"."""
        return self.name if self.parent is None else f"{self.parent.path}/{self.name}"

    def to_parent(self, points: ArrayLike) -> FloatArray:
        """Points of this system in coordinates of its parent; shapes and errors as in `convert`."""
        return convert(points, self, self._required_parent())

    def from_parent(self, points: ArrayLike) -> FloatArray:
        """Points of the parent in coordinates of this system; shapes and errors as in `convert`."""
        return convert(points, self._required_parent(), self)

    def _required_parent(self) -> CoordinateSystem:
        if self.parent is None:
            raise BadInput(f"{self.name!r} is a root and has no parent; use a child of it")
        return self.parent

    def __repr__(self) -> str:
        if self.parent is None:
            return self.name if self is world else f"CoordinateSystem({self.name!r})"
        if isinstance(self._mapping, Cartesian):
            return f"{self.parent!r}.child({self.name!r}, {self._mapping.arguments()})"
        return f"{self.parent!r}.mapped({self.name!r}, {self._mapping!r})"


world = CoordinateSystem("world")


def convert(points: ArrayLike, source: CoordinateSystem, target: CoordinateSystem) -> FloatArray:
    """Points of one system in coordinates of another, by way of their lowest common ancestor.

    Args:
        points: shape (n, d), or (d,) for one point; d = 1, 2 or 3, missing components count as 0.
        source: the system that the points are given in.
        target: the system that they are wanted in; the same one gives a copy.

    Returns:
        A new float64 array of the shape of `points`.

    Raises:
        BadInput: when the systems belong to different trees; when points in 1-D or 2-D leave their line or plane
            (by more than 1e-12 of the largest coordinate met on the way); for other shapes and for NaN or infinity.
    """
    array = np.array(as_real(points, "points"), dtype=np.float64)
    if array.ndim not in (1, 2) or not 1 <= array.shape[-1] <= 3:
        raise BadInput(
            f"points has shape {array.shape}; give (n, d), or (d,) for one point, with d = 1, 2 or 3 "
            "(many points in 1-D: shape (n, 1))"
        )
    require_finite(array, "points")
    for system, what in ((source, "source"), (target, "target")):
        if not isinstance(system, CoordinateSystem):
            raise BadInput(f"{what} = {system!r} is no CoordinateSystem; give world or a system below it")
    shared = _common_ancestor(source, target)
    if source is target:
        return array
    rows = array.reshape(-1, array.shape[-1])
    dimension = rows.shape[1]
    full = np.zeros((len(rows), 3))
    full[:, :dimension] = rows
    scale = np.abs(full).max(initial=0.0)
    for step in _steps(source, target, shared):
        full = step(full)
        scale = max(scale, np.abs(full).max(initial=0.0))
    _require_flat(full, dimension, FLATNESS * scale, f"{source.path} to {target.path}")
    return np.ascontiguousarray(full[:, :dimension]).reshape(array.shape)


def _common_ancestor(source: CoordinateSystem, target: CoordinateSystem) -> CoordinateSystem:
    """The deepest system that is above both (or one of them)."""
    a: CoordinateSystem | None = source
    b: CoordinateSystem | None = target
    while a is not b:
        # The deeper one climbs; at equal depth both must, the second in the next round.
        if b is None or (a is not None and a.depth >= b.depth):
            a = a.parent if a is not None else None
        else:
            b = b.parent
    if a is None:
        raise BadInput(
            f"{source.path!r} and {target.path!r} belong to different trees; make both children of one system, "
            "such as world"
        )
    return a


def _steps(source: CoordinateSystem, target: CoordinateSystem, shared: CoordinateSystem) -> list[Step]:
    """The functions that lead up from the source to the shared system and down to the target."""
    up, down = _line_below(shared, source), _line_below(shared, target)
    return [*(mapping.to_parent for mapping in up), *(mapping.from_parent for mapping in reversed(down))]


def _line_below(top: CoordinateSystem, bottom: CoordinateSystem) -> list[Mapping]:
    """Mappings of the systems from `bottom` up to, but without, `top`."""
    mappings: list[Mapping] = []
    system: CoordinateSystem | None = bottom
    while system is not None and system is not top and system.mapping is not None:
        mappings.append(system.mapping)
        system = system.parent
    return mappings


def _require_flat(full: FloatArray, dimension: int, tolerance: float, way: str) -> None:
    """Refuse to drop components that are not zero."""
    dropped = np.abs(full[:, dimension:])
    if dropped.size and dropped.max() > tolerance:
        row, column = np.unravel_index(np.argmax(dropped), dropped.shape)
        raise BadInput(
            f"{way}: points[{row}] gets {'xyz'[dimension + int(column)]} = {full[row, dimension + column]:.6g} and "
            f"leaves {dimension} dimension{'s' if dimension > 1 else ''}; give 3-D points (add the missing zeros)"
        )
