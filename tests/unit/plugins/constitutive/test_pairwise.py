"""Bond loops against sums written out in numpy, for laws that ask for everything a law can ask for."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import Field
from rbs_plugins import BondBased, Criterion, CriticalStretch, PairwiseForce, StrainEnergy
from rbs_plugins.constitutive.pairwise import hardening
from rbs_plugins.fields import (
    density,
    displacement,
    force_density,
    strain_energy,
    strain_energy_density,
    volume,
    volume_fraction,
)
from rbs_plugins.testing import body, ends

temperature = Field("temperature", "node", "scalar", "K", "T", "Made up for these tests.")
factor = Field("factor", "bond", "scalar", "1", "λ", "Made up for these tests.")


def everything(stretch, extension, length, reference_length, time, dt, c, factor, temperature_i, temperature_j, k=0.25):
    """The same from both ends, if `factor` is."""
    warm = 0.5 * (temperature_i + temperature_j) / 300.0
    return c * factor * warm * (stretch + k * extension / (length + reference_length)) * (1.0 + time) + 1e10 * dt


def failing(stretch, s0, temperature_i, temperature_j):
    """Warm bonds hold less."""
    return stretch > s0 * (1.0 - 0.001 * (temperature_i + temperature_j - 500.0))


def furnished(dimension, cloud, notched=True):
    part = body(dimension, cloud, notched=notched)
    rng = np.random.default_rng(11)
    part[temperature] = rng.uniform(200.0, 400.0, len(part))
    i, j = ends(part)
    part[factor] = 1.0 + 0.1 * np.sin(i + j)  # any symmetric numbers
    part[displacement] = rng.uniform(-2e-5, 2e-5, part.positions.shape)
    return part


def bonds_of(part):
    """Kinematics of every directed bond, by numpy."""
    i, j = ends(part)
    y = part.positions + part[displacement]
    d = y[j] - y[i]
    length, rest = np.linalg.norm(d, axis=1), np.linalg.norm(part.positions[j] - part.positions[i], axis=1)
    return i, j, d / length[:, None], length, rest


def gathered(part, i, values):
    total = np.zeros((len(part), *values.shape[1:]))
    np.add.at(total, i, values)
    return total


def step(*relations, dt=0.5, **options):
    analysis = rbs.Analysis(relations)
    analysis.run(steps=1, dt=dt, force_dt=True, progress=False, **options)
    return analysis


@pytest.mark.parametrize(
    ("dimension", "cloud", "fraction"),
    [
        (1, "grid", "linear"), (1, "jittered", "none"), (2, "grid", "none"), (2, "jittered", "linear"),
        (3, "grid", "linear"), (3, "jittered", "none"),
    ],
)  # fmt: skip
def test_forces_and_energies_are_the_sums_of_the_book(dimension, cloud, fraction):
    """L_i = Σ μ f β V_j d/|d| and W_i = ½ Σ μ w β V_j, bond by bond in numpy, with everything switched on."""
    part = furnished(dimension, cloud)
    law = PairwiseForce(part, everything, c=3e18, k=0.5, potential=energy_of_nobody, partial_volume=fraction, e0=7.0)
    measure = StrainEnergy(part, [law])
    step(law, measure)
    i, j, n, length, rest = bonds_of(part)
    beta = part[volume_fraction] if fraction == "linear" else np.ones(len(i))
    assert (beta.min() < 1) == (fraction == "linear")
    f = everything(
        length / rest - 1, length - rest, length, rest, 0.5, 0.5, 3e18, part[factor], part[temperature][i],
        part[temperature][j], 0.5,
    )  # fmt: skip
    holds = part.bonds.intact
    weight = holds * beta * part[volume][j]
    wanted = gathered(part, i, (weight * f)[:, None] * n)
    size = gathered(part, i, np.abs(weight * f))
    # both sums lose at most an ulp of the sizes per term; a stretch of 0.01 loses two digits of its sixteen
    error = np.abs(part[force_density] - wanted).max(axis=1)
    assert (error <= 1e-12 * size).all()
    held = gathered(part, i, 0.5 * weight * 7.0 * part[temperature][i] * length)
    np.testing.assert_allclose(part[strain_energy_density], held, rtol=1e-13)
    assert part[strain_energy] == pytest.approx(math.fsum(held * part[volume]), rel=1e-13)
    assert law.items() == len(part.bonds)


def energy_of_nobody(e0, temperature_i, length):
    """Not the potential of any law here: shows that it is called with its own arguments."""
    return e0 * temperature_i * length


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_breaking_by_a_criterion_of_fields(dimension):
    part = furnished(dimension, "jittered")
    before = part.bonds.intact.copy()
    part[displacement] *= 10
    law = PairwiseForce(part, hardening, Criterion(failing, s0=0.1), c=1e18)
    i, j, n, length, rest = bonds_of(part)
    fails = failing(length / rest - 1, 0.1, part[temperature][i], part[temperature][j])
    assert 0 < np.count_nonzero(fails & before) < np.count_nonzero(before) / 2
    step(law)
    assert np.array_equal(part.bonds.intact, before & ~fails)
    pull = part.bonds.intact * hardening(length / rest - 1, 1e18) * part[volume][j]
    wanted = gathered(part, i, pull[:, None] * n)
    assert (np.abs(part[force_density] - wanted).max(axis=1) <= 1e-12 * gathered(part, i, np.abs(pull))).all()


def test_bonds_break_only_within_their_region():
    part = furnished(2, "grid", notched=False)
    left = rbs.HalfSpace((0.0125, 0.0), (-1.0, 0.0))
    law = PairwiseForce(part, hardening, CriticalStretch(0.001, within=left), c=1e18)
    step(law)
    i, j, _, length, rest = bonds_of(part)
    inside = left.contains(part.positions)
    fails = (length / rest - 1 > 0.001) & inside[i] & inside[j]
    assert fails.any()
    assert (length / rest - 1 > 0.001)[~(inside[i] & inside[j])].any()
    assert np.array_equal(part.bonds.intact, ~fails)


# -- stable step ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_stable_step_is_that_of_silling_and_askari(dimension):
    """Δt = sqrt(2ρ / Σ c V/|ξ|), at the worst node (Silling & Askari 2005, eq. 35)."""
    part = furnished(dimension, "jittered", notched=False)
    steel = BondBased(part, c=2e18, partial_volume="linear")
    i, j, _, _, rest = bonds_of(part)
    stiffness = gathered(part, i, 2e18 * part[volume_fraction] * part[volume][j] / rest)
    wanted = np.sqrt(2 * part[density] / stiffness).min()
    assert rbs.Analysis([steel]).stable_dt() == pytest.approx(wanted, rel=1e-9)  # slope by a difference of 1e-6
