"""The documentation is true: its code runs and prints what it says, commands parse, tables match the registry."""

from __future__ import annotations

import contextlib
import difflib
import doctest
import importlib.util
import inspect
import io
import re
from pathlib import Path

import pytest

import rbs_core
import rbs_plugins
from rbs_core import hookspecs
from rbs_core.command import _parser, main
from rbs_core.plugins import Registry
from rbs_core.testing import isolated_registry
from tests.documents.pages import (
    PAGES,
    ROOT,
    Block,
    blocks,
    commands,
    leads_somewhere,
    links,
    name_of,
    paths,
    pictures,
)

DOCS = ROOT / "docs"
CHECKER = doctest.OutputChecker()
LENIENT = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """A working directory of its own, with the third-party package of the tests within reach."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(ROOT / "tests" / "plugin_package"))
    return tmp_path


# -- code -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_code_runs_and_prints_what_the_page_says(page, folder):
    """All Python blocks of a page in one namespace; an `output` block is what the block before it has printed."""
    found = blocks(page)
    source = folder / f"{page.stem}.py"  # laws are looked up in it, and messages name the lines of the page
    source.write_text(only_code(page, found), encoding="utf-8")
    namespace = {"__name__": f"page_{page.stem}", "__file__": str(source)}
    printed: str | None = None
    for block in found:
        where = f"{name_of(page)}:{block.line}"
        if block.language == "output":
            assert printed is not None, f"{where}: no Python block before this output"
            assert CHECKER.check_output(block.text, printed, LENIENT), f"{where}:\n{difference(block.text, printed)}"
        if block.language != "python":
            continue
        if block.file is not None:
            write(block)
            continue
        with contextlib.redirect_stdout(io.StringIO()) as stream:
            exec(compile("\n" * block.line + block.text, str(source), "exec"), namespace)
        printed = stream.getvalue()


def write(block: Block) -> None:
    """Makes the file that a block shows."""
    assert block.file is not None
    Path(block.file).parent.mkdir(parents=True, exist_ok=True)
    Path(block.file).write_text(block.text, encoding="utf-8")


def only_code(page: Path, found: list[Block]) -> str:
    """The Python blocks of a page, every line at its place."""
    lines = [""] * len(page.read_text(encoding="utf-8").splitlines())
    for block in found:
        if block.language == "python":
            for number, line in enumerate(block.text.splitlines(), block.line):
                lines[number] = line
    return "\n".join(lines) + "\n"


def difference(page: str, printed: str) -> str:
    """Both texts side by side."""
    return "\n".join(difflib.unified_diff(page.splitlines(), printed.splitlines(), "page", "printed", lineterm=""))


# -- commands -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_commands_parse_and_name_what_exists(page, folder, capsys):
    """Long runs, and `show`, are only parsed; `list`, `describe` and runs of files that the page shows are executed."""
    shown = {block.file: block for block in blocks(page) if block.file is not None}
    for block in shown.values():
        write(block)
    for where, words in commands(page):
        options = _parser().parse_args(words[1:])
        if words[1] == "show":
            continue  # of runs that are not done here
        if words[1] != "run":
            assert main(words[1:]) == 0, f"{where}: {capsys.readouterr().err}"
            continue
        file = folder / options.file if options.file in shown else ROOT / options.file
        assert file.is_file(), f"{where}: there is no {options.file}"
        known = inspect.signature(scene_of(file)).parameters
        for name in (text.split("=")[0] for text in options.set):
            assert name in known, f"{where}: scene of {options.file} takes {', '.join(known)}"
        if options.file in shown:
            out = ["--out", str(folder / "out" / file.stem)]
            assert main([*words[1:], *([] if options.out else out), "--quiet"]) == 0, capsys.readouterr().err


def scene_of(file: Path):
    """The function `scene` of a file."""
    spec = importlib.util.spec_from_file_location(f"shown_{file.stem}", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.scene


def test_the_package_on_the_page_is_the_one_that_is_tested():
    """What howto_write_a_plugin.md shows is tests/plugin_package, letter by letter."""
    shown = [block for block in blocks(DOCS / "howto_write_a_plugin.md") if block.file is not None]
    assert len(shown) == 3
    for block in shown:
        real = (ROOT / "tests" / "plugin_package" / block.file).read_text(encoding="utf-8")
        text = block.text.split("\n", 1)[1]
        assert text == real, f"{block.file}:\n{difference(text, real)}"


def test_the_readme_says_how_to_start():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert "python -m pip install -e . && rbs run simulations/plate_with_crack.py\n" in text
    assert 'python -m pip install -e ".[test]" && python -m pytest\n' in text


# -- links and names ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_and_paths_lead_somewhere(page):
    missing = [target for target in links(page) if not leads_somewhere(page, target)]
    missing += [target for target in paths(page) if not (ROOT / target).exists()]
    assert not missing, f"{name_of(page)} names {missing}, which do not exist"


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_pictures_are_small(page):
    sizes = {picture.name: picture.stat().st_size for picture in pictures(page)}
    large = {name: size for name, size in sizes.items() if size > 150_000}
    assert not large, f"{name_of(page)} shows pictures of more than 150 kB: {large}"


def test_every_page_can_be_reached():
    pages = (ROOT / "README.md", DOCS / "README.md")
    reached = {(page.parent / target.split("#")[0]).resolve() for page in pages for target in links(page)}
    lost = [name_of(page) for page in PAGES[1:] if page not in reached and page.name != "index.md"]
    assert not lost, f"neither README.md nor docs/README.md links {lost}"


def test_hooks_are_documented_with_their_signatures():
    text = (DOCS / "reference_hooks.md").read_text(encoding="utf-8")
    specs = {name: each for name, each in vars(hookspecs).items() if name.startswith("rbs_")}
    assert len(specs) == 5
    for name, spec in specs.items():
        signature = f"def {name}{inspect.signature(spec)}".replace("'", "")
        assert f"\n{signature}\n" in text, f"docs/reference_hooks.md lacks the line {signature}"
    named = set(re.findall(r"\brbs_\w+(?=\()", text))
    assert named == set(specs), f"docs/reference_hooks.md knows hooks that nobody calls: {named - set(specs)}"


@pytest.fixture(scope="module")
def built_in() -> Registry:
    """What this project offers, without strangers that happen to be installed."""
    with isolated_registry(rbs_plugins) as found:
        return found


def test_the_table_of_fields_is_the_registry(built_in):
    text = (DOCS / "reference_fields.md").read_text(encoding="utf-8")
    rows = {
        f"| `{f.name}` | {f.symbol} | {f.at} | {f.shape} | {f.unit} | {f.doc} |" for f in built_in.fields().values()
    }
    missing = [row for row in sorted(rows) if row not in text]
    assert not missing, "docs/reference_fields.md lacks\n" + "\n".join(missing)


def test_every_relation_has_its_paragraph_contract_and_source(built_in):
    text = (DOCS / "reference_relations.md").read_text(encoding="utf-8")
    for name, relation in built_in.relations().items():
        found = re.search(rf"^### {name}\n(.*?)(?=^##|\Z)", text, flags=re.DOTALL | re.MULTILINE)
        assert found, f"docs/reference_relations.md has no paragraph ### {name}"
        paragraph = found.group(1)
        file = Path(inspect.getsourcefile(relation)).resolve().relative_to(ROOT).as_posix()
        wanted = [file, *declared(relation), *arguments(relation)]
        missing = [each for each in wanted if not re.search(rf"(?<!\w){re.escape(each)}(?!\w)", paragraph)]
        assert not missing, f"the paragraph of {name} does not name {missing}"


def declared(relation) -> list[str]:
    """Names of the fields that the class itself declares; those that depend on its arguments are told in words."""
    words = (getattr(relation, word) for word in ("reads", "writes", "updates", "adds", "offers"))
    return [field.name for word in words if isinstance(word, tuple) for field in word]


def arguments(relation) -> list[str]:
    """Names of the arguments, without those that every relation has."""
    return [name for name in inspect.signature(relation.__init__).parameters if name not in ("self", "part", "when")]


def signature_of(thing) -> str:
    """As it is written on a page: names and defaults, no types; of a field its name."""
    signature = inspect.signature(thing.__init__)
    bare = [p.replace(annotation=p.empty) for name, p in signature.parameters.items() if name != "self"]
    text = str(inspect.Signature(bare)).replace("'", '"')
    return re.sub(r'Field\("(\w+)", at=[^()]*\)', r"\1", text)


def test_signatures_of_relations_and_criteria_are_right(built_in):
    text = (DOCS / "reference_relations.md").read_text(encoding="utf-8")
    classes = [*built_in.relations().values(), rbs_plugins.CriticalStretch, rbs_plugins.Criterion]
    missing = [line for each in classes if (line := f"`{each.__name__}{signature_of(each)}`") not in text]
    assert not missing, "docs/reference_relations.md lacks\n" + "\n".join(missing)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_calls_name_arguments_that_exist(page):
    """Every `rbs.name(argument, other=...)` between backticks."""
    wrong = []
    for name, given in re.findall(r"`rbs((?:\.\w+)+)\(([^`()]*)\)`", page.read_text(encoding="utf-8")):
        called = rbs_core
        for step in name.split(".")[1:]:
            called = getattr(called, step)
        known = inspect.signature(called.__init__ if isinstance(called, type) else called).parameters
        names = [argument.split("=")[0].strip(" *") for argument in given.split(",")]
        wrong += [f"rbs{name}({each})" for each in names if each.isidentifier() and each not in known]
    assert not wrong, f"{name_of(page)}: {wrong}"


@pytest.mark.parametrize(
    ("page", "package"), [("reference_kernel.md", rbs_core), ("reference_relations.md", rbs_plugins)]
)
def test_every_public_name_is_on_its_page(page, package):
    text = (DOCS / page).read_text(encoding="utf-8")
    missing = [name for name in package.__all__ if not re.search(rf"(?<!\w){name}(?!\w)", text)]
    assert not missing, f"docs/{page} does not know {missing}"


def test_every_option_of_the_command_line_is_on_its_page():
    text = (DOCS / "reference_command_line.md").read_text(encoding="utf-8")
    groups = next(a for a in _parser()._actions if a.dest not in ("help",) and a.choices)
    for command, parser in groups.choices.items():
        assert f"`rbs {command}" in text, f"docs/reference_command_line.md does not know rbs {command}"
        for option in (o for action in parser._actions for o in action.option_strings if o not in ("-h", "--help")):
            assert f"`{option}" in text, f"docs/reference_command_line.md does not know {option} of rbs {command}"
