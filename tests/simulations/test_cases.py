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


def test_crack_branching_coarse(tmp_path):
    # twice as coarse as the case, and the load on a horizon of rows, as a single one would be torn off
    found = run("crack_branching", tmp_path, n=200, horizon=2e-3, rows=4, frames=50)
    assert found["nodes"] == 200 * 80
    assert found["asymmetry_of_damage_up_down"] < 1e-12
    assert found["cracks_side_by_side"] == 2
    assert 0.01 < found["branches_at_m"] < 0.03
    assert 0 < found["tip_speed_largest_m_per_s"] < found["rayleigh_speed_m_per_s"]
    assert found["energy_error"] < 0.01


def test_kalthoff_winkler_coarse(tmp_path):
    # the published size; at this spacing the first 20 mm of the crack are flatter than on finer grids
    found = run("kalthoff_winkler", tmp_path)
    assert found["nodes"] == 2500
    assert 55 < found["crack_angle_deg"] < 75
    assert abs(found["angle_from_notch_to_end_deg"] - 70) < 5
    assert found["right_edge_cracks_at_s"] < 50e-6, "the second crack that the dissertation shows"
    assert found["tip_speed_largest_m_per_s"] < found["rayleigh_speed_m_per_s"]
    assert found["energy_error"] < 0.01


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


@pytest.mark.verify
def test_crack_branching_full_size(tmp_path):
    found = run("crack_branching", tmp_path)
    assert found["nodes"] == 64_000
    assert found["asymmetry_of_damage_up_down"] < 1e-12
    assert found["cracks_side_by_side"] == 2
    assert 0.01 < found["branches_at_m"] < 0.025
    assert found["largest_distance_from_axis_m"] > 0.01, "branches, not a rough straight crack"
    assert 1000 < found["tip_speed_mean_m_per_s"] < found["tip_speed_largest_m_per_s"] < found["rayleigh_speed_m_per_s"]
    assert found["energy_error"] < 0.01


@pytest.mark.verify
@pytest.mark.parametrize("half", [True, False])
def test_kalthoff_winkler_on_a_finer_grid(half, tmp_path):
    found = run("kalthoff_winkler", tmp_path, n=200, horizon=1e-3, half=half)
    assert abs(found["crack_angle_deg"] - 70) < 5
    assert found["asymmetry_of_damage_up_down"] < 1e-12, "of the whole plate: two cracks that mirror each other"
    assert found["tip_speed_largest_m_per_s"] < found["rayleigh_speed_m_per_s"]
    assert found["energy_error"] < 0.01
