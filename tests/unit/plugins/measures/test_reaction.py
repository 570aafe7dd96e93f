"""Reaction forces in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, Field
from rbs_plugins import BoundaryDomain, OrdinaryStateBased, ReactionForce
from rbs_plugins.fields import displacement, reaction_force
from rbs_plugins.testing import body

left = Field("left", "part", "vector", "N", "R", "Force that holds the left half.")


def test_the_halves_of_a_stretched_bar_pull_with_its_section_force():
    """N = E A ε."""
    bar = body(1, "lattice", notched=False)
    bar[displacement] = 1e-6 * bar.positions
    middle = bar.positions.mean()
    force = OrdinaryStateBased(bar, E=1e9)
    right = BoundaryDomain(bar, rbs.HalfSpace((middle,), normal=(1,)), velocity=0.0)
    relations = [
        force,
        ReactionForce(bar, right),
        ReactionForce(bar, rbs.HalfSpace((middle,), normal=(-1,)), field=left),
    ]
    rbs.Analysis(relations).run(steps=1, dt=1.0, force_dt=True, progress=False)
    assert bar[reaction_force][0] == pytest.approx(1e9 * bar.area * 1e-6, rel=1e-9)
    assert bar[left][0] == pytest.approx(-1e9 * bar.area * 1e-6, rel=1e-9)


def test_bad_input_is_refused():
    part, other = body(2), body(2)
    with pytest.raises(BadInput, match="no node lies in"):
        ReactionForce(part, rbs.Nowhere())
    with pytest.raises(BadInput, match="prescribes a load"):
        ReactionForce(part, BoundaryDomain(part, rbs.Everywhere(), body_force=(0.0, 1.0)))
    with pytest.raises(BadInput, match="another part"):
        ReactionForce(part, BoundaryDomain(other, rbs.Everywhere(), velocity=(0.0, 1.0)))
    with pytest.raises(BadInput, match="must be a field like"):
        ReactionForce(part, np.arange(3), field=displacement)
