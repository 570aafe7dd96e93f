"""Functions for laws: exp, log, pow and tanh that vectorise, as those of `math` and `numpy` do not.

    from rbs_plugins.functions import exp

    def law(stretch, c, s_char):
        return c * s_char * (1.0 - exp(-stretch / s_char))

They are called like those of `math`, with numbers. In compiled loops they are polynomials without branches and calls,
so that several bonds are computed at once, in double precision also in parts of single precision. Relative errors are
below 1e-12 where the result is a normal number; smaller ones become zero. Where `math` raises, they answer infinity or
NaN.

Reduction to a small range as in Cody & Waite (1980), then the series of the exponential and of the inverse hyperbolic
tangent.
"""

from __future__ import annotations

import math
from typing import Any

from numba import float32, float64, njit
from numba.extending import overload

from rbs_plugins.loops.bits import LIFTED, STEADY, exponent, fused, mantissa, scaled

__all__ = ["exp", "log", "pow", "tanh"]

_INLINED = {"forceinline": True, "error_model": "numpy", "fastmath": False}
_PER_LN2 = 1.4426950408889634
_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10  # n * high is exact
_EXP_LARGEST, _EXP_SMALLEST = 709.782712893384, -708.3964185322641
_SMALLEST = 2.2250738585072014e-308  # normal number
_TANH_IS_ONE = 20.0  # to the last digit, from here on


def exp(x: float) -> float:
    """e**x."""
    try:
        return 0.0 if x < _EXP_SMALLEST else math.exp(x)
    except OverflowError:
        return math.inf


def log(x: float) -> float:
    """Natural logarithm; -infinity at zero, NaN below."""
    if x < _SMALLEST:
        return math.nan if x < 0 else -math.inf
    return math.log(x)


def pow(x: float, y: float) -> float:
    """x**y for x that is not negative; NaN for one that is."""
    if y == 0.0:
        return 1.0
    return exp(y * log(x)) if x >= 0 else math.nan


def tanh(x: float) -> float:
    """Hyperbolic tangent."""
    return math.tanh(x)


# -- compiled ------------------------------------------------------------------------------------------------------


@njit(**_INLINED)
def _reduced(x):
    """(r, n + STEADY) with x = r + n ln 2 and |r| <= ln 2 / 2."""
    place = fused(x, _PER_LN2, STEADY)
    n = place - STEADY
    return fused(n, -_LN2_LOW, fused(n, -_LN2_HIGH, x)), place


@njit(**_INLINED)
def _minus_one(r):
    """e**r - 1 for |r| <= ln 2 / 2: series to r**13, the next term is below 1e-17."""
    y = fused(1.605904383682161459e-10, r, 2.087675698786809898e-09)
    y = fused(y, r, 2.505210838544171878e-08)
    y = fused(y, r, 2.755731922398589065e-07)
    y = fused(y, r, 2.755731922398589065e-06)
    y = fused(y, r, 2.480158730158730159e-05)
    y = fused(y, r, 1.984126984126984127e-04)
    y = fused(y, r, 1.388888888888888889e-03)
    y = fused(y, r, 8.333333333333333333e-03)
    y = fused(y, r, 4.166666666666666667e-02)
    y = fused(y, r, 1.666666666666666667e-01)
    y = fused(y, r, 0.5)
    return fused(y, r * r, r)


@njit(**_INLINED)
def _exp(x):
    r, place = _reduced(x)
    y = scaled(1.0 + _minus_one(r), place)
    y = math.inf if x > _EXP_LARGEST else y
    y = 0.0 if x < _EXP_SMALLEST else y
    return x if x != x else y


@njit(**_INLINED)
def _log(x):
    m = mantissa(x) - 1.0
    s = m / (m + 2.0)
    z = s * s
    y = fused(1 / 19, z, 1 / 17)  # 2 artanh(s), to s**19: the next term is below 1e-16 of the sum
    y = fused(y, z, 1 / 15)
    y = fused(y, z, 1 / 13)
    y = fused(y, z, 1 / 11)
    y = fused(y, z, 1 / 9)
    y = fused(y, z, 1 / 7)
    y = fused(y, z, 1 / 5)
    y = fused(y, z, 1 / 3)
    n = exponent(x) - LIFTED
    y = fused(n, _LN2_HIGH, fused(n, _LN2_LOW, 2.0 * fused(y, z * s, s)))
    y = -math.inf if x < _SMALLEST else y
    y = math.nan if x < 0.0 else y
    return x if not x < math.inf else y


@njit(**_INLINED)
def _pow(x, y):
    power = _exp(y * _log(x))
    return 1.0 if y == 0.0 else power


@njit(**_INLINED)
def _tanh(x):
    twice = 2.0 * min(abs(x), _TANH_IS_ONE)
    r, place = _reduced(twice)
    one = scaled(1.0, place)
    grown = fused(one, _minus_one(r), one - 1.0)  # e**(2|x|) - 1, good for small x, too
    y = math.copysign(grown / (grown + 2.0), x)
    return x if x != x else y


def _compiled(function: Any, compiled: Any) -> None:
    """Says what compiled code takes in place of a function; numbers of single precision come back as such."""

    @overload(function, jit_options=_INLINED)
    def one(x):
        if x == float32:
            return lambda x: float32(compiled(float64(x)))
        return lambda x: compiled(float64(x))

    assert one


for _function, _made in ((exp, _exp), (log, _log), (tanh, _tanh)):
    _compiled(_function, _made)


@overload(pow, jit_options=_INLINED)
def _(x, y):
    if x == y == float32:
        return lambda x, y: float32(_pow(float64(x), float64(y)))
    return lambda x, y: _pow(float64(x), float64(y))
