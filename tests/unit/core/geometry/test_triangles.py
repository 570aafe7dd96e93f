"""The checks that make a surface of triangles."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry.boxtree import BoxTree
from rbs_core.geometry.triangles import as_triangles, edges_of, require_no_crossing, require_one_side
from tests.unit.core.geometry.examples import FACES, OCTAHEDRON

VERTICES, TRIANGLES = as_triangles(OCTAHEDRON, FACES)
TURNED = TRIANGLES.copy()
TURNED[3] = TURNED[3, ::-1]


def test_triangles_are_copied_and_cannot_be_changed():
    rows = np.array(FACES)
    _, triangles = as_triangles(OCTAHEDRON, rows)
    rows[0] = 0
    assert triangles[0].tolist() == list(FACES[0])
    with pytest.raises(ValueError, match="read-only"):
        triangles[0] = 0


def test_edges_in_the_order_of_the_corners():
    starts, ends, owners = edges_of(np.array([[3, 1, 2], [0, 5, 4]]))
    assert starts.tolist() == [3, 1, 2, 0, 5, 4]
    assert ends.tolist() == [1, 2, 3, 5, 4, 0]
    assert owners.tolist() == [0, 0, 0, 1, 1, 1]


def test_closed_and_open_surfaces_with_two_sides_pass():
    require_one_side(VERTICES, TRIANGLES, closed=True)
    require_one_side(VERTICES, TRIANGLES[:5], closed=False)
    require_no_crossing(VERTICES, TRIANGLES, BoxTree(VERTICES[TRIANGLES]))


def crossing() -> None:
    vertices = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0.2, 0.2, -1), (0.2, 0.2, 1), (2, 2, 0)], dtype=float)
    triangles = np.array([(0, 1, 2), (3, 4, 5)])
    require_no_crossing(vertices, triangles, BoxTree(vertices[triangles]))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: as_triangles([(0, 0), (1, 0)], FACES), r"vertices has shape \(2, 2\); give points in 3-D"),
        (lambda: as_triangles([(0, 0, np.nan)], FACES), r"vertices\[0, 2\] = nan is not finite"),
        (lambda: as_triangles(OCTAHEDRON, [(0, 1)]), r"triangles has shape \(1, 2\) of int64; give three indices"),
        (lambda: as_triangles(OCTAHEDRON, [(0.0, 1.0, 2.0)]), r"triangles has shape \(1, 3\) of float64"),
        (lambda: as_triangles(OCTAHEDRON, np.zeros((0, 3), int)), r"triangles has shape \(0, 3\)"),
        (
            lambda: as_triangles(OCTAHEDRON, [(0, 2, 4), (0, 2, 6)]),
            r"triangles\[1\] = \(0, 2, 6\) names a vertex that is not there; give indices from 0 to 5",
        ),
        (
            lambda: as_triangles([(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0)], [(0, 1, 3), (0, 1, 2)]),
            r"triangles\[1\] = \(0, 1, 2\) with the corners .* has no area \(1 such triangles\); leave it out",
        ),
        (lambda: as_triangles(OCTAHEDRON, [(0, 0, 1)]), r"triangles\[0\] = \(0, 0, 1\) .* has no area"),
        (
            lambda: require_one_side(VERTICES, TRIANGLES[1:], closed=True),
            r"the surface is open: triangle \d has no neighbor at the edge from vertex \d at .* \(3 such edges\)",
        ),
        (
            lambda: require_one_side(VERTICES, TURNED, closed=True),
            r"triangles \d and \d go along the edge from .* in the same direction: one of them is turned over",
        ),
        (
            lambda: require_one_side(VERTICES, np.vstack([TRIANGLES, [(0, 2, 1)]]), closed=False),
            r"3 triangles share the edge from vertex .*; a surface has two there: give several surfaces",
        ),
        (crossing, r"triangles \d and \d pass through each other; give a surface that does not meet itself"),
    ],
)
def test_refusals_say_what_where_and_cure(call, message):
    with pytest.raises(BadInput, match=message):
        call()
