"""One axis of a grid: edges of cells, points between them, and how both are spread."""

from __future__ import annotations

from math import log, log1p

import numpy as np
from numpy.typing import ArrayLike

from rbs_core.errors import BadInput
from rbs_core.space.checks import FloatArray, as_number, as_real, as_text, require_finite
from rbs_core.space.grids.cells import require_few

# A share of the first cell below which others are too small to fill anything.
SMALLEST = 1e-6

# Up to so many cells are shown one by one.
SHOWN = 12


class Axis:
    """Cells in a row.

    Args:
        edges: where cells begin and end, rising, shape (k + 1,).
        coordinates: of the points, one within each cell, shape (k,); the middles if not given.

    Raises:
        BadInput: for edges that do not rise, and points that are not within their cells.
    """

    def __init__(self, edges: ArrayLike, coordinates: ArrayLike | None = None) -> None:
        self.edges = _rising(edges, "edges", 2)
        self.sizes: FloatArray = np.diff(self.edges)
        self.coordinates: FloatArray
        if coordinates is None:
            self.coordinates = (self.edges[:-1] + self.edges[1:]) / 2
        else:
            self.coordinates = _rising(coordinates, "coordinates", 1)
            if len(self.coordinates) != len(self.sizes):
                raise BadInput(
                    f"coordinates has {len(self.coordinates)} points, edges make {len(self.sizes)} cells; give one "
                    "point per cell"
                )
            outside = np.flatnonzero((self.coordinates <= self.edges[:-1]) | (self.coordinates >= self.edges[1:]))
            if outside.size:
                cell = outside[0]
                raise BadInput(
                    f"coordinates[{cell}] = {self.coordinates[cell]} is not within its cell from {self.edges[cell]} to "
                    f"{self.edges[cell + 1]}; give a point within each cell"
                )
        for array in (self.edges, self.sizes, self.coordinates):
            array.flags.writeable = False

    @classmethod
    def through(cls, coordinates: ArrayLike) -> Axis:
        """The axis with given points: cells end halfway between them, and as far behind the first and the last one.

        Args:
            coordinates: rising, at least two, shape (k,).

        Raises:
            BadInput: for coordinates that do not rise.
        """
        points = _rising(coordinates, "coordinates", 2)
        halfway = (points[:-1] + points[1:]) / 2
        ends = 2 * points[0] - halfway[0], 2 * points[-1] - halfway[-1]
        return cls(np.concatenate([ends[:1], halfway, ends[1:]]), points)

    def __len__(self) -> int:
        return len(self.sizes)

    def __repr__(self) -> str:
        if len(self) > SHOWN:
            return f"<{len(self)} cells from {self.edges[0]} to {self.edges[-1]}>"
        middles = np.array_equal(self.coordinates, (self.edges[:-1] + self.edges[1:]) / 2)
        return as_text(self.edges) if middles else f"Axis({as_text(self.edges)}, {as_text(self.coordinates)})"


def edges(lower: float, upper: float, spacing: float, *, growth: float = 1.0) -> FloatArray:
    """Edges of cells that fill an interval, each larger than the one before by a factor.

    Their number is the one whose first cell is nearest to `spacing`; then all are scaled to fill the interval.

    Args:
        lower: begin of the interval (m).
        upper: end of the interval (m).
        spacing: size of the first cell (m), about.
        growth: size of a cell as a multiple of the one before it: 1 for equal cells, below 1 for shrinking ones.

    Returns:
        Shape (k + 1,), from `lower` to `upper`.

    Raises:
        BadInput: for an empty interval, for a spacing or growth that is not positive, for cells that shrink so fast
            that they hardly reach the end or never do.
    """
    low, high = as_number(lower, "lower"), as_number(upper, "upper")
    if high <= low:
        raise BadInput(f"upper = {high} is not above lower = {low}; give upper above lower")
    first, ratio = as_number(spacing, "spacing", positive=True), as_number(growth, "growth", positive=True)
    length, excess = high - low, ratio - 1.0
    change = length * excess / first  # from the first cell to the one behind the last, as a multiple of the first
    if 1.0 + change < SMALLEST:
        raise BadInput(
            f"cells that begin with spacing = {first} and shrink by growth = {ratio} fill {-first / excess:.6g} in the "
            f"end, not {length}; give a larger spacing, or a growth nearer to 1"
        )
    wanted = length / first if excess == 0.0 else log1p(change) / log(ratio)
    require_few(wanted, f"spacing = {first}")
    count = max(1, round(wanted))
    steps: FloatArray = np.arange(count + 1.0)
    filled = steps if excess == 0.0 else np.expm1(steps * log(ratio))
    # Weights of both ends, so that edges of equal cells around 0 are symmetric to the last bit.
    result: FloatArray = (low * (filled[-1] - filled) + high * filled) / filled[-1]
    result[0], result[-1] = low, high  # also where the weights round
    return result


def _rising(values: ArrayLike, what: str, fewest: int) -> FloatArray:
    """A copy of numbers in a row, refused unless they rise."""
    array = np.array(as_real(values, what), dtype=np.float64)
    if array.ndim != 1 or len(array) < fewest:
        raise BadInput(f"{what} has shape {array.shape}; give at least {fewest} numbers in a row")
    require_finite(array, what)
    falling = np.flatnonzero(np.diff(array) <= 0.0)
    if falling.size:
        after = falling[0] + 1
        raise BadInput(
            f"{what}[{after}] = {array[after]} is not above {what}[{after - 1}] = {array[after - 1]}; give rising "
            "numbers"
        )
    return array
