"""Regular grids: points in the middle of equal cells, and the volume of a cell."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, prod

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.space.checks import FloatArray, as_number, as_text, as_vector, as_vectors

# How far size/spacing may be from a whole number of cells and still mean it: lengths arrive with round-off.
WHOLE = 1e-6

# Points are numbered by unsigned integers of 32 bits.
MOST_POINTS = 2**32 - 1


@dataclass(frozen=True, eq=False)
class Grid:
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

    def points(self) -> FloatArray:
        """The points (m), shape (n, d); number i = ix + iy nx + iz nx ny, so x runs fastest."""
        points = np.empty((len(self), self.dimension))
        by_axes = points.reshape(*reversed(self.shape), self.dimension)
        for axis in range(self.dimension):
            along = [1] * self.dimension
            along[self.dimension - 1 - axis] = self.shape[axis]
            by_axes[..., axis] = self.coordinates(axis).reshape(along)
        return points

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
    edge = as_number(spacing, "spacing", positive=True)
    ratios = [size / edge for size in (high - low).tolist()]
    if prod(max(1.0, ratio) for ratio in ratios) > MOST_POINTS:
        raise BadInput(
            f"spacing = {edge} is too small: a box of {as_text(high - low)} would hold more than {MOST_POINTS} points; "
            "give a larger spacing"
        )
    return Grid(edge, tuple(_cells(ratio) for ratio in ratios), (low + high) / 2)


def _cells(ratio: float) -> int:
    """Number of cells on a side that is `ratio` cells long."""
    nearest = round(ratio)
    return max(1, nearest if abs(ratio - nearest) <= WHOLE else ceil(ratio))
