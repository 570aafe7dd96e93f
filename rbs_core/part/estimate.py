"""How much memory bonds will take, known before they are made."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rbs_core.memory import fits, require_memory
from rbs_core.part.reach import half_family_size
from rbs_core.part.storage import TOLERANCE

BOND = 12  # bytes of a bond in a list: neighbor and inverse length
CONVERTED = 44  # bytes of a bond while a lattice becomes a list
SAMPLE = 64  # nodes whose families are counted where all might be too many
SAFE = 1.5  # by which factor more than there is such an estimate must be, to refuse
CURE = "take a smaller horizon or a larger spacing"


def require_points(owner: str, count: int, dimension: int) -> None:
    """Refuses a grid whose points do not fit: positions, those in the geometry, volumes, and what lies between.

    Raises:
        BadInput: if they need more than there is.
    """
    needed = 8.0 * count * (3 * dimension + 3)
    require_memory(needed, f"part '{owner}': a grid of {count:,} points", "take a larger spacing or a smaller geometry")


def require_lattice(owner: str, shape: tuple[int, ...], ratio: float) -> None:
    """Refuses bonds as bits that do not fit.

    Args:
        owner: name of the part.
        shape: cells per axis.
        ratio: horizon in cells.

    Raises:
        BadInput: if they need more than there is.
    """
    steps = half_family_size(shape, ratio)
    cells = float(np.prod(np.array(shape, np.float64)))
    margin = min(ratio, shape[-1]) * cells / shape[-1]
    needed = max(steps / 8, 1.0) * (cells + 2 * margin)
    require_memory(needed, f"part '{owner}': its bonds ({2 * steps:,.0f} neighbors of a node)", CURE)


def require_rows(owner: str, points: NDArray[np.float64], horizon: float) -> None:
    """Refuses lists of so many bonds that nobody need count them: where most nodes are neighbors of most others.

    Args:
        owner: name of the part.
        points: (n, d) m.
        horizon: m.

    Raises:
        BadInput: if they need more than there is.
    """
    n = len(points)
    if n < SAMPLE or fits(BOND * float(n) * n / SAFE):
        return
    limit = (horizon * (1 + TOLERANCE)) ** 2
    chosen = np.linspace(0, n - 1, SAMPLE).astype(np.int64)
    counts = [np.count_nonzero(((points - points[node]) ** 2).sum(axis=1) <= limit) - 1 for node in chosen]
    bonds = float(np.mean(counts)) * n
    if not fits(BOND * bonds / SAFE):
        require_memory(BOND * bonds, f"part '{owner}': a list of about {bonds:.2g} directed bonds", CURE)


def require_bonds(count: int) -> None:
    """Refuses a list of bonds that have been counted.

    Raises:
        BadInput: if they need more than there is.
    """
    require_memory(float(BOND * count), f"a list of {count:,} directed bonds", CURE)
