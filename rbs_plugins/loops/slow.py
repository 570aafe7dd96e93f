"""Which calls in a law keep its loop from computing several bonds at once, and what to write instead."""

from __future__ import annotations

import dis
import math
import re
import types
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from rbs_plugins.loops.source import FUNCTIONS, names_from_outside, plain

# Functions that the processor has no instruction for: in a compiled loop each is a call of a library, bond after bond.
_NAMES = """exp expm1 exp2 log log1p log2 log10 pow power cbrt hypot sin cos tan sinh cosh tanh asin acos atan atan2
    asinh acosh atanh arcsin arccos arctan arctan2 arcsinh arccosh arctanh erf erfc gamma lgamma"""
_SLOW = {getattr(module, name) for module in (math, np) for name in re.findall(r"\w+", _NAMES) if hasattr(module, name)}
_CURES = {"exp": "exp", "log": "log", "pow": "pow", "power": "pow", "tanh": "tanh"}
_warned: set[Any] = set()


def warn_of_slow_calls(function: Callable[..., Any], label: str) -> None:
    """Says once for each law what makes its loop slow.

    Warns:
        UserWarning: names the calls, and what computes the same.
    """
    law = plain(function)
    if law in _warned:
        return
    _warned.add(law)
    found = dict.fromkeys(slow_calls(law))
    if not found:
        return
    cures = dict.fromkeys(_CURES[name] for name in found if name in _CURES)
    cure = f"`from {FUNCTIONS} import {', '.join(cures)}` computes the same side by side" if cures else ""
    rest = [name for name in found if name not in _CURES]
    other = f"write {', '.join(rest)} with arithmetic, square roots or a polynomial, if you can" if rest else ""
    warnings.warn(
        f"{label} calls {', '.join(found)}, bond after bond, which makes its loop five to twenty times slower: "
        f"{'; '.join(each for each in (cure, other) if each)}",
        stacklevel=4,
    )


def slow_calls(function: Any, busy: tuple[Any, ...] = ()) -> Iterator[str]:
    """Names of the slow functions that a law or its helpers call; "pow" for powers that are not whole.

    It reads what Python has compiled, as laws need not have a source.
    """
    if not isinstance(function, types.FunctionType) or function in busy:
        return
    scope = names_from_outside(function)
    before = None
    for step in dis.get_instructions(function):
        if step.opname.startswith("BINARY") and step.argrepr.startswith("**") and not _quick_power(before):
            yield "pow"
        before = step.argval if step.opname.startswith("LOAD") else None
    names = (*function.__code__.co_names, *function.__code__.co_freevars)
    named = [scope[name] for name in names if name in scope]
    modules = [value for value in named if isinstance(value, types.ModuleType)]
    named += [getattr(module, name) for module in modules for name in names if hasattr(module, name)]
    for value in named:
        if isinstance(value, types.BuiltinFunctionType | np.ufunc):
            yield from [value.__name__] if value in _SLOW else []
        elif getattr(value, "__module__", None) != FUNCTIONS:
            yield from slow_calls(plain(value), (*busy, function))


def _quick_power(power: Any) -> bool:
    """True for whole numbers and 0.5, which become products and roots."""
    return isinstance(power, int) or power == 0.5
