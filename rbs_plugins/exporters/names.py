"""Fields that an exporter was asked for: taken as they are, or refused with the nearest names that there are."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from rbs_core import BadInput, Field, registry
from rbs_core.errors import nearest

KINDS = {"node": "node field", "bond": "bond field", "part": "number of the part"}


def listed(given: Any) -> tuple[Any, ...]:
    """What was given as a list of things or as one of them, as a tuple."""
    return (given,) if isinstance(given, str) or not isinstance(given, Iterable) else tuple(given)


def fields_of(label: str, given: Any, places: Sequence[str], why: str) -> tuple[Field, ...]:
    """The fields that were asked for, each once.

    Args:
        label: of the exporter, for messages.
        given: a field or several.
        places: where such fields live, e.g. ("node",).
        why: end of the message about another one.

    Raises:
        BadInput: on anything else than a field of one of these places; with the nearest names of the registry.
    """
    return tuple(dict.fromkeys(field_of(label, each, places, why) for each in listed(given)))


def field_of(label: str, given: Any, places: Sequence[str], why: str) -> Field:
    """The same for one field."""
    if isinstance(given, Field) and given.at in places:
        return given
    kinds = " and no ".join(KINDS[place] for place in places)
    raise BadInput(f"{label}: {given!r} is no {kinds}: {why}{_instead(given, places)}")


def _instead(given: Any, places: Sequence[str]) -> str:
    """What was probably meant by a name, or by a field of another place."""
    name = given.name if isinstance(given, Field) else given
    if not isinstance(name, str):
        return ""
    known = [field.name for field in registry().fields().values() if field.at in places]
    if name in known:
        return f"; {name!r} is a name: give the field itself, as in `from rbs_plugins.fields import {name}`"
    return f"; {nearest(name, known)}"
