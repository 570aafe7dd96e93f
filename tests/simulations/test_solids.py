"""Cracks in ordinary state-based solids: coarse runs on each commit, the numbers of the cases under --verify."""

from __future__ import annotations

import pytest

from tests.simulations.test_cases import run


def test_sarego_poisson_angle_coarse(tmp_path):
    found = {
        nu: run("sarego_poisson_angle", tmp_path / f"{nu}", nu=nu, horizon=6e-3, until=0.5e-3, frames=10)
        for nu in (0.1, 0.4)
    }
    for each in found.values():
        assert 0.2e-3 < each["starts_at_s"] < 0.5e-3
        assert each["tip_at_the_end_m"] > 0.04
        assert each["energy_error"] < 0.02
    assert found[0.1]["angle_deg"] > found[0.4]["angle_deg"] > 5


def test_semicircular_bend_coarse(tmp_path):
    found = run("semicircular_bend", tmp_path, horizon=6e-3, speed=0.8, until=1.2e-3, frames=20)
    assert found["cracked_nodes"] > 10
    assert abs(found["kink_angle_deg"]) < 5, "mode I runs straight on"
    assert found["energy_error"] < 0.02


@pytest.mark.parametrize("criterion", ["stretch", "bond energy", "nodal energy"])
def test_diagonal_plate_coarse(tmp_path, criterion):
    found = run("diagonal_plate", tmp_path, criterion=criterion, horizon=10e-3, m=2, speed=1.5, until=2e-3, frames=20)
    assert found["nodes"] == 30**2 - 8
    assert found["cracked_nodes"] > 10
    assert found["energy_error"] < 0.02


@pytest.mark.parametrize("criterion", ["stretch", "bond energy", "nodal energy"])
def test_nooru_mohamed_coarse(tmp_path, criterion):
    found = run(
        "nooru_mohamed", tmp_path, criterion=criterion, horizon=20e-3, speed=0.3, until=2e-3, dt=1e-6, frames=20
    )
    assert found["nodes"] == 30**2
    assert found["cracked_nodes"] > 10
    assert found["asymmetry_of_damage_under_half_a_turn"] < 1e-12
    assert found["energy_error"] < 0.02
