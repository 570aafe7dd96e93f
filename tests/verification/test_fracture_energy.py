"""The energy of pulling a block apart along a plane is the fracture energy, for every criterion that takes one."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import (
    BondBased,
    CriticalBondEnergy,
    CriticalNodalEnergy,
    CriticalStretch,
    OrdinaryStateBased,
    critical_bond_energy,
)
from rbs_plugins.fields import displacement, force_density, volume

E, G0, H = 2e9, 10.0, 1e-3  # Pa, J/m^2, m
STEPS = 1000
ACROSS = {1: {"area": 2e-6}, 2: {"thickness": 5e-3}, 3: {}}


class Pull(rbs.Measure):
    """Moves the right half of a block as it is, a little further in each step."""

    updates = (displacement,)

    def __init__(self, part, opening):
        super().__init__(part)
        self.opening, self.right = opening, part.positions[:, 0] > 0

    def apply(self, clock):
        self[displacement][self.right, 0] = self.opening * clock.step / clock.last_step


class Traction(rbs.Measure):
    """Keeps the force per area on the left half, from the nodes of the middle line."""

    reads = (force_density, volume)

    def __init__(self, part, middle, area):
        super().__init__(part)
        self.middle, self.area, self.values = middle, area, []

    def apply(self, clock):
        line = self.middle
        self.values.append(float((self[force_density][line, 0] * self[volume][line]).sum() / self.area))


def taken(make, dimension, criterion, m, steps=STEPS, storage=None):
    """Work of the tractions per area, J/m^2, while two rigid halves move apart, far from all other faces."""
    horizon = (m + 0.015) * H
    size = (4 * m * H, *((4 * m + 1) * H,) * (dimension - 1))
    block = rbs.Part("block", rbs.Box(size=size)).discretize(H, **ACROSS[dimension]).connect(horizon, storage=storage)
    force = make(block, criterion)
    away = np.abs(block.positions[:, 1:]).max(axis=1, initial=0.0) if dimension > 1 else np.zeros(len(block))
    middle = np.flatnonzero((block.positions[:, 0] < 0) & (away < H / 2))
    area = block[volume][0] / H
    # beyond the opening at which the last bond breaks: it is as steep as 1 in m
    opening = 6 * m * horizon * np.sqrt(G0 / (E * horizon))
    pull, traction = Pull(block, opening), Traction(block, middle, area)
    rbs.Analysis([pull, force, traction]).run(steps=steps, dt=1.0, force_dt=True, progress=False)
    offsets, neighbors = block.bonds.as_rows()
    ends = np.repeat(np.arange(len(block)), np.diff(offsets))
    crossing = pull.right[ends] != pull.right[neighbors]
    assert not block.bonds.intact[crossing].any(), "the halves have parted"
    values = np.array([0.0, *traction.values])
    return float(np.sum(0.5 * (values[1:] + values[:-1])) * opening / steps)


def bond_based(plane=None):
    return lambda part, criterion: BondBased(part, E=E, fracture=criterion, plane=plane)


def ordinary(nu=None, plane=None, influence="constant"):
    return lambda part, criterion: OrdinaryStateBased(
        part, E=E, nu=nu, plane=plane, fracture=criterion, influence=influence
    )


def crossing_pairs(dimension, m):
    """Σ V V of the pairs of nodes that a plane of unit area parts, m^4: what is counted by w0."""
    horizon, cells = (m + 0.015) * H, np.arange(-m, m + 1)
    vectors = np.stack(np.meshgrid(*[cells] * dimension, indexing="ij"), axis=-1).reshape(-1, dimension) * H
    there = (vectors[:, 0] > 0) & (np.linalg.norm(vectors, axis=1) <= horizon)
    cell = {1: 2e-6 * H, 2: 5e-3 * H**2, 3: H**3}[dimension]
    # a bond that reaches k spacings across is one of k that start in front of the plane, per face of a cell
    return (vectors[there, 0] / H).sum() * cell**2 / (cell / H)


SOLIDS = {
    "bond-based, 1-D": (1, 4, bond_based(), True),
    "bond-based, plane stress": (2, 4, bond_based("stress"), True),
    "bond-based, plane strain": (2, 4, bond_based("strain"), True),
    "bond-based, 3-D": (3, 3, bond_based(), True),
    "ordinary, 1-D": (1, 4, ordinary(), True),
    "ordinary, plane stress, 0.1": (2, 4, ordinary(0.1), False),
    "ordinary, plane stress, 1/3": (2, 4, ordinary(1 / 3), True),
    "ordinary, plane stress, 0.45": (2, 4, ordinary(0.45), False),
    "ordinary, plane stress, 0.1, inverse": (2, 4, ordinary(0.1, influence="inverse"), False),
    "ordinary, plane strain, 0.1": (2, 4, ordinary(0.1, "strain"), False),
    "ordinary, plane strain, 0.45": (2, 4, ordinary(0.45, "strain"), False),
    "ordinary, 3-D, 0.1": (3, 3, ordinary(0.1), False),
    "ordinary, 3-D, 0.4": (3, 3, ordinary(0.4), False),
}
# What sums over so few nodes are off: a row of 4 springs is 1 + 1/m = 1.25 times the integral that it stands for.
LATTICE = {1: 0.4, 2: 0.1, 3: 0.13}


@pytest.mark.parametrize("form", ["incremental", None])
@pytest.mark.parametrize("name", SOLIDS)
def test_bond_energy(name, form):
    """Each bond takes w0 to the last, so what the block takes differs from G0 as the number of bonds does."""
    dimension, m, make, _ = SOLIDS[name]
    found = taken(make, dimension, CriticalBondEnergy(fracture_energy=G0, form=form), m)
    across = {1: 2e-6, 2: 5e-3, 3: 1.0}[dimension]
    bonds = critical_bond_energy(G0, dimension, (m + 0.015) * H, across) * crossing_pairs(dimension, m)
    assert found == pytest.approx(bonds, rel=0.015)  # the steps of the opening
    assert found == pytest.approx(G0, rel=LATTICE[dimension])


@pytest.mark.parametrize("name", SOLIDS)
def test_stretch(name):
    dimension, m, make, _ = SOLIDS[name]
    assert taken(make, dimension, CriticalStretch(fracture_energy=G0), m) == pytest.approx(G0, rel=LATTICE[dimension])


@pytest.mark.verify
@pytest.mark.parametrize("name", [name for name, (dimension, *_) in SOLIDS.items() if dimension < 3])
def test_it_comes_closer_with_finer_nodes(name):
    dimension, m, make, _ = SOLIDS[name]
    for criterion in (CriticalStretch(fracture_energy=G0), CriticalBondEnergy(fracture_energy=G0)):
        rough, fine = (abs(taken(make, dimension, criterion, each * m) / G0 - 1) for each in (1, 2))
        assert fine < 0.8 * rough, criterion


@pytest.mark.parametrize("storage", ["list", "lattice"])
@pytest.mark.parametrize("name", [name for name, (*_, springs) in SOLIDS.items() if not springs])
def test_secant_energy_takes_another_energy(name, storage):
    """Dilatations go back when bonds break: a tenth or more is missing or too much, so it takes no fracture energy."""
    dimension, m, make, _ = SOLIDS[name]
    w0 = critical_bond_energy(G0, dimension, (m + 0.015) * H, {1: 2e-6, 2: 5e-3, 3: 1.0}[dimension])
    secant = taken(make, dimension, CriticalBondEnergy(w0, form="secant"), m, storage=storage)
    bonds = w0 * crossing_pairs(dimension, m)
    assert 0.02 < abs(secant / bonds - 1) < 0.3
    block = rbs.Part("block", rbs.Box(size=(6 * H,) * dimension)).discretize(H, **ACROSS[dimension]).connect(2 * H)
    with pytest.raises(rbs.BadInput, match="depends on the path"):
        make(block, CriticalBondEnergy(fracture_energy=G0, form="secant"))


@pytest.mark.parametrize(("dimension", "m", "times"), [(1, 4, 7), (2, 4, 8), (3, 3, 10)])
def test_mean_energy_of_nodes_takes_several_times_more(dimension, m, times):
    """Beside a crack most bonds of a node are not strained, and the mean counts them."""
    w0 = critical_bond_energy(G0, dimension, (m + 0.015) * H, {1: 2e-6, 2: 5e-3, 3: 1.0}[dimension])
    found = taken(bond_based(), dimension, CriticalNodalEnergy(w0), m)
    assert found / G0 == pytest.approx(times, rel=0.3)
