"""The site shows every public name; what builds it is loaded without Sphinx."""

from __future__ import annotations

import importlib.util

import pytest

import rbs_core
import rbs_plugins
from tests.documents.pages import PAGES, ROOT


@pytest.fixture(scope="module")
def conf():
    """The module docs/conf.py."""
    spec = importlib.util.spec_from_file_location("conf", ROOT / "docs" / "conf.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("package", [rbs_core, rbs_plugins], ids=["core", "plugins"])
def test_every_public_name_is_on_a_page_of_names(conf, package):
    shown = {place for page in PAGES for place in conf.places(page.read_text(encoding="utf-8"))}
    names = [name for name in package.__all__ if not hasattr(getattr(package, name), "__path__")]
    names = [name for name in names if type(getattr(package, name)).__name__ != "module"]
    missing = [name for name in names if (package.__name__, name) not in shown]
    assert not missing, f"no page docs/names_*.md shows {missing} of {package.__name__}"


def test_pages_are_in_one_of_the_tables_of_contents():
    kinds = [line for line in (ROOT / "docs" / "index.md").read_text(encoding="utf-8").splitlines() if "*" in line]
    shown = {path for kind in kinds for path in (ROOT / "docs").glob(f"{kind}.md")}
    lost = [page.name for page in PAGES if page.parent.name == "docs" and page not in shown]
    assert sorted(lost) == ["README.md", "index.md"]


def test_text_of_docstrings_means_what_it_says(conf):
    lines = ["Energy of |y| with `a *b`", "and **options, name_ of `x_`."]
    conf.as_restructured_text(None, "function", "f", None, None, lines)
    assert lines == ["Energy of \\|y\\| with ``a *b``", "and \\*\\*options, name\\_ of ``x_``."]
