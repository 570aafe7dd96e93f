"""The vocabulary."""

from __future__ import annotations

import rbs_core as rbs
from rbs_plugins import fields


def test_every_field_of_the_module_is_in_the_vocabulary():
    declared = {name: value for name, value in vars(fields).items() if isinstance(value, rbs.Field)}
    kernel = {"intact", "is_fictitious", "reference_position", "volume"}
    assert set(declared) - kernel == {field.name for field in fields.VOCABULARY}
    assert all(name == field.name for name, field in declared.items())
    assert set(fields.__all__) == {*declared, "VOCABULARY"}


def test_registry_knows_them():
    known = rbs.registry().fields()
    assert all(known[field.name] is field for field in fields.VOCABULARY)


def test_each_says_what_it_is_once():
    for attribute in ("name", "doc"):
        values = [getattr(field, attribute) for field in fields.VOCABULARY]
        assert len(set(values)) == len(values)
    for field in fields.VOCABULARY:
        assert field.unit
        assert field.symbol
        assert field.doc.endswith(".")
