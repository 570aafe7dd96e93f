"""What the argument names of correspondence laws mean: at a node, and at a bond."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from rbs_core import BadLaw, Field, registry
from rbs_core.part import Host
from rbs_plugins.loops.arguments import CLOCK, Argument, label, names_of, resolve
from rbs_plugins.loops.tensor_recipe import TENSORS


def resolve_node(
    function: Callable[..., Any], part: Host, values: dict[str, float], state: tuple[Field, ...]
) -> tuple[Argument, ...]:
    """Arguments of a function of a node: F, states, parameters, scalar fields of the node, time and dt.

    Raises:
        BadLaw: on a name that nobody knows; the message lists what is known.
    """
    known = {**registry().fields(), **{field.name: field for field in part.fields}}
    states = {field.name for field in state}
    names = names_of(function)
    at_node = {name: known[name] for name in names
               if name in known and known[name].at == "node" and known[name].shape == "scalar"
               and name not in values and name not in states}  # fmt: skip
    given = {"F", *states, *at_node}
    found = [*resolve_checked(function, part, values, given)]
    return tuple(replace(a, kind="node", field=at_node[a.name]) if a.name in at_node else a for a in found)


def resolve_checked(
    function: Callable[..., Any], part: Host, values: dict[str, float], given: set[str]
) -> list[Argument]:
    """As `resolve`, with a message for functions of a node."""
    try:
        found = resolve(function, part, values, given)
    except BadLaw as error:
        if "which nobody knows" not in str(error):
            raise
        found = [Argument("", "unknown")]
    if any(a.kind not in ("given", "parameter", "clock") for a in found):
        usable = {*given, *CLOCK, *values}
        name = next(name for name in names_of(function) if name not in usable)
        raise BadLaw(
            f"{label(function)} of part '{part.name}' asks for '{name}', which nobody knows at a node. Known are "
            f"{', '.join(sorted(given))}; {', '.join(CLOCK)}; parameters ({', '.join(values)}); scalar fields of nodes"
        )
    return found


def resolve_bond(function: Callable[..., Any], part: Host, values: dict[str, float]) -> tuple[Argument, ...]:
    """Arguments of a function of a bond: F_i, F_j, P_i, P_j, and whatever laws of bonds may ask for."""
    return tuple(resolve(function, part, values, TENSORS))
