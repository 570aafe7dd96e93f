"""Bonds as compressed rows."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core import Box, Part, Segment
from rbs_core.part import Rows, rows


def plate() -> Part:
    return Part("plate", Box(size=(6.0, 6.0))).discretize(1.0).connect(2.0, storage="list")


def crossing(part: Part) -> np.ndarray:
    y = part.positions[:, 1]
    return np.array([(y[i] > 0) != (y[j] > 0) for i, j in part.bonds])


@pytest.mark.parametrize("chunk", [1, 7, 1 << 20])
def test_the_runs_in_which_bonds_are_looked_at_do_not_matter(monkeypatch, chunk):
    monkeypatch.setattr(rows, "_CHUNK", chunk)
    part = plate()
    part.bonds.cut(Segment((-9.0, 0.0), (9.0, 0.0)))
    assert np.array_equal(part.bonds.intact, ~crossing(part))
    part = plate()
    assert part.bonds.remove(Segment((-9.0, 0.0), (9.0, 0.0))) > 0
    assert not crossing(part).any()


def test_the_list_counts_its_memory():
    stored = Part("bar", Box(size=3.0)).discretize(1.0).connect(1.0, storage="list").bonds.stored
    assert isinstance(stored, Rows)
    assert stored.nbytes == 4 * 8 + 4 * 4 + 4 * 8
