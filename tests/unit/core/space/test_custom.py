"""Coordinates of one's own: checked when they are made, and used as all others."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import Box
from rbs_core.space import Custom, convert, convert_vectors, world
from tests.unit.core.space.trees import no_waves, slopes, waves


def bend(points):
    """A straight bar around the z axis: x is the angle, y the distance from a radius of 2."""
    radius = 2.0 + points[:, 1]
    return np.column_stack([radius * np.sin(points[:, 0]), radius * np.cos(points[:, 0]), points[:, 2]])


def unbend(points):
    return np.column_stack(
        [np.arctan2(points[:, 0], points[:, 1]), np.hypot(points[:, 0], points[:, 1]) - 2.0, points[:, 2]]
    )


def bend_slopes(points):
    radius, sine, cosine = 2.0 + points[:, 1], np.sin(points[:, 0]), np.cos(points[:, 0])
    result = np.zeros((len(points), 3, 3))
    result[:, 0, 0], result[:, 0, 1] = radius * cosine, -radius * sine
    result[:, 1, 0], result[:, 1, 1] = sine, cosine
    result[:, 2, 2] = 1.0
    return result


def bend_box(lower, upper):
    """The full ring: never wrong, not sharp."""
    return (-2.0 - upper[1], -2.0 - upper[1], lower[2]), (2.0 + upper[1], 2.0 + upper[1], upper[2])


def logarithm(points):
    return np.log(points)


def power(points):
    return np.exp(points)


def test_axes_follow_the_functions():
    mapping = Custom(bend, unbend, (1.0, 0.0, 0.0), [(2.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, -0.5)])
    own = np.array([[0.0, 0.0, 0.0], [np.pi / 2, 1.0, 4.0]])
    assert np.allclose(mapping.to_parent(own), [[1.0, 6.0, 0.0], [7.0, 0.0, -2.0]], atol=1e-14)
    assert np.allclose(mapping.from_parent(mapping.to_parent(own)), own, atol=1e-15)


def test_differences_are_good_to_twelve_digits(rng):
    points = rng.uniform(-1.0, 1.0, (2000, 3))
    exact = Custom(bend, unbend, jacobian=bend_slopes).basis(points)
    assert np.abs(Custom(bend, unbend).basis(points) - exact).max() < 2e-12


def test_differences_take_their_step_from_the_samples():
    """Coordinates of some thousandth of a millimeter next to one of kilometers."""
    scale = np.array([1e-6, 1.0, 1e3])

    def large(points):
        return waves(points / scale)

    def small(points):
        return no_waves(points) * scale

    samples = np.random.default_rng(4).uniform(-1.0, 1.0, (50, 3)) * scale
    mapping = Custom(large, small, samples=samples)
    assert np.allclose(mapping.basis(samples) * scale[:, None], slopes(samples / scale), atol=2e-12)


def test_functions_that_change_their_argument_do_no_harm():
    def doubled(points):
        points *= 2.0
        return points

    def halved(points):
        points /= 2.0
        return points

    system = world.custom("doubled", doubled, halved)
    points = np.ones((2, 3))
    assert np.array_equal(convert(points, system, world), np.full((2, 3), 2.0))
    assert np.array_equal(points, np.ones((2, 3)))


def test_samples_come_from_the_domain_of_the_functions():
    with pytest.raises(
        BadInput, match=r"to_parent = logarithm returns .*nan.* for \(.*give points from its domain .*samples=points"
    ):
        Custom(logarithm, power)
    mapping = Custom(logarithm, power, samples=[[1.0, 2.0, 3.0], [0.5, 4.0, 0.1]])
    assert mapping.to_parent(np.full((1, 3), np.e)).tolist() == [[1.0] * 3]
    with pytest.raises(BadInput, match=r"to_parent = logarithm returns \(float\('-inf'\), 0.0, 0.0\) for \(0.0, 1.0"):
        mapping.to_parent(np.array([[0.0, 1.0, 1.0]]))


def test_bounds_are_infinite_unless_a_function_knows_them():
    slab = Box((0.5, 0.5, 0.5))
    assert np.isinf(slab.placed(world.custom("bent", bend, unbend)).bounds).all()
    ring = slab.placed(world.custom("bent", bend, unbend, (1.0, 0.0, 0.0), bounds=bend_box))
    assert np.array_equal(ring.bounds, [[-1.25, -2.25, -0.25], [3.25, 2.25, 0.25]])
    assert ring.contains([[1.0, 2.0, 0.0], [1.0, 1.7, 0.0]]).tolist() == [True, False]


def test_cell_volumes_by_points_of_gauss():
    """The Jacobian of a ring is linear in the radius, for which three points are exact."""
    lower, upper = np.array([[0.0, 0.0, 0.0], [1.0, 0.5, 0.0]]), np.array([[1.0, 0.5, 2.0], [1.2, 0.6, 1.0]])
    exact = [0.5 * (2.5**2 - 2.0**2) * 2.0, 0.1 * (2.6**2 - 2.5**2)]
    mapping = Custom(bend, unbend, axes=3 * np.eye(3), jacobian=bend_slopes)
    assert np.allclose(mapping.cell_volumes(lower, upper), 27 * np.array(exact), rtol=1e-14)
    assert np.allclose(mapping.cell_volumes(lower[:, :2], upper[:, :2]), 9 * np.array(exact) / [2.0, 1.0], rtol=1e-14)


def test_vectors_belong_to_the_tangents():
    system = world.custom("bent", bend, unbend)
    assert np.allclose(convert_vectors([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], system, world), [3.0, 0.0, 0.0], atol=1e-11)
    assert np.allclose(convert_vectors([0.0, 3.0, 0.0], [3.0, 0.0, 0.0], world, system), [-1.0, 0.0, 0.0], atol=1e-11)


def test_moving_does_not_check_anew():
    calls = []

    def counted(points):
        calls.append(len(points))
        return bend(points)

    system = world.custom("bent", counted, unbend, jacobian=bend_slopes)
    checked = len(calls)
    system.translate((1.0, 0.0))
    system.rotate(np.pi / 2, center=(0.0, 0.0))
    assert len(calls) == checked
    assert np.allclose(convert([0.0, 0.0, 0.0], system, world), [-2.0, 1.0, 0.0], atol=1e-15)


def test_repr_can_be_typed_back():
    samples = [[0.1, 0.2, 0.3]]
    mapping = Custom(bend, unbend, (1.0,), [(2, 0), (0, 1)], samples=samples, jacobian=bend_slopes, bounds=bend_box)
    again = eval(repr(mapping))
    assert repr(again) == repr(mapping)
    assert "samples=((0.1, 0.2, 0.3),), jacobian=bend_slopes, bounds=bend_box" in repr(mapping)
    system = world.custom("bent", waves, no_waves)
    assert repr(system) == "world.custom('bent', waves, no_waves, origin=(0.0, 0.0, 0.0))"


def turned_slopes(points):
    return np.swapaxes(bend_slopes(points), 1, 2)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: Custom(bend, bend),
            r"from_parent = bend is not the inverse of to_parent = bend: the sample \(0.6.*\) goes to \(.*\) and comes "
            r"back as \(.*\); give functions that undo each other, or samples=points of shape \(n, 3\)",
        ),
        (lambda: Custom(np.abs, np.abs), r"not the inverse of to_parent = absolute"),
        (lambda: Custom(lambda p: p * [1, 1, 0], lambda p: p), r"not the inverse"),
        (lambda: Custom(lambda p: p**3, np.cbrt, samples=[[1, 1, 1], [0, 0, 0]]), r"is flat at the sample \(0.0, 0.0"),
        (lambda: Custom(bend, unbend, axes=[(1, 0), (0, 0)]), r"axes\[1\] = .* has no length; give a vector"),
        (lambda: Custom(3, unbend), r"to_parent = 3 is no function; give one of points"),
        (lambda: Custom(bend, None), r"from_parent = None is no function"),
        (lambda: Custom(bend, unbend, jacobian=np.eye(3).tolist()), r"jacobian = .* is no function"),
        (
            lambda: Custom(lambda p: p[:, :2], unbend),
            r"returns float64 of shape \(64, 2\) for points of shape \(64, 3\)",
        ),
        (lambda: Custom(lambda p: p + 1j, unbend), r"returns complex128 of shape"),
        (lambda: Custom(bend, unbend, samples=[[1.0, 2.0]]), r"samples has shape \(1, 2\); give at least one point"),
        (lambda: Custom(bend, unbend, samples=np.zeros((0, 3))), r"samples has shape \(0, 3\)"),
        (
            lambda: Custom(bend, unbend, jacobian=turned_slopes),
            r"jacobian = turned_slopes is not the derivative of to_parent = bend: at the sample .* it is .*, "
            r"differences give .*; give \[:, i, j\] = derivative of coordinate j by own coordinate i",
        ),
        (lambda: Custom(bend, unbend, jacobian=lambda p: p), r"return real numbers of shape \(64, 3, 3\)"),
        (
            lambda: Custom(bend, unbend, bounds=lambda low, high: (low, high)),
            r"bounds = .* gives .* for the box of all samples, but \(.*\) goes to \(.*; give a box around all images",
        ),
        (lambda: Custom(bend, unbend, bounds=lambda low, high: (high, low)), r"return the smallest and the largest"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
