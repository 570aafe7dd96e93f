"""What a run tells its user: log lines, a progress line, and at the end a table of where the time went."""

from __future__ import annotations

import logging
import sys
import time
from dataclasses import dataclass, field
from typing import Any

log = logging.getLogger("rbs")


@dataclass
class Row:
    """Cost of one place in the list of relations."""

    name: str
    calls: int = 0
    seconds: float = 0.0
    items: int = 0
    visited: int = 0

    @property
    def saved(self) -> float:
        """Share of the directed bonds that did not have to be visited."""
        return 1.0 - self.visited / self.items if self.items else 0.0

    @property
    def rate(self) -> float | None:
        """Directed bonds per second in millions, None for a relation without bonds."""
        return self.items / self.seconds / 1e6 if self.items and self.seconds > 0 else None


@dataclass
class Report:
    """What `Analysis.run` returns; `print(report)` shows the table.

    Attributes:
        rows: one per relation, in order.
        steps: steps done in this run.
        step: number of the last step.
        time: simulated time reached, s.
        seconds: wall time of the steps, s.
        prepare_seconds: wall time of checking, allocating and compiling, s.
        stopped: "finished", "interrupted", or "failed" where the run ended in an error.
        nbytes: memory of all fields and bonds, and of what the relations keep beside them, bytes.
        storages: how the bonds of each part are stored, by its name.
    """

    rows: list[Row] = field(default_factory=list)
    steps: int = 0
    step: int = 0
    time: float = 0.0
    seconds: float = 0.0
    prepare_seconds: float = 0.0
    stopped: str = "finished"
    nbytes: int = 0
    storages: dict[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        width = max([8, *(len(row.name) for row in self.rows)])
        lines = [f"   {'relation':<{width}}  {'calls':>7} {'seconds':>9} {'share':>7} {'Mbond/s':>9} {'saved':>6}"]
        for number, row in enumerate(self.rows):
            share = row.seconds / self.seconds if self.seconds > 0 else 0.0
            rate = "" if row.rate is None else f"{row.rate:.1f}"
            saved = f"{row.saved:.0%}" if row.saved else ""
            cost = f"{row.calls:>7} {row.seconds:>9.3f} {share:>7.1%} {rate:>9} {saved:>6}"
            lines.append(f"{number:>2} {row.name:<{width}}  {cost}".rstrip())
        lines.append(
            f"{self.steps} steps in {self.seconds:.2f} s (prepared in {self.prepare_seconds:.2f} s), {self.stopped} at "
            f"step {self.step}, time {self.time:.6g} s; fields, bonds and relations hold {self.nbytes / 2**20:.1f} MiB"
        )
        if self.storages:
            stored = [f"'{name}' as {storage}" for name, storage in self.storages.items()]
            lines.append(f"bonds stored: {', '.join(stored[:10])}{', ...' if len(stored) > 10 else ''}")
        return "\n".join(lines)

    def as_dict(self) -> dict[str, Any]:
        """The same as plain numbers, for result.json."""
        return {
            "steps": self.steps,
            "time": self.time,
            "seconds": self.seconds,
            "prepare_seconds": self.prepare_seconds,
            "stopped": self.stopped,
            "bytes": self.nbytes,
            "storages": self.storages,
            "relations": [
                {"name": row.name, "calls": row.calls, "seconds": row.seconds, "bonds": row.items, "saved": row.saved}
                for row in self.rows
            ],
        }


class Progress:
    """A bar with the time left on a terminal, a plain line every ten seconds elsewhere, nothing when switched off."""

    def __init__(self, title: str, first: int, last: int, mode: bool | None = None) -> None:
        self._title, self._first, self._last = title, first, last
        self._bar: Any = None
        self._enabled = mode is not False
        self._terminal = self._enabled and sys.stderr.isatty()
        self._start = self._shown = time.monotonic()
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
        if not self._enabled:
            return
        now = time.monotonic()
        if now - self._shown < (0.2 if self._terminal else 10.0):
            return
        self._shown = now
        if self._bar is not None:
            self._bar.update(self._task, completed=step, total=last)
        else:
            left = (now - self._start) / max(step - self._first, 1) * (last - step)
            sys.stderr.write(f"{self._title}: step {step} of {last}, about {left:.0f} s left\n")

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.update(self._task, completed=self._step)  # the bar must not end at the last look
            self._bar.stop()
