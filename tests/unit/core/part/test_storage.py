"""Both representations hold the same bonds, whatever the body."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rbs_core as rbs
from rbs_core import Ball, Box, Part, Segment, intact

zone = rbs.Field("zone", "bond", "scalar", "1", "z", "A test.", "uint8", 1)
share = rbs.Field("share", "bond", "scalar", "1", "s", "A test.")
SIZES = {1: (13,), 2: (9, 7), 3: (6, 5, 4)}


def both(dimension: int, ratio: float, hole: float, shift: float) -> list[Part]:
    """The same box with a hole, off the middle, in both representations."""
    parts = []
    for storage in ("list", "lattice"):
        geometry = Box(size=[0.1 * n for n in SIZES[dimension]], center=[0.3] * dimension)
        if dimension > 1:
            geometry = geometry - Ball(hole, [0.3 + shift] * dimension)
        part = Part("body", geometry).discretize(0.1)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a hole may leave nodes alone
            parts.append(part.connect(0.1 * ratio, storage=storage))
    return parts


bodies = st.tuples(st.integers(1, 3), st.floats(1.0, 5.0), st.floats(0.05, 0.22), st.floats(-0.3, 0.3))


def same(one: Part, two: Part) -> None:
    """Both say the same to whoever asks."""
    assert (len(one.bonds), one.bonds.has_broken) == (len(two.bonds), two.bonds.has_broken)
    for mine, other in zip(one.bonds.as_rows(), two.bonds.as_rows(), strict=True):
        assert mine.dtype == other.dtype
        assert np.array_equal(mine, other)
    assert np.array_equal(one.bonds.counts(), two.bonds.counts())
    assert np.array_equal(one.bonds.intact, two.bonds.intact)
    np.testing.assert_allclose(one.bonds.lengths, two.bonds.lengths, rtol=1e-12)  # positions round, steps do not
    for node in range(0, len(one), 7):
        assert np.array_equal(one.bonds.neighbors(node), two.bonds.neighbors(node))
        assert one.bonds.family(node) == two.bonds.family(node)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(bodies, st.tuples(*[st.floats(-0.6, 0.9)] * 4))
def test_random_bodies_cuts_and_removals(body, ends):
    one, two = both(*body)
    same(one, two)
    if body[0] == 2:
        surface = Segment(ends[:2], (ends[2], ends[3] + 1.0))
    else:
        surface = lambda starts, stops: (starts[:, 0] > ends[0]) != (stops[:, 0] > ends[0])  # noqa: E731
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a cut may miss the body
        assert one.bonds.cut(surface) == two.bonds.cut(surface)
        same(one, two)
        inner = lambda starts, stops: np.linalg.norm(starts + stops, axis=1) < 0.6  # noqa: E731
        assert one.bonds.remove(inner) == two.bonds.remove(inner)
    same(one, two)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(bodies, st.floats(0.1, 1.0))
def test_fields_of_bonds(body, size):
    one, two = both(*body)
    for part in (one, two):
        part.bonds.mark(zone, Box(size=[size] * body[0], center=[0.3] * body[0]))
        part.bonds.tabulate(share, lambda bonds: (bonds**2).sum(axis=1))
    assert np.array_equal(one[zone], two[zone])
    np.testing.assert_allclose(one[share], two[share], rtol=1e-12)
    two[zone] = 1
    two[zone] = one[zone]
    assert np.array_equal(one[zone], two[zone])
    two.bonds.set(share, two[share] * 2.0)
    np.testing.assert_allclose(two[share], 2.0 * one[share], rtol=1e-12)
    pairs = {pair: number for number, pair in enumerate(two.bonds)}
    if pairs:
        (i, j), holds = next(iter(pairs)), np.ones(len(pairs), bool)
        holds[[pairs[i, j], pairs[j, i]]] = False
        one[intact] = two[intact] = holds
        same(one, two)


def test_a_lattice_is_smaller():
    one, two = both(3, 3.0, 0.05, 0.0)
    assert two.bonds.nbytes * 10 < one.bonds.nbytes


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_looking_through_a_node(dimension):
    one, two = both(dimension, 2.0, 0.05, 0.25)
    for part in (one, two):
        part[zone] = 1
        part[share] = 1.0
        part.nodes[1].neighborhood[zone] = 1
    for number in range(len(one)):
        assert np.array_equal(one.nodes[number].neighborhood[zone], two.nodes[number].neighborhood[zone])
    one.nodes[0].neighborhood[share] = 3.0
    assert one[share][: len(one.nodes[0].neighborhood)].tolist() == [3.0] * len(one.nodes[0].neighborhood)
