"""Which representation suits the nodes of a part, and the search that fills it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput
from rbs_core.part.estimate import require_lattice, require_rows
from rbs_core.part.lattice import Lattice
from rbs_core.part.rows import Rows
from rbs_core.part.storage import TOLERANCE, Crosses, Storage
from rbs_core.space import Grid

Predicate = Callable[[NDArray[np.float64], NDArray[np.float64]], ArrayLike]
STORAGES = ("list", "lattice")
# A lattice also works on the empty cells of its grid; from this share of filled ones on it is faster than a list.
FILLED = 0.3


def families(
    owner: str,
    positions: NDArray[np.float64],
    place: tuple[Grid | None, NDArray[np.int64] | None],
    reach: float,
    storage: str | None,
    real: str,
) -> Storage:
    """The bonds of all nodes to all others within reach.

    Args:
        owner: name of the part, for messages.
        positions: (n, d), m.
        place: the grid that the nodes were laid on, None for nodes from elsewhere, and their cells in it, None for all.
        reach: radius within which nodes are bonded, m.
        storage: "list", "lattice", or None for what suits the nodes.
        real: type of bond fields of real numbers.

    Raises:
        BadInput: on an unknown storage, a lattice for nodes that are not on a grid, two nodes at one place, or bonds
            that do not fit into memory.
    """
    if storage not in (*STORAGES, None):
        raise BadInput(f"part '{owner}': storage={storage!r} must be one of {', '.join(STORAGES)} or None")
    grid, cells = place
    cells = np.arange(len(positions)) if cells is None else cells
    # somebody may have moved the nodes off the grid since
    if grid is None or not np.array_equal(positions, grid.points()[cells]):
        if storage == "lattice":
            raise BadInput(
                f"part '{owner}': its nodes are not those of a regular grid, which storage='lattice' needs: use "
                "part.discretize, or storage='list'"
            )
        return _of_cloud(owner, positions, reach, real)
    if storage == "lattice" or (storage is None and len(cells) >= FILLED * len(grid)):
        require_lattice(owner, grid.shape, reach / grid.spacing * (1 + TOLERANCE))
        return Lattice(f"part '{owner}'", positions, cells, grid.shape, grid.spacing, reach, real)
    from rbs_core.part import search  # numba is loaded when first needed, not by the import of the package

    require_rows(owner, positions, reach)
    rows = search.lattice_rows(positions, cells, grid.shape, grid.spacing, reach)
    return Rows(f"part '{owner}'", positions, rows, real)


def _of_cloud(owner: str, positions: NDArray[np.float64], horizon: float, real: str) -> Rows:
    from rbs_core.part import search

    require_rows(owner, positions, horizon)
    rows = search.cloud_rows(positions, horizon)
    together = np.flatnonzero(~np.isfinite(rows[2]))
    if len(together):
        node = int(np.searchsorted(rows[0], together[0], side="right")) - 1
        raise BadInput(
            f"part '{owner}': nodes {node} and {rows[1][together[0]]} are at the same place "
            f"{positions[node].tolist()}: remove one"
        )
    return Rows(f"part '{owner}'", positions, rows, real)


def left_out(name: str, where: Predicate) -> Crosses:
    """A function that is True for bonds of which a predicate is not.

    It raises BadInput where the predicate does not return one truth value per bond, or another one for the way back.
    """

    def asked(starts: NDArray[np.float64], ends: NDArray[np.float64]) -> NDArray[np.bool_]:
        there = np.asarray(where(starts, ends))
        if there.shape != (len(starts),) or there.dtype != np.bool_:
            raise BadInput(f"part '{name}': where(starts, ends) must return one truth value per bond")
        return there

    def crosses(starts: NDArray[np.float64], ends: NDArray[np.float64]) -> NDArray[np.bool_]:
        there = asked(starts, ends)
        differ = np.flatnonzero(there != asked(ends, starts))
        if len(differ):
            first = f"{starts[differ[0]].tolist()} to {ends[differ[0]].tolist()}"
            raise BadInput(
                f"part '{name}': where(starts, ends) says {there[differ[0]]} of the bond from {first}, and something "
                "else of the way back: a bond is there from both ends or not at all, so let it depend on both alike"
            )
        return ~there

    return crosses
