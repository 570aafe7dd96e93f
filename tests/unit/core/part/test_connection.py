"""Bonds between two parts: who is bonded, in which coordinates, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, MissingField, intact
from rbs_core.part import Connection, in_world
from rbs_core.part.pairs import pairs_between
from tests.unit.core.toys import a, field, line

strength = field("strength", at="bond")
total = field("total", at="part")


def two(gap=0.0, n=4):
    """Two lines of n nodes, one behind the other: at 0.5, 1.5, ... and at n + gap + 0.5, ..."""
    right = rbs.Part("right", rbs.Box(size=float(n), center=1.5 * n + gap)).discretize(1.0)
    return line(n, "left"), right


def pairs_of(connection):
    """Bonds as (part, node, part, node)."""
    count = len(connection.nodes[0])
    found = []
    for i, j in connection.bonds:
        (p, m), (q, n) = (
            ((0, connection.nodes[0][k]) if k < count else (1, connection.nodes[1][k - count])) for k in (i, j)
        )
        found.append((p, int(m), q, int(n)))
    return found


def test_nodes_within_the_horizon_are_bonded_from_both_ends():
    connection = Connection(*two(), horizon=2.0)
    assert [nodes.tolist() for nodes in connection.nodes] == [[2, 3], [0, 1]]
    assert len(connection) == 4
    ahead = [(0, 2, 1, 0), (0, 3, 1, 0), (0, 3, 1, 1)]
    assert pairs_of(connection) == [*ahead, (1, 0, 0, 2), (1, 0, 0, 3), (1, 1, 0, 3)]
    assert connection.bonds.lengths.tolist() == [2.0, 1.0, 2.0, 2.0, 1.0, 2.0]
    assert connection.positions[:, 0].tolist() == [2.5, 3.5, 4.5, 5.5]
    assert connection.horizon == connection.bonds.horizon == 2.0
    assert repr(connection) == ("<Connection 'left to right', 6 directed bonds, 2 nodes of 'left', 2 nodes of 'right'>")


def test_one_way():
    connection = Connection(*two(), horizon=2.0, both=False)
    assert pairs_of(connection) == [(0, 2, 1, 0), (0, 3, 1, 0), (0, 3, 1, 1)]
    assert len(connection) == 4


def test_given_pairs():
    connection = Connection(*two(), pairs=[[3, 0], [0, 3], [3, 0]], name="rope")
    assert connection.name == "rope"
    assert pairs_of(connection) == [(0, 0, 1, 3), (0, 3, 1, 0), (1, 0, 0, 3), (1, 3, 0, 0)]
    assert connection.bonds.horizon == 7.0
    with pytest.raises(BadInput, match="was given pairs of nodes: there is nothing to search"):
        connection.search()


def test_any_predicate_of_the_ends():
    connection = Connection(*two(), horizon=3.0, where=lambda starts, ends: ends[:, 0] - starts[:, 0] > 1.5)
    assert connection.bonds.lengths.min() == 2.0
    assert len(connection.bonds) == 2 * 5
    with pytest.raises(BadInput, match="must return one truth value per bond"):
        Connection(*two(), horizon=3.0, where=lambda starts, ends: starts[:, 0])


def test_nodes_on_the_horizon_belong_to_it_wherever_the_parts_are(rng):
    for _ in range(20):
        shift = rng.uniform(-1e3, 1e3)
        left = rbs.Part("left", rbs.Box(size=4.0, center=shift)).discretize(1.0)
        right = rbs.Part("right", rbs.Box(size=4.0, center=shift + 4.0)).discretize(1.0)
        assert len(Connection(left, right, horizon=3.0).bonds) == 2 * (1 + 2 + 3)


def test_systems_are_taken_into_account():
    turned = rbs.world.child("turned", origin=(0.0, 6.0, 0.0), axes=[(0.0, -1.0, 0.0), (1.0, 0.0, 0.0)])
    left = rbs.Part("left", rbs.Box(size=(2.0, 2.0))).discretize(1.0)
    right = rbs.Part("right", rbs.Box(size=(2.0, 2.0), center=(4.0, 0.0)), system=turned).discretize(1.0)
    connection = Connection(left, right, horizon=1.0)
    assert np.sort(in_world(right)[:, 1]).tolist() == [1.5, 1.5, 2.5, 2.5]
    assert connection.bonds.lengths.tolist() == [1.0] * 4
    assert connection.nodes[0].tolist() == [2, 3]  # the upper ones


def test_found_anew_among_displaced_nodes():
    left, right = two(gap=10.0)
    with pytest.warns(UserWarning, match="connection 'left to right' has no bond"):
        connection = Connection(left, right, horizon=1.5)
    assert connection.version == (1, 1)
    connection.search((np.zeros((4, 1)), np.full((4, 1), -10.0)))
    assert connection.version == (1, 2)
    assert pairs_of(connection) == [(0, 3, 1, 0), (1, 0, 0, 3)]
    connection[intact] = 0
    connection.search((np.zeros((4, 1)), np.full((4, 1), -9.9)))
    assert connection.bonds.intact.all()  # what bonds held is forgotten
    np.testing.assert_allclose(connection.bonds.lengths, 1.1)
    assert not connection.searched_again
    connection.search_during_runs()
    assert connection.searched_again


def test_fields_live_at_bonds_and_at_the_connection():
    connection = Connection(*two(), horizon=2.0)
    connection[strength] = np.arange(6.0)
    connection[total] = 3.0
    assert connection[strength].tolist() == [0, 1, 2, 3, 4, 5]
    assert [each.name for each in connection.fields] == ["strength", "total"]
    assert connection.nbytes > 6 * 8
    with pytest.raises(MissingField, match="has no fields at nodes: ask its parts"):
        connection[a]


def test_bonds_are_cut_in_the_world():
    connection = Connection(*two(), horizon=2.0)
    assert connection.bonds.cut(rbs.Point(4.0)) == 6
    assert not connection.bonds.intact.any()
    with pytest.warns(UserWarning, match=r"connection 'left to right': bonds\.cut\(.*broken before"):
        connection.bonds.cut(rbs.Point(4.0))


def test_parts_may_overlap():
    left = line(4, "left")
    right = rbs.Part("right", rbs.Box(size=3.0, center=2.0)).discretize(1.0)
    right[rbs.reference_position] = right.positions + 0.25
    assert len(Connection(left, right, horizon=0.5).bonds) == 2 * 3


def test_nodes_at_one_place_are_refused():
    left, right = line(4, "left"), line(4, "right")
    with pytest.raises(
        BadInput, match=r"node 0 of 'left' and node 0 of 'right' are both at \[0\.5\] \(world\): move one"
    ):
        Connection(left, right, horizon=1.0)
    apart = Connection(left, right, horizon=1.0, where=lambda starts, ends: (starts != ends).any(axis=1))
    assert len(apart.bonds) == 2 * 6


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "give either a horizon or pairs of nodes"),
        ({"horizon": 1.0, "pairs": [[0, 0]]}, "give either a horizon or pairs of nodes"),
        ({"horizon": 0.0}, "horizon=0.0 must be positive and finite"),
        ({"horizon": np.inf}, "horizon=inf must be positive and finite"),
        ({"pairs": [0, 1]}, r"pairs must be whole numbers \(k, 2\)"),
        ({"pairs": [[0.5, 1]]}, r"pairs must be whole numbers \(k, 2\)"),
        ({"pairs": [[0, 4]]}, "part 'right' has no node 4, only 0 to 3"),
    ],
)
def test_bad_input(options, message):
    with pytest.raises(BadInput, match=message):
        Connection(*two(), **options)


def test_bad_parts():
    plate = rbs.Part("plate", rbs.Box(size=(2.0, 2.0))).discretize(1.0)
    with pytest.raises(BadInput, match="'left' has dimension 1, 'plate' has 2"):
        Connection(line(4, "left"), plate, horizon=1.0)
    with pytest.raises(BadInput, match="is no Part"):
        Connection(line(4), "right", horizon=1.0)
    with pytest.raises(MissingField, match="has no nodes"):
        Connection(line(4), rbs.Part("empty", rbs.Box(size=1.0)), horizon=1.0)


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_pairs_between_against_all_distances(dimension, rng):
    one, two_ = rng.uniform(0, 1, (60, dimension)), rng.uniform(0.5, 2, (80, dimension))
    distances = np.linalg.norm(one[:, None] - two_[None], axis=2)
    assert pairs_between(one, two_, 0.4).tolist() == np.argwhere(distances <= 0.4).tolist()
    assert pairs_between(one, two_ + 10.0, 0.4).shape == (0, 2)


def test_bonds_within_one_part():
    part = line(5)
    more = Connection(part, horizon=2.0)
    assert more.name == f"within {part.name}"
    assert more.ends == (part,)
    assert repr(more) == f"<Connection 'within {part.name}', 14 directed bonds, 5 nodes of '{part.name}'>"
    assert more.pairs.tolist() == [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3], [2, 4], [3, 4]]
    assert sorted(more.bonds) == sorted((int(i), int(j)) for k in more.pairs for i, j in (k, k[::-1]))
    few = Connection(part, part, pairs=[[4, 1], [1, 4], [3, 1]])
    assert [nodes.tolist() for nodes in few.nodes] == [[1, 3, 4]]
    assert few.pairs.tolist() == [[1, 3], [1, 4]]
    assert few.bonds.lengths.tolist() == [2.0, 3.0, 2.0, 3.0]
    with pytest.raises(BadInput, match="node 2 cannot be bonded to itself"):
        Connection(part, pairs=[[1, 2], [2, 2]])
    with pytest.raises(BadInput, match="within one part, both ends of a bond feel it"):
        Connection(part, horizon=2.0, both=False)


def test_bonds_that_somebody_has_found():
    left, right = two()
    connection = Connection(left, right, pairs=np.empty((0, 2), np.int64))
    assert (len(connection), len(connection.bonds), len(connection.pairs)) == (0, 0, 0)
    connection.take([[3, 0]], (np.full((4, 1), 0.25), None))
    assert connection.pairs.tolist() == [[3, 0]]
    assert connection.bonds.lengths.tolist() == [0.75, 0.75]
    assert connection.version == (1, 2)
