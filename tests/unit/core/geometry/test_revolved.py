"""Solids around an axis, and capsules."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import Bar, Capsule, Cone, Cylinder, HalfSpace, Slab, Torus, Tube


def test_cylinder_and_tube():
    cylinder, tube = Cylinder(1.0, (0, 0, 0), (0, 0, 4)), Tube(1.0, 0.5, (0, 0, 0), (0, 0, 4))
    points = [[0.0, 0.0, 2.0], [0.0, 0.75, 2.0], [0.0, 3.0, 2.0], [4.0, 0.0, 8.0], [0.0, 0.0, -1.0]]
    assert cylinder.distance(points) == pytest.approx([-1.0, -0.25, 2.0, 5.0, 1.0])
    assert tube.distance(points) == pytest.approx([0.5, -0.25, 2.0, 5.0, np.hypot(0.5, 1.0)])
    assert cylinder.projection([[0.0, 0.5, 3.9], [3.0, 0.0, 2.0]]) == pytest.approx(
        np.array([[0.0, 0.5, 4.0], [1.0, 0.0, 2.0]])
    )
    assert cylinder.status([[1.0, 0.0, 1.0], [0.0, 0.0, 4.0], [0.0, 0.0, 2.0]]).tolist() == [0, 0, -1]


def test_the_axis_is_no_surface():
    """Points near it would find the flat side of the profile there, were it not continued."""
    for solid in (Cylinder(1.0, (0, 0, 0), (0, 0, 4)), Cone(1.0, (0, 0, 0), (0, 0, 4))):
        near = solid.distance([[0.0, 0.0, 1.0], [1e-6, 0.0, 1.0]])
        assert (near < -0.5).all()


@pytest.mark.parametrize(
    ("solid", "members"),
    [
        (
            Cylinder(0.5, (0.1, 0.2, 0.3), (0.7, 0.2, 1.1)),
            Bar(0.5, (0.1, 0.2, 0.3), (0.6, 0.0, 0.8)) & Slab(1.0, (0.4, 0.2, 0.7), (0.6, 0.0, 0.8)),
        ),
        (
            Tube(0.5, 0.2, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
            (Bar(0.5, (0, 0, 0), (0, 0, 1)) - Bar(0.2, (0, 0, 0), (0, 0, 1)))
            & HalfSpace((0, 0, 0), (0, 0, 1))
            & HalfSpace((0, 0, 1), (0, 0, -1)),
        ),
    ],
    ids=["cylinder", "tube"],
)
def test_they_are_what_set_operations_make_of_primaries(solid, members, rng):
    points = rng.uniform(-1.0, 1.5, (5000, 3))
    assert np.array_equal(solid.contains(points), members.contains(points))
    bound, exact = members.distance(points), solid.distance(points)
    assert np.array_equal(np.sign(bound), np.sign(exact))
    assert (np.abs(bound) <= np.abs(exact) + 1e-12).all()


def test_cone_and_frustum():
    cone = Cone(3.0, (0, 0, 0), (0, 0, 4))
    assert cone.distance([[0.0, 0.0, 4.0], [0.0, 0.0, 9.0], [0.0, 0.0, 1.0]]) == pytest.approx([0.0, 5.0, -1.0])
    assert cone.distance([[3.0, 0.0, 4.0]]) == pytest.approx([12.0 / 5.0])
    frustum = Cone(3.0, (0, 0, 0), (0, 0, 2), top=1.5)
    assert frustum.contains([[1.5, 0.0, 2.0], [1.6, 0.0, 2.0], [2.2, 0.0, 1.0], [2.3, 0.0, 1.0]]).tolist() == [
        True, False, True, False
    ]  # fmt: skip
    assert repr(cone) == "Cone(radius=3.0, start=(0.0, 0.0, 0.0), end=(0.0, 0.0, 4.0))"


def test_torus():
    torus = Torus(2.0, 0.5, (0, 0, 0), (0, 0, 1))
    assert torus.distance([[2.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 3.0, 0.0]]) == pytest.approx([-0.5, 1.5, 0.5])
    assert np.allclose(torus.bounds, [[-2.5, -2.5, -0.5], [2.5, 2.5, 0.5]])


def test_capsule():
    capsule = Capsule(0.5, (0, 0), (2, 0))
    assert capsule.distance([[1.0, 0.0], [-1.0, 0.0], [5.0, 4.0]]).tolist() == [-0.5, 0.5, 4.5]
    assert capsule.dimension == 2
    assert np.array_equal(capsule.bounds, [[-0.5, -0.5], [2.5, 0.5]])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Cylinder(1.0, (0, 0, 0), (0, 0, 0)), r"start = end = \(0.0, 0.0, 0.0\): no axis; give two different"),
        (lambda: Cylinder(0.0, (0, 0, 0), (0, 0, 1)), r"radius = 0.0 is not positive"),
        (lambda: Cylinder(1.0, (0, 0), (0, 1)), r"start = .* has 2 components; give 3"),
        (lambda: Tube(1.0, 1.0, (0, 0, 0), (0, 0, 1)), r"inner = 1.0 is not below outer = 1.0"),
        (lambda: Cone(1.0, (0, 0, 0), (0, 0, 1), top=-0.5), r"top = -0.5 is negative; give a radius from 0"),
        (lambda: Torus(1.0, 1.0, (0, 0, 0), (0, 0, 1)), r"minor = 1.0 is not below major = 1.0"),
        (lambda: Torus(1.0, 0.5, (0, 0, 0), (0, 0, 0)), r"axis = .* has no length"),
        (lambda: Capsule(1.0, (0, 0), (0, 0)), r"a segment without length"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
