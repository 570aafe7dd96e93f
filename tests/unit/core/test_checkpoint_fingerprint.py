"""When are two functions, given to a relation, the same? The fingerprint in a checkpoint must know."""

from __future__ import annotations

import math
import os
import subprocess
import sys

import numba
import numpy as np
import pytest

import rbs_core as rbs
from rbs_core.checkpoint import fingerprint
from tests.unit.core.toys import Toy, a, line

SPEED = 20.0
TABLE = np.array([1.0, 2.0])


def helper(time):
    return 2.0 * time


def printed(**parameters) -> str:
    """What a checkpoint says about a relation with these parameters."""
    return fingerprint(rbs.Analysis([Toy(line(), updates=(a,), **parameters)]), 0.1)["relation 0"]


def scaled(factor):
    def law(stretch):
        return factor * stretch

    return law


PAIRS = {
    "constant": (lambda time: 2.0 * time, lambda time: 3.0 * time),
    "operation": (lambda time: 2.0 * time, lambda time: 2.0 + time),
    "name": (lambda time: math.sin(time), lambda time: math.cos(time)),
    "captured value": (scaled(1.0), scaled(2.0)),
    "captured function": (scaled(helper), scaled(scaled(1.0))),
    "default": (lambda time, k=1.0: k * time, lambda time, k=2.0: k * time),
    "keyword default": (lambda time, *, k=1.0: k * time, lambda time, *, k=2.0: k * time),
    "inner function": (lambda time: [t + 1.0 for t in time], lambda time: [t + 2.0 for t in time]),
    "number": (1.0, 2.0),
    "array": (np.zeros(3), np.ones(3)),
    "entry of a list": ([None, 1.0], [None, 2.0]),
    "entry of a dict": ({"x": scaled(1.0)}, {"x": scaled(2.0)}),
    "geometry": (rbs.Box(size=(1.0, 2.0)), rbs.Box(size=(1.0, 3.0))),
    "trigger": (rbs.every(2), rbs.every(3)),
    "jitted": (numba.njit(scaled(1.0)), numba.njit(scaled(2.0))),
}


@pytest.mark.parametrize(("one", "other"), PAIRS.values(), ids=PAIRS)
def test_what_computes_something_else_is_told_apart(one, other):
    assert printed(law=one) == printed(law=one)
    assert printed(law=one) != printed(law=other)


def test_a_global_number_belongs_to_the_function(monkeypatch):
    def law(time):
        return SPEED * time + TABLE[0]

    before = printed(law=law)
    monkeypatch.setitem(globals(), "SPEED", 30.0)
    changed = printed(law=law)
    assert before != changed
    monkeypatch.setitem(globals(), "TABLE", np.array([5.0, 2.0]))
    assert printed(law=law) != changed


def test_the_same_function_made_twice_is_the_same():
    assert printed(law=scaled(1.0)) == printed(law=scaled(1.0))
    assert printed(law=numba.njit(scaled(1.0))) == printed(law=numba.njit(scaled(1.0)))


def test_a_function_that_calls_itself():
    def factorial(n):
        return 1 if n < 2 else n * factorial(n - 1)

    assert printed(law=factorial) == printed(law=factorial)


def test_objects_without_a_text_of_their_own_have_no_address():
    assert "0x" not in printed(law=object())


SCRIPT = """
import rbs_core as rbs
from rbs_core.checkpoint import fingerprint
from rbs_plugins import BoundaryDomain
part = rbs.Part("bar", rbs.Box(size=1.0)).discretize(0.25)
names = {"x", "y", "z"}
def speed(time): return 2.0 if "x" in {"x", "y", "z", "w"} else len(names)
analysis = rbs.Analysis([BoundaryDomain(part, rbs.Everywhere(), velocity=speed)])
print(sorted(fingerprint(analysis, 0.1).items()))
"""


def test_the_fingerprint_is_the_same_in_every_process():
    """Sets of texts are stored in another order in every process."""
    runs = [
        subprocess.run(
            [sys.executable, "-c", SCRIPT],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        )
        for seed in ("1", "2")
    ]
    assert runs[0].stdout == runs[1].stdout
    assert "BoundaryDomain 'bar'" in runs[0].stdout
