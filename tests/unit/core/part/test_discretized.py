"""What a part knows of its nodes: node sets live and die with them."""

from __future__ import annotations

import pytest

from rbs_core import BadInput, Box, MissingField, Part
from rbs_core.part.discretized import Discretized


def test_a_part_is_discretized():
    assert issubclass(Part, Discretized)


def test_node_sets_belong_to_the_nodes():
    part = Part("bar", Box(size=4.0)).discretize(1.0)
    part.node_sets["left"] = Box.between(-9.0, 0.0)
    part.connect(2.0)
    assert part.where("left").tolist() == [0, 1]
    for again in (lambda: part.discretize(0.5), lambda: part.place([0.0, 1.0], 1.0)):
        again()
        assert not len(part.node_sets)
        part.node_sets["left"] = [0]
    with pytest.raises(BadInput):
        part.place([[9.0]], 1.0)
    assert part.node_sets["left"].tolist() == [0]


def test_a_part_without_nodes_has_none():
    part = Part("bar", Box(size=4.0))
    assert not len(part.node_sets)
    with pytest.raises(MissingField, match="part 'bar' has no nodes"):
        part.node_sets["left"] = [0]
