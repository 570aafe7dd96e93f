"""Generated modules: where they live, who may write there, and that a second process need not compile."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from rbs_plugins.loops import cache

posix = pytest.mark.skipif(not hasattr(os, "getuid"), reason="permissions as on POSIX")


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A cache folder of our own, and a process that has loaded nothing yet."""
    monkeypatch.setenv("RBS_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(cache, "_loaded", {})
    return tmp_path / "cache"


def test_folder_is_made_for_the_user_alone(home):
    assert cache.folder() == home
    assert home.is_dir()
    if hasattr(os, "getuid"):
        assert home.stat().st_mode & 0o777 == 0o700


@posix
@pytest.mark.parametrize("mode", [0o770, 0o702, 0o777])
def test_folder_that_others_may_write_is_not_used(home, mode):
    home.mkdir()
    home.chmod(mode)
    assert cache.folder() is None
    module = cache.load("x = 1\n")
    assert module.x == 1
    assert list(home.iterdir()) == []


@posix
def test_folder_of_somebody_else_is_not_used(home, monkeypatch):
    home.mkdir(mode=0o700)
    uid = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: uid + 1)
    assert cache.folder() is None


def test_folder_that_cannot_be_made_is_not_used(home, monkeypatch):
    home.parent.mkdir(exist_ok=True)
    home.write_text("a file")
    assert cache.folder() is None
    monkeypatch.setenv("RBS_CACHE", str(home / "below"))
    assert cache.folder() is None
    assert cache.load("x = 2\n").x == 2


@pytest.mark.parametrize("word", ["off", "OFF", "0"])
def test_off(home, monkeypatch, word):
    monkeypatch.setenv("RBS_CACHE", word)
    assert cache.folder() is None
    module = cache.load("x = 3\ncached = CACHE\n")
    assert (module.x, module.cached) == (3, False)
    assert module.__file__.startswith("<rbs ")
    assert not home.exists()


@pytest.mark.skipif(sys.platform == "win32", reason="XDG")
def test_default_folder(tmp_path, monkeypatch):
    monkeypatch.delenv("RBS_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache.folder() == tmp_path / "xdg" / "rbs"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(Path, "home", lambda: tmp_path / "me")
    assert cache.folder() == tmp_path / "me" / ".cache" / "rbs"


def test_module_is_written_once_and_kept_in_the_process(home):
    one = cache.load("x = 4\ncached = CACHE\n")
    assert (one.x, one.cached) == (4, True)
    assert cache.load("x = 4\ncached = CACHE\n") is one
    assert cache.load("x = 5\n") is not one
    files = sorted(path.name for path in home.glob("*.py"))
    assert len(files) == 2
    assert all(name.startswith("rbs_") for name in files)
    assert not list(home.glob("*.partial"))


def test_file_is_not_touched_when_it_is_right(home, monkeypatch):
    cache.load("x = 6\n")
    (path,) = home.glob("*.py")
    before = path.stat().st_mtime_ns
    monkeypatch.setattr(cache, "_loaded", {})
    assert cache.load("x = 6\n").x == 6
    assert path.stat().st_mtime_ns == before  # numba's own cache asks for this time


def test_tampered_file_is_never_run_but_written_again(home, monkeypatch):
    cache.load("x = 7\n")
    (path,) = home.glob("*.py")
    text = path.read_text(encoding="utf-8")
    path.write_text("raise SystemExit('a stranger wrote this')", encoding="utf-8")
    monkeypatch.setattr(cache, "_loaded", {})
    assert cache.load("x = 7\n").x == 7
    assert path.read_text(encoding="utf-8") == text


def test_objects_that_no_text_can_say_never_reach_the_disk(home):
    secret = object()
    module = cache.load("y = thing\n", {"thing": secret})
    assert module.y is secret
    assert not home.exists() or not list(home.iterdir())
    other = object()
    assert cache.load("y = thing\n", {"thing": other}).y is other  # and are not shared between laws


def test_traceback_shows_the_line_of_a_module_in_memory(monkeypatch):
    import traceback

    monkeypatch.setenv("RBS_CACHE", "off")
    monkeypatch.setattr(cache, "_loaded", {})
    module = cache.load("def broken():\n    return 1 // 0  # this very line\n")
    try:
        module.broken()
    except ZeroDivisionError:
        assert "this very line" in traceback.format_exc()


SCENE = """
import json, sys
import numpy as np
import rbs_core as rbs
from rbs_plugins import PairwiseForce
from rbs_plugins.fields import displacement, force_density

def law(stretch, c):
    return c * stretch * (1.0 + stretch)

part = rbs.Part("pair", rbs.Everywhere(), dimension=1)
part.place([[0.0], [1.0]], [2.0, 3.0], spacing=1.0).connect(1.5)
part[displacement] = np.array([[0.0], [0.5]])
force = PairwiseForce(part, law, c=4.0)
rbs.Analysis([force]).run(steps=1, dt=1.0, force_dt=True, progress=False)
module = force._loops._sum._keep
stats = getattr(module, "entry", None)
print(json.dumps({
    "force": part[force_density].ravel().tolist(),
    "hits": stats.cache_hits if stats else 0,
    "file": module.__file__,
}))
"""


def start(tmp_path, **environment):
    script = tmp_path / "scene.py"
    script.write_text(SCENE, encoding="utf-8")
    return subprocess.Popen(
        [sys.executable, str(script)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "RBS_CACHE": str(tmp_path / "cache"), **environment},
    )


def answer(process):
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    return json.loads(out)


def test_two_processes_at_once_and_a_third_that_need_not_compile(tmp_path):
    both = [answer(process) for process in [start(tmp_path), start(tmp_path)]]
    third = answer(start(tmp_path))
    wanted = [4.0 * 0.5 * 1.5 * 3.0, -4.0 * 0.5 * 1.5 * 2.0]
    for each in (*both, third):
        assert each["force"] == wanted
        assert each["file"] == both[0]["file"]
        assert Path(each["file"]).parent == tmp_path / "cache"
    assert third["hits"] == 1
    assert sum(each["hits"] for each in both) <= 1  # otherwise the third has proved nothing
    assert not list((tmp_path / "cache").glob("*.partial"))


def test_without_cache_a_process_compiles_for_itself(tmp_path):
    found = answer(start(tmp_path, RBS_CACHE="off"))
    assert found["force"] == [9.0, -6.0]
    assert found["hits"] == 0
    assert not (tmp_path / "cache").exists()


def test_without_compiler_the_same_law_and_loop_run_as_python(tmp_path):
    script = tmp_path / "plain.py"
    script.write_text(SCENE, encoding="utf-8")
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "RBS_CACHE": str(tmp_path / "cache")}
    shown = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, env=environment)
    assert shown.returncode == 0, shown.stderr
    assert json.loads(shown.stdout)["force"] == [9.0, -6.0]
