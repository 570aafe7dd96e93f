"""Small loops between nodes and cells for correspondence models."""

from __future__ import annotations


def take_state(begin, end, thread, field, by_cell, cells):
    """Copies states (n, k) of nodes to their cells (k, size)."""
    for i in range(begin, end):
        for k in range(by_cell.shape[0]):
            by_cell[k, cells[i]] = field[i, k]
    return 0


def keep_state(begin, end, thread, field, by_cell, cells):
    """Copies states by cell (k, size) to their nodes (n, k)."""
    for i in range(begin, end):
        for k in range(by_cell.shape[0]):
            field[i, k] = by_cell[k, cells[i]]
    return 0
