"""Control of zero-energy modes, as printed by Hashim (2021): divided by the volume of each family."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_plugins import Correspondence, SillingControl, StrainEnergy
from rbs_plugins.constitutive.stress import saint_venant_kirchhoff
from rbs_plugins.fields import density, displacement, strain_energy_density, volume

H = 1e-3


def test_control_by_family_is_divided_by_the_volume_of_each_family(rng):
    part = (
        rbs.Part("plate", rbs.Box(size=(8 * H, 6 * H))).discretize(H, thickness=2e-3).connect(3.015 * H, storage="list")
    )
    part[density] = 1000.0
    part[displacement] = 0.01 * H * rng.standard_normal((len(part), 2))
    energies = []
    for control in (SillingControl(1.0), SillingControl(2.0), SillingControl(1e-8, by_family=True)):
        force = Correspondence(part, saint_venant_kirchhoff, E=1e9, nu=0.3, stabilization=control)
        rbs.Analysis([force, StrainEnergy(part, force)], dt=1e-8).run(steps=1, progress=False)
        energies.append(part[strain_energy_density].copy())
    offsets, neighbors = part.bonds.as_rows()
    family = np.add.reduceat(part[volume][neighbors], offsets[:-1])
    of_control = energies[1] - energies[0]
    expected = energies[0] + of_control * (1e-8 / family - 1)
    np.testing.assert_allclose(energies[2], expected, rtol=1e-9)


def test_control_by_family_needs_a_list():
    assert repr(SillingControl(0.1)) == "SillingControl(0.1)"
    control = SillingControl(1e-8, by_family=True)
    assert repr(control) == "SillingControl(1e-08, by_family=True)"
    part = rbs.Part("plate", rbs.Box(size=(8 * H, 6 * H))).discretize(H).connect(2.015 * H, storage="lattice")
    part[density], part[displacement] = 1000.0, 0.0
    force = Correspondence(part, saint_venant_kirchhoff, E=1e9, nu=0.3, stabilization=control)
    with pytest.raises(rbs.BadInput, match="list"):
        rbs.Analysis([force], dt=1e-8).run(steps=1, progress=False)
