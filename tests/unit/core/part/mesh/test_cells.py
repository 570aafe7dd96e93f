"""Nodes and node sets out of cells, and the meshes that are refused."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

from rbs_core import BadInput, Part, volume, world
from rbs_core.part.mesh import placed
from tests.unit.core.part.mesh.blocks import CELLS, block, one_cell


def from_mesh(mesh, **arguments):
    return Part.from_mesh("p", mesh, **arguments)


def refused(mesh, match, **arguments):
    with pytest.raises(BadInput, match=match):
        from_mesh(mesh, **arguments)


def sets(part):
    return {name: nodes.tolist() for name, nodes in part.node_sets.items()}


# -- nodes ----------------------------------------------------------------------------------------------------------


def test_a_block_of_hexahedra_is_a_regular_part():
    part = from_mesh(block(4, 3, 2), precision="single")
    assert (part.dimension, len(part), part.precision, part.spacing) == (3, 24, "single", pytest.approx(1.0))
    assert part.positions[:2].tolist() == pytest.approx(np.array([[0.5, 0.5, 0.5], [1.5, 0.5, 0.5]]))
    assert part[volume].tolist() == pytest.approx([1.0] * 24)
    assert part.system is world
    assert part.grid is None
    part.connect(1.5)
    assert part.bonds.storage == "list"
    with pytest.raises(BadInput, match="not those of a regular grid"):
        part.connect(1.5, storage="lattice")


def test_scale_thickness_and_area():
    part = from_mesh(block(2, 1, 0), scale=1e-3, thickness=0.5)
    assert part.positions.tolist() == pytest.approx(np.array([[0.5e-3, 0.5e-3], [1.5e-3, 0.5e-3]]))
    assert part[volume].tolist() == pytest.approx([0.5e-6] * 2)
    assert (part.thickness, part.spacing) == (0.5, pytest.approx(1e-3))
    bar = from_mesh(one_cell("line"), area=3.0)
    assert (bar[volume].tolist(), bar.area) == ([6.0], 3.0)
    refused(one_cell("line"), "thickness belongs to 2-D parts only", thickness=1.0)
    refused(one_cell("line"), "scale=0 must be positive", scale=0)


def test_spacing_is_the_size_of_cells_that_are_alike():
    points = [[0, 0], [1, 0], [2.4, 0], [4, 0], [0, 1], [1, 1], [2.4, 1], [4, 1]]
    alike = meshio.Mesh(points, [("quad", [[0, 1, 5, 4], [1, 2, 6, 5]])])
    assert from_mesh(alike).spacing == pytest.approx((1 + np.sqrt(1.4)) / 2)
    uneven = meshio.Mesh(points, [("quad", [[0, 1, 5, 4], [0, 3, 7, 4]])])
    assert from_mesh(uneven).spacing is None
    assert from_mesh(uneven, spacing=0.7).spacing == 0.7


def test_kinds_may_be_mixed_and_points_may_lie_around():
    square, triangle = [[5, 1], [6, 1], [6, 2], [5, 2]], [[6, 1], [9, 1], [6, 4]]
    points = np.array([[np.nan] * 2, *square, *triangle, [0, 0]])
    part = from_mesh(meshio.Mesh(points, [("quad", [[1, 2, 3, 4]]), ("vertex", [[8]]), ("triangle", [[5, 6, 7]])]))
    assert part.positions.tolist() == pytest.approx(np.array([[5.5, 1.5], [7.0, 2.0]]))
    assert part[volume].tolist() == pytest.approx([1.0, 4.5])


def test_the_highest_dimension_counts():
    mesh = block(1, 1, 1)
    mesh = meshio.Mesh(mesh.points, [("quad", [[0, 1, 3, 2]]), *mesh.cells, ("line", [[0, 1]])])
    assert len(from_mesh(mesh)) == 1
    assert from_mesh(mesh).dimension == 3


def test_a_plane_may_lie_at_any_height():
    mesh = block(2, 1, 0)
    mesh.points[:, 2] = 7.0
    assert from_mesh(mesh).positions.shape == (2, 2)
    mesh.points[:, 2] = 7.0 + 1e-8 * np.arange(len(mesh.points))  # of a file in single precision
    assert from_mesh(mesh).dimension == 2


def test_cells_that_are_there_twice_are_one_node():
    mesh = block(3, 1, 0)
    again = mesh.cells[0].data[[1]][:, [2, 3, 0, 1]]
    part = from_mesh(meshio.Mesh(mesh.points, [("quad", again), *mesh.cells]))
    assert part.positions[:, 0].tolist() == pytest.approx([1.5, 0.5, 2.5])


# -- sets -----------------------------------------------------------------------------------------------------------


def test_sets_of_lower_cells_are_those_of_their_owners():
    mesh = block(3, 2, 1)
    cells = [
        ("quad", [[0, 12, 16, 4], [1, 5, 17, 13]]),  # the left side of a cell, and a side between two
        *mesh.cells,
        ("line", [[5, 17]]),  # an edge in the middle of four cells
        ("vertex", [[0], [23]]),
        ("triangle", [[0, 1, 2]]),  # across two cells
    ]
    nothing = {"triangle": [[], [], [], [], [0]]}
    held = {
        "left": [[0], [], [], [], []],
        "between": [[1], [], [], [], []],
        "edge": [[], [], [0], [], []],
        "tips": [[], [], [], [0, 1], []],
        "mixed": [[0], [5], [], [], []],
        "self": [[], [2, 0], [], [], []],
    }
    with pytest.warns(UserWarning, match="no cell is in triangle: left out"):
        part = from_mesh(meshio.Mesh(mesh.points, cells, cell_sets={**held, **nothing}))
    assert sets(part) == {
        "left": [0], "between": [0, 1], "edge": [0, 1, 3, 4], "tips": [0, 5], "mixed": [0, 5], "self": [0, 2],
    }  # fmt: skip


def test_sets_of_points_are_cells_with_a_side_there():
    mesh = block(2, 2, 0, cell_sets={"same": [[3]]}, point_sets={"left": [0, 3, 6], "middle": [4], "same": [0, 3]})
    assert sets(from_mesh(mesh)) == {"left": [0, 2], "middle": [0, 1, 2, 3], "same": [3]}


def test_a_collapsed_cell_owns_no_more_than_its_sides():
    """With a corner twice, it has not three points in common with a triangle that only touches an edge of it."""
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1], [5, 5, 5]]
    cells = [("hexahedron", [[0, 1, 2, 2, 3, 4, 5, 5]]), ("triangle", [[2, 5, 6], [0, 2, 1]])]
    with pytest.warns(UserWarning, match="no cell is in beside"):
        part = from_mesh(meshio.Mesh(points, cells, cell_sets={"beside": [[], [0]], "below": [[], [1]]}))
    assert sets(part) == {"below": [0]}


def test_a_part_can_be_made_of_some_sets_alone():
    held = {"steel": [[0, 1, 4]], "rubber": [[2, 3]], "glue": [[5]]}
    mesh = block(3, 2, 0, cell_sets=held, point_sets={"top": [8, 9, 10, 11], "left": [0, 4, 8]})
    mesh.points[7] = mesh.points[6]  # the third cell is degenerate, and belongs to another part
    part = from_mesh(mesh, only="steel")
    assert part.positions.tolist() == pytest.approx(np.array([[0.5, 0.5], [1.5, 0.5], [1.5, 1.5]]))
    assert sets(part) == {"steel": [0, 1, 2], "left": [0], "top": [2]}
    mesh.points[7] = [3.0, 1.0, 0.0]
    assert len(from_mesh(mesh, only=["steel", "glue"])) == 4
    refused(mesh, "part 'p', mesh: only='stell' is no set of this mesh: the nearest names are steel", only="stell")
    refused(block(1, 1, 0), "only='a' is no set of this mesh: there are none", only=["a"])
    refused(block(1, 1, 0), "no cell is in only=: name other sets", only=[])


# -- refused --------------------------------------------------------------------------------------------------------


def test_flat_cells_are_named():
    mesh = block(2, 2, 0)
    mesh.points[[1, 4]] = mesh.points[[0, 3]]
    text = (
        r"part 'p', mesh: 1 of 4 cells have no positive area, such as cell 0 \(quad, points \[0, 1, 4, 3\] at "
        r"\[\[0.0, 0.0\], \[0.0, 0.0\], \[0.0, 1.0\], \[0.0, 1.0\]\]\) with 0 m\^2; they are flat: remove them, or mesh"
    )
    refused(mesh, text)
    refused(mesh, text, reorient=True)


@pytest.mark.parametrize("kind", [kind for kind in CELLS if kind != "line"])
def test_cells_turned_inside_out_are_named(kind):
    mesh = one_cell(kind)
    good = from_mesh(mesh)
    mesh.points[:, 0] *= -1
    why = "clockwise" if good.dimension == 2 else "turned inside out"
    words = f"1 of 1 cells have no positive .*, such as cell 0 .{kind}, points .* with -.*{why}.*reverse their points"
    refused(mesh, words)
    turned = from_mesh(mesh, reorient=True)
    assert turned[volume].tolist() == good[volume].tolist()
    assert turned.positions == pytest.approx(good.positions * [-1, *[1] * (good.dimension - 1)])


def test_lines_have_no_inside():
    mesh = meshio.Mesh([[0.0], [2.0], [3.0]], [("line", [[1, 0], [1, 2]])])
    assert from_mesh(mesh)[volume].tolist() == [2.0, 1.0]


def test_cells_are_numbered_in_the_order_of_the_file():
    mesh = block(5, 1, 0)
    mesh.cells[0].data[1:] = mesh.cells[0].data[1:, ::-1]
    mesh = meshio.Mesh(mesh.points, [("line", [[0, 1], [1, 2]]), *mesh.cells])
    refused(mesh, "4 of 5 cells .* such as cell 3 .*; cell 4 .*; cell 5 .* with -1 m.2; the points of a cell go round")


def test_shells_and_beams_in_space_are_refused():
    shell = block(2, 2, 0)
    shell.points[4, 2] = 0.1
    text = "highest dimension are surfaces, and z goes from 0 to 0.1 m: shells and beams in space are no parts"
    refused(shell, text)
    upright = block(2, 2, 0)
    upright.points = upright.points[:, [0, 2, 1]]
    refused(upright, "and z goes from 0 to 2 m: .* turn it so that z is the same everywhere")
    beam = meshio.Mesh([[0, 0, 0], [0, 3, 0]], [("line", [[0, 1]])])
    refused(beam, "are lines, and y goes from 0 to 3 m: .* so that y and z are the same everywhere")


def test_points_alone_are_refused():
    refused(meshio.Mesh(np.eye(3), [("vertex", [[0], [1]])]), "only points: Part.from_points takes points with volumes")
    refused(meshio.Mesh(np.eye(3), []), "there are no cells")


def test_what_is_found_can_be_asked_for():
    found = placed("me", block(2, 1, 1), only=None, scale=2.0, file_format=None, reorient=False)
    assert (found.dimension, found.spacing, found.sets, found.unknown) == (3, pytest.approx(2.0), {}, [])
    assert found.measures.tolist() == pytest.approx([8.0, 8.0])
