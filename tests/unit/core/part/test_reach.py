"""Steps to the neighbors on a grid, and their number, which is known without them."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.part.reach import half_family_size, half_steps


@pytest.mark.parametrize("shape", [(9,), (40,), (9, 9), (3, 20), (6, 7, 8), (2, 2, 30)])
@pytest.mark.parametrize("ratio", [1.0, 2.5, 3.015, 7.0, 1000.0])
def test_the_number_of_steps(shape, ratio):
    vectors, steps = half_steps(shape, ratio)
    assert half_family_size(shape, ratio) == len(vectors) == len(steps)


def test_one_of_two_opposite_steps():
    vectors, steps = half_steps((9, 9), 1.5)
    assert vectors.tolist() == [[1, 0], [-1, 1], [0, 1], [1, 1]]
    assert steps.tolist() == [1, 8, 9, 10]
    assert (np.linalg.norm(vectors, axis=1) <= 1.5).all()
