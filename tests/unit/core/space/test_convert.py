"""Points and vectors between any two systems, of any kind, at any depth."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rbs_core.space
from rbs_core.errors import BadInput
from rbs_core.space import Cartesian, CoordinateSystem, Mapping, convert, convert_vectors, world
from tests.unit.core.space.trees import KINDS, branch

QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=200)
LINES = st.lists(st.sampled_from(KINDS), min_size=1, max_size=5)
SEEDS = st.integers(0, 2**32 - 1)
PI = np.pi


def turned(angle: float) -> list[tuple[float, float]]:
    return [(np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))]


def two_branches(above: list[str], a_kinds: list[str], b_kinds: list[str], seed: int):
    """Two lines of systems below a third one, and the same points in coordinates of all."""
    rng = np.random.default_rng(seed)
    shared, cloud = branch(world, rng.uniform(-0.3, 0.3, (20, 3)), above, rng, "s")
    a, in_a = branch(shared, cloud, a_kinds, rng, "a")
    b, in_b = branch(shared, cloud, b_kinds, rng, "b")
    return (shared, a, b), (cloud, in_a, in_b), rng


# -- points ---------------------------------------------------------------------------------------------------------


@QUIET
@given(LINES, LINES, SEEDS)
def test_points_there_and_back_between_two_branches_of_all_kinds(a_kinds, b_kinds, seed):
    (_, a, b), (_, in_a, in_b), _ = two_branches([], a_kinds, b_kinds, seed)
    size = 1.0 + np.abs(in_a).max() + np.abs(in_b).max()
    assert np.abs(convert(in_a, a, b) - in_b).max() < 1e-12 * size
    assert np.abs(convert(convert(in_a, a, b), b, a) - in_a).max() < 1e-12 * size
    assert np.array_equal(convert(convert(in_a, a, world), world, b), convert(in_a, a, b))


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


def test_a_plane_has_polar_coordinates():
    polar = world.cylindrical("polar", (1.0, 0.0))
    assert np.allclose(convert([[2.0, PI / 2], [1.0, PI]], polar, world), [[1.0, 2.0], [0.0, 0.0]], atol=1e-15)
    assert np.allclose(convert([1.0, 3.0], world, polar), [3.0, PI / 2])
    assert convert([3.0], world, polar).tolist() == [2.0]
    with pytest.raises(BadInput, match=r"world to world/polar: points\[0\] gets y = 3.14159 and leaves 1 dimension;"):
        convert([[-3.0]], world, polar)


# -- vectors --------------------------------------------------------------------------------------------------------


@QUIET
@given(st.lists(st.sampled_from(KINDS), max_size=2), LINES, LINES, SEEDS)
def test_vectors_there_and_back_between_two_branches_of_all_kinds(above, a_kinds, b_kinds, seed):
    (_, a, b), (_, in_a, in_b), rng = two_branches(above, a_kinds, b_kinds, seed)
    vectors = rng.uniform(-1.0, 1.0, in_a.shape)
    over = convert_vectors(vectors, in_a, a, b)
    assert np.abs(convert_vectors(over, in_b, b, a) - vectors).max() < 1e-12 * (1.0 + np.abs(over).max())
    # components of the same arrow in the world, whichever way they took
    size = 1.0 + np.abs(over).max() + np.abs(in_b).max()
    up = convert_vectors(vectors, in_a, a, world)
    assert np.abs(up - convert_vectors(over, in_b, b, world)).max() < 1e-11 * size * (1.0 + np.abs(up).max())


def lengths_per_unit(kind: str, points: np.ndarray) -> np.ndarray:
    """How long the way along a unit of each coordinate is, in basis vectors: written down anew for the test."""
    ones = np.ones(len(points))
    r, polar = points[:, 0], points[:, 1]
    table = {"cylindrical": (ones, r, ones), "spherical": (ones, r, r * np.sin(polar))}
    return np.column_stack(table.get(kind, (ones, ones, ones)))


@QUIET
@given(LINES, SEEDS)
def test_a_vector_is_where_points_go(kinds, seed):
    """The velocity of moving points, from differences of their places in the world."""
    rng = np.random.default_rng(seed)
    system, cloud = branch(world, rng.uniform(-0.3, 0.3, (10, 3)), kinds, rng, "a")
    velocity, time = rng.uniform(-1.0, 1.0, cloud.shape), 1e-5
    step = velocity / lengths_per_unit(kinds[-1], cloud) * time
    places = [convert(cloud + sign * step, system, world) for sign in (-1, 1)]
    expected = (places[1] - places[0]) / (2 * time)
    found = convert_vectors(velocity, cloud, system, world)
    # round-off 1e-16 / time, and the second order of the differences
    assert np.abs(found - expected).max() < 1e-8 * (1.0 + np.abs(found).max())


@QUIET
@given(st.sampled_from(["cylindrical", "spherical"]), SEEDS)
def test_unit_vectors_keep_lengths_and_work(kind, seed):
    rng = np.random.default_rng(seed)
    system, cloud = branch(world, rng.uniform(-1.0, 1.0, (10, 3)), [kind], rng, "a")
    force, way = rng.normal(size=(2, 10, 3))
    there = [convert_vectors(vectors, cloud, system, world) for vectors in (force, way)]
    assert np.allclose((there[0] * there[1]).sum(axis=1), (force * way).sum(axis=1), rtol=0, atol=1e-13)


def test_vectors_of_a_circle():
    polar = world.cylindrical("polar", (1.0, 0.0))
    hoop = convert_vectors([[0.0, 2.0], [0.0, 2.0]], [[3.0, 0.0], [3.0, PI / 2]], polar, world)
    assert np.allclose(hoop, [[0.0, 2.0], [-2.0, 0.0]], atol=1e-15)
    assert np.allclose(convert_vectors([0.0, 5.0], [1.0, 4.0], world, polar), [5.0, 0.0], atol=1e-15)


def test_cartesian_components_belong_to_axes_of_any_length():
    system = world.child("stretched", (9.0, 9.0, 9.0), [(2.0, 0.0, 0.0), (0.0, 4.0, 0.0), (0.0, 0.0, 0.5)])
    assert convert_vectors([1.0, 1.0, 1.0], [0.0, 0.0, 0.0], system, world).tolist() == [2.0, 4.0, 0.5]
    flat = world.child("flat", 9.0, [(2.0, 0.0), (0.0, 4.0)])
    assert convert_vectors([[2.0, 2.0]], [[7.0, 8.0]], world, flat).tolist() == [[1.0, 0.5]]


def test_on_an_axis_the_basis_is_that_of_the_frame():
    pipe, globe = world.cylindrical("pipe"), world.spherical("globe")
    vector = [1.0, 2.0, 3.0]
    for place in ([0.0, 0.0, 0.0], [0.0, 0.0, 5.0]):
        assert convert_vectors(vector, place, world, pipe).tolist() == vector
        assert np.allclose(convert_vectors(vector, place, world, globe), [3.0, 1.0, 2.0])  # r up, theta along x
    assert np.allclose(convert_vectors(vector, [0.0, 0.0, -5.0], world, globe), [-3.0, -1.0, 2.0], atol=1e-15)
    assert np.allclose(convert_vectors(vector, [0.0, PI / 2, 0.0], pipe, world), [-2.0, 1.0, 3.0])  # phi of the point


def test_on_an_axis_a_child_of_curved_coordinates_has_no_basis():
    wall = world.cylindrical("pipe").child("wall", (1.0, 0.0, 0.0))
    assert np.allclose(convert_vectors([0.0, 6.0, 0.0], [2.0, 0.0, 0.0], world, wall), [0.0, 3.0, 0.0])  # 6 m/s / 2 m
    with pytest.raises(
        BadInput,
        match=r"world/pipe/wall has no basis at \(-1.0, 0.0, 4.0\) \(points\[1\]\), where a coordinate of "
        r"world/pipe or of itself leads nowhere; leave points on such an axis",
    ):
        convert_vectors(np.ones((2, 3)), [[2.0, 0.0, 0.0], [0.0, 0.0, 4.0]], world, wall)


def test_flat_vectors_may_leave_their_plane_by_round_off_only():
    tilted = world.child("tilted", axes=[(1.0, 0.0, 0.0), (0.0, 0.8, 0.6)])
    with pytest.raises(BadInput, match=r"world/tilted to world: vectors\[0\] gets z = 0.6 and leaves 2 dimensions"):
        convert_vectors([0.0, 1.0], [0.0, 0.0], tilted, world)
    with pytest.raises(BadInput, match=r"points\[0\] gets z = 0.6 and leaves 2 dimensions"):
        convert_vectors([1.0, 0.0], [0.0, 1.0], tilted, world)


@pytest.mark.parametrize("shape", [(1,), (2,), (3,), (5, 1), (5, 2), (5, 3), (0, 2)])
def test_shapes_of_vectors_are_kept(shape):
    system = world.child("shifted", (3.0,), [(2.0, 0.0), (0.0, 1.0)])
    result = convert_vectors(np.ones(shape), np.zeros(shape), system, world)
    assert result.shape == shape
    assert np.all(result[..., 0] == 2.0)


def test_vectors_of_the_same_system_are_copied():
    vectors = np.ones((3, 2))
    result = convert_vectors(vectors, np.zeros((3, 2)), world, world)
    assert np.array_equal(result, vectors)
    assert not np.shares_memory(result, vectors)


def test_the_function_is_what_the_package_exports():
    assert rbs_core.space.convert is convert
    assert callable(convert)


class Bare(Mapping):
    def to_parent(self, points):
        return points.copy()

    from_parent = to_parent


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
        (lambda: convert([-1.0, 0.0], world.cylindrical("a"), world), r"points\[0\] = .* has a negative radius"),
        (
            lambda: convert_vectors([0.0, 1.0], [0.0], world, world),
            r"vectors has shape \(2,\), points has \(1,\); give one point per vector",
        ),
        (
            lambda: convert_vectors(np.zeros((2, 4)), np.zeros((2, 4)), world, world),
            r"vectors has shape \(2, 4\); give",
        ),
        (lambda: convert_vectors([np.nan], [0.0], world, world), r"vectors\[0\] = nan is not finite"),
        (lambda: convert_vectors([0.0], [0.0], world, CoordinateSystem("moon")), r"belong to different trees"),
        (
            lambda: convert_vectors([0.0], [0.0], world.mapped("bare", Bare()), world),
            r"Bare\(\) has no basis, so that vectors have no components: give its class a method basis",
        ),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
