"""Triggers: in which steps they say yes."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rbs_core import BadInput, Clock, always, at, between, every, last, once, realtime, trigger
from rbs_core.trigger import Trigger


def fired(when: Trigger, steps: int = 10, dt: float = 0.1) -> list[int]:
    """Numbers of the steps in which a trigger says yes."""
    clock = Clock(dt=dt, last_step=steps)
    found = []
    for _ in range(steps):
        clock.advance()
        if when(clock):
            found.append(clock.step)
    return found


def test_the_clock_multiplies_and_never_accumulates():
    clock = Clock(dt=0.1)
    for _ in range(1000):
        clock.advance()
    assert clock.step == 1000
    assert clock.time == 1000 * 0.1  # a sum of 1000 steps would be off by 1e-12: a resumed run would have other times


def test_named_triggers():
    assert fired(always, 4) == [1, 2, 3, 4]
    assert fired(once, 4) == [1]
    assert fired(last, 4) == [4]


@pytest.mark.parametrize(
    ("when", "expected"),
    [
        (every(1), [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]),
        (every(3), [3, 6, 9]),
        (every(3, start=2), [2, 5, 8]),
        (every(3, start=5), [5, 8]),
        (every(20), []),
    ],
)
def test_every(when, expected):
    assert fired(when) == expected


@pytest.mark.parametrize("steps", [0, -1, 2.5])
def test_every_needs_a_whole_number(steps):
    with pytest.raises(BadInput, match=rf"every\({steps}\): the number of steps must be a whole number of at least 1"):
        every(steps)


@given(st.integers(1, 10**6), st.floats(1e-12, 1e3))
def test_at_a_multiple_of_dt_means_that_step(step, dt):
    """However the product was rounded; tested one step before and behind, where a wrong slack would show."""
    when = at(step * dt)
    around = [Clock(dt, k, k * dt) for k in (step - 1, step, step + 1)]
    assert [when(clock) for clock in around] == [False, True, False]


def test_at_between_two_steps_means_the_first_that_reaches_it():
    assert fired(at([0.25, 0.61])) == [3, 7]
    assert fired(at([0.21, 0.25])) == [3]
    assert fired(at(0.0)) == [1]
    assert fired(at(5.0)) == []


@pytest.mark.parametrize("times", [math.nan, math.inf, -1.0, [0.1, math.nan]])
def test_at_needs_times_that_can_be_reached(times):
    with pytest.raises(BadInput, match="times must be finite and not negative"):
        at(times)


def test_between_has_both_ends_and_forgives_rounding():
    assert 3 * 0.1 > 0.3  # the rounding in question
    assert fired(between(0.1, 0.3)) == [1, 2, 3]
    assert fired(between(0.3, 0.5)) == [3, 4, 5]
    assert fired(between(0.25, 0.25)) == []


@pytest.mark.parametrize(("start", "end"), [(2.0, 1.0), (math.nan, 1.0), (0.0, math.nan)])
def test_between_needs_an_interval(start, end):
    with pytest.raises(BadInput, match="the start must not be after the end"):
        between(start, end)


def test_realtime_fires_at_most_once_in_so_many_seconds(monkeypatch):
    now = 100.0
    monkeypatch.setattr(trigger._time, "monotonic", lambda: now)
    when = realtime(5.0)
    seconds = {1: 101.0, 2: 104.9, 3: 105.0, 4: 109.0, 5: 110.5, 6: 111.0}
    found = []
    for step, now in seconds.items():  # noqa: B007  the clock above reads it
        if when(Clock(0.1, step)):
            found.append(step)
    assert found == [3, 5]


def test_realtime_says_the_same_to_everybody_in_a_step(monkeypatch):
    """A measure and the exporter behind it share a trigger: the first question must not use the answer up."""
    now = 0.0
    monkeypatch.setattr(trigger._time, "monotonic", lambda: now)
    when = realtime(5.0)
    now = 6.0
    assert [when(Clock(0.1, 1)), when(Clock(0.1, 1)), when(Clock(0.1, 2))] == [True, True, False]


@pytest.mark.parametrize("seconds", [0, -1.0, math.nan])
def test_realtime_needs_positive_seconds(seconds):
    with pytest.raises(BadInput, match="the seconds must be positive"):
        realtime(seconds)


def test_combinations():
    assert fired(every(2) & every(3), 12) == [6, 12]
    assert fired(every(4) | once, 8) == [1, 4, 8]
    assert fired(~every(2), 5) == [1, 3, 5]
    assert fired(every(2) & ~(between(0.3, 0.7) | last)) == [2, 8]


@pytest.mark.parametrize("other", [5, True, None, lambda clock: True])
def test_only_triggers_combine(other):
    for combine in (lambda: every(2) & other, lambda: every(2) | other):
        with pytest.raises(TypeError, match="unsupported operand"):
            combine()


def test_triggers_are_values():
    assert every(25) == every(25)
    assert hash(every(25)) == hash(every(25))
    assert every(25) != every(26)
    assert every(25) != every(25, start=5)
    assert every(25) != 25
    assert (every(2) & once) == (every(2) & once)
    assert (every(2) & once) != (every(2) | once)


def test_repr_is_what_was_typed():
    assert repr(every(25)) == "every(25)"
    assert repr(every(25, start=5)) == "every(25, start=5)"
    assert repr(at(1e-6)) == "at([1e-06])"
    assert repr(~every(2) & between(0.0, 1.0) | last) == "((~every(2) & between(0.0, 1.0)) | last)"
    assert repr(realtime(600)) == "realtime(600)"
