"""What the exit code of a command says, and where its messages go."""

from __future__ import annotations

import json
import logging
import warnings

import pytest

from rbs_core import command, errors
from rbs_core.command import main
from rbs_core.report import log

KINDS = [kind for kind in vars(errors).values() if isinstance(kind, type) and kind is not errors.RBSError]


@pytest.mark.parametrize("kind", KINDS)
def test_errors_before_a_run_give_2_and_those_of_a_run_1(kind, monkeypatch, capsys):
    def fail(_):
        raise kind("this is wrong: do that")

    monkeypatch.setattr("rbs_core.command.parser.list_all", fail)
    assert main(["list"]) == (1 if kind in (errors.NotFinite, errors.DishonestRelation) else 2)
    assert capsys.readouterr().err == f"rbs: {kind.__name__}: this is wrong: do that\n"


@pytest.mark.parametrize(
    ("error", "code", "text"),
    [
        (MemoryError("no room"), 1, "rbs: MemoryError: no room: take fewer nodes, a smaller horizon, or "
                                    "precision='single'\n"),
        (KeyboardInterrupt(), 130, "rbs: interrupted\n"),
    ],
)  # fmt: skip
def test_other_ends(error, code, text, monkeypatch, capsys):
    def fail(_):
        raise error

    monkeypatch.setattr("rbs_core.command.parser.list_all", fail)
    assert main(["list"]) == code
    assert capsys.readouterr().err == text


def test_a_mistake_in_the_file_shows_where_it_is_and_stays_in_the_log(file, tmp_path):
    bad = file.with_name("pulled_wrongly.py")
    bad.write_text(file.read_text() + "\n\ndef measure(analysis):\n    return {'a': 1 / 0}\n")
    with pytest.raises(ZeroDivisionError):
        main(["run", str(bad), "--out", str(tmp_path / "out"), "--level", "off"])
    text = (tmp_path / "out" / "run.log").read_text()
    assert "error    Traceback (most recent call last):\n" in text
    assert 'pulled_wrongly.py", line' in text
    assert text.rstrip().endswith("ZeroDivisionError: division by zero")


def run(file, out, *words):
    return main(["run", str(file), "--set", "n=10", "--out", str(out), *words])


def test_numbers_are_the_same_to_the_bit_whatever_is_told(file, tmp_path, capsys):
    measured = []
    for level in ("off", "error", "warning", "process", "timing", "debug"):
        out = tmp_path / level
        assert run(file, out, "--level", level, "--log-level", level) == 0
        measured.append(json.loads((out / "result.json").read_text())["measured"])
        measured.append((out / "history.csv").read_bytes())
    assert all(each == measured[number % 2] for number, each in enumerate(measured))


@pytest.mark.parametrize(
    ("level", "table", "place", "steps"),
    [("off", 0, 0, 0), ("error", 0, 0, 0), ("process", 0, 1, 0), ("timing", 1, 1, 0), ("debug", 1, 1, 20)],
)
def test_what_the_terminal_shows(file, tmp_path, capsys, level, table, place, steps):
    assert run(file, tmp_path / "out", "--level", level) == 0
    printed = capsys.readouterr()
    assert "pulled_m" in printed.out  # what was measured, always
    assert printed.out.count("Mbond/s") == table
    assert printed.out.count("results in") == place
    assert len([line for line in printed.err.splitlines() if line.startswith("step ")]) == steps


def test_no_log(file, tmp_path):
    assert run(file, tmp_path / "out", "--log-level", "off") == 0
    assert not (tmp_path / "out" / "run.log").exists()


def test_the_log_keeps_earlier_runs_and_errors(file, tmp_path):
    out = tmp_path / "out"
    assert run(file, out, "--steps", "3") == 0
    assert run(file, out, "--steps", "-3") == 2
    lines = [line[20:] for line in (out / "run.log").read_text().splitlines() if not line.startswith("    ")]
    said = [line for line in lines if line.startswith(("process  rbs run", "error"))]
    assert said[0].endswith("--set n=10 --steps 3")
    assert said[1].endswith("--set n=10 --steps -3")
    assert said[2].startswith("error    BadInput: steps=-3 must be a whole ")
    assert len(said) == 3


def test_a_warning_is_one_line(file, tmp_path, capsys):
    warned = file.with_name("pulled_warned.py")
    text = file.read_text().replace(
        "    ends = [", "    warnings.warn('one node is alone', stacklevel=1)\n    ends = ["
    )
    warned.write_text(text.replace("import time\n", "import time\nimport warnings\n"))
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        assert run(warned, tmp_path / "out", "--level", "warning") == 0
        assert run(warned, tmp_path / "out", "--level", "error") == 0
    assert capsys.readouterr().err == "rbs: warning: one node is alone\n"


def test_nothing_stays_configured(file, tmp_path):
    before = (list(log.handlers), log.level, log.propagate, list(logging.getLogger().handlers))
    assert run(file, tmp_path / "out", "--level", "debug") == 0
    assert (list(log.handlers), log.level, log.propagate, list(logging.getLogger().handlers)) == before


def test_the_names_of_the_codes():
    assert (command.SUCCESS, command.FAILED, command.USAGE, command.INTERRUPTED) == (0, 1, 2, 130)
