"""The peridynamic stress balances the forces: sections carry what the nodes behind them feel."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import BondBased, OrdinaryStateBased, PeridynamicStress, Stress
from rbs_plugins.fields import displacement, force_density, peridynamic_stress, stress, volume
from rbs_plugins.measures.crossing import passed
from rbs_plugins.testing import body


def run(*relations):
    rbs.Analysis(list(relations)).run(steps=1, dt=1.0, force_dt=True, progress=False)


MODELS = [
    (BondBased, {}),
    (BondBased, {"surface_correction": "energy"}),
    (BondBased, {"surface_correction": "volume", "linear": True}),
    (BondBased, {"partial_volume": "linear"}),
    (OrdinaryStateBased, {"influence": "conical"}),
]


@pytest.mark.parametrize(("model", "arguments"), MODELS)
@pytest.mark.parametrize("cloud", ["grid", "lattice"])
@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_sections_carry_the_forces(dimension, cloud, model, arguments, rng):
    """In any displacement, with broken bonds and at surfaces: ∫ ν·n over cells is the mean force at their two faces."""
    part = body(dimension, cloud)
    part[displacement] = rng.uniform(-1e-5, 1e-5, part.positions.shape)
    nu = {} if dimension == 1 or model is BondBased else {"nu": 0.1}
    force = model(part, E=1e9, **nu, **arguments)
    run(*force.feeders, force, PeridynamicStress(part, force))
    column = np.rint((part.positions[:, 0] - part.positions[:, 0].min()) / part.spacing).astype(int)
    count = column.max() + 1
    felt = np.zeros((count, dimension))
    np.add.at(felt, column, part[force_density] * part[volume][:, None])
    behind = np.cumsum(felt[::-1], axis=0)[::-1]  # what the nodes of these columns and all behind feel
    faces = -np.concatenate([behind, np.zeros((1, dimension))])
    carried = np.zeros((count, dimension))
    np.add.at(carried, column, part[peridynamic_stress][:, :, 0] * part[volume][:, None] / part.spacing)
    np.testing.assert_allclose(carried, 0.5 * (faces[1:] + faces[:-1]), atol=1e-9 * np.abs(faces).max())


@pytest.mark.parametrize(("model", "arguments"), MODELS[:4])
@pytest.mark.parametrize("cloud", ["jittered", "grid", "lattice"])
def test_all_moments_are_there(cloud, model, arguments, rng):
    """The sum over all cells is that of the collapsed stress."""
    part = body(2, cloud)
    part[displacement] = rng.uniform(-1e-5, 1e-5, part.positions.shape)
    steel = model(part, E=1e9, **arguments)
    run(steel, PeridynamicStress(part, steel), Stress(part, steel))
    sizes = part[volume][:, None, None]
    wanted = (part[stress] * sizes).sum(axis=0)
    np.testing.assert_allclose((part[peridynamic_stress] * sizes).sum(axis=0), wanted, atol=1e-9 * np.abs(wanted).max())


def test_cells_that_a_bond_passes():
    assert [(cell.tolist(), share) for cell, share in passed((2,))] == [([0], 0.25), ([1], 0.5), ([2], 0.25)]
    cells = {tuple(cell): share for cell, share in passed((2, -1))}
    assert cells == pytest.approx({(0, 0): 0.25, (1, 0): 0.25, (1, -1): 0.25, (2, -1): 0.25})
    assert [(cell.tolist(), share) for cell, share in passed((1, 1))] == [([0, 0], 0.5), ([1, 1], 0.5)]
