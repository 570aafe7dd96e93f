"""The extension API: five hooks, no more."""

from __future__ import annotations

import inspect

import pluggy
import pytest

from rbs_core import Analysis, hookimpl, hookspecs
from rbs_core.plugins import Registry
from tests.unit.core.toys import Toy, line

HOOKS = {
    "rbs_relations": [],
    "rbs_fields": [],
    "rbs_geometries": [],
    "rbs_analysis_started": ["analysis"],
    "rbs_analysis_finished": ["analysis", "report"],
}


def test_these_hooks_and_no_others():
    found = {name: value for name, value in vars(hookspecs).items() if name.startswith("rbs_")}
    assert {name: list(inspect.signature(value).parameters) for name, value in found.items()} == HOOKS


@pytest.mark.parametrize("name", HOOKS)
def test_each_hook_is_documented_and_asks_every_plugin(name):
    hook = getattr(hookspecs, name)
    assert hook.__doc__.strip().endswith(".")
    assert not hook.rbs_spec["firstresult"]  # or the order of plugins would carry a meaning


def test_the_manager_knows_them_all():
    hooks = Registry(discover=False).manager.hook
    assert {name for name in vars(hooks) if not name.startswith("__")} == set(HOOKS)


def test_every_plugin_is_asked(empty_registry):
    class Plugin:
        def __init__(self, name):
            self.name = name

        @hookimpl
        def rbs_relations(self):
            return [type(self.name, (Toy,), {})]

    empty_registry.register(Plugin("Granite"))
    empty_registry.register(Plugin("Basalt"))
    assert sorted(empty_registry.relations()) == ["Basalt", "Granite"]


def test_a_plugin_may_ask_for_fewer_arguments_and_for_no_others(empty_registry):
    told = []

    class Silent:
        @hookimpl
        def rbs_analysis_finished(self):
            told.append("finished")

    class Greedy:
        @hookimpl
        def rbs_analysis_finished(self, weather):
            told.append(weather)

    empty_registry.register(Silent())
    with pytest.raises(pluggy.PluginValidationError, match="weather"):
        empty_registry.register(Greedy())
    Analysis([Toy(line())]).run(steps=1, dt=0.1)
    assert told == ["finished"]


def test_no_hook_is_called_in_every_step(empty_registry):
    told = []
    empty_registry.manager.add_hookcall_monitoring(lambda name, *_: told.append(name), lambda *_: None)
    Analysis([Toy(line())]).run(steps=50, dt=0.1)
    assert told == ["rbs_analysis_started", "rbs_analysis_finished"]
