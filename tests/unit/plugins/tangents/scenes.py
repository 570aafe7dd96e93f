"""Parts with relations on them, asked for their forces at any displacement, for tests of tangents."""

from __future__ import annotations

import numpy as np

import rbs_core as rbs
from rbs_plugins.fields import displacement, force_density

SPACING = 0.5


def parts(turned=False, gap=1.0):
    """Two small plates beside each other with unequal volumes; the second one in a turned system, if it shall be."""
    axes = np.array([[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    other = rbs.world.child("turned", origin=[0.3, -0.2], axes=axes) if turned else rbs.world
    rng = np.random.default_rng(3)
    made = []
    for name, low, system in (("left", 0.0, rbs.world), ("right", 2.0 + gap, other)):
        grid = np.stack(np.meshgrid(np.arange(3.0) + low, np.arange(3.0), indexing="ij"), axis=-1).reshape(-1, 2)
        points = (grid + rng.uniform(-0.1, 0.1, grid.shape)) * SPACING
        part = rbs.Part(name, rbs.Everywhere(), dimension=2, system=system)
        place = points if system is rbs.world else rbs.convert(points, rbs.world, system)
        part.place(place, rng.uniform(0.7, 1.3, 9) * SPACING**2, spacing=SPACING, thickness=1.0)
        part.connect(2.1 * SPACING, storage="list")
        made.append(part)
    return made


class Held:
    """Relations that hold the damage, ready to be asked.

    Args:
        ends: the parts whose displacements count, in order.
        relations: forces, and what else runs.
    """

    def __init__(self, ends, relations):
        self.ends = ends
        for end in ends:
            end[displacement] = 0.0
        analysis = rbs.Analysis(relations)
        self._plan, self.relations = analysis.prepare(), analysis.relations
        self.clock = rbs.Clock(dt=1e-3, step=1, time=0.25, last_step=1)
        for relation in self.relations:
            relation.begin(self.clock)
            if hasattr(relation, "hold"):
                relation.hold = True

    def force(self, u):
        """(dN,) forces on the nodes at a displacement (dN,), N."""
        begin = 0
        for end in self.ends:
            size = end[displacement].size
            end[displacement] = u[begin : begin + size].reshape(-1, end.dimension)
            begin += size
            end[force_density] = 0.0
        for position, relation in enumerate(self.relations):
            for part, field in self._plan.clear.get(position, ()):
                part[field][...] = 0
            relation.apply(self.clock)
        return np.concatenate([(end[force_density] * end[rbs.volume][:, None]).ravel() for end in self.ends])

    def differences(self, u, step=1e-7):
        """−dF/du by central differences."""
        columns = []
        for index in range(len(u)):
            one, two = u.copy(), u.copy()
            one[index] += step
            two[index] -= step
            columns.append((self.force(two) - self.force(one)) / (one[index] - two[index]))
        self.force(u)
        return np.array(columns).T


def assert_near(found, expected, tolerance):
    """Of the largest entry."""
    worst = np.abs(found - expected).max() / np.abs(expected).max()
    assert worst <= tolerance, f"off by {worst:.3g} of the largest"


def assert_consistent(tangent, differences):
    """A tangent is what differences say, whichever way it is asked."""
    whole = tangent.matrix().toarray()
    assert_near(whole, differences, 1e-6)
    v = np.random.default_rng(1).uniform(-1.0, 1.0, len(whole))
    out = np.zeros_like(v)
    tangent.multiply(v, out)
    assert_near(out, whole @ v, 1e-12)
    out = np.zeros_like(v)
    tangent.diagonal(out)
    assert_near(out, np.diag(whole), 1e-12)
    if tangent.symmetric:
        assert_near(whole, whole.T, 1e-12)
