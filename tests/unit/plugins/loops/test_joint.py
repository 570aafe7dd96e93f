"""Forces across a connection: a body in two pieces that are connected is the body in one piece."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core.part import Connection
from rbs_plugins import (
    BondBased,
    BoundaryDomain,
    Criterion,
    CriticalStretch,
    FractureDissipation,
    KineticEnergy,
    PairwiseForce,
    StrainEnergy,
    VelocityVerlet,
)
from rbs_plugins.fields import (
    density,
    displacement,
    dissipation_density,
    external_work,
    force_density,
    fracture_dissipation,
    intact,
    kinetic_energy,
    strain_energy,
    strain_energy_density,
    velocity,
)

SIZES = {1: (14.0,), 2: (12.0, 6.0), 3: (8.0, 4.0, 4.0)}
RATIO = 3.015
warmth = rbs.Field("warmth", "node", "scalar", "K", "T", "Made up for these tests.")


def linear(stretch, c):
    return c * stretch


def warm(stretch, warmth_i, warmth_j, c):
    return c * (stretch - 1e-2 * (warmth_i + warmth_j))


def turned_system(dimension):
    """A system that is shifted, and turned where there is room."""
    angle = 0.7
    turn = np.array([[np.cos(angle), np.sin(angle), 0.0], [-np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    axes = None if dimension == 1 else turn
    origin = [2.5, -1.5, 0.75][:dimension]
    return rbs.world.child("turned", origin=origin, axes=axes), (np.eye(3) if axes is None else turn)[
        :dimension, :dimension
    ]


def whole(dimension):
    part = rbs.Part("whole", rbs.Box(size=SIZES[dimension])).discretize(1.0)
    part[density] = 1.0
    return part.connect(RATIO, storage="list")


def halves(dimension, *, turned=False):
    """The same nodes in two parts, the second one in a system of its own; and where its vectors are in the world."""
    one = whole(dimension)
    left = one.positions[:, 0] < 0.5
    system, turn = turned_system(dimension) if turned else (rbs.world, np.eye(dimension))
    parts = []
    for name, mine, where in (("left", left, rbs.world), ("right", ~left, system)):
        part = rbs.Part(name, rbs.Everywhere(), dimension=dimension, system=where)
        points = one.positions[mine] if where is rbs.world else rbs.convert(one.positions[mine], rbs.world, where)
        part.place(points, one[rbs.volume][mine], spacing=1.0).connect(RATIO)
        part[density] = 1.0
        parts.append(part)
    return one, left, parts, turn


def compare(dimension, make, *, turned, steps=1, rng, fields=(force_density, strain_energy_density)):
    """Fields of the whole, and of the two halves put together again, after some steps at the same displacement."""
    one, left, (a, b), turn = halves(dimension, turned=turned)
    u = rng.normal(scale=0.02, size=one.positions.shape)
    one[displacement], a[displacement], b[displacement] = u, u[left], u[~left] @ turn.T
    for part, mine in ((one, slice(None)), (a, left), (b, ~left)):
        part[warmth] = (one.positions[mine, 0] % 3.0) * 0.01
    force = make(one)
    rbs.Analysis([force, StrainEnergy(one, [force])]).run(steps=steps, dt=0.1, force_dt=True, progress=False)
    glue = Connection(a, b, RATIO)
    forces = [make(host) for host in (a, b, glue)]
    energies = [StrainEnergy(a, [forces[0], forces[2]]), StrainEnergy(b, [forces[1], forces[2]])]
    rbs.Analysis([*forces, *energies]).run(steps=steps, dt=0.1, force_dt=True, progress=False)
    for field in fields:
        found = np.empty_like(one[field])
        found[left] = a[field]
        found[~left] = b[field] @ turn if field.shape == "vector" else b[field]
        np.testing.assert_allclose(found, one[field], rtol=0, atol=1e-12 * np.abs(one[field]).max(), err_msg=field.name)
    return one, glue


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_forces_and_energies_are_those_of_the_whole(dimension, turned, rng):
    compare(dimension, lambda host: BondBased(host, c=2.0), turned=turned, rng=rng)


def test_fields_of_both_parts(rng):
    compare(2, lambda host: PairwiseForce(host, warm, c=2.0), turned=True, rng=rng)


@pytest.mark.parametrize("release", ["at once", "next step"])
def test_bonds_between_parts_break_as_those_inside(release, rng):
    def make(host):
        return PairwiseForce(host, linear, CriticalStretch(0.02, mode="both", release=release), c=2.0)

    one, glue = compare(2, make, turned=True, steps=3, rng=rng)
    assert np.count_nonzero(~glue.bonds.intact) > 0 < len(glue.bonds)
    inside = len(one.bonds) - len(glue.bonds)
    assert inside > 0


def test_one_way_only_the_first_part_feels_it(rng):
    _, _, (a, b), _ = halves(2)
    a[displacement], b[displacement] = 0.0, rng.normal(scale=0.02, size=b.positions.shape)
    b[force_density] = 0.0
    rbs.Analysis([BondBased(Connection(a, b, RATIO, both=False), c=2.0)]).run(
        steps=1, dt=0.1, force_dt=True, progress=False
    )
    assert a[force_density].any()
    assert not b[force_density].any()


def test_momentum_and_energy_of_two_parts_that_break_apart(tmp_path):
    """Two bodies, each with a scheme of its own, glued together, thrown apart: what is supplied is found again."""
    _, _, (a, b), _ = halves(2, turned=True)
    glue = Connection(a, b, RATIO)
    bonds = [BondBased(host, c=2.0) for host in (a, b)]
    glued = PairwiseForce(glue, linear, CriticalStretch(0.03), c=1.0)
    a[velocity], b[velocity] = [-0.05, 0.02], [0.05, 0.0]
    schemes = [VelocityVerlet(part) for part in (a, b)]
    measures = [
        measure
        for part, own in ((a, bonds[0]), (b, bonds[1]))
        for measure in (KineticEnergy(part), StrainEnergy(part, [own, glued]), FractureDissipation(part))
    ]
    kicks, drifts = [each.kick for each in schemes], [each.drift for each in schemes]
    analysis = rbs.Analysis([*kicks, *drifts, *bonds, glued, *kicks, *measures])

    def momentum():
        to_world = rbs.convert(b[velocity], b.system, rbs.world) - rbs.convert(np.zeros((1, 2)), b.system, rbs.world)
        return (a[velocity] * a[rbs.volume][:, None]).sum(0) + (to_world * b[rbs.volume][:, None]).sum(0)

    def energy():
        kinds = (kinetic_energy, strain_energy, fracture_dissipation)
        return sum(float(part[kind]) for part in (a, b) for kind in kinds)

    analysis.run(steps=1, dt=0.05, progress=False)
    start, before = momentum(), energy()
    analysis.run(steps=400, dt=0.05, progress=False)
    np.testing.assert_allclose(momentum(), start, atol=1e-12)
    assert np.count_nonzero(~glue.bonds.intact) > 0
    assert sum(float(part[fracture_dissipation]) for part in (a, b)) > 0.05 * before
    assert abs(energy() / before - 1) < 5e-3


def test_a_moving_system_takes_its_part_along():
    system = rbs.world.child("moving", origin=(1.0, 0.0))
    a = rbs.Part("a", rbs.Box(size=(1.0, 1.0))).discretize(1.0)
    b = rbs.Part("b", rbs.Box(size=(1.0, 1.0)), system=system).discretize(1.0)
    a[displacement] = b[displacement] = 0.0
    force = PairwiseForce(Connection(a, b, 1.5), linear, c=2.0)
    analysis = rbs.Analysis([force])
    analysis.run(steps=1, dt=0.1, force_dt=True, progress=False)
    assert not a[force_density].any()
    system.mapping = type(system.mapping)(origin=(1.25, 0.0))
    analysis.run(steps=2, dt=0.1, force_dt=True, progress=False)
    np.testing.assert_allclose(a[force_density], [[0.5, 0.0]], rtol=1e-14)
    np.testing.assert_allclose(b[force_density], [[-0.5, 0.0]], rtol=1e-14)


def test_stable_step_counts_the_bonds_of_both_ends():
    one, left, (a, b), _ = halves(2)
    force = BondBased(one, c=2.0)
    one[displacement] = a[displacement] = b[displacement] = 0.0
    wanted = rbs.Analysis([force]).stable_dt()
    forces = [BondBased(host, c=2.0) for host in (a, b, Connection(a, b, RATIO))]
    assert rbs.Analysis(forces).stable_dt() == pytest.approx(wanted, rel=1e-12)
    squares = forces[2].squared_frequencies()
    own = forces[0].squared_frequency()
    np.testing.assert_allclose(own + squares[a], force.squared_frequency()[left], rtol=1e-12)


def test_many_connections_are_done_in_one_call(rng):
    def scene(separately):
        parts = []
        for k in range(4):
            part = rbs.Part(f"part {k}", rbs.Box(size=(5.0, 4.0), center=(6.0 * k, 0.0))).discretize(1.0).connect(2.0)
            part[displacement] = np.random.default_rng(k).normal(scale=0.02, size=part.positions.shape)
            part[density], part[warmth] = 1.0, 0.01 * k
            parts.append(part)
        links = [Connection(one, two, 2.5) for one, two in itertools.pairwise(parts)]
        own = [BondBased(part, c=2.0) for part in parts]
        across = [PairwiseForce(link, warm, CriticalStretch(0.05), c=2.0) for link in links]
        if separately:
            for force in across:
                force.batch_key = lambda: None
        steps = [VelocityVerlet(part) for part in parts]
        kicks, drifts = [s.kick for s in steps], [s.drift for s in steps]
        order = [*kicks, *drifts, *own, *across, *kicks]
        report = rbs.Analysis(order).run(steps=30, dt=0.05, progress=False)
        return report, np.concatenate([part[displacement] for part in parts])

    (alone, one), (together, two) = scene(True), scene(False)
    assert [row.name for row in together.rows][3] == "PairwiseForce, 3 parts"
    assert len(alone.rows) == len(together.rows) + 2
    assert np.array_equal(one, two)


def test_a_resumed_run_is_the_uninterrupted_one(tmp_path):
    def scene(path):
        _, _, (a, b), _ = halves(2, turned=True)
        a[velocity], b[velocity] = [-0.05, 0.02], [0.05, 0.0]
        bonds = [BondBased(host, c=2.0) for host in (a, b)]
        glue = Connection(a, b, RATIO)
        forces = [*bonds, PairwiseForce(glue, linear, CriticalStretch(0.03), c=1.0)]
        schemes = [VelocityVerlet(part) for part in (a, b)]
        kicks, drifts = [each.kick for each in schemes], [each.drift for each in schemes]
        losses = [FractureDissipation(a), FractureDissipation(b)]
        saved = rbs.Checkpoint(path, when=rbs.every(60))
        return (a, b, glue), rbs.Analysis([*kicks, *drifts, *forces, *kicks, *losses, saved])

    one, analysis = scene(tmp_path / "whole.npz")
    analysis.run(steps=150, dt=0.05, progress=False)
    _, first = scene(tmp_path / "parts.npz")
    first.run(steps=80, dt=0.05, progress=False)
    two, second = scene(tmp_path / "parts.npz")
    report = second.run(steps=150, dt=0.05, progress=False, resume=tmp_path / "parts.npz")
    assert report.steps == 90
    assert np.array_equal(one[2].bonds.intact, two[2].bonds.intact)
    assert not one[2].bonds.intact.all()
    for field in (displacement, velocity, force_density, dissipation_density, fracture_dissipation):
        for k in (0, 1):
            assert np.array_equal(one[k][field], two[k][field]), field.name


def test_only_one_record_is_refused():
    _, _, (a, b), _ = halves(2)
    a[displacement] = b[displacement] = 0.0
    force = PairwiseForce(Connection(a, b, RATIO), linear, CriticalStretch(0.03), c=1.0)
    with pytest.raises(rbs.BadInput, match="belongs to both parts, and only that of 'left' is asked for"):
        rbs.Analysis([force, FractureDissipation(a)]).prepare()


def test_a_criterion_may_be_limited_to_a_region_of_the_world():
    _, _, (a, b), _ = halves(2)
    a[displacement], b[displacement] = 0.0, [1.0, 0.0]
    glue = Connection(a, b, RATIO)
    upper = Criterion(lambda stretch: stretch > 0.01, within=rbs.HalfSpace((0.0, 0.0), (0.0, 1.0)))
    rbs.Analysis([PairwiseForce(glue, linear, upper, c=1.0)]).run(steps=1, dt=0.1, force_dt=True, progress=False)
    above = glue.positions[:, 1] > 0
    i, j = np.array(list(glue.bonds)).T
    assert np.array_equal(~glue.bonds.intact, above[i] & above[j])
    assert glue[intact].sum() < len(glue.bonds)


def test_work_of_a_motion_goes_through_a_connection():
    """A driver that is moved pulls a body by the bonds between them: its work is in the energies of both."""
    _, _, (a, b), _ = halves(2)
    glue = Connection(a, b, RATIO)
    forces = [BondBased(host, c=2.0) for host in (b, glue)]
    drive = BoundaryDomain(a, rbs.Everywhere(), velocity=(-0.01, 0.0))
    schemes = [VelocityVerlet(part) for part in (a, b)]
    measures = [StrainEnergy(a, [forces[1]]), StrainEnergy(b, forces), KineticEnergy(b), KineticEnergy(a)]
    kicks, drifts = [each.kick for each in schemes], [each.drift for each in schemes]
    analysis = rbs.Analysis([*kicks, drive, *drifts, *forces, *kicks, drive, *measures, Reads(a)])
    analysis.run(steps=1, dt=0.05, progress=False)
    start = float(a[kinetic_energy])
    analysis.run(steps=300, dt=0.05, progress=False)
    found = sum(float(part[strain_energy]) for part in (a, b)) + float(b[kinetic_energy]) + float(a[kinetic_energy])
    work = float(a[external_work])
    assert work > 0
    assert abs(found - start - (work - start)) < 2e-3 * work


class Reads(rbs.Measure):
    """Takes the offer of the work."""

    reads = (external_work,)

    def apply(self, clock):
        """Does nothing."""
