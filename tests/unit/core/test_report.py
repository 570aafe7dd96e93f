"""The table of times and the progress line."""

from __future__ import annotations

import io
import json
import logging

import pytest

from rbs_core import Report, report
from rbs_core.report import Progress, Row


def example() -> Report:
    rows = [Row("Kick 'bar'", calls=100, seconds=1.0), Row("BondBased 'bar'", 50, 3.0, 600_000_000, 450_000_000)]
    return Report(
        rows,
        steps=100,
        step=400,
        time=2e-6,
        seconds=4.0,
        prepare_seconds=0.5,
        nbytes=3 * 2**20,
        storages={"bar": "list"},
    )


def test_bonds_per_second():
    kick, force = example().rows
    assert kick.rate is None
    assert force.rate == pytest.approx(200.0)  # million
    assert Row("never ran", items=0, seconds=0.0).rate is None


def test_the_table_says_where_the_time_went():
    header, kick, force, sentence, stored = str(example()).splitlines()
    assert header.split() == ["relation", "calls", "seconds", "share", "Mbond/s", "saved"]
    assert kick.split() == ["0", "Kick", "'bar'", "100", "1.000", "25.0%"]
    assert force.split() == ["1", "BondBased", "'bar'", "50", "3.000", "75.0%", "200.0", "25%"]
    assert stored == "bonds stored: 'bar' as list"
    assert sentence == (
        "100 steps in 4.00 s (prepared in 0.50 s), finished at step 400, time 2e-06 s; "
        "fields, bonds and relations hold 3.0 MiB"
    )


def test_columns_are_aligned():
    lines = str(example()).splitlines()
    ends = [line.index(word) + len(word) for line, word in zip(lines, ("seconds", "1.000", "3.000"), strict=False)]
    assert len(set(ends)) == 1


def test_a_report_of_nothing_can_be_printed():
    assert "0 steps in 0.00 s" in str(Report())
    assert "0.0%" in str(Report([Row("Kick 'bar'")]))


def test_plain_numbers_for_a_file():
    assert json.loads(json.dumps(example().as_dict())) == {
        "steps": 100,
        "time": 2e-6,
        "seconds": 4.0,
        "prepare_seconds": 0.5,
        "stopped": "finished",
        "bytes": 3 * 2**20,
        "storages": {"bar": "list"},
        "relations": [
            {"name": "Kick 'bar'", "calls": 100, "seconds": 1.0, "bonds": 0, "saved": 0.0},
            {"name": "BondBased 'bar'", "calls": 50, "seconds": 3.0, "bonds": 600_000_000, "saved": 0.25},
        ],
    }


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_plain_line_every_ten_seconds_where_there_is_no_terminal(monkeypatch, caplog):
    """Directly, not through the log: a script that has set up no logging shall see it, too."""
    now = 0.0
    stream = io.StringIO()
    monkeypatch.setattr(report.time, "monotonic", lambda: now)
    monkeypatch.setattr(report.sys, "stderr", stream)
    caplog.set_level(logging.INFO, "rbs")
    with Progress("plate", 0, 100) as bar:
        for step, now in ((1, 4.0), (2, 9.9), (4, 10.0), (6, 19.0), (10, 20.0)):  # noqa: B007  the clock reads it
            bar.show(step, 100)
    assert stream.getvalue().splitlines() == [
        "plate: step 4 of 100, about 240 s left",
        "plate: step 10 of 100, about 180 s left",
    ]
    assert not caplog.records


def test_the_time_left_of_a_resumed_run_counts_from_where_it_began(monkeypatch):
    now = 0.0
    stream = io.StringIO()
    monkeypatch.setattr(report.time, "monotonic", lambda: now)
    monkeypatch.setattr(report.sys, "stderr", stream)
    with Progress("plate", 500, 600) as bar:
        now = 10.0
        bar.show(550, 600)
    assert stream.getvalue().endswith("about 10 s left\n")


def test_a_bar_on_a_terminal(monkeypatch):
    now = 0.0
    screen = Terminal()
    monkeypatch.setattr(report.time, "monotonic", lambda: now)
    monkeypatch.setattr(report.sys, "stderr", screen)
    with Progress("plate", 0, 80) as bar:
        now = 1.0
        bar.show(40, 80)
        now = 1.1
        bar.show(47, 80)  # too early to be shown, but the bar must end where the run ended
    assert "plate" in screen.getvalue()
    assert "47/80" in screen.getvalue()


def test_silence_when_switched_off(monkeypatch, caplog):
    now = 0.0
    screen = Terminal()
    monkeypatch.setattr(report.time, "monotonic", lambda: now)
    monkeypatch.setattr(report.sys, "stderr", screen)
    caplog.set_level(logging.INFO, "rbs")
    with Progress("plate", 0, 80, mode=False) as bar:
        now = 100.0
        bar.show(40, 80)
    assert screen.getvalue() == ""
    assert not caplog.records
