"""Every built-in relation against the public conformance suite; time integrators against the orders they claim."""

from __future__ import annotations

import pytest

from rbs_plugins import SymplecticEuler, VelocityVerlet
from rbs_plugins.testing import check_order, conformance

# Loops differ by dimension, storage, precision and whether nodes are alike: some of these are met on each commit, all
# combinations with --verify; of models with many loops of their own only one kind, of other forces but one a plane, of
# what makes no forces one cloud in a plane.
EACH_COMMIT = {1: (), 2: ("jittered", "lattice"), 3: ("lattice",)}
MANY_LOOPS = {"Correspondence": ((2, "lattice"),), "OrdinaryStateBased": ((2, "jittered"), (2, "lattice"))}
EVERYWHERE = "BondBased"  # the force that is met in space, too


def marks(case):
    name, kind = case.relation_class.__name__, (case.dimension, case.cloud)
    chosen = case.cloud in EACH_COMMIT[case.dimension] and kind in MANY_LOOPS.get(name, (kind,))
    chosen &= not (name == "ShortRangeRepulsion" and "tangent" in case.check.__name__)  # it is that of PairwiseForce
    if name != EVERYWHERE:
        force = case.relation_class.role == "constitutive"
        chosen &= case.dimension == 2 and (force or case.cloud == "jittered")
        chosen &= case.check.__name__ != "check_storages"
    return [] if chosen else [pytest.mark.verify]


test_relation = conformance("rbs_plugins", marks=marks)


@pytest.mark.parametrize("scheme", [VelocityVerlet, SymplecticEuler])
def test_claimed_order(scheme):
    check_order(scheme)
