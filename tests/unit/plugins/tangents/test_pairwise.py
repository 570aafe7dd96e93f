"""Tangents of bonds by themselves against differences of forces, in what the conformance suite does not show."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import Field
from rbs_plugins import BondBased, CriticalStretch, PairwiseForce
from rbs_plugins.tangents.pairwise import pulls_alike
from tests.unit.plugins.tangents.scenes import SPACING, Held, assert_consistent, assert_near, parts

warmth = Field("warmth", "node", "scalar", "K", "T", "Made up for these tests.")


def everything(stretch, extension, length, reference_length, time, warmth_i, warmth_j, k):
    warm = 1.0 + 0.01 * (warmth_i + warmth_j) + time
    return k * warm * (stretch + 0.5 * stretch**2) * (1.0 + extension * length / reference_length**2)


def its_slope(stretch, time, warmth_i, warmth_j, k):
    """Of the same law, e |Y| / |ξ|² = s (1 + s)."""
    warm = 1.0 + 0.01 * (warmth_i + warmth_j) + time
    return (
        k * warm * ((1.0 + stretch) * (1.0 + stretch + stretch**2) + (stretch + 0.5 * stretch**2) * (1 + 2 * stretch))
    )


def one_sided(stretch, warmth_i, k):
    return k * warmth_i * stretch


def plate(rng):
    part = parts()[0]
    part[warmth] = rng.uniform(1.0, 10.0, len(part))
    return part, rng.uniform(-0.05, 0.05, part.positions.size)


@pytest.mark.parametrize("slope", [None, its_slope])
def test_a_law_that_asks_for_everything(slope, rng):
    part, u = plate(rng)
    force = PairwiseForce(part, everything, slope=slope, k=100.0)
    scene = Held([part], [force])
    differences = scene.differences(u)
    tangent = force.tangent()
    assert tangent.symmetric
    assert not tangent.constant
    assert_consistent(tangent, differences)
    assert tangent.nbytes > 0


def test_a_law_that_pulls_one_end_more(rng):
    part, u = plate(rng)
    force = PairwiseForce(part, one_sided, k=100.0)
    differences = Held([part], [force]).differences(u)
    tangent = force.tangent()
    assert not tangent.symmetric
    assert_consistent(tangent, differences)


def test_laws_that_python_cannot_follow_are_not_taken_for_symmetric(rng):
    def picky(stretch, warmth_i, warmth_j):
        return stretch / (warmth_i - warmth_i)

    part, _ = plate(rng)
    assert not pulls_alike(picky, PairwiseForce(part, picky)._law_arguments)


@pytest.mark.parametrize(("turned", "both"), [(False, True), (True, True), (True, False)])
def test_a_connection(turned, both, rng):
    """Of two parts, some nodes of which have no bonds; the second one has a system of its own."""
    ends = parts(turned)
    link = rbs.Connection(*ends, horizon=2.2 * SPACING, both=both)
    assert 0 < len(link.nodes[1]) < len(ends[1])
    force = BondBased(link, c=100.0)
    u = rng.uniform(-0.05, 0.05, 2 * 18)
    differences = Held(ends, [force]).differences(u)
    tangent = force.tangent()
    assert tangent.ends == tuple(ends)
    assert tangent.symmetric == both
    assert_consistent(tangent, differences)


def test_bonds_that_are_searched_again_make_another_structure(rng):
    ends = parts()
    link = rbs.Connection(*ends, horizon=2.2 * SPACING)
    force = BondBased(link, c=100.0)
    scene = Held(ends, [force])
    u = np.zeros(2 * 18)
    scene.force(u)
    tangent = force.tangent()
    before = tangent.matrix()
    assert tangent.matrix().indices is before.indices
    link.horizon = 3.1 * SPACING
    link.search()
    tangent.update()
    assert tangent.matrix().nnz > before.nnz
    assert_consistent(tangent, scene.differences(u))


def test_small_displacements_make_a_constant_tangent(rng):
    part, u = plate(rng)
    force = BondBased(part, c=100.0, linear=True)
    scene = Held([part], [force])
    scene.force(u)
    tangent = force.tangent()
    assert tangent.constant
    whole = tangent.matrix().toarray()
    assert_near(-whole @ u, scene.force(u), 1e-10)


def test_bonds_hold_while_they_are_told_to(rng):
    part, u = plate(rng)
    force = BondBased(part, c=100.0, fracture=CriticalStretch(0.01))
    scene = Held([part], [force])
    held = scene.force(u)
    assert part.bonds.intact.all()
    tangent = force.tangent()
    assert_consistent(tangent, scene.differences(u))
    force.hold = False
    scene.force(u)
    broken = ~part.bonds.intact
    assert broken.any()
    force.hold = True
    assert not np.array_equal(scene.force(u), held)
    tangent.update()
    assert_consistent(tangent, scene.differences(u))
    assert np.array_equal(part.bonds.intact, ~broken)


@pytest.mark.verify
def test_bonds_of_a_lattice_hold_as_well(rng):
    part = rbs.Part("block", rbs.Box(size=(8.0, 4.0))).discretize(1.0, thickness=1.0).connect(2.1, storage="lattice")
    force = BondBased(part, c=1.0, fracture=CriticalStretch(0.01))
    scene = Held([part], [force])
    u = rng.uniform(-0.05, 0.05, part.positions.size)
    held = scene.force(u)
    assert part.bonds.intact.all()
    force.hold = False
    scene.force(u)
    assert not part.bonds.intact.all()
    force.hold = True
    assert not np.array_equal(scene.force(u), held)
    with pytest.raises(rbs.BadInput, match="a tangent needs the bonds as list"):
        force.tangent()
