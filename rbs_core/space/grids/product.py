"""Grids of axes: cells between the edges of each axis, in straight coordinates or in curved ones."""

from __future__ import annotations

from abc import abstractmethod
from math import prod

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.space.checks import FloatArray
from rbs_core.space.grids.axis import Axis
from rbs_core.space.grids.cells import Cells, Cloud, require_few, typical
from rbs_core.space.mapping import Cartesian
from rbs_core.space.system import CoordinateSystem


class Product(Cells):
    """A grid with one point for each combination of points of its axes; x runs fastest."""

    @abstractmethod
    def axis(self, number: int) -> Axis:
        """One axis: 0 is x, 1 is y, 2 is z."""

    @property
    def axes(self) -> tuple[Axis, ...]:
        """All axes."""
        return tuple(self.axis(number) for number in range(self.dimension))

    def points(self) -> FloatArray:
        """The points (m), shape (n, d); number i = ix + iy nx + iz nx ny, so x runs fastest."""
        return _combinations([axis.coordinates for axis in self.axes])

    def measures(self) -> FloatArray:
        """What the cells measure: products of their sides, m^d, shape (n,)."""
        measures: FloatArray = _combinations([axis.sizes for axis in self.axes]).prod(axis=1)
        return measures

    def __len__(self) -> int:
        return prod(len(axis) for axis in self.axes)

    def with_axis(self, number: int, *, edges: ArrayLike | None = None, coordinates: ArrayLike | None = None) -> Graded:
        """This grid with another axis in place of one of its own.

        Args:
            number: which one: 0 is x, 1 is y, 2 is z.
            edges: of the cells along it (m), rising, shape (k + 1,); two edges make a single layer. Halfway between
                the coordinates if not given, and as far behind the first and the last one.
            coordinates: of the points along it (m), rising, shape (k,); the middles of the cells if not given.

        Raises:
            BadInput: for an axis that is not there, for neither edges nor coordinates, and as `Axis`.
        """
        axes = list(self.axes)
        if number not in range(len(axes)):
            raise BadInput(f"axis {number} is not there; give one from 0 to {len(axes) - 1} (use extruded for another)")
        if edges is not None:
            axes[number] = Axis(edges, coordinates)
        elif coordinates is not None:
            axes[number] = Axis.through(coordinates)
        else:
            raise BadInput(f"axis {number} got neither edges nor coordinates; give one of them, or both")
        return Graded(*axes)

    def extruded(self, edges: ArrayLike) -> Graded:
        """Layers of this grid along the next axis: a plane one becomes solid, a line becomes plane.

        Args:
            edges: of the layers along the new axis (m), rising, shape (layers + 1,).

        Raises:
            BadInput: in 3-D, and for edges that do not rise.
        """
        return Graded(*self.axes, Axis(edges))

    def placed(self, system: CoordinateSystem) -> Cells:
        """This grid, its numbers understood in any system, as a grid in coordinates of that system's parent.

        In cylindrical and spherical systems the axes are those of their coordinates: edges of r, phi (rad) and z make
        sectors of tubes, of r, theta and phi those of shells. The volumes are exact; in custom systems as exact as
        three points of Gauss per axis and cell.

        Args:
            system: where; not a root.

        Raises:
            BadInput: for a root, for coordinates that the system does not have (negative radii, more than a turn), and
                when points in 1-D or 2-D leave their line or plane.
        """
        mapping, _ = system.placement()
        if isinstance(mapping, Cartesian):
            return super().placed(system)
        lower = _combinations([axis.edges[:-1] for axis in self.axes])
        upper = _combinations([axis.edges[1:] for axis in self.axes])
        measures = mapping.cell_volumes(lower, upper)
        return Cloud(system.to_parent(self.points()), measures, None, f"{self!r}.placed({system!r})")


class Graded(Product):
    """A grid whose cells have the sizes that the edges of its axes say.

    Args:
        axes: one to three, each an `Axis` or the edges of its cells (m), rising; points in the middle of their cells.

    Raises:
        BadInput: for another number of axes, and for edges that do not rise.
    """

    def __init__(self, *axes: Axis | ArrayLike) -> None:
        if not 1 <= len(axes) <= 3:
            raise BadInput(f"{len(axes)} axes were given; give the edges of 1, 2 or 3")
        self._axes = tuple(axis if isinstance(axis, Axis) else Axis(axis) for axis in axes)
        require_few(prod(float(len(axis)) for axis in self._axes), "the edges")
        self.spacing = typical([size for axis in self._axes if len(axis) > 1 for size in axis.sizes.tolist()])

    @property
    def dimension(self) -> int:
        """Number of axes."""
        return len(self._axes)

    def axis(self, number: int) -> Axis:
        """One axis: 0 is x, 1 is y, 2 is z."""
        return self._axes[number]

    def __repr__(self) -> str:
        return f"graded({', '.join(repr(axis) for axis in self._axes)})"


def graded(*axes: Axis | ArrayLike) -> Graded:
    """A grid whose cells have any sizes.

    Args:
        axes: edges of the cells (m) along x, y and z, rising, such as `edges(0.0, 1.0, 0.01, growth=1.1)`.

    Raises:
        BadInput: for another number of axes than 1 to 3, and for edges that do not rise.
    """
    return Graded(*axes)


def _combinations(axes: list[FloatArray]) -> FloatArray:
    """All combinations of numbers of the axes as rows, the first axis fastest."""
    shape = tuple(len(axis) for axis in axes)
    rows = np.empty((prod(shape), len(axes)))
    by_axes = rows.reshape(*reversed(shape), len(axes))
    for number, values in enumerate(axes):
        along = [1] * len(axes)
        along[len(axes) - 1 - number] = len(values)
        by_axes[..., number] = values.reshape(along)
    return rows
