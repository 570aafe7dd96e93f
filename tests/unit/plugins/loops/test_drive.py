"""The parallel loop and its twin on one thread: every task once, with the arrays and numbers of its own segment."""

from __future__ import annotations

import numba
import numpy as np
import pytest

from rbs_plugins.loops import SERIAL_BELOW, Loop, Text, drive

KINDS = ("float64", "float32", "int64", "int32", "uint64", "uint32", "uint16", "uint8")
BOTH = pytest.mark.parametrize("run", [drive.parallel, drive.serial], ids=["parallel", "serial"])


def witness(begin, end, thread, visits, who, weight):
    """Adds to what it visits and says which thread it was."""
    for i in range(begin, end):
        visits[i] += weight
        who[i] = thread
    return 1000 * begin + end


def copy(begin, end, thread, out, a):
    for i in range(begin, end):
        for k in range(a.shape[1]):
            out[i, k] = a[i, k]
    return 0


def segments(*counts):
    """One loop over several arrays, of the lengths given, with a weight of its own for each."""
    arrays = [(np.zeros(count), np.full(count, -1)) for count in counts]
    loops = [
        Loop(Text.of(witness), "witness", {"visits": visits, "who": who, "weight": 1.0 + number}, len(visits))
        for number, (visits, who) in enumerate(arrays)
    ]
    return loops[0].merged(loops[1:]), arrays


def call(run, loop, tasks):
    answers = np.full(len(tasks), -7)
    run(loop._entry, loop._tables, loop._numbers, tasks, answers)
    return answers


@BOTH
def test_every_task_once(run):
    loop, arrays = segments(10_000, 3, 5000)
    answers = call(run, loop, loop.tasks)
    assert np.array_equal(answers, 1000 * loop.tasks[:, 1] + loop.tasks[:, 2])
    for number, (visits, who) in enumerate(arrays):
        assert np.array_equal(visits, np.full(len(visits), 1.0 + number))
        assert 0 <= who.min() <= who.max() < numba.config.NUMBA_NUM_THREADS
        assert run is drive.parallel or not who.any()


@BOTH
def test_only_the_tasks_that_are_given(run):
    loop, arrays = segments(100, 100)
    tasks = np.array([[1, 10, 20], [0, 99, 100], [1, 50, 50]])
    assert call(run, loop, tasks).tolist() == [10_020, 99_100, 50_050]
    first, second = (np.flatnonzero(visits).tolist() for visits, _ in arrays)
    assert (first, second) == ([99], list(range(10, 20)))
    assert call(run, loop, tasks[:0]).tolist() == []


@BOTH
@pytest.mark.parametrize("kind", KINDS)
def test_arrays_of_every_type(run, kind, rng):
    a = rng.integers(0, 200, (300, 3)).astype(kind)
    out = np.zeros_like(a)
    loop = Loop(Text.of(copy), "copy", {"out": out, "a": a}, len(a))
    call(run, loop, loop.tasks)
    assert np.array_equal(out, a)


@pytest.mark.parametrize(("work", "several"), [(SERIAL_BELOW - 1, False), (SERIAL_BELOW, True)])
def test_threads_are_asked_only_where_there_is_enough_to_do(monkeypatch, work, several):
    asked = []
    for name in ("serial", "parallel"):
        monkeypatch.setattr(drive, name, lambda *arguments, name=name: asked.append(name))
    monkeypatch.setattr(numba, "get_num_threads", lambda: 2)
    arguments = {"visits": np.zeros(10_000), "who": np.zeros(10_000, np.int64), "weight": 1.0}
    Loop(Text.of(witness), "witness", arguments, 10_000, work)()
    Loop(Text.of(witness), "witness", arguments, np.array([[0, 10_000]]), work)()  # one task needs one thread
    monkeypatch.setattr(numba, "get_num_threads", lambda: 1)
    Loop(Text.of(witness), "witness", arguments, 10_000, work)()
    assert asked == ["parallel" if several else "serial", "serial", "serial"]
