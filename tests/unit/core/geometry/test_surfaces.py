"""Points and segments as cuts: tips, sides, symmetry, speed-relevant rounds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rbs_core.errors import BadInput
from rbs_core.geometry import Point, Segment, Surfaces
from rbs_core.geometry.surfaces import ROUND
from rbs_core.space import uniform

QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=200)
NUMBERS = st.integers(-16, 16).map(lambda number: number / 10)  # many coincidences, with round-off


def pairs_of(points: np.ndarray, horizon: float) -> tuple[np.ndarray, np.ndarray]:
    """Indices of both ends of all bonds, seen from both ends."""
    lengths = np.linalg.norm(points[:, None] - points[None], axis=2)
    return np.nonzero((lengths <= horizon) & (lengths > 0.0))


def test_segment_cuts_what_passes_through_it():
    crack = Segment((-1.0, 0.0), (1.0, 0.0))
    starts = [[0.0, 1.0], [0.0, 1.0], [2.0, 1.0], [0.5, 1.0], [-3.0, 1.0]]
    ends = [[0.0, -1.0], [0.0, 0.5], [2.0, -1.0], [1.2, -1.0], [0.9, -1.0]]
    assert crack.crosses(starts, ends).tolist() == [True, False, False, True, False]
    # The last one passes the line at x = -1.05, the other way round at the mirror image.
    assert crack.crosses([[-2.9, 1.0]], [[0.9, -1.0]]).tolist() == [True]


@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 2, 2.0])
def test_bonds_through_a_tip_cross_and_those_beside_it_do_not(angle):
    axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    tips = np.array([[-0.005, 0.0], [0.005, 0.0]]) @ axes + [0.1, 0.2]
    crack = Segment(*tips)
    for side in (-1.0, 1.0):
        at = np.array([side * 0.005, 0.0])
        for direction in ([0.0, 1.0], [1.0, 1.0], [-3.0, 1.0]):
            arm = 1e-4 * np.array(direction)
            starts, ends = ((at + sign * arm) @ axes + [0.1, 0.2] for sign in (1, -1))
            assert crack.crosses([starts], [ends]).all()
            beside = np.array([side * 1e-8, 0.0]) @ axes
            assert not crack.crosses([starts + beside], [ends + beside]).any()
            assert crack.crosses([starts - beside], [ends - beside]).all()


def test_ends_on_the_line_belong_to_the_positive_side():
    crack = Segment((-1.0, 0.0), (1.0, 0.0))  # positive side: y > 0
    on, below, above = [0.5, 0.0], [0.5, -1.0], [0.5, 1.0]
    assert crack.crosses([on, on], [below, above]).tolist() == [True, False]
    assert Segment((1.0, 0.0), (-1.0, 0.0)).crosses([on, on], [below, above]).tolist() == [False, True]
    assert not crack.crosses([[-0.5, 0.0]], [[0.5, 0.0]]).any()
    # Round-off below the line is still on it, and the bond then leaves from there.
    assert crack.crosses([[0.5, -1e-10]], [below]).all()
    assert not crack.crosses([[0.5, -1e-10]], [above]).any()
    assert not crack.crosses([[1.5, -1e-10]], [[0.9, -1.0]]).any()
    # ... also when the other end is hardly deeper: the bond does not reach the crack.
    assert not crack.crosses([[1.5, -1.9e-9]], [[0.0, -2.1e-9]]).any()
    # Both ends below, one just beyond the tolerance: no blow-up of the meeting point.
    assert crack.crosses([[0.5, -2e-9]], [[0.6, -2.0000001e-9 - 1e-9]]).tolist() == [True]
    assert crack.crosses([[1.5, -2e-9]], [[0.9, -3e-9]]).tolist() == [False]


@QUIET
@given(
    arrays(float, (6, 2), elements=NUMBERS),
    arrays(float, (6, 2), elements=NUMBERS),
    arrays(float, (2, 2), elements=NUMBERS),
)
def test_a_bond_and_its_reverse_get_the_same_answer(starts, ends, tips):
    if np.array_equal(*tips):
        return
    crack = Segment(*tips)
    assert np.array_equal(crack.crosses(starts, ends), crack.crosses(ends, starts))


@pytest.mark.parametrize("cells", [(20, 20), (21, 20), (20, 26)])
@pytest.mark.parametrize("half", [0.25, 0.3, 0.275])
def test_symmetric_meshes_are_cut_symmetrically(cells, half):
    spacing = 0.05
    sides = np.array(cells) * spacing
    points = uniform(-sides / 2, sides / 2, spacing).points()
    start, end = pairs_of(points, 3.015 * spacing)
    crack = Segment((-half, 0.0), (half, 0.0))
    cut = crack.crosses(points[start], points[end])
    assert 0 < cut.sum() < len(cut)
    for mirror in ([-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]):
        assert np.array_equal(crack.crosses(points[start] * mirror, points[end] * mirror), cut)
    assert np.array_equal(crack.crosses(points[end], points[start]), cut)


def test_directed_bonds_cut_by_the_crack_of_a_plate():
    # Around the crack the lattice is that of the plate with 500 nodes on 50 mm; counted in whole numbers.
    spacing, reach = 1e-4, 3
    points = uniform((-0.006, -reach * spacing), (0.006, reach * spacing), spacing).points()
    twice = np.rint(points / spacing * 2).astype(int)  # coordinates in half spacings: odd numbers
    count, cut = 0, 0
    crack = Segment((-0.005, 0.0), (0.005, 0.0))
    for dx in range(-reach, reach + 1):
        for dy in range(1, reach + 1):
            if dx * dx + dy * dy > 9:
                continue
            upward = (twice[:, 1] < 0) & (twice[:, 1] + 2 * dy > 0)
            x, y = twice[upward].T
            count += 2 * int((np.abs(x * dy - y * dx) <= 100 * dy).sum())
            starts = points[upward]
            cut += 2 * int(crack.crosses(starts, starts + spacing * np.array([dx, dy])).sum())
    assert cut == count == 3612


@pytest.mark.parametrize("angle", [0.0, 0.3, 2.0])
@pytest.mark.parametrize("length", [1e-8, 1.0, 100.0, 1e4])
def test_the_length_of_a_segment_does_not_move_it(angle, length):
    spacing = 1e-9
    axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    points = uniform((-4 * spacing, -4 * spacing), (4 * spacing, 4 * spacing), spacing).points()
    start, end = pairs_of(points, 3.015 * spacing)
    crack = Segment(*(np.array([[-length / 2, 0.0], [length / 2, 0.0]]) @ axes))
    turned = points @ axes
    cut = crack.crosses(turned[start], turned[end])
    away = (points[start, 1] > 0) != (points[end, 1] > 0)
    if length > 1e-7:
        assert np.array_equal(cut, away)
    assert 0 < cut.sum() <= away.sum()
    assert np.array_equal(crack.crosses(turned[end], turned[start]), cut)


def test_nodes_on_a_long_segment_stay_on_it_and_tips_stay_closed():
    for angle in np.linspace(0.0, 3.0, 31):
        along, left = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        crack = Segment(-500.0 * along, 500.0 * along)
        on = np.linspace(-400.0, 400.0, 9)[:, None] * along  # up to round-off of 400 m, which is 6e-14 m
        assert crack.crosses(on, on - 1e-9 * left).all()
        assert not crack.crosses(on, on + 1e-9 * left).any()
        above, below = 500.0 * along + 1e-6 * left, 500.0 * along - 1e-6 * left  # through the tip
        assert crack.crosses([above], [below]).all()
        assert not crack.crosses([above + 1e-9 * along], [below + 1e-9 * along]).any()


def test_a_point_far_from_the_origin_cuts_where_it_is():
    for x in (1.0, -1e3, 1e6):
        nodes = x + 1e-10 * abs(x) * np.arange(-4, 4)[:, None]
        starts, ends = nodes[:-1], nodes[1:]
        cut = Point(x).crosses(starts, ends)
        assert cut.tolist() == [False, False, False, True, False, False, False]
        assert np.array_equal(Point(x).crosses(ends, starts), cut)


@QUIET
@given(
    arrays(float, (6, 2), elements=NUMBERS),
    arrays(float, (6, 2), elements=NUMBERS),
    st.sampled_from([1e-9, 1e-6, 1.0]),
    st.sampled_from([1.0, 1e3, 1e6]),
)
def test_at_any_scale_a_bond_and_its_reverse_get_the_same_answer(starts, ends, small, large):
    crack = Segment((-0.3 * large, -0.1 * large), (0.3 * large, 0.1 * large))
    forth = crack.crosses(small * starts, small * ends)
    assert np.array_equal(forth, crack.crosses(small * ends, small * starts))
    assert np.array_equal(forth, crack.crosses(small * starts, small * ends))


def test_rounds_do_not_change_the_result():
    rng = np.random.default_rng(6)
    starts = rng.uniform(-1.0, 1.0, (ROUND + 1000, 2))
    ends = starts + rng.uniform(-0.2, 0.2, starts.shape)
    crack = Segment((-0.5, 0.1), (0.5, -0.1))
    whole = crack.crosses(starts, ends)
    parts = np.concatenate([crack.crosses(starts[i::7], ends[i::7]) for i in range(7)])
    assert np.array_equal(np.concatenate([whole[i::7] for i in range(7)]), parts)
    assert crack.crosses(np.zeros((0, 2)), np.zeros((0, 2))).shape == (0,)
    short = starts.astype(np.float32)
    assert np.array_equal(crack.crosses(short, ends), crack.crosses(short.astype(float), ends))


def test_point_cuts_a_line():
    cut = Point(0.3)
    assert cut.crosses([[0.0], [0.3], [0.3], [0.4]], [[1.0], [0.2], [0.4], [0.5]]).tolist() == [
        True,
        True,
        False,
        False,
    ]
    assert cut.crosses([[0.1 + 0.2]], [[0.2]]).all()
    assert cut.crosses([[0.3 - 1e-12]], [[0.2]]).all()
    assert Point(0.0).crosses([[-1e-12]], [[1e-3]]).tolist() == [False]


@QUIET
@given(arrays(float, (6, 1), elements=NUMBERS), arrays(float, (6, 1), elements=NUMBERS), NUMBERS)
def test_point_a_bond_and_its_reverse_get_the_same_answer(starts, ends, x):
    assert np.array_equal(Point(x).crosses(starts, ends), Point(x).crosses(ends, starts))


def test_several_surfaces_cut_what_any_of_them_cuts():
    first, second, third = Segment((0, 0), (1, 0)), Segment((0, 0), (0, 1)), Segment((2, 0), (2, 3))
    all_three = first | second | third
    assert all_three == Surfaces(first, second, third) == first | (second | third)
    assert all_three.dimension == 2
    assert np.array_equal(all_three.bounds, [[0.0, 0.0], [2.0, 3.0]])
    starts, ends = [[0.5, 1], [-1, 0.5], [1.5, 2], [5, 5]], [[0.5, -1], [0.2, 0.5], [2.5, 2], [6, 6]]
    assert all_three.crosses(starts, ends).tolist() == [True, True, True, False]


def test_bounds_and_dimension():
    assert np.array_equal(Segment((1, 0), (0, 2)).bounds, [[0.0, 0.0], [1.0, 2.0]])
    assert np.array_equal(Point(3).bounds, [[3.0], [3.0]])
    assert (Point(0).dimension, Segment((0, 0), (1, 1)).dimension) == (1, 2)
    assert repr(Segment((0, 0), (1, 0.5))) == "Segment(start=(0.0, 0.0), end=(1.0, 0.5))"


CRACK = Segment((0, 0), (1, 0))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: Segment((1, 2), (1, 2)),
            r"start = end = \(1.0, 2.0\): a segment without length; give two different tips",
        ),
        (lambda: Segment(1.0, 2.0), r"start = .* has 1 component; give 2 or 3 \(1-D: Point to cut"),
        (
            lambda: Segment((1, 2, 3), (1, 2, 4)).crosses(np.zeros((1, 3)), np.ones((1, 3))),
            r"no bond can cross Segment\(.*\): in 3-D bonds pass by a line; cut with a Polygon",
        ),
        (lambda: Segment((1, np.nan), (1, 2)), r"start\[1\] = nan is not finite"),
        (
            lambda: Point((1, 2)).crosses(np.zeros((1, 2)), np.ones((1, 2))),
            r"no bond can cross Point\(.*\): a point cuts in 1-D alone; cut with a Segment",
        ),
        (lambda: Surfaces(), r"Surfaces\(\) holds no surface; give one at least"),
        (lambda: CRACK | Point(0.0), r"Segment\(.*\) has dimension 2, Point\(.*\) has 1"),
        (
            lambda: CRACK.crosses(np.zeros((3, 2)), np.zeros((4, 2))),
            r"starts has shape \(3, 2\), ends has \(4, 2\); give both",
        ),
        (
            lambda: CRACK.crosses(np.zeros((3, 3)), np.zeros((3, 3))),
            r"starts has 3 columns, but Segment\(.*\) has dimension 2",
        ),
        (lambda: CRACK.crosses([0, 0], [1, 1]), r"starts has shape \(2,\)"),
        (
            lambda: CRACK.crosses(np.zeros((ROUND + 9, 2)), np.vstack([np.zeros((ROUND + 8, 2)), [[0, np.inf]]])),
            rf"ends\[{ROUND + 8}, 1\] = inf is not finite",
        ),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
