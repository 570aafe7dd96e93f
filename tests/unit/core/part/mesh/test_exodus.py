"""Blocks and sets of Exodus files."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

from rbs_core import Part
from tests.unit.core.part.mesh.blocks import block

netCDF4 = pytest.importorskip("netCDF4", reason="meshio needs it for Exodus")


def letters(text, width=33):
    return np.frombuffer(text.encode().ljust(width, b"\0"), "S1")


@pytest.fixture
def path(tmp_path):
    """Three cubes in a row in two blocks, with two node sets and two side sets."""
    mesh = block(3, 1, 1)
    cells = mesh.cells[0].data
    mesh = meshio.Mesh(
        mesh.points,
        [("hexahedron", cells[:2]), ("hexahedron", cells[2:])],
        point_sets={"left": np.array([0, 4, 8, 12])},
    )
    path = tmp_path / "mesh.e"
    meshio.write(path, mesh, "exodus")
    return path


def names(part):
    return {name: nodes.tolist() for name, nodes in part.node_sets.items()}


def test_blocks_have_numbers(path):
    assert names(Part.from_mesh("p", path)) == {"left": [0], "block_0": [0, 1], "block_1": [2]}


def test_blocks_and_sides_have_names(path):
    with netCDF4.Dataset(path, "a") as file:
        file.createDimension("num_side_sets", 2)
        file.createVariable("eb_names", "S1", ("num_el_blk", "len_string"))[:] = [letters("steel"), letters("")]
        file.createVariable("ss_names", "S1", ("num_side_sets", "len_string"))[:] = [letters("ends"), letters("")]
        file.createVariable("ss_prop1", "i4", ("num_side_sets",))[:] = [10, 20]
        for number, elements in ((1, [1, 3, 3]), (2, [2])):
            file.createDimension(f"num_side_ss{number}", len(elements))
            file.createVariable(f"elem_ss{number}", "i4", (f"num_side_ss{number}",))[:] = elements
    part = Part.from_mesh("p", path)
    assert names(part) == {"left": [0], "steel": [0, 1], "block_1": [2], "ends": [0, 2], "side_set_20": [1]}
    assert len(Part.from_mesh("p", path, only="steel")) == 2


def test_node_sets_without_names_are_kept(path):
    with netCDF4.Dataset(path, "a") as file:
        file.renameVariable("ns_names", "other")
    assert names(Part.from_mesh("p", path)) == {"node_set_0": [0], "block_0": [0, 1], "block_1": [2]}
