"""Equilibria against theory and published tables: what is quick on each commit, full sizes under --verify."""

from __future__ import annotations

import numpy as np
import pytest

from tests.simulations.test_cases import case, run

# errors of E and Poisson's ratio by the tensor method, percent, recomputed apart from this package
LATTICE = {
    (0.1, 2): (1.85, -16.66), (0.1, 3): (1.96, -17.65), (0.1, 4): (0.33, -2.94), (0.1, 5): (0.14, -1.29),
    (0.1, 6): (0.35, -3.18), (0.1, 7): (-0.13, 1.15), (0.1, 8): (0.34, -3.07), (0.1, 10): (0.05, -0.42),
    (0.2, 3): (2.14, -8.57), (0.2, 5): (0.16, -0.63), (0.4, 3): (2.51, -3.76), (0.4, 5): (0.18, -0.27),
    (0.45, 3): (2.60, -3.18), (0.45, 5): (0.19, -0.23),
}  # fmt: skip
# table 4.2 of Sarego (2016), columns "tensor", with headings and two rows put right: E, ν
TABLE = {
    "inverse": (0.32, -2.87), "constant": (0.32, -2.90), "gaussian": (0.16, -1.47), "linear": (0.45, -4.08),
    "hyperbolic": (-1.30, 11.68), "inverse_fourth": (9.23, -83.03),
}  # fmt: skip


@pytest.fixture(scope="module")
def moduli():
    return case("sarego_moduli")


@pytest.mark.parametrize(("nu", "m"), LATTICE)
def test_tensor_method_sees_one_family(moduli, nu, m):
    """The areal modulus is exact, and the horizon does not matter."""
    found = moduli.closed_form(nu, m, "constant")
    assert found == pytest.approx(LATTICE[nu, m], abs=0.006)
    assert found[0] == pytest.approx(-nu / (1 - nu) * found[1], abs=1e-9)
    assert moduli.closed_form(nu, m, "constant", horizon=0.5e-3) == pytest.approx(found, abs=1e-9)


def test_tensor_method_for_all_influence_functions_of_the_table(moduli):
    found = {name: moduli.closed_form(0.1, 6, name) for name in TABLE}
    for name, (E, nu) in TABLE.items():
        assert found[name] == pytest.approx((E, nu), abs=0.4), name
        assert found[name][0] == pytest.approx(E, abs=0.05), name
    assert moduli.closed_form(0.1, 6, moduli.in_millimetres) == pytest.approx((37.93, -341.38), abs=0.005)
    # δ − r as it was computed counts neighbors beyond the horizon with a negative weight
    unclipped = moduli.closed_form(0.1, 6, lambda r, horizon: 1 - r / horizon, clipped=False)
    assert unclipped == pytest.approx((-0.24, 2.13), abs=0.05)
    smooth = [abs(found[name][1]) for name in ("inverse", "constant", "gaussian", "linear")]
    assert min(smooth) == abs(found["gaussian"][1])


def test_sarego_moduli_coarse(tmp_path, moduli):
    analysis = moduli.scene(m=3, load="strain", out=tmp_path)
    analysis.relations = [each for each in analysis.relations if each.role != "exporter"]
    analysis.run(progress=False)
    strained = moduli.measure(analysis)
    pulled = run("sarego_moduli", tmp_path / "tension", m=3)
    for found, tolerance in ((strained, 1e-6), (pulled, 0.02)):  # which has not quite forgotten its edges
        for name in ("E_error", "nu_error"):
            assert found[f"{name}_tensor_percent"] == pytest.approx(found[f"{name}_closed_form_percent"], abs=tolerance)
    assert pulled["nodes"] == 81 * 21
    # edges are softer, but the force is divided by more than the depth: stiffer in all
    assert 3 < pulled["E_error_double_percent"] < 10


def test_sarego_beam_coarse(tmp_path):
    """Too soft, and less so on finer grids."""
    found = {n: run("sarego_beam", tmp_path / str(n), n=n) for n in (100, 200)}
    assert found[100]["error_percent"] == pytest.approx(32.1, abs=0.2)
    assert found[200]["error_percent"] == pytest.approx(12.3, abs=0.2)
    for load, error in (("moment", 14.9), ("uniform", 15.0)):
        assert run("sarego_beam", tmp_path / load, n=200, load=load)["error_percent"] == pytest.approx(error, abs=0.2)


def test_three_point_bending_coarse(tmp_path):
    size = {"spacing": 1e-2, "columns": 62, "rows": 15}
    dropped = run("three_point_bending", tmp_path / "newton", steps=12, **size)
    path = run("three_point_bending", tmp_path / "sequential", path="sequential", steps=40, **size)
    for found in (dropped, path):
        assert abs(found["stiffness_error_percent"]) < 5
        assert found["largest_load_N"] == pytest.approx(found["load_with_edge_at_limit_N"], rel=0.15)
        assert found["crack_off_middle_m"] < 1e-9
    assert dropped["damage_grows"]
    assert 0 < dropped["load_behind_the_drop_N"] < 0.1 * dropped["largest_load_N"]
    assert path["largest_load_N"] == pytest.approx(dropped["largest_load_N"], rel=0.15)
    # the displacement goes back as the crack grows
    assert path["smallest_displacement_behind_peak_m"] < 0.8 * path["displacement_then_m"]


def test_fracture_mechanics_of_the_beam_with_a_crack():
    """K√b³ t/(P l) is 2.66 for half of the depth (ASTM E399); a growing crack takes G0 from load and compliance."""
    case_ = case("three_point_bending")
    assert float(case_.of_notch(np.array(0.5))) == pytest.approx(2.66, abs=0.01)
    down, load = case_.snap_back(5e-10)
    share = np.linspace(0.002, 0.95, 1000)
    released = 0.5 * (load[:-1] * down[1:] - load[1:] * down[:-1])
    area = np.diff(share) * case_.DEPTH * case_.THICKNESS
    assert np.sum(released[50:]) == pytest.approx(case_.G0 * np.sum(area[50:]), rel=0.01)


def test_theory_of_the_beam_on_two_supports():
    """5qL⁴/384EI and the shear in the middle, nothing at the ends."""
    beam = case("sarego_beam")
    x = np.array([0.0, beam.LENGTH / 2, beam.LENGTH])
    q = beam.FORCE / beam.LENGTH
    middle = 5 * q * beam.LENGTH**4 / (384 * beam.BENDING) + q * beam.LENGTH**2 / (8 * beam.SHEAR)
    assert beam.theory("uniform", x) == pytest.approx([0.0, -middle, 0.0], abs=1e-12)


@pytest.mark.verify
def test_sarego_beam_full_size(tmp_path):
    found = {load: run("sarego_beam", tmp_path / load, load=load) for load in ("force", "moment", "uniform")}
    assert found["force"]["nodes"] == 8000
    assert 0 < found["force"]["error_percent"] < 4.5
    assert 0 < found["moment"]["error_percent"] < 5.5
    assert 0 < found["uniform"]["error_percent"] < 5.0, "published: below 3.5"
    assert found["force"]["as_published_beyond_m"] < 0.12 * 30e-3
    assert found["moment"]["largest_error_percent"] < 5.5


@pytest.mark.verify
def test_sarego_beam_and_the_grid(tmp_path):
    """The local beam is what smaller horizons lead to, and not what more nodes in a horizon do."""
    finer = [run("sarego_beam", tmp_path / f"n{n}", n=n)["error_percent"] for n in (100, 200, 300, 400)]
    assert finer == pytest.approx([32.1, 12.3, 6.4, 3.6], abs=0.2)
    denser = [run("sarego_beam", tmp_path / f"m{m}", n=50 * m, m=m)["error_percent"] for m in (2, 4, 6, 8)]
    assert denser == pytest.approx([7.9, 22.7, 24.6, 25.6], abs=0.2)
    steps = np.diff(denser)
    assert (steps[1:] < steps[:-1]).all()


@pytest.mark.verify
@pytest.mark.parametrize("influence", [*TABLE, "conical", "in_millimetres"])
def test_sarego_moduli_full_size(tmp_path, influence):
    found = run("sarego_moduli", tmp_path, influence=influence)
    assert found["nodes"] == 6601
    tolerance = 0.2 if influence == "hyperbolic" else 0.05  # most of its weight lies at the edge of the family
    for name in ("E_error", "nu_error"):
        assert found[f"{name}_tensor_percent"] == pytest.approx(found[f"{name}_closed_form_percent"], abs=tolerance)
    if influence == "constant":
        assert found["u_x_error_inside_percent"] < 7.5
        assert found["E_error_double_percent"] == pytest.approx(4.94, abs=0.7)


@pytest.mark.verify
def test_three_point_bending_full_size(tmp_path):
    dropped = run("three_point_bending", tmp_path / "newton")
    path = run("three_point_bending", tmp_path / "sequential", path="sequential")
    for found in (dropped, path):
        assert found["nodes"] == 3720
        assert abs(found["stiffness_error_percent"]) < 5
        assert found["largest_load_N"] == pytest.approx(found["load_with_edge_at_limit_N"], rel=0.1)
        assert found["crack_off_middle_m"] < 1e-9
    assert dropped["damage_grows"]
    assert dropped["load_behind_the_drop_N"] < 0.05 * dropped["largest_load_N"]
    assert path["smallest_displacement_behind_peak_m"] == pytest.approx(
        path["the_same_of_fracture_mechanics_m"], rel=0.1
    )
    assert abs(path["off_fracture_mechanics_mean_percent"]) < 10
    notched = run("three_point_bending", tmp_path / "notch", path="sequential", notch=0.075, steps=60)
    assert notched["largest_load_N"] == pytest.approx(notched["largest_load_of_fracture_mechanics_N"], rel=0.1)
