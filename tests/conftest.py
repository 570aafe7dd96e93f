"""What all tests share: a fresh analysis, numpy errors raised, seeded numbers, and the two flags of slow tests."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parent.parent
if str(ROOT) not in sys.path:  # so that `tests.scenes` and `simulations` can be imported, however pytest was called
    sys.path.insert(0, str(ROOT))

import rbs_core as rbs  # noqa: E402  not before the path above
from rbs_core.plugins import Registry, use_registry  # noqa: E402

# No deadline: the first example may compile a loop.
settings.register_profile("rbs", deadline=None)
settings.load_profile("rbs")

FLAGS = {"verify": "run long physics", "bench": "run measurements of speed"}


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds --verify and --bench."""
    for name, text in FLAGS.items():
        parser.addoption(f"--{name}", action="store_true", help=text)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Skips what is marked verify or bench, unless the flag of that name is given."""
    for item in items:
        for name in FLAGS:
            if name in item.keywords and not config.getoption(f"--{name}"):
                item.add_marker(pytest.mark.skip(reason=f"runs with --{name}"))


@pytest.fixture(autouse=True)
def analysis() -> Iterator[rbs.Analysis]:
    """A fresh current analysis, so that no scene leaks from one test into the next."""
    with rbs.Analysis() as fresh:
        yield fresh


@pytest.fixture(autouse=True)
def numpy_errors() -> Iterator[None]:
    """Divisions by zero, overflows and invalid numbers raise; results too small for a float may become zero."""
    with np.errstate(all="raise", under="ignore"):
        yield


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers, the same in every run."""
    return np.random.default_rng(20140305)


@pytest.fixture
def empty_registry() -> Iterator[Registry]:
    """A registry without any plugin, in place of the one of the process."""
    registry = Registry(discover=False)
    before = use_registry(registry)
    yield registry
    use_registry(before)
