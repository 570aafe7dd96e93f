"""Numbers as text: what Python's %g writes, but for ties."""

from __future__ import annotations

import io
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rbs_plugins.exporters import digits as module
from rbs_plugins.exporters.digits import LOWEST, RowWriter, write_number

POWERS = np.array([float(f"1e{exponent}") for exponent in range(LOWEST, 309)])


def text_of(value, digits):
    """The number by the plain function."""
    out = bytearray(digits + 8)
    end = write_number(out, 0, value, digits, LOWEST, POWERS)
    return out[:end].decode()


def right(text, value, digits):
    """As %g writes it, or the neighbor where the number lies in the middle between two to round-off."""
    if text == f"{value:.{digits}g}":
        return True
    unit = 10.0 ** (math.floor(math.log10(abs(value))) - digits + 1)
    return abs(abs(float(text) - value) - 0.5 * unit) <= 1e-2 * unit and len(text) <= digits + 7


@given(
    st.floats(allow_nan=False, allow_infinity=False).filter(lambda x: x == 0.0 or abs(x) >= 1e-290),
    st.integers(1, 13),
)
def test_any_number(value, digits):
    found = text_of(value, digits)
    assert right(found, value + 0.0, digits), (found, f"{value:.{digits}g}")


@pytest.mark.parametrize("digits", [1, 3, 9, 15])
@pytest.mark.parametrize("exponent", [-289, -101, -100, -99, -5, -4, -1, 0, 1, 2, 8, 9, 14, 15, 22, 99, 100, 300])
def test_powers_of_ten_and_their_neighbors(exponent, digits):
    power = float(f"1e{exponent}")
    assert text_of(power, digits) == f"{power:.{digits}g}"
    for value in (np.nextafter(power, 0), np.nextafter(power, np.inf), 9.999999999999998 * power):
        assert text_of(float(value), digits) == f"{value:.{min(digits, 15)}g}"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (1e-300, "0"),
        (-1.5, "-1.5"),
        (0.0001, "0.0001"),
        (1e-5, "1e-05"),
        (123456789.0, "123456789"),
        (1234567890.0, "1.23456789e+09"),
        (-2e-123, "-2e-123"),
        (1e22, "1e+22"),
        (100.0, "100"),
        (0.1, "0.1"),
    ],
)
def test_by_hand(value, text):
    assert text_of(value, 9) == text


def test_the_last_digit_of_fifteen_is_off_by_one_at_most(rng):
    for value in rng.normal(size=300) * 10.0 ** rng.integers(-30, 30, 300):
        unit = 10.0 ** (math.floor(math.log10(abs(value))) - 14)
        assert abs(float(text_of(value, 15)) - value) <= 1.01 * unit


@pytest.mark.parametrize("rows", [1, 8, 9, 25])
def test_rows_of_several_arrays_in_blocks(rows, rng, monkeypatch):
    monkeypatch.setattr(module, "ROWS", 8)
    arrays = [rng.normal(size=rows), rng.normal(size=(rows, 3)), rng.integers(0, 255, rows).astype(np.uint8)]
    file = io.BytesIO()
    RowWriter(5, 9).write(file, arrays)
    lines = file.getvalue().decode().split("\n")
    assert lines.pop() == ""
    wanted = np.column_stack(arrays)
    assert lines == [" ".join(f"{value:.9g}" for value in row) for row in wanted]


def test_many_rows_on_all_threads_are_the_rows_one_by_one(rng):
    values = rng.normal(size=(70_000, 2)) * 1e-6
    file = io.BytesIO()
    RowWriter(2, 9).write(file, [values])
    assert file.getvalue().decode() == "".join(f"{x:.9g} {y:.9g}\n" for x, y in values.tolist())
