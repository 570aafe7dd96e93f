"""The one parallel loop: it hands tasks to threads and calls, for each, a compiled function by its address.

A task is a range of one segment; a segment is what one relation gives a loop: a row of addresses and sizes of arrays
and a row of numbers. So loops themselves are compiled without threads, each in a fraction of the time, and many small
parts run in one parallel region.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import njit, prange, types
from numba.extending import intrinsic
from numba.np.ufunc.parallel import get_thread_id

# What every compiled loop looks like from outside: table, numbers, begin, end, thread -> answer.
SIGNATURE = types.int64(
    types.CPointer(types.int64), types.CPointer(types.float64), types.int64, types.int64, types.int64
)
_LONG, _REAL = ir.IntType(64), ir.DoubleType()


@intrinsic
def _call(context: Any, entry: Any, table: Any, numbers: Any, begin: Any, end: Any, thread: Any) -> Any:
    """Calls the function at an address."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = ir.FunctionType(_LONG, [_LONG.as_pointer(), _REAL.as_pointer(), _LONG, _LONG, _LONG])
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        rows = [builder.inttoptr(a, t.as_pointer()) for a, t in zip(arguments[1:3], (_LONG, _REAL), strict=True)]
        return builder.call(function, [*rows, *arguments[3:]])

    return types.int64(*(types.int64,) * 6), code


call: Any = _call  # an intrinsic is called without its first argument


def _pointer(kind: Any) -> Any:
    @intrinsic
    def pointer(context: Any, address: Any) -> Any:
        """An address as pointer to numbers of one type."""

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))

        return types.CPointer(kind)(types.int64), code

    return pointer


at_float64, at_float32 = _pointer(types.float64), _pointer(types.float32)
at_int64, at_int32 = _pointer(types.int64), _pointer(types.int32)
at_uint64, at_uint32, at_uint16, at_uint8 = (_pointer(getattr(types, f"uint{bits}")) for bits in (64, 32, 16, 8))


@njit(parallel=True, cache=True, error_model="numpy")
def parallel(entry: int, tables: Any, numbers: Any, tasks: Any, answers: Any) -> None:
    """Runs tasks (k, 3) of segment, begin, end; answers (k,)."""
    first_table, first_number = tables.ctypes.data, numbers.ctypes.data
    table_bytes, number_bytes = tables.shape[1] * 8, numbers.shape[1] * 8
    for t in prange(tasks.shape[0]):
        row = tasks[t, 0]
        table, number = first_table + row * table_bytes, first_number + row * number_bytes
        answers[t] = call(entry, table, number, tasks[t, 1], tasks[t, 2], get_thread_id())


@njit(cache=True, error_model="numpy")
def serial(entry: int, tables: Any, numbers: Any, tasks: Any, answers: Any) -> None:
    """The same on the calling thread."""
    first_table, first_number = tables.ctypes.data, numbers.ctypes.data
    table_bytes, number_bytes = tables.shape[1] * 8, numbers.shape[1] * 8
    for t in range(tasks.shape[0]):
        row = tasks[t, 0]
        table, number = first_table + row * table_bytes, first_number + row * number_bytes
        answers[t] = call(entry, table, number, tasks[t, 1], tasks[t, 2], 0)
