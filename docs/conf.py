"""Builds the pages as a site: `sphinx-build -W docs out/site`.

The pages are Markdown and stay readable as they are. Lines such as `:::{names} rbs_core.geometry` become the reference
of the public names of a module, from their docstrings.
"""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import rbs_core
import rbs_plugins
from rbs_core import Field

project = "RBS"
author = copyright = "the authors of RBS"
version = release = rbs_core.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "index"
html_theme = "furo"
html_title = "RBS"
html_show_sourcelink = html_copy_source = False
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 4
highlight_language = "text"

# Types stand beside the description of an argument; signatures stay short.
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_inherit_docstrings = False  # what a class only overrides is described at its base
# Names of types that say more than what they stand for.
ALIASES = ("ArrayLike", "BoolArray", "BoundsFunction", "Crossing", "FloatArray", "Function", "Predicate", "Region")
autodoc_type_aliases = {name: name for name in ALIASES}
python_use_unqualified_type_names = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
nitpicky = True
# Public names must lead somewhere. Those of Python and numpy, and what is inside of modules, are not on this site.
nitpick_ignore_regex = [(r"py:.*", r"(?!rbs_(core|plugins)\.\w+$).*")]
suppress_warnings = ["ref.python"]  # attributes of several classes have one name

PACKAGES = (rbs_core, rbs_plugins)
NAMES = re.compile(r"^:::\{names\} (?P<module>[\w.]+)\n:::$", re.MULTILINE)


# -- the reference of public names --------------------------------------------------------------------------------


def places(text: str) -> Iterator[tuple[str, str]]:
    """(module, name) of what the lines `:::{names}` of a page show: a module that users import from, and its name."""
    for found in NAMES.finditer(text):
        module = importlib.import_module(found["module"])
        for name in public(module):
            home = next((package for package in PACKAGES if offers(package, module, name)), module)
            yield home.__name__, name


def public(module: ModuleType) -> list[str]:
    """The names of a module, sorted: those in `__all__`, or those that are made in it.

    Where a package offers some functions of a module, the others are for itself.
    """
    listed = getattr(module, "__all__", None)
    if listed is None:
        here = {name: value for name, value in vars(module).items() if made_in(module, name, value)}
        offered = {name for name in here for package in PACKAGES if offers(package, module, name)}
        helpers = {name for name, value in here.items() if inspect.isfunction(value)} - offered
        some = any(inspect.isfunction(here[name]) for name in offered)
        listed = here.keys() - helpers if some else here.keys()
    return sorted((name for name in listed if not name.startswith("_")), key=str.lower)


def made_in(module: ModuleType, name: str, value: Any) -> bool:
    """True for what a module makes itself, be it an object of a class from outside of this project."""
    home = getattr(value, "__module__", None) or ""
    offered = any(offers(package, module, name) for package in PACKAGES)
    return home == module.__name__ or (offered and not inspect.ismodule(value) and not home.startswith("rbs_"))


def offers(package: ModuleType, module: ModuleType, name: str) -> bool:
    """True if a package offers the very same thing under the same name."""
    return name in package.__all__ and getattr(package, name) is getattr(module, name)


def entry(home: str, name: str) -> str:
    """The lines that make autodoc describe one name."""
    thing = getattr(importlib.import_module(home), name)
    if inspect.ismodule(thing):
        return ""  # has lines `:::{names}` of its own
    if inspect.isclass(thing):
        bases = "   :show-inheritance:\n" if known_base(thing) else ""
        return f".. autoclass:: {home}.{name}\n   :members:\n{bases}"
    if inspect.isroutine(thing):
        return f".. autofunction:: {home}.{name}\n"
    return f".. py:data:: {home}.{name}\n   :type: {type(thing).__name__}\n\n   {data(thing)}\n"


def data(thing: Any) -> str:
    """What there is to say of an object that has no docstring of its own."""
    if isinstance(thing, Field):
        return f"{escaped(thing.doc)} Symbol {escaped(thing.symbol)}, unit {escaped(thing.unit)}, at {thing.at}."
    return "" if isinstance(thing, dict | list | tuple) else f"``{thing!r}``"


def with_names(app: Any, docname: str, source: list[str]) -> None:
    """Puts the entries in the place of the lines `:::{names}`; a thing that has two homes is described once a page."""
    seen = set()

    def entries(found: re.Match[str]) -> str:
        body = []
        for home, name in places(found[0]):
            thing = id(getattr(importlib.import_module(home), name))
            if thing not in seen:
                body.append(entry(home, name))
            seen.add(thing)
        return "```{eval-rst}\n" + "\n".join(body) + "\n```"

    source[0] = NAMES.sub(entries, source[0]).replace("](../README.md)", "](index.md)")


# -- docstrings ---------------------------------------------------------------------------------------------------


def as_restructured_text(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Docstrings are plain text with `code` between backticks."""
    pieces = re.split(r"(``.+?``|`[^`]+`)", "\n".join(lines), flags=re.DOTALL)
    for number, piece in enumerate(pieces):
        pieces[number] = f"``{' '.join(piece.strip('`').split())}``" if number % 2 else escaped(piece)
    lines[:] = "".join(pieces).split("\n")


def escaped(text: str) -> str:
    """Text in which bars, stars and underscores mean themselves."""
    return re.sub(r"([*|\\]|_(?!\w))", r"\\\1", text)


def whole_properties(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """What a property is may have a colon in it: not a type in front of it, as napoleon has it."""
    if what in ("property", "attribute") and (text := inspect.getdoc(thing)) and ": " in text.split("\n")[0]:
        lines[:] = text.split("\n")
        as_restructured_text(app, what, name, thing, options, lines)


def known_base(thing: type) -> type | None:
    """The nearest base of a class that users know."""
    known = {id(getattr(package, each)) for package in PACKAGES for each in package.__all__}
    return next((base for base in thing.__mro__[1:] if id(base) in known), None)


def known_bases(app: Any, name: str, thing: type, options: Any, bases: list[Any]) -> None:
    """A class derives from what users know, not from what it shares with others inside."""
    bases[:] = [known_base(thing)]


def setup(app: Any) -> None:
    """Called by Sphinx."""
    from pygments.lexers.special import TextLexer

    app.add_lexer("output", TextLexer)  # what a block of code prints
    app.connect("source-read", with_names)
    app.connect("autodoc-process-docstring", as_restructured_text, priority=100)  # before napoleon
    app.connect("autodoc-process-docstring", whole_properties, priority=900)
    app.connect("autodoc-process-bases", known_bases)
