"""Surface corrections: factors of nodes and bonds, the same however bonds are stored, and what they do to a plate."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import BondBased, CriticalStretch, FractureDissipation, PairwiseForce, StrainEnergy
from rbs_plugins.constitutive.surface import family_sums
from rbs_plugins.fields import (
    density,
    displacement,
    dissipation_density,
    force_density,
    strain_energy_density,
    volume,
)
from rbs_plugins.loops.recipe import Recipe
from rbs_plugins.testing import (
    check_angular_momentum,
    check_breaking,
    check_energy,
    check_momentum,
    check_permutation,
    check_stable_step,
    check_storages,
    check_threads,
)

METHODS = ["volume", "force density", "energy"]
SIZES = {1: (9.0,), 2: (9.0, 8.0), 3: (6.0, 5.0, 5.0)}
E = 1e9


def body(dimension, ratio=3.015, size=None, **options):
    part = rbs.Part("body", rbs.Box(size=size or SIZES[dimension])).discretize(1.0)
    return part.connect(ratio, **options)


def whole(dimension, ratio=3.015, **options):
    """A body with whole families in its middle, all cells that the horizon cuts among them."""
    size = [2.0 * math.ceil(ratio + 1) + 1] * dimension
    return body(dimension, ratio, size, reach=ratio + math.sqrt(dimension) / 2, **options)


# -- factors of nodes -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_no_correction_in_the_bulk_by_volume(dimension):
    """Whole cells fill the ball, so V = V0 there; to what slices of cells can do in 3-D."""
    part = whole(dimension)
    found = BondBased(part, E=E, partial_volume="exact", surface_correction="volume").surface.factors
    assert found.shape == (len(part), 1)
    assert found[len(part) // 2, 0] == pytest.approx(1.0, rel=1e-6 if dimension == 3 else 1e-13)
    assert found.max() <= 1.0 + 1e-6


def test_volume_of_a_node_on_an_edge():
    """Half a disk and half of its own cell's row: columns to the right of the edge, counted here."""
    part = body(2, 3.0, (15.0, 15.0))
    found = BondBased(part, E=E, surface_correction="volume").surface.factors[:, 0].reshape(15, 15)
    steps = np.arange(-3, 4)
    inside = steps[:, None] ** 2 + steps**2 <= 9
    assert found[7, 0] == pytest.approx(inside[:, 3:].sum() / (9 * math.pi), rel=1e-12)
    assert found[0, 0] == pytest.approx(inside[3:, 3:].sum() / (9 * math.pi), rel=1e-12)


@pytest.mark.parametrize("method", ["force density", "energy"])
@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_ratios_are_those_of_sums_written_here(dimension, method):
    part = body(dimension, 2.5)
    found = BondBased(part, E=E, surface_correction=method).surface.factors
    power, factor = {"force density": (3, 0), "energy": (4, 1)}[method]
    sums = np.zeros_like(part.positions)
    for i, j in part.bonds:
        xi = part.positions[j] - part.positions[i]
        r = np.linalg.norm(xi)
        sums[i] += r**factor * np.abs(xi / r) ** power
    # of the ball: ∫ r^factor |n_x|^power over r and, in the angle from the axis, over its directions
    angle = (np.arange(20000) + 0.5) * math.pi / 20000
    turns = {1: 2.0, 2: 2 * np.mean(np.abs(np.cos(angle)) ** power) * math.pi,
             3: 2 * math.pi * np.mean(np.abs(np.cos(angle)) ** power * np.sin(angle)) * math.pi}[dimension]  # fmt: skip
    ball = turns * 2.5 ** (dimension + factor) / (dimension + factor)
    np.testing.assert_allclose(found, ball / sums, rtol=1e-6)


def test_energy_in_the_bulk_is_that_of_the_continuum():
    """A stretch along an axis gets its classical energy, whatever the sum over the lattice would give."""
    strain = 1e-6
    for method, error in (("none", 0.04), ("energy", 1e-5)):
        part = body(2, 3.015, (17.0, 17.0))
        part[displacement] = lambda X: strain * X * [1.0, 0.0]
        steel = BondBased(part, E=E, surface_correction=method)
        rbs.Analysis([steel, StrainEnergy(part, [steel])]).run(steps=1, dt=1.0, force_dt=True, progress=False)
        ratio = part[strain_energy_density][len(part) // 2] / (0.5 * E / (1 - 1 / 9) * strain**2)
        assert ratio == pytest.approx(1.0, abs=error)
        assert method != "none" or ratio > 1.03


def test_axis_without_bonds():
    """A row of nodes in a plane has nothing across: the factor there is never asked for."""
    part = body(2, 2.0, (9.0, 1.0))
    steel = BondBased(part, E=E, surface_correction="energy")
    assert steel.surface.factors[:, 1].tolist() == [1.0] * 9
    part[displacement] = lambda X: 1e-3 * X
    rbs.Analysis([steel]).run(steps=1, dt=1.0, force_dt=True, progress=False)
    assert np.isfinite(part[force_density]).all()


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_sums_over_families(storage):
    part = rbs.Part("body", rbs.Box(size=(5.0, 4.0)) - rbs.Ball(1.1, center=(1.0, 0.0))).discretize(1.0)
    part[volume] = np.random.default_rng(0).uniform(0.5, 1.5, len(part))
    part.connect(2.3, storage=storage)
    part.bonds.remove(rbs.Segment((-1.0, -3.0), (-1.0, 3.0)))
    found = family_sums(part, lambda bonds: bonds**2)
    wanted = np.zeros_like(found)
    for i, j in part.bonds:
        wanted[i] += (part.positions[j] - part.positions[i]) ** 2 * part[volume][j]
    np.testing.assert_allclose(found, wanted, rtol=1e-13, atol=1e-13)


# -- forces ---------------------------------------------------------------------------------------------------------


def outcome(dimension, method, storage, partial, precision="double"):
    """Force, energy, stiffness and lost energy of a body in which bonds break."""
    reach = {"none": None, "exact": 2.5 + math.sqrt(dimension) / 2}[partial]
    part = rbs.Part("body", rbs.Box(size=SIZES[dimension]), precision=precision).discretize(1.0)
    part.connect(2.5, storage=storage, reach=reach)
    part[density] = 1.0
    part[displacement] = np.random.default_rng(3).normal(size=part.positions.shape) * 0.02
    steel = BondBased(part, c=1.0, fracture=CriticalStretch(0.05), partial_volume=partial, surface_correction=method)
    measures = [StrainEnergy(part, [steel]), FractureDissipation(part)]
    analysis = rbs.Analysis([steel, *measures])
    part[displacement] *= 0.5
    analysis.run(steps=1, dt=1.0, force_dt=True, progress=False)
    part[displacement] *= 4.0
    analysis.run(steps=2, dt=1.0, force_dt=True, progress=False)
    assert 0 < np.count_nonzero(part.bonds.intact) < len(part.bonds)
    felt = [part[field] for field in (force_density, strain_energy_density, dissipation_density)]
    return [*felt, steel.squared_frequency(), part.bonds.intact]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("dimension", "partial"), [(1, "none"), (2, "none"), (2, "exact"), (3, "none")])
def test_list_and_lattice_agree(dimension, method, partial):
    one, two = (outcome(dimension, method, storage, partial) for storage in ("list", "lattice"))
    for here, there in zip(one, two, strict=True):
        assert np.abs(here * 1.0 - there).max() <= 1e-12 * np.abs(here).max()


@pytest.mark.parametrize("method", METHODS)
def test_single_precision(method):
    one, two = (outcome(2, method, "lattice", "none", precision) for precision in ("double", "single"))
    assert np.abs(one[1] - two[1]).max() <= 1e-5 * np.abs(one[1]).max()


@pytest.mark.parametrize("method", ["volume", "energy"])
@pytest.mark.parametrize("cloud", ["jittered", "lattice"])
@pytest.mark.parametrize(
    "check",
    [check_momentum, check_angular_momentum, check_energy, check_stable_step, check_breaking, check_permutation],
)
def test_forces_are_those_of_a_potential(check, cloud, method):
    """Newton's third law, and dw/d(length) = law with the factor in both."""
    check(BondBased, 2, cloud, E=E, surface_correction=method)


@pytest.mark.parametrize("check", [check_threads, check_storages])
def test_threads_and_storages(check):
    check(BondBased, 2, "lattice", E=E, surface_correction="energy")


def test_cracks_stay_soft():
    """Broken bonds count in the sums, removed ones do not: a cut is no surface, a gap is one."""
    found = {}
    for way in ("whole", "cut", "remove"):
        part = body(2, 2.0)
        if way != "whole":
            getattr(part.bonds, way)(rbs.Segment((0.0, -9.0), (0.0, 9.0)))
        found[way] = BondBased(part, E=E, surface_correction="energy").surface.factors
    assert np.array_equal(found["whole"], found["cut"])
    assert found["remove"].max() > found["whole"].max() * 1.01 or (found["remove"] > found["whole"] * 1.01).any()


@pytest.mark.parametrize(
    ("method", "most"), [("none", 0.13), ("volume", 0.07), ("force density", 0.08), ("energy", 0.05)]
)
def test_modulus_of_a_plate_in_tension(method, most):
    """24 x 12 nodes, pulled at both ends: 14 % too long without a correction, 4 to 7 % too short with one.

    Whole cells, horizon ratio 3.015: between its ends the plate has 0.874 of its modulus without, 1.060, 1.078 and
    1.045 with a correction by volume, force density and energy.
    """
    part = rbs.Part("plate", rbs.Box(size=(24.0, 12.0))).discretize(1.0)
    part.connect(3.015, reach=3.015 + math.sqrt(0.5))
    part[displacement] = 0.0
    steel = BondBased(part, E=E, partial_volume="exact", surface_correction=method)
    ends = [np.flatnonzero(np.isclose(part.positions[:, 0], x)) for x in (-11.5, 11.5)]
    load = np.zeros_like(part.positions)
    load[ends[0], 0], load[ends[1], 0] = -1.0, 1.0
    u = np.linalg.lstsq(stiffness(part, steel), load.ravel(), rcond=1e-9)[0].reshape(load.shape)
    modulus = 23.0 / (u[ends[1], 0].mean() - u[ends[0], 0].mean())
    assert modulus / E == pytest.approx(1.0, abs=most)
    assert (modulus < 0.9 * E) if method == "none" else (modulus > 1.03 * E)


def stiffness(part, steel):
    """Matrix of the forces of small displacements, column by column."""
    analysis = rbs.Analysis([steel])
    analysis.prepare()
    clock = rbs.Clock(dt=1.0, step=1, time=1.0, last_step=1)
    steel.begin(clock)
    columns = []
    for index in np.ndindex(*part.positions.shape):
        part[displacement][...] = 0.0
        part[displacement][index] = 1e-6
        part[force_density][...] = 0.0
        steel.apply(clock)
        columns.append(part[force_density].ravel() / -1e-6)
    return np.array(columns).T


# -- what is refused, and what costs nothing ------------------------------------------------------------------------


def test_bad_methods():
    part = body(2)
    with pytest.raises(BadInput, match="must be one of none, volume, force density, energy"):
        BondBased(part, E=E, surface_correction="variable horizon")
    other = rbs.Part("other", rbs.Box(size=(2.0, 2.0), center=(6.0, 0.0))).discretize(1.0)
    with pytest.raises(BadInput, match="belongs to the families of one part"):
        BondBased(rbs.Connection(part, other, 3.0), c=1.0, surface_correction="volume")


def flat(stretch):
    return 0.0 * stretch


def warm(stretch, density_i, density_j):
    return stretch * (density_i + density_j)


@pytest.mark.parametrize("law", [flat, warm])
def test_laws_without_a_known_stiffness(law):
    part = body(2)
    with pytest.raises(BadInput, match="compares stiffnesses at rest"):
        PairwiseForce(part, law, surface_correction="energy")
    assert PairwiseForce(part, law, surface_correction="volume").surface.factors.shape == (len(part), 1)


@pytest.mark.parametrize("storage", ["list", "lattice"])
def test_who_asks_for_none_pays_nothing(storage, monkeypatch):
    """The text of the loops does not mention it, and no factor is computed."""
    texts = []
    whole_text = Recipe.text
    monkeypatch.setattr(Recipe, "text", lambda self, *loops: texts.append(loops) or whole_text(self, *loops))

    def stiff(stretch, c):
        return c * stretch * 1.0

    part = body(2, storage=storage)
    part[displacement] = 0.0
    steel = PairwiseForce(part, stiff, c=1.0)
    rbs.Analysis([steel]).run(steps=1, dt=1.0, force_dt=True, progress=False)
    assert steel.surface.factors.shape == (len(part), 0)
    assert texts
    assert not any("surface" in piece or "factor" in piece for loops in texts for piece in loops)
