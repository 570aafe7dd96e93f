"""The command line as a process of its own: exit codes, Ctrl-C from outside, a terminal."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from rbs_core.command import main
from tests.unit.core.results import check_run, strict


def rbs(*words, cwd: Path, **options) -> subprocess.CompletedProcess:
    """`python -m rbs_core ...` in a process of its own."""
    command = [sys.executable, "-m", "rbs_core", *map(str, words)]
    return subprocess.run(command, cwd=cwd, capture_output=True, encoding="utf-8", timeout=120, check=False, **options)


def test_run_as_a_process_in_the_folder_that_is_taken_by_default(file, tmp_path):
    done = rbs("run", file.name, "--set", "n=10", "--set", "speed=2.5", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    out = Path("out/pulled_bar")
    assert f"results in {out}{os.sep}" in done.stdout
    check_run(tmp_path / out, file, done.stdout.replace(str(out), str(tmp_path / out)))


def test_exit_codes_of_processes(file, tmp_path):
    assert rbs("run", file.name, "--steps", 1, "--quiet", cwd=tmp_path).returncode == 0
    missing = rbs("run", "missing.py", cwd=tmp_path)
    assert (missing.returncode, missing.stderr) == (2, "rbs: BadInput: there is no file missing.py\n")
    usage = rbs("run", cwd=tmp_path)
    assert usage.returncode == 2
    assert "the following arguments are required: file" in usage.stderr
    (tmp_path / "pulled_broken.py").write_text("def scene():\n    return 1 / 0\n", encoding="utf-8")
    broken = rbs("run", "pulled_broken.py", cwd=tmp_path)
    assert broken.returncode == 1
    assert 'pulled_broken.py", line 2, in scene' in broken.stderr  # a mistake of the file: where it is


def test_list_and_describe_as_processes(tmp_path):
    listed = rbs("list", cwd=tmp_path, env={**os.environ, "PYTHONIOENCODING": "utf-8"})
    assert (listed.returncode, listed.stderr) == (0, "")
    assert "BondBased" in listed.stdout
    described = rbs("describe", "damage", cwd=tmp_path, env={**os.environ, "PYTHONIOENCODING": "utf-8"})
    assert (described.returncode, described.stderr) == (0, "")
    assert described.stdout.startswith("damage (φ)")


# -- Ctrl-C ---------------------------------------------------------------------------------------------------------


def test_ctrl_c_gives_130_and_a_checkpoint_to_go_on_from(file, tmp_path):
    """A process that waits in every step is interrupted from outside; resumed, it gives the uninterrupted run."""
    out = tmp_path / "out"
    words = ["run", file.name, "--set", "n=10", "--set", "saved=1000", "--out", str(out)]
    process = subprocess.Popen(
        [sys.executable, "-m", "rbs_core", *words, "--set", "pause=0.3"],
        cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8",
    )  # fmt: skip
    try:
        for _ in range(600):
            if (out / "history.csv").exists() and (out / "history.csv").read_text().count("\n") > 3:
                break
            time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        stdout, stderr = process.communicate(timeout=60)
    finally:
        process.kill()
        process.wait()
    assert (process.returncode, stderr) == (130, "")
    stopped = strict(out / "result.json")
    step = stopped["run"]["steps"]
    assert 3 <= step < 20
    assert f"interrupted at step {step}" in stdout
    assert (stopped["run"]["stopped"], stopped["measured"]) == ("interrupted", {})
    with np.load(out / "checkpoint.npz") as saved:
        assert json.loads(str(saved["meta"]))["step"] == step
    resume = ["run", str(file), "--set", "n=10", "--set", "saved=1000", "--quiet"]
    assert main([*resume, "--out", str(out), "--resume"]) == 0
    assert strict(out / "result.json")["run"]["steps"] == 20 - step
    assert main([*resume, "--out", str(tmp_path / "whole")]) == 0
    assert (out / "history.csv").read_bytes() == (tmp_path / "whole" / "history.csv").read_bytes()


@pytest.mark.parametrize(("keys", "words"), [(1, "interrupted at step 3"), (2, "rbs: interrupted")])
def test_once_finishes_the_step_and_twice_breaks_off(file, tmp_path, capsys, keys, words):
    out, before = tmp_path / "out", signal.getsignal(signal.SIGINT)
    assert main(["run", str(file), "--set", f"keys={keys}", "--set", "saved=1000", "--out", str(out)]) == 130
    printed = capsys.readouterr()
    assert words in printed.out + printed.err
    assert (out / "checkpoint.npz").exists() == (keys == 1)
    # what lies in the folder is of this run, also if it was broken off
    assert strict(out / "result.json")["run"]["stopped"] == ("interrupted" if keys == 1 else "failed")
    assert (out / "history.csv").read_text().count("\n") == 4
    assert signal.getsignal(signal.SIGINT) is before


# -- progress -------------------------------------------------------------------------------------------------------


def on_a_terminal(*words, cwd: Path) -> tuple[int, str, str]:
    """Exit code, standard output and what the terminal shows, with the error stream on a pseudo terminal."""
    pty = pytest.importorskip("pty")
    ours, theirs = pty.openpty()
    plain = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "CI", "TTY_COMPATIBLE")}
    process = subprocess.Popen(
        [sys.executable, "-m", "rbs_core", *map(str, words)],
        cwd=cwd, stdout=subprocess.PIPE, stderr=theirs, env={**plain, "TERM": "xterm", "COLUMNS": "100"},
    )  # fmt: skip
    os.close(theirs)
    screen = b""
    try:
        while piece := os.read(ours, 4096):
            screen += piece
    except OSError:
        pass  # how Linux says that nobody writes any more
    finally:
        os.close(ours)
        stdout, _ = process.communicate(timeout=60)
    return process.returncode, stdout.decode(), screen.decode()


def test_a_terminal_shows_a_bar(file, tmp_path):
    code, stdout, screen = on_a_terminal("run", file.name, "--set", "pause=0.03", cwd=tmp_path)
    assert code == 0
    assert "pulled bar" in screen
    assert "━" in screen
    counts = [int(count) for count in re.findall(r"(\d+)/20", screen)]
    assert counts == sorted(counts)
    assert (counts[0], counts[-1]) == (0, 20)
    assert any(0 < count < 20 for count in counts)
    assert "\x1b" not in stdout  # the bar does not get into the results
    assert "20 steps in" in stdout


def test_quiet_shows_nothing(file, tmp_path):
    code, stdout, screen = on_a_terminal("run", file.name, "--quiet", "--set", "pause=0.01", cwd=tmp_path)
    assert (code, screen) == (0, "")
    assert "20 steps in" in stdout
