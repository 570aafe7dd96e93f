"""Tangents of ordinary state-based solids where the conformance suite does not look: materials, rules, connections."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import CriticalStretch, OrdinaryStateBased
from tests.unit.plugins.tangents.scenes import SPACING, Held, assert_consistent, assert_near, parts

E = 100.0


def total(tangents, ends):
    """The sum of tangents as one matrix over all ends."""
    sizes = [len(end) * end.dimension for end in ends]
    begins = dict(zip(ends, np.cumsum([0, *sizes]), strict=False))
    whole = np.zeros((sum(sizes), sum(sizes)))
    for tangent in tangents:
        numbers = np.concatenate([begins[end] + np.arange(len(end) * end.dimension) for end in tangent.ends])
        whole[np.ix_(numbers, numbers)] += tangent.matrix().toarray()
    return whole


def test_another_material_at_each_node(rng):
    part = parts()[0]
    young, ratio = rng.uniform(50.0, 150.0, len(part)), rng.uniform(0.0, 0.45, len(part))
    solid = OrdinaryStateBased(
        part, young, ratio, CriticalStretch(0.01), influence="gaussian", weighted_volume="intact"
    )
    scene = Held([part], [solid])
    u = rng.uniform(-0.05, 0.05, part.positions.size)
    solid.hold = False
    scene.force(u)
    solid.hold = True
    assert not part.bonds.intact.all()
    differences = scene.differences(u)
    tangent = solid.tangent()
    assert tangent.symmetric
    assert_consistent(tangent, differences)


@pytest.mark.verify
def test_small_displacements_make_a_constant_tangent(rng):
    part = parts()[0]
    solid = OrdinaryStateBased(part, E, 0.2, linear=True)
    scene = Held([part], [solid])
    u = rng.uniform(-0.05, 0.05, part.positions.size)
    scene.force(u)
    tangent = solid.tangent()
    assert tangent.constant
    assert_near(-tangent.matrix() @ u, scene.force(u), 1e-10)


def test_a_ratio_without_dilatation_has_springs_alone(rng):
    part = parts()[0]
    solid = OrdinaryStateBased(part, E, 1 / 3)
    u = rng.uniform(-0.05, 0.05, part.positions.size)
    differences = Held([part], [solid]).differences(u)
    tangent = solid.tangent()
    assert tangent.matrix().nnz == 4 * (len(part.bonds) + len(part))
    assert_consistent(tangent, differences)


@pytest.mark.parametrize("turned", [False, True])
def test_parts_that_are_connected(turned, rng):
    """Of the sum of all three; each alone is symmetric."""
    ends = parts(turned)
    solids = [OrdinaryStateBased(ends[0], E, 0.1), OrdinaryStateBased(ends[1], 2 * E, 0.4)]
    link = OrdinaryStateBased(rbs.Connection(*ends, horizon=2.2 * SPACING), between=solids)
    scene = Held(ends, [*solids, link])
    u = rng.uniform(-0.05, 0.05, 2 * 18)
    differences = scene.differences(u)
    tangents = [each.tangent() for each in (*solids, link)]
    assert tangents[1].ends == (ends[1], ends[0])
    for tangent in tangents:
        whole = tangent.matrix().toarray()
        assert tangent.symmetric
        assert_consistent(tangent, whole)
    assert_near(total(tangents, ends), differences, 1e-6)


def test_bonds_within_a_part_beside_its_own(rng):
    """Also between nodes that have a bond already."""
    part = parts()[0]
    solid = OrdinaryStateBased(part, E, 0.1)
    more = OrdinaryStateBased(rbs.Connection(part, pairs=[[0, 8], [0, 1], [2, 6]]), between=[solid])
    scene = Held([part], [solid, more])
    u = rng.uniform(-0.05, 0.05, 18)
    differences = scene.differences(u)
    tangents = [solid.tangent(), more.tangent()]
    assert_near(total(tangents, [part]), differences, 1e-6)


def test_bonds_that_only_one_part_feels_are_refused():
    ends = parts()
    solids = [OrdinaryStateBased(end, E, 0.1) for end in ends]
    link = OrdinaryStateBased(rbs.Connection(*ends, horizon=2.2 * SPACING, both=False), between=solids)
    Held(ends, [*solids, link]).force(np.zeros(36))
    for each in (*solids, link):
        with pytest.raises(rbs.BadInput, match="no tangent where only one part feels the bonds"):
            each.tangent()
