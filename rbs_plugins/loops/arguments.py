"""What a law's argument names mean: kinematics of the bond, parameters, bond fields, node fields at either end."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from rbs_core import BadLaw, Field, registry
from rbs_core.part import Connection, Host
from rbs_plugins.loops.slow import warn_of_slow_calls
from rbs_plugins.loops.source import answers, plain

KINEMATICS = ("stretch", "extension", "length", "reference_length")
CLOCK = ("time", "dt")


@dataclass(frozen=True)
class Argument:
    """One resolved argument name.

    Attributes:
        name: as the law spells it.
        kind: "kinematic", "clock", "parameter", "bond", "node", or "given" for what the caller's loop computes.
        field: for "bond" and "node".
        value: for "parameter".
    """

    name: str
    kind: str
    field: Field | None = None
    value: float | None = None

    @property
    def array(self) -> str:
        """Name of the array that a loop takes for it."""
        return f"field_{self.field.name}" if self.field is not None else ""


def names_of(function: Callable[..., Any]) -> list[str]:
    """Argument names of a law.

    Raises:
        BadLaw: if it is no function of named arguments.
    """
    try:
        parameters = inspect.signature(plain(function)).parameters.values()
    except (TypeError, ValueError):
        raise BadLaw(f"{function!r} is no plain function: a law is a Python function of named arguments") from None
    for parameter in parameters:
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            raise BadLaw(f"{label(function)} takes *{parameter.name}: name each argument, so that it can be resolved")
    return [parameter.name for parameter in parameters]


def label(function: Callable[..., Any]) -> str:
    """Name and place of a law, for messages."""
    code = getattr(plain(function), "__code__", None)
    name = getattr(plain(function), "__name__", repr(function))
    return f"law '{name}'" if code is None else f"law '{name}' ({code.co_filename}, line {code.co_firstlineno})"


def resolve(
    function: Callable[..., Any], part: Host, parameters: dict[str, float], given: Collection[str] = ()
) -> list[Argument]:
    """Says once, for each argument name, where its value comes from; those in `given` come from the caller's loop.

    Raises:
        BadLaw: on a name that nobody knows (the message lists what is known), or a branch that returns nothing.

    Warns:
        UserWarning: once for a law that calls functions which make its loop slow.
    """
    defaults = {
        name: parameter.default
        for name, parameter in inspect.signature(plain(function)).parameters.items()
        if parameter.default is not parameter.empty
    }
    if not answers(function):
        raise BadLaw(f"{label(function)} returns nothing in some branch: every branch needs a return with a number")
    warn_of_slow_calls(function, label(function))
    hosts = (part, *part.ends) if isinstance(part, Connection) else (part,)
    known = {**registry().fields(), **{field.name: field for host in hosts for field in host.fields}}
    return [
        Argument(name, "given") if name in given else _one(name, function, part, {**defaults, **parameters}, known)
        for name in names_of(function)
    ]


def _one(
    name: str, function: Callable[..., Any], part: Host, parameters: dict[str, float], known: dict[str, Field]
) -> Argument:
    if name in KINEMATICS:
        return Argument(name, "kinematic")
    if name in CLOCK:
        return Argument(name, "clock")
    if name in parameters:
        return Argument(name, "parameter", value=_number(name, parameters[name], function))
    if name in known and known[name].at == "bond":
        return Argument(name, "bond", _scalar(known[name], function))
    if name[-2:] in ("_i", "_j") and name[:-2] in known and known[name[:-2]].at == "node":
        return Argument(name, "node", _scalar(known[name[:-2]], function))
    bonds = sorted(each for each, field in known.items() if field.at == "bond" and field.shape == "scalar")
    nodes = sorted(each for each, field in known.items() if field.at == "node" and field.shape == "scalar")
    raise BadLaw(
        f"{label(function)} of part '{part.name}' asks for '{name}', which nobody knows. Known are the kinematics "
        f"{', '.join(KINEMATICS)}; {', '.join(CLOCK)}; parameters given as keywords "
        f"({', '.join(parameters) or 'none'}); bond fields ({', '.join(bonds)}); "
        f"node fields with _i or _j behind ({', '.join(nodes)}). "
        "A field of your own counts once a plugin declares it or part[field] = ... has set it"
    )


def _number(name: str, value: Any, function: Callable[..., Any]) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = float("nan")
    if not np.isfinite(number):
        raise BadLaw(f"{label(function)}: the parameter {name}={value!r} must be a finite number")
    return number


def _scalar(field: Field, function: Callable[..., Any]) -> Field:
    if field.shape != "scalar":
        raise BadLaw(f"{label(function)} asks for '{field.name}', which is a {field.shape}: laws take scalar fields")
    return field


def fields(arguments: Iterable[Argument]) -> list[Field]:
    """The fields among arguments, each once."""
    return list(dict.fromkeys(a.field for a in arguments if a.field is not None))
