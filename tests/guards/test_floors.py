"""The house has floors: a module imports only from below, so that every part can be read without those above it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.guards.sources import ROOT, files, imports, module_of

# A module may import from floors with a smaller number; inside of a package of several modules, from its own.
FLOORS = {
    "rbs_core.errors": 0,
    "rbs_core.files": 1,
    "rbs_core.interrupt": 1,
    "rbs_core.trigger": 1,
    "rbs_core.memory": 1,
    "rbs_core.report": 2,
    "rbs_core.space": 2,
    "rbs_core.geometry": 3,
    "rbs_core.fields": 3,
    "rbs_core.part": 4,
    "rbs_core.relation": 5,
    "rbs_core.roles": 6,
    "rbs_core.schedule": 6,
    "rbs_core.contract": 6,
    "rbs_core.honesty": 6,
    "rbs_core.stability": 6,
    "rbs_core.held": 6,
    "rbs_core.checkpoint": 7,
    "rbs_core.steps": 7,
    "rbs_core.hookspecs": 7,
    "rbs_core.plugins": 8,
    "rbs_core.analysis": 9,
    "rbs_core.testing": 10,
    "rbs_core.command": 10,
    "rbs_core.__main__": 11,
    "rbs_core": 12,  # the public names: for everybody outside, and nobody inside
}
PACKAGES = ("rbs_core.space", "rbs_core.geometry", "rbs_core.part", "rbs_core.report", "rbs_core.command")

# Above each package stand others that it must not know.
ABOVE = {
    "rbs_core": ("rbs_plugins", "simulations", "tests"),
    "rbs_plugins": ("simulations", "tests"),
    "simulations": ("tests",),
}

HEAVY = ("meshio", "pyvista", "vtk", "vtkmodules", "h5py", "matplotlib")
COMPILED = ("rbs_core.part.search",)  # the only modules of the kernel that may import numba


def floor_of(module: str) -> tuple[str, int]:
    """The longest name on the list that a module belongs to, and its floor."""
    names = [name for name in FLOORS if module == name or (module.startswith(f"{name}.") and name != "rbs_core")]
    assert names, f"{module} has no floor: put it on the list in {__name__}"
    name = max(names, key=len)
    return name, FLOORS[name]


def at(path: Path, line: int) -> str:
    return f"{path.relative_to(ROOT)}:{line}"


@pytest.mark.parametrize("path", files("rbs_core"), ids=module_of)
def test_the_kernel_imports_only_from_below(path):
    own, floor = floor_of(module_of(path))
    wrong = []
    for line, module, _ in imports(path):
        if module.split(".")[0] != "rbs_core":
            continue
        other, below = floor_of(module)
        if below >= floor and not (own == other and own in PACKAGES):
            wrong.append(f"{at(path, line)}: floor {floor} imports {module} of floor {below}")
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("package", ABOVE)
def test_nobody_looks_up(package):
    wrong = [
        f"{at(path, line)}: {package} imports {module}"
        for path in files(package)
        for line, module, _ in imports(path)
        if module.split(".")[0] in ABOVE[package]
    ]
    assert not wrong, "\n".join(wrong)


def test_the_kernel_is_light():
    """Pictures and file formats are no business of the kernel; numba is loaded by the bond search alone."""
    wrong = []
    for path in files("rbs_core"):
        for line, module, top in imports(path):
            name = module.split(".")[0]
            if (name in HEAVY and top) or (name == "numba" and module_of(path) not in COMPILED):
                wrong.append(f"{at(path, line)}: imports {name}")
            if module in COMPILED and top:
                wrong.append(f"{at(path, line)}: imports {module} at the top, so `import rbs_core` would load numba")
    assert not wrong, "\n".join(wrong)


def test_every_module_of_the_kernel_has_a_floor():
    known = {floor_of(module_of(path))[0] for path in files("rbs_core")}
    gone = {name for name in FLOORS if not (ROOT / name.replace(".", "/")).is_dir()} - known
    assert not gone, f"{sorted(gone)} stand on the list and are no modules any more"


def test_the_guard_sees_what_it_should(tmp_path, monkeypatch):
    """A guard that finds nothing may be blind: it must find these."""
    monkeypatch.setattr("tests.guards.sources.ROOT", tmp_path)
    folder = tmp_path / "rbs_core" / "part"
    folder.mkdir(parents=True)
    (folder / "__init__.py").touch()
    (tmp_path / "rbs_core" / "analysis.py").touch()
    file = folder / "views.py"
    file.write_text(
        "from typing import TYPE_CHECKING\n"
        "import numba.core, os\n"
        "if TYPE_CHECKING:\n    from rbs_core.analysis import Analysis\nelse:\n    import json\n"
        "def late():\n    from rbs_core import analysis, Part\n"
        "class Inner:\n    from .. import analysis\n    from . import views\n"
    )
    assert list(imports(file)) == [
        (1, "typing", True),
        (2, "numba.core", True),
        (2, "os", True),
        (6, "json", True),
        (8, "rbs_core.analysis", False),
        (8, "rbs_core", False),
        (10, "rbs_core.analysis", True),
        (11, "rbs_core.part.views", True),
    ]
