"""The way of a newcomer: from an empty folder through the tutorial to its picture, in processes of their own."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.documents.pages import ROOT, blocks, commands, pictures

TUTORIAL = ROOT / "docs" / "tutorial_first_scene.md"
PNG = b"\x89PNG\r\n\x1a\n"


def walk(folder: Path, python: Path, environment: dict[str, str]) -> None:
    """Does what the page says: one script of all its blocks, the files it shows, and the commands behind them."""
    found = [block for block in blocks(TUTORIAL) if block.language == "python"]
    for block in found:
        if block.file is not None:
            (folder / block.file).write_text(block.text, encoding="utf-8")
    script = "\n".join(block.text for block in found if block.file is None)
    (folder / "first_scene.py").write_text(script, encoding="utf-8")
    steps = [["first_scene.py"], *(["-m", "rbs_core", *words[1:]] for _, words in commands(TUTORIAL))]
    assert len(steps) == 3
    for step in steps:
        done = subprocess.run(
            [python, *step], cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False
        )
        assert done.returncode == 0, f"{step}: {done.stderr}"
    drawn = [folder / "out" / "damage_000183.png", *(folder / "out").glob("*/damage_*.png")]
    assert len(drawn) == 3
    assert all(file.read_bytes().startswith(PNG) for file in drawn)
    assert sorted(path.name for path in folder.iterdir()) == ["first_scene.py", "out", "small_plate.py"]


def test_from_an_empty_folder_to_a_picture(tmp_path):
    walk(tmp_path, Path(sys.executable), {**os.environ, "PYTHONPATH": str(ROOT)})
    assert [picture.name for picture in pictures(TUTORIAL)] == ["first_scene.png"]


@pytest.mark.verify
def test_the_same_with_the_package_installed_by_pip(tmp_path):
    """Not in place: into an environment of its own, with all that it depends on."""
    source, home, folder = tmp_path / "rbs", tmp_path / "environment", tmp_path / "empty"
    source.mkdir()
    folder.mkdir()
    for name in ("rbs_core", "rbs_plugins"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(ROOT / name, source)
    python = home / ("Scripts" if os.name == "nt" else "bin") / "python"
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    for command in (
        [sys.executable, "-m", "venv", home],
        [python, "-m", "pip", "install", "--quiet", source],
    ):
        subprocess.run(command, check=True, env=clean, timeout=600)
    where = [python, "-c", "import rbs_core, rbs_plugins; print(rbs_core.__file__, rbs_plugins.__file__)"]
    found = subprocess.run(where, check=True, env=clean, cwd=folder, capture_output=True, text=True).stdout
    assert found.count(str(home)) == 2
    walk(folder, python, clean)
