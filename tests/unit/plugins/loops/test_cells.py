"""Small loops over the cells of a lattice against numpy."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins.fields import breakable, intact
from rbs_plugins.loops import Loop, Text, cells
from rbs_plugins.loops.lattice import Cells
from rbs_plugins.loops.lattice_text import CHUNK


def held(shape, hole):
    box = rbs.Box(size=[float(n) for n in shape])
    geometry = box - rbs.Ball(1.3, [0.2] * len(shape)) if hole else box
    part = rbs.Part("body", geometry).discretize(1.0).connect(2.0, storage="lattice")
    return part, Cells(part.bonds.stored)


def run(function, where, **arguments):
    return Loop(Text.of(function), function.__name__, {**where.tables, **arguments}, where.ranges, 1)()


BODIES = pytest.mark.parametrize(
    ("shape", "hole"), [((9,), False), ((50, 47), False), ((50, 47), True), ((9, 8, 7), True)]
)


@BODIES
def test_ranges_cover_all_nodes(shape, hole):
    _, where = held(shape, hole)
    stored = where.stored
    assert where.first[0] == 0
    assert where.first[-1] == len(stored.cells)
    for c, (begin, end) in enumerate(where.ranges):
        assert (begin, end) == (c, c + 1)
        own = stored.cells[where.first[c] : where.first[c + 1]] - stored.margin
        assert ((own >= c * CHUNK) & (own < (c + 1) * CHUNK)).all()


@BODIES
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_gather(shape, hole, precision, rng):
    part, where = held(shape, hole)
    source = rng.normal(size=part.positions.shape).astype(precision)
    source[: len(part) // 2] = 0.0
    source[len(part) // 2, -1] = np.nan  # is not zero either
    functions = [cells.gather] if hole else [cells.gather, cells.gather_dense]
    for function in functions:
        target = np.full((part.dimension, where.stored.size), 7.0, precision)
        moved = np.full(len(where.ranges), 3, np.uint8)
        run(function, where, source=source, target=target, moved=moved)
        assert np.array_equal(target[:, where.stored.cells].T, source, equal_nan=True)
        empty = np.ones(where.stored.size, bool)
        empty[where.stored.cells] = False
        assert (target[:, empty] == 7.0).all()  # margins and holes are left alone
        spans = zip(where.first[:-1], where.first[1:], strict=True)
        assert moved.tolist() == [int((source[a:b] != 0).any()) for a, b in spans]


@BODIES
def test_survey(shape, hole, rng):
    part, where = held(shape, hole)
    stored = where.stored
    x = part.positions[:, 0]
    pairs = np.array(list(part.bonds))
    holds = (x[pairs] < 0).all(axis=1) & (pairs.sum(axis=1) % 5 == 0)
    part[intact] = holds
    bits = part.raw(intact)
    alive, failed = (np.full((len(where.ranges), len(stored.steps)), 9, np.uint8) for _ in range(2))
    weak = holds & (part.positions[:, 1:][pairs] < 0.5).all(axis=(1, 2))
    part[breakable] = weak
    run(cells.survey, where, bits=bits, zone=part.raw(breakable), alive=alive, failed=failed)
    assert not failed.any()
    wanted = np.zeros(alive.shape, np.uint8)
    for (here, there), there_is, may_fail in zip(stored.cells[pairs], holds, weak, strict=True):
        if there_is:
            step = int(np.flatnonzero(stored.steps == abs(there - here))[0])
            wanted[(here - stored.margin) // CHUNK, step] |= cells.HOLDS + cells.MAY_FAIL * may_fail
    assert np.array_equal(alive, wanted)
