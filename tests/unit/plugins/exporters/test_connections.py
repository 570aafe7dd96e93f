"""Bonds between two parts, as another program reads them."""

from __future__ import annotations

import numpy as np
import pytest
import pyvista

import rbs_core as rbs
from rbs_core import BadInput, intact
from rbs_core.part import Connection
from rbs_plugins import ConnectionExporter
from rbs_plugins.fields import displacement

PAIRS = [[1, 0], [1, 1], [2, 1]]


def glue(**options):
    """A row of three nodes, and two nodes above it in a system of their own, with bonds 1-0, 1-1 and 2-1."""
    above = rbs.world.child("above", origin=(0.0, 1.0, 0.0), axes=[(0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)])
    row = rbs.Part("row", rbs.Box(size=(3.0, 1.0))).discretize(1.0)
    lid = rbs.Part("lid", rbs.Everywhere(), dimension=2, system=above).place([[0.0, 0.0], [0.0, -1.0]], 1.0)
    return Connection(row, lid, pairs=PAIRS, name="glue", **options)


def read(path):
    """A file, and which of its cells are lines."""
    grid = pyvista.read(path)
    return grid, grid.celltypes == pyvista.CellType.LINE


@pytest.mark.parametrize("both", [True, False])
def test_points_lines_and_sizes(tmp_path, both):
    exporter = ConnectionExporter(glue(both=both), tmp_path / "glue")
    assert [part.name for part in exporter.parts] == ["row", "lid"]
    assert exporter.label == "ConnectionExporter 'glue' glue"
    assert repr(exporter).startswith("ConnectionExporter(glue, path=")
    rbs.Analysis([exporter]).run(steps=2, dt=1.0, progress=False)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["glue.pvd", "glue_000001.vtu"]
    grid, lines = read(tmp_path / "glue_000001.vtu")
    np.testing.assert_allclose(grid.points, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], atol=1e-15)
    assert grid["is_other"].tolist() == [0, 0, 1, 1]
    assert grid.point_data["node"].tolist() == [1, 2, 0, 1]
    assert grid.point_data["family_size"].tolist() == ([2, 1, 1, 2] if both else [2, 1, 0, 0])
    assert lines.tolist() == [False] * 4 + [True] * 3
    assert grid.cell_data["node"][lines].tolist() == [0, 0, 1]
    assert grid.cell_data["neighbor"][lines].tolist() == [2, 3, 3]
    np.testing.assert_allclose(grid["bond_length"][lines], [1.0, 2**0.5, 1.0])
    np.testing.assert_allclose(grid["bond_vector"][lines], [[0, 1, 0], [1, 1, 0], [0, 1, 0]], atol=1e-15)
    assert not grid["bond_length"][~lines].any()
    assert (grid["intact"] == 1).all()


def test_current_positions_and_the_system_of_each_part(tmp_path):
    connection = glue()
    row, lid = connection.ends
    row[displacement], lid[displacement] = (0.0, -1.0), (1.0, 0.0)
    exporter = ConnectionExporter(connection, tmp_path / "glue", configuration="current")
    assert (lid, displacement) in exporter.reads
    rbs.Analysis([exporter]).run(steps=1, dt=1.0, progress=False)
    grid, _ = read(tmp_path / "glue_000001.vtu")
    np.testing.assert_allclose(grid.points[:, 1], [-1, -1, 2, 2], atol=1e-15)


def test_broken_bonds(tmp_path):
    connection = glue()
    connection[intact] = [1, 0, 1, 1, 0, 1]  # from both ends: 1-0, 1-1, 2-1, 0-1, 1-1, 1-2
    ConnectionExporter(connection, tmp_path / "glue").write(tmp_path / "now.vtu")
    grid, lines = read(tmp_path / "now.vtu")
    assert grid["intact"][lines].tolist() == [1, 0, 1]


class Approach(rbs.Integrator):
    """Two parts come nearer, and their bonds are searched again."""

    updates = (displacement,)

    def __init__(self, part, connection):
        super().__init__(part)
        self.connection = connection
        connection.search_during_runs()

    def apply(self, clock):
        self[displacement][:, 0] = clock.step
        self.connection.search((self.part[displacement], np.zeros((4, 1))))


def test_bonds_that_come_during_a_run(tmp_path):
    left = rbs.Part("left", rbs.Box(size=4.0)).discretize(1.0)
    right = rbs.Part("right", rbs.Box(size=4.0, center=6.0)).discretize(1.0)
    with pytest.warns(UserWarning, match="has no bond"):
        connection = Connection(left, right, horizon=2.0)
    exporter = ConnectionExporter(connection, tmp_path / "gap", configuration="current", when=rbs.always)
    exporter.write(tmp_path / "none.vtu")
    assert pyvista.read(tmp_path / "none.vtu").n_points == 0
    rbs.Analysis([Approach(left, connection), exporter]).run(steps=2, dt=1.0, progress=False)
    found = [read(tmp_path / f"gap_00000{step}.vtu") for step in (1, 2)]
    assert [np.count_nonzero(lines) for _, lines in found] == [1, 3]
    assert found[1][0]["bond_length"].max() == 2.0


def test_bonds_within_one_part(tmp_path):
    part = rbs.Part("plate", rbs.Box(size=(3.0, 2.0))).discretize(1.0)
    connection = Connection(part, pairs=[[0, 5], [5, 1], [1, 5]])
    ConnectionExporter(connection, tmp_path / "within").write(tmp_path / "now.vtu")
    grid, lines = read(tmp_path / "now.vtu")
    assert grid.point_data["node"].tolist() == [0, 1, 5]
    assert not grid["is_other"].any()
    assert grid["neighbor"][lines].tolist() == [2, 2]
    assert grid["node"][lines].tolist() == [0, 1]


def test_what_is_no_connection_is_refused(tmp_path):
    for given in (None, "glue", glue().ends[0]):
        with pytest.raises(BadInput, match=r"is no connection: give a Connection\(part, other, \.\.\.\)"):
            ConnectionExporter(given, tmp_path / "glue")
    with pytest.raises(BadInput, match="configuration='past' must be one of"):
        ConnectionExporter(glue(), tmp_path / "glue", configuration="past")
