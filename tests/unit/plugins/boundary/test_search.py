"""Bonds that are found again while nodes move."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core.part import Connection
from rbs_plugins import BoundaryDomain, Drift, PairwiseForce, Search
from rbs_plugins.boundary.search import Travel
from rbs_plugins.fields import density, displacement, force_density, velocity


def spring(length, k):
    return k * (length - 1.0)


def passing(speed=1.0):
    """A line of four nodes, and one node above it that flies along."""
    line = rbs.Part("line", rbs.Box(size=(4.0, 1.0))).discretize(1.0)
    point = rbs.Part("point", rbs.Everywhere(), dimension=2).place([[-2.0, 0.75]], 1.0)
    for part in (line, point):
        part[density], part[displacement], part[velocity] = 1.0, 0.0, 0.0
    point[velocity] = [speed, 0.0]
    return line, point, Connection(point, line, 1.0)


def test_new_neighbors_are_found_and_old_ones_forgotten():
    _, point, connection = passing()
    seen = []

    class Look(rbs.Measure):
        def apply(self, clock):
            seen.append([clock.step, connection.pairs[:, 1].tolist()])

    rbs.Analysis([Drift(point), Search(connection, when=rbs.every(2)), Look(point)]).run(
        steps=8, dt=0.5, progress=False
    )
    assert seen == [[1, [0]], [2, [0, 1]], [3, [0, 1]], [4, [1, 2]], [5, [1, 2]], [6, [2, 3]], [7, [2, 3]], [8, [3]]]


def test_forces_follow_the_new_bonds():
    line, point, connection = passing()
    scene = [Drift(point), Search(connection, when=rbs.every(1)), PairwiseForce(connection, spring, k=2.0)]
    rbs.Analysis(scene).run(steps=4, dt=0.5, force_dt=True, progress=False)
    d = np.array([[-0.5, -0.75], [0.5, -0.75]])
    length = np.linalg.norm(d, axis=1)[:, None]
    pulls = 2.0 * (length - 1.0) * d / length
    np.testing.assert_allclose(point[force_density], [pulls.sum(axis=0)], rtol=1e-14)
    np.testing.assert_allclose(line[force_density], [[0, 0], *(-pulls), [0, 0]], atol=1e-14)


def test_new_bonds_that_are_too_stiff_for_the_step_are_told():
    _, _, connection = passing(speed=0.1)
    connection.take(np.empty((0, 2), np.int64))
    pull = PairwiseForce(connection, spring, k=2.0)
    scene = rbs.Analysis([Search(connection, when=rbs.every(1)), pull])
    with pytest.warns(UserWarning, match=r"the bonds found at step 1 allow a time step of .* s, and it is 100 s"):
        scene.run(steps=2, dt=100.0, force_dt=True, progress=False)


def test_a_second_run_begins_with_the_bonds_of_the_scene():
    _, point, connection = passing()
    scene = [Drift(point), Search(connection, when=rbs.every(1))]
    rbs.Analysis(scene).run(steps=4, dt=0.5, progress=False)
    assert connection.pairs[:, 1].tolist() == [1, 2]
    point[displacement] = 0.0
    again = rbs.Analysis(scene)
    again.prepare()
    again.run(steps=0, dt=0.5, progress=False)
    assert connection.pairs[:, 1].tolist() == [0]


def test_a_resumed_run_has_the_bonds_and_their_fields(tmp_path):
    def scene():
        line, point, connection = passing(0.9)
        force = PairwiseForce(connection, spring, k=0.01)
        drive = BoundaryDomain(line, rbs.Everywhere(), velocity=(0.0, 0.0))
        save = rbs.Checkpoint(tmp_path / "c.npz", when=rbs.every(7))
        moves = [drive, Drift(line), Drift(point)]
        return point, connection, rbs.Analysis([*moves, Search(connection, when=rbs.every(3)), force, save])

    *_, first = scene()
    first.run(steps=8, dt=0.25, force_dt=True, progress=False)
    other, resumed, rest = scene()
    report = rest.run(steps=12, dt=0.25, force_dt=True, progress=False, resume=tmp_path / "c.npz")
    assert report.steps == 5
    (tmp_path / "c.npz").unlink()
    point, connection, whole = scene()
    whole.run(steps=12, dt=0.25, force_dt=True, progress=False)
    assert np.array_equal(connection.pairs, resumed.pairs)
    assert np.array_equal(connection.bonds.lengths, resumed.bonds.lengths)
    assert np.array_equal(point[force_density], other[force_density])


def test_what_cannot_be_searched_is_refused():
    line, point, _ = passing()
    with pytest.raises(rbs.BadInput, match="give a connection that was made with a horizon"):
        Search(Connection(point, line, pairs=[[0, 0]]))
    with pytest.raises(rbs.BadInput, match="give a connection that was made with a horizon"):
        Search(line)


def test_the_way_of_a_part_is_that_of_its_nodes_and_of_its_system():
    system = rbs.world.child("own", origin=(1.0, 0.0))
    part = rbs.Part("part", rbs.Box(size=(4.0, 2.0)), system=system).discretize(1.0)
    part[displacement] = 0.0
    travel = Travel(part, part[displacement])
    assert travel.distance() == 0.0
    part[displacement][3] = [0.3, 0.4]
    assert travel.distance() == pytest.approx(0.5, rel=1e-14)
    system.mapping = type(system.mapping)(origin=(1.0, 2.0))
    assert travel.distance() == pytest.approx(2.5, rel=1e-14)
    travel.look()
    assert travel.distance() == 0.0
    quarter = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    system.mapping = type(system.mapping)(origin=(1.0, 2.0), axes=quarter)
    furthest = np.linalg.norm(part.positions + part[displacement], axis=1).max() * np.sqrt(2.0)
    assert furthest <= travel.distance() <= 1.1 * furthest


def test_the_gap_between_two_parts():
    one, two = (
        rbs.Part(name, rbs.Box(size=(2.0, 2.0), center=center)).discretize(1.0)
        for name, center in (("one", (0.0, 0.0)), ("two", (5.0, 6.0)))
    )
    for part in (one, two):
        part[displacement] = 0.0
    assert Travel(one, one[displacement]).gap(Travel(two, two[displacement])) == pytest.approx(np.hypot(4.0, 5.0))
    assert Travel(one, one[displacement]).gap(Travel(one, one[displacement])) == 0.0
