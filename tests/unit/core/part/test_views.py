"""Node and Neighborhood: looking at one node, and walking from neighbor to neighbor."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, Neighborhood, Node, Part, reference_position
from tests.unit.core.toys import a, b, field, line, strength, total

flow = field("flow", shape="vector")


def test_a_node_reads_and_writes_the_arrays():
    part = line(4)
    part[a], part[flow] = [1.0, 2.0, 3.0, 4.0], 0.0
    node = part.nodes[2]
    assert node[a] == 3.0
    node[a] = 7.0
    node[flow] = 5.0
    assert part[a].tolist() == [1.0, 2.0, 7.0, 4.0]
    assert part[flow].tolist() == [[0.0], [0.0], [5.0], [0.0]]
    node[flow][0] += 1.0  # a row is a view
    assert part[flow][2, 0] == 6.0
    assert node[reference_position].tolist() == [2.5]


def test_nodes_are_a_sequence():
    part = line(3)
    assert [node.index for node in part.nodes] == [0, 1, 2]
    assert len(part.nodes) == 3
    assert part.nodes[-1] == part.nodes[2]
    assert part.nodes[np.int64(1)].index == 1
    assert repr(part.nodes) == "<3 nodes of part 'line'>"
    assert repr(part.nodes[1]) == "<node 1 of part 'line'>"


@pytest.mark.parametrize("index", [3, -4, 100])
def test_a_node_that_does_not_exist(index):
    with pytest.raises(BadInput, match=f"part 'line' has no node {index}: its nodes are 0 to 2"):
        line(3).nodes[index]


def test_nodes_are_equal_if_they_are_the_same_node_of_the_same_part():
    one, two = line(3), line(3)
    assert one.nodes[1] == Node(one, 1)
    assert len({one.nodes[1], Node(one, 1), one.nodes[2], two.nodes[1]}) == 3
    assert one.nodes[1] != two.nodes[1]
    assert one.nodes[1] != 1


def test_views_hold_no_arrays():
    assert Node.__slots__ == Neighborhood.__slots__ == ("index", "part")
    with pytest.raises(AttributeError):
        line(3).nodes[0].color = "red"


def test_a_neighborhood_holds_neighbors_that_have_neighborhoods():
    part = line(5, horizon=1.0)
    hood = part.nodes[0].neighborhood
    assert isinstance(hood, Neighborhood)
    assert len(hood) == 1
    (neighbor,) = hood
    assert isinstance(neighbor, Node)
    assert [node.index for node in neighbor.neighborhood] == [0, 2]
    seconds = {second.index for first in hood for second in first.neighborhood}
    thirds = {third.index for second in seconds for third in part.nodes[second].neighborhood}
    assert (seconds, thirds) == ({0, 2}, {1, 3})
    assert repr(hood) == "<neighborhood of node 0 of part 'line': 1 neighbors>"


def test_walking_reaches_neighbors_of_neighbors():
    part = line(9, horizon=1.0)
    middle = part.nodes[4].neighborhood
    assert middle.reach(0).tolist() == []
    assert middle.reach(1).tolist() == middle.neighbors.tolist() == [3, 5]
    assert middle.reach().tolist() == [2, 3, 5, 6]
    assert middle.reach(4).tolist() == middle.reach(50).tolist() == [0, 1, 2, 3, 5, 6, 7, 8]


@pytest.mark.parametrize("walks", [1, 2, 3])
def test_walking_agrees_with_powers_of_the_adjacency(rng, walks):
    points = rng.random((60, 2))
    part = Part("cloud", rbs.Everywhere(), dimension=2).place(points, 1.0).connect(0.25)
    adjacent = np.eye(60, dtype=int)
    for i, j in part.bonds:
        adjacent[i, j] = 1
    reached = np.linalg.matrix_power(adjacent, walks) > 0
    for node in part.nodes:
        expected = set(np.flatnonzero(reached[node.index])) - {node.index}
        assert set(node.neighborhood.reach(walks)) == expected


def test_a_removed_bond_is_no_way():
    part = line(5, horizon=1.0)
    part.bonds.remove(rbs.Point(2.0))  # between nodes 1 and 2
    assert part.nodes[0].neighborhood.reach(9).tolist() == [1]
    assert part.nodes[4].neighborhood.reach(9).tolist() == [2, 3]


def test_bond_fields_of_a_neighborhood():
    part = line(4, horizon=1.0)
    part[strength] = np.arange(6.0)
    hood = part.nodes[1].neighborhood
    assert hood.neighbors.tolist() == [0, 2]
    assert hood[strength].tolist() == [1.0, 2.0]
    hood[strength] = -1.0
    hood[strength][1] = -2.0  # a slice is a view
    assert part[strength].tolist() == [0.0, -1.0, -2.0, 3.0, 4.0, 5.0]


def test_a_neighborhood_sees_and_breaks_bonds():
    part = line(4, horizon=1.0)
    part.bonds.cut(rbs.Point(1.0))
    assert part.nodes[1].neighborhood[rbs.intact].tolist() == [0, 1]
    part.nodes[3].neighborhood[rbs.intact] = 0
    assert part.bonds.intact.tolist() == [False, False, True, True, True, False]


def test_node_fields_at_the_neighbors_are_a_copy():
    part = line(4, horizon=1.0)
    part[b] = [10.0, 11.0, 12.0, 13.0]
    hood = part.nodes[1].neighborhood
    assert hood[b].tolist() == [10.0, 12.0]
    hood[b][0] = 0.0
    assert part[b][0] == 10.0


def test_a_view_refuses_fields_of_other_places():
    """A node has no bond number 2, and the sum of a part is no entry of a node."""
    part = line(4, horizon=1.0)
    part[strength], part[total], part[a] = 1.0, 2.0, 3.0
    node = part.nodes[2]
    with pytest.raises(BadInput, match=r"'strength' lives at the bond, not at a node: ask for node.neighborhood"):
        node[strength]
    with pytest.raises(BadInput, match=r"'total' lives at the part, not at a node: ask for part\[...\]"):
        node[total] = 1.0
    with pytest.raises(BadInput, match="'total' lives at the part, not at its nodes"):
        node.neighborhood[total]
    with pytest.raises(BadInput, match="'a' lives at the node: assign through that"):
        node.neighborhood[a] = 1.0
