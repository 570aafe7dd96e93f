"""One axis: edges in steps that grow, points between edges, edges between points."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rbs_core.errors import BadInput
from rbs_core.space.grids.axis import Axis, edges

QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=200)


def test_points_lie_in_the_middle_of_their_cells():
    axis = Axis([0.0, 1.0, 3.0])
    assert axis.coordinates.tolist() == [0.5, 2.0]
    assert axis.sizes.tolist() == [1.0, 2.0]
    assert len(axis) == 2
    with pytest.raises(ValueError, match="read-only"):
        axis.edges[0] = 7.0


def test_points_may_lie_elsewhere_in_their_cells():
    assert Axis([0.0, 1.0, 3.0], [0.1, 2.9]).coordinates.tolist() == [0.1, 2.9]


def test_cells_end_halfway_between_given_points():
    axis = Axis.through([0.0, 1.0, 3.0])
    assert axis.edges.tolist() == [-0.5, 0.5, 2.0, 4.0]
    assert axis.coordinates.tolist() == [0.0, 1.0, 3.0]


def test_equal_edges():
    assert edges(0.0, 1.0, 0.1).tolist() == [i / 10 for i in range(11)]
    assert len(edges(0.0, 1.0, 0.26)) == 5
    assert edges(2.0, 5.0, 100.0).tolist() == [2.0, 5.0]


@QUIET
@given(st.floats(1e-6, 1e3), st.integers(1, 50))
def test_equal_edges_around_zero_are_symmetric_to_the_bit(half, count):
    result = edges(-half, half, 2 * half / count)
    assert len(result) == count + 1
    assert np.array_equal(result, -result[::-1])


@QUIET
@given(st.floats(-10.0, 10.0), st.floats(0.1, 10.0), st.floats(0.01, 0.5), st.floats(0.8, 1.3))
def test_cells_grow_by_the_factor_and_fill_the_interval(lower, length, share, growth):
    first = share * length
    if growth < 1.0 and first / (1.0 - growth) <= length * 1.0001:  # they would not reach the end
        return
    result = edges(lower, lower + length, first, growth=growth)
    sizes = np.diff(result)
    assert (result[0], result[-1]) == (lower, lower + length)
    assert np.allclose(sizes[1:] / sizes[:-1], growth, rtol=0, atol=1e-13 * (abs(lower) + length) / sizes.min())
    # one cell more or less would begin further away from what was asked for, about
    assert 0.5 * first < sizes[0] * max(1.0, growth) ** 0.5 < 2.0 * first or len(sizes) == 1


def test_known_graded_edges():
    assert np.allclose(edges(0.0, 7.0, 1.0, growth=2.0), [0.0, 1.0, 3.0, 7.0], rtol=1e-15)
    assert np.allclose(edges(0.0, 1.75, 1.0, growth=0.5), [0.0, 1.0, 1.5, 1.75], rtol=1e-15)


def test_repr():
    assert repr(Axis([0, 1])) == "(0.0, 1.0)"
    assert repr(Axis([0, 1], [0.25])) == "Axis((0.0, 1.0), (0.25,))"
    assert repr(Axis(edges(0.0, 1.0, 0.01))) == "<100 cells from 0.0 to 1.0>"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Axis([0.0, 1.0, 1.0]), r"edges\[2\] = 1.0 is not above edges\[1\] = 1.0; give rising numbers"),
        (lambda: Axis([1.0]), r"edges has shape \(1,\); give at least 2 numbers in a row"),
        (lambda: Axis([[0.0, 1.0]]), r"edges has shape \(1, 2\)"),
        (lambda: Axis([0.0, np.inf]), r"edges\[1\] = inf is not finite"),
        (
            lambda: Axis([0.0, 1.0], [0.2, 0.4]),
            r"coordinates has 2 points, edges make 1 cells; give one point per cell",
        ),
        (lambda: Axis([0, 1, 2], [0.5, 2.5]), r"coordinates\[1\] = 2.5 is not within its cell from 1.0 to 2.0"),
        (lambda: Axis.through([1.0]), r"coordinates has shape \(1,\); give at least 2"),
        (lambda: edges(1.0, 1.0, 0.1), r"upper = 1.0 is not above lower = 1.0; give upper above lower"),
        (lambda: edges(0.0, 1.0, 0.0), r"spacing = 0.0 is not positive"),
        (lambda: edges(0.0, 1.0, 0.1, growth=-1.0), r"growth = -1.0 is not positive"),
        (
            lambda: edges(0.0, 1.0, 0.1, growth=0.5),
            r"begin with spacing = 0.1 and shrink by growth = 0.5 fill 0.2 in the end, not 1.0; give a larger spacing",
        ),
        (lambda: edges(0.0, 1.0, 1e-12), r"spacing = 1e-12 would make 1e\+12 points, more than 4294967295; make fewer"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
