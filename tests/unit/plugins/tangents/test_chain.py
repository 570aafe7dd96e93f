"""Chains against dense products."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_plugins.tangents import BlockMatrix, Chain, Pattern
from tests.unit.plugins.tangents.graphs import families


def dense(chain, blocks):
    """C, or L, as (rows q, columns d)."""
    rows = np.repeat(np.arange(chain.pattern.rows), np.diff(chain.pattern.starts))
    d = chain.dimension
    full = np.zeros((chain.pattern.rows, chain.size, chain.pattern.width, d))
    for row, column, block in zip(rows, chain.pattern.columns, blocks, strict=True):
        full[row, :, column] = np.kron(np.eye(d), block[:, None]) if block.ndim == 1 else block
    return full.reshape(chain.pattern.rows * chain.size, -1)


@pytest.mark.parametrize(("d", "q", "gradient"), [(2, 1, False), (2, 4, True)])
def test_what_a_chain_computes(d, q, gradient, rng):
    chain = Chain(Pattern.of_families(*families()[:2]), d, q, gradient=gradient, apart=gradient)
    chain.left[...] = rng.normal(size=chain.blocks.shape)
    chain.blocks[...] = rng.normal(size=chain.blocks.shape)
    chain.weights[...] = rng.normal(size=chain.weights.shape)
    C, L, G = dense(chain, chain.blocks), dense(chain, chain.left), np.zeros((12, q, 12, q))
    G[np.arange(12), :, np.arange(12)] = chain.weights
    expected = L.T @ G.reshape(12 * q, 12 * q) @ C
    matrix = BlockMatrix(chain.pattern.normal, d)
    chain.add_to(matrix)
    limit = 1e-14 * np.abs(expected).max()
    assert np.allclose(matrix.matrix.toarray(), expected, rtol=0, atol=limit)
    v, out = rng.normal(size=12 * d), np.ones(12 * d)
    chain.multiply(v, out)
    assert np.allclose(out - 1, expected @ v, rtol=0, atol=20 * limit)
    out = np.ones(12 * d)
    chain.diagonal(out)
    assert np.allclose(out - 1, np.diag(expected), rtol=0, atol=20 * limit)
    assert np.allclose(chain.sums(v).ravel(), C @ v, rtol=0, atol=1e-13)
    assert chain.nbytes > 0
