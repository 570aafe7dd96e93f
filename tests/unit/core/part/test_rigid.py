"""Systems in which a length is a length, and others, which a part refuses."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, Box, Part
from rbs_core.space import Cartesian, Mapping

SQUARE = Box(size=(1.0, 1.0))


class Curved(Mapping):
    """Polar coordinates, as far as the test needs them."""

    def to_parent(self, points):
        return np.column_stack([points[:, 0] * np.cos(points[:, 1]), points[:, 0] * np.sin(points[:, 1]), points[:, 2]])

    def from_parent(self, points):
        return np.column_stack([np.hypot(*points[:, :2].T), np.arctan2(points[:, 1], points[:, 0]), points[:, 2]])

    def __repr__(self):
        return "Curved()"


def turned(angle: float) -> list[tuple[float, float]]:
    return [(np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))]


def test_shifted_turned_and_mirrored_systems_are_rigid():
    far = rbs.world.child("far", origin=(1e6, -2e6), axes=turned(0.3))
    near = far.child("near", origin=(1.0, 2.0, 3.0), axes=turned(-1.1))
    mirrored = near.child("mirrored", axes=[(1, 0, 0), (0, 1, 0), (0, 0, -1)])
    for system in (rbs.world, far, near, mirrored, rbs.CoordinateSystem("moon")):
        assert Part("p", SQUARE, system=system).system is system


def test_what_is_stretched_and_shrunk_again_is_rigid():
    twice = rbs.world.child("twice", axes=2 * np.eye(3))
    assert Part("p", SQUARE, system=twice.child("half", axes=np.eye(3) / 2)).system.name == "half"


@pytest.mark.parametrize(
    "axes",
    [
        [(2, 0), (0, 1)],
        [(1, 0), (0.1, 1)],
        np.diag([1e-3, 1e-3, 1e-3]),
        [(1, 0, 0), (0, 1, 0), (0, 0, 1 + 1e-8)],
        [(0.7071, 0.7071), (-0.7071, 0.7071)],
    ],
)
def test_stretched_and_sheared_axes_are_refused(axes):
    bad = rbs.world.child("bad", axes=axes)
    below = bad.child("below", origin=(1.0, 0.0), axes=turned(0.2))
    message = (
        r"Part\('p'\): system 'world/bad' has axes that are not of length 1 at right angles .*, so that bond "
        r"lengths would not be lengths: give it such axes, or stretch the geometry instead with geometry\.placed"
    )
    for system in (bad, below):
        with pytest.raises(BadInput, match=message):
            Part("p", SQUARE, system=system)


def test_curved_systems_are_refused():
    for curved in (rbs.world.cylindrical("pipe"), rbs.world.spherical("globe").child("below")):
        with pytest.raises(BadInput, match=r"is not Cartesian \((Cylindrical|Spherical)\(origin=.*put the part into a"):
            Part("p", SQUARE, system=curved)
    polar = rbs.world.mapped("polar", Curved())
    with pytest.raises(BadInput, match=r"system 'world/polar' is not Cartesian \(Curved\(\)\), so that bond lengths"):
        Part("p", SQUARE, system=polar.child("below"))


def test_what_is_no_system_is_refused():
    with pytest.raises(BadInput, match=r"Part\('p'\): system = 'world' is no CoordinateSystem; give world or"):
        Part("p", SQUARE, system="world")


def test_a_system_may_move_later():
    system = rbs.world.child("moving")
    part = Part("p", SQUARE, system=system).discretize(0.5).connect(0.5)
    lengths = part.bonds.lengths
    system.mapping = Cartesian((1.0, 2.0), turned(0.5))
    system.rotate(0.2, center=(5.0, 5.0))
    system.translate((0.0, 1.0))
    assert np.array_equal(part.bonds.lengths, lengths)
    assert rbs.convert(part.positions, part.system, rbs.world).shape == (4, 2)
