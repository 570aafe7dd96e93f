"""What parts and connections have in common."""

from __future__ import annotations

import pytest

from rbs_core.part import Connection, Host, Part
from tests.unit.core.toys import field, line

strength = field("strength", at="bond")


@pytest.mark.parametrize("kind", ["part", "connection"])
def test_fields_are_made_found_and_asked_for(kind):
    part = line(4, "one", horizon=1.5)
    host = part if kind == "part" else Connection(part, line(4, "two"), pairs=[[0, 1]])
    assert isinstance(host, Host)
    assert host.connected
    assert strength not in host
    host.raw(strength)
    assert strength in host
    host[strength] = 2.0
    assert host[strength].tolist() == [2.0] * (6 if kind == "part" else 2)
    assert not host.searched_again


def test_a_part_is_a_host():
    assert issubclass(Part, Host)
