"""The tree of coordinate systems."""

from __future__ import annotations

import gc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rbs_core.space
from rbs_core.errors import BadInput
from rbs_core.space import Cartesian, CoordinateSystem, Mapping, convert, world

QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=50)


def turned(angle: float) -> list[tuple[float, float]]:
    return [(np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))]


def branch(rng: np.random.Generator, depth: int, name: str) -> CoordinateSystem:
    """A line of `depth` systems below the world: shifted, turned, stretched and sheared at random."""
    system = world
    for level in range(depth):
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0] * rng.uniform(0.5, 2.0, (3, 1)) + rng.uniform(-0.1, 0.1, (3, 3))
        system = system.child(f"{name}{level}", rng.uniform(-1.0, 1.0, 3), axes)
    return system


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


@QUIET
@given(st.integers(0, 2**32 - 1), st.integers(1, 5), st.integers(1, 5))
def test_round_trip_between_two_branches(seed, a_depth, b_depth):
    rng = np.random.default_rng(seed)
    a, b = branch(rng, a_depth, "a"), branch(rng, b_depth, "b")
    points = rng.uniform(-1.0, 1.0, (20, 3))
    assert np.abs(convert(convert(points, a, b), b, a) - points).max() < 1e-11
    assert np.allclose(convert(points, a, b), convert(convert(points, a, world), world, b), rtol=1e-11, atol=1e-11)


def test_round_trip_at_depth_five_of_rotations_is_exact_to_round_off():
    system = world
    for level in range(5):
        system = system.child(f"level{level}", (0.1, -0.2, 0.3), [*turned(0.3 + level)])
    points = np.random.default_rng(3).uniform(-1.0, 1.0, (1000, 3))
    assert np.abs(convert(convert(points, system, world), world, system) - points).max() < 1e-14


def test_conversion_passes_the_lowest_common_ancestor_only():
    class Forbidden(Cartesian):
        def to_parent(self, points):
            raise AssertionError("went above the common ancestor")

        from_parent = to_parent

    plate = world.mapped("plate", Forbidden())
    left, right = plate.child("left", -1.0), plate.child("right", +1.0)
    assert convert([0.0, 0.0, 0.0], left, right).tolist() == [-2.0, 0.0, 0.0]
    assert convert([0.0], left.child("tip", 0.5), left).tolist() == [0.5]
    assert convert([0.0], left, left.child("tip", 0.5)).tolist() == [-0.5]


def test_to_parent_and_from_parent():
    plate = world.child("plate", (1.0, 2.0), turned(np.pi / 2))
    assert np.allclose(plate.to_parent([[1.0, 0.0]]), [[1.0, 3.0]], atol=1e-15)
    assert np.allclose(plate.from_parent([1.0, 3.0]), [1.0, 0.0], atol=1e-15)


@pytest.mark.parametrize("shape", [(1,), (2,), (3,), (5, 1), (5, 2), (5, 3), (0, 2)])
def test_shapes_are_kept(shape):
    system = world.child("shifted", (3.0,))
    points = np.zeros(shape)
    result = convert(points, system, world)
    assert result.shape == shape
    assert np.all(result[..., 0] == 3.0)


def test_same_system_gives_a_copy():
    points = np.ones((3, 2))
    result = convert(points, world, world)
    assert np.array_equal(result, points)
    assert not np.shares_memory(result, points)


def test_flat_points_may_leave_their_plane_by_round_off_only():
    tilted = world.child("tilted", axes=[(1.0, 0.0, 0.0), (0.0, 0.8, 0.6)])
    points = np.array([[5.0, 0.0], [1.0, 2.0]])
    with pytest.raises(
        BadInput, match=r"world/tilted to world: points\[1\] gets z = 1.2 and leaves 2 dimensions; give 3-D"
    ):
        convert(points, tilted, world)
    assert np.allclose(convert([[1.0, 2.0, 0.0]], tilted, world), [[1.0, 1.6, 1.2]])
    lifted = world.child("lifted", (0.0, 0.0, 0.1 + 0.2)).child("lowered", (0.0, 0.0, -0.3))
    assert np.array_equal(convert(points, lifted, world), points)


def test_round_off_is_judged_by_the_largest_coordinate_on_the_way():
    far = world.child("far", (0.0, 0.0, 1e6)).child("near", (0.0, 0.0, 0.1)).child("back", (0.0, 0.0, -1e6))
    home = world.child("home", (0.0, 0.0, 0.1))
    assert convert([1e-3, 1e-3], far, home).tolist() == [1e-3, 1e-3]


def test_moving_a_system_moves_all_below_it():
    arm = world.child("arm")
    hand = arm.child("hand", (1.0, 0.0))
    arm.mapping = Cartesian((0.0, 5.0), turned(np.pi))
    assert np.allclose(convert([0.0, 0.0], hand, world), [-1.0, 5.0])
    with pytest.raises(BadInput, match="'world' is a root: it has no parent and cannot be moved"):
        world.mapping = Cartesian()


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


def test_the_function_is_what_the_package_exports():
    assert rbs_core.space.convert is convert
    assert callable(convert)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: convert([0.0], world, CoordinateSystem("moon")), r"'world' and 'moon' belong to different trees"),
        (
            lambda: convert([0.0], CoordinateSystem("moon").child("sea"), world),
            r"'moon/sea' and 'world' belong to different",
        ),
        (lambda: convert(np.zeros((2, 4)), world, world), r"points has shape \(2, 4\); give \(n, d\)"),
        (lambda: convert([0.0], "world", world), r"source = 'world' is no CoordinateSystem; give world"),
        (lambda: convert(0.0, world, world), r"points has shape \(\)"),
        (lambda: convert([[0.0, np.inf]], world, world), r"points\[0, 1\] = inf is not finite"),
        (lambda: world.to_parent([0.0]), r"'world' is a root: it has no parent and cannot be moved; use a child"),
        (lambda: world.child(""), r"name '' cannot stand in a path"),
        (lambda: world.child("a/b"), r"name 'a/b' cannot stand in a path; give a text .* no '/'"),
        (lambda: CoordinateSystem("lost", world), r"'lost' needs both a parent and a mapping.*parent.child\('lost'\)"),
        (lambda: world.child("bad", (1, 2, 3, 4)), r"origin has shape \(4,\)"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
