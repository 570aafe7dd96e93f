"""A pulse in a bar against d'Alembert: its speed to nine digits, its shape with the order of the horizon.

Bond-based peridynamics disperses: ω² = (2cA/ρ) Σ β_k V_k/A (1 − cos k ξ_k)/ξ_k. At long waves ω = c0 k exactly if the
family has its exact stiffness, Σ β ξ Δx = δ²/2 on either side, which the linear partial volume gives for whole ratios
δ/Δx (tests/unit/plugins/constitutive/test_corrections.py). So:

* the centre of gravity of a pulse travels with dω/dk at k = 0, which is c0 exactly, whatever dispersion does to its
  shape (∫ x u dx / ∫ u dx is i d/dk of the logarithm of the transform at k = 0);
* the shape is off by the next term of ω, of second order in δ, and by that of the time step, of second order in dt.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import BondBased, KineticEnergy, StrainEnergy, VelocityVerlet
from rbs_plugins.fields import density, displacement, kinetic_energy, strain_energy, velocity

E, RHO, AREA = 210e9, 7800.0, 2e-4
SPEED = math.sqrt(E / RHO)
WIDTH, HEIGHT, TRAVEL = 0.03, 1e-5, 0.25  # m


def gauss(x):
    return HEIGHT * np.exp(-((x / WIDTH) ** 2) / 2)


def pulse(n, *, ratio=3.0, partial_volume="linear", moving=False):
    """A bar of 1 m with a pulse in its middle after it has travelled a quarter of it; ends are 8 widths away."""
    bar = rbs.Part("bar", rbs.Box(size=1.0)).discretize(1.0 / n, area=AREA).connect(ratio / n)
    bar[density] = RHO
    x = bar.positions[:, 0]
    bar[displacement] = gauss(x)[:, None]
    bar[velocity] = (SPEED * x / WIDTH**2 * gauss(x))[:, None] if moving else 0.0
    steel = BondBased(bar, E=E, partial_volume=partial_volume)
    relations = [*VelocityVerlet(bar).step([steel]), KineticEnergy(bar), StrainEnergy(bar, [steel])]
    analysis = rbs.Analysis(relations)
    end = TRAVEL / SPEED
    steps = math.ceil(end / (0.5 * analysis.stable_dt()))
    analysis.run(steps=steps, dt=end / steps, progress=False)
    return bar, x, bar[displacement][:, 0].copy()


def centre(x, u):
    """Centre of gravity of what runs to the right."""
    right = x > 0
    return float(x[right] @ u[right] / u[right].sum())


@pytest.mark.parametrize("ratio", [2.0, 3.0, 4.0])
def test_speed(ratio):
    """Sums of a Gauss curve over 12 points per width are exact to 1e-16; round-off of 500 steps is far below 1e-9.

    The tail that the other half leaves behind the middle is e^(−8²/2), 1e-14, times its distance.
    """
    _, x, u = pulse(400, ratio=ratio)
    assert centre(x, u) == pytest.approx(TRAVEL, rel=1e-9)


def test_speed_without_partial_volume_is_that_of_a_stiffer_bar():
    """With whole cells at the horizon Σ ξ Δx = δ² (m + 1)/(2m): for m = 3 the bar is 4/3 as stiff as it should be."""
    _, x, u = pulse(400, partial_volume="none")
    assert centre(x, u) == pytest.approx(TRAVEL * math.sqrt(4 / 3), rel=1e-9)


def test_shape_converges_with_order_two():
    """max |u − u_exact| over the height, for δ = 3/200, 3/400, 3/800 m and dt proportional to δ.

    The next term of the error is smaller by (δ/width)²/10 or so: 0.6 % at n = 400, which moves the order by 0.01.
    """
    errors = []
    for n in (200, 400, 800):
        _, x, u = pulse(n)
        exact = 0.5 * (gauss(x - TRAVEL) + gauss(x + TRAVEL))
        errors.append(np.abs(u - exact).max() / HEIGHT)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 2e-3
    assert orders[0] == pytest.approx(2.0, abs=0.2)
    assert orders[1] == pytest.approx(2.0, abs=0.05)


def test_pulse_that_runs_one_way():
    """With the velocity of d'Alembert's right-going wave nothing runs to the left but what dispersion leaves.

    Internal forces do not move the centre of gravity of ∫ u dx, so it goes on with the c0 of its start, exactly.
    """
    _, x, u = pulse(400, moving=True)
    assert x @ u / u.sum() == pytest.approx(TRAVEL, rel=1e-9)
    assert np.abs(u[x < 0]).max() < 5e-3 * HEIGHT
    assert u.max() == pytest.approx(HEIGHT, rel=0.02)


def test_energy_of_a_running_wave_is_half_motion_and_half_strain():
    bar, _, _ = pulse(400, moving=True)
    total = AREA * E * HEIGHT**2 * math.sqrt(math.pi) / (2 * WIDTH)  # ∫ E A u_x² dx of the Gauss curve
    assert bar[kinetic_energy] == pytest.approx(total / 2, rel=5e-3)
    assert bar[strain_energy] == pytest.approx(total / 2, rel=5e-3)
