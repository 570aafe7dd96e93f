"""Block matrices against dense ones."""

from __future__ import annotations

import numpy as np

from rbs_plugins.tangents import BlockMatrix, Pattern
from tests.unit.plugins.tangents.graphs import families


def filled(dimension, rng, **given):
    """A matrix of random numbers, and the same as (n, n, d, d)."""
    matrix = BlockMatrix(Pattern.of_families(*families()[:2]), dimension, **given)
    matrix.data[...] = rng.normal(size=len(matrix.data))
    return matrix


def test_the_matrix_has_blocks_where_the_pattern_has_entries(rng):
    matrix = filled(2, rng).matrix
    assert np.array_equal(matrix.toarray() != 0, np.kron(families()[2], np.ones((2, 2))) != 0)
    assert matrix.has_sorted_indices
    matrix.check_format()


def test_nodes_of_a_few_among_many(rng):
    nodes = np.arange(12) * 2 + 1
    some = filled(2, rng, nodes=nodes, count=30)
    whole = some.matrix.toarray()
    rows = (2 * nodes[:, None] + np.arange(2)).ravel()
    assert whole.shape == (60, 60)
    alone = BlockMatrix(some.pattern, 2)
    alone.data[...] = some.data
    assert np.array_equal(whole[np.ix_(rows, rows)], alone.matrix.toarray())
    assert np.count_nonzero(whole) == np.count_nonzero(some.data)


def test_blocks_in_turned_coordinates(rng):
    for d in (1, 2, 3):
        matrix = filled(d, rng)
        turns = np.array([np.eye(d), np.linalg.qr(rng.normal(size=(d, d)))[0]])
        owners = (np.arange(12) % 2).astype(np.uint8)
        whole = np.zeros((12 * d, 12 * d))
        for node, owner in enumerate(owners):
            whole[node * d : node * d + d, node * d : node * d + d] = turns[owner]
        expected = whole.T @ matrix.matrix.toarray() @ whole
        matrix.turn(owners, turns)
        assert np.allclose(matrix.matrix.toarray(), expected, rtol=0, atol=1e-14)
        matrix.clear()
        assert not matrix.matrix.toarray().any()
        assert matrix.nbytes > 0
