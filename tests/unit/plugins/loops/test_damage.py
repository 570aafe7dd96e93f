"""The broken share of families, over rows and over a lattice."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins.fields import damage, intact, volume
from rbs_plugins.loops.damage import damage_loops


@pytest.mark.parametrize("storage", ["list", "lattice"])
@pytest.mark.parametrize("shape", [(9,), (7, 5), (40, 40), (4, 5, 3)])
def test_against_the_definition(storage, shape, rng):
    part = rbs.Part("body", rbs.Box(size=[float(n) for n in shape])).discretize(1.0).connect(2.0, storage=storage)
    part[volume] = rng.uniform(1.0, 2.0, len(part))
    pairs = np.array(list(part.bonds))
    holds = (pairs.min(axis=1) * 7 + pairs.max(axis=1)) % 3 > 0  # the same from both ends
    part[intact], part[damage] = holds, 0.5
    for loop in damage_loops(part.bonds.stored, part.raw(intact), part[volume], part[damage])[0]:
        loop()
    total = np.bincount(pairs[:, 0], part[volume][pairs[:, 1]], len(part))
    left = np.bincount(pairs[:, 0], part[volume][pairs[:, 1]] * holds, len(part))
    np.testing.assert_allclose(part[damage], 1.0 - left / total, rtol=1e-13, atol=1e-14)


def test_a_node_without_bonds_has_no_damage():
    with pytest.warns(UserWarning, match="no bond"):
        part = rbs.Part("body", rbs.Box(size=1.0)).discretize(1.0).connect(2.0)
    part[damage] = 1.0
    for loop in damage_loops(part.bonds.stored, part.raw(intact), part[volume], part[damage])[0]:
        loop()
    assert part[damage].tolist() == [0.0]
