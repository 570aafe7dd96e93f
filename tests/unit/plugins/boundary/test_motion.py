"""Parts that move as a whole: where they are, what they drag along, and what a checkpoint keeps of it."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core.part import Connection
from rbs_core.space import Cartesian
from rbs_plugins import BondBased, PairwiseForce, Rotation, ShortRangeRepulsion, Translation, VelocityVerlet
from rbs_plugins.fields import density, displacement, force_density, velocity


def tool(dimension=2, name="tool", origin=(0.0,), parent=None):
    """Two nodes along x in a system of their own."""
    system = (parent or rbs.world).child(name, origin=origin)
    part = rbs.Part(name, rbs.Everywhere(), dimension=dimension, system=system)
    return part.place(np.eye(dimension)[0] * [[1.0], [2.0]], 1.0)


def run(*relations, until=2.0, dt=0.125):
    return rbs.Analysis(list(relations)).run(until=until, dt=dt, force_dt=True, progress=False)


def where(part):
    return rbs.convert(part.positions, part.system, rbs.world)


@pytest.mark.parametrize(
    ("given", "way"),
    [
        ({"velocity": (3.0, 1.0)}, (6.0, 2.0)),
        ({"acceleration": (0.0, 2.0)}, (0.0, 4.0)),
        ({"velocity": (1.0, 0.0), "acceleration": (0.0, 2.0)}, (2.0, 4.0)),
        ({"velocity": lambda t: (3.0 * t**2, 1.0)}, (8.0, 2.0)),
        ({"displacement": lambda t: (np.sin(t), 1.0)}, (np.sin(2.0), 0.0)),
    ],
)
def test_a_part_is_shifted(given, way):
    part = tool(origin=(5.0,))
    run(Translation(part, **given))
    np.testing.assert_allclose(where(part), part.positions + np.array([5.0, 0.0]) + way, rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize(
    ("given", "angle"),
    [
        ({"velocity": 3.0}, 6.0),
        ({"acceleration": 2.0}, 4.0),
        ({"velocity": 1.0, "acceleration": 2.0}, 6.0),
        ({"velocity": lambda t: t**3}, 4.0),
        ({"angle": np.sin}, np.sin(2.0)),
    ],
)
def test_a_part_is_turned(given, angle):
    part = tool(origin=(5.0, 1.0))
    run(Rotation(part, **given))
    wanted = [[5.0 + r * np.cos(angle), 1.0 + r * np.sin(angle)] for r in (1.0, 2.0)]
    np.testing.assert_allclose(where(part), wanted, rtol=1e-13)


def test_a_part_turns_about_any_axis_by_the_rule_of_the_right_hand():
    part = tool(3)
    run(Rotation(part, velocity=np.pi / 4, axis=(0.0, 2.0, 0.0), center=(1.0, 0.0, 0.0)))
    np.testing.assert_allclose(where(part), [[1.0, 0.0, 0.0], [1.0, 0.0, -1.0]], atol=1e-14)


def test_a_part_spins_about_a_center_that_flies():
    part = tool()
    run(Translation(part, velocity=(10.0, 0.0)), Rotation(part, velocity=np.pi / 2, center=(1.0, 0.0)))
    np.testing.assert_allclose(where(part), [[21.0, 0.0], [20.0, 0.0]], atol=1e-12)


def test_a_system_above_takes_everything_below_along():
    arm = rbs.world.child("arm", origin=(10.0,))
    one, two = tool(name="one", parent=arm), tool(name="two", origin=(0.0, 1.0), parent=arm)
    run(Rotation(one, velocity=np.pi / 4, system=arm), Rotation(two, velocity=np.pi / 2))
    np.testing.assert_allclose(where(one), [[10.0, 1.0], [10.0, 2.0]], atol=1e-13)
    np.testing.assert_allclose(where(two), [[9.0, -1.0], [9.0, -2.0]], atol=1e-13)


def test_many_turns_keep_the_shape():
    part = tool(3)
    run(Rotation(part, velocity=1.0, axis=(1.0, 2.0, 3.0)), until=20_000.0, dt=1.0)
    axes = part.system.mapping.axes
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    turned = part.positions @ Cartesian((0.0,)).rotated(20_000.0, (1.0, 2.0, 3.0)).axes
    np.testing.assert_allclose(where(part), turned, atol=1e-9)


def test_another_run_begins_where_the_scene_did():
    part = tool()
    relations = [Translation(part, velocity=(1.0, 0.0))]
    run(*relations)
    run(*relations)
    np.testing.assert_allclose(where(part), part.positions + np.array([2.0, 0.0]), rtol=1e-14)


def test_a_resumed_run_is_the_uninterrupted_one(tmp_path):
    def scene():
        part = tool(3)
        moves = [Translation(part, velocity=(0.3, 0.1, 0.0)), Rotation(part, velocity=1.7, axis=(1.0, 2.0, 3.0))]
        return part, rbs.Analysis([*moves, rbs.Checkpoint(tmp_path / "c.npz", when=rbs.every(7))])

    scene()[1].run(steps=9, dt=0.1, progress=False, force_dt=True)
    again, rest = scene()
    rest.run(steps=20, dt=0.1, progress=False, force_dt=True, resume=tmp_path / "c.npz")
    (tmp_path / "c.npz").unlink()
    part, whole = scene()
    whole.run(steps=20, dt=0.1, progress=False, force_dt=True)
    assert np.array_equal(where(part), where(again))


def ring_and_hub():
    """A rigid hub that turns, and an elastic ring around it, both on one grid, glued to each other."""
    dx, horizon = 0.05, 3.015 * 0.05
    hub = rbs.Part("hub", rbs.Ball(radius=0.25, center=(0.0, 0.0)), system=rbs.world.child("hub")).discretize(dx)
    around = rbs.Ball(radius=0.5, center=(0.0, 0.0)) - rbs.Ball(radius=0.25, center=(0.0, 0.0))
    ring = rbs.Part("ring", around).discretize(dx).connect(horizon)
    for part in (hub, ring):
        part[displacement] = 0.0
        part[density] = 1000.0
    return hub, ring, Connection(hub, ring, horizon), BondBased(ring, E=1e8)


def pull(stretch, c):
    return c * stretch


def spin(part):
    """Mean angular velocity about the origin, rad/s: angular momentum over moment of inertia."""
    x, y = (part.positions + part[displacement]).T
    u, v = part[velocity].T
    return float((x * v - y * u).sum() / (x**2 + y**2).sum())


def test_a_hub_that_turns_drags_the_ring_around_it():
    """The damped ring ends up turning with the hub, and then both rest in each other's eyes."""
    hub, ring, glue, bonds = ring_and_hub()

    def drag(part, dt):
        """Takes motion out that is none of the hub's."""
        x, y = (part.positions + part[displacement]).T
        rigid = 5.0 * np.stack([-y, x], axis=1)
        return rigid + (part[velocity] - rigid) * np.exp(-200.0 * dt)

    class Damping(rbs.Boundary):
        reads, updates = (displacement,), (velocity,)

        def apply(self, clock):
            self[velocity][...] = drag(self.part, clock.dt)

    across = PairwiseForce(glue, pull, c=bonds.c)
    ring[velocity] = 0.0
    scene = VelocityVerlet(ring).step([bonds, across], [Damping(ring)])
    analysis = rbs.Analysis([Rotation(hub, velocity=5.0), *scene])
    analysis.run(until=0.1, progress=False)
    assert spin(ring) == pytest.approx(5.0, rel=0.02)
    # half a radian from where it began; a ring that had stayed behind would have been torn
    assert abs(glue.bonds.lengths.max() - glue.horizon) < glue.horizon
    x, y = (ring.positions + ring[displacement]).T
    turned = np.angle((x + 1j * y) / (ring.positions @ [1.0, 1j]))
    assert turned.mean() == pytest.approx(0.5, abs=0.05)
    assert turned.std() < 0.02


def test_turning_all_of_it_needs_no_force():
    hub, ring, glue, bonds = ring_and_hub()
    c, s = np.cos(0.7), np.sin(0.7)
    hub.system.rotate(0.7)
    ring[displacement] = ring.positions @ (np.array([[c, s], [-s, c]]) - np.eye(2))
    across = PairwiseForce(glue, pull, c=bonds.c)
    rbs.Analysis([bonds, across]).run(steps=1, dt=1e-9, progress=False)
    size = bonds.c * 1e-12
    assert np.abs(ring[force_density]).max() < size
    assert np.abs(hub[force_density]).max() < size


def test_a_paddle_that_turns_throws_a_ball():
    """Contact drives the deformable part; nothing but the paddle supplies energy."""
    dx = 0.05
    paddle = rbs.Part("paddle", rbs.Box(size=(1.0, 0.1)), system=rbs.world.child("paddle")).discretize(dx)
    system = rbs.world.child("ball", origin=(0.35, 0.30))
    ball = rbs.Part("ball", rbs.Ball(radius=0.15, center=(0.0, 0.0)), system=system).discretize(dx).connect(3.015 * dx)
    ball[density], ball[velocity] = 1000.0, 0.0
    bonds = BondBased(ball, E=1e8)
    contact = ShortRangeRepulsion(paddle, ball, stiffness=5 * bonds.c)
    paddle[displacement] = 0.0
    turn = Rotation(paddle, velocity=20.0)
    rbs.Analysis([turn, *VelocityVerlet(ball).step([bonds, contact])]).run(until=0.05, progress=False)
    vx, vy = ball[velocity].mean(axis=0)
    # pushed at least as fast as the paddle is at 0.35 m, thrown at most twice as fast as its tip at 0.5 m
    assert 20.0 * 0.35 < vy < 2.0 * 20.0 * 0.5
    assert abs(vx) < vy


def test_bad_motions_are_refused():
    part = tool()
    with pytest.raises(rbs.BadInput, match="which cannot be moved: make it in one of its own"):
        Translation(rbs.Part("fixed", rbs.Everywhere(), dimension=2).place(np.zeros((1, 2)), 1.0), velocity=(1.0, 0.0))
    with pytest.raises(rbs.BadInput, match=r"give velocity, acceleration \(or both\), or displacement"):
        Translation(part)
    with pytest.raises(rbs.BadInput, match="or displacement"):
        Translation(part, velocity=(1.0, 0.0), displacement=lambda t: (t, 0.0))
    with pytest.raises(rbs.BadInput, match=r"must be 2 finite numbers, got \(1.0, 0.0, 0.0\)"):
        Translation(part, velocity=(1.0, 0.0, 0.0))
    with pytest.raises(rbs.BadInput, match="at time 0 s: must be 2 finite numbers"):
        Translation(part, velocity=lambda t: (np.nan, 0.0))
    with pytest.raises(rbs.BadInput, match="must be a function of time"):
        Translation(part, displacement=(1.0, 0.0))
    with pytest.raises(rbs.BadInput, match="leaves nothing for an acceleration"):
        Translation(part, velocity=lambda t: (t, 0.0), acceleration=(1.0, 0.0))
    with pytest.raises(rbs.BadInput, match="a 1-D part has nothing to turn in"):
        Rotation(tool(1), velocity=1.0)
    with pytest.raises(rbs.BadInput, match="can only turn about z"):
        Rotation(part, velocity=1.0, axis=(1.0, 0.0, 0.0))
    with pytest.raises(rbs.BadInput, match="has no length"):
        Rotation(tool(3), velocity=1.0, axis=(0.0, 0.0, 0.0))
    with pytest.raises(rbs.BadInput, match="is neither the system of the part nor above it"):
        Translation(part, velocity=(1.0, 0.0), system=rbs.world.child("elsewhere"))
