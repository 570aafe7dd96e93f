"""Loop: a function of a range of items, compiled for its arguments and called range by range, on all threads.

The function takes (begin, end, thread) and then its arguments, and returns a whole number. What a range computes must
not depend on the other ranges of the same call: then results do not depend on the threads.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache as cache_of_calls
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.core.errors import NumbaError
from numpy.typing import NDArray

from rbs_core import BadLaw
from rbs_plugins.loops import cache
from rbs_plugins.loops.arguments import names_of
from rbs_plugins.loops.source import compilable, definitions, plain

# A parallel region costs about 3 to 15 microseconds; with less to do (bonds, entries of arrays) one thread is faster.
SERIAL_BELOW = 20_000
# Relations on parts with fewer nodes are done together with others of their kind: calls would cost a tenth of the work.
BATCH_BELOW = 3_000
CHUNK = 4096  # entries of arrays in a range
_FIRST = ("begin", "end", "thread")


@dataclass(frozen=True)
class Text:
    """Source of a module.

    Attributes:
        body: definitions, in order.
        names: objects that the text cannot say (laws without source), or None; such a module is never kept on disk.
        laws: the functions of the user in it, for messages.
        tensors: names of their arguments that are 3 x 3 tuples, not numbers.
    """

    body: str
    names: dict[str, Any] | None = None
    laws: tuple[Any, ...] = ()
    tensors: tuple[str, ...] = ()

    @classmethod
    @cache_of_calls
    def of(cls, function: Any) -> Text:
        """The text of one of our own functions with its helpers, under its own name."""
        pieces = definitions({function.__name__: function})
        assert pieces is not None, f"{function.__name__} has no source that can stand alone"
        return cls("\n\n".join(pieces) + "\n")


class Loop:
    """A compiled function with its arguments and ranges; call it to run.

    Args:
        text: the module of the function.
        name: of the function.
        arguments: an array (C order) or a number for every parameter behind (begin, end, thread), by name.
        ranges: (k, 2) begin and end of each range, or the number of items, which are cut into ranges of CHUNK.
        work: bonds or entries that one call visits, to decide whether threads are worth it.

    Raises:
        BadLaw: if it cannot be compiled; names the law and the line.
    """

    def __init__(
        self, text: Text, name: str, arguments: dict[str, Any], ranges: NDArray[np.int64] | int, work: int | None = None
    ) -> None:
        if isinstance(ranges, int | np.integer):
            begins = np.arange(0, ranges, CHUNK)
            work = int(ranges) if work is None else work
            ranges = np.stack([begins, np.minimum(begins + CHUNK, ranges)], axis=1)
        assert work is not None
        self.tasks = np.zeros((len(ranges), 3), np.int64)
        self.tasks[:, 1:] = ranges
        self.work, self.laws = work, text.laws
        self._parameters = _parameters(text.body, name)
        self._held = [{key: arguments[key] for key in self._parameters}]
        self._fill()
        self._entry, self._function, self._keep = _compiled(text, name, self._held[0])

    def _fill(self) -> None:
        """Tables of addresses and numbers from what is held."""
        tables, numbers = [], []
        for held in self._held:
            table: list[int] = []
            row: list[float] = []
            for value in held.values():
                if isinstance(value, np.ndarray):
                    assert value.flags.c_contiguous
                    table += [value.ctypes.data, *value.shape]
                else:
                    row.append(float(value))
            tables.append(table or [0])
            numbers.append(row or [0.0])
        self._tables, self._numbers = np.array(tables, np.int64), np.array(numbers, np.float64)
        names = [key for key, value in self._held[0].items() if not isinstance(value, np.ndarray)]
        self._column = {key: column for column, key in enumerate(names)}
        sizes = [1 + value.ndim if isinstance(value, np.ndarray) else 0 for value in self._held[0].values()]
        self._place = dict(zip(self._held[0], np.cumsum([0, *sizes]).tolist(), strict=False))
        self._answers = np.zeros(len(self.tasks), np.int64)

    def set(self, **values: Any) -> None:
        """Exchanges numbers, or arrays for others of the same shape and type; names without use are ignored."""
        for name, value in values.items():
            if name in self._column:
                self._numbers[:, self._column[name]] = value
            elif name in self._parameters:
                (held,) = self._held
                assert (value.shape, value.dtype) == (held[name].shape, held[name].dtype)
                assert value.flags.c_contiguous
                held[name] = value
                self._tables[0, self._place[name]] = value.ctypes.data

    def _now(self, row: int) -> dict[str, Any]:
        """The arguments of a segment, with numbers as they are set now."""
        numbers = {name: type(self._held[row][name])(self._numbers[row, c]) for name, c in self._column.items()}
        return {**self._held[row], **numbers}

    def __call__(self, tasks: NDArray[np.int64] | None = None, *, alone: bool = False) -> NDArray[np.int64]:
        """Runs all ranges, or the given tasks (k, 3), on one thread if `alone`; what was answered for each."""
        tasks = self.tasks if tasks is None else tasks
        answers = self._answers[: len(tasks)]
        if self._entry is None:
            for number, (row, begin, end) in enumerate(tasks):
                answers[number] = self._function(int(begin), int(end), 0, *self._now(row).values())
            return answers
        from rbs_plugins.loops import drive

        several = not alone and len(tasks) > 1 and self.work >= SERIAL_BELOW and numba.get_num_threads() > 1
        (drive.parallel if several else drive.serial)(self._entry, self._tables, self._numbers, tasks, answers)
        return answers

    def merged(self, others: Sequence[Loop]) -> Loop:
        """One loop over the ranges of this and other loops of the same function."""
        every = [self, *others]
        result = object.__new__(Loop)
        result.__dict__.update(self.__dict__)
        result._held = [loop._now(row) for loop in every for row in range(len(loop._held))]
        result.work = sum(loop.work for loop in every)
        result.tasks = np.concatenate([loop.tasks + np.array([number, 0, 0]) for number, loop in enumerate(every)])
        result._keep = [loop._keep for loop in every]
        result._fill()
        return result

    @property
    def kind(self) -> Any:
        """Loops of the same kind can be merged."""
        return self._function if self._entry is None else self._entry


def _parameters(body: str, name: str) -> list[str]:
    """Names of the parameters of a function behind (begin, end, thread)."""
    found = re.search(rf"^def {name}\(([^)]*)\)", body, re.MULTILINE)
    assert found is not None, f"the text has no function {name}"
    names = [each.strip() for each in found.group(1).split(",")]
    assert tuple(names[:3]) == _FIRST, f"{name} must take {', '.join(_FIRST)} first"
    return names[3:]


_made: dict[Any, Any] = {}


def _compiled(text: Text, name: str, arguments: dict[str, Any]) -> tuple[int | None, Any, Any]:
    """Address of the compiled function (None if compilation is switched off), the function, what to keep alive."""
    if getattr(numba.config, "DISABLE_JIT", 0):
        module = cache.load(text.body, text.names)
        return None, getattr(module, name), module
    kinds = tuple((str(a.dtype), a.ndim) if isinstance(a, np.ndarray) else type(a) for a in arguments.values())
    key = (text.body, name, kinds, cache.folder())
    if text.names is not None or key not in _made:
        try:
            module = cache.load(_with_entry(text.body, name, arguments), text.names)
        except NumbaError as error:
            raise BadLaw(_why(list(text.laws), error, text.tensors)) from None
        if text.names is not None:
            return module.entry.address, None, module
        _made[key] = module
    return _made[key].entry.address, None, _made[key]


def _with_entry(body: str, name: str, arguments: dict[str, Any]) -> str:
    """The text with one signature for all in place of the function: arrays from addresses, numbers from a row.

    The function itself becomes the entry, so that the compiler sees it once.
    """
    kinds = sorted({f"at_{value.dtype}" for value in arguments.values() if isinstance(value, np.ndarray)})
    lines, place, column = [], 0, 0
    for key, value in arguments.items():
        if isinstance(value, np.ndarray):
            shape = ", ".join(f"_t[{place + 1 + axis}]" for axis in range(value.ndim))
            lines.append(f"    {key} = carray(at_{value.dtype}(_t[{place}]), ({shape},))")
            place += 1 + value.ndim
        else:
            kind = "float32" if isinstance(value, np.float32) else "int64" if isinstance(value, int) else ""
            lines.append(f"    {key} = {kind}(_p[{column}])")
            column += 1
    head = rf"^@njit\(([^\n]*)\)\ndef {name}\([^)]*\):\n"
    found = re.search(head, body, re.MULTILINE)
    assert found is not None
    options = re.sub(r", (forceinline|no_cpython_wrapper|no_cfunc_wrapper)=True", "", found.group(1))
    entry = "\n".join([
        "from numba import carray, cfunc, float32, int64",
        f"from rbs_plugins.loops.drive import {', '.join(['SIGNATURE', *kinds])}", "",
        f"@cfunc(SIGNATURE, {options}, cache=CACHE)", "def entry(table, numbers, begin, end, thread):",
        f"    _t, _p = carray(table, ({max(place, 1)},)), carray(numbers, ({max(column, 1)},))", *lines, "",
    ])  # fmt: skip
    return body[: found.start()] + entry + body[found.end() :]


def _why(functions: list[Any], error: Exception, tensors: Sequence[str] = ()) -> str:
    """Which law does not compile, and at which line of the user's own file."""
    tensor = numba.types.UniTuple(numba.types.UniTuple(numba.float64, 3), 3)
    for function in functions:
        try:
            kinds = (tensor if name in tensors else numba.float64 for name in names_of(function))
            numba.njit(compilable(function)).compile(tuple(kinds))
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
