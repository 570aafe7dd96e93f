"""Relations of many small parts that are done in one call: to the bit what they do one by one."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import NotFinite
from rbs_plugins import CriticalStretch, PairwiseForce, StrainEnergy, VelocityVerlet
from rbs_plugins.fields import displacement, force_density, strain_energy_density, velocity
from tests.unit.plugins.loops.doubles import STORAGES, body

SHAPES = ((7, 6), (2, 5), (12, 9), (3, 3), (40, 35))  # the last one has several ranges


def linear(stretch, c):
    return c * stretch


def other(stretch, c):
    return c * stretch * (1.0 + stretch)


def bodies(*storages, shapes=SHAPES):
    """As many as there are shapes, with the storages in turn."""
    each = zip(range(len(shapes)), shapes, itertools.cycle(storages), strict=False)
    parts = [body(storage, shape, name=f"body {number}") for number, shape, storage in each]
    for number, part in enumerate(parts):
        part[velocity] = 3e-3 * np.random.default_rng(number).standard_normal(part.positions.shape)
    return parts


def moved(parts, release="at once", laws=(linear,), steps=6):
    """The calls of a scene that goes part by part, and what has come out of it."""
    relations = []
    for number, part in enumerate(parts):
        law = laws[number % len(laws)]
        # parameters differ from part to part
        force = PairwiseForce(part, law, CriticalStretch(0.009 + 1e-4 * number, release=release), c=2.0 + number)
        relations += VelocityVerlet(part).step([force])
    report = rbs.Analysis(relations).run(steps=steps, dt=0.05, force_dt=True, progress=False)
    fields = (displacement, velocity, force_density)
    return [row.name for row in report.rows], [
        [*(part[field].copy() for field in fields), part.bonds.intact.copy()] for part in parts
    ]


def alone(parts, **options):
    """The same for one part after the other, each in a scene of its own; `moved` numbers the parts of a scene."""
    found = []
    for number, part in enumerate(parts):
        law = PairwiseForce(part, linear, CriticalStretch(0.009 + 1e-4 * number, **options), c=2.0 + number)
        rbs.Analysis(VelocityVerlet(part).step([law])).run(steps=6, dt=0.05, force_dt=True, progress=False)
        fields = (displacement, velocity, force_density)
        found.append([*(part[field].copy() for field in fields), part.bonds.intact.copy()])
    return found


@pytest.mark.parametrize("storage", STORAGES)
@pytest.mark.parametrize("release", ["at once", "next step"])
def test_many_parts_in_one_call(storage, release):
    names, together = moved(bodies(storage), release)
    assert any(name.startswith("PairwiseForce, ") for name in names), names
    before = [part.bonds.intact for part in bodies(storage)]
    for found, wanted, start in zip(together, alone(bodies(storage), release=release), before, strict=True):
        for one, two in zip(found, wanted, strict=True):
            assert np.array_equal(one, two)
        assert np.count_nonzero(found[-1]) <= np.count_nonzero(start)
    assert any(np.count_nonzero(f[-1]) < np.count_nonzero(s) for f, s in zip(together, before, strict=True))


@pytest.mark.parametrize("storage", STORAGES)
def test_only_loops_of_one_law_are_put_together(storage):
    names, together = moved(bodies(storage, shapes=[(7, 6), (8, 6), (9, 6), (10, 6)]), laws=(linear, other))
    assert sum(name.startswith("PairwiseForce, 2 parts") for name in names) == 2, names
    _, single = moved(bodies(storage, shapes=[(7, 6)]))
    for one, two in zip(together[0], single[0], strict=True):
        assert np.array_equal(one, two)


@pytest.mark.parametrize("storage", STORAGES)
def test_bodies_that_start_at_rest_wake_up(storage):
    """The forces at the start are found part by part, where nothing is displaced yet."""

    def resting():
        parts = bodies(storage)
        for part in parts:
            part[displacement] = 0.0
        return parts

    for found, wanted in zip(moved(resting())[1], alone(resting()), strict=True):
        assert found[2].any()
        for one, two in zip(found, wanted, strict=True):
            assert np.array_equal(one, two)


def test_list_and_lattice_stay_apart():
    names, _ = moved(bodies(*STORAGES, shapes=[(7, 6)] * 4))
    assert sum(name.startswith("PairwiseForce, 2 parts") for name in names) == 2, names


@pytest.mark.parametrize("storage", STORAGES)
def test_energies_of_parts_that_are_done_together(storage):
    """A measure asks the force of its own part, whose clock is that of the common call."""

    def aging(stretch, time, c):
        return c * stretch * (1.0 + time)

    found = []
    for count in (3, 1):
        parts = bodies(storage, shapes=SHAPES[:count])
        forces = [PairwiseForce(part, aging, c=2.0) for part in parts]
        energies = [StrainEnergy(part, [force]) for part, force in zip(parts, forces, strict=True)]
        rbs.Analysis([*forces, *energies]).run(steps=3, dt=0.5, force_dt=True, progress=False)
        found.append(parts[0][strain_energy_density].copy())
    assert found[0].max() > 0
    assert np.array_equal(*found)


@pytest.mark.parametrize("storage", STORAGES)
def test_the_part_that_overflows_is_named(storage):
    parts = [rbs.Part(name, rbs.Box(size=(4.0, 3.0))).discretize(1.0).connect(1.5, storage=storage) for name in "abc"]
    forces = [PairwiseForce(part, linear, c=1.0) for part in parts]
    for part in parts:
        part[displacement] = 0.01 * part.positions
    analysis = rbs.Analysis(forces)
    analysis.run(steps=1, dt=1.0, force_dt=True, progress=False)
    parts[1][displacement][2, 0] = np.inf
    with np.errstate(invalid="ignore"), pytest.raises(NotFinite, match="part 'b'"):
        analysis.run(steps=2, dt=1.0, force_dt=True, progress=False)
