"""`rbs list` and `rbs describe NAME`: what there is to build scenes from."""

from __future__ import annotations

import argparse
import difflib
import inspect
import re
from typing import Any

from rbs_core.errors import BadInput
from rbs_core.fields import Field
from rbs_core.plugins import Registry, registry
from rbs_core.relation import WORDS, Relation


def list_all(_: argparse.Namespace) -> int:
    """Prints relations, fields, geometries and plugins."""
    known = registry()
    print("relations")
    for name, relation in sorted(known.relations().items()):
        print(f"  {name:<20} {relation.role:<13} {_sentence(relation)}  [{relation.__module__}]")
    print("fields")
    for name, field in sorted(known.fields().items()):
        print(f"  {name:<24} {field.symbol:<6} {field.at} {field.shape}, {field.unit}: {field.doc}")
    print("geometries")
    for name, geometry in sorted(known.geometries().items()):
        print(f"  {name:<20} {_sentence(geometry)}")
    print("plugins")
    for name, source in known.sources.items():
        print(f"  {name:<20} {source}")
    for name, why in known.failed.items():
        print(f"  {name:<20} failed: {why}")
    return 0


def describe(options: argparse.Namespace) -> int:
    """Prints what a relation, field or geometry is.

    Raises:
        BadInput: if nobody knows the name.
    """
    known, name = registry(), options.name
    if name in known.relations():
        _relation(name, known.relations()[name])
    elif name in known.fields():
        _field(known.fields()[name], known)
    elif name in known.geometries():
        geometry = known.geometries()[name]
        print(f"{name}{_signature(geometry)}\n\n{inspect.getdoc(geometry)}")
    else:
        names = sorted([*known.relations(), *known.fields(), *known.geometries()])
        raise BadInput(f"nobody knows '{name}'{similar(name, names)}; known are {', '.join(names)}")
    return 0


def similar(name: str, names: list[str]) -> str:
    """A question, if some of the names look like the one that was typed."""
    lower = {each.lower(): each for each in names}
    close = [lower[each] for each in difflib.get_close_matches(name.lower(), lower, 2, 0.7)]
    return f" (did you mean {' or '.join(close)}?)" if close else ""


def _relation(name: str, relation: type[Relation]) -> None:
    print(f"{name}{_signature(relation)}\n")
    print(inspect.getdoc(relation) or "")
    print()
    for word in WORDS:
        print(f"  {word:<8} {_fields(relation, word)}")
    print(f"\n{relation.__module__}, {inspect.getsourcefile(relation)}")


def _signature(thing: type[Any]) -> str:
    """How to call it; types that the source has in quotes without them."""
    return re.sub(r"(: |-> )'([^']*)'", r"\1\2", str(inspect.signature(thing)))


def _field(field: Field, known: Registry) -> None:
    print(f"{field.name} ({field.symbol}): {field.doc}\n  at {field.at}, {field.shape}, unit {field.unit}")
    for name, each in sorted(known.relations().items()):
        declared = {word: getattr(each, word) for word in WORDS}
        words = [word for word, fields in declared.items() if isinstance(fields, tuple) and field in fields]
        if words:
            print(f"  {name} {', '.join(words)} it")
    open_ended = [name for name, each in known.relations().items() if _depends(each)]
    print(f"  depends on their arguments: {', '.join(sorted(open_ended))} (see rbs describe NAME)")


def _depends(relation: type[Relation]) -> bool:
    """True if the contract follows from the arguments of an instance."""
    return any(isinstance(getattr(relation, word), property) for word in WORDS)


def _fields(relation: type[Relation], word: str) -> str:
    declared = getattr(relation, word)
    if isinstance(declared, property):
        return f"depends on the arguments: {inspect.getdoc(declared)}"
    return ", ".join(field.name for field in declared) or "nothing"


def _sentence(thing: Any) -> str:
    return (inspect.getdoc(thing) or "").split("\n")[0]
