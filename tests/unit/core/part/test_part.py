"""A part: nodes, fields, regions, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, Box, Everywhere, MissingField, Part, reference_position, volume
from tests.unit.core.toys import a, b, field, line, strength, total

flow = field("flow", shape="vector")


def plate(spacing: float = 0.25) -> Part:
    """16 nodes on the unit square around the origin, x fastest."""
    return Part("plate", Box(size=(1.0, 1.0))).discretize(spacing, thickness=0.1)


# -- making ---------------------------------------------------------------------------------------------------------


def test_nodes_are_cell_centres_and_their_volumes_fill_the_part():
    part = plate()
    assert len(part) == len(part.nodes) == 16
    assert part.positions[:5].tolist() == [
        [-0.375, -0.375], [-0.125, -0.375], [0.125, -0.375], [0.375, -0.375], [-0.375, -0.125],
    ]  # fmt: skip
    assert (part[volume] == 0.25 * 0.25 * 0.1).all()
    assert (part.spacing, part.thickness, part.area, part.dimension) == (0.25, 0.1, None, 2)
    assert part.system is rbs.world


@pytest.mark.parametrize(
    ("geometry", "across", "expected"),
    [
        (Box(size=2.0), {"area": 0.5}, 1.0),
        (Box(size=2.0), {}, 2.0),
        (Box(size=(2.0, 3.0)), {"thickness": 0.5}, 3.0),
        (Box(size=(2.0, 3.0)), {}, 6.0),
        (Box(size=(2.0, 3.0, 1.0)), {}, 6.0),
    ],
)
def test_the_volumes_add_up(geometry, across, expected):
    part = Part("part", geometry).discretize(0.125, **across)
    assert part[volume].sum() == pytest.approx(expected, rel=1e-12)  # a sum of up to 3072 rounded terms


def test_nodes_fill_only_the_geometry():
    disc = rbs.Ball(radius=1.0, center=(0.0, 0.0))
    ring = Part("ring", disc - rbs.Ball(radius=0.5, center=(0.0, 0.0))).discretize(0.02)
    radius = np.linalg.norm(ring.positions, axis=1)
    assert 0.5 < radius.min() < 0.52
    assert 0.98 < radius.max() < 1.0
    # cells on the boundary count as a whole or not at all: the error is a fraction of a cell times the boundary
    assert ring[volume].sum() == pytest.approx(np.pi * 0.75, abs=0.02 * 2 * np.pi * 1.5 * 0.1)


def test_nodes_can_come_from_anywhere():
    part = Part("cloud", Everywhere(), dimension=2).place([[0, 0], [1, 0], [0, 2]], [1.0, 2.0, 3.0], spacing=1.0)
    assert part[volume].tolist() == [1.0, 2.0, 3.0]
    assert (part.spacing, part.grid) == (1.0, None)
    assert Part("bar", Box(size=9.0)).place([0.0, 1.0, 2.0], 0.5).positions.shape == (3, 1)
    assert Part("one", Everywhere(), dimension=3).place([1.0, 2.0, 3.0], 0.5).positions.tolist() == [[1.0, 2.0, 3.0]]


@pytest.mark.parametrize("bad", [0.0, -1.0])
def test_volumes_stay_positive(bad):
    part = plate()
    before = part[volume].copy()
    values = before.copy()
    values[5] = bad
    message = rf"part 'plate': node 5 at \[-0.125, -0.125\] has no positive volume \({bad:g} m\^3\): give it one"
    for value in (values, lambda positions: values):
        with pytest.raises(BadInput, match=message):
            part[volume] = value
    with pytest.raises(BadInput, match=r"node 0 at .* has no positive volume"):
        part[volume] = bad
    assert np.array_equal(part[volume], before)
    part[volume] = 2.0
    assert (part[volume] == 2.0).all()
    with pytest.raises(MissingField, match="has no nodes"):
        Part("p", Box(size=1.0))[volume] = 1.0


def test_the_version_changes_with_nodes_and_bonds():
    part = Part("bar", Box(size=4.0))
    seen = [part.version]
    for change in (
        lambda: part.discretize(1.0),
        lambda: part.connect(2.0),
        lambda: part.bonds.remove(rbs.Point(0.0)),
        lambda: part.connect(2.0),
        lambda: part.discretize(1.0),
        lambda: part.place([0.0, 1.0], 1.0),
    ):
        change()
        seen.append(part.version)
    assert seen == [(0, None), (1, None), (1, 1), (1, 1), (1, 2), (2, None), (3, None)]


def test_the_version_stays_while_nodes_and_bonds_do():
    part = line(4, horizon=2.0)
    before = part.version
    part[a], part[volume] = 1.0, 2.0
    part.bonds.cut(rbs.Point(2.0))
    with pytest.warns(UserWarning, match="took nothing away"):
        part.bonds.remove(rbs.Point(9.0))
    with pytest.raises(BadInput):
        part.connect(-1.0)
    with pytest.raises(BadInput):
        part.place([[9.0]], 1.0)
    assert part.version == before


def test_given_positions_are_copied():
    mine = np.zeros((1, 2))
    part = Part("cloud", Everywhere(), dimension=2).place(mine, 1.0)
    mine[0] = 5.0
    assert part.positions.tolist() == [[0.0, 0.0]]


def test_new_nodes_have_no_old_bonds_and_no_old_fields():
    part = line(4, horizon=1.0)
    part[a] = 1.0
    part.discretize(0.5)
    assert len(part) == 8
    assert not part.connected
    assert a not in part


def test_new_bonds_have_no_old_bond_fields():
    part = line(4, horizon=1.0)
    part[strength] = 2.0
    part.connect(2.0)
    assert strength not in part
    assert len(part.bonds) == 10


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Part("p", "square"), r"Part\('p'\): the second argument must be a geometry such as Box, got 'square'"),
        (lambda: Part("p", Everywhere()), r"say dimension=1, 2 or 3 \(Everywhere\(\) alone does not tell\)"),
        (lambda: Part("p", Everywhere(), dimension=4), "say dimension=1, 2 or 3"),
        (lambda: Part("p", Box(size=(1.0, 1.0)), dimension=3), r"dimension=3, but Box\(.*\) has 2"),
        (lambda: Part("p", Box(size=1.0)).discretize(0.0), "spacing = 0.0 is not positive"),
        (lambda: Part("p", Box(size=1.0)).discretize(float("nan")), "spacing = nan is not finite"),
        (lambda: Part("p", Everywhere(), dimension=2).discretize(0.1), "no grid fills infinite space"),
        (lambda: Part("p", Box(size=1.0)).discretize(0.1, thickness=1.0), "is 1-D: thickness belongs to 2-D"),
        (lambda: Part("p", Box(size=(1.0, 1.0))).discretize(0.1, area=1.0), "is 2-D: area belongs to 1-D parts"),
        (lambda: Part("p", Box(size=1.0)).discretize(0.1, area=-1.0), "'p': area=-1.0 must be positive and finite"),
        (
            lambda: Part("p", rbs.Ball(radius=0.1, center=(0.0, 0.0)) - rbs.Ball(radius=0.09, center=(0.0, 0.0)))
            .discretize(0.2),
            r"part 'p' is empty: none of the 1 points of Grid.spacing=0.2.* lies in .*: use a smaller spacing",
        ),
    ],
)  # fmt: skip
def test_impossible_parts(make, message):
    with pytest.raises(BadInput, match=message):
        make()


@pytest.mark.parametrize(
    ("points", "volumes", "options", "message"),
    [
        ([[0.0, 0.0, 0.0]], 1.0, {}, r"points must be \(n, 2\) with n > 0, got \(1, 3\)"),
        (np.zeros((0, 2)), 1.0, {}, r"points must be \(n, 2\) with n > 0, got \(0, 2\)"),
        ([[0.0, 0.0], [0.0, 3.0], [4.0, 0.0]], 1.0, {}, r"2 points lie outside .* first is point 1 at \[0.0, 3.0\]"),
        ([[0.0, float("nan")]], 1.0, {}, "is not finite"),
        ([[0.0, 0.0], [0.1, 0.2]], [1.0, 0.0], {}, r"node 1 at \[0.1, 0.2\] has no positive volume"),
        ([[0.0, 0.0]], -1.0, {}, "has no positive volume"),
        ([[0.0, 0.0], [0.1, 0.2]], [1.0, 1.0, 1.0], {}, r"'volume' needs shape \(2,\)"),
        ([[0.0, 0.0]], float("inf"), {}, "'volume' would be inf"),
        ([[0.0, 0.0]], 1.0, {"spacing": -1.0}, "spacing=-1.0 must be positive and finite"),
        ([[0.0, 0.0]], 1.0, {"spacing": float("nan")}, "spacing=nan must be positive and finite"),
    ],
)
def test_impossible_nodes(points, volumes, options, message):
    part = Part("p", Box(size=(2.0, 2.0)))
    with pytest.raises(BadInput, match=message):
        part.place(points, volumes, **options)
    with pytest.raises(MissingField):
        len(part)


# -- bonds ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("horizon", [0.0, -1.0, float("nan"), float("inf")])
def test_a_horizon_is_a_length(horizon):
    with pytest.raises(BadInput, match=f"part 'line': horizon={horizon} must be positive and finite"):
        line().connect(horizon)


def test_a_horizon_below_the_spacing_leaves_nobody():
    with pytest.raises(BadInput, match=r"horizon 0\.99 m is below the spacing 1 m, so nodes would have no neighbors"):
        line().connect(0.99)
    assert len(line().connect(1.0 - 1e-12).bonds) == 6  # a rounded 1.0


def test_nodes_at_one_place_are_named():
    part = Part("cloud", Everywhere(), dimension=2)
    part.place([[0.0, 0.0], [5.0, 5.0], [1.0, 0.5], [1.0, 0.5]], 1.0)
    with pytest.raises(BadInput, match=r"part 'cloud': nodes 2 and 3 are at the same place \[1.0, 0.5\]: remove one"):
        part.connect(1.0)
    assert not part.connected


def test_nodes_without_neighbors_are_counted_and_named():
    part = Part("cloud", Everywhere(), dimension=1)
    part.place([0.0, 1.0, 10.0, 20.0, 30.0, 40.0], 1.0)
    message = r"part 'cloud': 4 nodes have no bond .*first: 2 at \[10.0\], 3 at \[20.0\], 4 at \[30.0\]\)"
    with pytest.warns(UserWarning, match=message) as caught:
        part.connect(1.5)
    assert caught[0].filename == __file__  # the line of the script
    assert part.bonds.counts().tolist() == [1, 1, 0, 0, 0, 0]


def test_things_that_are_not_there_yet_are_missed_with_the_cure():
    part = Part("p", Box(size=1.0))
    for early in (lambda: len(part), lambda: part.positions, lambda: part[a], lambda: part.connect(1.0)):
        with pytest.raises(MissingField, match=r"part 'p' has no nodes: call part.discretize\(spacing\) first"):
            early()
    part.discretize(0.25)
    for early in (lambda: part.bonds, lambda: part[strength], lambda: strength in part):
        with pytest.raises(MissingField, match=r"part 'p' has no bonds: call part.connect\(horizon=...\) first"):
            early()
    with pytest.raises(MissingField, match="has no field 'a'"):
        part[a]


def test_repr_says_how_far_it_is():
    part = Part("p", Box(size=1.0))
    assert repr(part) == "<Part 'p', 1-D, not discretized, not connected>"
    part.discretize(0.25)
    assert repr(part) == "<Part 'p', 1-D, 4 nodes, not connected>"
    assert "6 directed bonds of 4 nodes, horizon 0.25 m" in repr(part.connect(0.25))


# -- fields ---------------------------------------------------------------------------------------------------------


def test_fields_are_arrays_set_by_number_array_or_function():
    part = plate()
    part[a] = 8000.0
    part[b] = lambda positions: positions[:, 0] > 0.0
    part[flow] = lambda positions: 2.0 * positions
    assert part[a].sum() == 16 * 8000.0
    assert part[b].sum() == 8
    assert np.array_equal(part[flow], 2.0 * part.positions)
    part[a][3] = 1.0
    assert part[a][3] == 1.0
    assert a in part
    assert field("c") not in part


def test_a_function_must_return_one_entry_per_node():
    with pytest.raises(BadInput, match=r"'a' needs shape \(16,\)"):
        plate()[a] = lambda positions: positions[:4, 0]


def test_fields_of_nodes_bonds_and_the_part():
    part = line(3).connect(1.0, storage="list")
    part[a], part[strength], part[total] = 1.0, 2.0, 3.0
    assert (part[a].shape, part[strength].shape, part[total].shape) == ((3,), (4,), ())
    assert [each.name for each in part.fields] == ["reference_position", "volume", "a", "strength", "total"]
    bonds = part.bonds
    own = 3 * 8 * 3 + 4 * 8  # positions, volumes, a; strength
    assert part.nbytes == own + bonds.as_rows()[0].nbytes + bonds.as_rows()[1].nbytes + bonds.inverse_lengths.nbytes


def test_positions_are_the_field():
    part = plate()
    assert part.positions is part[reference_position]


def test_positions_are_fixed_once_the_bonds_are_measured():
    part = line(4)
    part[reference_position] = part.positions * 1.5
    part.positions[3] += 0.25  # before the bonds, both are fine
    assert part.connect(2.0).bonds.lengths.tolist() == [1.5, 1.5, 1.5, 1.5, 1.75, 1.75]
    before = part.positions.copy()
    message = "part 'line': 'reference_position' is fixed now that the part is connected: set it before"
    with pytest.raises(BadInput, match=message):
        part[reference_position] = 2.0 * before
    for store in (part.positions, part[reference_position]):
        with pytest.raises(ValueError, match="read-only"):
            store[0] = 9.0
    with pytest.raises(ValueError, match="read-only"):
        part.nodes[0][reference_position] = 9.0
    assert np.array_equal(part.positions, before)
    part[volume] = 2.0  # the bonds do not know it
    part.connect(3.0)  # other bonds of the same nodes
    with pytest.raises(BadInput, match="is fixed"):
        part[reference_position] = before
    part.discretize(0.5)  # new nodes are nobody's yet
    part[reference_position] = part.positions + 0.1
    assert part.positions[0, 0] == pytest.approx(0.35)


def test_positions_stay_free_if_the_search_fails():
    part = Part("cloud", Everywhere(), dimension=1).place([0.0, 0.0], 1.0)
    with pytest.raises(BadInput, match="same place"):
        part.connect(1.0)
    part.positions[1] = 1.0
    assert len(part.connect(1.0).bonds) == 2


# -- regions --------------------------------------------------------------------------------------------------------


def test_a_region_is_a_geometry_a_mask_indices_or_a_function():
    part = plate()
    expected = [12, 13, 14, 15]
    assert part.where(rbs.HalfSpace((0.0, 0.3), normal=(0.0, 1.0))).tolist() == expected
    assert part.where(part.positions[:, 1] > 0.3).tolist() == expected
    assert part.where([15, 12, 13, 14, 12]).tolist() == expected
    assert part.where(lambda positions: positions[:, 1] > 0.3).tolist() == expected
    assert part.where(lambda positions: np.array([3, 1])).tolist() == [1, 3]
    assert part.where(Everywhere()).tolist() == list(range(16))
    assert part.where(np.array([], dtype=int)).dtype == np.int64


@pytest.mark.parametrize(
    ("region", "message"),
    [
        (np.ones(3, bool), r"a mask must have shape \(16,\), got \(3,\)"),
        ([16], r"node indices must lie in 0..15"),
        ([-1], r"node indices must lie in 0..15"),
        ([0.5], "a region is a geometry, a mask, indices, a function or the name of a node set, got"),
        (3, "a region is a geometry"),
        ("upper", "part 'plate' has no node set 'upper': there are none"),
        (np.zeros((2, 2), int), "a region is a geometry"),
    ],
)
def test_impossible_regions(region, message):
    with pytest.raises(BadInput, match=message):
        plate().where(region)
