"""Sectors of a circle, symmetric to the bit, and layers between radii."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.space.grids.circles import as_center, as_radii, center_text, circle, fours, layers


def rows(points) -> set[tuple[float, ...]]:
    return {tuple(row) for row in np.asarray(points).tolist()}


@pytest.mark.parametrize("count", [3, 4, 5, 8, 12, 20, 26, 100, 1000])
def test_sectors_are_where_they_should_be(count):
    angles = (np.arange(count) + 0.5) * (2 * np.pi / count)
    assert np.allclose(circle(count), np.column_stack([np.cos(angles), np.sin(angles)]), rtol=0, atol=1e-14)
    assert np.allclose(np.linalg.norm(circle(count), axis=1), 1.0, rtol=3e-16, atol=0)


@pytest.mark.parametrize("count", [4, 8, 12, 20, 100, 1004])
def test_multiples_of_four_are_symmetric_to_axes_and_diagonals_to_the_bit(count):
    points = circle(count)
    assert len(rows(points)) == count
    for image in (points * [1, -1], points * [-1, 1], points[:, ::-1]):
        assert rows(image) == rows(points)


@pytest.mark.parametrize("count", [3, 5, 7, 101])
def test_any_number_is_symmetric_to_the_first_axis_to_the_bit(count):
    assert rows(circle(count) * [1, -1]) == rows(circle(count))


def test_multiples_of_four():
    assert fours(np.array([0.0, 5.9, 6.1, 10.0, 102.0])).tolist() == [4, 4, 8, 8, 104]


def test_layers():
    assert layers(0.5, 1.0, 0.26, dimension=2).edges.tolist() == [0.5, 0.75, 1.0]
    assert layers(0.0, 1.0, 9.0, dimension=3).edges.tolist() == [0.0, 1.0]


def test_centers_as_text():
    assert center_text(np.zeros(2)) == ""
    assert center_text(np.array([0.0, 1.0])) == ", center=(0.0, 1.0)"
    assert as_center((1, 2), 2).tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: layers(1.0, 1.0, 0.1, dimension=2), r"inner = 1.0, outer = 1.0 are no radii; give 0 <= inner < outer"),
        (lambda: layers(-1.0, 1.0, 0.1, dimension=2), r"inner = -1.0, outer = 1.0 are no radii"),
        (lambda: layers(0.0, 1.0, -0.1, dimension=2), r"spacing = -0.1 is not positive"),
        (lambda: layers(0.0, 1.0, 1e-5, dimension=2), r"spacing = 1e-05 would make 3.14e\+10 points, more than"),
        (lambda: layers(0.0, 1.0, 9e-4, dimension=3), r"spacing = 0.0009 would make 5.75e\+09 points"),
        (lambda: as_radii([-0.5, 1.0]), r"radii\[0\] = -0.5 is negative; give radii from 0"),
        (lambda: as_radii([1.0, 0.5]), r"edges\[1\] = 0.5 is not above edges\[0\] = 1.0"),
        (lambda: as_center((0, 0, 0), 2), r"center = \(0.0, 0.0, 0.0\) has 3 components; give 2"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
