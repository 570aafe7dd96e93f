"""What belongs to the loops over compressed rows alone; their sums are tested beside those of a lattice."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import NotFinite
from rbs_plugins import (
    Criterion,
    CriticalBondEnergy,
    CriticalStretch,
    FractureDissipation,
    OrdinaryStateBased,
    PairwiseForce,
    StrainEnergy,
)
from rbs_plugins.fields import (
    deviatoric_modulus,
    dilatation,
    dilatational_modulus,
    displacement,
    force_density,
    intact,
    inverse_weighted_volume,
)
from rbs_plugins.loops.rows import ROWS, row_ranges
from rbs_plugins.testing import ends
from tests.unit.plugins.loops.doubles import body


def linear(stretch, c):
    return c * stretch


@pytest.mark.parametrize("nodes", [0, 1, ROWS - 1, ROWS, ROWS + 1, 5 * ROWS + 3])
def test_ranges_of_rows(nodes):
    ranges = row_ranges(nodes)
    assert ranges.shape == (-(-nodes // ROWS), 2)
    assert [i for begin, end in ranges for i in range(begin, end)] == list(range(nodes))


@pytest.mark.parametrize("dissipation", [False, True])
def test_positions_are_those_of_the_last_force(dissipation):
    """Energies are asked for at other displacements and must not move them."""
    part = body("list", (9, 8))
    start = part[displacement].copy()
    force = PairwiseForce(part, linear, CriticalStretch(1.0), c=2.0)
    energy = StrainEnergy(part, [force])
    analysis = rbs.Analysis([force, energy, *([FractureDissipation(part)] if dissipation else [])])
    for step in (1, 2, 3):
        part[displacement] = step * start
        analysis.run(steps=step, dt=0.1, force_dt=True, progress=False)
        before = force._loops.position.copy()
        assert np.array_equal(before, part.positions + step * start)
        part[displacement][...] = 0.0
        energy.apply(None)
        assert np.array_equal(force._loops.position, before)


def test_both_ends_of_a_bond_break_together_in_a_cloud():
    """Stretches are the same to the bit from both ends, however close to the limit."""
    rng = np.random.default_rng(5)
    part = rbs.Part("cloud", rbs.Everywhere(), dimension=3).place(rng.uniform(0, 1, (200, 3)), 1.0, spacing=0.1)
    part.connect(0.3)
    part[displacement] = 1e-3 * rng.standard_normal((200, 3))
    pairs = np.array(list(part.bonds))
    middle = np.median(np.abs(np.random.default_rng(1).normal(0, 5e-3, 1000)))
    force = PairwiseForce(part, linear, CriticalStretch(float(middle), mode="both"), c=1.0)
    rbs.Analysis([force]).run(steps=1, dt=1.0, force_dt=True, progress=False)
    holds = dict(zip(map(tuple, pairs.tolist()), part[intact].tolist(), strict=True))
    assert 0 < sum(holds.values()) < len(holds)
    assert all(holds[i, j] == holds[j, i] for i, j in holds)


def test_what_depends_on_both_ends_is_the_same_from_either_to_the_bit(rng):
    """Half of the pull of a solid times the extension, at limits that are what some bond holds but for a rounding."""
    part = rbs.Part("cloud", rbs.Everywhere(), dimension=2)
    part.place(rng.uniform(0, 1, (80, 2)), rng.uniform(0.01, 0.03, 80), spacing=0.1, thickness=1.0).connect(0.4)
    part[displacement] = 1e-3 * rng.standard_normal((80, 2))
    nodes, neighbors = ends(part)
    E = np.where(part.positions[:, 0] < 0.5, 1e9, 2e9)

    def solid(w0):
        part[dilatation] = 0.0
        force = OrdinaryStateBased(part, E, 0.1, CriticalBondEnergy(w0, form="secant"))
        rbs.Analysis([*force.feeders, force]).run(steps=1, dt=1.0, force_dt=True, progress=False)

    solid(1e30)
    y = part.positions + part[displacement]
    rest = np.linalg.norm(part.positions[neighbors] - part.positions[nodes], axis=1)
    extension = np.linalg.norm(y[neighbors] - y[nodes], axis=1) - rest
    per_m = part[inverse_weighted_volume]
    growing, stiff = (per_m * part[dilatational_modulus] * part[dilatation], per_m * part[deviatoric_modulus])
    pull = (growing[nodes] + growing[neighbors]) * rest + (stiff[nodes] + stiff[neighbors]) * extension
    limits = 0.5 * (pull * extension)[(extension > 0) & (pull > 0)]
    back = np.lexsort((nodes, neighbors))
    for w0 in rng.choice(limits, 40).tolist():
        part[intact] = 1
        solid(w0)
        assert 0 < np.count_nonzero(part[intact]) < len(rest)
        assert np.array_equal(part[intact], part[intact][back])


def test_each_end_of_a_list_answers_for_itself():
    """A criterion that differs between the ends breaks one direction only: a list can hold that."""
    warmth = rbs.Field("warmth", "node", "scalar", "K", "T", "Made up for this test.")
    part = rbs.Part("rod", rbs.Box(size=2.0)).discretize(1.0).connect(1.0, storage="list")
    part[warmth], part[displacement] = [0.0, 1.0], [[0.0], [0.5]]
    force = PairwiseForce(part, linear, Criterion(lambda warmth_i: warmth_i > 0.5), c=1.0)
    rbs.Analysis([force]).run(steps=1, dt=1.0, force_dt=True, progress=False)
    assert part[intact].tolist() == [1, 0]
    assert part[force_density].tolist() == [[0.5], [0.0]]


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_is_reported(bad):
    part = body("list", (9, 8))
    force = PairwiseForce(part, linear, CriticalStretch(1.0), c=2.0)
    analysis = rbs.Analysis([force])
    analysis.run(steps=1, dt=0.1, force_dt=True, progress=False)
    part[displacement][40, 1] = bad
    with np.errstate(invalid="ignore"), pytest.raises(NotFinite, match="displacement"):
        analysis.run(steps=2, dt=0.1, force_dt=True, progress=False)
