"""`rbs list` and `rbs describe`."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import rbs_core
import rbs_plugins
from rbs_core import BadInput
from rbs_core.command import main
from rbs_core.testing import isolated_registry


@pytest.fixture
def built_in():
    """What this project offers, without strangers that happen to be installed."""
    with isolated_registry(rbs_plugins):
        yield


def told(capsys, *words: str) -> str:
    assert main(list(words)) == 0
    return capsys.readouterr().out


def test_list(built_in, capsys):
    sections = re.split(r"^(\w+)$", told(capsys, "list"), flags=re.MULTILINE)[1:]
    found = {title: text.strip("\n").splitlines() for title, text in zip(sections[::2], sections[1::2], strict=True)}
    assert list(found) == ["relations", "fields", "geometries", "plugins"]
    names = {title: [line.split()[0] for line in lines] for title, lines in found.items()}
    known = rbs_core.registry()
    assert names["relations"] == sorted(known.relations())
    assert names["fields"] == sorted(known.fields())
    assert names["geometries"] == sorted(known.geometries())
    damage = next(line for line in found["relations"] if line.split()[0] == "Damage")
    assert re.fullmatch(r"  Damage +measure +Broken share .*\.  \[rbs_plugins\.constitutive\.fracture\]", damage)
    assert "  density                  ρ      node scalar, kg/m^3: Mass per reference volume." in found["fields"]
    assert names["plugins"] == ["rbs_plugins"]
    assert found["plugins"][0].endswith(str(Path("rbs_plugins") / "__init__.py"))


def test_list_tells_which_plugins_failed(empty_registry, capsys):
    empty_registry.failed["granite"] = "ImportError: no stone"
    assert told(capsys, "list").splitlines()[-1].split() == ["granite", "failed:", "ImportError:", "no", "stone"]


def test_describe_a_relation(built_in, capsys):
    text = told(capsys, "describe", "FractureDissipation")
    assert text.startswith("FractureDissipation(")
    assert "the energy that bonds held when they broke" in text
    words = dict(line.split(maxsplit=1) for line in text.splitlines() if line.startswith("  "))
    assert words == {
        "reads": "dissipation_density, volume",
        "writes": "fracture_dissipation",
        "updates": "nothing",
        "adds": "nothing",
        "offers": "nothing",
    }
    assert text.splitlines()[-1].startswith("rbs_plugins.measures.")
    assert text.rstrip().endswith(".py")


def test_describe_a_contract_that_depends_on_the_arguments(built_in, capsys):
    text = told(capsys, "describe", "BondBased")
    assert re.search(r"^  updates  depends on the arguments: The state of the bonds, if they can fail\.$", text, re.M)
    assert re.search(r"^  adds     force_density$", text, re.M)


def test_describe_a_field(built_in, capsys):
    text = told(capsys, "describe", "damage")
    first, second, *users = text.splitlines()
    assert first == "damage (φ): Broken share of the family, by volume: 1 − Σ μV / ΣV."
    assert second == "  at node, scalar, unit 1"
    assert "  Damage writes it" in users
    assert users[-1].startswith("  depends on their arguments: ")
    assert " BondBased, " in users[-1]
    assert "StrainEnergy" in users[-1]
    assert not any(line.split()[0] in ("Kick", "Drift", "KineticEnergy") for line in users)


def test_describe_names_fields_exactly(built_in, capsys):
    """`strain_energy_density` is no `strain_energy`, and `intact` is a whole word."""
    users = told(capsys, "describe", "strain_energy").splitlines()[2:]
    assert "  StrainEnergy writes it" in users
    users = told(capsys, "describe", "density").splitlines()[2:]
    assert "  Kick reads it" in users
    assert not any("Drift" in line or "FractureDissipation" in line for line in users)


def test_describe_a_geometry(built_in, capsys):
    text = told(capsys, "describe", "Ball")
    assert text.startswith("Ball(radius: ")
    assert "Interval, disk or ball" in text


def test_describe_what_nobody_knows(built_in, capsys):
    assert main(["describe", "Granit"]) == 2
    message = capsys.readouterr().err
    assert message.startswith(f"rbs: {BadInput.__name__}: nobody knows 'Granit'; known are ")
    assert main(["describe", "bondbased"]) == 2
    assert "nobody knows 'bondbased' (did you mean BondBased?); known" in capsys.readouterr().err
    assert all(name in message for name in ("Ball", "BondBased", "damage"))
