"""Compiled loops: the one place that decides how and on how many threads a loop runs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.core.errors import NumbaError

from rbs_core import BadLaw
from rbs_plugins.loops.arguments import names_of
from rbs_plugins.loops.source import compilable, plain

# A parallel region costs 5 to 15 microseconds; below this many items (bonds, entries of arrays) one thread is faster.
SERIAL_BELOW = 20_000


def run(kernel: Any, items: int, *arguments: Any) -> Any:
    """Calls a compiled parallel loop, on one thread if there is little to do. Results do not depend on that."""
    threads = numba.get_num_threads()
    if items >= SERIAL_BELOW or threads == 1:
        return kernel(*arguments)
    numba.set_num_threads(1)
    try:
        return kernel(*arguments)
    finally:
        numba.set_num_threads(threads)


def compile_loop(kernel: Any, arguments: tuple[Any, ...], functions: list[Any]) -> None:
    """Compiles a loop for its arguments without running it.

    Args:
        kernel: a jitted loop, or a plain one where compilation is switched off (NUMBA_DISABLE_JIT=1).
        arguments: as it will be called.
        functions: the laws inside, for the message.

    Raises:
        BadLaw: if it cannot be compiled; names the function and the line.
    """
    if not hasattr(kernel, "compile"):
        return
    try:
        kernel.compile(tuple(numba.typeof(argument) for argument in arguments))
    except NumbaError as error:
        raise BadLaw(_why(functions, error)) from None


def _why(functions: list[Any], error: Exception) -> str:
    """Which law does not compile, and at which line of the user's own file."""
    for function in functions:
        try:
            numba.njit(compilable(function)).compile((numba.float64,) * len(names_of(function)))
        except NumbaError as own:
            error, code = own, plain(function).__code__
            found = re.findall(r'File "([^"]+)", line (\d+)', str(own))
            place = (code.co_filename, code.co_firstlineno)
            if found:  # the innermost comes first, with a path from here
                place = (str(Path(found[0][0]).resolve()), found[0][1])
            return f"law '{function.__name__}' cannot be compiled: {place[0]}, line {place[1]}: {_essence(own)}"
    return f"the loop around {[f.__name__ for f in functions]} cannot be compiled: {_essence(error)}"


def _essence(error: Exception) -> str:
    """The sentence of a numba message that says what is wrong."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    telling = [
        line
        for line in lines
        if re.match(
            r"(Unknown|Untyped|No implementation|NameError|Use of|Invalid|Cannot|Can't|Undefined|Unsupported|name )",
            line,
        )
    ]
    return (telling or lines or ["unknown reason"])[
        0
    ] + " (laws may use numbers, math, numpy scalars, if/else and other plain functions)"


def flat(array: np.ndarray) -> np.ndarray:
    """The same memory as one row."""
    return array.reshape(-1)
