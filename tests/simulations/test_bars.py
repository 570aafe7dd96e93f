"""Waves along a bar: coarse runs on each commit, the numbers of the case under --verify."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.simulations.test_cases import case, run

PLACES = ("254_mm", "127_mm", "51_mm")


def test_theory_of_the_aluminium_bar_is_its_series():
    """u = Σ 2V(−1)ⁿ/(L² c k³) sin(kx) sin(ckt), k = (2n + 1)π/(2L); 2000 terms leave 1e-7 of the largest u."""
    bar = case("aluminium_bar")
    time = np.linspace(0.0, 1.3, 40) * bar.PERIOD
    n = np.arange(2000)
    k = (2 * n + 1) * math.pi / (2 * bar.LENGTH)
    for x in (0.05, 0.13, 0.254):
        terms = 2 * bar.SPEED * (-1.0) ** n / (bar.LENGTH**2 * bar.WAVE * k**3) * np.sin(k * x)
        u, v, strain = bar.theory(x, time)
        assert np.sin(bar.WAVE * np.outer(time, k)) @ terms == pytest.approx(u, abs=1e-9)
        assert np.cos(bar.WAVE * np.outer(time, k)) @ (terms * bar.WAVE * k) == pytest.approx(v, abs=0.05)
        h = 1e-7
        slope = (bar.theory(x + h, time)[0] - bar.theory(x - h, time)[0]) / (2 * h)
        assert slope == pytest.approx(strain, abs=1e-6)


@pytest.mark.parametrize("model", ["bond-based", "correspondence"])
def test_aluminium_bar_coarse(tmp_path, model):
    found = run("aluminium_bar", tmp_path, model=model, n=49, dt=2e-7, frames=20)
    assert found["nodes"] == 52 * 5
    assert abs(found["period_error"]) < (0.08 if model == "bond-based" else 0.04)
    assert all(found[f"displacement_error_{place}"] < 0.4 for place in PLACES)
    assert found["energy_drift"] < 1e-4
    for file in ("bar.vtkhdf", "history.csv", "stress_strain.csv", "result.json"):
        assert (tmp_path / file).stat().st_size > 0


@pytest.mark.verify
def test_aluminium_bar_bond_based(tmp_path):
    """Far from theory, as all five rows of nodes lack bonds; with ten of them that and the sum over a family cancel."""
    found = run("aluminium_bar", tmp_path / "5")
    finer = run("aluminium_bar", tmp_path / "10", n=198, rows=10)
    assert found["nodes"] == (99 + 3) * 5
    assert found["period_error"] == pytest.approx(0.046, abs=0.003)
    assert found["stress_over_strain_Pa"] == pytest.approx(64.1e9, rel=0.01)
    assert abs(finer["period_error"]) < 0.01
    for place in PLACES:
        assert found[f"displacement_error_{place}"] < 0.2
        assert finer[f"displacement_error_{place}"] < 0.05
    for each in (found, finer):
        assert each["energy_drift"] < 1e-5


@pytest.mark.verify
def test_aluminium_bar_correspondence(tmp_path):
    """The modulus of the material; the ends cost a part of the period that goes with the spacing."""
    sizes = {49: 5, 99: 5, 198: 10}
    found = {n: run("aluminium_bar", tmp_path / f"{n}", model="correspondence", n=n, rows=sizes[n]) for n in sizes}
    for each in found.values():
        assert each["stress_over_strain_Pa"] == pytest.approx(69e9, rel=2e-3)
        assert each["energy_drift"] < 1e-5
    for place in PLACES:
        assert found[99][f"displacement_error_{place}"] < 0.065
    errors = [each["period_error"] for each in found.values()]
    assert errors[1] == pytest.approx(0.0114, abs=0.001)
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(1.0, abs=0.15)

    controlled = run("aluminium_bar", tmp_path / "controlled", model="correspondence", stabilization="silling")
    oscillation = "oscillation_of_one_node_254_mm"
    assert found[99][oscillation] == pytest.approx(0.022, abs=0.002), "zero-energy modes"
    assert controlled[oscillation] < 0.8 * found[99][oscillation]
