"""Nodes that come too close repel each other: forces, energy, momentum, searches, the stable step."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import (
    BondBased,
    BoundaryDomain,
    CriticalStretch,
    FractureDissipation,
    KineticEnergy,
    ShortRangeRepulsion,
    StrainEnergy,
    VelocityVerlet,
)
from rbs_plugins.boundary.contact import repulsion, repulsion_potential
from rbs_plugins.fields import (
    contact_distance,
    density,
    displacement,
    force_density,
    fracture_dissipation,
    intact,
    kinetic_energy,
    strain_energy,
    velocity,
)

DX = 0.05


def count_searches(contact):
    """A list that gets an entry for every search."""
    found, search = [], contact._find
    contact._find = lambda: (found.append(1), search())
    return found


def balls(dimension, n=16, speed=10.0, gap=0.1, *, turned=True):
    """Two elastic balls of diameter 1 that fly at each other, the second one on a grid turned by 0.3 rad."""
    c, s = np.cos(0.3), np.sin(0.3)
    axes = [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]] if turned else None
    parts = []
    for name, x in (("left", -0.5), ("right", 0.5 + gap + 1.0 / n)):
        system = rbs.world.child(name, origin=(x,), axes=axes if x > 0 else None)
        part = rbs.Part(name, rbs.Ball(radius=0.5, center=[0.0] * dimension), system=system).discretize(1.0 / n)
        part.connect(3.015 / n)
        part[density] = 1000.0
        flight = np.zeros((1, dimension))
        flight[0, 0] = -np.sign(x) * speed
        part[velocity] = flight @ (np.array(axes)[:dimension, :dimension].T if axes and x > 0 else np.eye(dimension))
        parts.append(part)
    bonds = [BondBased(part, E=1e9) for part in parts]
    return parts, bonds, ShortRangeRepulsion(*parts, stiffness=5 * bonds[0].c)


def world_velocity(part):
    zero = rbs.convert(np.zeros((1, part.dimension)), part.system, rbs.world)
    return rbs.convert(part[velocity], part.system, rbs.world) - zero


def momentum(parts):
    return sum((part[density] * part[rbs.volume]) @ world_velocity(part) for part in parts)


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_an_elastic_collision_keeps_momentum_and_energy(dimension):
    parts, bonds, contact = balls(dimension, {1: 40, 2: 16, 3: 8}[dimension], turned=dimension > 1)
    searches = count_searches(contact)
    schemes = [VelocityVerlet(part) for part in parts]
    kicks, drifts = [each.kick for each in schemes], [each.drift for each in schemes]
    energies = [StrainEnergy(part, [own, contact]) for part, own in zip(parts, bonds, strict=True)]
    measures = [*energies, *(KineticEnergy(part) for part in parts)]
    analysis = rbs.Analysis([*kicks, *drifts, *bonds, contact, *kicks, *measures])
    mass = [float(part[density] @ part[rbs.volume]) for part in parts]
    before = [momentum([part])[0] for part in parts]
    start = momentum(parts)
    dt = 0.4 * analysis.stable_dt()
    analysis.run(until=0.04, dt=dt, progress=False)
    after = [momentum([part])[0] for part in parts]
    scale = sum(abs(each) for each in before)
    np.testing.assert_allclose(momentum(parts), start, atol=1e-12 * scale)
    restitution = (after[1] / mass[1] - after[0] / mass[0]) / (before[0] / mass[0] - before[1] / mass[1])
    print(f"coefficient of restitution in {dimension}-D: {restitution:.3f}")
    # what is missing rings on in the balls
    assert 0.85 < restitution <= 1.0
    energy = sum(float(part[kind]) for part in parts for kind in (kinetic_energy, strain_energy))
    # bounded error of velocity Verlet, (ω dt)²/8 at most, here of the share that vibrates
    assert energy == pytest.approx(0.5 * sum(mass) * 10.0**2, rel=1e-3)
    assert not len(contact.host.bonds)
    assert 3 < len(searches) < analysis.clock.step / 20


def test_force_of_two_nodes():
    one, two = (rbs.Part(name, rbs.Everywhere(), dimension=2).place([[x, 0.0]], v) for name, x, v in
                (("one", 0.0, 2.0), ("two", 3.0, 4.0)))  # fmt: skip
    one[displacement], two[displacement] = 0.0, [-2.4, 0.8]
    contact = ShortRangeRepulsion(one, two, stiffness=10.0, distance=2.0)
    analysis = rbs.Analysis([contact, StrainEnergy(one, [contact])])
    analysis.run(steps=1, dt=0.1, force_dt=True, progress=False)
    np.testing.assert_allclose(one[force_density], 10.0 * (1.0 - 2.0) / 2.0 * 4.0 * np.array([[0.6, 0.8]]))
    np.testing.assert_allclose(two[force_density], -10.0 * (1.0 - 2.0) / 2.0 * 2.0 * np.array([[0.6, 0.8]]))
    assert one[strain_energy] == pytest.approx(0.5 * 0.5 * 10.0 * 2.0 * 0.25 * 2.0 * 4.0)
    two[displacement] = [-1.0, 0.0]
    analysis.run(steps=2, dt=0.1, force_dt=True, progress=False)
    assert not one[force_density].any()


def test_the_force_is_the_slope_of_the_energy():
    for length in np.linspace(0.2, 1.8, 9) + 0.01:
        w = [repulsion_potential(length + h, 1.0, 3.0) for h in (-1e-6, 1e-6)]
        assert (w[1] - w[0]) / 2e-6 == pytest.approx(repulsion(length, 1.0, 3.0), abs=1e-8)


def cracked():
    """A plate with a crack right through it, whose halves can only meet."""
    part = rbs.Part("plate", rbs.Box(size=(12 * DX, 8 * DX))).discretize(DX).connect(3.015 * DX)
    part[density] = 1000.0
    part.bonds.cut(rbs.Segment((-9.0, 0.0), (9.0, 0.0)))
    return part


def test_a_closed_crack_is_at_rest_and_resists_from_the_first_moment():
    part = cracked()
    part[displacement] = 0.0
    contact = ShortRangeRepulsion(part, stiffness=1e12)
    upper = part.positions[:, 1] > 0
    analysis = rbs.Analysis([contact])
    analysis.run(steps=1, dt=1e-9, force_dt=True, progress=False)
    assert len(contact.host.bonds)
    assert np.abs(part[force_density]).max() < 1e-12 * 1e12 * DX**2
    part[displacement][upper] = [0.0, -0.1 * DX]
    analysis.run(steps=2, dt=1e-9, force_dt=True, progress=False)
    push = part[force_density][:, 1]
    assert (push[upper & (part.positions[:, 1] < DX)] > 0).all()
    assert push.sum() == pytest.approx(0.0, abs=1e-12 * np.abs(push).sum())
    part[displacement][upper] = [0.0, 0.1 * DX]
    analysis.run(steps=3, dt=1e-9, force_dt=True, progress=False)
    assert np.abs(part[force_density]).max() < 1e-12 * 1e12 * DX**2


def test_the_energy_of_failing_bonds_is_that_of_the_material_alone():
    """Contact breaks no bond: the balance of the energies closes beside it."""
    part = rbs.Part("bar", rbs.Box(size=(12 * DX, 4 * DX))).discretize(DX).connect(3.015 * DX)
    part[density], part[displacement], part[velocity] = 1000.0, 0.0, part.positions * [80.0, 0.0]
    bonds = BondBased(part, E=1e9, fracture=CriticalStretch(0.01))
    contact = ShortRangeRepulsion(part, stiffness=5 * bonds.c)
    energies = [KineticEnergy(part), StrainEnergy(part, [bonds, contact]), FractureDissipation(part)]
    analysis = rbs.Analysis([*VelocityVerlet(part).step([bonds, contact]), *energies])
    analysis.run(steps=1, dt=2e-6, progress=False)
    start = float(part[kinetic_energy])
    analysis.run(steps=400, dt=2e-6, progress=False)
    assert part.bonds.has_broken
    parts = [float(part[kind]) for kind in (kinetic_energy, strain_energy, fracture_dissipation)]
    assert sum(parts) == pytest.approx(start, rel=5e-3)
    assert parts[2] > 0.01 * start


def test_a_bond_that_breaks_between_near_nodes_pushes_nobody():
    """Pairs are found some steps after their bonds have broken under compression; the energy balance closes."""
    dx = 0.5e-3
    bar = rbs.Part("bar", rbs.Box(size=(0.03, 0.01))).discretize(dx, thickness=dx).connect(3.015 * dx)
    ball = rbs.Part("ball", rbs.Ball(radius=0.005, center=(0.0, 0.0105))).discretize(dx, thickness=dx)
    ball.connect(3.015 * dx)
    bar[density], ball[density] = 2440.0, 7800.0
    ball[velocity] = (0.0, -60.0)
    glass = BondBased(bar, E=72e9, fracture=CriticalStretch(fracture_energy=135.0))
    hard = BondBased(ball, E=200e9)
    touch = ShortRangeRepulsion(bar, ball, stiffness=15 * glass.c)
    debris = ShortRangeRepulsion(bar, stiffness=15 * glass.c)
    schemes = VelocityVerlet(bar), VelocityVerlet(ball)
    kicks, drifts = [s.kick for s in schemes], [s.drift for s in schemes]
    measures = [*(KineticEnergy(p) for p in (bar, ball)), StrainEnergy(bar, [glass, touch, debris])]
    measures += [StrainEnergy(ball, [hard, touch]), FractureDissipation(bar)]
    analysis = rbs.Analysis([*kicks, *drifts, glass, hard, touch, debris, *kicks, *measures])
    analysis.run(until=15e-6, progress=False)
    start = 0.5 * 7800.0 * float(ball[rbs.volume].sum()) * 60.0**2
    found = sum(float(part[kind]) for part in (bar, ball) for kind in (kinetic_energy, strain_energy))
    assert len(debris.host.bonds)
    assert (debris.host[contact_distance] < dx).any()
    assert found + float(bar[fracture_dissipation]) == pytest.approx(start, rel=2e-3)


def test_contact_is_honest():
    """Bonds that come and go take their fields with them; nobody is blamed for that."""
    parts, bonds, contact = balls(2, 8)
    schemes = [VelocityVerlet(part) for part in parts]
    kicks, drifts = [each.kick for each in schemes], [each.drift for each in schemes]
    rbs.Analysis([*kicks, *drifts, *bonds, contact, *kicks]).run(until=0.02, progress=False, debug=True)
    assert parts[0][velocity][:, 0].mean() < 0


def test_nodes_at_an_irregular_rest_push_nobody(rng):
    part = rbs.Part("cloud", rbs.Everywhere(), dimension=2).place(rng.uniform(size=(60, 2)), 1e-3, spacing=0.1)
    part[displacement] = 0.0
    contact = ShortRangeRepulsion(part, stiffness=1e9, distance=0.3)
    rbs.Analysis([contact]).run(steps=1, dt=1e-9, force_dt=True, progress=False)
    assert np.abs(part[force_density]).max() <= 1e-9 * 1e9 * 1e-3
    assert contact.host[contact_distance].max() <= 0.3
    assert contact.host[contact_distance].min() == pytest.approx(contact.host.bonds.lengths.min())


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_what_bonds_hold_does_not_repel_and_what_breaks_does(storage):
    """A plate is pulled apart and pressed together again: only then, and only across the crack, there is contact."""
    part = rbs.Part("plate", rbs.Box(size=(6 * DX, 8 * DX))).discretize(DX).connect(3.015 * DX, storage=storage)
    part[density] = 1000.0
    bonds = BondBased(part, E=1e9, fracture=CriticalStretch(0.01))
    contact = ShortRangeRepulsion(part, stiffness=bonds.c, search=rbs.every(2))
    part[displacement] = 0.0
    rbs.Analysis([bonds, contact]).run(steps=1, dt=1e-9, force_dt=True, progress=False)
    assert not len(contact.host.bonds)
    upper = part.positions[:, 1] > 0
    part[displacement][upper] = [0.0, 0.1 * DX]
    analysis = rbs.Analysis([bonds, contact])
    analysis.run(steps=2, dt=1e-9, force_dt=True, progress=False)
    assert part.bonds.has_broken
    assert len(contact.host.bonds) > 0
    i, j = contact.host.pairs.T
    assert (upper[i] != upper[j]).all()
    assert not part.bonds.holds(i, j).any()
    part[displacement][upper] = [0.0, -0.2 * DX]
    analysis.run(steps=3, dt=1e-9, force_dt=True, progress=False)
    assert part[force_density][upper, 1].sum() > 0


def test_the_result_does_not_depend_on_how_often_is_searched():
    found = []
    for skin in (0.1, 0.7):
        parts, bonds, _ = balls(2, 10)
        contact = ShortRangeRepulsion(*parts, stiffness=5 * bonds[0].c, skin=skin * 0.1)
        searches = count_searches(contact)
        schemes = [VelocityVerlet(part) for part in parts]
        kicks, drifts = [each.kick for each in schemes], [each.drift for each in schemes]
        rbs.Analysis([*kicks, *drifts, *bonds, contact, *kicks]).run(until=0.02, dt=2e-5, progress=False)
        found.append((len(searches), parts[0][displacement].copy()))
    assert found[0][0] > 2 * found[1][0]
    np.testing.assert_allclose(found[0][1], found[1][1], atol=1e-9)


def test_a_tool_that_moves_with_its_system_is_noticed():
    """Only the system of the tool moves; its nodes never do."""
    system = rbs.world.child("tool", origin=(0.0, 5.0))
    tool = rbs.Part("tool", rbs.Box(size=(4.0, 1.0)), system=system).discretize(1.0)
    block = rbs.Part("block", rbs.Box(size=(4.0, 4.0))).discretize(1.0)
    for part in (tool, block):
        part[displacement] = 0.0
    contact = ShortRangeRepulsion(block, tool, stiffness=1.0)
    analysis = rbs.Analysis([contact])
    analysis.run(steps=1, dt=0.1, force_dt=True, progress=False)
    assert not len(contact.host.bonds)
    system.mapping = type(system.mapping)(origin=(0.0, 2.25))
    analysis.run(steps=2, dt=0.1, force_dt=True, progress=False)
    top = block.positions[:, 1] > 1.0
    np.testing.assert_allclose(block[force_density][top], [[0.0, -0.25]] * 4, rtol=1e-12, atol=1e-15)
    assert not block[force_density][~top].any()


def test_the_stable_step_takes_account_of_contact():
    parts, bonds, contact = balls(2)
    for part in parts:
        part[displacement] = 0.0
    with_, without = rbs.Analysis([*bonds, contact]).stable_dt(), rbs.Analysis(bonds).stable_dt()
    assert with_ < without
    stiffer = ShortRangeRepulsion(*parts, stiffness=100 * contact.stiffness)
    assert rbs.Analysis([*bonds, stiffer]).stable_dt() < 0.2 * without
    squares = stiffer.squared_frequencies()
    for part in parts:
        np.testing.assert_allclose(squares[part], 100 * contact.squared_frequencies()[part])


def test_a_resumed_run_is_the_uninterrupted_one(tmp_path):
    def scene():
        part = rbs.Part("bar", rbs.Box(size=(12 * DX, 4 * DX))).discretize(DX).connect(3.015 * DX)
        part[density] = 1000.0
        part.bonds.cut(rbs.Segment((0.0, -9.0), (0.0, 9.0)))
        bonds = BondBased(part, E=1e9, fracture=CriticalStretch(0.05))
        contact = ShortRangeRepulsion(part, stiffness=5 * bonds.c, search=rbs.every(5))
        part[velocity] = -part.positions * [40.0, 0.0]
        drive = BoundaryDomain(part, part.positions[:, 0] > 5 * DX, velocity=(-20.0, 0.0))
        save = rbs.Checkpoint(tmp_path / "c.npz", when=rbs.every(61))
        return part, contact, rbs.Analysis([*VelocityVerlet(part).step([bonds, contact], [drive]), save])

    *_, first = scene()
    first.run(steps=70, dt=1e-5, progress=False)
    other, again, rest = scene()
    report = rest.run(steps=120, dt=1e-5, progress=False, resume=tmp_path / "c.npz")
    assert report.steps == 59
    (tmp_path / "c.npz").unlink()
    part, contact, whole = scene()
    whole.run(steps=120, dt=1e-5, progress=False)
    assert not part[intact].all()
    assert np.array_equal(contact.host.pairs, again.host.pairs)
    for field in (displacement, velocity, force_density):
        assert np.array_equal(part[field], other[field]), field.name


def test_bad_numbers_are_refused():
    parts, _, _ = balls(1, 8, turned=False)
    for wrong in ({"stiffness": -1.0}, {"stiffness": 1.0, "distance": 0.0}, {"stiffness": 1.0, "skin": float("nan")}):
        with pytest.raises(rbs.BadInput, match="must be positive and finite"):
            ShortRangeRepulsion(*parts, **wrong)
    with pytest.raises(rbs.BadInput, match=r"search=7 must be a trigger such as every\(100\)"):
        ShortRangeRepulsion(*parts, stiffness=1.0, search=7)
    loose = rbs.Part("loose", rbs.Everywhere(), dimension=1).place([0.0, 9.0], 1.0)
    with pytest.raises(rbs.BadInput, match="say distance=, how near nodes may come"):
        ShortRangeRepulsion(parts[0], loose, stiffness=1.0)
    with pytest.raises(rbs.BadInput, match="is no Part"):
        ShortRangeRepulsion(rbs.Box(size=1.0), stiffness=1.0)
