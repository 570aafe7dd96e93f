"""The tables of times and of memory."""

from __future__ import annotations

import json

import pytest

from rbs_core import Report
from rbs_core.report import Held, Row


def example() -> Report:
    rows = [
        Row("Kick 'bar'", calls=100, seconds=1.0, nodes=2000),
        Row("BondBased 'bar'", 50, 3.0, 600_000_000, 450_000_000),
    ]
    return Report(
        rows,
        steps=100,
        step=400,
        time=2e-6,
        seconds=4.0,
        prepare_seconds=0.5,
        nbytes=3 * 2**20,
        storages={"bar": "list"},
        memory=[Held("bar", "displacement", "node", 2_500_000), Held("BondBased 'bar'", "loops", "", 1_000_000)],
    )


def test_bonds_per_second():
    kick, force = example().rows
    assert kick.rate is None
    assert force.rate == pytest.approx(200.0)  # million
    assert Row("never ran", items=0, seconds=0.0).rate is None


def test_the_table_says_where_the_time_went():
    header, kick, force, sentence, stored = str(example()).splitlines()
    assert header.split() == ["relation", "calls", "items", "seconds", "share", "ns/item", "Mbond/s", "saved"]
    assert kick.split() == ["0", "Kick", "'bar'", "100", "2k", "1.000", "25.0%", "5e+03"]
    assert force.split() == ["1", "BondBased", "'bar'", "50", "12M", "3.000", "75.0%", "5", "200.0", "25%"]
    assert stored == "bonds stored: 'bar' as list"
    assert sentence == (
        "100 steps in 4.00 s (prepared in 0.50 s), finished at step 400, time 2e-06 s; "
        "fields, bonds and relations hold 3.1 MB"
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
        "step": 400,
        "time": 2e-6,
        "seconds": 4.0,
        "prepare_seconds": 0.5,
        "stopped": "finished",
        "bytes": 3 * 2**20,
        "storages": {"bar": "list"},
        "relations": [
            {"name": "Kick 'bar'", "calls": 100, "seconds": 1.0, "bonds": 0, "saved": 0.0}
            | {"nodes": 2000, "seconds_per_item": 5e-6},
            {"name": "BondBased 'bar'", "calls": 50, "seconds": 3.0, "bonds": 600_000_000, "saved": 0.25}
            | {"nodes": 0, "seconds_per_item": 5e-9},
        ],
        "memory": [
            {"owner": "bar", "name": "displacement", "at": "node", "nbytes": 2_500_000},
            {"owner": "BondBased 'bar'", "name": "loops", "at": "", "nbytes": 1_000_000},
        ],
    }


def test_the_report_comes_back_from_the_file():
    again = Report.from_dict(json.loads(json.dumps(example().as_dict())))
    assert again == example()
    assert str(again) == str(example())


def test_a_report_of_an_older_file_can_be_shown():
    old = {"steps": 3, "seconds": 1.0, "relations": [{"name": "Kick", "calls": 3, "seconds": 0.5, "bonds": 0}]}
    text = str(Report.from_dict(old))
    assert "finished at step 3" in text
    assert "50.0%" in text


def test_seconds_per_item():
    kick, force = example().rows
    assert (kick.worked, force.worked) == (200_000, 600_000_000)
    assert kick.seconds_per_item == pytest.approx(5e-6)
    assert force.seconds_per_item == pytest.approx(5e-9)
    assert Row("Checkpoint", 3, 1.0).seconds_per_item is None


def test_the_table_of_memory():
    header, field, loops = example().memory_table().splitlines()
    assert header.split() == ["of", "what", "at", "memory"]
    assert field.split() == ["bar", "displacement", "node", "2.5", "MB"]
    assert loops.split() == ["BondBased", "'bar'", "loops", "1", "MB"]
    assert Report().memory_table() == ""


def test_many_small_shares_of_memory_are_one_sum():
    """Each of 2,000 parts has less than a row of the table is worth."""
    many = Report(memory=[Held(f"part {n}", "volume", "node", 1000) for n in range(2000)], nbytes=2_000_000)
    assert many.memory_table().splitlines()[-1].split() == ["and", "2000", "more", "2", "MB"]


def test_a_long_table_of_memory_ends_with_a_sum():
    many = Report(memory=[Held(f"part {n}", "volume", "node", 1000) for n in range(25)], nbytes=25_000)
    lines = many.memory_table().splitlines()
    assert len(lines) == 22
    assert lines[-1].split() == ["and", "5", "more", "5", "kB"]
    small = Report(memory=[Held("a", "volume", "node", 10**6), Held("a", "energy", "part", 8)], nbytes=10**6 + 8)
    assert small.memory_table().splitlines()[-1].split() == ["and", "1", "more", "8", "B"]
