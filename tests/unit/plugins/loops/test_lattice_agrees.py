"""List and lattice are two spellings of the same sums: for every kind of law, body and failure they agree."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import BondBased, Criterion, CriticalStretch, PairwiseForce
from rbs_plugins.fields import displacement, force_density, intact
from tests.unit.plugins.loops.doubles import STORAGES, assert_close, body, grade, history


def linear(stretch, c):
    return c * stretch


def energy_of_linear(stretch, reference_length, c):
    return 0.5 * c * stretch * stretch * reference_length


def stiffening(stretch, c, hard=30.0):
    return c * stretch * (1.0 + hard * stretch)


def bilinear(stretch, c, limit):
    if stretch > limit:
        return c * limit
    return c * stretch


def warm(stretch, warmth_i, warmth_j, c):
    return c * (stretch - 2e-3 * (warmth_i + warmth_j))


def energy_of_warm(stretch, reference_length, warmth_i, warmth_j, c):
    return 0.5 * c * (stretch - 2e-3 * (warmth_i + warmth_j)) ** 2 * reference_length


def too_warm(stretch, warmth_i, warmth_j, s0):
    return stretch > s0 * (1.0 - 0.2 * warmth_i * warmth_j)


def aging(extension, length, reference_length, time, dt, c):
    return c * extension / reference_length * (1.0 - time) + 1e-3 * c * dt * (length - reference_length)


def tired(stretch, time, s0):
    return abs(stretch) > s0 * (1.0 - time)


def graded(stretch, grade, c):
    return c * grade * stretch


def graded_limit(stretch, grade, s0):
    return stretch > s0 * grade


def tabulated(part):
    part.bonds.tabulate(grade, lambda bonds: 1.0 / (1.0 + np.linalg.norm(bonds, axis=1)))
    return [PairwiseForce(part, graded, Criterion(graded_limit, s0=0.02), c=2.0)]


def with_table_of_a_number(part):
    part[grade] = 1.5
    return [PairwiseForce(part, graded, Criterion(graded_limit, s0=0.005), c=2.0)]


def zone(part):
    return rbs.HalfSpace(part.positions.mean(axis=0), [1.0] + [0.0] * (part.dimension - 1))


def brittle(release, **options):
    return lambda part: [PairwiseForce(part, linear, CriticalStretch(0.007, release=release, **options), c=2.0)]


# shape and options of the body, forces
CASES = {
    "energy by quadrature, 1-D": ((40,), {}, lambda part: [PairwiseForce(part, stiffening, c=2.0)]),
    "energy by quadrature, breaking": (
        (9, 8), {}, lambda part: [PairwiseForce(part, bilinear, CriticalStretch(0.008), c=2.0, limit=0.004)],
    ),
    "energy given": ((9, 8), {}, lambda part: [PairwiseForce(part, linear, potential=energy_of_linear, c=2.0)]),
    "energy given, breaking, 3-D": (
        (6, 5, 5), {},
        lambda part: [PairwiseForce(part, linear, CriticalStretch(0.008), potential=energy_of_linear, c=2.0)],
    ),
    "fields at both ends": (
        (9, 8), {"hole": True, "uneven": True},
        lambda part: [PairwiseForce(part, warm, Criterion(too_warm, s0=0.01), potential=energy_of_warm, c=2.0)],
    ),
    "fields at both ends, 3-D": (
        (7, 6, 5), {"hole": True}, lambda part: [PairwiseForce(part, warm, Criterion(too_warm, s0=0.01), c=2.0)],
    ),
    "time": ((9, 8), {}, lambda part: [PairwiseForce(part, aging, Criterion(tired, s0=0.012), c=2.0)]),
    "table of lengths": ((9, 8), {"uneven": True}, tabulated),
    "table of one number, 1-D": ((40,), {}, with_table_of_a_number),
    "partial volume": (
        (9, 8), {"uneven": True},
        lambda part: [BondBased(part, E=1e3, fracture=CriticalStretch(0.008), partial_volume="linear")],
    ),
    "partial volume, 3-D": ((6, 5, 5), {}, lambda part: [BondBased(part, E=1e3, partial_volume="linear")]),
    "no-fail zone": (
        (9, 8), {"hole": True},
        lambda part: [PairwiseForce(part, linear, CriticalStretch(0.007, within=zone(part)), c=2.0)],
    ),
    "next step, 1-D": ((40,), {"uneven": True}, brittle("next step", mode="both")),
    "next step": ((9, 8), {}, brittle("next step")),
    "next step, 3-D": ((6, 5, 5), {"hole": True}, brittle("next step", mode="compression")),
    "at once, several ranges": ((61, 53), {"hole": True}, brittle("at once", mode="both")),
    "steps longer than a range": ((19, 18, 7), {}, brittle("at once")),
    "more than 64 steps": ((9, 8, 8), {"ratio": 4.0}, brittle("at once")),
    "horizon wider than the body": ((4, 3), {"ratio": 9.0}, brittle("at once")),
    "one cell thick": ((9, 1, 4), {}, brittle("next step")),
    "two forces that break": (
        (9, 8), {},
        lambda part: [
            PairwiseForce(part, linear, CriticalStretch(0.008), c=2.0),
            PairwiseForce(part, stiffening, CriticalStretch(0.006, mode="compression", release="next step"), c=1.0),
        ],
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_forces_energies_and_failures_agree(case):
    shape, options, make = CASES[case]
    parts = [body(storage, shape, **options) for storage in STORAGES]
    one, two = (history(part, make) for part in parts)
    assert [part.bonds.storage for part in parts] == list(STORAGES)
    assert_close(one, two, parts[0])
    for name in ("force_density", "strain_energy_density", "squared frequency"):
        assert all(np.abs(values).max() > 0 for key, values in one.items() if key.startswith(name)), name
    breaking = any(name.startswith("dissipation") for name in one) or case.startswith("two")
    lost = np.count_nonzero(one["intact 1"]) - np.count_nonzero(one["intact 4"])
    assert (lost > 0) == breaking
    assert lost < len(one["intact 1"]) / 2
    if breaking and not case.startswith("two"):
        assert one["dissipation_density 4"].max() > 0


@pytest.mark.parametrize("storage", STORAGES)
def test_quadrature_is_the_energy(storage):
    """Of a smooth law the panels are exact: the energy is that of the potential."""
    parts = [body(storage, (9, 8)) for _ in range(2)]
    given = history(parts[0], lambda part: [PairwiseForce(part, linear, potential=energy_of_linear, c=2.0)])
    found = history(parts[1], lambda part: [PairwiseForce(part, linear, c=2.0)])
    for name, values in given.items():
        np.testing.assert_allclose(found[name], values, rtol=1e-13, atol=1e-13 * values.max(), err_msg=name)


@pytest.mark.parametrize("storage", STORAGES)
def test_what_one_force_breaks_is_broken_for_the_other(storage):
    part = rbs.Part("rod", rbs.Box(size=2.0)).discretize(1.0).connect(1.0, storage=storage)
    part[displacement] = [[0.0], [0.2]]
    strong, weak = PairwiseForce(part, linear, c=1.0), PairwiseForce(part, linear, CriticalStretch(0.1), c=10.0)
    analysis = rbs.Analysis([strong, weak])
    analysis.run(steps=1, dt=1.0, force_dt=True, progress=False)  # the strong one is asked before the weak one breaks
    np.testing.assert_allclose(part[force_density], [[0.2], [-0.2]], rtol=1e-14)
    analysis.run(steps=2, dt=1.0, force_dt=True, progress=False)
    assert not part[intact].any()
    assert not part[force_density].any()


@pytest.mark.parametrize("storage", STORAGES)
def test_bonds_that_were_removed_never_were(storage):
    parts = [body(storage, (9, 8)) for _ in range(2)]
    for part in parts:
        getattr(part.bonds, "remove" if part is parts[0] else "cut")(rbs.Segment((1.5, -1.0), (1.5, 9.0)))
    forces = [history(part, lambda part: [PairwiseForce(part, linear, c=2.0)]) for part in parts]
    assert len(parts[0].bonds) < len(parts[1].bonds)
    for step in (1, 4):
        name = f"force_density {step}"
        # a row of fewer bonds is summed in another order
        np.testing.assert_allclose(forces[0][name], forces[1][name], rtol=0, atol=1e-13 * np.abs(forces[0][name]).max())
    assert forces[0]["damage 4"].max() < forces[1]["damage 4"].max()
