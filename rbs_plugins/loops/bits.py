"""Arithmetic with the bits of real numbers, for loops that LLVM shall vectorise: no calls, no branches."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

_KINDS = {types.float64: (ir.DoubleType(), ir.IntType(64)), types.float32: (ir.FloatType(), ir.IntType(32))}
_WHOLE = ir.IntType(64)
_MANTISSA = 52  # bits of it in double precision
_ROOT_HALF = 0x3FE6A09E667F3BCD  # sqrt(1/2)
# Near this number doubles are the whole numbers: the last bits of x + STEADY are those of x, rounded.
STEADY = 1.5 * 2.0**52
# What `exponent` adds to its answer, which it makes from bits alone.
LIFTED = 2.0**52 + 1023.0
# For the square root: minimax over a period of the exponent (Lomont 2003).
_GUESSES = {types.float64: 0x5FE6EB50C7B537A9, types.float32: 0x5F375A86}


@intrinsic
def root_guess(context: Any, x: Any) -> Any:
    """1 / sqrt(x) to 3.5 %, for positive x."""
    if x not in _KINDS:
        return None
    kind, whole = _KINDS[x]

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        half = builder.lshr(builder.bitcast(arguments[0], whole), whole(1))
        return builder.bitcast(builder.sub(whole(_GUESSES[x]), half), kind)

    return x(x), code


@intrinsic
def scaled(context: Any, x: Any, steady: Any) -> Any:
    """X * 2**n, where steady = n + STEADY."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        bits, place = (builder.bitcast(each, _WHOLE) for each in arguments)
        return builder.bitcast(builder.add(bits, builder.shl(place, _WHOLE(_MANTISSA))), ir.DoubleType())

    return types.float64(types.float64, types.float64), code


def _above_root_half(builder: Any, x: Any) -> Any:
    return builder.sub(builder.bitcast(x, _WHOLE), _WHOLE(_ROOT_HALF))


@intrinsic
def mantissa(context: Any, x: Any) -> Any:
    """X / 2**n in [sqrt(1/2), sqrt(2)), for positive x."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        rest = builder.and_(_above_root_half(builder, arguments[0]), _WHOLE((1 << _MANTISSA) - 1))
        return builder.bitcast(builder.add(rest, _WHOLE(_ROOT_HALF)), ir.DoubleType())

    return types.float64(types.float64), code


@intrinsic
def exponent(context: Any, x: Any) -> Any:
    """N + LIFTED, where x / 2**n lies in [sqrt(1/2), sqrt(2)), for positive x."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        biased = builder.add(_above_root_half(builder, arguments[0]), _WHOLE(1023 << _MANTISSA))
        number = builder.lshr(biased, _WHOLE(_MANTISSA))
        return builder.bitcast(builder.or_(number, _WHOLE((1023 + _MANTISSA) << _MANTISSA)), ir.DoubleType())

    return types.float64(types.float64), code


def fused(a: float, b: float, c: float) -> float:
    """A * b + c, in compiled loops rounded once where the machine can do that: in vectors as in single numbers."""
    return a * b + c


@intrinsic
def _fused(context: Any, a: Any, b: Any, c: Any) -> Any:
    if a not in _KINDS or not a == b == c:
        return None
    kind, _ = _KINDS[a]

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        type_ = ir.FunctionType(kind, [kind] * 3)
        return builder.call(builder.module.declare_intrinsic("llvm.fmuladd", [kind], type_), arguments)

    return a(a, a, a), code


@overload(fused, jit_options={"forceinline": True})
def _(a, b, c):  # numba compares this signature with that of the answer
    return lambda a, b, c: _fused(a, b, c)
