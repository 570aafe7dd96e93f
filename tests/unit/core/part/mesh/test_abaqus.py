"""Element sets of Abaqus files."""

from __future__ import annotations

import pytest

from rbs_core import Part
from rbs_core.part.mesh import abaqus

# Three squares over two triangles each: some blocks with a set, one without, one set over two blocks.
FILE = """*HEADING
** a comment, with a comma
*NODE
1, 0, 0
2, 1, 0
3, 2, 0
4, 0, 1
5, 1, 1
6, 2, 1
7, 3, 0
8, 3, 1
*ELEMENT, TYPE=CPS3
10, 1, 2, 4
11, 2, 5, 4
*Element, type=CPS4, ELSET=Right
20, 2, 3, 6, 5
*ELEMENT, TYPE=CPS3, ELSET=Right
30, 3, 7,
6
31, 7, 8, 6
*NSET, NSET=BOTTOM
1, 2, 3,
7
*ELSET, ELSET=steps, GENERATE
10, 30, 10
*ELSET, ELSET=listed, INTERNAL
11, 20,
99
*ELSET, ELSET=both
listed, 31
*MATERIAL, NAME=STEEL
"""
CELL_SETS = {"Right": [2, 3, 4], "steps": [0, 2, 3], "listed": [1, 2], "both": [1, 2, 4]}


def file(folder, text=FILE):
    path = folder / "mesh.inp"
    path.write_text(text)
    return path


def test_sets_have_the_cells_that_the_file_says(tmp_path):
    found = abaqus.cell_sets(file(tmp_path), [(2, 3), (1, 4), (2, 3)])
    assert {name: cells.tolist() for name, cells in found.items()} == CELL_SETS


def test_they_are_the_node_sets_of_a_part(tmp_path):
    part = Part.from_mesh("p", file(tmp_path))
    assert len(part) == 5
    assert {name: nodes.tolist() for name, nodes in part.node_sets.items()} == {**CELL_SETS, "BOTTOM": [0, 2, 3]}


@pytest.mark.parametrize(
    "text",
    [FILE.replace("31, 7, 8, 6", "30, 7, 8, 6"), FILE.replace("*MATERIAL", "*INCLUDE, INPUT=gone.inp\n*MATERIAL")],
    ids=["numbers twice", "includes"],
)
def test_sets_that_cannot_be_told_are_left_out(text, tmp_path):
    (tmp_path / "gone.inp").write_text("*HEADING\n")
    with pytest.warns(UserWarning, match=r"mesh\.inp: its element sets are left out: the file includes others, or"):
        part = Part.from_mesh("p", file(tmp_path, text))
    assert list(part.node_sets) == ["BOTTOM"]


def test_files_that_meshio_reads_otherwise_are_told(tmp_path):
    assert abaqus.cell_sets(file(tmp_path), [(2, 3), (1, 4)]) is None
    assert abaqus.cell_sets(file(tmp_path), [(2, 3), (2, 4), (1, 3)]) is None
