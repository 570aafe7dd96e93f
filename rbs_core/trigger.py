"""When a relation runs: triggers are values that answer yes or no to a clock and combine with & | ~."""

from __future__ import annotations

import math
import time as _time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from rbs_core.errors import BadInput

# Times that differ by round-off are the same: at(k * dt) means step k, however the product was rounded.
SLACK = 1e-12


@dataclass
class Clock:
    """Where a run is.

    Attributes:
        dt: time step, s.
        step: number of the current step; the first step of a run is 1, 0 is the state before it.
        time: time at the end of the current step, s; always step * dt, so a resumed run has the same times.
        last_step: number of the last planned step.
    """

    dt: float
    step: int = 0
    time: float = 0.0
    last_step: int = 0

    def advance(self) -> None:
        """Goes to the next step."""
        self.step += 1
        self.time = self.step * self.dt

    def end(self) -> None:
        """Makes this step the last one: for a relation that has nothing left to do."""
        self.last_step = self.step


def last_step(steps: int | None, until: float | None, dt: float) -> int:
    """Number of the last step of a run: so many steps, or the first that ends at or after a time, s; the earlier one.

    Raises:
        BadInput: if neither is given, or one is negative or no number.
    """
    ends = []
    if steps is not None:
        if not math.isfinite(steps) or steps != int(steps) or steps < 0:
            raise BadInput(f"steps={steps} must be a whole number, not negative")
        ends.append(int(steps))
    if until is not None:
        if not (math.isfinite(until) and until >= 0):
            raise BadInput(f"until={until} must be a time in s, not negative")
        ends.append(math.ceil(until / dt * (1 - 1e-12)))
    if not ends:
        raise BadInput("say how long to run: steps=... or until=...")
    return min(ends)


class Trigger:
    """A named yes-or-no function of the clock."""

    def __init__(self, decide: Callable[[Clock], bool], text: str, *, keeps_state: bool = False) -> None:
        self._decide = decide
        self._text = text
        self._key: object = object() if keeps_state else text  # two clocks of one text still tick on their own

    def __call__(self, clock: Clock) -> bool:
        return self._decide(clock)

    def __and__(self, other: Trigger) -> Trigger:
        if not isinstance(other, Trigger):
            return NotImplemented
        return Trigger(lambda clock: self(clock) and other(clock), f"({self} & {other})")

    def __or__(self, other: Trigger) -> Trigger:
        if not isinstance(other, Trigger):
            return NotImplemented
        return Trigger(lambda clock: self(clock) or other(clock), f"({self} | {other})")

    def __invert__(self) -> Trigger:
        return Trigger(lambda clock: not self(clock), f"~{self}")

    def __repr__(self) -> str:
        return self._text

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Trigger) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)


always = Trigger(lambda clock: True, "always")
once = Trigger(lambda clock: clock.step == 1, "once")
last = Trigger(lambda clock: clock.step == clock.last_step, "last")


def every(steps: int, start: int = 0) -> Trigger:
    """Every `steps` steps, counted from step `start`.

    Raises:
        BadInput: if `steps` is not a positive whole number.
    """
    if steps != int(steps) or steps < 1:
        raise BadInput(f"every({steps}): the number of steps must be a whole number of at least 1")
    text = f"every({steps})" if start == 0 else f"every({steps}, start={start})"
    return Trigger(lambda clock: clock.step >= start and (clock.step - start) % steps == 0, text)


def at(times: float | Iterable[float]) -> Trigger:
    """At given times in s: in the first step that ends at or after each of them."""
    moments = [float(times)] if isinstance(times, (int, float)) else [float(t) for t in times]
    if any(not math.isfinite(t) or t < 0.0 for t in moments):
        raise BadInput(f"at({moments}): times must be finite and not negative")

    def reached(clock: Clock) -> bool:
        now, before = clock.time * (1 + SLACK), (clock.step - 1) * clock.dt * (1 + SLACK)
        return clock.step > 0 and any(before < t <= now or (t == 0.0 and clock.step == 1) for t in moments)

    return Trigger(reached, f"at({moments})")


def between(start: float, end: float) -> Trigger:
    """While start <= time <= end, in s."""
    if not start <= end:
        raise BadInput(f"between({start}, {end}): the start must not be after the end")
    return Trigger(lambda clock: start * (1 - SLACK) <= clock.time <= end * (1 + SLACK), f"between({start}, {end})")


def realtime(seconds: float) -> Trigger:
    """At most once in so many seconds of wall time, e.g. for checkpoints; in one step it says the same to everybody."""
    if not seconds > 0:
        raise BadInput(f"realtime({seconds}): the seconds must be positive")
    previous = _time.monotonic()
    asked, answer = -1, False

    def due(clock: Clock) -> bool:
        nonlocal previous, asked, answer
        if clock.step != asked:
            now = _time.monotonic()
            asked, answer = clock.step, now - previous >= seconds
            previous = now if answer else previous
        return answer

    return Trigger(due, f"realtime({seconds})", keeps_state=True)
