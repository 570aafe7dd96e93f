"""What every grid has: points and the exact volumes of the cells around them; ways to make other grids from it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput
from rbs_core.space.checks import BoolArray, FloatArray, as_number, as_points, as_real, as_text, require_finite
from rbs_core.space.mapping import Cartesian
from rbs_core.space.system import CoordinateSystem

if TYPE_CHECKING:
    from rbs_core.space.grids.regular import Grid

# Points are numbered by unsigned integers of 32 bits.
MOST_POINTS = 2**32 - 1

# By which factor cells may differ in size while one number still says how far apart their points are.
ALIKE = 1.5


class HasPoints(Protocol):
    """Something that says which points are in it, such as a geometry."""

    def contains(self, points: ArrayLike) -> BoolArray:
        """True where a point (n, d) is in, shape (n,)."""
        ...


Lattice: TypeAlias = "tuple[Grid, NDArray[np.int64] | None]"
Region: TypeAlias = HasPoints | Callable[[FloatArray], ArrayLike] | ArrayLike


class Cells(ABC):
    """Points in 1, 2 or 3 dimensions, each with a cell whose volume is exact: what a part takes its nodes from.

    Attributes:
        spacing: typical distance of neighboring points (m), None where they differ too much for one number.
    """

    spacing: float | None

    @property
    @abstractmethod
    def dimension(self) -> int:
        """Number of coordinates of a point."""

    @abstractmethod
    def points(self) -> FloatArray:
        """The points (m), shape (n, d)."""

    @abstractmethod
    def measures(self) -> FloatArray:
        """What the cells measure: volume in 3-D, area in 2-D, length in 1-D; m^d, shape (n,)."""

    @abstractmethod
    def __len__(self) -> int: ...

    def volumes(self, across: float = 1.0) -> FloatArray:
        """Volumes of the cells.

        Args:
            across: what the missing axes measure: thickness (m) in 2-D, area of the cross section (m^2) in 1-D.

        Returns:
            Shape (n,); m^3 when `across` is given.

        Raises:
            BadInput: for a number that is not positive.
        """
        return self.measures() * as_number(across, "across", positive=True)

    def lattice(self, chosen: BoolArray) -> Lattice | None:
        """The uniform grid that some of the points lie on, and which of its points they are, None for all.

        None where they lie on no such grid, as with most kinds.

        Args:
            chosen: which of the points, shape (n,).
        """
        return None

    def where(self, region: Region) -> Cells:
        """The points of a region with their whole cells.

        Args:
            region: a geometry, a function of the points (n, d) that returns truth values, or truth values (n,).

        Raises:
            BadInput: when the region is something else, and when no point is in it.
        """
        points = self.points()
        if hasattr(region, "contains"):
            inside = np.asarray(region.contains(points))
        else:
            inside = np.asarray(region(points) if callable(region) else region)
        if inside.dtype != np.bool_ or inside.shape != (len(self),):
            raise BadInput(
                f"region = {_named(region)} gives {inside.dtype} of shape {inside.shape} for {len(self)} points; give "
                "a geometry, or one truth value per point"
            )
        if not inside.any():
            raise BadInput(
                f"none of the {len(self)} points of {self!r} lies in {_named(region)}; use a smaller spacing or check "
                "the region"
            )
        return Cloud(
            points[inside], self.measures()[inside], self.spacing, f"{self!r}.where({_named(region)})",
            on=self.lattice(inside),
        )  # fmt: skip

    def extruded(self, edges: ArrayLike) -> Cells:
        """Layers of this grid along the next axis: a plane one becomes solid, a line becomes plane.

        Args:
            edges: coordinates along the new axis (m) between which the layers are, rising, shape (layers + 1,); the
                points lie in the middle of their layers.

        Raises:
            BadInput: in 3-D, and for edges that do not rise.
        """
        from rbs_core.space.grids.axis import Axis  # late: grids of axes are a kind of this one

        if self.dimension == 3:
            raise BadInput(f"{self!r} has three dimensions; only plane and straight grids can be extruded")
        axis = Axis(edges)
        points, layers = self.points(), len(axis)
        require_few(len(points) * layers, "edges")
        solid = np.column_stack([np.tile(points, (layers, 1)), np.repeat(axis.coordinates, len(points))])
        measures = np.outer(axis.sizes, self.measures()).ravel()
        sizes = [] if self.spacing is None else [self.spacing]
        spacing = typical(sizes + (axis.sizes.tolist() if layers > 1 else [])) if sizes else None
        return Cloud(solid, measures, spacing, f"{self!r}.extruded({as_text(axis.edges)})")

    def placed(self, system: CoordinateSystem) -> Cells:
        """This grid, its numbers understood in a Cartesian system, as a grid in coordinates of that system's parent.

        Where the axes of the system stretch, cells grow with them. Grids of axes (`uniform`, `graded`) can be placed in
        curved systems too.

        Args:
            system: where; not a root.

        Raises:
            BadInput: for a root, for a system that is not Cartesian, and when points in 1-D or 2-D leave their line or
                plane.
        """
        mapping, _ = system.placement()
        if not isinstance(mapping, Cartesian):
            raise BadInput(
                f"{self!r} cannot be placed in {system.path!r} ({mapping!r}): only the cells between the edges of "
                "axes (uniform, graded) have known volumes in curved coordinates; use one of those"
            )
        points = system.to_parent(self.points())
        factor, stretch = mapping.volume_factor(self.dimension), mapping.least_stretch(self.dimension)
        even = factor <= ALIKE * stretch**self.dimension
        spacing = self.spacing * stretch if even and self.spacing is not None else None
        return Cloud(points, self.measures() * factor, spacing, f"{self!r}.placed({system!r})")


class Cloud(Cells):
    """Points in any order, with what their cells measure.

    Args:
        points: (m), shape (n, d), n > 0.
        measures: volume in 3-D, area in 2-D, length in 1-D; m^d, positive, shape (n,) or one number.
        spacing: typical distance of neighboring points (m), None if there is none.
        text: how it was made, for its `repr`.
        on: the uniform grid that the points lie on and which of its points they are, None if they lie on none.

    Raises:
        BadInput: for other shapes, and for measures or a spacing that are not positive.
    """

    def __init__(
        self,
        points: ArrayLike,
        measures: ArrayLike,
        spacing: float | None = None,
        text: str | None = None,
        *,
        on: Lattice | None = None,
    ) -> None:
        self._points = np.array(as_points(points))
        if not len(self._points):
            raise BadInput("points is empty; give at least one point")
        self._measures = np.array(as_real(measures, "measures"), dtype=np.float64)
        if self._measures.ndim == 0:
            self._measures = np.full(len(self._points), float(self._measures))
        if self._measures.shape != (len(self._points),):
            raise BadInput(
                f"measures has shape {self._measures.shape} for {len(self._points)} points; give one number per point"
            )
        require_finite(self._measures, "measures")
        empty = np.flatnonzero(self._measures <= 0.0)
        if empty.size:
            raise BadInput(f"measures[{empty[0]}] = {self._measures[empty[0]]} is not positive; give every cell a size")
        self.spacing = None if spacing is None else as_number(spacing, "spacing", positive=True)
        self._text = text
        self._on = on

    @property
    def dimension(self) -> int:
        """Number of coordinates of a point."""
        return int(self._points.shape[1])

    def points(self) -> FloatArray:
        """The points (m), shape (n, d)."""
        return self._points.copy()

    def measures(self) -> FloatArray:
        """What the cells measure, m^d, shape (n,)."""
        return self._measures.copy()

    def lattice(self, chosen: BoolArray) -> Lattice | None:
        if self._on is None:
            return None
        grid, indices = self._on
        return grid, np.flatnonzero(chosen) if indices is None else indices[chosen]

    def __len__(self) -> int:
        return len(self._points)

    def __repr__(self) -> str:
        return self._text or f"<Cloud of {len(self)} points, {self.dimension}-D>"


def require_few(count: float, cause: str) -> None:
    """Refuse more points than can be numbered, before there are any.

    Args:
        count: number of points.
        cause: name of the argument that asks for them.

    Raises:
        BadInput: when there are more than 2^32 - 1.
    """
    if count > MOST_POINTS:
        raise BadInput(f"{cause} would make {count:.3g} points, more than {MOST_POINTS}; make fewer, larger cells")


def typical(sizes: list[float]) -> float | None:
    """One number for the sizes of cells, None where they differ too much for that."""
    if not sizes or max(sizes) > ALIKE * min(sizes):
        return None
    return float(np.mean(sizes)) if max(sizes) > min(sizes) else float(sizes[0])


def _named(thing: object) -> str:
    """A region as it could be typed; a function by its name, truth values as what they are."""
    name = getattr(thing, "__qualname__", None)
    if isinstance(name, str):
        return name
    return repr(thing) if hasattr(thing, "contains") else "mask"
