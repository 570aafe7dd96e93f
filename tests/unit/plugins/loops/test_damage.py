"""The broken share of families, over rows and over a lattice."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import Damage
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


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_bonds_of_connections_count(storage):
    """Two halves with a connection have the damage of the whole, wherever bonds are cut."""
    dx, cuts = 0.1, [rbs.Segment((-9.0, 0.0), (0.12, 0.0)), rbs.Segment((-0.35, -0.55), (0.3, 0.2))]

    def plate(name, x, n):
        part = rbs.Part(name, rbs.Box(size=(n * dx, 8 * dx), center=(x, 0.0))).discretize(dx)
        return part.connect(3.015 * dx, storage=storage)

    whole, halves = plate("whole", 0.0, 8), [plate("left", -0.2, 4), plate("right", 0.2, 4)]
    link = rbs.Connection(*halves, horizon=3.015 * dx)
    for bonds in (whole.bonds, link.bonds, *(part.bonds for part in halves)):
        for cut in cuts:
            bonds.cut(cut)
    rbs.Analysis([Damage(whole), *(Damage(part, [link]) for part in halves)]).run(steps=1, dt=1.0, progress=False)
    for part in halves:
        order = [int(np.linalg.norm(whole.positions - x, axis=1).argmin()) for x in part.positions]
        np.testing.assert_allclose(part[damage], whole[damage][order], atol=1e-14)
        assert part[damage].max() > 0.4


def test_only_connections_of_the_part_that_stay():
    parts = [
        rbs.Part(name, rbs.Box(size=1.0, center=x)).discretize(0.1).connect(0.3)
        for name, x in zip("abc", range(3), strict=True)
    ]
    link = rbs.Connection(parts[0], parts[1], horizon=0.3)
    with pytest.raises(rbs.BadInput, match="is no connection of this part"):
        Damage(parts[2], [link])
    link.search_during_runs()
    with pytest.raises(rbs.BadInput, match="the bonds of 'a to b' are searched again: leave it out"):
        rbs.Analysis([Damage(parts[0], link)]).prepare()
