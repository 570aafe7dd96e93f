"""Layers of nodes beyond the body."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, Box, Part, is_fictitious, volume
from rbs_plugins import BondBased, BoundaryDomain, CriticalStretch, VelocityVerlet
from rbs_plugins.fields import density, displacement


def body(dimension, n=5, **options):
    """A box of n cells of 1 m along each axis, the last one longer by 1."""
    shape = (*(dimension - 1) * [float(n)], n + 1.0)
    part = Part("body", Box(size=shape))
    return part.discretize(1.0, **options)


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_a_side_is_continued_along_the_grid(dimension):
    part = body(dimension)
    before, size = part.positions.copy(), len(part)
    axis = "xyz"[dimension - 1]
    layer = part.extend("clamp", f"-{axis}", thickness=3.015)
    across = size // 6
    assert (len(layer), len(part), part.body.size) == (3 * across, size + 3 * across, size)
    assert np.array_equal(part.positions[part.body], before)
    bottom = part.positions[layer.nodes]
    assert sorted(set(bottom[:, -1])) == [-5.5, -4.5, -3.5]
    assert set(map(tuple, bottom[:, :-1])) == set(map(tuple, before[:, :-1]))
    assert part[is_fictitious].sum() == len(layer)
    assert (part[volume] == 1.0).all()
    part.connect(3.015, storage="lattice")
    wide = Part("wide", part.geometry | Box.between(*np.stack([bottom.min(0) - 0.5, bottom.max(0) + 0.5])))
    wide.discretize(1.0).connect(3.015, storage="lattice")
    assert np.allclose(wide.positions, part.positions, atol=1e-14)
    assert np.array_equal(wide.bonds.counts(), part.bonds.counts())


def test_layers_follow_one_another_and_leave_corners_free():
    part = body(2, thickness=0.5)
    part.node_sets["edge"] = part.positions[:, 0] > 1.5
    edge = part.positions[part.where("edge")].copy()
    left, top = part.extend("left", "-x", 2.0), part.extend("top", "+y", 1.0)
    assert (len(left), len(top), len(part)) == (12, 5, 47)
    assert np.array_equal(part.positions[part.where("edge")], edge)
    assert np.array_equal(part.where(left), part.where("left"))
    assert (part.positions[left.nodes, 0] < -2.5).all()
    assert (part.positions[part.where(top), 1] == 3.5).all()
    assert np.array_equal(part.where("body"), part.body)
    assert np.array_equal(np.sort(np.concatenate([part.body, left.nodes, top.nodes])), np.arange(47))
    assert (part[volume] == 0.5).all()
    assert part.connect(3.0, storage="lattice").bonds.storage == "lattice"


def test_several_sides_at_once_fill_their_corners():
    part = body(2)
    rim = part.extend("rim", ("-x", "+x", "-y", "+y"), 2.0)
    assert len(rim) == 9 * 10 - 30
    assert part.connect(2.0).bonds.counts()[part.body].tolist() == [12] * 30


def test_a_geometry_is_filled_along_the_grid():
    part = body(2)
    ring = part.extend("ring", Box(size=(7.0, 8.2)) - part.geometry)
    assert len(ring) == 7 * 8 - 30
    assert (np.abs(part.positions * 2 % 1) < 1e-12).all()


def test_what_has_been_cut_out_is_continued_too():
    """An L: the uppermost nodes are those of one leg."""
    part = Part("L", Box(size=(4.0, 4.0)) - Box(size=(2.0, 2.0), center=(1.0, 1.0))).discretize(1.0)
    top = part.extend("top", "+y", 1.0)
    assert part.positions[top.nodes].tolist() == [[-1.5, 2.5], [-0.5, 2.5]]


@pytest.mark.parametrize("moved", [False, True])
def test_points_from_elsewhere(moved, rng):
    points = body(2).positions + 0.1 * rng.random((30, 2))
    if moved:
        part = body(2)
        part[rbs.reference_position] = points
    else:
        part = Part.from_points("cloud", points, np.linspace(1.0, 2.0, 30), spacing=1.0)
    sizes = part[volume].copy()
    layer = part.extend("left", "-x", 3.0)
    assert (layer.nodes == np.arange(30, 48)).all()
    assert np.array_equal(part.positions[:30], points)
    outer = points[:, 0] < -1.5
    assert np.allclose(part.positions[30:33], points[outer][0] - [[1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])
    assert np.array_equal(part[volume][30:33], sizes[outer][[0, 0, 0]])
    assert part.grid is None
    grip = part.extend("grip", Box(size=(2.0, 6.0), center=(3.6, 0.0)))
    assert part.positions[grip.nodes].min(axis=0).tolist() == pytest.approx([3.1, -2.5])
    nail = part.extend("nail", rbs.grids.Cloud([[0.0, 9.0], [1.0, 9.0]], [0.5, 0.5]))
    assert part[volume][nail.nodes].tolist() == [0.5, 0.5]
    assert part.connect(3.0).bonds.storage == "list"


def test_a_layer_is_a_region_and_the_body_may_break():
    part = body(2)
    clamp, grip = part.extend("clamp", "-x", 3.0), part.extend("grip", "+x", 3.0)
    part.connect(3.0)
    part[density] = 1.0
    force = BondBased(part, E=1.0, fracture=CriticalStretch(0.01, within="body"))
    held = BoundaryDomain(part, clamp, velocity=(0.0, 0.0))
    pulled = BoundaryDomain(part, grip, velocity=(lambda time: 0.05, None))
    assert np.array_equal(held.nodes, clamp.nodes)
    assert "FictitiousLayer 'clamp' of part 'body'" in repr(held)
    rbs.Analysis(VelocityVerlet(part).step([force], [held, pulled])).run(steps=40, progress=False)
    assert part[displacement][grip.nodes, 0].min() > 0.0
    offsets, ends = part.bonds.as_rows()
    starts = np.repeat(np.arange(len(part)), np.diff(offsets))
    broken = ~part.bonds.intact
    assert broken.any()
    assert not part[is_fictitious][starts[broken]].any()
    assert not part[is_fictitious][ends[broken]].any()


def test_wrong_layers_are_refused():
    part = body(2)
    cases = [
        (("left", "-z", 3.0), r"part 'body' has no side '-z': "),
        (("left", "-x"), r"thickness=None must be positive and finite, such as the horizon"),
        (("left", "-x", 0.9), r"a layer of 0.9 m is thinner than the spacing 1 m"),
        (("left", Box(size=(3.0, 3.0)), 3.0), r"thickness= is for a side such as '-x'"),
        (("left", Box(size=(9.0, 3.0))), r"20 nodes of the layer would lie on those of the body, the first on node 5"),
        (("left", rbs.Nowhere()), r"infinite|empty|bounded"),
        (("left", rbs.HalfSpace((9.0, 0.0), (1.0, 0.0))), r"no grid fills infinite space"),
        (("left", Box(size=0.1)), r"is 2-D, but Box\(.* has 1"),
        (("left", Box(size=(0.2, 0.2), center=(9.0, 9.0))), r"no node of the layer lies in Box"),
        (("left", 3.0, 3.0), r"a layer lies on a side such as '-x', in a geometry or a grid, got 3.0"),
        (("body", "-x", 3.0), r"the name of a layer must be a text that no node set has yet, got 'body'"),
        ((7, "-x", 3.0), r"got 7"),
    ]
    for given, text in cases:
        with pytest.raises(BadInput, match=text):
            part.extend(*given)
    assert (len(part), part.extended, list(part.node_sets)) == (30, False, [])
    left = part.extend("left", "-x", 1.0)
    with pytest.raises(BadInput, match="2 nodes of the layer would lie on those of another layer"):
        part.extend("more", Box.between((-3.4, -1.0), (-2.6, 1.0)))
    with pytest.raises(BadInput, match="got 'left'"):
        part.extend("left", "+x", 1.0)
    with pytest.raises(BadInput, match=r"<FictitiousLayer 'left' of part 'body'> is of another part"):
        body(2).where(left)
    part[density] = 1.0
    with pytest.raises(BadInput, match="new nodes would have no density: extend it before these are set"):
        part.extend("right", "+x", 1.0)
    with pytest.raises(BadInput, match="is connected, and a new layer would have no bonds: extend it before connect"):
        part.connect(1.0).extend("right", "+x", 1.0)
    part.discretize(1.0)
    assert not part.extended
    with pytest.raises(BadInput, match="no node set 'left'"):
        len(left)
    part.node_sets["body"] = [0]
    with pytest.raises(BadInput, match="its node set 'body' would be replaced"):
        part.extend("left", "-x", 1.0)
    cloud = Part.from_points("cloud", [0.0, 1.0], 1.0)
    for where in ("-x", Box(size=1.0, center=3.0)):
        with pytest.raises(BadInput, match="part 'cloud' has no spacing"):
            cloud.extend("left", where, 1.0 if where == "-x" else None)
