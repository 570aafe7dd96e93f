"""Solids: closed, and known by their distance."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.geometry import Ball, Cone, Cylinder, Plane, Solid
from rbs_core.geometry.solid import bounds_of
from tests.unit.core.geometry.examples import EXAMPLES

# A ball is closed to the last bit: what is on it up to round-off may be outside.
SOLIDS = [each for each in EXAMPLES if isinstance(each, Solid) and not isinstance(each, Ball)]


@pytest.mark.parametrize("solid", SOLIDS, ids=repr)
def test_the_surface_belongs_to_a_solid(solid, rng):
    surface = solid.projection(rng.uniform(-1.0, 1.0, (200, solid.dimension)))
    assert solid.contains(surface).all()
    assert solid.distance(surface) == pytest.approx(0.0, abs=1e-12)


def test_bounds_by_how_far_it_reaches():
    lower, upper = bounds_of(Cylinder(1.0, (0, 0, 0), (0, 0, 2)))
    assert lower.tolist() == [-1.0, -1.0, 0.0]
    assert upper.tolist() == [1.0, 1.0, 2.0]
    assert not np.signbit(bounds_of(Plane((0.0, 0.0), (0.0, 1.0)))[0][1])
    cone = Cone(1.0, (0, 0, 0), (1.0, 0.0, 1.0))
    tilt = np.sqrt(0.5)
    assert np.allclose(cone.bounds, [[-tilt, -1.0, -tilt], [1.0, 1.0, 1.0]])
