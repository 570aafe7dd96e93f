"""Every published case: a coarse run on each commit, its numbers at full size under --verify."""

from __future__ import annotations

import importlib.util
import json
import math
import sys
from pathlib import Path

import pytest

from rbs_core.command import main

CASES = Path(__file__).parents[2] / "simulations"


def case(name: str):
    """A simulation as a module, imported as the command line does it."""
    spec = importlib.util.spec_from_file_location(name, CASES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def run(name: str, out: Path, **arguments):
    """Runs a case through the command line; returns what it measured."""
    settings = [part for key, value in arguments.items() for part in ("--set", f"{key}={value}")]
    assert main(["run", str(CASES / f"{name}.py"), "--out", str(out), "--quiet", *settings]) == 0
    return json.loads((out / "result.json").read_text())["measured"]


@pytest.mark.parametrize("name", sorted(path.stem for path in CASES.glob("*.py")))
def test_every_case_is_a_documented_scene_with_a_measure(name):
    module = case(name)
    assert module.__doc__
    assert module.scene.__doc__
    assert module.measure.__doc__
    row = [line for line in (CASES / "README.md").read_text().splitlines() if f"({name}.py)" in line]
    assert row, f"simulations/README.md has no row for {name}"


def test_plate_with_crack_coarse(tmp_path):
    found = run("plate_with_crack", tmp_path, n=100, frames=10)
    assert found["nodes"] == 100 * 106
    # the plate is symmetric to the bit, and so are its sums up to their order: damage counts whole bonds
    assert found["asymmetry_of_damage_left_right"] < 1e-12
    assert found["asymmetry_of_damage_up_down"] < 1e-12
    assert found["damage_in_the_no_fail_zone"] == 0
    assert found["broken_directed_bonds"] > 732, "bonds break beyond those of the pre-crack"
    assert found["energy_error"] < 0.01
    for file in ("plate.vtkhdf", "history.csv", "plate_with_crack.py", "result.json"):
        assert (tmp_path / file).stat().st_size > 0
    assert list(tmp_path.glob("damage_*.png"))


def test_wave_in_plate_coarse(tmp_path):
    found = run("wave_in_plate", tmp_path, n=256, until=110e-6, frames=2)
    # 4 times coarser than the case: the pulse is 9 spacings wide and disperses; 8 % is what the coarse family allows
    assert abs(found["pressure_speed_error"]) < 0.08
    assert found["asymmetry_left_right"] < 1e-10
    assert found["energy_drift_after_load"] < 1e-3
    assert found["energy_error"] < 0.01


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


@pytest.mark.verify
def test_plate_with_crack_at_20_m_per_s(tmp_path):
    found = run("plate_with_crack", tmp_path)
    assert found["nodes"] == 253_000
    assert found["directed_bonds"] == 7_047_820
    assert found["asymmetry_of_damage_left_right"] < 1e-12
    assert found["asymmetry_of_damage_up_down"] < 1e-12
    assert found["damage_in_the_no_fail_zone"] == 0
    assert math.isfinite(found["tip_starts_at_s"])
    assert 0 < found["tip_speed_largest_m_per_s"] < found["rayleigh_speed_m_per_s"]
    assert found["energy_error_largest"] < 0.01


@pytest.mark.verify
def test_plate_with_crack_at_50_m_per_s_branches(tmp_path):
    found = run("plate_with_crack", tmp_path, speed=50)
    assert found["branches_at_m"] < 0.02
    assert found["largest_distance_from_axis_m"] > 0.005, "a branch, not a rough straight crack"
    assert found["asymmetry_of_damage_left_right"] < 1e-12
    assert found["asymmetry_of_damage_up_down"] < 1e-12
    assert found["tip_speed_largest_m_per_s"] < found["rayleigh_speed_m_per_s"]
    assert found["energy_error_largest"] < 0.01


@pytest.mark.verify
def test_wave_in_plate_full_size(tmp_path):
    found = run("wave_in_plate", tmp_path)
    assert abs(found["pressure_speed_error"]) < 0.03
    assert abs(found["rayleigh_speed_error"]) < 0.03
    # the family of 28 is 4 % stiffer than its integral, and waves 2 % faster; the ray is a staircase of nodes
    assert abs(found["shear_speed_error"]) < 0.05
    assert 0.177 < found["pressure_pulse_at_107_us_m"] < 0.195
    assert found["asymmetry_left_right"] < 1e-10
    assert found["energy_drift_after_load"] < 1e-3
    assert found["energy_error"] < 1e-3
