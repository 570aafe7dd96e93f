"""Inverse square roots: by the instructions of the machine, or by Newton's iteration where that is faster.

A bond needs the inverse of its length. Processors of Intel take 17 to 20 cycles for four square roots and quotients in
double precision, whatever the width of their vectors, but multiply and add eight numbers at once, twice in a cycle. So
there 1/sqrt(x) starts from a guess that is good to 3.5 % (half of the exponent, by shifting the bits of x) and is
refined by multiplications alone: a step whose constant is fitted to that guess, one of second order and one of third
order (errors of 9e-4, 1e-6 and the last digit of double precision). Which way is taken depends on the kind of processor
alone, so that runs on one machine are the same to the bit.
"""

from __future__ import annotations

import os
from typing import Any

import numba
from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from rbs_core import BadInput
from rbs_plugins.loops.machine import processor

WAYS = ("hardware", "newton")
_GUESS = {64: 0x5FE6EB50C7B537A9, 32: 0x5F375A86}  # minimax over a period of the exponent (Lomont 2003)
_REAL = {types.float64: (ir.DoubleType(), 64), types.float32: (ir.FloatType(), 32)}


def way(real: str) -> str:
    """One of WAYS, by the processor and the type of numbers; RBS_ROOTS chooses one of them.

    In single precision the instructions are as fast as the multiplications.

    Raises:
        BadInput: if RBS_ROOTS is neither.
    """
    chosen = os.environ.get("RBS_ROOTS", "")
    if chosen not in ("", *WAYS):
        raise BadInput(f"RBS_ROOTS={chosen!r} must be one of {', '.join(WAYS)}")
    if getattr(numba.config, "DISABLE_JIT", 0):
        return "hardware"  # plain Python has no bits to shift
    return chosen or ("newton" if processor() == "intel512" and real == "float64" else "hardware")


def _kind(number: Any) -> Any:
    return number if number in _REAL else None


@intrinsic
def root_guess(context: Any, x: Any) -> Any:
    """1 / sqrt(x) to 3.5 %, for positive x."""
    if _kind(x) is None:
        return None
    kind, bits = _REAL[x]

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        whole = ir.IntType(bits)
        half = builder.lshr(builder.bitcast(arguments[0], whole), whole(1))
        return builder.bitcast(builder.sub(whole(_GUESS[bits]), half), kind)

    return x(x), code


def fused(a: float, b: float, c: float) -> float:
    """A * b + c, in compiled loops rounded once where the machine can do that: in vectors as in single numbers."""
    return a * b + c


@intrinsic
def _fused(context: Any, a: Any, b: Any, c: Any) -> Any:
    if _kind(a) is None or not a == b == c:
        return None
    kind, _ = _REAL[a]

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        type_ = ir.FunctionType(kind, [kind] * 3)
        return builder.call(builder.module.declare_intrinsic("llvm.fmuladd", [kind], type_), arguments)

    return a(a, a, a), code


@overload(fused, jit_options={"forceinline": True})
def _(a, b, c):  # numba compares this signature with that of the answer
    return lambda a, b, c: _fused(a, b, c)  # type: ignore[call-arg]  # an intrinsic is called without its context


def text(inverse_root: str, square: str) -> list[str]:
    """Lines that set `inverse_root` to 1 / sqrt(square) by Newton's iteration; `square` is a name."""
    r = inverse_root
    return [
        f"half_square = REAL(0.5) * {square}",
        f"{r} = root_guess({square})",
        f"{r} = {r} * fused(-(half_square * {r}), {r}, REAL(1.5008909))",
        f"{r} = {r} * fused(-(half_square * {r}), {r}, REAL(1.5))",
        f"rest = fused(-(half_square * {r}), {r}, REAL(0.5))",
        f"{r} = fused({r} * rest, fused(REAL(1.5), rest, REAL(1.0)), {r})",
    ]
