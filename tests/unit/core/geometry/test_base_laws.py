"""What holds for every geometry: signs, distances, nearest points, bounds, moves, sizes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rbs_core
from rbs_core import geometry as everything
from rbs_core.errors import BadInput
from rbs_core.geometry import Cropped, Everywhere, Geometry, Nowhere, Placed, Solid, Status, Surface, Where
from rbs_core.space import world
from tests.unit.core.geometry.examples import (
    EXAMPLES,
    FILLED,
    KINDS,
    MEASURING,
    STRETCHED,
    THIN,
    TURNED,
    WITH_SURFACE,
    above_parabola,
    cloud,
    measured,
)

QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=60)
# Where the distance is a bound, not the distance: joined, cropped and stretched geometries.
BOUND = ("|", "&", " - ", "^", "stretched")


def is_exact(geometry: Geometry) -> bool:
    return not any(word in repr(geometry) for word in BOUND)


def nearest_exactly(geometry: Geometry) -> bool:
    """Whether its projection leads as far as its distance says."""
    return is_exact(geometry) and not isinstance(geometry, Cropped)


def test_there_is_an_example_of_every_geometry():
    classes = {each for name in everything.__all__ if isinstance(each := getattr(everything, name), type)}
    assert {each for each in classes if issubclass(each, Geometry)} - KINDS == {Geometry, Surface, Solid}
    assert {each for each in KINDS if each.__name__ not in rbs_core.__all__} <= {
        everything.Combined, everything.Complement, Cropped, everything.Surfaces, everything.Transformed, Placed
    }  # fmt: skip


@pytest.mark.parametrize("geometry", EXAMPLES, ids=repr)
def test_repr_can_be_typed_back(geometry):
    names = vars(everything) | {"world": world, "above_parabola": above_parabola}
    again = eval(repr(geometry), names)
    assert repr(again) == repr(geometry)
    if ".placed(" not in repr(geometry):  # a system is no other one with the same numbers
        assert again == geometry
        assert hash(again) == hash(geometry)


@pytest.mark.parametrize("geometry", MEASURING, ids=repr)
def test_the_sign_of_the_distance_is_the_status_and_tells_what_is_in(geometry):
    points = cloud(geometry)
    distance, status, inside = geometry.distance(points), geometry.status(points), geometry.contains(points)
    clear = np.abs(distance) > 1e-8
    assert np.array_equal(np.sign(distance)[clear], status[clear])
    assert np.array_equal(inside[clear], status[clear] == Status.INSIDE)
    assert status.dtype == np.int8
    near = geometry.status(points, tolerance=0.1)
    wide = np.abs(distance) > 0.1 + 1e-9
    assert np.array_equal(near[wide & is_exact(geometry)], np.sign(distance)[wide & is_exact(geometry)])


@pytest.mark.parametrize("geometry", MEASURING, ids=repr)
def test_no_point_of_the_other_side_is_nearer_than_the_distance(geometry):
    points = cloud(geometry)
    distance, inside = geometry.distance(points), geometry.contains(points)
    ways = np.linalg.norm(points[:, None] - points[None], axis=2)
    nearest = np.where(inside[:, None] != inside[None], ways, np.inf).min(axis=1)
    assert (np.abs(distance) <= nearest + 1e-9).all()
    if np.isfinite(distance).all():  # no distance changes faster than the way
        assert (np.abs(distance[:, None] - distance[None]) <= ways + 1e-9).all()


@pytest.mark.parametrize("geometry", WITH_SURFACE, ids=repr)
def test_projections_are_on_the_surface_and_as_far_away_as_the_distance(geometry):
    points = cloud(geometry, count=120)
    before = points.copy()
    projection = geometry.projection(points)
    assert np.array_equal(points, before)
    ways, distance = np.linalg.norm(projection - points, axis=1), np.abs(geometry.distance(points))
    on = geometry.status(projection, tolerance=1e-7) == Status.ON
    assert on.all(), points[~on]
    assert (ways >= distance - 1e-9).all()
    if nearest_exactly(geometry):
        assert ways == pytest.approx(distance, abs=1e-9)


@pytest.mark.parametrize("geometry", EXAMPLES, ids=repr)
def test_all_points_are_within_the_bounds(geometry):
    points = cloud(geometry, count=3000)
    lower, upper = geometry.bounds
    assert lower.shape == upper.shape == (geometry.dimension or 1,)
    inside = points[geometry.contains(points)]
    assert ((inside >= lower - 1e-9) & (inside <= upper + 1e-9)).all()
    assert geometry.size >= 0.0


@pytest.mark.parametrize("geometry", [each for each in WITH_SURFACE if is_exact(each)], ids=repr)
def test_bounds_are_as_small_as_can_be(geometry):
    lower, upper = geometry.bounds
    for side, sign in ((lower, -1.0), (upper, 1.0)):
        for axis in np.flatnonzero(np.isfinite(side)):
            far = np.zeros((1, geometry.dimension))
            far[0, axis] = sign * 1e7
            reach = geometry.projection(far)[0, axis]
            if np.isfinite([lower, upper]).all():
                assert reach == pytest.approx(side[axis], abs=1e-6)


@pytest.mark.parametrize("geometry", EXAMPLES, ids=repr)
def test_other_points_than_those_of_the_dimension_are_refused(geometry):
    if geometry.dimension is not None:
        with pytest.raises(BadInput, match=r"columns?, but"):
            geometry.contains(np.zeros((2, geometry.dimension % 3 + 1)))
    assert geometry.contains(np.zeros((0, geometry.dimension or 2))).shape == (0,)


# -- moves -----------------------------------------------------------------------------------------------------------


def moves(dimension: int):
    """Functions that move a geometry, and those that move points alike, with the factor of lengths."""
    numbers = st.integers(-20, 20).map(lambda number: number / 10)
    vectors = st.lists(numbers, min_size=dimension, max_size=dimension).map(np.array)
    long = vectors.filter(np.any)
    kinds = [st.tuples(st.just("moved"), vectors), st.tuples(st.just("scaled"), st.sampled_from([0.5, 3.0]), vectors)]
    kinds.append(st.tuples(st.just("mirrored"), vectors, long))
    if dimension == 2:
        kinds.append(st.tuples(st.just("rotated"), numbers, st.none(), vectors))
    if dimension == 3:
        kinds.append(st.tuples(st.just("rotated"), numbers, long, vectors))
    return st.one_of(*kinds)


def image(points: np.ndarray, move: tuple) -> np.ndarray:
    """Points after a move, by the formulas of a textbook."""
    kind, *arguments = move
    if kind == "moved":
        return points + arguments[0]
    if kind == "scaled":
        factor, center = arguments
        return center + factor * (points - center)
    if kind == "mirrored":
        place, normal = arguments
        normal = normal / np.linalg.norm(normal)
        return points - 2.0 * ((points - place) @ normal)[:, None] * normal
    angle, axis, center = arguments
    off = points - center
    if axis is None:
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        return center + off @ turn.T
    axis = axis / np.linalg.norm(axis)  # Rodrigues
    along = (off @ axis)[:, None] * axis
    return center + along + np.cos(angle) * (off - along) + np.sin(angle) * np.cross(axis, off)


@QUIET
@given(st.data())
def test_a_moved_geometry_is_where_its_points_are(data):
    geometry = data.draw(st.sampled_from(EXAMPLES))
    dimension = geometry.dimension or 2
    move = data.draw(moves(dimension))
    moved = getattr(geometry, move[0])(*move[1:])
    points = cloud(geometry, count=150)
    images = image(points, move)
    assert moved.dimension in (None, dimension)
    if geometry in MEASURING:
        distance = geometry.distance(points)
        factor = move[1] if move[0] == "scaled" else 1.0
        assert moved.distance(images) == pytest.approx(factor * distance, abs=1e-8)
        clear = np.abs(distance) > 1e-7
        assert np.array_equal(moved.status(images)[clear], geometry.status(points)[clear])
    else:
        clear = np.full(len(points), True)
    agree = moved.contains(images) == geometry.contains(points)
    assert agree[clear].mean() > (1.0 - 1e-9 if geometry in MEASURING else 0.97)  # of a function on its border
    lower, upper = moved.bounds
    inside = images[moved.contains(images)]
    assert ((inside >= lower - 1e-9) & (inside <= upper + 1e-9)).all()


@pytest.mark.parametrize("geometry", EXAMPLES, ids=repr)
def test_quarter_turns_and_mirror_images_come_back(geometry):
    dimension = geometry.dimension or 2
    points = cloud(geometry)
    back = geometry.mirrored(np.full(dimension, 0.5), np.eye(dimension)[0])
    back = back.mirrored(np.full(dimension, 0.5), np.eye(dimension)[0])
    if dimension > 1:
        axis = (0.0, 0.0, 1.0) if dimension == 3 else None
        for _ in range(4):
            back = back.rotated(np.pi / 2, axis)
    agree = back.contains(points) == geometry.contains(points)
    clear = np.abs(geometry.distance(points)) > 1e-9 if geometry in MEASURING else np.full(len(points), True)
    assert agree[clear].all()


@pytest.mark.parametrize("system", [STRETCHED, TURNED], ids=lambda system: system.name)
@pytest.mark.parametrize("geometry", EXAMPLES, ids=repr)
def test_a_placed_geometry_is_where_its_system_is(geometry, system):
    if geometry.dimension != 2:
        system = world.child("tilted", (0.1, 0.0, 0.2), [(0.6, 0.0, 0.8), (0.0, 2.0, 0.0), (-0.8, 0.0, 0.6)])
    if geometry.dimension == 1:
        system = world.child("shifted", (0.5, 0.0, 0.0), [(2.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
    if geometry.dimension is None:
        system = TURNED
    placed = geometry.placed(system)
    points = cloud(geometry)
    images = system.to_parent(points)
    clear = np.abs(geometry.distance(points)) > 1e-8 if geometry in MEASURING else np.full(len(points), True)
    agree = placed.contains(images) == geometry.contains(points)
    assert agree[clear].mean() > (1.0 - 1e-9 if geometry in MEASURING else 0.97)  # of a function on its border
    lower, upper = placed.bounds
    inside = images[placed.contains(images)]
    assert ((inside >= lower - 1e-9) & (inside <= upper + 1e-9)).all()


# -- sizes -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("geometry", "exact"), FILLED, ids=lambda value: repr(value)[:60])
def test_measured_size_converges_to_the_exact_one(geometry, exact):
    spacings = {1: (0.02, 0.002), 2: (0.04, 0.008), 3: (0.09, 0.03)}[geometry.dimension]
    coarse, fine = (abs(measured(geometry, spacing) / exact - 1.0) for spacing in spacings)
    assert coarse < 1.2 * spacings[0] * geometry.dimension
    assert fine < (1.4 if geometry.dimension == 1 else 0.8) * spacings[1] * geometry.dimension


@pytest.mark.parametrize("geometry", [each for each in THIN if each.dimension > 1], ids=repr)
def test_thin_shapes_have_no_inside(geometry):
    points = cloud(geometry)
    assert (geometry.distance(points) >= 0.0).all()
    assert (geometry.status(points) >= 0).all()


def test_whole_space_and_nothing_have_no_surface():
    for geometry in (Everywhere(), Nowhere()):
        with pytest.raises(BadInput, match="has no surface to project on"):
            geometry.projection([[0.0, 0.0]])
    with pytest.raises(BadInput, match="knows no distance"):
        Where(above_parabola).projection([[0.0, 0.0]])
