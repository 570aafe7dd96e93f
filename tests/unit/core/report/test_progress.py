"""The bar, the line, and the estimate before a long run."""

from __future__ import annotations

import io
import logging

import pytest

from rbs_core.report import Progress, configure_logging, progress
from rbs_core.report.levels import logging_of_a_command
from rbs_core.report.progress import duration


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_plain_line_every_ten_seconds_where_there_is_no_terminal(monkeypatch, caplog):
    """Directly, not through the log: a script that has set up no logging shall see it, too."""
    now = 0.0
    stream = io.StringIO()
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    monkeypatch.setattr(progress.sys, "stderr", stream)
    caplog.set_level(logging.INFO, "rbs")
    with Progress("plate", 0, 100) as bar:
        for step, now in ((1, 4.0), (2, 9.9), (4, 10.0), (6, 19.0), (10, 20.0)):  # noqa: B007  the clock reads it
            bar.show(step, 100)
    assert stream.getvalue().splitlines() == [
        "plate: step 4 of 100, about 240 s left",
        "plate: step 10 of 100, about 180 s left",
    ]
    assert [record.getMessage() for record in caplog.records] == ["plate: needs 0 B, about 10 min"]


def test_the_time_left_of_a_resumed_run_counts_from_where_it_began(monkeypatch):
    now = 0.0
    stream = io.StringIO()
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    monkeypatch.setattr(progress.sys, "stderr", stream)
    with Progress("plate", 500, 600) as bar:
        now = 10.0
        bar.show(550, 600)
    assert stream.getvalue().endswith("about 10 s left\n")


def test_a_bar_on_a_terminal(monkeypatch):
    now = 0.0
    screen = Terminal()
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    monkeypatch.setattr(progress.sys, "stderr", screen)
    with Progress("plate", 0, 80) as bar:
        now = 1.0
        bar.show(40, 80)
        now = 1.1
        bar.show(47, 80)  # too early to be shown, but the bar must end where the run ended
    assert "plate" in screen.getvalue()
    assert "47/80" in screen.getvalue()


def test_silence_when_switched_off(monkeypatch):
    now = 0.0
    screen = Terminal()
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    monkeypatch.setattr(progress.sys, "stderr", screen)
    with Progress("plate", 0, 80, mode=False) as bar:
        now = 100.0
        bar.show(40, 80)
    assert screen.getvalue() == ""


# -- what a long run needs ------------------------------------------------------------------------------------------


def told(monkeypatch, seconds: list[float], last: int, **options) -> str:
    """What a run tells whose steps end at these times, s."""
    now, stream = 0.0, io.StringIO()
    monkeypatch.setattr(progress.sys, "stderr", stream)
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    with Progress("plate", 0, last, nbytes=3_100_000_000, size="253,000 nodes", **options) as bar:
        for step, now in enumerate(seconds, 1):  # noqa: B007  the clock reads it
            bar.show(step, last)
    return stream.getvalue()


def test_a_long_run_says_once_what_it_needs(monkeypatch):
    # the first step compiles, and does not count: 5 s + 1000 steps of 0.72 s
    assert (
        told(monkeypatch, [5.0, 5.72, 6.44, 7.16, 7.88, 8.6], 1001)
        == "plate: needs 3.1 GB, about 12 min (253,000 nodes, 1001 steps)\n"
    )


def test_a_short_run_says_nothing(monkeypatch):
    assert told(monkeypatch, [5.0, 5.72, 6.44, 7.16, 7.88, 8.6], 50) == ""


def test_without_progress_the_log_tells_it(monkeypatch, tmp_path):
    with logging_of_a_command():
        configure_logging("error", tmp_path / "run.log", file_level="process")
        assert told(monkeypatch, [5.0, *(5.0 + 2.0 * n for n in range(1, 70))], 1001, mode=False) == ""
    lines = [line.split(" process  ")[1] for line in (tmp_path / "run.log").read_text().splitlines()]
    assert lines[0] == "plate: needs 3.1 GB, about 33 min (253,000 nodes, 1001 steps)"
    assert [line.split(",")[0] for line in lines[1:]] == ["plate: step 29 of 1001", "plate: step 59 of 1001"]


def test_terminals_that_show_errors_only_show_no_progress(monkeypatch):
    with logging_of_a_command():
        configure_logging("warning")
        assert told(monkeypatch, [5.0 * n for n in range(1, 30)], 1001) == ""


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.0, "0 s"), (59.7, "60 s"), (99.6, "2 min"), (720, "12 min"), (12_000, "3 h 20 min"), (187_200, "2 d 4 h")],
)
def test_durations_as_people_say_them(seconds, text):
    assert duration(seconds) == text
