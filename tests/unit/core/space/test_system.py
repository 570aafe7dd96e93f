"""The tree of coordinate systems."""

from __future__ import annotations

import gc

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import Ball, Box
from rbs_core.part import Part
from rbs_core.space import Cartesian, CoordinateSystem, Mapping, convert, world


def turned(angle: float) -> list[tuple[float, float]]:
    return [(np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))]


def test_tree_knows_names_depths_and_paths():
    plate = world.child("plate")
    hole = plate.child("hole", (0.1, 0.2))
    assert (world.path, plate.path, hole.path) == ("world", "world/plate", "world/plate/hole")
    assert (world.depth, plate.depth, hole.depth) == (0, 1, 2)
    assert hole.parent is plate
    assert plate.children == (hole,)
    assert plate in world.children


def test_parents_do_not_keep_children_alive_but_children_keep_parents():
    before = world.children
    leaf = world.child("kept").child("leaf")
    gc.collect()
    assert [system.name for system in world.children if system not in before] == ["kept"]
    del leaf
    gc.collect()
    assert world.children == before


def test_repr_can_be_typed_back():
    system = world.child("plate", (1.0, 2.0), turned(0.5)).child("hole", 3.0)
    again = eval(repr(system))
    assert repr(again) == repr(system)
    assert repr(world) == "world"
    assert repr(CoordinateSystem("moon")) == "CoordinateSystem('moon')"
    assert np.array_equal(convert([1.0, 2.0, 3.0], again, world), convert([1.0, 2.0, 3.0], system, world))


def test_repr_of_every_kind_can_be_typed_back():
    pipe = world.cylindrical("pipe", (1.0, 2.0), turned(0.5))
    globe = pipe.child("wall", (1.0, 0.0)).spherical("globe", (0.0, 0.0, 3.0))
    assert eval(repr(globe)).path == "world/pipe/wall/globe"
    assert repr(eval(repr(globe))) == repr(globe)
    assert repr(world.spherical("globe")) == "world.spherical('globe', origin=(0.0, 0.0, 0.0))"


def test_to_parent_and_from_parent():
    plate = world.child("plate", (1.0, 2.0), turned(np.pi / 2))
    assert np.allclose(plate.to_parent([[1.0, 0.0]]), [[1.0, 3.0]], atol=1e-15)
    assert np.allclose(plate.from_parent([1.0, 3.0]), [1.0, 0.0], atol=1e-15)


def test_moving_a_system_moves_all_below_it():
    arm = world.child("arm")
    hand = arm.child("hand", (1.0, 0.0))
    arm.mapping = Cartesian((0.0, 5.0), turned(np.pi))
    assert np.allclose(convert([0.0, 0.0], hand, world), [-1.0, 5.0])
    with pytest.raises(BadInput, match="'world' is a root: it has no parent and cannot be moved"):
        world.mapping = Cartesian()


def test_translate_and_rotate():
    arm = world.child("arm", (1.0, 0.0))
    arm.translate((0.0, 2.0))
    assert arm.mapping.origin.tolist() == [1.0, 2.0, 0.0]
    arm.rotate(np.pi / 2)
    assert np.allclose(convert([1.0, 0.0], arm, world), [1.0, 3.0])
    arm.rotate(np.pi / 2, center=(0.0, 0.0))
    assert np.allclose(convert([0.0, 0.0], arm, world), [-2.0, 1.0])
    assert np.allclose(convert([1.0, 0.0], arm, world), [-3.0, 1.0])
    arm.rotate(np.pi, axis=(5.0, 0.0, 0.0), center=(0.0, 1.0, 0.0))
    assert np.allclose(convert([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]], arm, world), [[-2, 1, 0], [-2, 1, -1]])


def test_motion_is_in_coordinates_of_the_parent():
    arm = world.child("arm", (10.0, 0.0), turned(np.pi / 2))
    hand = arm.child("hand", (1.0, 0.0))
    hand.translate((2.0, 0.0))
    assert np.allclose(convert([0.0, 0.0], hand, world), [10.0, 3.0])


def test_a_shift_moves_by_what_is_added():
    cart = world.child("cart", axes=[(2.0, 0.0), (0.5, 1.0)])
    for _ in range(8):
        cart.translate((0.125, 0.0, 0.25))
    assert cart.mapping.origin.tolist() == [1.0, 0.0, 2.0]
    assert np.array_equal(cart.mapping.axes, [[2.0, 0, 0], [0.5, 1, 0], [0, 0, 1]])


@pytest.mark.parametrize("axes", [np.eye(3), [(2.0, 0.0, 0.0), (0.3, 1.0, 0.0), (0.0, 0.1, 0.01)]])
def test_many_rotations_keep_the_shape_of_the_axes(axes):
    """Plain products would drift by 2e-17 to 1e-16 in each step, always to the same side."""
    wheel = world.child("wheel", (1.0, 2.0, 3.0), axes)
    before = wheel.mapping.axes @ wheel.mapping.axes.T
    for _ in range(20_000):
        wheel.rotate(0.1, axis=(1.0, 2.0, 3.0))
    after = wheel.mapping.axes @ wheel.mapping.axes.T
    assert np.abs(after - before).max() < 5e-15
    assert wheel.mapping.origin.tolist() == [1.0, 2.0, 3.0]
    turned_at_once = Cartesian((1.0, 2.0, 3.0), axes).rotated(20_000 * 0.1, (1.0, 2.0, 3.0))
    assert np.abs(wheel.mapping.axes - turned_at_once.axes).max() < 1e-11  # 20,000 times the round-off of an angle


def test_parts_and_geometries_follow_their_system():
    cart = world.child("cart", (1.0, 0.0))
    part = Part("p", Box(size=(2.0, 1.0)), system=cart).discretize(0.5).connect(0.5)
    disk, lengths = Ball(0.5, (1.0, 0.0)).placed(cart), part.bonds.lengths
    start = convert(part.positions, part.system, world)
    first = cart.mapping
    for time in (0.5, 1.0, 1.5):
        cart.mapping = first.rotated(0.7 * time, center=(0.0, 0.0)).translated((0.0, 2.0 * time))
        angle = 0.7 * time
        cosine, sine = np.cos(angle), np.sin(angle)
        expected = start @ [[cosine, sine], [-sine, cosine]] + [0.0, 2.0 * time]
        assert np.allclose(convert(part.positions, part.system, world), expected, atol=1e-14)
        center = np.array([2.0 * cosine, 2.0 * sine + 2.0 * time])
        assert disk.contains(center + np.array([[0.49, 0.0], [0.0, 0.51]])).tolist() == [True, False]
        assert np.allclose(disk.bounds, [center - 0.5, center + 0.5], atol=1e-14)
    assert np.array_equal(part.bonds.lengths, lengths)


def test_curved_systems_move_with_what_is_below_them():
    turret = world.cylindrical("turret", (5.0, 0.0))
    barrel = turret.child("barrel", (2.0, 0.0))
    turret.rotate(np.pi / 2)
    assert np.allclose(convert([0.0, 0.0], barrel, world), [5.0, 2.0])
    turret.translate((-5.0, 0.0))
    assert np.allclose(convert([0.0, 0.0], barrel, world), [0.0, 2.0])


def test_other_kinds_of_coordinates_are_just_other_mappings():
    class Bent(Mapping):
        """z -> z + x^2, and back."""

        def to_parent(self, points):
            return points + points[:, :1] ** 2 * [0.0, 0.0, 1.0]

        def from_parent(self, points):
            return points - points[:, :1] ** 2 * [0.0, 0.0, 1.0]

        def __repr__(self):
            return "Bent()"

    bent = world.mapped("bent", Bent())
    assert bent.to_parent([2.0, 0.0, 1.0]).tolist() == [2.0, 0.0, 5.0]
    assert bent.from_parent([2.0, 0.0, 5.0]).tolist() == [2.0, 0.0, 1.0]
    assert repr(bent) == "world.mapped('bent', Bent())"
    assert np.isinf(bent.mapping.bounds_to_parent(np.zeros(3), np.ones(3))).all()
    assert bent.mapping.least_stretch(3) == 0.0


class Fixed(Mapping):
    def to_parent(self, points):
        return points.copy()

    from_parent = to_parent


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: world.to_parent([0.0]), r"'world' is a root: it has no parent and cannot be moved; use a child"),
        (lambda: world.translate((1.0, 0.0)), r"'world' is a root: it has no parent and cannot be moved"),
        (lambda: world.rotate(0.1), r"'world' is a root"),
        (lambda: world.child("a").rotate(0.1, axis=(0, 0, 0)), r"axis = .* has no length; give a vector of any other"),
        (lambda: world.child("a").translate((1, np.nan)), r"vector\[1\] = nan is not finite"),
        (lambda: setattr(world.child("a"), "mapping", 3), r"mapping = 3 of 'world/a' is no Mapping; give one such as"),
        (
            lambda: world.mapped("a", Fixed()).rotate(0.1),
            r"Fixed\(\) cannot be moved by itself: assign another",
        ),
        (lambda: world.mapped("a", Fixed()).translate(1.0), r"Fixed\(\) cannot be moved by itself"),
        (lambda: world.cylindrical("a", axes=[(1, 0), (0, 0)]), r"axes\[1\] = .* has no length"),
        (lambda: world.spherical("a/b"), r"name 'a/b' cannot stand in a path"),
        (lambda: world.child(""), r"name '' cannot stand in a path"),
        (lambda: world.child("a/b"), r"name 'a/b' cannot stand in a path; give a text .* no '/'"),
        (lambda: CoordinateSystem("lost", world), r"'lost' needs both a parent and a mapping.*parent.child\('lost'\)"),
        (lambda: world.child("bad", (1, 2, 3, 4)), r"origin has shape \(4,\)"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
