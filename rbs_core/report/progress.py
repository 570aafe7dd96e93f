"""How far a run is, and what it will cost: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
import time
from typing import Any

from rbs_core.memory import as_text
from rbs_core.report.levels import FILE_ONLY, PROCESS, log, shown

LONG = 60.0  # s from which on a run is announced
LEARNT = 2.0  # s of steps after which it is known how long one takes


class Progress:
    """A bar with the time left on a terminal, a plain line every ten seconds elsewhere, nothing when switched off.

    Once it is known how long a step takes, a run of more than a minute says what it needs.

    Args:
        title: of the run.
        first: number of the last step that is done already.
        last: number of the step to end with.
        mode: False for neither bar nor lines.
        nbytes: memory of the run.
        size: what makes it large, in words.
    """

    def __init__(
        self, title: str, first: int, last: int, mode: bool | None = None, *, nbytes: int = 0, size: str = ""
    ) -> None:
        self._title, self._first, self._last = title, first, last
        self._needs, self._size = nbytes, size
        self._bar: Any = None
        self._enabled = mode is not False and shown(PROCESS)
        self._terminal = self._enabled and sys.stderr.isatty()
        self._active = self._enabled or log.isEnabledFor(PROCESS)
        self._start = self._shown = self._noted = time.monotonic()
        self._learnt: float | None = None  # when the first step was over: it may have compiled
        self._told = False
        self._step = first

    def __enter__(self) -> Progress:
        if self._terminal:
            from rich.console import Console
            from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

            columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
            self._bar = Progress(*columns, console=Console(stderr=True))
            self._task = self._bar.add_task(self._title, total=self._last, completed=self._first)
            self._bar.start()
        return self

    def show(self, step: int, last: int) -> None:
        """Tells how far the run is; cheap enough to be called every step."""
        self._step = step
        if not self._active:
            return
        now = time.monotonic()
        if not self._told:
            self._estimate(now, step, last)
        if now - self._shown < (0.2 if self._terminal else 10.0):
            return
        self._shown = now
        left = (now - self._start) / max(step - self._first, 1) * (last - step)
        line = f"{self._title}: step {step} of {last}, about {left:.0f} s left"
        if self._bar is not None:
            self._bar.update(self._task, completed=step, total=last)
        elif self._enabled:
            sys.stderr.write(f"{line}\n")
        if now - self._noted >= 60.0:
            self._noted = now
            log.log(PROCESS, line, extra=FILE_ONLY)

    def _estimate(self, now: float, step: int, last: int) -> None:
        """Says once what the run needs, if it is a long one."""
        if self._learnt is None:
            self._learnt, self._after = now, step
            return
        seconds = now - self._learnt
        if seconds < LEARNT:
            return
        self._told = True
        left = seconds / (step - self._after) * (last - step)
        whole = left + now - self._start
        if whole < LONG:
            return
        line = f"{self._title}: needs {as_text(self._needs)}, about {duration(whole)}"
        line += f" ({self._size}, {last - self._first} steps)" if self._size else ""
        if log.isEnabledFor(PROCESS):
            log.log(PROCESS, line)
        else:  # directly: a script that has set up no logging shall see it, too
            sys.stderr.write(f"{line}\n")

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.update(self._task, completed=self._step)  # the bar must not end at the last look
            self._bar.stop()


def duration(seconds: float) -> str:
    """A time as people say it: 45 s, 12 min, 3 h 20 min, 2 d 4 h."""
    if seconds < 99.5:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    if minutes < 100:
        return f"{minutes} min"
    hours, minutes = divmod(minutes, 60)
    if hours < 48:
        return f"{hours} h {minutes} min"
    days, hours = divmod(hours, 24)
    return f"{days} d {hours} h"
