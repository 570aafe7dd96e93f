"""Boundary domains: who is in, what is prescribed when, and the work it does."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import BondBased, BoundaryDomain, CSVExporter, SymplecticEuler, VelocityVerlet
from rbs_plugins.fields import density, displacement, external_work, force_density, velocity, volume


@pytest.fixture
def dots():
    """Four free nodes in a plane with unequal masses; nothing pulls on them."""
    part = rbs.Part("dots", rbs.Everywhere(), dimension=2)
    part.place([[0.0, 0.0], [1.0, 0.0], [2.0, 1.0], [3.0, 1.0]], [1.0, 2.0, 3.0, 4.0], spacing=1.0)
    part[density] = [10.0, 20.0, 30.0, 40.0]
    part[force_density] = 0.0
    return part


class Idle(rbs.Constitutive):
    """Adds nothing: a place where forces are summed."""

    adds = (force_density,)


def run(part, boundaries, steps=4, dt=0.25, tmp_path=None, scheme=VelocityVerlet):
    table = [] if tmp_path is None else [CSVExporter(part, [external_work], tmp_path / "work.csv")]
    analysis = rbs.Analysis([*scheme(part).step([Idle(part)], boundaries), *table])
    analysis.run(steps=steps, dt=dt, progress=False)
    return analysis


@pytest.mark.parametrize(
    ("region", "wanted"),
    [
        (rbs.Box(size=(3.0, 0.5), center=(1.5, 0.0)), [0, 1]),
        (np.array([False, True, False, True]), [1, 3]),
        ([3, 0, 3], [0, 3]),
        (lambda points: points[:, 0] > 0.5, [1, 2, 3]),
    ],
)
def test_regions(dots, region, wanted):
    assert BoundaryDomain(dots, region, velocity=(0.0, None)).nodes.tolist() == wanted


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "exactly one of velocity, displacement, force, body_force, got none"),
        ({"velocity": (0.0, 0.0), "force": (0.0, 0.0)}, r"got \['velocity', 'force'\]"),
        ({"velocity": 1.0}, "velocity: give 2 components"),
        ({"force": (None, None)}, "nothing is prescribed"),
    ],
)
def test_bad_values(dots, given, words):
    with pytest.raises(BadInput, match=words):
        BoundaryDomain(dots, rbs.Everywhere(), **given)


def test_empty_region_is_refused(dots):
    with pytest.raises(BadInput, match="no node lies in"):
        BoundaryDomain(dots, rbs.Nowhere(), velocity=(0.0, 0.0))


# -- motions -------------------------------------------------------------------------------------------------------


def test_velocity_moves_its_nodes_and_leaves_the_rest(dots):
    dots[velocity] = (7.0, 8.0)
    run(dots, [BoundaryDomain(dots, [1, 2], velocity=(None, -2.0))])
    assert dots[velocity].tolist() == [[7.0, 8.0], [7.0, -2.0], [7.0, -2.0], [7.0, 8.0]]
    assert dots[displacement].tolist() == [[7.0, 8.0], [7.0, -2.0], [7.0, -2.0], [7.0, 8.0]]


def test_velocity_of_time_is_taken_at_mid_step_for_the_path_and_at_the_end_for_the_eye(dots):
    """v = 6 t: the midpoint rule integrates it exactly, u = 3 t²; v at the end of the last step is 6 t."""
    run(dots, [BoundaryDomain(dots, [0], velocity=(lambda time: 6.0 * time, 0.0))], steps=8, dt=0.25)
    assert dots[displacement][0].tolist() == [12.0, 0.0]
    assert dots[velocity][0].tolist() == [12.0, 0.0]


def test_path_of_a_curved_velocity_converges_with_order_two(dots):
    errors = []
    for steps in (8, 16):
        dots[displacement] = 0.0
        run(dots, [BoundaryDomain(dots, [0], velocity=(lambda t: 3 * t**2, 0.0))], steps=steps, dt=2.0 / steps)
        errors.append(abs(dots[displacement][0, 0] - 8.0))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=1e-9)  # a parabola: the error is exactly a multiple of dt²


def test_displacement_is_reached_at_the_end_of_every_step(dots):
    def path(time, positions):
        return np.sin(time) * positions

    domain = BoundaryDomain(dots, [1, 3], displacement=path)
    analysis = None
    for steps in range(1, 6):
        analysis = analysis or rbs.Analysis(VelocityVerlet(dots).step([Idle(dots)], [domain]))
        analysis.run(steps=steps, dt=0.3, progress=False)
        wanted = np.sin(0.3 * steps) * dots.positions[[1, 3]]
        np.testing.assert_allclose(dots[displacement][[1, 3]], wanted, atol=4e-16 * 5 * 3)  # an ulp of 3 m per step
    assert not dots[displacement][[0, 2]].any()


def test_displacement_shows_its_own_velocity_at_the_end_of_the_step(dots):
    run(dots, [BoundaryDomain(dots, [0], displacement=(lambda t: t**2, None))], steps=4, dt=0.25)
    assert dots[displacement][0, 0] == 1.0
    assert dots[velocity][0, 0] == 2.0  # a central difference of a parabola is exact


def test_euler_steps_take_motions_too(dots):
    run(dots, [BoundaryDomain(dots, [0], velocity=(1.0, 2.0))], scheme=SymplecticEuler)
    assert dots[displacement][0].tolist() == [1.0, 2.0]


def test_components_of_a_displacement_stay_the_same(dots):
    domain = BoundaryDomain(dots, [0], displacement=lambda t: (t, 0.0) if t < 0.6 else (t, None))
    with pytest.raises(BadInput, match=r"'dots', displacement: prescribes components \[0\] at time 0.75 s"):
        run(dots, [domain])
    run(dots, [BoundaryDomain(dots, [0], velocity=lambda t: (1.0, 1.0) if t < 0.6 else (2.0, None))])


def test_two_motions_of_one_node(dots):
    """Refused if they differ: the later one would win silently."""
    left = BoundaryDomain(dots, [0, 1], velocity=(0.0, 0.0))
    for right in (
        BoundaryDomain(dots, [1, 2], velocity=(1.0, None)),
        BoundaryDomain(dots, [1, 2], velocity=(None, lambda t: t)),
        BoundaryDomain(dots, [1, 2], velocity=lambda t, X: 1e3 * t * X),
        BoundaryDomain(dots, [1, 2], displacement=(0.0, None)),
    ):
        with pytest.raises(BadInput, match=r"different motions: component [01] of the node at \[1.0, 0.0\]"):
            run(dots, [left, right])


def test_motions_that_share_nodes_and_do_not_clash(dots):
    """A held corner, other components, other nodes, loads, turns by triggers, another part."""
    left = BoundaryDomain(dots, [0, 1], velocity=(0.0, None), when=rbs.always)
    other = rbs.Part("other", rbs.Everywhere(), dimension=2).place([[0.0, 0.0], [1.0, 0.0]], 1.0, spacing=1.0)
    other[density], other[displacement] = 1.0, 0.0
    for right in (
        BoundaryDomain(dots, [1, 2], velocity=(0.0, None)),
        BoundaryDomain(dots, [1, 2], velocity=([0.0, 5.0], None)),
        BoundaryDomain(dots, [1, 2], velocity=(None, 1.0)),
        BoundaryDomain(dots, [2, 3], velocity=(1.0, 1.0)),
        BoundaryDomain(dots, [1, 2], force=(1.0, 1.0)),
        BoundaryDomain(dots, [1, 2], velocity=(1.0, None), when=rbs.between(0.0, 0.5)),
        BoundaryDomain(other, [1], velocity=(1.0, None)),
    ):
        run(dots, [left, right], steps=1)


# -- loads ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["force", "body_force"])
def test_loads_add_to_the_force(dots, kind):
    run(dots, [BoundaryDomain(dots, [1, 3], **{kind: (12.0, None)})], steps=1)
    per_volume = {"force": 12.0 / (2.0 + 4.0), "body_force": 12.0}[kind]
    assert dots[force_density].tolist() == [[0.0, 0.0], [per_volume, 0.0], [0.0, 0.0], [per_volume, 0.0]]
    total = (dots[force_density] * dots[volume][:, None]).sum(axis=0)
    assert total[0] == pytest.approx({"force": 12.0, "body_force": 72.0}[kind], rel=1e-15)


@pytest.mark.parametrize(
    ("given", "on_each", "total"),
    [
        (12.0, [4.0, 8.0], 12.0),
        (lambda t: 12.0, [4.0, 8.0], 12.0),
        (np.array([12.0]), [4.0, 8.0], 12.0),
        ([1.0, 5.0], [1.0, 5.0], 6.0),
        (lambda t: np.array([1.0, 5.0]), [1.0, 5.0], 6.0),
        (lambda t, X: X[:, 0], [1.0, 3.0], 4.0),
    ],
)
def test_a_number_is_the_total_force_and_an_array_the_force_on_each_node(dots, given, on_each, total):
    run(dots, [BoundaryDomain(dots, [1, 3], force=(given, None))], steps=1)
    found = dots[force_density][:, 0] * dots[volume]
    np.testing.assert_allclose(found, [0.0, on_each[0], 0.0, on_each[1]], rtol=1e-15)
    assert found.sum() == pytest.approx(total, rel=1e-15)


def test_forces_on_each_node_for_all_components_at_once(dots):
    given = np.array([[1.0, 2.0], [3.0, 4.0]])
    run(dots, [BoundaryDomain(dots, [1, 3], force=given)], steps=1)
    np.testing.assert_allclose((dots[force_density] * dots[volume][:, None])[[1, 3]], given, rtol=1e-15)


def test_two_loads_on_one_node_add_up(dots):
    loads = [BoundaryDomain(dots, [1], body_force=(1.0, 2.0)), BoundaryDomain(dots, [1, 2], body_force=(10.0, None))]
    run(dots, loads, steps=1)
    assert dots[force_density][1].tolist() == [11.0, 2.0]
    assert dots[force_density][2].tolist() == [10.0, 0.0]


def test_load_of_time_is_that_of_the_end_of_the_step(dots):
    run(dots, [BoundaryDomain(dots, [0], body_force=(lambda time: 5.0 * time, None))], steps=4, dt=0.25)
    assert dots[force_density][0, 0] == 5.0


# -- work ----------------------------------------------------------------------------------------------------------


def kinetic(part):
    return 0.5 * float(np.sum(part[density] * part[volume] * (part[velocity] ** 2).sum(axis=1)))


def test_work_of_a_constant_force_is_the_kinetic_energy(dots, tmp_path):
    """The path of velocity Verlet under a constant force is exact, and so is force times path."""
    run(dots, [BoundaryDomain(dots, [1, 3], force=(12.0, -3.0))], tmp_path=tmp_path, steps=7)
    assert kinetic(dots) > 0
    assert dots[external_work] == pytest.approx(kinetic(dots), rel=1e-14)


def test_work_of_a_motion_from_rest_is_the_kinetic_energy(dots, tmp_path):
    run(dots, [BoundaryDomain(dots, [1, 3], velocity=(2.0, -3.0))], tmp_path=tmp_path)
    assert kinetic(dots) == 0.5 * 13.0 * (40.0 + 160.0)
    assert dots[external_work] == kinetic(dots)


def test_work_of_stopping_what_moves(dots, tmp_path):
    """Whatever was asked of the analysis before the velocities were given."""
    domain = BoundaryDomain(dots, rbs.Everywhere(), velocity=(0.0, 0.0))
    table = CSVExporter(dots, [external_work], tmp_path / "work.csv")
    analysis = rbs.Analysis([*VelocityVerlet(dots).step([Idle(dots)], [domain]), table])
    analysis.prepare()
    dots[velocity] = (1.0, 2.0)
    moving = kinetic(dots)
    analysis.run(steps=3, dt=0.1, progress=False)
    assert dots[external_work] == -moving


@pytest.mark.parametrize("kind", ["displacement", "velocity"])
@pytest.mark.parametrize("end", [0.7, 1.0])
def test_work_against_a_spring_is_its_energy_and_motion(tmp_path, kind, end):
    """Two nodes; one is held, one is led along a sine: work = ½ c s² |ξ| V V + ½ m v², to second order in dt."""
    motion = {
        "displacement": lambda t: 0.05 * (1 - np.cos(np.pi * t)),
        "velocity": lambda t: 0.05 * np.pi * np.sin(np.pi * t),
    }[kind]
    errors = []
    for steps in (100, 200):
        part = rbs.Part("pair", rbs.Everywhere(), dimension=1)
        part.place([[0.0], [1.0]], [2.0, 3.0], spacing=1.0).connect(1.5)
        part[density] = 1.0
        spring = BondBased(part, c=4.0)
        ends = [
            BoundaryDomain(part, [0], velocity=0.0),
            BoundaryDomain(part, [1], **{kind: motion}),
        ]
        table = CSVExporter(part, [external_work], tmp_path / "work.csv")
        analysis = rbs.Analysis([*VelocityVerlet(part).step([spring], ends), table])
        analysis.run(steps=steps, dt=end / steps, progress=False)
        stored = 0.5 * 4.0 * float(part[displacement][1, 0]) ** 2 * 6.0
        errors.append(abs(float(part[external_work]) - stored - kinetic(part)) / stored)
    assert errors[1] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)  # the next term is smaller by π dt, 2 % and less


def test_work_is_offered_and_costs_nothing_if_nobody_asks(dots):
    domain = BoundaryDomain(dots, [0], velocity=(1.0, None))
    run(dots, [domain])
    assert external_work not in dots
    assert domain.state() == {}


@pytest.mark.parametrize("given", [{"velocity": (1.0, None)}, {"force": (1.0, None)}], ids=["motion", "load"])
@pytest.mark.parametrize("when", [rbs.every(2), rbs.between(0.0, 0.5)], ids=repr)
def test_work_of_a_domain_that_acts_now_and_then_is_refused(dots, tmp_path, given, when):
    """What happens between its steps nobody has looked at: the sum would be silently wrong."""
    domain = BoundaryDomain(dots, [0], when=when, **given)
    with pytest.raises(BadInput, match=r"'dots': its work can only be followed if it acts in every step, not when="):
        run(dots, [domain], tmp_path=tmp_path)
    assert not dots[displacement].any()
    run(dots, [domain])  # nobody asks
    assert dots[displacement][0, 0] > 0


def test_work_of_others_can_be_followed_beside_it(dots, tmp_path):
    """Of another part, or where the value depends on time instead."""
    other = rbs.Part("other", rbs.Everywhere(), dimension=2).place([[0.0, 0.0]], 1.0, spacing=1.0)
    other[density], other[displacement] = 1.0, 0.0
    pulse = BoundaryDomain(other, [0], velocity=(2.0, None), when=rbs.once)
    pull = BoundaryDomain(dots, [0], force=(lambda time: 8.0 if time <= 0.5 else 0.0, None))
    run(dots, [pull, pulse], tmp_path=tmp_path)
    assert dots[external_work] > 0
    assert external_work not in other
