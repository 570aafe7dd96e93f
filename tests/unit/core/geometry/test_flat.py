"""Disks, rings and circles: regions and curves in 2-D, faces and sets of points in 3-D."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import Circle, Combined, Disk, Rectangle, Ring, Segment, Surfaces


def test_in_the_plane_they_are_filled():
    disk, ring, circle = Disk(1.0, (0, 0)), Ring(1.0, 0.5, (0, 0)), Circle(1.0, (0, 0))
    points = [[0.0, 0.0], [0.75, 0.0], [1.0, 0.0], [2.0, 0.0]]
    assert disk.distance(points).tolist() == [-1.0, -0.25, 0.0, 1.0]
    assert ring.distance(points).tolist() == [0.5, -0.25, 0.0, 1.0]
    assert circle.distance(points).tolist() == [1.0, 0.25, 0.0, 1.0]
    assert disk.contains(points).tolist() == [True, True, True, False]
    assert ring.contains(points).tolist() == [False, True, True, False]
    assert circle.contains(points).tolist() == [False, False, True, False]


def test_in_space_they_are_faces_and_lines():
    disk, ring, circle = (
        shape for shape in (
            Disk(1.0, (0, 0, 0), (0, 0, 3)), Ring(1.0, 0.5, (0, 0, 0), (0, 0, 1)), Circle(1.0, (0, 0, 0), (0, 0, 1))
        )
    )  # fmt: skip
    points = [[0.0, 0.0, 2.0], [0.75, 0.0, 2.0], [4.0, 0.0, 4.0]]
    assert disk.distance(points) == pytest.approx([2.0, 2.0, 5.0])
    assert ring.distance(points) == pytest.approx([np.hypot(2.0, 0.5), 2.0, 5.0])
    assert circle.distance(points) == pytest.approx([np.hypot(2.0, 1.0), np.hypot(2.0, 0.25), 5.0])
    assert np.allclose(disk.bounds, [[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]])


def test_a_penny_shaped_crack_cuts_what_passes_through_it():
    crack = Disk(1.0, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    up, down = np.array([0.0, 0.0, 0.5]), np.array([0.0, 0.0, -0.5])
    at = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [1.001, 0.0, 0.0], [0.8, 0.7, 0.0]])
    assert crack.crosses(at + up, at + down).tolist() == [True, True, True, False, False]
    ring = Ring(1.0, 0.5, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    assert ring.crosses(at + up, at + down).tolist() == [False, True, True, False, False]


def test_a_circle_cuts_what_goes_in_or_out_or_through():
    circle = Circle(1.0, (0.0, 0.0))
    starts = [[0.0, 0.0], [-2.0, 0.0], [-2.0, 0.5], [-2.0, 1.01], [-0.5, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 0.0]]
    ends = [[2.0, 0.0], [0.0, 0.0], [2.0, 0.5], [2.0, 1.01], [0.5, 0.0], [3.0, 0.0], [2.0, 0.0], [0.5, 0.0]]
    expected = [True, True, True, False, False, False, False, True]
    assert circle.crosses(starts, ends).tolist() == expected
    assert circle.crosses(ends, starts).tolist() == expected


def test_a_circle_is_the_border_of_its_disk(rng):
    circle, disk = Circle(0.7, (0.1, 0.2)), Disk(0.7, (0.1, 0.2))
    starts, ends = rng.uniform(-1.0, 1.0, (2, 2000, 2))
    different = disk.contains(starts) != disk.contains(ends)
    crosses = circle.crosses(starts, ends)
    assert (different <= crosses).all()
    share = np.linspace(0.0, 1.0, 400)[:, None, None]
    way = (1.0 - share) * starts + share * ends
    inside = np.linalg.norm(way - [0.1, 0.2], axis=2) < 0.7
    through = inside.any(axis=0) & ~inside[0] & ~inside[-1]
    assert np.array_equal(crosses, different | through) or (crosses ^ (different | through)).sum() < 4


def test_filled_shapes_are_joined_as_regions_and_thin_ones_as_surfaces():
    left, right = Rectangle((0, 0), (1, 0), (0, 1)), Rectangle((1, 0), (1, 0), (0, 1))
    both = left | right
    assert isinstance(both, Combined)
    assert both.status([[1.0, 0.5], [0.5, 0.5], [2.0, 0.5]]).tolist() == [-1, -1, 0]
    assert isinstance(left - Disk(0.1, (0.5, 0.5)), Combined)
    assert isinstance(Circle(1.0, (0, 0)) | Segment((0, 0), (1, 0)), Surfaces)
    crack = Segment((-1.0, 0.5), (2.0, 0.5)) - left
    assert crack.crosses([[0.5, 1.0], [-0.5, 1.0]], [[0.5, 0.0], [-0.5, 0.0]]).tolist() == [False, True]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Disk(1.0, 0.0), r"center = \(0.0,\) has 1 component; give 2, or 3"),
        (lambda: Disk(0.0, (0, 0)), r"radius = 0.0 is not positive"),
        (lambda: Disk(1.0, (0, 0), (0, 0, 1)), r"in 2-D it lies in the plane anyway; leave the normal out"),
        (lambda: Disk(1.0, (0, 0, 0)), r"normal is missing: in 3-D give the direction in which the face looks"),
        (lambda: Circle(1.0, (0, 0, 0), (0, 0, 0)), r"normal = .* has no length"),
        (lambda: Ring(0.5, 0.5, (0, 0)), r"inner = 0.5 is not below outer = 0.5"),
        (
            lambda: Disk(1.0, (0, 0)).crosses([[0.0, 0.0]], [[1.0, 1.0]]),
            r"no bond can cross Disk\(.*\): in 2-D it fills a region; cut along its outline",
        ),
        (
            lambda: Circle(1.0, (0, 0, 0), (0, 0, 1)).crosses(np.zeros((1, 3)), np.ones((1, 3))),
            r"no bond can cross Circle\(.*\): in 3-D bonds pass by a line; cut with the Disk",
        ),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
