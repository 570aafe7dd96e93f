"""Fields of nodes may change while a run goes on: loops see what they hold now, however bonds are stored."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import Criterion, Damage, PairwiseForce, StrainEnergy
from rbs_plugins.fields import damage, displacement, force_density, strain_energy_density, volume
from tests.unit.plugins.loops.doubles import STORAGES, assert_close, body, warmth


class Changes(rbs.Boundary):
    """Adds, in every step, the number of the node to a field."""

    def __init__(self, part, field, factor):
        super().__init__(part)
        self.updates = (field,)
        self._field, self._factor = field, factor

    def apply(self, clock):
        self[self._field] += self._factor * np.arange(1.0, len(self.part) + 1)


def linear(stretch, c):
    return c * stretch


def warm(stretch, warmth_i, warmth_j, c):
    return c * (stretch - 2e-3 * (warmth_i + warmth_j))


def warm_limit(stretch, warmth_i, warmth_j, s0):
    return stretch > s0 - 1e-4 * (warmth_i + warmth_j)


def seen(part, change, force, fields=(force_density, strain_energy_density, damage)):
    relations = [change, force, StrainEnergy(part, [force]), Damage(part)]
    rbs.Analysis(relations).run(steps=4, dt=0.1, force_dt=True, progress=False)
    found = {field.name: part[field].copy() for field in fields}
    return {**found, "intact": part.bonds.intact.copy(), "frequency": force.squared_frequency()}


SCENES = {
    "law": lambda part: (Changes(part, warmth, 0.1), PairwiseForce(part, warm, c=2.0)),
    "criterion": lambda part: (
        Changes(part, warmth, 0.1),
        PairwiseForce(part, linear, Criterion(warm_limit, s0=0.02), c=2.0),
    ),
    "volume": lambda part: (Changes(part, volume, 1e-3), PairwiseForce(part, linear, c=2.0)),
}


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("hole", [False, True])
def test_what_a_relation_changes_in_every_step(scene, hole):
    parts = [body(storage, (9, 8), hole=hole) for storage in STORAGES]
    one, two = (seen(part, *SCENES[scene](part)) for part in parts)
    assert [part.bonds.storage for part in parts] == list(STORAGES)
    start = body("list", (9, 8), hole=hole).bonds.intact
    assert np.array_equal(one["intact"], start) == (scene != "criterion")
    assert_close(one, two, parts[0])


@pytest.mark.parametrize("storage", STORAGES)
def test_what_is_set_between_two_runs(storage):
    """The second run on a part gives what the same part gives in its first one."""
    late, fresh = (body(storage, (9, 8)) for _ in range(2))
    forces = [PairwiseForce(part, warm, c=2.0) for part in (late, fresh)]
    analysis = rbs.Analysis([forces[0], Damage(late)])
    analysis.run(steps=1, dt=0.1, force_dt=True, progress=False)
    for part in (late, fresh):
        part[warmth] = np.linspace(0, 1, len(part))
        part[volume] = np.linspace(1, 2, len(part))
        part[displacement] = 1e-3 * part.positions
    analysis.run(steps=2, dt=0.1, force_dt=True, progress=False)
    rbs.Analysis([forces[1], Damage(fresh)]).run(steps=1, dt=0.1, force_dt=True, progress=False)
    for field in (force_density, damage):
        assert late[field].any()
        assert np.array_equal(late[field], fresh[field])
