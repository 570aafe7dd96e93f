"""Bonds that are left out by a predicate when a part is connected."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core import BadInput, Box, Part, Segment, intact


def plate() -> Part:
    """8 x 6 nodes."""
    return Part("plate", Box(size=(8.0, 6.0))).discretize(1.0)


def apart(starts, ends):
    """No bonds between left and right."""
    return (starts[:, 0] > 0) == (ends[:, 0] > 0)


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_bonds_are_left_out_on_both_sides(storage):
    part = plate().connect(2.5, storage=storage, where=apart)
    assert part.bonds.storage == storage
    x = part.positions[:, 0] > 0
    pairs = np.array(list(part.bonds))
    assert (x[pairs[:, 0]] == x[pairs[:, 1]]).all()
    assert {(i, j) for i, j in pairs} == {(j, i) for i, j in pairs}
    whole = np.array(list(plate().connect(2.5, storage=storage).bonds))
    assert len(pairs) == len(part.bonds) == (x[whole[:, 0]] == x[whole[:, 1]]).sum()
    # nobody has broken them: they have never been
    assert not part.bonds.has_broken
    assert part.raw(intact).any()
    assert not part.bonds.has_broken


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_it_leaves_what_removing_leaves(storage):
    notch = Segment((-4.0, 0.0), (1.0, 0.0))
    one = plate().connect(2.5, storage=storage, where=lambda starts, ends: ~notch.crosses(starts, ends))
    two = plate().connect(2.5, storage=storage)
    two.bonds.remove(notch)
    assert list(one.bonds) == list(two.bonds)
    assert np.array_equal(one.bonds.lengths, two.bonds.lengths)


def test_the_storage_is_chosen_as_ever():
    assert plate().connect(2.5, where=apart).bonds.storage == "lattice"
    cloud = plate().place(np.random.default_rng(0).uniform(-3, 3, (20, 2)), 1.0).connect(9.0, where=apart)
    assert cloud.bonds.storage == "list"


@pytest.mark.parametrize("storage", ["list", "lattice"])
@pytest.mark.parametrize(
    ("where", "text"),
    [
        (
            lambda starts, ends: starts[:, 0] < ends[:, 0],
            r"where\(starts, ends\) says .* from \[.*\] to \[.*\], and",
        ),
        (lambda starts, ends: starts[:, 0] > 0, "of the way back: a bond is there from both ends or not at all"),
        (lambda starts, ends: True, r"part 'plate': where\(starts, ends\) must return one truth value per bond"),
        (lambda starts, ends: np.ones(len(starts)), "one truth value per bond"),
    ],
)
def test_predicates_that_make_no_bonds_are_refused(where, text, storage):
    part = plate()
    with pytest.raises(BadInput, match=text):
        part.connect(2.5, storage=storage, where=where)
    assert not part.connected


def test_nodes_without_bonds_are_named():
    with pytest.warns(UserWarning, match="48 nodes have no bond"):
        plate().connect(2.5, where=lambda starts, ends: np.zeros(len(starts), bool))
