"""Two revisions on one machine: the same rows of this benchmark with either package, in turn; prints what moved."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from bench import CORES, ROOT, Figures, row

MOVED = 0.10
ROWS = [
    ("scene", "plate", "503", "lattice"), ("scene", "plate", "503", "lattice", "single"),
    ("scene", "plate", "503", "list"), ("scene", "cube", "60", "lattice"), ("scene", "cube", "60", "list"),
    ("law", "300"), ("parts", "bond-based", "500"), ("frame", "503"), ("case", "500"),
]  # fmt: skip
QUICK = [("scene", "plate", "60", "lattice"), ("scene", "plate", "60", "list")]
ROUNDS = 3


def compare(revision: str, *, quick: bool = False) -> None:
    """Measures a revision and the working tree in turn, and prints figures whose best moved by more than a tenth."""
    with tempfile.TemporaryDirectory() as folder:
        other = Path(folder) / "other"
        _git("worktree", "add", "--detach", "--quiet", str(other), revision)
        try:
            for key in QUICK if quick else ROWS:
                _compare_row(key, other)
        finally:
            _git("worktree", "remove", "--force", str(other))


def _compare_row(key: tuple[str, ...], other: Path) -> None:
    before: list[Figures] = []
    after: list[Figures] = []
    for _ in range(ROUNDS):
        for package, found in ((other, before), (ROOT, after)):
            try:
                found.append(row(*key, package=package))
            except SystemExit as error:  # a row that a revision does not know yet
                where = "the other revision" if package is other else "the working tree"
                print(f"{' '.join(key)}: cannot be measured with {where}: {str(error).strip().splitlines()[-1]}")
                return
    lines = []
    for name in sorted(before[0].keys() & after[0].keys()):
        if name.endswith(("_median", "_largest", "_1_best")) and CORES > 1:
            continue
        old, new = (min(figures[name] for figures in found) for found in (before, after))
        if old > 0 and abs(new / old - 1) > MOVED:
            lines.append(f"  {name:<24} {old:.4g} -> {new:.4g}  ({new / old - 1:+.0%})")
    print(f"{' '.join(key)}: {'nothing moved' if not lines else ''}", *lines, sep="\n" if lines else "", flush=True)


def _git(*arguments: str) -> None:
    done = subprocess.run(["git", "-C", str(ROOT), *arguments], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr.strip())
