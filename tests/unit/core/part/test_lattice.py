"""Bonds of a regular grid: edges of the grid, odd shapes, and what the bits hold."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, Box, Part, intact
from rbs_core.part import Lattice

zone = rbs.Field("zone", "bond", "scalar", "1", "z", "A test.", "uint8", 1)
pull = rbs.Field("pull", "bond", "vector", "1", "p", "A test.")


def lattice(shape, ratio) -> Part:
    return Part("body", Box(size=[float(n) for n in shape])).discretize(1.0).connect(ratio, storage="lattice")


def test_no_bond_leads_across_the_edge_of_a_row():
    """From the end of a row, one cell further is the start of the next row."""
    part = lattice((4, 3), 1.0)
    assert sorted(part.bonds) == sorted(
        (i, j) for i in range(12) for j in range(12) if abs(i % 4 - j % 4) + abs(i // 4 - j // 4) == 1
    )


@pytest.mark.parametrize("shape", [(1, 6), (6, 1), (2, 7), (1, 1, 5), (2, 2, 2), (3, 1, 4)])
@pytest.mark.parametrize("ratio", [1.0, 2.5, 50.0])
def test_narrow_bodies_and_wide_horizons(shape, ratio):
    part = lattice(shape, ratio)
    X = part.positions
    near = np.linalg.norm(X[:, None] - X[None], axis=2) <= ratio
    np.fill_diagonal(near, False)
    assert list(part.bonds) == [(int(i), int(j)) for i, j in np.argwhere(near)]


def test_a_node_alone():
    with pytest.warns(UserWarning, match="1 nodes have no bond"):
        part = lattice((1, 1), 3.0)
    assert len(part.bonds) == 0
    assert part.bonds.as_rows()[0].tolist() == [0, 0]
    assert not part.bonds.has_broken


@pytest.mark.parametrize(("ratio", "width", "words"), [(2.0, 8, 1), (3.0, 16, 1), (4.0, 16, 2), (7.0, 16, 5)])
def test_bits_are_held_in_words(ratio, width, words):
    stored = lattice((20, 20), ratio).bonds.stored
    assert isinstance(stored, Lattice)
    assert (stored.width, len(stored.present)) == (width, words)
    assert stored.count(stored.present) == len(stored)


def test_steps_lead_to_later_cells_in_order():
    stored = lattice((5, 4, 3), 3.0).bonds.stored
    assert (stored.steps > 0).all()
    assert (np.diff(stored.steps) >= 0).all()
    assert len({*map(tuple, stored.vectors), *map(tuple, -stored.vectors)}) == 2 * len(stored.steps)


def test_weights_are_summed_over_families():
    part = Part("ring", Box(size=(9.0, 9.0)) - rbs.Ball(2.0, (0.0, 0.0))).discretize(1.0)
    stored = part.connect(2.0, storage="lattice").bonds.stored
    first = stored.offsets()[:-1]
    wanted = np.add.reduceat(stored.expand(stored.lengths), first)
    np.testing.assert_allclose(stored.weigh(stored.lengths), wanted, rtol=1e-14)


def test_arrays_of_its_fields_are_made_for_the_occasion():
    part = lattice((4, 4), 1.5)
    part[zone] = 0
    with pytest.raises(ValueError, match="read-only"):
        part[zone][0] = 1
    assert part.raw(zone).shape == part.bonds.stored.present.shape
    assert not part[zone].any()
    assert intact not in part


def test_what_it_cannot_hold():
    part = lattice((4, 4), 1.5)
    with pytest.raises(BadInput, match="stores its bonds as lattice, which holds scalars that are 0 or 1"):
        part.raw(pull)
    with pytest.raises(BadInput, match=r"'zone' needs shape \(84,\) or one entry"):
        part[zone] = np.ones(3)
    with pytest.raises(rbs.BadInput, match="would be nan"):
        part[rbs.Field("share", "bond", "scalar", "1", "s", "A test.")] = np.nan


def test_fields_follow_removed_bonds():
    part = lattice((6, 6), 2.0)
    part[zone] = 1
    part.bonds.remove(rbs.Segment((-9.0, 0.0), (9.0, 0.0)))
    assert part[zone].tolist() == [1] * len(part.bonds)
    assert not part.bonds.has_broken


def test_single_precision_for_values_of_steps():
    part = Part("body", Box(size=(4.0, 4.0)), precision="single").discretize(1.0).connect(1.5)
    share = rbs.Field("share", "bond", "scalar", "1", "s", "A test.")
    part.bonds.tabulate(share, lambda bonds: np.linalg.norm(bonds, axis=1))
    assert part[share].dtype == np.float32
