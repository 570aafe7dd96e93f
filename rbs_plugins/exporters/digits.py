"""Numbers as text, fast: a compiled loop writes rows of numbers with so many significant digits, as `%g` does it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from rbs_plugins.loops import Loop, Text

ROWS = 32768  # of a block: what is held beside the numbers is small, and there is work for several threads
MOST_DIGITS = 15
LOWEST = -320  # powers of ten in the table begin here


def write_rows(begin, end, thread, columns, out, width, digits, lowest, powers):
    """Writes rows of numbers into the bytes that belong to a range; answers how many they are."""
    start = begin * width
    at = start
    for i in range(begin, end):
        for k in range(columns.shape[1]):
            at = write_number(out, at, columns[i, k], digits, lowest, powers)
            out[at] = 32  # blank
            at += 1
        out[at - 1] = 10  # end of the line
    return at - start


def write_number(out, at, value, digits, lowest, powers):
    """Writes a finite number from a place on; returns the place behind it.

    The digits are those of value times a power of ten, rounded to a whole number. With 15 of them the last may be off
    by one, with fewer that happens where the next digits are as near to 5 as round-off.
    """
    if value < 0.0:
        out[at] = 45  # -
        at += 1
        value = -value
    if value < 1e-290:  # nothing that is measured in any unit
        out[at] = 48  # 0
        return at + 1
    exponent = math.floor(math.log10(value))
    if exponent < -250:  # the power that is wanted is no double
        value, shift = value * 1e100, 100
    else:
        shift = 0
    place = digits - 1 - shift - lowest
    least = powers[digits - 1 - lowest]
    scaled = value * powers[place - exponent]
    if scaled < least - 0.5:  # the logarithm was rounded up
        exponent -= 1
        scaled = value * powers[place - exponent]
    whole = int(scaled + 0.5)
    if whole >= 10 * int(least):
        whole //= 10
        exponent += 1
    count = digits
    while count > 1 and whole % 10 == 0:
        whole //= 10
        count -= 1
    if -5 < exponent < 0:  # 0.00ddd
        for k in range(1 - exponent):
            out[at + k] = 48
        out[at + 1] = 46  # .
        return put_digits(out, at + 1 - exponent, whole, count, count)
    if 0 <= exponent < digits:  # ddd.ddd or ddd000
        at = put_digits(out, at, whole, count, exponent + 1)
        for _ in range(exponent + 1 - count):
            out[at] = 48
            at += 1
        return at
    at = put_digits(out, at, whole, count, 1)
    out[at] = 101  # e
    out[at + 1] = 45 if exponent < 0 else 43
    size = abs(exponent)
    return put_digits(out, at + 2, size, 3 if size > 99 else 2, 3)


def put_digits(out, at, whole, count, before):
    """Writes so many digits of a whole number, with a point behind the first ones; returns the place behind."""
    point = 1 if count > before else 0
    if point:
        out[at + before] = 46
    for k in range(count - 1, -1, -1):
        out[at + k + (point if k >= before else 0)] = 48 + whole % 10
        whole //= 10
    return at + count + point


class RowWriter:
    """Writes rows of numbers to files, with blanks between them.

    Args:
        columns: how many numbers a row has.
        digits: significant digits, 1 to 15.
    """

    def __init__(self, columns: int, digits: int) -> None:
        self._width = columns * (digits + 8)  # sign, point, e, sign, three digits, blank
        self._columns = np.zeros((ROWS, columns))
        self._out = np.zeros(ROWS * self._width, np.uint8)
        powers = np.array([float(f"1e{exponent}") for exponent in range(LOWEST, 309)])
        arguments = {
            "columns": self._columns, "out": self._out, "width": self._width, "digits": digits, "lowest": LOWEST,
            "powers": powers,
        }  # fmt: skip
        self._loop = Loop(Text.of(write_rows), "write_rows", arguments, ROWS, ROWS * columns)

    def write(self, file: IO[bytes], arrays: Sequence[NDArray[Any]]) -> None:
        """Writes arrays (n,) or (n, k) side by side."""
        for first in range(0, len(arrays[0]), ROWS):
            count, column = min(ROWS, len(arrays[0]) - first), 0
            for array in arrays:
                block = array[first : first + count].reshape(count, -1)
                self._columns[:count, column : column + block.shape[1]] = block
                column += block.shape[1]
            tasks = self._loop.tasks[self._loop.tasks[:, 1] < count].copy()
            tasks[:, 2] = np.minimum(tasks[:, 2], count)
            for (_, begin, _), length in zip(tasks, self._loop(tasks), strict=True):
                place = begin * self._width
                file.write(self._out[place : place + length].data)
