"""Small loops over the cells of a lattice against numpy."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins.fields import intact
from rbs_plugins.loops import Loop, Text, cells
from rbs_plugins.loops.lattice_text import CHUNK
from rbs_plugins.loops.ranges import Cells


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
    run(cells.survey, where, bits=bits, alive=alive, failed=failed)
    assert not failed.any()
    wanted = np.zeros(alive.shape, np.uint8)
    for here, there in stored.cells[pairs][holds]:
        if there > here:
            wanted[(here - stored.margin) // CHUNK, np.flatnonzero(stored.steps == there - here)[0]] = 1
    assert np.array_equal(alive, wanted)


@BODIES
@pytest.mark.parametrize("start", [0, 1])
@pytest.mark.parametrize("components", [1, 2])
def test_finish(shape, hole, start, components, rng):
    part, where = held(shape, hole)
    functions = [cells.finish] if hole else [cells.finish, cells.finish_dense]
    for function in functions:
        targets, out = np.zeros((components, where.stored.size)), rng.normal(size=(len(part), components))
        values, before = rng.normal(size=out.shape), out.copy()
        targets[:, where.stored.cells] = values.T
        assert not run(function, where, targets=targets, out=out, cell=3.0, start=start).any()
        np.testing.assert_allclose(out, 3.0 * values + (0.0 if start else before), rtol=1e-14)
        assert not targets.any()


@BODIES
def test_finish_finds_what_is_not_finite(shape, hole):
    part, where = held(shape, hole)
    for function in [cells.finish] if hole else [cells.finish, cells.finish_dense]:
        for wrong in (np.nan, np.inf, -np.inf):
            targets, out = np.zeros((1, where.stored.size)), np.zeros((len(part), 1))
            targets[0, where.stored.cells[-1]] = wrong
            assert run(function, where, targets=targets, out=out, cell=1.0).tolist() == [0] * (
                len(where.ranges) - 1
            ) + [1]
