"""Plugins: found through entry points of the group "rbs", loaded when first needed.

RBS_PLUGINS=granite,rbs_plugins loads only those; RBS_PLUGINS=-granite loads all but that one; RBS_TRACE=1 prints every
hook call to stderr. A plugin that cannot be imported costs one warning with its name.
"""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Iterable
from importlib import metadata
from typing import Any

import pluggy

from rbs_core import hookspecs
from rbs_core.errors import BadInput, FieldClash
from rbs_core.fields import KERNEL_FIELDS, Field
from rbs_core.relation import Relation

GROUP = "rbs"


class Registry:
    """What the loaded plugins offer.

    Args:
        discover: whether to look for installed plugins; False gives an empty registry, for tests.
    """

    def __init__(self, discover: bool = True) -> None:
        self.manager = pluggy.PluginManager("rbs")
        self.manager.add_hookspecs(hookspecs)
        if os.environ.get("RBS_TRACE", "") not in ("", "0"):
            self.manager.trace.root.setwriter(lambda text: sys.stderr.write(f"[rbs hook] {text}"))
            self.manager.enable_tracing()
        self.failed: dict[str, str] = {}
        self.sources: dict[str, str] = {}
        if discover:
            self._discover()

    def _discover(self) -> None:
        points: dict[str, metadata.EntryPoint] = {}
        for point in metadata.entry_points(group=GROUP):
            known = points.setdefault(point.name, point)
            if known.value != point.value:
                warnings.warn(
                    f"two plugins are called '{point.name}': {known.value} is used, {point.value} is not: rename one",
                    stacklevel=4,
                )
        for name in selected(points, os.environ.get("RBS_PLUGINS", "")):
            try:
                self.register(points[name].load(), name)
            except Exception as error:  # a stranger may raise anything on import
                self.failed[name] = f"{type(error).__name__}: {error}"
                warnings.warn(f"plugin '{name}' cannot be loaded ({self.failed[name]}): it is left out", stacklevel=4)

    def register(self, plugin: Any, name: str | None = None) -> None:
        """Adds a module or object with `@hookimpl` functions."""
        try:
            registered = self.manager.register(plugin, name)
        except pluggy.PluginValidationError:
            if self.manager.is_registered(plugin):
                self.manager.unregister(plugin)  # older pluggy keeps the hooks before the bad one
            raise
        if registered is not None:
            self.sources[registered] = getattr(plugin, "__file__", None) or repr(plugin)
        for hook in self.manager.get_hookcallers(plugin) or []:
            if not hook.has_spec() and not all(each.optionalhook for each in hook.get_hookimpls()):
                warnings.warn(
                    f"plugin '{registered}' has a hook {hook.name}, which nobody calls: misspelt?", stacklevel=2
                )

    def relations(self) -> dict[str, type[Relation]]:
        """Every relation class by name.

        Raises:
            FieldClash: if two plugins offer different relations under one name.
        """
        return self._by_name(self.manager.hook.rbs_relations(), "relations")

    def geometries(self) -> dict[str, type]:
        """Every geometry class by name."""
        return self._by_name(self.manager.hook.rbs_geometries(), "geometries")

    def _by_name(self, offers: Iterable[Iterable[type]], kind: str) -> dict[str, Any]:
        found: dict[str, type] = {}
        for offer in offers:
            for each in offer:
                other = found.setdefault(each.__name__, each)
                if other is not each:
                    raise FieldClash(
                        f"{other.__module__} and {each.__module__} both offer {kind} called {each.__name__}: switch "
                        "one off with RBS_PLUGINS=-name"
                    )
        return found

    def fields(self) -> dict[str, Field]:
        """Every field of the vocabulary by name.

        Raises:
            FieldClash: if two plugins declare one name differently.
        """
        found = {each.name: each for each in KERNEL_FIELDS}
        for offer in self.manager.hook.rbs_fields():
            for each in offer:
                if found.setdefault(each.name, each) != each:
                    raise FieldClash(f"two plugins declare '{each.name}': {found[each.name]!r} and {each!r}")
        return found

    def providers(self, field: Field) -> list[str]:
        """Names of the relations whose class contract can provide a field."""
        names = []
        for name, relation in self.relations().items():
            offers = [getattr(relation, word) for word in ("writes", "updates", "adds", "offers")]
            if any(isinstance(offer, tuple) and field in offer for offer in offers):
                names.append(name)
        return names


def selected(points: Iterable[str], choice: str) -> list[str]:
    """Names of the plugins to load: all, only the named ones, or all but those with a minus.

    Raises:
        BadInput: if RBS_PLUGINS names a plugin that is not installed.
    """
    names = [name.strip() for name in choice.split(",") if name.strip()]
    wanted = [name for name in names if not name.startswith("-")]
    unwanted = [name[1:] for name in names if name.startswith("-")]
    known = list(points)
    for name in wanted:
        if name not in known:
            raise BadInput(f"RBS_PLUGINS asks for '{name}', which is not installed (installed: {', '.join(known)})")
    return [name for name in (wanted or known) if name not in unwanted]


_current: Registry | None = None


def registry() -> Registry:
    """The registry of this process, filled at the first call."""
    global _current  # one process has one set of plugins
    if _current is None:
        _current = Registry()
    return _current


def use_registry(new: Registry | None) -> Registry | None:
    """Makes another registry the one of this process (None: discover again at next need); returns the one before."""
    global _current
    before, _current = _current, new
    return before
