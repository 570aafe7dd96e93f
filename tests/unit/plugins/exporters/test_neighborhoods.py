"""Sizes of families and bonds of examples, as another program reads them."""

from __future__ import annotations

import numpy as np
import pytest
import pyvista

import rbs_core as rbs
from rbs_core import BadInput, MissingField
from rbs_plugins import NeighborhoodExporter
from rbs_plugins.fields import displacement


def plate(storage="lattice"):
    """5 x 3 nodes, each bonded to those beside it: families of 2, 3 and 4."""
    return rbs.Part("plate", rbs.Box(size=(5.0, 3.0))).discretize(1.0).connect(1.0, storage=storage)


def read(path):
    """A file, and its lines as an array of (node, neighbor)."""
    grid = pyvista.read(path)
    lines = grid.celltypes == pyvista.CellType.LINE
    return grid, np.stack([grid["node"][lines], grid["neighbor"][lines]], axis=1), lines


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_sizes_and_an_example_of_each(tmp_path, storage):
    part = plate(storage)
    rbs.Analysis([NeighborhoodExporter(part, tmp_path / "families")]).run(steps=3, dt=1.0, progress=False)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["families.pvd", "families_000001.vtu"]
    grid, lines, is_line = read(tmp_path / "families_000001.vtu")
    sizes = part.bonds.counts()
    assert np.array_equal(grid["family_size"], sizes)
    assert np.array_equal(grid["missing_neighbors"], 4 - sizes)
    assert not grid["broken_bonds"].any()
    corner, side, middle = 0, int(np.flatnonzero(sizes == 3)[0]), int(np.flatnonzero(sizes == 4)[0])
    assert np.flatnonzero(grid["chosen"]).tolist() == sorted([corner, side, middle])
    bonds = {(node, int(other)) for node in (corner, side, middle) for other in part.bonds.neighbors(node)}
    assert {tuple(line) for line in lines.tolist()} == bonds
    assert len(lines) == 2 + 3 + 4
    vectors = part.positions[lines[:, 1]] - part.positions[lines[:, 0]]
    np.testing.assert_allclose(grid["bond_vector"][is_line][:, :2], vectors, atol=1e-15)
    np.testing.assert_allclose(grid["bond_length"][is_line], 1.0)
    assert (grid["intact"] == 1).all()
    # vertices: one for each node, in front of the lines
    assert grid.n_cells == 15 + 9
    assert grid["node"][:15].tolist() == list(range(15))
    assert (grid["neighbor"][:15] == -1).all()
    assert not grid["bond_length"][:15].any()


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_broken_bonds(tmp_path, storage):
    part = plate(storage)
    part.bonds.cut(rbs.Segment((0.5, -1.0), (0.5, 1.0)))
    NeighborhoodExporter(part, tmp_path / "a", of=rbs.Everywhere()).write(tmp_path / "a.vtu")
    grid, lines, is_line = read(tmp_path / "a.vtu")
    crosses = np.prod(part.positions[lines][:, :, 0] - 0.5, axis=1) < 0
    assert np.array_equal(grid["intact"][is_line], ~crosses)
    assert np.array_equal(grid["broken_bonds"], np.bincount(lines[crosses, 0], minlength=15))
    assert np.count_nonzero(grid["broken_bonds"]) == 6
    assert np.array_equal(grid["family_size"], part.bonds.counts())
    assert len(lines) == len(part.bonds)
    assert grid["chosen"].all()


def test_bonds_of_a_region_and_of_a_node_set(tmp_path):
    part = plate()
    part.node_sets["corner"] = [0]
    for of, nodes in ((rbs.HalfSpace((1.5, 0.0), normal=(1.0, 0.0)), [4, 9, 14]), ([7], [7]), ("corner", [0])):
        NeighborhoodExporter(part, tmp_path / "a", of=of).write(tmp_path / "a.vtu")
        _, lines, _ = read(tmp_path / "a.vtu")
        assert np.unique(lines[:, 0]).tolist() == nodes
    with pytest.raises(BadInput, match="has no node set 'corners': the nearest names are corner"):
        NeighborhoodExporter(part, tmp_path / "a", of="corners")
    with pytest.raises(BadInput, match="no node of part 'plate' lies in"):
        NeighborhoodExporter(part, tmp_path / "a", of=rbs.Nowhere())


def test_current_positions(tmp_path):
    part = plate()
    part[displacement] = lambda X: 0.5 * X
    NeighborhoodExporter(part, tmp_path / "a", configuration="current").write(tmp_path / "a.vtu")
    grid, _, is_line = read(tmp_path / "a.vtu")
    np.testing.assert_allclose(grid.points[:, :2], 1.5 * part.positions)
    np.testing.assert_allclose(grid["bond_length"][is_line], 1.5)


@pytest.mark.filterwarnings("ignore:part 'dots'.*have no bond")
def test_nodes_without_bonds(tmp_path):
    part = rbs.Part("dots", rbs.Everywhere(), dimension=1).place([[0.0], [1.0], [9.0]], 1.0).connect(1.0)
    NeighborhoodExporter(part, tmp_path / "a").write(tmp_path / "a.vtu")
    grid, lines, _ = read(tmp_path / "a.vtu")
    assert grid["family_size"].tolist() == [1, 1, 0]
    assert grid["chosen"].tolist() == [1, 0, 1]
    assert lines.tolist() == [[0, 1]]
    part = rbs.Part("dots", rbs.Everywhere(), dimension=1).place([[0.0], [5.0]], 1.0).connect(1.0)
    NeighborhoodExporter(part, tmp_path / "a").write(tmp_path / "a.vtu")
    assert read(tmp_path / "a.vtu")[0].n_cells == 2


def test_a_part_without_bonds_is_refused(tmp_path):
    part = rbs.Part("plate", rbs.Box(size=(5.0, 3.0))).discretize(1.0)
    with pytest.raises(MissingField, match=r"has no bonds: call part.connect"):
        NeighborhoodExporter(part, tmp_path / "a")


def test_it_is_written_once_unless_asked_for_more(tmp_path):
    part = plate()
    exporter = NeighborhoodExporter(part, tmp_path / "a", when=rbs.every(2))
    rbs.Analysis([exporter]).run(steps=4, dt=1.0, progress=False)
    assert sorted(path.name for path in tmp_path.glob("*.vtu")) == ["a_000002.vtu", "a_000004.vtu"]
