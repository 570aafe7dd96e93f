"""Sessions at a real terminal are as they are written down, in command/sessions/*.txt.

A session is a list of commands behind `$`, each with what the screen shows in the end, and `[code]` where the exit code
is not 0. Three dots stand for what differs from run to run, and blanks count as one. `[Ctrl-C at text]` below a command
presses the keys when the screen has shown the text.
"""

from __future__ import annotations

import difflib
import doctest
import re
import shlex
import shutil
from pathlib import Path

import pytest

from tests.unit.core.command.terminal import Terminal

pytest.importorskip("pty")

SESSIONS = sorted(Path(__file__).with_name("command").joinpath("sessions").glob("*.txt"))
CHECKER, LENIENT = doctest.OutputChecker(), doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def commands(text: str) -> list[tuple[str, str]]:
    """(command, what the screen shows) of a session."""
    pieces = re.split(r"^\$ (.*)\n", text, flags=re.MULTILINE)[1:]
    return list(zip(pieces[::2], pieces[1::2], strict=True))


@pytest.mark.parametrize("session", SESSIONS, ids=lambda path: path.stem)
def test_a_session(session, file, tmp_path):
    shutil.copy(Path(__file__).with_name("command") / "cracked_strip.py", tmp_path)
    for command, expected in commands(session.read_text(encoding="utf-8")):
        words = shlex.split(command)
        first = words.index("rbs")
        variables = dict(word.split("=", 1) for word in words[:first])
        terminal = Terminal(words[first + 1 :], tmp_path, {"RBS_PLUGINS": "rbs_plugins", **variables})
        key = re.search(r"^\[Ctrl-C at (.*)\]\n", expected, flags=re.MULTILINE)
        if key is not None:
            terminal.wait_for(key[1])
            terminal.press("\x03")
            expected = expected.replace(key[0], "")
        code, shown = terminal.end()
        found = shown + (f"[{code}]\n" if code else "")
        difference = difflib.unified_diff(
            expected.splitlines(), found.splitlines(), session.name, "screen", lineterm=""
        )
        assert CHECKER.check_output(expected, found, LENIENT), f"$ {command}\n" + "\n".join(difference)


def test_there_are_sessions():
    assert {"run_and_show", "wrong_words", "interrupted"} <= {path.stem for path in SESSIONS}
