"""The help teaches: its examples are commands that work, its lists are complete."""

from __future__ import annotations

import re
import shlex

import pytest

from rbs_core.command import main
from rbs_core.command.parser import make_parser
from rbs_core.memory import VARIABLE
from rbs_core.report import LEVELS

COMMANDS = ("run", "show", "list", "describe")


def help_of(capsys, *words: str) -> str:
    with pytest.raises(SystemExit) as caught:
        main([*words, "--help"])
    assert caught.value.code == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("words", [(), *((command,) for command in COMMANDS)], ids=lambda words: " ".join(words))
def test_examples_of_the_help_parse(words, capsys):
    text = help_of(capsys, *words)
    examples = re.findall(r"^  rbs (.*?)(?:   .*)?$", text, flags=re.MULTILINE)
    assert len(examples) >= 2
    for example in examples:
        plain = re.split(r" [|>]", example)[0]
        assert make_parser().parse_args(shlex.split(plain)).command is not None, example


def test_the_first_help_leads_to_all_commands(capsys):
    text = help_of(capsys)
    for command in COMMANDS:
        assert re.search(rf"^    {command} ", text, flags=re.MULTILINE)
    for code in ("0", "1", "2", "130"):
        assert re.search(rf"^  {code} +\w", text, flags=re.MULTILINE)
    assert VARIABLE in text


def test_the_help_of_run_explains_every_level(capsys):
    text = help_of(capsys, "run")
    for level in LEVELS:
        assert re.search(rf"^  {level} +\w", text, flags=re.MULTILINE), level


def test_lines_fit_a_terminal(capsys):
    for words in ((), *((command,) for command in COMMANDS)):
        assert max(map(len, help_of(capsys, *words).splitlines())) <= 120
