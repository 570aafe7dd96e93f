"""What tests of the command line share."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest


@pytest.fixture
def file(tmp_path, monkeypatch) -> Iterator[Path]:
    """A copy of pulled_bar.py in a folder of its own; that `rbs run` makes it a module is taken back afterwards."""
    monkeypatch.setattr(sys, "path", list(sys.path))
    yield Path(shutil.copy(Path(__file__).with_name("pulled_bar.py"), tmp_path))
    for name in [name for name in sys.modules if name.startswith("pulled_")]:
        del sys.modules[name]
