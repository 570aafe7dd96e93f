"""Patterns against dense tables."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_plugins.tangents import Pattern
from tests.unit.plugins.tangents.graphs import families


def dense(pattern):
    table = np.zeros((pattern.rows, pattern.width), bool)
    table[np.repeat(np.arange(pattern.rows), np.diff(pattern.starts)), pattern.columns] = True
    assert table.sum() == len(pattern), "an entry is there twice"
    for begin, end in zip(pattern.starts, pattern.starts[1:], strict=False):
        assert (np.diff(pattern.columns[begin:end].astype(int)) > 0).all(), "columns are not in ascending order"
    return table


@pytest.fixture
def pattern():
    return Pattern.of_families(*families()[:2])


def test_families_hold_the_node_itself(pattern):
    assert np.array_equal(dense(pattern), families()[2])


def test_the_entries_of_each_column(pattern):
    starts, rows, entries = pattern.transposed
    table = dense(pattern)
    for column in range(pattern.width):
        here = slice(starts[column], starts[column + 1])
        assert rows[here].tolist() == np.flatnonzero(table[:, column]).tolist()
        assert (pattern.columns[entries[here]] == column).all()


def test_columns_that_meet_in_a_row(pattern):
    table = dense(pattern).astype(int)
    assert np.array_equal(dense(pattern.normal), table.T @ table > 0)


def test_a_pattern_that_is_not_square():
    table = np.array([[1, 0, 1, 0], [0, 0, 1, 1]])
    pattern = Pattern(np.array([0, 2, 4]), np.nonzero(table)[1].astype(np.uint32), 4)
    assert np.array_equal(dense(pattern.normal), table.T @ table > 0)
    assert pattern.nbytes > 0
