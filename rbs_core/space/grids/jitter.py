"""Points displaced at random."""

from __future__ import annotations

import numpy as np

from rbs_core.errors import BadInput
from rbs_core.space.checks import as_number
from rbs_core.space.grids.cells import Cells, Cloud

# A share of the edge of a cell from which on a displaced point could leave its cell or meet another one.
LEAVING = 0.5


def jittered(grid: Cells, amount: float, *, seed: int = 0) -> Cells:
    """A grid with points displaced at random, so that no direction of the grid stands out.

    Args:
        grid: any grid; cells keep their volumes.
        amount: largest displacement along each axis, as a share of the edge of a cube (square, line) of the volume
            of the cell, from 0 to below 0.5.
        seed: of the random numbers; the same one gives the same points.

    Raises:
        BadInput: for an amount outside of that range.
    """
    if not isinstance(grid, Cells):
        raise BadInput(f"grid = {grid!r} is no grid; give one of rbs_core.grids, such as uniform(0.0, 1.0, 0.1)")
    share = as_number(amount, "amount")
    if not 0.0 <= share < LEAVING:
        raise BadInput(f"amount = {share} would let points leave their cells or meet; give a share from 0 to below 0.5")
    points, measures = grid.points(), grid.measures()
    edges = measures ** (1 / grid.dimension)
    points += np.random.default_rng(seed).uniform(-share, share, points.shape) * edges[:, None]
    return Cloud(points, measures, grid.spacing, f"jittered({grid!r}, {share}, seed={seed})")
