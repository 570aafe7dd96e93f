"""Regular grids: points in the middle of equal cells along the axes, and the same turned."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, prod

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.space.bases import combined, rotation
from rbs_core.space.checks import BoolArray, Bounds, FloatArray, as_number, as_text, as_vector, as_vectors
from rbs_core.space.grids.axis import Axis
from rbs_core.space.grids.cells import MOST_POINTS, Cells, Cloud, Lattice, require_few
from rbs_core.space.grids.product import Product

# How far size/spacing may be from a whole number of cells and still mean it: lengths arrive with round-off.
WHOLE = 1e-6


@dataclass(frozen=True, eq=False, repr=False)
class Grid(Product):
    """Equal cubic (square, straight) cells around a center; the points are their middles.

    Args:
        spacing: edge of a cell (m).
        shape: number of cells per axis, 1 to 3 axes.
        center: middle of the grid (m), shape (d,).

    Raises:
        BadInput: for a spacing that is not positive, for axes without cells, for a center of another dimension.
    """

    spacing: float
    shape: tuple[int, ...]
    center: FloatArray

    def __post_init__(self) -> None:
        center = as_vector(self.center, "center")
        object.__setattr__(self, "spacing", as_number(self.spacing, "spacing", positive=True))
        object.__setattr__(self, "center", center)
        if len(self.shape) != center.size:
            raise BadInput(
                f"shape = {self.shape} has {len(self.shape)} axes, center = {as_text(center)} has {center.size}; "
                "give both the same number"
            )
        for axis, cells in enumerate(self.shape):
            if cells != int(cells) or cells < 1:
                raise BadInput(f"shape[{axis}] = {cells} is no number of cells; give a whole number from 1")
        object.__setattr__(self, "shape", tuple(int(cells) for cells in self.shape))

    @property
    def dimension(self) -> int:
        """Number of axes."""
        return len(self.shape)

    def coordinates(self, axis: int) -> FloatArray:
        """Coordinates (m) of the points along one axis, shape (shape[axis],)."""
        cells = self.shape[axis]
        # From the center outwards, not from an edge: a grid around 0 is symmetric to the last bit.
        result: FloatArray = self.center[axis] + (np.arange(cells) - (cells - 1) / 2) * self.spacing
        return result

    def axis(self, number: int) -> Axis:
        cells = self.shape[number]
        edges = self.center[number] + (np.arange(cells + 1) - cells / 2) * self.spacing
        return Axis(edges, self.coordinates(number))

    def lattice(self, chosen: BoolArray) -> Lattice:
        return self, None if chosen.all() else np.flatnonzero(chosen)

    def measures(self) -> FloatArray:
        """The volume of a cell for each of them, m^d, shape (n,)."""
        return np.full(len(self), self.cell_volume())

    def volumes(self, across: float = 1.0) -> FloatArray:
        return np.full(len(self), self.cell_volume(across))

    def cell_volume(self, thickness: float = 1.0) -> float:
        """Volume of a cell.

        Args:
            thickness: what the missing axes measure: thickness (m) in 2-D, area of the cross section (m^2) in 1-D.

        Returns:
            spacing^d times thickness; m^3 when the thickness is given.

        Raises:
            BadInput: for a thickness that is not positive.
        """
        return float(self.spacing**self.dimension) * as_number(thickness, "thickness", positive=True)

    def __len__(self) -> int:
        return prod(self.shape)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Grid):
            return NotImplemented
        return self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def _key(self) -> tuple[object, ...]:
        return self.spacing, self.shape, tuple(self.center.tolist())

    def __repr__(self) -> str:
        return f"Grid(spacing={self.spacing}, shape={self.shape}, center={as_text(self.center)})"


def uniform(lower: ArrayLike, upper: ArrayLike, spacing: float) -> Grid:
    """A grid that fills a box; where the box is no whole number of cells wide, the grid is wider, on both sides alike.

    Args:
        lower: smallest coordinates of the box (m), shape (d,) or a number.
        upper: largest coordinates of the box (m), shape (d,) or a number.
        spacing: edge of a cell (m).

    Returns:
        The grid; its center is the middle of the box.

    Raises:
        BadInput: for an empty or infinite box, a spacing that is not positive and finite, more points than 2^32 - 1.
    """
    low, high = finite_box(lower, upper)
    edge = as_number(spacing, "spacing", positive=True)
    ratios = [size / edge for size in (high - low).tolist()]
    if prod(max(1.0, ratio) for ratio in ratios) > MOST_POINTS:
        raise BadInput(
            f"spacing = {edge} is too small: a box of {as_text(high - low)} would hold more than {MOST_POINTS} points; "
            "give a larger spacing"
        )
    return Grid(edge, tuple(_cells(ratio) for ratio in ratios), (low + high) / 2)


def rotated(
    lower: ArrayLike,
    upper: ArrayLike,
    spacing: float,
    angle: float,
    *,
    axis: ArrayLike | None = None,
    center: ArrayLike | None = None,
) -> Cells:
    """A uniform grid that is turned and covers a box: shows whether cracks follow the box or the grid.

    It holds every cell that touches the box; a part takes those whose points are in its geometry. All cells are whole,
    so that their volumes add up to a little more than the box, or to about it once points outside are left out.

    Args:
        lower: smallest coordinates of the box (m), shape (d,) or a number, d = 2 or 3.
        upper: largest coordinates of the box (m), shape (d,) or a number.
        spacing: edge of a cell (m).
        angle: rad, by the rule of the right hand about the axis; 0 makes the points of `uniform`.
        axis: to turn about in 3-D, of any length but zero; z if not given.
        center: the point that stays in its place (m), shape (d,); the middle of the box if not given.

    Raises:
        BadInput: as `uniform`; in 1-D, for an axis in 2-D, for an axis without length, for a center of another
            dimension.
    """
    straight = uniform(lower, upper, spacing)
    dimension, middle, edge = straight.dimension, straight.center, straight.spacing
    low, high = finite_box(lower, upper)
    if dimension == 1 or (dimension == 2 and axis is not None):
        raise BadInput(f"a grid in {dimension}-D has no axis to turn about: {_TURNS[dimension]}")
    turn = rotation(angle, (0.0, 0.0, 1.0) if axis is None else axis)
    stays = middle if center is None else as_vector(center, "center")
    if stays.size != dimension:
        raise BadInput(f"center = {as_text(stays)} has {stays.size} components; give {dimension}, as the box has")

    def turned(points: FloatArray, matrix: FloatArray) -> FloatArray:
        """Points turned about the one that stays."""
        full = np.zeros((len(points), 3))
        full[:, :dimension] = points - stays
        return combined(full, matrix)[:, :dimension] + stays

    corners = np.array([low, high])[np.indices((2,) * dimension).reshape(dimension, -1).T, np.arange(dimension)]
    reach = np.abs(turned(corners, turn.T) - middle).max(axis=0) / edge
    # On both sides as many cells more as the corners are away, so that the lattice stays the one of `uniform`.
    more = np.maximum(np.ceil(reach - np.array(straight.shape) / 2), 0.0).astype(int) + 1
    shape = tuple(int(cells) for cells in np.array(straight.shape) + 2 * more)
    require_few(prod(float(cells) for cells in shape), "spacing")
    points = turned(Grid(edge, shape, middle).points(), turn)
    half = np.abs(turn[:dimension, :dimension]).sum(axis=0) * edge / 2  # of the box around a turned cell
    touching = (np.abs(points - middle) < (high - low) / 2 + half - WHOLE * edge).all(axis=1)
    others = "".join(
        f", {name}={as_text(value)}"
        for name, value in (("axis", None if axis is None else as_vector(axis, "axis")), ("center", center))
        if value is not None
    )
    text = f"rotated({as_text(low)}, {as_text(high)}, {edge}, {float(angle)}{others})"
    return Cloud(points[touching], straight.measures()[0], edge, text)


_TURNS = {1: "use uniform", 2: "leave axis out, it is z"}


def finite_box(lower: ArrayLike, upper: ArrayLike) -> Bounds:
    """Two corners of a box, refused unless it has an inside and is finite.

    Raises:
        BadInput: for an empty or infinite box.
    """
    low, high = as_vectors(lower, upper, ("lower", "upper"), infinite=True)
    for axis, (least, most) in enumerate(zip(low.tolist(), high.tolist(), strict=True)):
        if most <= least:
            raise BadInput(
                f"upper[{axis}] = {most} is not above lower[{axis}] = {least}: the box is empty; "
                "give upper above lower, or a geometry that has points"
            )
        if not (np.isfinite(least) and np.isfinite(most)):
            side, value = ("upper", most) if np.isfinite(least) else ("lower", least)
            raise BadInput(f"{side}[{axis}] = {value}: no grid fills infinite space; give a bounded geometry")
    return low, high


def _cells(ratio: float) -> int:
    """Number of cells on a side that is `ratio` cells long."""
    nearest = round(ratio)
    return max(1, nearest if abs(ratio - nearest) <= WHOLE else ceil(ratio))
