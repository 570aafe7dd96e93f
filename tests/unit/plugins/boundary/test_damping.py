"""Viscous damping: against the closed forms of its own recursion and of the oscillator, its work and its step."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import (
    BondBased,
    CSVExporter,
    KineticEnergy,
    StrainEnergy,
    SymplecticEuler,
    VelocityVerlet,
    ViscousDamping,
)
from rbs_plugins.fields import (
    density,
    displacement,
    force_density,
    kinetic_energy,
    strain_energy,
    velocity,
    viscous_dissipation,
    volume,
)

RHO, LENGTH, C = 1000.0, 0.1, 1e12
OMEGA = math.sqrt(C / LENGTH * 2e-3 / RHO)  # of two equal nodes of 1e-3 m^3


def pair():
    """Two nodes on a spring, drawn apart, without momentum."""
    part = rbs.Part("pair", rbs.Everywhere(), dimension=1)
    part.place([[0.0], [LENGTH]], 1e-3, spacing=LENGTH).connect(1.5 * LENGTH)
    part[density] = RHO
    part[displacement] = [[-1e-3], [1e-3]]
    part[velocity] = 0.0
    return part


class Recorder(rbs.Measure):
    """Keeps the displacement of the second node."""

    reads = (displacement,)

    def begin(self, clock):
        self.u = [float(self[displacement][1, 0])]

    def apply(self, clock):
        self.u.append(float(self[displacement][1, 0]))


def swing(ratio, phase, steps, scheme=VelocityVerlet, **options):
    """Displacements (steps + 1,) with the damping ratio, ω dt = phase."""
    part = pair()
    damping = ViscousDamping(part, **(options or {"ratio": ratio, "frequency": OMEGA}))
    recorder = Recorder(part)
    relations = [*scheme(part).step([BondBased(part, c=C)], [damping]), recorder]
    rbs.Analysis(relations).run(steps=steps, dt=phase / OMEGA, force_dt=True, progress=False)
    return np.array(recorder.u)


@pytest.mark.parametrize("ratio", [0.05, 0.3, 0.7])
def test_recursion_is_solved_exactly(ratio):
    """u_{n+1} − 2u_n + u_{n−1} = −(ω dt)² u_n − γ dt (u_n − u_{n−1}): a spiral r^n cos(nφ), known to the last digit.

    From the first two values on, with r² = 1 − γ dt and 2 r cos φ = 2 − γ dt − (ω dt)².
    """
    phase, steps = 0.2, 300
    u = swing(ratio, phase, steps)
    gamma = 2 * ratio * phase
    r = math.sqrt(1 - gamma)
    angle = math.acos((2 - gamma - phase**2) / (2 * r))
    n = np.arange(steps + 1)
    sine = (u[1] / r - u[0] * math.cos(angle)) / math.sin(angle)
    wanted = r**n * (u[0] * np.cos(n * angle) + sine * np.sin(n * angle))
    assert np.abs(u - wanted).max() <= 1e-10 * u[0]


@pytest.mark.parametrize("scheme", [VelocityVerlet, SymplecticEuler])
@pytest.mark.parametrize("ratio", [0.1, 0.5])
def test_oscillator(ratio, scheme):
    """u = A e^(−ζωt) (cos ω_d t + ζω/ω_d sin ω_d t), with an error of first order in dt."""
    errors = []
    for steps in (400, 800, 1600):
        phase = 8.0 / steps
        t = np.arange(steps + 1) * phase  # in units of 1/ω
        swift = math.sqrt(1 - ratio**2)
        wanted = 1e-3 * np.exp(-ratio * t) * (np.cos(swift * t) + ratio / swift * np.sin(swift * t))
        errors.append(np.abs(swing(ratio, phase, steps, scheme) - wanted).max() / 1e-3)
    assert errors[-1] < 5e-3
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(1.0, abs=0.1)


def test_ratio_and_coefficient():
    part = pair()
    part[density] = [1000.0, 3000.0]
    found = ViscousDamping(part, ratio=0.25, frequency=8.0).coefficients
    assert found.tolist() == [4000.0, 12000.0]
    assert ViscousDamping(part, 7.0).coefficients.tolist() == [7.0, 7.0]
    assert ViscousDamping(part, [7.0, 8.0]).coefficients.tolist() == [7.0, 8.0]
    by_ratio, by_number, by_array = (
        swing(0.3, 0.2, 50, **options)
        for options in (
            {},
            {"coefficient": 2 * 0.3 * OMEGA * RHO},
            {"coefficient": np.full(2, 2 * 0.3 * OMEGA * RHO)},
        )
    )
    np.testing.assert_allclose(by_number, by_ratio, rtol=1e-12, atol=1e-17)
    assert np.array_equal(by_number, by_array)


# -- energy ---------------------------------------------------------------------------------------------------------


def test_balance_of_energy():
    """T + U + Ψ − dt²/8 Σ V f²/ρ stays what it was, to round-off: velocity Verlet, linear bonds.

    The kinetic energy of the scheme changes by ½ (f_n + f_{n+1}) Δu V, the same trapezoidal work as of the damping and
    of linear bonds, and by the last term.
    """
    part = rbs.Part("bar", rbs.Box(size=30.0)).discretize(1.0).connect(3.0)
    part[density] = np.random.default_rng(0).uniform(1.0, 2.0, 30)
    part[velocity] = np.random.default_rng(1).normal(size=(30, 1)) * 1e-3
    part[displacement] = 0.0
    steel = BondBased(part, E=1.0)
    damping = ViscousDamping(part, np.linspace(0.0, 0.2, 30))

    class Balance(rbs.Measure):
        reads = (kinetic_energy, strain_energy, viscous_dissipation, force_density, density, volume)

        def begin(self, clock):
            self.sums, self.lost = [], []

        def apply(self, clock):
            held = float(self[kinetic_energy] + self[strain_energy] + self[viscous_dissipation])
            change = (self[force_density] ** 2).sum(axis=1) / self[density]
            self.sums.append(held - clock.dt**2 / 8 * float(change @ self[volume]))
            self.lost.append(float(self[viscous_dissipation]))

    balance = Balance(part)
    relations = VelocityVerlet(part).step([steel], [damping])
    relations += [KineticEnergy(part), StrainEnergy(part, [steel]), balance]
    rbs.Analysis(relations).run(steps=400, progress=False)
    start = 0.5 * float((part[density] * part[volume]) @ (np.random.default_rng(1).normal(size=30) * 1e-3) ** 2)
    sums = np.array(balance.sums)
    assert np.ptp(sums) <= 1e-12 * start
    assert balance.lost[-1] > 0.9 * start


def test_nothing_is_followed_unless_asked(tmp_path):
    part = pair()
    damping = ViscousDamping(part, 1e3)
    rbs.Analysis(VelocityVerlet(part).step([BondBased(part, c=C)], [damping])).run(steps=2, dt=1e-6, progress=False)
    assert viscous_dissipation not in part
    late = ViscousDamping(part, 1e3, when=rbs.every(2))
    table = CSVExporter(part, [viscous_dissipation], tmp_path / "table.csv")
    with pytest.raises(BadInput, match="acts in every step"):
        rbs.Analysis([*VelocityVerlet(part).step([BondBased(part, c=C)], [late]), table]).run(steps=2, dt=1e-6)


# -- stable step ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [0.0, 0.2, 1.0, 4.0])
@pytest.mark.parametrize("scheme", [VelocityVerlet, SymplecticEuler])
def test_stable_step(ratio, scheme):
    """2/ω (sqrt(1 + ζ²) − ζ) is what the scene knows, and what holds: above it a swing of 1e-3 grows on and on."""
    part = pair()
    damping = [ViscousDamping(part, ratio=ratio * share, frequency=OMEGA) for share in (0.25, 0.75)]
    relations = scheme(part).step([BondBased(part, c=C)], damping)
    analysis = rbs.Analysis(relations)
    limit = 2 * (math.sqrt(1 + ratio**2) - ratio) / OMEGA
    assert analysis.stable_dt() == pytest.approx(limit, rel=1e-6)
    assert np.abs(swing(ratio, 0.99 * limit * OMEGA, 1000, scheme)).max() <= 0.011
    assert np.abs(swing(ratio, 1.01 * limit * OMEGA, 1000, scheme)).max() > 0.02


def test_stable_step_of_free_nodes():
    """2ρ/c without any other force."""

    class Idle(rbs.Constitutive):
        adds = (force_density,)

    part = pair()
    damping = ViscousDamping(part, 50.0)
    analysis = rbs.Analysis(VelocityVerlet(part).step([Idle(part)], [damping]))
    assert analysis.stable_dt() == pytest.approx(2 * RHO / 50.0, rel=1e-12)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "give either a coefficient, or a ratio and the frequency"),
        ({"ratio": 0.1}, "give either a coefficient, or a ratio and the frequency"),
        ({"coefficient": 1.0, "ratio": 0.1, "frequency": 1.0}, "give either a coefficient"),
        ({"coefficient": -1.0}, "finite and not negative"),
        ({"coefficient": [1.0, 2.0, 3.0]}, r"one number or \(2,\)"),
        ({"ratio": math.inf, "frequency": 1.0}, "ratio=inf must be finite"),
        ({"ratio": 0.1, "frequency": -1.0}, "frequency=-1.0 must be finite and not negative"),
    ],
)
def test_bad_arguments(given, words):
    with pytest.raises(BadInput, match=words):
        ViscousDamping(pair(), **given)
