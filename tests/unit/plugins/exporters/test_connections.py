"""Bonds between two parts, as another program reads them, from any object that has them."""

from __future__ import annotations

import logging

import numpy as np
import pytest
import pyvista

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import ConnectionExporter
from rbs_plugins.exporters.connections import Connected, GivenRows
from rbs_plugins.fields import displacement


def parts():
    """A row of three nodes, and two nodes above it in a system of their own."""
    above = rbs.world.child("above", origin=(0.0, 1.0, 0.0))
    row = rbs.Part("row", rbs.Box(size=(3.0, 1.0))).discretize(1.0)
    lid = rbs.Part("lid", rbs.Everywhere(), dimension=2, system=above).place([[0.0, 0.0], [1.0, 0.0]], 1.0)
    return row, lid


class Glue:
    """A stand-in for whatever connects parts."""

    def __init__(self, part, other):
        self.part, self.other = part, other

    def as_rows(self):
        """Node 1 leads to 0 and 1, node 2 to 1."""
        return np.array([0, 0, 2, 3]), np.array([0, 1, 1], np.uint32)


def test_points_lines_and_sizes(tmp_path):
    row, lid = parts()
    assert isinstance(Glue(row, lid), Connected)
    exporter = ConnectionExporter(row, Glue(row, lid), tmp_path / "glue")
    assert exporter.parts == [row, lid]
    rbs.Analysis([exporter]).run(steps=2, dt=1.0, progress=False)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["glue.pvd", "glue_000001.vtu"]
    grid = pyvista.read(tmp_path / "glue_000001.vtu")
    np.testing.assert_allclose(grid.points, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], atol=1e-15)
    assert grid["is_other"].tolist() == [0, 0, 1, 1]
    assert grid["node"][:4].tolist() == [0, 1, 2, 3]
    assert grid.point_data["node"].tolist() == [1, 2, 0, 1]
    assert grid.point_data["family_size"].tolist() == [2, 1, 1, 2]
    lines = grid.celltypes == pyvista.CellType.LINE
    assert grid.cell_data["node"][lines].tolist() == [0, 0, 1]
    assert grid.cell_data["neighbor"][lines].tolist() == [2, 3, 3]
    np.testing.assert_allclose(grid["bond_length"][lines], [1.0, 2**0.5, 1.0])
    np.testing.assert_allclose(grid["bond_vector"][lines], [[0, 1, 0], [1, 1, 0], [0, 1, 0]], atol=1e-15)
    assert not grid["bond_length"][~lines].any()
    assert lines.tolist() == [False] * 4 + [True] * 3


def test_current_positions_of_both_parts(tmp_path):
    row, lid = parts()
    row[displacement], lid[displacement] = (0.0, -1.0), (0.0, 1.0)
    exporter = ConnectionExporter(row, Glue(row, lid), tmp_path / "glue", configuration="current")
    assert (lid, displacement) in exporter.reads
    rbs.Analysis([exporter]).run(steps=1, dt=1.0, progress=False)
    grid = pyvista.read(tmp_path / "glue_000001.vtu")
    np.testing.assert_allclose(grid.points[:, 1], [-1, -1, 2, 2], atol=1e-15)


def test_it_writes_without_a_run_from_given_rows(tmp_path):
    row, lid = parts()
    given = GivenRows(row, lid, [0, 1, 1, 1], [1])
    assert repr(given) == "GivenRows(row, lid, 1 bonds)"
    ConnectionExporter(row, given, tmp_path / "glue").write(tmp_path / "now.vtu")
    grid = pyvista.read(tmp_path / "now.vtu")
    assert (grid.n_points, grid.n_cells) == (2, 3)


def test_no_bonds_are_said_once(tmp_path, caplog):
    row, lid = parts()
    exporter = ConnectionExporter(row, GivenRows(row, lid, [0, 0, 0, 0], []), tmp_path / "glue", when=rbs.always)
    with caplog.at_level(logging.WARNING, logger="rbs"):
        rbs.Analysis([exporter]).run(steps=2, dt=1.0, progress=False)
    assert [record.message for record in caplog.records] == [
        "ConnectionExporter 'row' glue: no node of 'row' is bonded to 'lid'"
    ]
    assert pyvista.read(tmp_path / "glue_000002.vtu").n_points == 0


@pytest.mark.parametrize(
    ("offsets", "neighbors", "message"),
    [
        ([0, 1], [0], "must be 4 numbers that rise from 0"),
        ([0, 1, 2, 3], [0], "to the number of bonds, 1"),
        ([1, 1, 1, 1], [0], "must be 4 numbers"),
        ([0, 2, 1, 3], [0, 1, 0], "must be 4 numbers"),
        ([0, 1, 1, 1], [2], "leads to node 2 of part 'lid', which has the nodes 0 to 1"),
        ([0, 1, 1, 1], [-1], "leads to node -1"),
    ],
)
def test_rows_that_do_not_fit_are_refused_before_the_run(tmp_path, offsets, neighbors, message):
    row, lid = parts()
    analysis = rbs.Analysis([ConnectionExporter(row, GivenRows(row, lid, offsets, neighbors), tmp_path / "glue")])
    with pytest.raises(BadInput, match=message):
        analysis.prepare()


def test_what_is_no_connection_is_refused(tmp_path):
    row, lid = parts()
    for given in (lid, None, GivenRows(row, "lid", [0, 0, 0, 0], [])):
        with pytest.raises(BadInput, match=r"is no connection: it needs part, other and as_rows\(\)"):
            ConnectionExporter(row, given, tmp_path / "glue")
    with pytest.raises(BadInput, match="belongs to part 'row': give that one in front of it"):
        ConnectionExporter(lid, Glue(row, lid), tmp_path / "glue")
