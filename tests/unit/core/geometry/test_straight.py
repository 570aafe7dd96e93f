"""Segments, rays and lines."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import Line, Ray, Segment, Status


def test_distance_and_projection():
    points = [[-1.0, 1.0], [0.5, -2.0], [3.0, 1.0]]
    segment, ray, line = Segment((0, 0), (1, 0)), Ray((0, 0), (2, 0)), Line((0, 0), (-3, 0))
    assert segment.distance(points) == pytest.approx([np.sqrt(2.0), 2.0, np.sqrt(5.0)])
    assert ray.distance(points) == pytest.approx([np.sqrt(2.0), 2.0, 1.0])
    assert line.distance(points) == pytest.approx([1.0, 2.0, 1.0])
    assert segment.projection(points).tolist() == [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]]
    assert ray.projection(points).tolist() == [[0.0, 0.0], [0.5, 0.0], [3.0, 0.0]]
    assert line.projection(points).tolist() == [[-1.0, 0.0], [0.5, 0.0], [3.0, 0.0]]


def test_they_are_sets_of_points_as_well():
    segment = Segment((0.0, 0.0, 0.0), (0.1, 0.2, 0.3))
    on = np.linspace(0.0, 1.0, 11)[:, None] * segment.end
    assert segment.contains(on).all()
    assert (segment.status(on) == Status.ON).all()
    assert not segment.contains(on + 1e-6).any()
    assert not segment.contains([1.001 * segment.end])[0]


def test_bounds():
    assert [side.tolist() for side in Ray((1, 2), (0, -3)).bounds] == [[1.0, -np.inf], [1.0, 2.0]]
    assert [side.tolist() for side in Ray((1, 2), (1, -3)).bounds] == [[1.0, -np.inf], [np.inf, 2.0]]
    assert [side.tolist() for side in Line((1, 2), (1, 0)).bounds] == [[-np.inf, 2.0], [np.inf, 2.0]]


def test_rays_and_lines_cut_without_end():
    starts, ends = (
        [[-5.0, 1.0], [5.0, 1.0], [1e6, 1.0], [0.0, 1.0]],
        [[-5.0, -1.0], [5.0, -1.0], [1e6, -1.0], [0.0, -1.0]],
    )
    assert Ray((0, 0), (1, 0)).crosses(starts, ends).tolist() == [False, True, True, True]
    assert Line((0, 0), (1, 0)).crosses(starts, ends).tolist() == [True] * 4
    assert Line((0, 0), (1, 0)).crosses([[0.0, 0.0]], [[0.0, -1.0]]).tolist() == [True]  # left is the positive side
    assert Line((0, 0), (-1, 0)).crosses([[0.0, 0.0]], [[0.0, -1.0]]).tolist() == [False]


def test_a_bond_and_its_reverse_get_the_same_answer(rng):
    starts, ends = np.round(rng.uniform(-1.0, 1.0, (2, 500, 2)), 1)
    for cut in (Ray((0.1, 0.2), (1.0, 3.0)), Line((0.1, 0.2), (1.0, 3.0)), Segment((0.1, 0.2), (0.3, 0.8))):
        assert np.array_equal(cut.crosses(starts, ends), cut.crosses(ends, starts))


def test_a_segment_is_part_of_its_ray_and_that_of_its_line(rng):
    starts, ends = rng.uniform(-1.0, 1.0, (2, 500, 2))
    segment, ray, line = (
        shape.crosses(starts, ends)
        for shape in (Segment((0, 0), (0.5, 0.1)), Ray((0, 0), (0.5, 0.1)), Line((0, 0), (0.5, 0.1)))
    )
    assert (segment <= ray).all()
    assert (ray <= line).all()
    assert segment.sum() < ray.sum() < line.sum()


def test_line_through_two_points():
    assert Line.through((1, 2), (3, 3)) == Line((1, 2), (2, 1))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Ray((0, 0), (0, 0)), r"direction = \(0.0, 0.0\) has no length; give a vector of any length but 0"),
        (lambda: Line((0, 0), (0, 0)), r"direction = .* has no length"),
        (lambda: Line((0, 0), (0, 0, 1)), r"direction = .* has 3 components; give 2"),
        (lambda: Ray(0.0, 1.0), r"start = \(0.0,\) has 1 component; give 2 or 3 \(in 1-D: HalfSpace"),
        (lambda: Line.through((1, 1), (1, 1)), r"first = second = \(1.0, 1.0\); give two different points"),
        (
            lambda: Line((0, 0, 0), (0, 0, 1)).crosses(np.zeros((1, 3)), np.ones((1, 3))),
            r"no bond can cross Line\(.*\): in 3-D bonds pass by a line; cut with a Polygon, a Disk or a Plane",
        ),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
