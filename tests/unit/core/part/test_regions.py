"""Regions and node sets: what they take, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core import BadInput, HalfSpace
from rbs_core.part.regions import NodeSets, nodes_in
from tests.unit.core.toys import line


@pytest.mark.parametrize(
    "region",
    [
        HalfSpace(2.0, normal=1),
        np.array([False, False, True, True, True]),
        [4, 2, 3, 3],
        lambda positions: positions[:, 0] > 2.0,
        lambda positions: np.argsort(positions[:, 0])[2:],
        "right",
    ],
    ids=["geometry", "mask", "indices", "function", "function of indices", "name"],
)
def test_every_kind_of_region_gives_ascending_indices(region):
    part = line(5, "bar")
    part.node_sets["right"] = [3, 2, 4]
    assert part.where(region).tolist() == [2, 3, 4]
    part.node_sets["again"] = region
    assert part.node_sets["again"].tolist() == [2, 3, 4]


@pytest.mark.parametrize(
    ("region", "text"),
    [
        ([True], r"part 'bar': a mask must have shape \(5,\), got \(1,\)"),
        ([0.5], "part 'bar': a region is a geometry, a mask, indices, a function or the name of a node set, got"),
        ([[1]], "a region is a geometry"),
        ([5], r"part 'bar': node indices must lie in 0\.\.4"),
        ([-1], r"node indices must lie in 0\.\.4"),
        ("rigt", "part 'bar' has no node set 'rigt': the nearest names are right"),
        ("xyz", "part 'bar' has no node set 'xyz': there are left, right"),
    ],
)
def test_other_regions_are_refused(region, text):
    sets = {"right": np.array([4]), "left": np.array([0])}
    with pytest.raises(BadInput, match=text):
        nodes_in("part 'bar'", region, np.zeros((5, 1)), sets)


def test_a_node_set_is_not_changed_by_what_is_done_to_it():
    part = line(3)
    mine = np.array([0, 1])
    part.node_sets["a"] = mine
    mine[:] = 2
    part.where("a")[:] = 2
    assert part.node_sets["a"].tolist() == [0, 1]
    with pytest.raises(ValueError, match="read-only"):
        part.node_sets["a"][0] = 2


def test_node_sets_are_a_mapping():
    sets = line(4, "bar").node_sets
    assert repr(sets) == "<node sets of part 'bar': none>"
    sets["b"], sets["a"] = [1, 2], [3]
    sets["b"] = [0]
    assert list(sets) == ["b", "a"]
    assert len(sets) == 2
    assert "a" in sets
    assert "c" not in sets
    assert {name: nodes.tolist() for name, nodes in sets.items()} == {"b": [0], "a": [3]}
    assert sets.get("c") is None
    assert sets.get("a", 0).tolist() == [3]
    assert repr(sets) == "<node sets of part 'bar': b (1), a (1)>"
    del sets["a"]
    assert list(sets) == ["b"]
    for use in (lambda: sets["a"], lambda: sets.__delitem__("a")):
        with pytest.raises(BadInput, match="part 'bar' has no node set 'a': there are b"):
            use()


@pytest.mark.parametrize(
    ("name", "region", "text"),
    [
        (3, [0], "the name of a node set must be a text, got 3"),
        ("", [0], "the name of a node set must be a text"),
        ("left", [], "a region is a geometry"),
        ("left", np.zeros(4, bool), "part 'bar': the node set 'left' would be empty: check the region"),
        ("left", [9], r"node indices must lie in 0\.\.3"),
    ],
)
def test_wrong_node_sets_are_refused(name, region, text):
    sets = line(4, "bar").node_sets
    assert isinstance(sets, NodeSets)
    with pytest.raises(BadInput, match=text):
        sets[name] = region
    assert not len(sets)
