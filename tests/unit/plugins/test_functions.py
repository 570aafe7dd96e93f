"""Functions for laws: as exact as they say, in loops that compute several bonds at once, and in plain Python."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import PairwiseForce, functions
from rbs_plugins.fields import displacement, force_density
from rbs_plugins.loops import Loop, Text
from tests.unit.plugins.loops.test_recipe_vectorised import assembly_of

ACCURATE = 1e-12  # relative, as promised
INFINITE, NONE = math.inf, math.nan
NAMES = ("exp", "log", "pow", "tanh")


def compiled(name, *columns):
    """What a function answers in a compiled loop, in the precision of the columns."""
    arguments = ", ".join(f"x{k}[i]" for k in range(len(columns)))
    given = ", ".join(f"x{k}" for k in range(len(columns)))
    body = (
        f"from rbs_plugins.functions import {name}\n\n@njit(error_model='numpy')\n"
        f"def ask(begin, end, thread, {given}, out):\n    for i in range(begin, end):\n"
        f"        out[i] = {name}({arguments})\n    return 0\n"
    )
    out = np.empty_like(columns[0])
    Loop(Text(body), "ask", {**{f"x{k}": c for k, c in enumerate(columns)}, "out": out}, len(out))()
    return out


def spread(rng, low, high, count=2000):
    """Numbers of every size between two powers of ten."""
    return 10.0 ** rng.uniform(low, high, count)


SAMPLES = {
    "exp": lambda rng: (np.concatenate([rng.uniform(-708, 709, 2000), spread(rng, -20, 2), -spread(rng, -20, 2)]),),
    "log": lambda rng: (np.concatenate([spread(rng, -307, 308), 1 + spread(rng, -15, -1), 1 - spread(rng, -15, -1)]),),
    "pow": lambda rng: (spread(rng, -30, 30), rng.uniform(-10, 10, 2000)),
    "tanh": lambda rng: (np.concatenate([spread(rng, -300, 3), -spread(rng, -300, 3)]),),
}


@pytest.mark.parametrize("name", NAMES)
def test_in_loops_they_are_as_exact_as_promised(name, rng):
    columns = SAMPLES[name](rng)
    np.testing.assert_allclose(compiled(name, *columns), getattr(np, name)(*columns), rtol=ACCURATE)


@pytest.mark.parametrize("name", NAMES)
def test_single_precision_is_good_to_its_last_digit(name, rng):
    columns = [np.clip(column, -80, 80).astype(np.float32) for column in SAMPLES[name](rng)]
    if name != "exp":
        columns[0] = np.clip(columns[0], 1e-3, 1e3)
    exact = getattr(np, name)(*(column.astype(np.float64) for column in columns))
    np.testing.assert_allclose(compiled(name, *columns), exact, rtol=2**-24)


EDGES = [
    ("exp", 0.0, 1.0), ("exp", 710.0, INFINITE), ("exp", -710.0, 0.0), ("exp", INFINITE, INFINITE),
    ("exp", -INFINITE, 0.0), ("exp", NONE, NONE), ("log", 1.0, 0.0), ("log", 0.0, -INFINITE), ("log", -1.0, NONE),
    ("log", INFINITE, INFINITE), ("log", NONE, NONE), ("tanh", 0.0, 0.0), ("tanh", INFINITE, 1.0),
    ("tanh", -INFINITE, -1.0), ("tanh", NONE, NONE), ("tanh", 1e-310, 1e-310),
]  # fmt: skip


@pytest.mark.parametrize(("name", "x", "wanted"), EDGES)
def test_at_the_edges_plain_python_and_loops_agree(name, x, wanted):
    np.testing.assert_equal(getattr(functions, name)(x), wanted)
    np.testing.assert_equal(compiled(name, np.array([x]))[0], wanted)


POWERS = [
    (0.0, 0.0, 1.0), (0.0, 2.5, 0.0), (0.0, -1.0, INFINITE), (-1.0, 2.0, NONE), (2.0, 0.0, 1.0),
    (10.0, 400.0, INFINITE), (10.0, -400.0, 0.0), (INFINITE, -1.0, 0.0), (NONE, 1.0, NONE),
]  # fmt: skip


@pytest.mark.parametrize(("x", "y", "wanted"), POWERS)
def test_powers_at_the_edges(x, y, wanted):
    np.testing.assert_equal(functions.pow(x, y), wanted)
    np.testing.assert_equal(compiled("pow", np.array([x]), np.array([y]))[0], wanted)


@pytest.mark.parametrize("name", NAMES)
def test_plain_python_computes_the_same(name, rng):
    columns = [column[::50].copy() for column in SAMPLES[name](rng)]
    plain = [getattr(functions, name)(*row) for row in zip(*(column.tolist() for column in columns), strict=True)]
    np.testing.assert_allclose(plain, compiled(name, *columns), rtol=ACCURATE)


# -- in laws -------------------------------------------------------------------------------------------------------


def saturating(stretch, c, limit):
    return c * limit * functions.tanh(stretch / limit)


def softening(stretch, c, limit):
    return c * stretch * functions.exp(-functions.pow(abs(stretch) / limit, 1.5)) + 0.0 * functions.log(1.0 + stretch)


def made(law, precision="double", storage="lattice"):
    part = (
        rbs.Part("plate", rbs.Box(size=(8.0, 8.0)), precision=precision).discretize(1.0).connect(3.0, storage=storage)
    )
    return PairwiseForce(part, law, c=2.0, limit=0.01)


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize("law", [saturating, softening])
def test_a_law_with_them_is_computed_side_by_side(law, precision, monkeypatch):
    monkeypatch.setenv("RBS_CACHE", "off")
    assembly = assembly_of(made(law, precision))
    packed, single = (len(re.findall(rf"\bv?(mul|fn?madd\d*|fmadd\d*){kind}\b", assembly)) for kind in ("pd", "sd"))
    assert packed > 0
    assert packed >= single / 4  # what is left for single bonds is the tail of a range, once
    assert not re.search(r"\b(exp|log|pow|tanh)f?\b", assembly)


@pytest.mark.parametrize("storage", ["list", "lattice"])
@pytest.mark.parametrize("law", [saturating, softening])
def test_a_law_with_them_gives_the_right_force(law, storage, rng):
    force = made(law, storage=storage)
    part = force.part
    part[displacement] = 1e-3 * rng.normal(size=part.positions.shape)
    rbs.Analysis([force]).run(steps=1, dt=0.1, force_dt=True, progress=False)
    i = 27
    y = part.positions + part[displacement]
    total = np.zeros(2)
    for j in part.bonds.neighbors(i):
        d, size = y[j] - y[i], np.linalg.norm(part.positions[j] - part.positions[i])
        stretch = np.linalg.norm(d) / size - 1
        total += law(stretch, 2.0, 0.01) * d / np.linalg.norm(d)
    np.testing.assert_allclose(part[force_density][i], total, rtol=1e-9)
