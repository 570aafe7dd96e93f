"""The public suite on variants of correspondence that its example does not show."""

from __future__ import annotations

import pytest

from rbs_plugins import BondSoftening, Correspondence, CriticalShearStrain, MaximumPrincipalStress, WanControl
from rbs_plugins import testing as suite
from rbs_plugins.constitutive import stress

WAN = {"law": stress.neo_hookean, "stabilization": WanControl()}
SPLINE = {"law": stress.hencky, "plane": "strain", "influence": "cubic_spline", "partial_volume": "linear"}
CASES = [
    (suite.check_energy, 2, "jittered", WAN),
    (suite.check_angular_momentum, 2, "lattice", WAN),
    (suite.check_objectivity, 2, "jittered", WAN),
    (suite.check_stable_step, 2, "lattice", WAN),
    (suite.check_breaking, 2, "lattice", WAN),
    (suite.check_energy, 2, "jittered", SPLINE),
    (suite.check_storages, 2, "lattice",
     {"law": stress.hencky, "plane": "strain", "fracture": MaximumPrincipalStress(2e6)}),
    (suite.check_going_on, 2, "lattice", {"fracture": CriticalShearStrain(2e-3)}),
    (suite.check_going_on, 1, "jittered", {"fracture": BondSoftening(5e-4, 1e-3)}),
    (suite.check_going_on, 2, "jittered", {"law": stress.j2_plasticity, "yield_stress": 1e4, "hardening": 1e8}),
]  # fmt: skip


@pytest.mark.parametrize(("check", "dimension", "cloud", "arguments"), CASES)
def test_variant(check, dimension, cloud, arguments):
    check(Correspondence, dimension, cloud, **arguments)
