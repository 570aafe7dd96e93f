"""Who is within the horizon: compressed rows of neighbors, from lattice offsets or from a cell list.

Both count first and then fill, in parallel, every row in ascending order: the result does not depend on the number of
threads. The horizon is widened by one part in 1e9, so that on a grid with horizon = m * spacing the nodes exactly on
the horizon belong to the family in every direction alike.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from rbs_core.part.estimate import require_bonds
from rbs_core.part.storage import TOLERANCE

Rows = tuple[NDArray[np.int64], NDArray[np.uint32], NDArray[np.float64]]


def lattice_rows(
    points: NDArray[np.float64], cells: NDArray[np.int64], shape: tuple[int, ...], spacing: float, horizon: float
) -> Rows:
    """Families of nodes on a regular grid: who belongs to them is decided in whole numbers of cells.

    Args:
        points: (n, d) positions, from which the lengths are taken, rounding and all: rest is rest then.
        cells: (n,) ascending linear cell indices (x fastest) of the nodes.
        shape: cells per axis.
        spacing: of the grid, m.
        horizon: radius of a family, m.

    Returns:
        offsets (n+1,), neighbors (m,), inverse reference lengths (m,) in 1/m.
    """
    # no further than the grid is long, so that a huge horizon (metres for millimetres) costs no memory
    reach = [int(min(horizon / spacing * (1 + TOLERANCE), cells - 1)) for cells in (*shape, 1, 1)[:3]]
    axes = [np.arange(-steps, steps + 1) for steps in reach]
    dz, dy, dx = (a.ravel() for a in np.meshgrid(axes[2], axes[1], axes[0], indexing="ij"))
    squared = dx * dx + dy * dy + dz * dz
    near = (squared > 0) & (squared <= (horizon / spacing * (1 + TOLERANCE)) ** 2)
    steps = np.stack([dx[near], dy[near], dz[near]], axis=1)
    nx, ny, nz = (*shape, 1, 1)[:3]
    node_of = np.full(nx * ny * nz, -1, np.int64)
    node_of[cells] = np.arange(len(cells))
    return _count_then_fill(len(cells), _lattice_pass, (_padded(points), cells, node_of, nx, ny, nz, steps))


def cloud_rows(points: NDArray[np.float64], horizon: float) -> Rows:
    """Families of any cloud of points (n, d); returns as `lattice_rows`."""
    n = len(points)
    padded = _padded(points)
    low = padded.min(axis=0)
    extent = padded.max(axis=0) - low
    # cells as wide as the horizon, but never so many that the table outgrows the points
    width = horizon * (1 + 2 * TOLERANCE)
    while np.prod(np.floor(extent / width) + 1) > 4 * n + 64:
        width *= 2
    shape = np.floor(extent / width).astype(np.int64) + 1
    place = np.minimum((padded - low) // width, shape - 1).astype(np.int64)
    cell = place[:, 0] + shape[0] * (place[:, 1] + shape[1] * place[:, 2])
    order = np.argsort(cell, kind="stable")
    starts = np.searchsorted(cell[order], np.arange(np.prod(shape) + 1))
    limit = (horizon * (1 + TOLERANCE)) ** 2
    return _count_then_fill(n, _cloud_pass, (padded, place, shape, order, starts, limit))


def _padded(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (n, 3), with zeros for the dimensions that a part does not have."""
    padded = np.zeros((len(points), 3))
    padded[:, : points.shape[1]] = points
    return padded


def _count_then_fill(nodes: int, search: Any, arguments: tuple[Any, ...]) -> Rows:
    """Two calls of a pass: one that counts, one that fills rows of just the right size."""
    offsets = np.zeros(nodes + 1, np.int64)
    search(*arguments, offsets, np.empty(0, np.uint32), np.empty(0))
    np.cumsum(offsets, out=offsets)
    require_bonds(int(offsets[-1]))
    neighbors, lengths = np.empty(offsets[-1], np.uint32), np.empty(offsets[-1])
    search(*arguments, offsets, neighbors, lengths)
    return offsets, neighbors, lengths


@njit(inline="always")
def _inverse_length(points: Any, i: int, j: int) -> float:
    dx, dy, dz = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
    return 1.0 / math.sqrt(dx * dx + dy * dy + dz * dz)


@njit(inline="always")
def _lattice_row(cell: int, node_of: Any, nx: int, ny: int, nz: int, steps: Any, row: Any, fill: bool) -> int:
    """Finds the neighbors of a cell; writes them if asked to. Returns how many there are."""
    x, y, z = cell % nx, (cell // nx) % ny, cell // (nx * ny)
    found = 0
    for k in range(steps.shape[0]):
        u, v, w = x + steps[k, 0], y + steps[k, 1], z + steps[k, 2]
        if 0 <= u < nx and 0 <= v < ny and 0 <= w < nz:
            j = node_of[u + nx * (v + ny * w)]
            if j >= 0:
                if fill:
                    row[found] = j
                found += 1
    return found


@njit(parallel=True, cache=True)
def _lattice_pass(
    points: Any, cells: Any, node_of: Any, nx: int, ny: int, nz: int, steps: Any, offsets: Any, rows: Any, lengths: Any
) -> None:
    """Counts into offsets[1:] while there is no room for neighbors, fills the rows otherwise."""
    fill = rows.size > 0
    for i in prange(cells.size):
        begin, end = (offsets[i], offsets[i + 1]) if fill else (0, 0)
        found = _lattice_row(cells[i], node_of, nx, ny, nz, steps, rows[begin:end], fill)
        if not fill:
            offsets[i + 1] = found
        for q in range(begin, end):
            lengths[q] = _inverse_length(points, i, rows[q])


@njit(inline="always")
def _cloud_row(
    i: int, points: Any, place: Any, shape: Any, order: Any, starts: Any, limit: float, row: Any, fill: bool
) -> int:
    """Finds the neighbors of a point in the cells around it; writes them if asked to. Returns how many there are."""
    found = 0
    for w in range(max(place[i, 2] - 1, 0), min(place[i, 2] + 2, shape[2])):
        for v in range(max(place[i, 1] - 1, 0), min(place[i, 1] + 2, shape[1])):
            first = shape[0] * (v + shape[1] * w)
            low, high = max(place[i, 0] - 1, 0), min(place[i, 0] + 2, shape[0])
            for q in range(starts[first + low], starts[first + high]):
                j = order[q]
                dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
                dz = points[j, 2] - points[i, 2]
                if j != i and dx * dx + dy * dy + dz * dz <= limit:
                    if fill:
                        row[found] = j
                    found += 1
    return found


@njit(parallel=True, cache=True)
def _cloud_pass(
    points: Any, place: Any, shape: Any, order: Any, starts: Any, limit: float, offsets: Any, rows: Any, lengths: Any
) -> None:
    """Counts into offsets[1:] while there is no room for neighbors, fills the rows otherwise."""
    fill = rows.size > 0
    for i in prange(points.shape[0]):
        begin, end = (offsets[i], offsets[i + 1]) if fill else (0, 0)
        row = rows[begin:end]
        found = _cloud_row(i, points, place, shape, order, starts, limit, row, fill)
        if not fill:
            offsets[i + 1] = found
            continue
        row.sort()
        for q in range(row.size):
            lengths[begin + q] = _inverse_length(points, i, row[q])
