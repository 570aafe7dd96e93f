"""The growth of families: uniform strain, rigid motion, rules for the weighted volume, connections."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import Connection
from rbs_plugins import Dilatation
from rbs_plugins.constitutive.influence import FUNCTIONS
from rbs_plugins.fields import dilatation, displacement, intact, inverse_weighted_volume

DX = 0.1


def block(dimension=2, n=9, storage=None, name="block", center=0.0):
    middle = [center] + [0.0] * (dimension - 1)
    part = rbs.Part(name, rbs.Box(size=(n * DX,) * dimension, center=middle)).discretize(DX)
    return part.connect(3.015 * DX, storage=storage)


def run(*relations):
    return rbs.Analysis(list(relations)).run(steps=1, dt=1e-9, force_dt=True, progress=False)


@pytest.mark.parametrize("storage", ["list", "lattice"])
@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_uniform_growth(dimension, storage):
    """Every bond grows by the same share, so the family grows by d times it, whatever is missing at the surface."""
    part = block(dimension, 7, storage)
    part[displacement] = 1e-3 * part.positions
    run(Dilatation(part))
    np.testing.assert_allclose(part[dilatation], dimension * 1e-3, rtol=1e-11)


@pytest.mark.parametrize("influence", [each for each in FUNCTIONS if each != "double_hyperbolic"])
def test_the_trace_of_a_strain_in_the_bulk(influence):
    """A square grid has the fourfold symmetry that the second moment of a family needs: exact in first order."""
    part = block(2, 9)
    part[displacement] = part.positions @ np.array([[3e-7, 1e-7], [2e-7, -1e-7]])
    run(Dilatation(part, influence))
    middle = np.linalg.norm(part.positions, axis=1) < DX
    np.testing.assert_allclose(part[dilatation][middle], 2e-7, rtol=1e-5)


def test_a_rotation_is_no_growth():
    part = block()
    c, s = np.cos(1.0), np.sin(1.0)
    part[displacement] = part.positions @ (np.array([[c, s], [-s, c]]) - np.eye(2))
    run(Dilatation(part))
    assert np.abs(part[dilatation]).max() < 1e-13


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_weighted_volumes_by_hand(storage):
    part = block(2, 7, storage)
    part[displacement] = 0.0
    made = Dilatation(part, "inverse")
    assert made.rule == "initial"
    run(made)
    middle = int(np.linalg.norm(part.positions, axis=1).argmin())
    lengths = np.linalg.norm(part.positions[part.bonds.neighbors(middle)] - part.positions[middle], axis=1)
    m = float((3.015 * DX / lengths * lengths**2).sum()) * part[rbs.volume][0]
    assert 1.0 / part[inverse_weighted_volume][middle] == pytest.approx(m, rel=1e-13)


def test_the_full_family_is_the_integral():
    for dimension, around in ((1, 2.0), (2, 2 * np.pi), (3, 4 * np.pi)):
        part = block(dimension, 5)
        part[displacement] = 0.0
        run(Dilatation(part, weighted_volume="full"))
        m = around * (3.015 * DX) ** (dimension + 2) / (dimension + 2)
        np.testing.assert_allclose(1.0 / part[inverse_weighted_volume], m, rtol=1e-10)


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_what_broken_bonds_leave_behind(storage):
    """Behind a cut, "initial" families have lost part of their growth, "intact" ones see what is left of them."""
    found = {}
    for rule in ("initial", "intact"):
        part = block(2, 8, storage)
        part.bonds.cut(rbs.Segment((-9.0, 0.0), (9.0, 0.0)))
        part[displacement] = 1e-3 * part.positions
        run(Dilatation(part, weighted_volume=rule))
        found[rule] = part[dilatation].copy()
    near = np.abs(part.positions[:, 1]) < DX
    np.testing.assert_allclose(found["intact"], 2e-3, rtol=1e-11)
    assert (found["initial"][near] < 1.6e-3).all()


def test_weighted_volumes_follow_bonds_that_break_during_a_run():
    part = block(2, 8)
    part[displacement] = 1e-3 * part.positions

    class Tear(rbs.Constitutive):
        updates, storages = (intact,), ("list", "lattice")

        def apply(self, clock):
            if clock.step == 2:
                part.bonds.cut(rbs.Segment((-9.0, 0.0), (9.0, 0.0)))

    made = Dilatation(part, weighted_volume="intact")
    rbs.Analysis([Tear(part), made]).run(steps=3, dt=1e-9, force_dt=True, progress=False)
    np.testing.assert_allclose(part[dilatation], 2e-3, rtol=1e-11)


def test_bonds_of_a_connection_count_for_both_parts():
    """Two halves with a connection have the families of the whole."""
    whole = block(2, 8, "list", "whole")
    halves = []
    for name, x in (("left", -0.2), ("right", 0.2)):
        part = rbs.Part(name, rbs.Box(size=(4 * DX, 8 * DX), center=(x, 0.0))).discretize(DX)
        halves.append(part.connect(3.015 * DX))
    field = np.array([[2e-3, 1e-3], [0.0, 1e-3]])
    for part in (whole, *halves):
        part[displacement] = part.positions @ field
    run(Dilatation(whole))
    link = Connection(*halves, horizon=3.015 * DX)
    own = [Dilatation(part) for part in halves]
    run(*own, Dilatation(link, within=own))
    for part in halves:
        order = [int(np.linalg.norm(whole.positions - x, axis=1).argmin()) for x in part.positions]
        np.testing.assert_allclose(part[dilatation], whole[dilatation][order], rtol=1e-11)


@pytest.mark.parametrize("rule", ["initial", "intact", "full"])
def test_several_connections_count_once_each_and_a_new_one_takes_the_place_of_the_old(rule):
    middle, left, right = (block(2, 5, name=name, center=x) for name, x in (("m", 0.0), ("l", -0.5), ("r", 0.5)))
    joints = [Connection(middle, other, horizon=3.015 * DX) for other in (left, right)]
    found = []
    for links in (joints, [joints[0], *joints]):
        own = {part: Dilatation(part, weighted_volume=rule) for part in (middle, left, right)}
        made = [Dilatation(link, weighted_volume=rule, within=[own[part] for part in link.ends]) for link in links]
        for part in own:
            part[displacement] = 0.0
        run(*own.values(), *made[-2:])
        found.append(middle[inverse_weighted_volume].copy())
    assert found[0].any()
    np.testing.assert_array_equal(*found)


def test_weighing_makes_no_field_that_nobody_gave():
    part = block()
    made = Dilatation(part)
    assert displacement not in part
    with pytest.raises(rbs.MissingField, match="reads 'displacement'"):
        run(made)


def test_wrong_arguments_are_refused():
    part = block()
    with pytest.raises(rbs.BadInput, match="weighted_volume='half' must be one of initial, intact, full"):
        Dilatation(part, weighted_volume="half")
    other = block(name="other", center=1.0)
    link = Connection(part, other, horizon=3.015 * DX)
    with pytest.raises(rbs.BadInput, match="give within=, the dilatations of 'block' and 'other'"):
        Dilatation(link)
    with pytest.raises(rbs.BadInput, match="must be those of its parts"):
        Dilatation(link, "inverse", within=[Dilatation(part), Dilatation(other)])
    Dilatation(part, "conical")
    with pytest.raises(rbs.BadInput, match="already has another influence function"):
        Dilatation(part, "gaussian")
