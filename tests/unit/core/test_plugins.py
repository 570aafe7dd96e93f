"""Plugins are found, chosen, and never bring a scene down by themselves."""

from __future__ import annotations

import subprocess
import sys
import warnings
from types import ModuleType, SimpleNamespace

import pytest

import rbs_core as rbs
from rbs_core import Analysis, BadInput, FieldClash, hookimpl, plugins
from rbs_core.fields import KERNEL_FIELDS
from rbs_core.plugins import Registry, registry, selected, use_registry
from tests.unit.core.toys import Toy, a, b, field, line


def plugin(name: str, relations=(), fields=(), geometries=()) -> ModuleType:
    """A module with hooks."""
    module = ModuleType(name)
    module.__file__ = f"/site/{name}.py"
    module.rbs_relations = hookimpl(lambda: relations, specname="rbs_relations")
    module.rbs_fields = hookimpl(lambda: fields, specname="rbs_fields")
    module.rbs_geometries = hookimpl(lambda: geometries, specname="rbs_geometries")
    return module


def relation(name: str, module: str = "somewhere", **contract) -> type[rbs.Relation]:
    return type(name, (rbs.Relation,), {"__module__": module, **contract})


@pytest.fixture
def installed(monkeypatch):
    """Fakes installed packages: installed(name=module or error, ...); returns the names of what was imported."""
    monkeypatch.delenv("RBS_PLUGINS", raising=False)
    monkeypatch.delenv("RBS_TRACE", raising=False)

    def install(*pairs, **named):
        loaded = []

        def load(name, what):
            loaded.append(name)
            if isinstance(what, Exception):
                raise what
            return what

        points = [
            SimpleNamespace(
                name=n, value=getattr(what, "__name__", "broken"), load=lambda n=n, what=what: load(n, what)
            )
            for n, what in (*pairs, *named.items())
        ]
        monkeypatch.setattr(plugins.metadata, "entry_points", lambda group: points if group == "rbs" else [])
        return loaded

    return install


# -- discovery ------------------------------------------------------------------------------------------------------


def test_what_is_installed_is_offered(installed):
    granite = plugin("rbs_granite", [relation("Granite")], [a], [rbs.Box])
    loaded = installed(granite=granite)
    found = Registry()
    assert loaded == ["granite"]
    assert list(found.relations()) == ["Granite"]
    assert list(found.geometries()) == ["Box"]
    assert list(found.fields()) == [*(each.name for each in KERNEL_FIELDS), "a"]
    assert found.sources == {"granite": "/site/rbs_granite.py"}
    assert found.failed == {}


def test_our_own_plugins_come_through_the_same_door(monkeypatch):
    monkeypatch.delenv("RBS_PLUGINS", raising=False)
    found = Registry()
    assert found.relations()["BondBased"].__module__.startswith("rbs_plugins.")
    assert found.sources["rbs_plugins"].endswith("__init__.py")


def test_importing_the_kernel_imports_no_plugin():
    """Nor anything that a script may not need."""
    script = (
        "import sys, rbs_core, rbs_core.__main__\n"
        "print([name for name in sys.modules if name.split('.')[0] in ('rbs_plugins', 'numba', 'pyvista', 'meshio')])"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_registry_is_filled_when_first_needed_and_once(installed):
    loaded = installed(granite=plugin("rbs_granite"))
    before = use_registry(None)
    try:
        assert loaded == []
        assert registry() is registry()
        assert loaded == ["granite"]
    finally:
        use_registry(before)


def test_another_registry_can_be_put_in_place(empty_registry):
    assert registry() is empty_registry
    assert registry().relations() == {}
    other = Registry(discover=False)
    assert use_registry(other) is empty_registry
    assert use_registry(empty_registry) is other


def test_a_plugin_that_cannot_be_imported_costs_one_warning(installed):
    installed(
        bad=ImportError("no module named 'rock'"),
        good=plugin("rbs_good", [relation("Good")]),
        worse=SystemError("boom"),
    )
    with pytest.warns(UserWarning, match="cannot be loaded") as caught:
        found = Registry()
    assert [str(warning.message) for warning in caught] == [
        "plugin 'bad' cannot be loaded (ImportError: no module named 'rock'): it is left out",
        "plugin 'worse' cannot be loaded (SystemError: boom): it is left out",
    ]
    assert list(found.relations()) == ["Good"]
    assert found.failed == {"bad": "ImportError: no module named 'rock'", "worse": "SystemError: boom"}


@pytest.mark.parametrize("bad", ["rbs_analysis_started", "rbs_relations"])
def test_a_plugin_with_a_hook_of_the_wrong_form_is_left_out_as_a_whole(installed, bad):
    module = plugin("rbs_wrong", [relation("Wrong")], [a])
    setattr(module, bad, hookimpl(lambda colour: None, specname=bad))
    installed(wrong=module)
    with pytest.warns(UserWarning, match=r"(?s)plugin 'wrong' cannot be loaded .*colour"):
        found = Registry()
    assert found.relations() == {}
    assert "a" not in found.fields()
    assert found.sources == {}


def test_a_misspelt_hook_is_named(installed):
    """Or its author would look for his relations in vain."""
    module = plugin("rbs_granite", [relation("Granite")])
    module.rbs_relation = hookimpl(lambda: [])
    installed(granite=module)
    with pytest.warns(UserWarning, match=r"plugin 'granite' has a hook rbs_relation, which nobody calls: misspelt\?"):
        found = Registry()
    assert list(found.relations()) == ["Granite"]
    module.rbs_relation = hookimpl(lambda: [], optionalhook=True)  # of a version to come
    assert list(Registry().relations()) == ["Granite"]


def test_two_plugins_of_one_name(installed):
    first, second = plugin("rbs_first", [relation("First")]), plugin("rbs_second", [relation("Second")])
    loaded = installed(("rock", first), ("rock", second))
    with pytest.warns(UserWarning, match="two plugins are called 'rock': rbs_first is used, rbs_second is not"):
        found = Registry()
    assert list(found.relations()) == ["First"]
    assert loaded == ["rock"]


def test_one_plugin_that_is_listed_twice(installed):
    """A stale egg-info beside an editable installation."""
    module = plugin("rbs_granite", [relation("Granite")])
    installed(("granite", module), ("granite", module))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert list(Registry().relations()) == ["Granite"]


# -- choosing -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("choice", "expected"),
    [
        ("", ["granite", "ice", "steel"]),
        ("ice", ["ice"]),
        (" steel , ice ,", ["steel", "ice"]),
        ("-ice", ["granite", "steel"]),
        ("granite,ice,-ice", ["granite"]),
        ("-ice,-steel,-granite", []),
    ],
)
def test_the_environment_chooses(installed, monkeypatch, choice, expected):
    loaded = installed(granite=plugin("g"), ice=plugin("i"), steel=plugin("s"))
    monkeypatch.setenv("RBS_PLUGINS", choice)
    Registry()
    assert loaded == expected


def test_a_plugin_that_is_asked_for_and_not_there():
    message = r"RBS_PLUGINS asks for 'marble', which is not installed \(installed: granite, ice\)"
    with pytest.raises(BadInput, match=message):
        selected(["granite", "ice"], "granite,marble")


def test_a_trace_of_the_hooks_goes_to_stderr(monkeypatch, capsys):
    monkeypatch.setenv("RBS_TRACE", "1")
    traced = Registry(discover=False)
    before = use_registry(traced)
    try:
        Analysis([Toy(line())]).run(steps=1, dt=0.1)
    finally:
        use_registry(before)
    shown = capsys.readouterr()
    assert "[rbs hook]" in shown.err
    assert "rbs_analysis_started" in shown.err
    assert "rbs_analysis_finished" in shown.err
    assert shown.out == ""


@pytest.mark.parametrize("off", ["", "0"])
def test_no_trace_unless_asked_for(monkeypatch, capsys, off):
    monkeypatch.setenv("RBS_TRACE", off)
    Registry(discover=False).relations()
    assert capsys.readouterr().err == ""


# -- contradictions -------------------------------------------------------------------------------------------------


def test_two_relations_of_one_name(empty_registry):
    empty_registry.register(plugin("one", [relation("Rock", "one")]))
    empty_registry.register(plugin("two", [relation("Rock", "two")]))
    with pytest.raises(FieldClash, match=r"(one and two|two and one) both offer") as caught:
        empty_registry.relations()
    assert "both offer relations called Rock: switch one off with RBS_PLUGINS=-name" in str(caught.value)


def test_one_relation_offered_twice_is_one(empty_registry):
    rock = relation("Rock")
    empty_registry.register(plugin("one", [rock]))
    empty_registry.register(plugin("two", [rock]))
    assert empty_registry.relations() == {"Rock": rock}


def test_two_fields_of_one_name(empty_registry):
    empty_registry.register(plugin("one", fields=[a, b]))
    empty_registry.register(plugin("two", fields=[a]))
    assert empty_registry.fields()["a"] is a  # the same declaration may come twice
    empty_registry.register(plugin("three", fields=[field("b", unit="K")]))
    with pytest.raises(FieldClash, match=r"two plugins declare 'b': .*unit='.*unit='"):
        empty_registry.fields()


def test_the_fields_of_the_kernel_cannot_be_declared_differently(empty_registry):
    empty_registry.register(plugin("one", fields=[field("volume", unit="litre")]))
    with pytest.raises(FieldClash, match="'volume'"):
        empty_registry.fields()


# -- who provides ---------------------------------------------------------------------------------------------------


def test_providers_are_found_by_every_word_but_reads(empty_registry):
    words = ("reads", "writes", "updates", "adds", "offers")
    empty_registry.register(plugin("one", [relation(word.title(), **{word: (a,)}) for word in words]))
    assert sorted(empty_registry.providers(a)) == ["Adds", "Offers", "Updates", "Writes"]
    assert empty_registry.providers(b) == []


def test_contracts_that_depend_on_arguments_are_no_obstacle(empty_registry):
    depends = relation("Depends", writes=property(lambda self: (a,)))
    empty_registry.register(plugin("one", [depends, relation("Sure", writes=(a,))]))
    assert empty_registry.providers(a) == ["Sure"]
