"""Plates of Hashim (2021): a coarse one on each commit, others under --verify, beside finite elements."""

from __future__ import annotations

import numpy as np
import pytest

from tests.simulations.test_cases import run


def test_plate_in_tension_coarse(tmp_path):
    found = run("hashim_plates", tmp_path, case="tension", n=20, m=1.015, factor=0)
    assert found["u_x_error"] < 0.1
    assert found["iterations"] <= 3


@pytest.mark.verify
def test_plate_in_tension(tmp_path):
    errors = [run("hashim_plates", tmp_path / f"{n}", case="tension", n=n)["u_x_error"] for n in (50, 100, 200)]
    assert 0.02 > errors[0] > errors[1] > errors[2]
    newton, relaxed = (
        run("hashim_plates", tmp_path / f"{solver}", case="tension", n=50, solver=solver)["u_x_of_the_end_m"]
        for solver in ("newton", "relaxation")
    )
    assert relaxed == pytest.approx(newton, rel=1e-6)
    free = run("hashim_plates", tmp_path / "free", case="tension", n=50, factor=0)
    assert free["u_x_error"] > 1, "zero-energy modes"
    shortest = [run("hashim_plates", tmp_path / f"s{n}", case="tension", n=n, m=1.015, factor=0) for n in (50, 100)]
    assert 0.04 > shortest[0]["u_x_error"] > 1.5 * shortest[1]["u_x_error"]


def along(found: dict, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Places in the first quadrant on an axis of a plate, and displacements there."""
    table = np.array(found[f"{name}_the_pull"])
    table = table[(table[:, 0] > 0) & (table[:, 1] > 0)]
    return table[:, :2], table[:, 2:]


@pytest.mark.verify
def test_plates_against_finite_elements(tmp_path):
    pytest.importorskip("skfem", reason="scikit-fem, of the extra 'test'")
    from tests.simulations.plane_strain import Quarter, around_hole, beside_crack

    pull = 1e-4
    exact = Quarter(around_hole(0.075, 0.025, 0.01), 210e9, 0.33, 0.075, pull)
    found = run("hashim_plates", tmp_path / "long", fracture="none", steps=1)
    for name in ("along", "across"):
        places, ours = along(found, name)
        assert np.abs(ours - exact.displacement(places))[:, 0].max() < 0.02 * pull

    pull = 2.7541e-4 * 0.02
    exact = Quarter(around_hole(0.025, 0.025, 0.005), 192e9, 0.33, 0.025, pull)
    found = run("hashim_plates", tmp_path / "hole", case="hole", fracture="none", steps=1, share=0.02)
    y = np.linspace(0.00502, 0.02499, 800)
    spread = exact.stress_along(np.column_stack([np.full_like(y, 1e-5), y]), 5e-6)
    concentration = exact.stress_along(np.array([[0.0005, 0.0055]]), 1e-5)[0] / np.trapezoid(spread, y)
    ours = 2 * found["largest_stress_in_the_section_Pa"] / found["largest_force_N_per_m"]
    assert np.abs(found["at_m"]) == pytest.approx([0.0055, 0.0005])
    assert ours == pytest.approx(concentration, rel=0.1)

    pull = 1.6e-5
    sticks = {"sticks": lambda x: x[1] > 0.005 - 1e-9}
    exact = Quarter(beside_crack(0.025, 0.025, 0.005), 192e9, 0.33, 0.025, pull, **sticks)
    found = run("hashim_plates", tmp_path / "crack", case="crack", fracture="none", steps=1)
    places, ours = along(found, "across")
    opened = places[:, 0] < 0.004
    assert ours[opened, 1] == pytest.approx(exact.displacement(places[opened][:, ::-1])[:, 0], rel=0.1)


@pytest.mark.verify
def test_square_plate_with_hole_breaks(tmp_path):
    """Symmetric cracks from the hole across the pull; correspondence breaks earlier than bonds alone do."""
    found = {model: run("hashim_plates", tmp_path / model, case="hole", model=model) for model in (
        "correspondence", "bond-based"
    )}  # fmt: skip
    for each in found.values():
        assert each["asymmetry_of_damage"] < 1e-12
        assert np.abs(each["first_nodes_m"]).max(axis=0) == pytest.approx([0.0055, 0.0005])
        assert each["half_width_of_the_crack_m"] <= 2e-3
        assert each["reach_across_m"][-1][1] > 0.024
    assert 0.7 < found["correspondence"]["first_at_share"] / found["bond-based"]["first_at_share"] < 0.85
    free = run("hashim_plates", tmp_path / "free", case="hole", factor=0)
    assert free["damaged_nodes"] > 5 * found["correspondence"]["damaged_nodes"]


@pytest.mark.verify
def test_crack_does_not_hang_on_load_steps(tmp_path):
    """Softening bonds: straight on from both tips, and nearly the same load."""
    found = [
        run("hashim_plates", tmp_path / f"{steps}", case="crack", steps=steps, tolerance=1e-6) for steps in (15, 30)
    ]
    for each in found:
        assert each["asymmetry_of_damage"] == 0.0
        assert np.abs(each["first_nodes_m"]).max(axis=0) == pytest.approx([0.0055, 0.0005])
        assert each["reach_across_m"][-1][1] > 0.024
        assert each["half_width_of_the_crack_m"] <= 2e-3
    forces = [each["largest_force_N_per_m"] for each in found]
    assert forces[0] == pytest.approx(forces[1], rel=0.05)


@pytest.mark.verify
def test_long_plate_breaks_across_its_hole(tmp_path):
    found = run("hashim_plates", tmp_path, n=30, fracture="stretch")
    assert found["nodes_of_the_body"] == 30 * 10 - 12
    assert found["asymmetry_of_damage"] == 0.0
    assert max(abs(x) for x, _ in found["first_nodes_m"]) < 10e-3
    assert abs(found["force_at_the_end_N_per_m"]) < 1e-6 * found["largest_force_N_per_m"], "it is apart"


@pytest.mark.verify
def test_long_plate(tmp_path):
    """Breaks in one plane across the hole with a critical stretch, and no iteration takes long."""
    found = run("hashim_plates", tmp_path, fracture="stretch")
    assert found["asymmetry_of_damage"] == 0.0
    assert found["reach_across_m"][-1][1] > 0.024
    assert found["half_width_of_the_crack_m"] <= 3.5e-3
    assert found["largest_force_N_per_m"] == pytest.approx(6.18e6, rel=0.05)
    assert found["iterations"] < 15 * found["searches"]
