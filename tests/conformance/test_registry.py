"""Every built-in relation against the public conformance suite; time integrators against the orders they claim."""

from __future__ import annotations

import pytest

from rbs_plugins import SymplecticEuler, VelocityVerlet
from rbs_plugins.testing import check_order, conformance

test_relation = conformance("rbs_plugins")


@pytest.mark.parametrize("scheme", [VelocityVerlet, SymplecticEuler])
def test_claimed_order(scheme):
    check_order(scheme)
