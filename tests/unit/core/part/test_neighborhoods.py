"""Bonds: cutting, removing, and what both ends agree on."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, Box, Part, Segment, intact
from tests.unit.core.toys import field, line, strength

pull = field("pull", at="bond", shape="vector")
zone = rbs.Field("zone", "bond", "scalar", "1", "z", "A test.", "uint8", 1)


@pytest.fixture(params=["list", "lattice"])
def storage(request) -> str:
    return str(request.param)


def plate(storage: str | None = None) -> Part:
    """6 x 6 nodes at whole numbers plus a half, around the origin."""
    return Part("plate", Box(size=(6.0, 6.0))).discretize(1.0).connect(2.0, storage=storage)


def crossing(part: Part) -> np.ndarray:
    """(m,) bonds whose ends lie on different sides of y = 0, found one by one."""
    y = part.positions[:, 1]
    return np.array([(y[i] > 0) != (y[j] > 0) for i, j in part.bonds])


def test_rows_iteration_and_families_say_the_same(storage):
    part = line(4).connect(2.0, storage=storage)
    bonds = part.bonds
    offsets, neighbors = bonds.as_rows()
    assert offsets.tolist() == [0, 2, 5, 8, 10]
    assert neighbors.tolist() == [1, 2, 0, 2, 3, 0, 1, 3, 1, 2]
    assert (offsets.dtype, neighbors.dtype) == (np.int64, np.uint32)
    assert list(bonds) == [(i, int(j)) for i in range(4) for j in bonds.neighbors(i)]
    assert bonds.counts().tolist() == [2, 3, 3, 2]
    assert bonds.family(1) == slice(2, 5)
    assert bonds.lengths.tolist() == [1.0, 2.0, 1.0, 1.0, 2.0, 2.0, 1.0, 1.0, 2.0, 1.0]
    assert np.array_equal(bonds.inverse_lengths, 1.0 / bonds.lengths)
    assert (len(bonds), bonds.horizon, bonds.storage) == (10, 2.0, storage)
    assert repr(bonds) == f"<10 directed bonds of 4 nodes, horizon 2 m, stored as {storage}>"


# -- cut ------------------------------------------------------------------------------------------------------------


def test_a_cut_breaks_the_bonds_that_cross_and_keeps_them(storage):
    part = plate(storage)
    expected, count = crossing(part), len(part.bonds)
    assert not part.bonds.has_broken
    assert part.bonds.cut(Segment((-9.0, 0.0), (9.0, 0.0))) == expected.sum() > 0
    assert np.array_equal(part.bonds.intact, ~expected)
    assert np.array_equal(part[intact], (~expected).astype(np.uint8))
    assert (len(part.bonds), part.bonds.has_broken) == (count, True)


def test_a_cut_counts_only_what_it_breaks_itself(storage):
    part = plate(storage)
    half = part.bonds.cut(Segment((-9.0, 0.0), (0.01, 0.0)))
    again = rf"part 'plate': bonds.cut\(Segment\(.*\)\) broke nothing: the {half} directed bonds .* were broken before"
    with pytest.warns(UserWarning, match=again) as warned:
        assert part.bonds.cut(Segment((-9.0, 0.0), (0.01, 0.0))) == 0
    assert (len(warned), warned[0].filename) == (1, __file__)
    assert half + part.bonds.cut(Segment((-9.0, 0.0), (9.0, 0.0))) == crossing(part).sum()


def test_a_cut_is_the_same_from_both_ends(rng):
    points = rng.random((300, 2))
    part = Part("cloud", rbs.Everywhere(), dimension=2).place(points, 1.0).connect(0.2)
    part.bonds.cut(Segment((0.2, 0.1), (0.7, 0.8)) | Segment((0.1, 0.9), (0.6, 0.55)))
    state = dict(zip(part.bonds, part.bonds.intact, strict=True))
    assert all(state[j, i] == holds for (i, j), holds in state.items())
    assert 0 < sum(state.values()) < len(state)


def test_a_short_cut_reaches_no_further_than_itself(storage):
    part = plate(storage)
    part.bonds.cut(Segment((-0.4, 0.0), (0.4, 0.0)))
    broken = [pair for pair, holds in zip(part.bonds, part.bonds.intact, strict=True) if not holds]
    x, y = part.positions.T
    for i, j in broken:
        middle = x[i] - y[i] * (x[j] - x[i]) / (y[j] - y[i])  # where the bond meets y = 0
        assert abs(middle) <= 0.4 + 1e-8
    assert broken


def test_a_function_of_starts_and_ends_cuts_too(storage):
    part = plate(storage)
    assert part.bonds.cut(lambda starts, ends: (starts[:, 1] > 0) != (ends[:, 1] > 0)) == crossing(part).sum()
    assert np.array_equal(part.bonds.intact, ~crossing(part))


def test_a_surface_beside_the_part_cuts_nothing(storage):
    part = plate(storage)
    beside = Segment((-9.0, 50.0), (9.0, 50.0))
    with pytest.warns(
        UserWarning, match=r"bonds.cut\(Segment.* broke nothing: no bond crosses it; check where"
    ) as warned:
        assert part.bonds.cut(beside) == 0
    with pytest.warns(UserWarning, match=r"bonds.remove\(Segment.* took nothing away: no bond crosses it") as gone:
        assert part.bonds.remove(beside) == 0
    assert [warning.filename for warning in (*warned, *gone)] == [__file__] * 2
    assert not part.bonds.has_broken


def test_a_volume_is_no_cut():
    with pytest.raises(BadInput, match=r"cannot cut with Box\(.*\): give a Segment, a Polygon, another surface, or"):
        plate().bonds.cut(Box(size=(1.0, 1.0)))


@pytest.mark.parametrize("surface", [rbs.Point(0.0), lambda starts, ends: starts[:, 0] * ends[:, 0] < 0])
def test_a_line_is_cut_at_a_point(surface):
    part = Part("bar", Box(size=4.0)).discretize(1.0).connect(1.0)
    assert part.bonds.cut(surface) == 2
    assert [pair for pair, holds in zip(part.bonds, part.bonds.intact, strict=True) if not holds] == [(1, 2), (2, 1)]


def test_a_block_is_cut_by_a_polygon():
    part = Part("block", Box(size=(4.0, 4.0, 4.0))).discretize(1.0).connect(1.0)
    square = rbs.Polygon([(-9.0, -9.0, 0.0), (9.0, -9.0, 0.0), (9.0, 9.0, 0.0), (-9.0, 9.0, 0.0)])
    assert part.bonds.cut(square) == 2 * 16


# -- remove ---------------------------------------------------------------------------------------------------------


def test_removed_bonds_have_never_been(storage):
    part, whole = plate(storage), plate(storage)
    gone = crossing(whole)
    assert part.bonds.remove(Segment((-9.0, 0.0), (9.0, 0.0))) == gone.sum()
    kept = [pair for pair, away in zip(whole.bonds, gone, strict=True) if not away]
    assert list(part.bonds) == kept
    assert part.bonds.counts().sum() == len(part.bonds) == len(kept)
    assert np.array_equal(part.bonds.lengths, whole.bonds.lengths[~gone])
    assert not part.bonds.has_broken
    with pytest.warns(UserWarning, match="took nothing away"):
        assert part.bonds.remove(Segment((-9.0, 0.0), (9.0, 0.0))) == 0


def test_bond_fields_follow_their_bonds():
    part = plate()
    number = np.arange(len(part.bonds), dtype=float)
    pairs = list(part.bonds)
    part[strength], part[pull] = number, np.stack([number, -number], axis=1)
    part.bonds.cut(Segment((0.0, -9.0), (0.0, 9.0)))
    state = dict(zip(pairs, part.bonds.intact.tolist(), strict=True))
    part.bonds.remove(Segment((-9.0, 0.0), (9.0, 0.0)))
    for (i, j), value, vector, holds in zip(part.bonds, part[strength], part[pull], part.bonds.intact, strict=True):
        assert pairs[int(value)] == (i, j)
        assert vector.tolist() == [value, -value]
        assert holds == state[i, j]
    assert len(part[strength]) == len(part.bonds) < len(number)


def test_a_field_that_comes_later_fits_what_is_left(storage):
    part = plate(storage)
    part.bonds.remove(Segment((-9.0, 0.0), (9.0, 0.0)))
    part[strength] = 1.0
    assert part[strength].shape == (len(part.bonds),)


def test_everything_may_be_removed(storage):
    part = plate(storage)
    part.bonds.remove(lambda starts, ends: np.ones(len(starts), bool))
    assert len(part.bonds) == 0
    assert list(part.bonds) == []
    assert part.bonds.counts().tolist() == [0] * 36
    assert not part.bonds.has_broken
    with pytest.warns(UserWarning, match="broke nothing"):
        assert part.bonds.cut(Segment((-9.0, 0.0), (9.0, 0.0))) == 0


def test_a_cut_far_larger_than_the_part_or_far_off_the_origin_misses_no_bond():
    spacing = 1e-9
    small = Part("small", Box(size=(8 * spacing, 8 * spacing))).discretize(spacing).connect(3.015 * spacing)
    assert small.bonds.cut(Segment((-50.0, 0.0), (50.0, 0.0))) == crossing(small).sum() > 0
    assert np.array_equal(small.bonds.intact, ~crossing(small))
    bar = Part("bar", Box(size=8 * spacing, center=0.1)).discretize(spacing).connect(spacing * (1 + 1e-6))
    assert bar.bonds.cut(rbs.Point(0.1)) == 2


# -- the state ------------------------------------------------------------------------------------------------------


def test_intact_is_the_field_of_the_part(storage):
    part = line(3).connect(1.0, storage=storage)
    part[intact] = [1, 1, 0, 1] if storage == "list" else [0, 0, 1, 1]  # a lattice breaks both ends together
    assert part.bonds.has_broken
    part[intact] = 1
    assert not part.bonds.has_broken
    with pytest.raises(ValueError, match="read-only"):
        part.bonds.intact[0] = False


@pytest.mark.parametrize(
    ("size", "horizon"), [((6.0, 6.0), 2.0), ((3.0, 7.0), 3.0), ((2.0, 3.0, 4.0), 2.5), ((5.0,), 2)]
)
def test_which_pairs_of_nodes_hold_together(size, horizon, storage):
    part = Part("plate", Box(size=size)).discretize(1.0).connect(horizon, storage=storage)
    i, j = (ends.ravel() for ends in np.indices((len(part), len(part))))
    bonded = np.zeros((len(part), len(part)), np.bool_)
    bonded[tuple(np.array(list(part.bonds)).T)] = True
    assert np.array_equal(part.bonds.holds(i, j), bonded.ravel())
    assert intact not in part.bonds.fields
    part.bonds.cut(lambda starts, ends: (starts[:, 0] > 0.3) != (ends[:, 0] > 0.3))
    holding = np.zeros_like(bonded)
    holding[tuple(np.array(list(part.bonds)).T)] = part.bonds.intact
    assert np.array_equal(part.bonds.holds(i, j), holding.ravel())
    assert 0 < holding.sum() < bonded.sum()


def test_the_state_costs_nothing_until_somebody_asks():
    part = line(3).connect(1.0, storage="list")
    assert not part.bonds.has_broken
    assert intact not in part
    bytes_before = part.nbytes
    assert part.bonds.intact.all()
    assert part.nbytes == bytes_before + 4


def test_bonds_between_nodes_of_a_region(storage):
    part = line(4).connect(1.0, storage=storage)
    part.bonds.mark(zone, Box(size=2.0, center=1.0))  # nodes 0 and 1
    assert [pair for pair, both in zip(part.bonds, part[zone], strict=True) if both] == [(0, 1), (1, 0)]


def test_a_function_of_the_bonds(storage):
    part = Part("plate", Box(size=(4.0, 3.0))).discretize(1.0).connect(2.0, storage=storage)
    part.bonds.tabulate(strength, lambda bonds: bonds[:, 0] ** 2 + 5.0 * bonds[:, 1] ** 2)
    x, y = np.array([part.positions[j] - part.positions[i] for i, j in part.bonds]).T
    assert part[strength] == pytest.approx(x**2 + 5.0 * y**2, rel=1e-12)


def test_reach_beyond_the_horizon(storage):
    """Families of a larger radius, while the horizon stays what materials are made of."""
    part = line(4).connect(1.0, storage=storage, reach=2.0)
    assert (part.bonds.horizon, part.bonds.reach) == (1.0, 2.0)
    assert list(part.bonds) == list(line(4).connect(2.0, storage=storage).bonds)
    assert "horizon 1 m, reach 2 m" in repr(part.bonds)
    assert "reach" not in repr(line(4).connect(1.0, storage=storage).bonds)


@pytest.mark.parametrize("reach", [0.9, np.inf, np.nan])
def test_reach_is_not_below_the_horizon(reach):
    with pytest.raises(BadInput, match="must be finite, and not below the horizon 1 m"):
        line(4).connect(1.0, reach=reach)


def test_cuts_look_as_far_as_bonds_reach(storage):
    part = Part("plate", Box(size=(6.0, 1.0))).discretize(1.0).connect(1.0, storage=storage, reach=3.0)
    assert part.bonds.cut(Segment((0.0, -0.4), (0.0, 0.4))) == 2 * (1 + 2 + 3)


# -- representations ------------------------------------------------------------------------------------------------


def test_a_lattice_becomes_a_list_where_a_field_differs_from_bond_to_bond():
    part = plate()
    part.bonds.cut(Segment((-9.0, 0.0), (9.0, 0.0)))
    part.bonds.mark(zone, Box(size=(2.0, 2.0)))
    before, marked, rows = part.bonds.intact, part[zone], part.bonds.as_rows()
    assert part.bonds.storage == "lattice"
    part[strength] = np.arange(len(part.bonds))
    assert part.bonds.storage == "list"
    assert part[strength].tolist() == list(range(len(part.bonds)))
    assert np.array_equal(part.bonds.intact, before)
    assert np.array_equal(part[zone], marked)
    assert all(np.array_equal(one, two) for one, two in zip(rows, part.bonds.as_rows(), strict=True))


def test_a_lattice_that_was_asked_for_stays_one():
    part = plate("lattice")
    message = "the field 'strength', which differs from bond to bond, needs the bonds of part 'plate' as list"
    with pytest.raises(BadInput, match=message):
        part[strength] = np.arange(len(part.bonds))
    with pytest.raises(BadInput, match="needs the bonds of part 'plate' as list"):
        part[intact] = np.arange(len(part.bonds)) > 0  # broken from one end only
    part[strength] = 2.0
    assert part[strength].tolist() == [2.0] * len(part.bonds)
    assert part.bonds.storage == "lattice"


def test_equal_entries_of_a_step_stay_in_the_lattice():
    part = plate()
    part[strength] = part.bonds.lengths
    assert part.bonds.storage == "lattice"
    assert part[strength] == pytest.approx(part.bonds.lengths)
