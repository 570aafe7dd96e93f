"""What the suite is built from: registries of our own, instances from examples, bodies and copies of bodies."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core.testing import furnish, isolated_registry, make, partners
from rbs_plugins import BondBased, StrainEnergy
from rbs_plugins import testing as suite
from rbs_plugins.fields import volume


def test_isolated_registry_holds_only_what_it_is_given():
    before = rbs.registry()
    with isolated_registry() as empty:
        assert rbs.registry() is empty
        assert empty.relations() == {}
    with isolated_registry("rbs_plugins") as found:
        assert found.relations()["BondBased"] is BondBased
    assert rbs.registry() is before
    with pytest.raises(RuntimeError), isolated_registry():
        raise RuntimeError
    assert rbs.registry() is before


def test_make_takes_arguments_beside_the_example():
    part = suite.body(2)
    assert make(BondBased, part, partial_volume="linear").parameters == {"E": 1e9, "partial_volume": "linear"}
    energy = make(StrainEnergy, part)
    assert [type(each) for each in partners(energy)] == [BondBased]


def test_copy_of_a_body_has_the_same_bonds():
    part = suite.body(3)
    order = np.random.default_rng(0).permutation(len(part))
    copy = suite.again(part, order=order)
    i, j = suite.ends(part)
    k, m = suite.ends(copy)
    broken = {(a, b) for a, b, holds in zip(i, j, part.bonds.intact, strict=True) if not holds}
    assert broken
    assert broken == {(order[a], order[b]) for a, b, holds in zip(k, m, copy.bonds.intact, strict=True) if not holds}
    np.testing.assert_array_equal(copy[volume], part[volume][order])


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("cloud", suite.CLOUDS)
def test_body_has_what_the_checks_need(dimension, cloud):
    part = suite.body(dimension, cloud)
    broken = ~part.bonds.intact
    assert 0 < np.count_nonzero(broken) < len(broken) / 2
    i, j = suite.ends(part)
    assert {(a, b) for a, b in zip(i[broken], j[broken], strict=True)} == {
        (b, a) for a, b in zip(i[broken], j[broken], strict=True)
    }
    assert (np.ptp(part[volume]) > 0) == (cloud == "jittered")
    assert np.bincount(i[~broken], minlength=len(part)).min() >= 1
    turn = suite.rotation(dimension)
    np.testing.assert_allclose(turn @ turn.T, np.eye(dimension), atol=1e-15)
    assert np.linalg.det(turn) == pytest.approx(1.0, abs=1e-14)


def test_unknown_scalars_of_nodes_differ_from_node_to_node():
    """Equal values would hide a law that looks at one end of a bond only."""
    part = rbs.Part("bar", rbs.Box(size=4.0)).discretize(1.0)
    wear = rbs.Field("wear", "node", "scalar", "1", "w", "How much a node has suffered.")

    class Reader(rbs.Measure):
        """Looks."""

        reads = (wear,)

    furnish([Reader(part)])
    assert len(set(part[wear])) == 4
    assert abs(part[wear] - 1).max() <= 0.1
