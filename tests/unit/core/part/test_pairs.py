"""Which points are near each other."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.part.pairs import pairs_among, pairs_between


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_pairs_are_those_of_all_distances(dimension, rng):
    one, two = rng.uniform(size=(40, dimension)), rng.uniform(size=(30, dimension)) + 0.3
    far = np.linalg.norm(one[:, None] - two[None], axis=2)
    assert pairs_between(one, two, 0.2).tolist() == np.argwhere(far <= 0.2).tolist()
    within = np.linalg.norm(one[:, None] - one[None], axis=2)
    assert pairs_among(one, 0.2).tolist() == np.argwhere(np.triu(within <= 0.2, 1)).tolist()


def test_a_distance_that_is_met_counts_though_it_is_rounded():
    one = np.arange(10.0)[:, None] * 0.1
    assert len(pairs_between(one, one + 1.0, 0.1)) == 1
    assert len(pairs_among(one, 0.3)) == 9 + 8 + 7


def test_nothing_is_near():
    one = np.zeros((3, 2))
    assert pairs_between(one, one + 5.0, 1.0).shape == (0, 2)
    assert pairs_among(np.eye(3) * 9.0, 1.0).shape == (0, 2)
    assert pairs_among(np.eye(3) * 9.0, 1.0).dtype == np.int64
