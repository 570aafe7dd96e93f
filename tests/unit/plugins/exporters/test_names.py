"""Names that are nearly right, and lists of one."""

from __future__ import annotations

import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins.exporters.names import field_of, fields_of, listed, nearest
from rbs_plugins.fields import damage, displacement, kinetic_energy


def test_lists_of_one():
    assert listed(damage) == (damage,)
    assert listed([damage, damage]) == (damage, damage)
    assert listed("damage") == ("damage",)
    assert listed(3) == (3,)
    assert listed(x for x in "ab") == ("a", "b")
    assert listed(()) == ()


def test_each_field_once():
    given = [damage, displacement, damage]
    assert fields_of("me", given, ("node",), "why") == (damage, displacement)


def test_nearest_names():
    known = ["velocity", "volume", "damage", "displacement"]
    assert nearest("velocty", known) == "the nearest names are velocity"
    assert nearest("xyz", known) == "there are damage, displacement, velocity, volume"
    assert nearest("xyz", []) == "there are none"


@pytest.mark.parametrize(
    ("given", "places", "message"),
    [
        ("damage", ("node",), "me: 'damage' is no node field: why; 'damage' is a name: give the field itself, as in"),
        ("kinetic_energy", ("node",), "me: 'kinetic_energy' is no node field: why; "),
        (kinetic_energy, ("node", "bond"), r"me: Field\('kinetic_energy'.* is no node field and no bond field: why; "),
        (
            damage,
            ("part",),
            r"is no number of the part: why; there are crack_tip, crack_tip_speed, external_work, fracture_dissipation",
        ),
        (None, ("node",), "me: None is no node field: why$"),
    ],
)
def test_another_field_is_refused(given, places, message):
    with pytest.raises(BadInput, match=message):
        field_of("me", given, places, "why")


def test_fields_of_other_packages_are_known():
    wear = rbs.Field("wear", "node", "scalar", "1", "w", "How much a node has suffered.")

    class Other:
        @rbs.hookimpl
        def rbs_fields():
            return [wear]

    from rbs_core.testing import isolated_registry

    with isolated_registry("rbs_plugins", Other), pytest.raises(BadInput, match=r"the nearest names are wear$"):
        field_of("me", "waer", ("node",), "why")
