"""Levels of messages, on the terminal and in a file."""

from __future__ import annotations

import logging
import re
import warnings
from collections.abc import Iterator

import pytest

from rbs_core import BadInput, configure_logging
from rbs_core.report import LEVELS, log
from rbs_core.report.levels import FILE_ONLY, PROCESS, TIMING, add_file, logging_of_a_command, shown


@pytest.fixture(autouse=True)
def restored() -> Iterator[None]:
    with logging_of_a_command():
        yield


def say_all() -> None:
    log.error("%s", "wrong")
    log.warning("odd")
    log.log(PROCESS, "going on")
    log.log(TIMING, "took 3 s")
    log.debug("kick\nand drift")


SAID = ["rbs: wrong", "rbs: warning: odd", "going on", "took 3 s", "kick", "and drift"]


@pytest.mark.parametrize(("level", "count"), list(zip(LEVELS, (0, 1, 2, 3, 4, 6), strict=True)))
def test_each_level_tells_what_those_before_tell_and_more(level, count, capsys):
    configure_logging(level)
    say_all()
    printed = capsys.readouterr()
    assert printed.err.splitlines() == SAID[:count]
    assert printed.out == ""


@pytest.mark.parametrize(("level", "count"), list(zip(LEVELS, (0, 1, 2, 3, 4, 5), strict=True)))
def test_a_file_has_a_level_of_its_own(level, count, capsys, tmp_path):
    configure_logging("off", tmp_path / "run.log", file_level=level)
    say_all()
    assert capsys.readouterr().err == ""
    assert (tmp_path / "run.log").exists() == (count > 0)  # made with the first line
    if count:
        date = r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d"
        lines = (tmp_path / "run.log").read_text().splitlines()
        names = [re.fullmatch(rf"{date} (\w+) +\S.*", line) for line in lines if not line.startswith("    ")]
        assert [name[1] for name in names] == [*LEVELS][1 : count + 1]
        assert (lines[-1] == "    and drift") == (level == "debug")


def test_lines_are_added_to_a_file(tmp_path):
    for word in ("one", "two"):
        configure_logging("off", tmp_path / "run.log")
        log.info(word)
    assert [line.split()[-1] for line in (tmp_path / "run.log").read_text().splitlines()] == ["one", "two"]


def test_what_only_files_tell(tmp_path, capsys):
    configure_logging("debug", tmp_path / "run.log")
    log.info("for later", extra=FILE_ONLY)
    assert capsys.readouterr().err == ""
    assert "for later" in (tmp_path / "run.log").read_text()


def test_the_last_call_counts(tmp_path, capsys):
    configure_logging("debug", tmp_path / "run.log")
    configure_logging("error")
    say_all()
    assert capsys.readouterr().err == "rbs: wrong\n"
    assert not (tmp_path / "run.log").exists()


@pytest.mark.parametrize("words", [{"terminal": "loud"}, {"file_level": "info"}])
def test_a_level_that_is_none(words):
    configure_logging("error")
    with pytest.raises(BadInput, match=r"no level '\w+' of messages: take one of off, error, .*debug"):
        configure_logging(**words)
    assert not shown(PROCESS)  # nothing has changed


def test_progress_is_shown_unless_the_terminal_is_told_otherwise():
    assert shown(PROCESS)
    for level, told in (("timing", True), ("process", True), ("warning", False), ("off", False)):
        configure_logging(level)
        assert shown(PROCESS) == told


def test_a_command_takes_back_what_it_configured(tmp_path, capsys):
    configure_logging("error")
    before = (list(log.handlers), log.level, log.propagate, warnings.showwarning)
    with logging_of_a_command():
        configure_logging("debug")
        add_file(tmp_path / "run.log", "debug")
        log.debug("inside")
    assert (list(log.handlers), log.level, log.propagate, warnings.showwarning) == before
    say_all()
    assert capsys.readouterr().err == "inside\nrbs: wrong\n"


def test_what_is_warned_of_becomes_a_message(capsys):
    configure_logging("warning")
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        with logging_of_a_command():
            warnings.warn("3 nodes have no bond", UserWarning, stacklevel=1)
            warnings.warn("old", DeprecationWarning, stacklevel=1)
    first, second = capsys.readouterr().err.splitlines()
    assert first == "rbs: warning: 3 nodes have no bond"
    assert re.fullmatch(r"rbs: warning: old \(DeprecationWarning, .*test_levels.py:\d+\)", second)


def test_scripts_that_set_up_the_standard_library_themselves_get_the_messages(caplog):
    caplog.set_level(logging.DEBUG, "rbs")
    say_all()
    assert [record.levelno for record in caplog.records] == [40, 30, 20, 15, 10]
