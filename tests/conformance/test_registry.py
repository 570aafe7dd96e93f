"""Every built-in relation against the public conformance suite; time integrators against the orders they claim."""

from __future__ import annotations

import pytest

from rbs_plugins import SymplecticEuler, VelocityVerlet
from rbs_plugins.testing import check_order, conformance

# Loops differ by dimension, by how bonds are stored and by whether nodes are alike: every one of these is met on each
# commit, all combinations with --verify.
EACH_COMMIT = {1: ("lattice",), 2: ("jittered", "lattice", "single"), 3: ("jittered", "lattice")}

DEAR = ((1, "lattice"), (2, "jittered"), (2, "lattice"))  # of models with many loops


def marks(case):
    dear = case.relation_class.__name__ == "Correspondence" and (case.dimension, case.cloud) not in DEAR
    return [pytest.mark.verify] if dear or case.cloud not in EACH_COMMIT[case.dimension] else []


test_relation = conformance("rbs_plugins", marks=marks)


@pytest.mark.parametrize("scheme", [VelocityVerlet, SymplecticEuler])
def test_claimed_order(scheme):
    check_order(scheme)
