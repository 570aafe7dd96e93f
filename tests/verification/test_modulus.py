"""The modulus that a plate really has: energy and force of given strains in the bulk against classical elasticity.

Two errors, told apart (Bobaru et al. 2009):

* m-convergence: at a fixed horizon the sum over the family becomes the integral as m = δ/Δx grows. The circle cuts
  cells; the integral of r·r dr dφ over a disk that is wrong by half a cell diagonal, 0.71 Δx, all around is wrong by
  3 · 0.71/m. That is the bound that is asked for; the sum does better, as errors cancel around the circle.
* δ-convergence: at a fixed m the modulus stays what the sum gives; what converges, with order two, is the force of a
  strain that varies, as the family shrinks to a point.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import BondBased, StrainEnergy
from rbs_plugins.fields import displacement, force_density, strain_energy_density

E, NU, THICKNESS = 70e9, 1 / 3, 2e-3
SIZE = 1e-6  # of strains: so small that stretch and strain are the same to six digits
STRAINS = {
    "pulled along x": [[1.0, 0.0], [0.0, 0.0]],
    "pulled all around": [[1.0, 0.0], [0.0, 1.0]],
    "sheared": [[0.0, 0.5], [0.5, 0.0]],
    "pulled and pressed": [[1.0, 0.0], [0.0, -1.0]],
}


def classical(strain):
    """Strain energy density of plane stress, J/m^3."""
    e = np.array(strain) * SIZE
    return E / (2 * (1 - NU**2)) * ((1 - NU) * (e * e).sum() + NU * np.trace(e) ** 2)


def ratio_of_energy(m, strain, partial_volume="none"):
    """Energy density in the middle of a plate over that of classical elasticity; the middle has a whole family."""
    cells = 2 * math.ceil(m) + 5
    part = rbs.Part("plate", rbs.Box(size=(float(cells), float(cells)))).discretize(1.0, thickness=THICKNESS)
    part.connect(m)
    part[displacement] = lambda X: SIZE * X @ np.array(strain)
    steel = BondBased(part, E=E, partial_volume=partial_volume)
    rbs.Analysis([steel, StrainEnergy(part, [steel])]).run(steps=1, dt=1.0, force_dt=True, progress=False)
    return float(part[strain_energy_density][len(part) // 2]) / classical(strain)


def ratio_of_sums(m, strain):
    """The same by a sum over a lattice that is written here."""
    reach = np.arange(-math.floor(m), math.floor(m) + 1)
    x, y = (a.ravel() for a in np.meshgrid(reach, reach))
    r = np.hypot(x, y)
    x, y, r = (a[(r > 0) & (r <= m)] for a in (x, y, r))
    xi = np.stack([x, y])
    stretch = np.einsum("im,ij,jm->m", xi, np.array(strain) * SIZE, xi) / r**2
    c = 9 * E / (math.pi * THICKNESS * m**3)
    return float((0.25 * c * stretch**2 * r).sum() * THICKNESS) / classical(strain)


@pytest.mark.parametrize("strain", STRAINS.values(), ids=STRAINS)
@pytest.mark.parametrize("m", [2.0, 3.015, 6.0, 9.5])
def test_energy_is_the_sum_over_the_lattice(m, strain):
    """To 5e-6: at a strain of 1e-6 stretch and strain differ by as much. (At m = 3.015 the plate is 4 % too stiff.)"""
    assert ratio_of_energy(m, strain) == pytest.approx(ratio_of_sums(m, strain), rel=5e-6)


def test_linear_partial_volume_only_takes_away():
    """Cells whose middles lie beyond the horizon are in no family, so half of the rim is missing: 14 % at m = 3.015."""
    whole = [ratio_of_energy(3.015, strain) for strain in STRAINS.values()]
    partial = [ratio_of_energy(3.015, strain, "linear") for strain in STRAINS.values()]
    assert all(0.84 < p < 0.88 < w for p, w in zip(partial, whole, strict=True))


def rms(errors):
    return math.sqrt(np.mean(np.square(errors)))


@pytest.mark.verify
@pytest.mark.parametrize("strain", STRAINS.values(), ids=STRAINS)
def test_m_convergence(strain):
    """Below the bound at every m, and in the mean over an octave of m four times smaller for m four times larger.

    The mean, because the error of a single m can be anything below the bound, zero as well. The sum stands in for the
    part in the octaves, as the test above shows that they are the same.
    """
    for m in (2, 3, 6, 12, 24):
        assert abs(ratio_of_energy(float(m), strain) - 1) < 3 * math.sqrt(0.5) / m
    coarse, fine = (rms([ratio_of_sums(float(m), strain) - 1 for m in ms]) for ms in (range(8, 16), range(32, 64)))
    assert coarse / fine > 4


@pytest.mark.verify
@pytest.mark.parametrize("strain", STRAINS.values(), ids=STRAINS)
def test_m_convergence_with_linear_partial_volume(strain):
    """It converges too, and from below, but with order one: the half of the rim that is missing is Δx/2 wide."""
    ratios = [3.0, 6.0, 12.0, 24.0]
    errors = [1 - ratio_of_energy(m, strain, "linear") for m in ratios]
    assert all(0 < error < 3 * math.sqrt(0.5) / m for error, m in zip(errors, ratios, strict=True))
    assert -np.polyfit(np.log(ratios), np.log(errors), 1)[0] == pytest.approx(1.0, abs=0.35)


@pytest.mark.verify
@pytest.mark.parametrize("m", [3.015, 4.015])
@pytest.mark.parametrize("direction", ["along", "across"])
def test_delta_convergence(m, direction):
    """The force of u = sin(k x), pressure along x or shear across: −C k² u with the modulus C that the sum gives.

    Of second order in δ: the next term is (kδ)²/10 and less of the error.
    """
    wave = 2 * math.pi
    axis = {"along": 0, "across": 1}[direction]
    strain = {"along": [[1.0, 0.0], [0.0, 0.0]], "across": [[0.0, 0.5], [0.5, 0.0]]}[direction]
    modulus = {"along": E / (1 - NU**2), "across": E / (2 * (1 + NU))}[direction]
    errors = []
    for n in (40, 80, 160):
        spacing = 1.0 / n
        part = rbs.Part("plate", rbs.Box(size=(1.5, 15 * spacing))).discretize(spacing, thickness=THICKNESS)
        part.connect(m * spacing)
        part[displacement] = 0.0
        part[displacement][:, axis] = SIZE * np.sin(wave * part.positions[:, 0])
        steel = BondBased(part, E=E)
        rbs.Analysis([steel]).run(steps=1, dt=1.0, force_dt=True, progress=False)
        middle = np.flatnonzero((np.abs(part.positions[:, 0]) < 0.4) & (np.abs(part.positions[:, 1]) < 0.6 * spacing))
        wanted = -modulus * ratio_of_sums(m, strain) * wave**2 * part[displacement][middle, axis]
        miss = np.abs(part[force_density][middle, axis] - wanted).max()
        errors.append(float(miss / np.abs(wanted).max()))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 1e-2
    assert orders == pytest.approx(2.0, abs=0.1)
