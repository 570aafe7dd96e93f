"""The command line, called as a function: what a run leaves behind, `--set`, exit codes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rbs_core.command import main
from tests.unit.core.results import check_run, strict

# -- run ------------------------------------------------------------------------------------------------------------


def test_run(file, tmp_path, capsys):
    out = tmp_path / "results" / "deep"
    assert main(["run", str(file), "--set", "n=10", "--set", "speed=2.5", "--out", str(out)]) == 0
    printed = capsys.readouterr()
    check_run(out, file, printed.out)
    assert printed.err == ""  # no line within ten seconds


def test_what_json_cannot_hold_is_null(file, tmp_path):
    assert main(["run", str(file), "--set", "n=10", "--out", str(tmp_path / "out"), "--quiet"]) == 0
    measured = strict(tmp_path / "out" / "result.json")["measured"]
    assert measured["never"] is None
    assert measured["unknown"] is None
    assert measured["path"] == [[1.0, None], [0.5, 2.0]]
    assert measured["more"] == {"list": [1, [2.0, None]], "3": None}
    assert measured["good"] is True
    assert measured["nodes"] == 10
    assert math.isfinite(measured["kinetic_J"])


def test_steps_leave_out_the_measure(file, tmp_path, capsys):
    """They are not the whole case, so its numbers would be wrong ones."""
    assert main(["run", str(file), "--steps", "6", "--out", str(tmp_path / "out")]) == 0
    result = strict(tmp_path / "out" / "result.json")
    assert (result["measured"], result["run"]["steps"]) == ({}, 6)
    printed = capsys.readouterr().out
    assert "finished at step 6" in printed
    assert "nodes" not in printed


@pytest.mark.parametrize("pieces", [[7, 20], [4, 4, 11, 20]])
def test_resumed_pieces_equal_the_uninterrupted_run(file, tmp_path, pieces):
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    run = ["run", str(file), "--set", "n=10", "--quiet"]
    assert main([*run, "--out", str(whole)]) == 0
    for steps in pieces[:-1]:  # the first one finds no file and starts at the beginning
        assert main([*run, "--out", str(parts), "--resume", "--steps", str(steps)]) == 0
    assert main([*run, "--out", str(parts), "--resume"]) == 0
    assert (parts / "history.csv").read_bytes() == (whole / "history.csv").read_bytes()
    one, other = (strict(folder / "result.json") for folder in (whole, parts))
    assert one["measured"] == other["measured"]
    assert other["run"]["steps"] == 20 - pieces[-2] // 4 * 4  # saved in every fourth step
    with np.load(whole / "checkpoint.npz") as a, np.load(parts / "checkpoint.npz") as b:
        assert a.files == b.files
        assert all(np.array_equal(a[name], b[name]) for name in a.files)


def test_resuming_another_scene_or_without_a_checkpoint_is_an_error(file, tmp_path, capsys):
    run = ["run", str(file), "--quiet", "--out", str(tmp_path / "out")]
    assert main([*run, "--steps", "8"]) == 0
    capsys.readouterr()
    assert main([*run, "--resume", "--set", "speed=2.0"]) == 2
    assert capsys.readouterr().err.startswith("rbs: BadCheckpoint: ")
    assert main([*run, "--resume", "--set", "saved=0"]) == 2
    assert capsys.readouterr().err == (
        "rbs: BadInput: --resume: the scene has no Checkpoint relation, so nothing was saved\n"
    )


# -- --set ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("12", 12),
        ("-2e-3", -2e-3),
        ("1_000", 1000),
        ("True", True),
        ("None", None),
        ("(1, 2.5)", [1, 2.5]),
        ("{'a': [1]}", {"a": [1]}),
        ("hello", "hello"),
        ("next step", "next step"),
        ("'12'", "12"),
        ("2*3", "2*3"),  # literals only: nothing is computed
        ("a=b", "a=b"),
        ("", ""),
    ],
)
def test_values_are_python_literals_or_text(file, tmp_path, text, value):
    run = ["run", str(file), "--steps", "1", "--quiet", "--out", str(tmp_path / "out")]
    assert main([*run, "--set", "n=10", "--set", f"region={text}"]) == 0
    assert strict(tmp_path / "out" / "result.json")["arguments"] == {"n": 10, "region": value}


def test_the_last_value_counts(file, tmp_path):
    run = ["run", str(file), "--steps", "1", "--quiet", "--out", str(tmp_path / "out")]
    assert main([*run, "--set", "name=a", "--set", "name=b"]) == 0
    assert strict(tmp_path / "out" / "result.json")["arguments"] == {"name": "b"}


def test_an_unknown_name_lists_the_known_ones(file, tmp_path, capsys):
    assert main(["run", str(file), "--set", "spede=10", "--out", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err == (
        f"rbs: BadInput: --set spede: scene of {file} takes n, speed, pause, keys, saved, name, region, out "
        "(did you mean speed?)\n"
    )
    assert not list((tmp_path / "out").iterdir())


@pytest.mark.parametrize("text", ["n", "=3", "2n=3", "n m=3"])
def test_what_is_no_assignment(file, tmp_path, capsys, text):
    assert main(["run", str(file), "--set", text, "--out", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err == f"rbs: BadInput: --set {text}: write NAME=VALUE, e.g. --set n=100\n"


# -- exit codes -----------------------------------------------------------------------------------------------------

BAD_FILES = {
    "x = 1": "has no function scene(...) that returns an Analysis",
    "scene = 3": "has no function scene(...) that returns an Analysis",
    "def scene(): return [1]": "must return an Analysis, got [1]",
}


@pytest.mark.parametrize(("text", "message"), BAD_FILES.items())
def test_files_without_a_scene(file, tmp_path, capsys, text, message):
    bad = file.with_name("pulled_badly.py")
    bad.write_text(text, encoding="utf-8")
    assert main(["run", str(bad), "--out", str(tmp_path / "out")]) == 2
    assert message in capsys.readouterr().err


def test_what_cannot_be_used_gives_2_and_one_line(file, tmp_path, capsys):
    (tmp_path / "in_the_way").write_text("no folder")
    for words, message in (
        ([str(tmp_path / "missing.py")], "rbs: BadInput: there is no file "),
        ([str(tmp_path)], "rbs: BadInput: there is no file "),
        ([str(file), "--out", str(tmp_path / "in_the_way")], "rbs: BadInput: cannot write into the folder "),
        ([str(file), "--steps", "-1", "--out", str(tmp_path / "out")], "rbs: BadInput: steps=-1 must be a whole "),
    ):
        assert main(["run", *words]) == 2
        printed = capsys.readouterr()
        assert printed.err.startswith(message)
        assert printed.err.count("\n") == 1
        assert printed.out == ""


@pytest.mark.parametrize(
    "words",
    [["run"], ["nonsense"], ["run", "a.py", "--steps", "many"], ["run", "a.py", "--colour"], ["describe"], ["show"]],
)
def test_wrong_usage_gives_2(words, capsys):
    with pytest.raises(SystemExit) as caught:
        main(words)
    assert caught.value.code == 2
    assert capsys.readouterr().err.startswith("usage: rbs")


def test_no_command_gives_2_and_the_help(capsys):
    assert main([]) == 2
    printed = capsys.readouterr().out
    assert all(
        word in printed
        for word in ("run", "show", "list", "describe", "exit codes", "rbs run simulations/plate_with_crack.py")
    )
