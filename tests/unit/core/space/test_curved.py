"""Cylindrical and spherical coordinates: known points, singular places, boxes around boxes, volumes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rbs_core.errors import BadInput
from rbs_core.space import Cylindrical, Spherical
from rbs_core.space.bases import rotation
from rbs_core.space.curved import cosine_range

QUIET = settings(derandomize=True, deadline=None, database=None, max_examples=100)
PI = np.pi
KINDS = {"cylindrical": Cylindrical, "spherical": Spherical}


def inside(mapping, count: int, rng: np.random.Generator) -> np.ndarray:
    """Own coordinates all over the range that comes back."""
    if isinstance(mapping, Cylindrical):
        return rng.uniform([0.01, -PI, -2.0], [3.0, PI, 2.0], (count, 3))
    return rng.uniform([0.01, 0.01, -PI], [3.0, PI - 0.01, PI], (count, 3))


def test_cylindrical_coordinates_of_known_points():
    own = np.array([[2.0, 0.0, 5.0], [2.0, PI / 2, 5.0], [2.0, PI, 5.0], [2.0, -PI / 2, -1.0], [2.0, PI / 6, 0.0]])
    straight = [[2, 0, 5], [0, 2, 5], [-2, 0, 5], [0, -2, -1], [np.sqrt(3), 1, 0]]
    mapping = Cylindrical()
    assert np.allclose(mapping.to_parent(own), straight, atol=1e-15)
    assert np.allclose(mapping.from_parent(np.array(straight, float)), own, atol=1e-15)


def test_spherical_coordinates_of_known_points():
    own = np.array([[2.0, PI / 2, 0.0], [2.0, PI / 2, PI / 2], [3.0, PI / 4, PI], [2.0, PI / 2, -PI / 2]])
    straight = [[2, 0, 0], [0, 2, 0], [-3 * np.sqrt(0.5), 0, 3 * np.sqrt(0.5)], [0, -2, 0]]
    mapping = Spherical()
    assert np.allclose(mapping.to_parent(own), straight, atol=1e-15)
    assert np.allclose(mapping.from_parent(np.array(straight, float)), own, atol=1e-15)


@QUIET
@given(st.sampled_from(list(KINDS)), st.integers(0, 2**32 - 1))
def test_there_and_back(kind, seed):
    rng = np.random.default_rng(seed)
    mapping = KINDS[kind](
        rng.uniform(-1, 1, 3), rotation(*rng.normal(size=1), rng.normal(size=3)) * rng.uniform(0.5, 2)
    )
    own = inside(mapping, 20, rng)
    # near the axis the round-off of the origin, 1e-16, turns by up to 1e-16 / 0.01
    assert np.allclose(mapping.from_parent(mapping.to_parent(own)), own, rtol=1e-12, atol=1e-13)
    points = rng.uniform(-2.0, 2.0, (20, 3))
    assert np.allclose(mapping.to_parent(mapping.from_parent(points)), points, rtol=0, atol=1e-14)


@pytest.mark.parametrize("zero", [0.0, -0.0])
def test_angles_are_zero_where_they_are_undetermined(zero):
    points = np.array([[zero, zero, zero], [zero, zero, 2.0], [zero, zero, -2.0]])
    assert np.array_equal(Cylindrical().from_parent(points), [[0, 0, 0], [0, 0, 2], [0, 0, -2]])
    assert np.array_equal(Spherical().from_parent(points), [[0, 0, 0], [2, 0, 0], [2, PI, 0]])


def test_the_seam_belongs_to_plus_pi():
    points = np.array([[-1.0, 0.0, 0.0], [-1.0, -0.0, 0.0]])
    assert Cylindrical().from_parent(points)[:, 1].tolist() == [PI, PI]
    assert Spherical().from_parent(points)[:, 2].tolist() == [PI, PI]
    far = Cylindrical().to_parent(np.array([[1.0, 7 * PI, 0.0]]))  # any number of turns
    assert np.allclose(far, [[-1, 0, 0]], atol=1e-14)


@pytest.mark.parametrize("kind", KINDS)
def test_the_basis_is_unit_vectors_along_the_coordinate_lines(kind, rng):
    mapping = KINDS[kind]((0.3, 0.2, 0.1), rotation(1.0, (1, 2, 3)))
    own = inside(mapping, 30, rng)
    basis, step = mapping.basis(own), 1e-6
    assert np.allclose(basis @ np.swapaxes(basis, 1, 2), np.eye(3), atol=1e-15)
    assert np.allclose(np.linalg.det(basis), 1.0, rtol=1e-14)  # r, phi, z and r, theta, phi turn to the right
    for k in range(3):
        shift = step * np.eye(3)[k]
        lines = (mapping.to_parent(own + shift) - mapping.to_parent(own - shift)) / (2 * step)
        # differences are good to step^2 and to 1e-16 / step
        assert np.allclose(lines, basis[:, k] * mapping.scales(own)[:, k : k + 1], atol=1e-9)


def test_stretched_axes_make_ellipses():
    mapping = Cylindrical(axes=[(3.0, 0.0), (0.0, 2.0)])
    assert np.allclose(mapping.to_parent(np.array([[1.0, 0.0, 0.0], [1.0, PI / 2, 0.0]])), [[3, 0, 0], [0, 2, 0]])
    assert np.allclose(mapping.basis(np.array([[1.0, 0.0, 0.0]])), [np.diag([3.0, 2.0, 1.0])])


@pytest.mark.parametrize(
    ("start", "stop"), [(0.3, 0.4), (-0.1, 0.1), (3.0, 3.3), (0.0, 2 * PI), (-10.0, 50.0), (5.0, 9.0), (-4.0, -3.0)]
)
def test_range_of_cosines(start, stop):
    values = np.cos(np.linspace(start, stop, 200_001))
    least, most = cosine_range(start, stop)
    assert least <= values.min() + 1e-15 <= least + 1e-8
    assert most >= values.max() - 1e-15 >= most - 1e-8


@QUIET
@given(st.sampled_from(list(KINDS)), st.integers(0, 2**32 - 1), st.booleans())
def test_bounds_are_sharp(kind, seed, stretched):
    """The box touches the images of a fine mesh of the box on all sides, and holds all of them."""
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    axes = axes * rng.uniform(0.3, 3.0, (3, 1)) + rng.uniform(-0.1, 0.1, (3, 3)) if stretched else axes
    mapping = KINDS[kind](rng.uniform(-1, 1, 3), axes)
    lower, upper = np.sort(rng.uniform(0.0, 1.0, (2, 3)), axis=0) * ([3, 7, 2] if kind == "cylindrical" else [3, PI, 7])
    mesh = np.stack(np.meshgrid(*[np.linspace(a, b, 41) for a, b in zip(lower, upper, strict=True)], indexing="ij"), -1)
    image = mapping.to_parent(mesh.reshape(-1, 3))
    least, most = mapping.bounds_to_parent(lower, upper)
    assert (image >= least - 1e-14).all()
    assert (image <= most + 1e-14).all()
    # between two of 41 places a cosine misses its crest by (7/40)^2/8 at most
    assert np.allclose(image.min(axis=0), least, atol=0.004 * 3 * 4)
    assert np.allclose(image.max(axis=0), most, atol=0.004 * 3 * 4)


def test_bounds_of_the_infinite_and_the_impossible():
    mapping = Cylindrical((1.0, 0.0, 0.0))
    bar = mapping.bounds_to_parent(np.array([0.0, 0.0, -np.inf]), np.array([2.0, 2 * PI, np.inf]))
    assert np.array_equal(bar, [[-1.0, -2.0, -np.inf], [3.0, 2.0, np.inf]])
    any_angle = mapping.bounds_to_parent(np.array([0.0, -np.inf, 0.0]), np.array([2.0, np.inf, 0.0]))
    assert np.array_equal(any_angle, [[-1.0, -2.0, 0.0], [3.0, 2.0, 0.0]])
    nothing = mapping.bounds_to_parent(np.array([-2.0, 0.0, 0.0]), np.array([-1.0, 1.0, 1.0]))
    assert np.array_equal(nothing, [[np.inf] * 3, [-np.inf] * 3])
    cone = Spherical().bounds_to_parent(np.array([0.0, 0.0, -PI]), np.array([np.inf, 0.1, PI]))
    assert np.array_equal(cone, [[-np.inf, -np.inf, 0.0], [np.inf] * 3])
    clipped = Spherical().bounds_to_parent(np.array([-5.0, -1.0, -np.inf]), np.array([2.0, 9.0, np.inf]))
    assert np.allclose(clipped, [[-2.0] * 3, [2.0] * 3], rtol=1e-15)
    beyond = Spherical().bounds_to_parent(np.array([0.0, 4.0, 0.0]), np.array([2.0, 5.0, 1.0]))
    assert np.array_equal(beyond, [[np.inf] * 3, [-np.inf] * 3])


def test_near_turns_angles_by_whole_turns():
    points = np.array([[1.0, -3.0, 0.0], [1.0, 3.0, 0.0], [1.0, 0.1, 0.0]])
    wound = Cylindrical().near(points, np.array([0.0, PI, 0.0]))
    assert np.allclose(wound[:, 1], [2 * PI - 3.0, 3.0, 0.1])
    assert np.array_equal(Spherical().near(points, np.zeros(3)), points)
    assert np.array_equal(Cylindrical().near(points, np.full(3, np.nan)), points)
    assert np.array_equal(Cylindrical().near(points[:, :1], np.zeros(1)), points[:, :1])


def test_cell_volumes_by_their_closed_forms():
    cells = np.array([[1.0, 0.0, 0.0]]), np.array([[2.0, PI / 2, 3.0]])
    assert Cylindrical().cell_volumes(*cells) == pytest.approx(PI / 4 * 3 * 3, rel=1e-15)
    assert Cylindrical(axes=[(2, 0, 0), (0, 1, 0), (0, 0, 5)]).cell_volumes(*cells) == pytest.approx(PI / 4 * 90)
    assert Cylindrical().cell_volumes(*(side[:, :2] for side in cells)) == pytest.approx(PI / 4 * 3, rel=1e-15)
    assert Cylindrical().cell_volumes(*(side[:, :1] for side in cells)).tolist() == [1.0]
    octant = np.array([[1.0, 0.0, 0.0]]), np.array([[2.0, PI / 2, PI / 2]])
    assert Spherical().cell_volumes(*octant) == pytest.approx(4 / 3 * PI * 7 / 8, rel=1e-15)
    thin = np.array([[1.0, 1e-9, 0.0]]), np.array([[2.0, 2e-9, 1.0]])
    assert Spherical().cell_volumes(*thin) == pytest.approx(7 / 3 * 1.5e-18, rel=1e-14)


@pytest.mark.parametrize("kind", KINDS)
def test_moved_and_turned(kind, rng):
    mapping = KINDS[kind]((1.0, 0.0, 0.0))
    own = inside(mapping, 5, rng)
    moved = mapping.translated((0.0, 2.0)).rotated(0.5, center=(0.0, 0.0))
    assert np.allclose(moved.to_parent(own), (mapping.to_parent(own) + np.array([0, 2, 0])) @ rotation(0.5), atol=1e-14)
    assert np.array_equal(mapping.frame.origin, [1, 0, 0])


def test_repr_can_be_typed_back():
    for mapping in (Cylindrical((1.0, 2.0)), Spherical(axes=[(0.0, 1.0), (-1.0, 0.0)])):
        again = eval(repr(mapping))
        assert repr(again) == repr(mapping)
        assert np.array_equal(again.frame.axes, mapping.frame.axes)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Cylindrical(axes=[(1, 0, 0), (0, 0, 0), (0, 0, 1)]), r"axes\[1\] = .* has no length"),
        (lambda: Spherical(axes=[(1, 0, 0), (2, 0, 0)]), r"axes\[0\].* axes\[1\].* are parallel"),
        (lambda: Cylindrical((1, 2, 3, 4)), r"origin has shape \(4,\)"),
        (
            lambda: Cylindrical().to_parent(np.array([[1.0, 0, 0], [-1.0, 0, 0]])),
            r"points\[1\] = \(-1.0, 0.0, 0.0\) has a negative radius in Cylindrical.*give radii from 0, and turn",
        ),
        (
            lambda: Spherical().to_parent(np.array([[1.0, 90.0, 0.0]])),
            r"points\[0\] = .* has theta = 90 in Spherical.*give it in rad, from 0 \(on the z axis\) to pi",
        ),
        (
            lambda: Cylindrical().cell_volumes(np.array([[-1.0, 0, 0]]), np.array([[1.0, 1, 1]])),
            r"has a negative radius",
        ),
        (
            lambda: Cylindrical().cell_volumes(np.array([[0.0, 0, 0], [0, 6, 0]]), np.array([[1.0, 1, 1], [1, 7, 1]])),
            r"go round from 0 to 7 rad, more than a full turn, and lie over each other",
        ),
        (
            lambda: Spherical().cell_volumes(np.array([[0.0, 0.0]]), np.array([[1.0, 1.0]])),
            r"cells in Spherical.* have 2 axes; give three",
        ),
        (
            lambda: Spherical().cell_volumes(np.array([[0.0, 2.0, 0]]), np.array([[1.0, 4.0, 1]])),
            r"has theta = 4",
        ),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
