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

import numba

from rbs_core import BadInput
from rbs_plugins.loops.machine import processor

WAYS = ("hardware", "newton")


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
