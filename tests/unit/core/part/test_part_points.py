"""Parts made of points and meshes from elsewhere: what a run makes of them."""

from __future__ import annotations

import numpy as np
import pytest

from rbs_core import Analysis, BadInput, Checkpoint, CoordinateSystem, Everywhere, Part, every, volume
from rbs_plugins import BondBased, BoundaryDomain, VelocityVerlet
from rbs_plugins.fields import density, displacement
from tests.unit.core.part.mesh.blocks import block


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_points_bring_their_dimension(dimension):
    points = np.arange(12.0).reshape(-1, dimension)
    part = Part.from_points("cloud", points, 0.5, spacing=2.0, precision="single")
    assert (part.dimension, part.spacing, part.precision, len(part)) == (dimension, 2.0, "single", len(points))
    assert isinstance(part.geometry, Everywhere)
    assert np.array_equal(part.positions, points)
    assert (part[volume] == 0.5).all()
    part.connect(9.0)
    assert part.bonds.storage == "list"


def test_more_about_points():
    turned = CoordinateSystem("turned")
    part = Part.from_points("bar", [0.0, 1.0, 3.0], [1.0, 2.0, 3.0], area=0.2, system=turned)
    assert (part.dimension, part.area, part.system) == (1, 0.2, turned)
    assert part[volume].tolist() == [1.0, 2.0, 3.0]
    assert Part.from_points("sheet", [[0.0, 1.0]], [1.0], thickness=0.1).thickness == 0.1


@pytest.mark.parametrize(
    ("points", "volumes", "text"),
    [
        (np.zeros((2, 4)), 1.0, r"part 'p': points must be \(n, d\) with d = 1, 2 or 3, got \(2, 4\)"),
        (np.zeros((2, 1, 1)), 1.0, r"got \(2, 1, 1\)"),
        (1.0, 1.0, r"points must be \(n, d\)"),
        (np.zeros((0, 2)), 1.0, r"points must be \(n, 2\) with n > 0"),
        ([0.0, 1.0], [1.0, 0.0], r"node 1 at \[1.0\] has no positive volume \(0 m\^3\): give it one"),
        ([0.0, 1.0], [1.0, -2.0], r"node 1 at \[1.0\] has no positive volume \(-2 m\^3\)"),
        ([0.0, 1.0], [1.0, 2.0, 3.0], "'volume' needs shape"),
        ([0.0, np.nan], 1.0, r"points\[1, 0\] = nan is not finite"),
    ],
)
def test_wrong_points_are_refused(points, volumes, text):
    with pytest.raises(BadInput, match=text):
        Part.from_points("p", points, volumes)


# -- a run ----------------------------------------------------------------------------------------------------------


def scene(path) -> tuple[Analysis, Part]:
    """A bar of a mesh, held at one node set and pulled at another."""
    ends = {"held": list(range(0, 63, 7))}, {"pulled": [[5, 11, 17, 23]]}
    mesh = block(6, 2, 2, point_sets=ends[0], cell_sets=ends[1])
    part = Part.from_mesh("bar", mesh, scale=1e-3).connect(2.2e-3)
    part[density] = 1000.0
    held = BoundaryDomain(part, "held", velocity=(0.0, 0.0, 0.0))
    pulled = BoundaryDomain(part, "pulled", velocity=(1.0, None, None))
    verlet, steel = VelocityVerlet(part), BondBased(part, E=1e9)
    relations = [verlet.kick, held, pulled, verlet.drift, steel, verlet.kick, Checkpoint(path, when=every(5))]
    return Analysis(relations, dt=1e-8), part


def test_node_sets_are_regions_of_boundary_domains():
    analysis, part = scene("unused.npz")
    held, pulled = analysis.relations[1:3]
    assert held.nodes.tolist() == [0, 6, 12, 18]
    assert pulled.nodes.tolist() == part.node_sets["pulled"].tolist() == [5, 11, 17, 23]
    assert repr(held) == "BoundaryDomain(bar, region='held', velocity=(0.0, 0.0, 0.0))"
    with pytest.raises(BadInput, match="part 'bar' has no node set 'pullled': the nearest names are pulled"):
        BoundaryDomain(part, "pullled", velocity=(1.0, None, None))


def test_runs_of_meshes_go_on_to_the_bit(tmp_path):
    whole, part = scene(tmp_path / "whole.npz")
    whole.run(steps=12, progress=False)
    first, _ = scene(tmp_path / "broken.npz")
    first.run(steps=7, progress=False)
    second, again = scene(tmp_path / "broken.npz")
    report = second.run(steps=12, resume=tmp_path / "broken.npz", progress=False)
    assert report.steps == 7  # from the checkpoint of step 5
    assert np.array_equal(again[displacement], part[displacement])
    assert np.abs(part[displacement]).max() > 0
