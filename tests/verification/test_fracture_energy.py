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
STEPS = 1500
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
    size = (2 * m * H, *((4 * m + 1) * H,) * (dimension - 1))
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


if __name__ == "__main__":
    import sys, time
    cases = [(1, bond_based(), "bb 1"), (2, bond_based("stress"), "bb s"), (2, bond_based("strain"), "bb e"), (3, bond_based(), "bb 3"),
      (1, ordinary(), "o 1")]
    cases += [(2, ordinary(nu, p), f"o {p} {nu}") for p in ("stress", "strain") for nu in (0.1, 0.25, 1/3, 0.45)]
    cases += [(2, ordinary(nu, "stress", "inverse"), f"o inv {nu}") for nu in (0.1, 0.45)]
    cases += [(3, ordinary(nu), f"o 3 {nu}") for nu in (0.1, 0.25, 0.4)]
    for d, make, name in cases:
        m = int(sys.argv[1]) if d > 2 else int(sys.argv[2])
        row = []
        w0 = critical_bond_energy(G0, d, (m + 0.015) * H, {1: 2e-6, 2: 5e-3, 3: 1.0}[d])
        for cr in (CriticalStretch(fracture_energy=G0), CriticalBondEnergy(fracture_energy=G0), CriticalBondEnergy(fracture_energy=G0, form="incremental"), CriticalBondEnergy(w0, form="secant"), CriticalNodalEnergy(w0)):
            t = time.time()
            try:
                row.append(f"{taken(make, d, cr, m) / G0:.4f} ({time.time()-t:.1f}s)")
            except Exception as e:
                row.append(type(e).__name__ + str(e)[:150])
        print(name, m, *row, flush=True)
