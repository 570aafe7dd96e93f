"""Every field and every relation says what it is: in code, and on its page of the reference."""

from __future__ import annotations

import re

import pytest

from rbs_core.plugins import Registry
from rbs_core.relation import Relation
from tests.guards.sources import ROOT

# Products and quotients of SI units with whole powers: kg/m^3, N/m^6, m/s^2, 1.
UNIT = re.compile(r"(1|(kg|m|s|N|J|Pa|K|W|Hz|rad)(\^\d)?)((/| )(kg|m|s|N|J|Pa|K|W|Hz|rad)(\^\d)?)*")


@pytest.fixture(scope="module")
def registry() -> Registry:
    """What this project offers, without strangers that happen to be installed."""
    found = Registry(discover=False)
    found.register(__import__("rbs_plugins"), "rbs_plugins")
    return found


def page(name: str) -> str:
    path = ROOT / "docs" / name
    assert path.exists(), f"{path.relative_to(ROOT)} is missing"
    return path.read_text(encoding="utf-8")


def named(name: str, text: str) -> bool:
    return re.search(rf"(?<!\w){re.escape(name)}(?!\w)", text) is not None


def test_there_is_a_vocabulary(registry):
    assert {"displacement", "volume", "intact", "force_density"} <= registry.fields().keys()
    assert {"BondBased", "Damage", "Kick"} <= registry.relations().keys()
    assert "Box" in registry.geometries()


def test_every_field_has_a_unit_a_symbol_and_one_sentence(registry):
    wrong = []
    for name, field in registry.fields().items():
        if not UNIT.fullmatch(field.unit):
            wrong.append(f"{name}: {field.unit!r} is no SI unit")
        if not field.symbol.strip():
            wrong.append(f"{name}: no symbol")
        # a stop ends the sentence, and nothing starts behind one
        if not re.fullmatch(r"[A-Z0-9][^\n]*\.", field.doc) or re.search(r"\. [A-Z]", field.doc):
            wrong.append(f"{name}: {field.doc!r} is not one sentence")
        if not re.fullmatch(r"[a-z]+(_[a-z]+)*", name):
            wrong.append(f"{name}: names are full English words in lower case")
    assert not wrong, "\n".join(wrong)


def test_no_two_fields_of_a_place_share_a_symbol(registry):
    seen: dict[tuple[str, str], str] = {}
    for name, field in registry.fields().items():
        other = seen.setdefault((field.at, field.symbol), name)
        assert other == name, f"{name} and {other} both have the symbol {field.symbol}"


def test_every_relation_says_what_it_does(registry):
    wrong = []
    for name, relation in registry.relations().items():
        assert issubclass(relation, Relation)
        own = (relation.__dict__.get("__doc__") or "").strip()
        first = own.split("\n\n")[0]
        if not first or first[-1] not in ".)":
            wrong.append(f"{name}: {first!r} is no sentence")
    assert not wrong, "\n".join(wrong)


def test_every_geometry_says_what_it_is(registry):
    for name, geometry in registry.geometries().items():
        assert (geometry.__dict__.get("__doc__") or "").strip(), f"{name} has no docstring of its own"


def test_every_relation_is_on_its_page(registry):
    text = page("reference_relations.md")
    missing = [name for name in registry.relations() if not named(name, text)]
    assert not missing, f"docs/reference_relations.md does not know {missing}"


def test_every_field_is_on_its_page(registry):
    text = page("reference_fields.md")
    missing = [name for name in registry.fields() if not named(name, text)]
    assert not missing, f"docs/reference_fields.md does not know {missing}"
