"""Boundary domains: what is left from an earlier run, and what makes a domain the same one."""

from __future__ import annotations

import pytest

import rbs_core as rbs
from rbs_plugins import BoundaryDomain, CSVExporter, VelocityVerlet
from rbs_plugins.fields import density, displacement, external_work, force_density, velocity


@pytest.fixture
def dots():
    """Three free nodes in a plane with unequal masses; nothing pulls on them."""
    part = rbs.Part("dots", rbs.Everywhere(), dimension=2)
    part.place([[0.0, 0.0], [1.0, 0.0], [2.0, 1.0]], [1.0, 2.0, 3.0], spacing=1.0)
    part[density] = [10.0, 20.0, 30.0]
    return part


class Idle(rbs.Constitutive):
    """Adds nothing: a place where forces are summed."""

    adds = (force_density,)


def run(part, boundaries, tmp_path, steps):
    table = CSVExporter(part, [external_work], tmp_path / "work.csv")
    analysis = rbs.Analysis([*VelocityVerlet(part).step([Idle(part)], boundaries), table])
    analysis.run(steps=steps, dt=0.25, progress=False)


@pytest.mark.parametrize(
    "given",
    [{"velocity": (lambda t: t, None)}, {"displacement": (lambda t: t**2, None)}, {"force": (lambda t: 1.0 + t, None)}],
    ids=lambda given: next(iter(given)),
)
def test_reset_forgets_an_earlier_run(dots, tmp_path, given):
    """The same domain in a second analysis: as if it were new."""
    domain = BoundaryDomain(dots, [0, 2], **given)
    results = []
    for _ in range(2):
        dots[displacement], dots[velocity], dots[force_density], dots[external_work] = 0.0, (1.0, 2.0), 0.0, 0.0
        domain.reset()
        assert (domain._step, domain.state()) == (-1, {})
        run(dots, [domain], tmp_path, steps=1)  # its only step has the number of the last one before
        results.append((dots[displacement].tolist(), dots[velocity].tolist(), float(dots[external_work])))
    assert results[0] == results[1]


def test_the_state_of_a_motion_is_the_velocity_before(dots, tmp_path):
    motion = BoundaryDomain(dots, [0], velocity=(1.0, None))
    load = BoundaryDomain(dots, [1], force=(1.0, None))
    run(dots, [motion, load], tmp_path, steps=4)
    assert set(motion.state()) == {"value"}
    assert set(load.state()) == {"path", "value"}


class Ramp:
    def __init__(self, slope):
        self.slope = slope

    def __call__(self, time):
        return self.slope * time


def right_of(x):
    return rbs.Where(lambda points: points[:, 0] > x)


@pytest.mark.parametrize(
    ("region", "given"),
    [(right_of(0.5), Ramp(2.0)), (right_of(1.5), Ramp(1.0))],
    ids=["another object", "another region"],
)
def test_a_checkpoint_of_another_domain_is_refused(dots, tmp_path, region, given):
    def analysis(region, given):
        domain = BoundaryDomain(dots, region, velocity=(given, None))
        save = rbs.Checkpoint(tmp_path / "save.npz")
        dots[displacement], dots[velocity], dots[force_density] = 0.0, 0.0, 0.0
        return rbs.Analysis([*VelocityVerlet(dots).step([Idle(dots)], [domain]), save], dt=0.25)

    analysis(right_of(0.5), Ramp(1.0)).run(steps=2, progress=False)
    report = analysis(right_of(0.5), Ramp(1.0)).run(steps=3, resume=tmp_path / "save.npz", progress=False)
    assert report.steps == 1
    with pytest.raises(rbs.BadCheckpoint, match="differs in relation 1: BoundaryDomain 'dots'"):
        analysis(region, given).run(steps=4, resume=tmp_path / "save.npz", progress=False)


def test_identity_names_nodes_and_values(dots):
    one, other = (BoundaryDomain(dots, region, velocity=(1.0, None)).identity() for region in ([0, 1], [0, 2]))
    assert one["velocity"] == (1.0, None)
    assert one["nodes"].tolist() == [0, 1]
    assert one["values"] == other["values"]
