"""Files of every format, written by meshio and read back; what is refused there; groups of gmsh."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

from rbs_core import BadInput, Part, volume
from tests.unit.core.part.mesh.blocks import CELLS, block, one_cell

FORMATS = {
    "abaqus": ".inp",
    "gmsh": ".msh",
    "gmsh22": ".msh",
    "exodus": ".exo",
    "vtk": ".vtk",
    "vtu": ".vtu",
    "xdmf": ".xdmf",
    "med": ".med",
    "nastran": ".bdf",
}

# Two unit squares side by side, the left one of two triangles. A curve is their left side, another one the top.
SQUARES = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
4
0 9 "corner"
1 1 "left side"
2 5 "steel"
2 6 "rubber"
$EndPhysicalNames
$Nodes
7
1 0 0 0
2 1 0 0
3 2 0 0
4 0 1 0
5 1 1 0
6 2 1 0
10 7 7 7
$EndNodes
$Elements
7
1 15 2 9 1 1
2 1 2 1 1 1 4
3 1 2 2 2 4 5
4 1 2 2 2 5 6
5 2 2 5 1 1 2 5
6 2 2 5 1 1 5 4
7 3 2 6 2 2 3 6 5
$EndElements
"""

# The same body, where the triangles belong to two groups.
SQUARES_41 = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
4
1 1 "left side"
2 5 "steel"
2 6 "rubber"
2 7 "all"
$EndPhysicalNames
$Entities
0 1 2 0
1 0 0 0 0 1 0 1 1 0
1 0 0 0 1 1 0 2 5 7 0
2 1 0 0 2 1 0 2 6 7 0
$EndEntities
$Nodes
1 6 1 6
2 1 0 6
1
2
3
4
5
6
0 0 0
1 0 0
2 0 0
0 1 0
1 1 0
2 1 0
$EndNodes
$Elements
3 4 1 4
1 1 1 1
1 1 4
2 1 2 2
2 1 2 5
3 1 5 4
2 2 3 1
4 2 3 6 5
$EndElements
"""


def written(folder, mesh, name, file_format=None):
    """The path of a file that meshio has written."""
    if name.endswith(".exo"):
        pytest.importorskip("netCDF4", reason="meshio needs it for Exodus")
    path = folder / name
    meshio.write(path, mesh, file_format)
    return path


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("kind", CELLS)
@pytest.mark.filterwarnings("ignore:.*meshio says")
def test_every_format_brings_every_kind_of_cell(name, kind, tmp_path, capsys):
    if (name, kind) in {("abaqus", "pyramid"), ("exodus", "line")}:
        pytest.skip("meshio does not write it")
    if name == "med":
        pytest.importorskip("h5py")
    path = written(tmp_path, one_cell(kind), f"cell{FORMATS[name]}", name)
    capsys.readouterr()
    part = Part.from_mesh("cell", path)
    _, size, centroid = CELLS[kind]
    assert part.dimension == len(centroid)
    assert part.positions == pytest.approx(np.array([centroid], float), rel=1e-14)
    assert part[volume].tolist() == pytest.approx([size], rel=1e-14)
    assert capsys.readouterr() == ("", "")


def test_physical_groups_of_gmsh_are_node_sets(tmp_path):
    path = tmp_path / "squares.msh"
    path.write_text(SQUARES)
    part = Part.from_mesh("squares", path, thickness=0.1)
    assert (part.dimension, part.thickness, len(part)) == (2, 0.1, 3)
    assert part.positions.tolist() == pytest.approx(np.array([[2 / 3, 1 / 3], [1 / 3, 2 / 3], [1.5, 0.5]]))
    assert part[volume].tolist() == pytest.approx([0.05, 0.05, 0.1])
    assert {name: nodes.tolist() for name, nodes in part.node_sets.items()} == {
        "corner": [0, 1],
        "left side": [1],
        "curve_2": [1, 2],  # a group without a name
        "steel": [0, 1],
        "rubber": [2],
    }


def test_cells_in_two_groups_are_one_node(tmp_path):
    new, old = tmp_path / "new.msh", tmp_path / "old.msh"
    new.write_text(SQUARES_41)
    # older files hold such a cell once for each group
    twice = SQUARES.replace("7\n1 15", "8\n1 15").replace("$EndElements", "8 2 2 7 1 5 4 1\n$EndElements")
    old.write_text(twice.replace('4\n0 9 "corner"', '5\n2 7 "all"\n0 9 "corner"'))
    part = Part.from_mesh("squares", new)
    assert {name: nodes.tolist() for name, nodes in part.node_sets.items()} == {
        "left side": [1], "steel": [0, 1], "rubber": [2], "all": [0, 1, 2],
    }  # fmt: skip
    part = Part.from_mesh("squares", old)
    assert len(part) == 3
    assert part.node_sets["all"].tolist() == [1]
    assert part.node_sets["steel"].tolist() == [0, 1]


def test_cell_and_point_sets_survive_a_file(tmp_path):
    mesh = block(3, 1, 1, cell_sets={"ends": [[0, 2]]}, point_sets={"left": [0, 4, 8, 12], "corner": [15]})
    part = Part.from_mesh("block", written(tmp_path, mesh, "block.inp"))
    assert {name: nodes.tolist() for name, nodes in part.node_sets.items()} == {
        "ends": [0, 2], "left": [0], "corner": [2],
    }  # fmt: skip


def test_a_mesh_of_meshio_is_taken_as_it_is():
    mesh = block(2, 1, 0, cell_sets={"gmsh:bounding_entities": [[0]], "some": [None], "right": [[1]]})
    with pytest.warns(UserWarning, match="part 'p': no cell is in some: left out"):
        part = Part.from_mesh("p", mesh)
    assert part.node_sets["right"].tolist() == [1]
    assert list(part.node_sets) == ["right"]


def test_what_meshio_says_becomes_a_warning(tmp_path):
    path = tmp_path / "m.msh"
    path.write_text(SQUARES.replace("5 2 2 5 1 1 2 5", "5 2 4 5 1 1 1 1 2 5").replace("6 2 2 5 1 ", "6 2 4 5 1 1 1 "))
    with pytest.warns(UserWarning, match=r"part 'p': .*m\.msh: meshio says: .*tag data") as caught:
        Part.from_mesh("p", path)
    assert caught[0].filename == __file__


def refused(mesh, match, **arguments):
    with pytest.raises(BadInput, match=match):
        Part.from_mesh("p", mesh, **arguments)


def test_files_that_cannot_be_read_are_refused(tmp_path, capsys):
    refused(tmp_path / "gone.msh", r"part 'p': there is no file .*gone\.msh: check the path")
    refused(tmp_path, "there is no file")
    empty = tmp_path / "empty.msh"
    empty.write_text("nothing\n")
    refused(empty, r"part 'p': meshio cannot read .*empty\.msh \(.*\): say file_format= .* or convert")
    refused(empty, "Unknown file format 'wrong'", file_format="wrong")
    unnamed = tmp_path / "mesh.data"
    unnamed.write_text(SQUARES)
    refused(unnamed, "Could not deduce file format")
    assert len(Part.from_mesh("p", unnamed, file_format="gmsh")) == 3
    assert capsys.readouterr() == ("", "")


def test_a_missing_package_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "netCDF4", None)
    path = tmp_path / "mesh.exo"
    path.touch()
    refused(path, r"to read .*mesh\.exo, meshio needs netCDF4: python -m pip install netCDF4")


def test_unknown_cells_missing_points_and_infinite_coordinates_are_refused():
    points = np.eye(4, 3)
    cells = [[[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]]]
    refused(meshio.Mesh(points, [("polyhedron4", cells)]), "1 cells are of the type polyhedron4, which is not known")
    mesh = meshio.Mesh(points, [("triangle", [[0, 1, 2]]), ("tetra", [[0, 1, 2, 4]])])
    refused(
        mesh, r"part 'p', mesh: cell 1 \(tetra\) has the points \[0, 1, 2, 4\], and the mesh only those from 0 to 3"
    )
    points[3] = np.nan
    refused(
        meshio.Mesh(points, [("tetra", [[0, 1, 2, 3]])]), r"cell 0 \(tetra\) has a point whose coordinates are not fin"
    )
    assert len(Part.from_mesh("p", meshio.Mesh(points[:, :2], [("triangle", [[0, 1, 2]])]))) == 1
    mesh.points = np.zeros((2, 4))
    refused(mesh, r"points must be \(n, 1\), \(n, 2\) or \(n, 3\), got \(2, 4\)")
