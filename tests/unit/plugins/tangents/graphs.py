"""Small graphs of nodes for the tests of patterns."""

from __future__ import annotations

import numpy as np


def families(n=12, seed=0):
    """Offsets and neighbors of a random symmetric graph, and its matrix with every node beside itself."""
    rng = np.random.default_rng(seed)
    bonded = rng.random((n, n)) < 0.2
    bonded |= bonded.T
    bonded[0] = bonded[:, 0] = False  # a node alone
    np.fill_diagonal(bonded, False)
    offsets = np.concatenate([[0], np.cumsum(bonded.sum(axis=1))]).astype(np.int64)
    return offsets, np.nonzero(bonded)[1].astype(np.uint32), bonded | np.eye(n, dtype=bool)
