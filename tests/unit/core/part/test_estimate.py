"""Parts that do not fit into memory are refused before their nodes or bonds are made."""

from __future__ import annotations

import re
import time

import numpy as np
import pytest

from rbs_core import BadInput, Box, Everywhere, Part
from rbs_core.part import estimate
from rbs_core.part.connection import Connection


def cube(spacing: float = 0.1) -> Part:
    return Part("cube", Box(size=(1.0, 1.0, 1.0))).discretize(spacing)


def cloud(n: int, rng, name: str = "cloud") -> Part:
    return Part(name, Everywhere(), dimension=3).place(rng.random((n, 3)), 1.0)


def test_a_grid_of_too_many_points():
    """Real numbers: 64 billion points fit into no machine that runs tests; nothing is made, so this takes no time."""
    before = time.perf_counter()
    with pytest.raises(
        BadInput, match=r"part 'cube': a grid of 4,096,000,000 points would need 393 GB of memory, and "
    ):
        Part("cube", Box(size=(1.0, 1.0, 1.0))).discretize(1.0 / 1600)
    assert time.perf_counter() - before < 1.0


def test_a_horizon_in_millimetres_for_a_part_in_metres(monkeypatch):
    part = cube(0.02)
    monkeypatch.setenv("RBS_MEMORY", "1GB")
    with pytest.raises(BadInput) as caught:
        part.connect(horizon=60.0)
    assert re.fullmatch(
        r"part 'cube': its bonds \(970,298 neighbors of a node\) would need \d+ GB of memory, and 1 GB are free: "
        r"take a smaller horizon or a larger spacing",
        str(caught.value),
    )
    assert not part.connected
    assert part.connect(horizon=0.0603).connected


@pytest.mark.parametrize(("size", "ratio"), [((30, 30), 3.015), ((12, 12, 12), 3.0), ((400,), 5.0), ((8, 8, 8), 100.0)])
def test_the_estimate_for_a_lattice_is_close(monkeypatch, size, ratio):
    told = []
    monkeypatch.setattr(estimate, "require_memory", lambda nbytes, *_: told.append(nbytes))
    part = Part("part", Box(size=tuple(map(float, size)))).discretize(1.0).connect(ratio, storage="lattice")
    words = part.bonds.stored.present.nbytes
    assert 0.3 * words < told[-1] < 1.5 * words + 1000


def test_bonds_of_a_list_are_counted_before_there_is_room_for_them(monkeypatch, rng):
    part = cloud(3000, rng)
    part.connect(horizon=0.2)
    bonds = len(part.bonds)
    monkeypatch.setenv("RBS_MEMORY", str(12 * bonds - 1))
    with pytest.raises(BadInput, match=rf"a list of {bonds:,} directed bonds would need .* smaller horizon"):
        part.connect(horizon=0.2)
    monkeypatch.setenv("RBS_MEMORY", str(12 * bonds))
    part.connect(horizon=0.2)


def test_a_list_of_all_pairs_is_not_even_counted(monkeypatch, rng):
    part = cloud(20_000, rng)
    monkeypatch.setenv("RBS_MEMORY", "1GB")
    monkeypatch.setattr("rbs_core.part.search.cloud_rows", lambda *_: pytest.fail("searched all pairs"))
    with pytest.raises(BadInput, match=r"'cloud': a list of about 4e\+08 directed bonds would need 4.8 GB"):
        part.connect(horizon=10.0)


def test_a_lattice_that_would_become_too_long_a_list(monkeypatch):
    part = cube().connect(horizon=0.31)
    needed = estimate.CONVERTED * len(part.bonds)
    monkeypatch.setenv("RBS_MEMORY", str(needed - 1))
    with pytest.raises(BadInput, match="part 'cube': its bonds as list, for Toy 'cube' would need"):
        part.bonds.need_list("Toy 'cube'")
    assert part.bonds.storage == "lattice"
    monkeypatch.setenv("RBS_MEMORY", str(needed))
    part.bonds.need_list("Toy 'cube'")
    assert part.bonds.storage == "list"


def test_connections_count_their_pairs_first(monkeypatch, rng):
    one, two = cloud(2000, rng, "one"), cloud(2000, rng, "two")
    few = Connection(one, two, horizon=0.05)
    assert len(few.bonds) > 0
    monkeypatch.setenv("RBS_MEMORY", "100MB")
    for ends in ((one, two), (one, None)):
        with pytest.raises(
            BadInput, match=r"a search for nodes within 2 m of each other: [\d,]+ pairs would need \d+ MB"
        ):
            Connection(*ends, horizon=2.0)
    again = Connection(one, two, horizon=0.05)
    assert np.array_equal(again.pairs, few.pairs)
