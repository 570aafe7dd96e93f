"""Which representation a part gets."""

from __future__ import annotations

import pytest

import rbs_core as rbs
from rbs_core import BadInput, Ball, Box, Part


def test_grids_become_lattices_and_clouds_lists():
    grid = Part("grid", Box(size=(4.0, 4.0))).discretize(1.0)
    cloud = Part("cloud", Box(size=(4.0, 4.0))).place(grid.positions, 1.0, spacing=1.0)
    assert grid.connect(1.5).bonds.storage == "lattice"
    assert "stored as lattice" in repr(grid)
    assert cloud.connect(1.5).bonds.storage == "list"


def test_nodes_that_were_moved_off_the_grid_are_a_cloud():
    part = Part("grid", Box(size=(4.0, 4.0))).discretize(1.0)
    part.positions[0] += 0.01
    assert part.connect(1.5).bonds.storage == "list"
    with pytest.raises(BadInput, match="nodes are not those of a regular grid, which storage='lattice' needs"):
        part.connect(1.5, storage="lattice")


def test_only_nodes_of_a_uniform_grid_become_lattices():
    square = Box(size=(4.0, 4.0))
    grid = rbs.grids.uniform((-2.0, -2.0), (2.0, 2.0), 0.5)
    assert Part("given", square).discretize(grid).connect(1.5).bonds.storage == "lattice"
    assert Part("some", square).discretize(grid.where(lambda x: x[:, 0] > 0)).connect(1.5).bonds.storage == "lattice"
    for other in (
        rbs.grids.jittered(grid, 0.1),
        rbs.grids.disk(2.0, 0.5),
        rbs.grids.rotated((-2.0, -2.0), (2.0, 2.0), 0.5, 0.3),
        grid.with_axis(0, edges=rbs.grids.edges(-2.0, 2.0, 0.4, growth=1.1)),
    ):
        part = Part("other", square).discretize(other)
        assert part.connect(1.5).bonds.storage == "list"
        with pytest.raises(BadInput, match="nodes are not those of a regular grid"):
            part.connect(1.5, storage="lattice")


def test_a_thin_ring_is_a_list_unless_somebody_wants_a_lattice():
    ring = Part("ring", Ball(20.0, (0.0, 0.0)) - Ball(18.5, (0.0, 0.0))).discretize(1.0)
    assert ring.connect(1.5).bonds.storage == "list"
    assert ring.connect(1.5, storage="lattice").bonds.storage == "lattice"


def test_an_unknown_storage():
    with pytest.raises(BadInput, match="storage='tree' must be one of list, lattice or None"):
        Part("bar", Box(size=4.0)).discretize(1.0).connect(1.5, storage="tree")
