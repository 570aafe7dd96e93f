"""Files stay short, packages stay silent, and tests stand where their sources stand."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from tests.guards.sources import ROOT, files

MOST_LINES = 350
EVERYTHING = ("rbs_core", "rbs_plugins", "simulations", "tests")
SPEAKING = {"rbs_core/command", "rbs_core/__main__.py"}  # the command line talks to people
MIRRORS = {"tests/unit/core": "rbs_core", "tests/unit/plugins": "rbs_plugins"}


def relative(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("folder", EVERYTHING)
def test_no_file_is_longer_than_a_person_reads(folder):
    lengths = {relative(path): len(path.read_text(encoding="utf-8").splitlines()) for path in files(folder)}
    long = {name: lines for name, lines in lengths.items() if lines > MOST_LINES}
    assert not long, f"longer than {MOST_LINES} lines: {long}"


def test_only_the_command_line_prints():
    """Everything else speaks through the logger, warnings and errors."""
    wrong = [
        f"{relative(path)}:{node.lineno}"
        for path in files("rbs_core", "rbs_plugins")
        if not SPEAKING.intersection([relative(path), relative(path.parent)])
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Name) and node.id == "print"
    ]
    assert not wrong, f"print in {wrong}"


@pytest.mark.parametrize("folder", MIRRORS)
def test_unit_tests_stand_where_their_sources_stand(folder):
    """tests/unit/core/part/test_views.py tests rbs_core/part/views.py; test_views_<aspect>.py does so too."""
    wrong = []
    for path in files(folder):
        if not path.name.startswith("test_"):
            continue  # helpers
        place = ROOT / MIRRORS[folder] / path.parent.relative_to(ROOT / folder)
        words = path.stem.removeprefix("test_").split("_")
        names = ["_".join(words[:count]) for count in range(1, len(words) + 1)]
        if place.name in names:  # tests of the package itself
            names.append("__init__")
        if not any((place / f"{name}.py").exists() or (place / name / "__init__.py").exists() for name in names):
            wrong.append(f"{relative(path)}: no {relative(place)}/{'_'.join(words)}.py")
    assert not wrong, "\n".join(wrong)


def test_the_kernel_is_tested_file_by_file():
    """Modules whose tests stand elsewhere: `python -m` is run, the checks for plugin authors check themselves."""
    elsewhere = {"rbs_core/__main__.py", "rbs_core/testing.py"}
    missing = []
    for path in files("rbs_core"):
        name = relative(path)
        folder = ROOT / "tests" / "unit" / "core" / path.parent.relative_to(ROOT / "rbs_core")
        if path.name != "__init__.py" and name not in elsewhere and not list(folder.glob(f"test_{path.stem}*.py")):
            missing.append(name)
    assert not missing, f"without a test file: {missing}"
