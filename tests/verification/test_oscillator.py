"""Two nodes on a spring: velocity Verlet against the exact solution of its own recursion, and against the circle."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import BondBased, VelocityVerlet
from rbs_plugins.fields import density, displacement, velocity

VOLUMES, RHO, LENGTH, C = np.array([2e-3, 5e-3]), np.array([1500.0, 700.0]), 0.1, 1e12
# f_1 V_1 = c s V_1 V_2 = -f_2 V_2, s = (u_2 - u_1) / ξ: the difference of displacements swings with
OMEGA = math.sqrt(C / LENGTH * (VOLUMES[1] / RHO[0] + VOLUMES[0] / RHO[1]))
MASSES = RHO * VOLUMES


class Recorder(rbs.Measure):
    """Keeps displacement and velocity of every step."""

    reads = (displacement, velocity)

    def begin(self, clock):
        self.u, self.v = [], []

    def apply(self, clock):
        self.u.append(self[displacement].copy())
        self.v.append(self[velocity].copy())


def swing(phase, steps, stretch=0.05, whole=0.0):
    """Displacements and velocities (steps, 2) of a swing without momentum, ω dt = phase."""
    part = rbs.Part("pair", rbs.Everywhere(), dimension=1)
    part.place([[0.3], [0.3 + LENGTH]], VOLUMES, spacing=LENGTH).connect(1.5 * LENGTH)
    part[density] = RHO
    share = np.array([-MASSES[1], MASSES[0]]) / MASSES.sum()  # the centre of mass rests
    part[displacement] = (share * stretch * LENGTH)[:, None]
    recorder = Recorder(part)
    relations = [*VelocityVerlet(part).step([BondBased(part, c=C)]), recorder]
    rbs.Analysis(relations).run(steps=steps, dt=phase / OMEGA, force_dt=True, progress=False)
    return np.array(recorder.u)[:, :, 0], np.array(recorder.v)[:, :, 0], share * stretch * LENGTH


@pytest.mark.parametrize("phase", [0.05, 0.5, 1.0, 1.9])
def test_discrete_frequency_is_exact(phase):
    """u_n = A cos(n φ) with cos φ = 1 − (ω dt)²/2, and v_n = −A (sin φ / dt) sin(n φ), for two thousand steps.

    Both follow from u_{n+1} − 2 u_n + u_{n−1} = −(ω dt)² u_n. In 1-D the stretch is linear in the displacements, so
    nothing is neglected. Round-off of the stretch is ε / 0.05 of it, 4e-15, and adds up like a random walk, or linearly
    at worst, over 2000 steps, with a factor 1/sin φ <= 20: 2e-10. The claim is 1e-9 of the amplitude.
    """
    steps = 2000
    u, v, amplitude = swing(phase, steps)
    angle = math.acos(1 - phase**2 / 2)
    n = np.arange(1, steps + 1)[:, None]
    assert np.abs(u - amplitude * np.cos(n * angle)).max() <= 1e-9 * np.abs(amplitude).max()
    speed = amplitude * math.sin(angle) / (phase / OMEGA)
    assert np.abs(v + speed * np.sin(n * angle)).max() <= 1e-9 * np.abs(speed).max()


def test_the_discrete_frequency_is_not_the_true_one():
    """The test above would notice: at ω dt = 0.05 the phases differ by (ω dt)³/24 a step, 1e-2 after 2000 steps."""
    steps, phase = 2000, 0.05
    u, _, amplitude = swing(phase, steps)
    true = amplitude * np.cos(np.arange(1, steps + 1)[:, None] * phase)
    assert np.abs(u - true).max() > 5e-3 * np.abs(amplitude).max()


def test_centre_of_mass_rests():
    """The forces of both ends differ by a rounding; what it leaves in the velocity of the centre adds up in its way."""
    steps, phase = 500, 0.5
    u, v, amplitude = swing(phase, steps)
    rounding = np.sqrt(steps) * 4e-16 * phase  # of velocities that steps change by the share `phase`
    assert np.abs(v @ MASSES).max() <= rounding * np.abs(v).max() * MASSES.max()
    assert np.abs(u @ MASSES).max() <= steps * phase * rounding * np.abs(amplitude @ np.diag(MASSES)).max()


def test_order_two_in_dt():
    """Error after one swing against the cosine, over a factor 8 in dt: the neglected term is (ω dt)² smaller."""
    counts = [40, 80, 160, 320]
    errors = []
    for count in counts:
        u, v, amplitude = swing(2 * math.pi / count, count)
        miss = np.hypot(np.abs(u[-1] - amplitude).max(), np.abs(v[-1]).max() / OMEGA)
        errors.append(miss / np.abs(amplitude).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.abs(orders - 2).max() < 0.02  # (2π/40)² = 0.025 at most in the ratio
    # and its size: the phase is ahead by n (ω dt)³/24 = 2π (ω dt)²/24
    assert errors[-1] == pytest.approx(2 * math.pi * (2 * math.pi / 320) ** 2 / 24, rel=0.01)


def test_unstable_beyond_two():
    """The bound of the scheme is ω dt = 2: a hair above it the amplitude explodes, a hair below it does not."""
    below, _, amplitude = swing(1.999, 400)
    above, _, _ = swing(2.001, 400)
    assert np.abs(below).max() <= 1.001 * np.abs(amplitude).max()
    # cosh: e^(n acosh(2.001²/2 − 1)), acosh = 0.0632, 400 steps; stop before numbers turn around each other
    assert np.abs(above[:60]).max() > 5 * np.abs(amplitude).max()
