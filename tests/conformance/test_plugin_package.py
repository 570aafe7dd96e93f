"""A third-party package: passes the public suite from its folder, and is discovered where pip has installed it."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

import rbs_core as rbs
import rbs_plugins
from rbs_core.testing import isolated_registry
from rbs_plugins import StrainEnergy
from rbs_plugins.fields import displacement, force_density, strain_energy
from rbs_plugins.testing import conformance

FOLDER = Path(__file__).resolve().parent.parent / "plugin_package"


def granite():
    """The module, from its folder unless it is installed."""
    if str(FOLDER) not in sys.path:
        sys.path.append(str(FOLDER))
    return importlib.import_module("rbs_granite")


granite()
test_granite = conformance("rbs_granite")


def installed():
    return any(point.name == "granite" for point in metadata.entry_points(group="rbs"))


def test_offers_its_relation_beside_the_built_in_ones():
    with isolated_registry(rbs_plugins, granite()) as found:
        names = found.relations()
        assert names["Granite"] is granite().Granite
        assert "BondBased" in names
        assert "Granite" in found.providers(force_density)


def test_pulls_and_holds_what_its_law_says():
    """Two nodes, seven stretches: force and energy against the triangle drawn by hand."""
    E, s_yield, s_break, size = 50e9, 1e-3, 3e-3, 0.1
    pair = rbs.Part("pair", rbs.Everywhere(), dimension=1)
    pair.place([[0.0], [size]], [2e-4, 5e-4], spacing=size, area=0.01).connect(1.5 * size)
    c = 2 * E / (0.01 * (1.5 * size) ** 2)
    rock = granite().Granite(pair, E, s_yield, s_break)
    energy = StrainEnergy(pair, [rock])
    analysis = rbs.Analysis([rock, energy])
    pair[displacement] = 0.0
    analysis.prepare()
    for stretch in (-2e-3, -1e-4, 0.5e-3, 1e-3, 1.5e-3, 2.5e-3, 2.9e-3):
        pair[displacement] = [[0.0], [stretch * size]]
        pair[force_density][...] = 0.0
        for relation in (rock, energy):
            relation.begin(analysis.clock)
            relation.apply(analysis.clock)
        peak = c * s_yield
        force = c * stretch if stretch < s_yield else peak * (s_break - stretch) / (s_break - s_yield)
        if stretch < s_yield:
            area = c * stretch**2 / 2
        else:
            area = peak * (s_break - 0.0) / 2 - force * (s_break - stretch) / 2
        # a stretch is known to an ulp of 1
        np.testing.assert_allclose(pair[force_density][:, 0], [force * 5e-4, -force * 2e-4], atol=4e-16 * c * 5e-4)
        assert pair[strain_energy] == pytest.approx(area * size * 2e-4 * 5e-4, rel=1e-11)


@pytest.mark.skipif(not installed(), reason="rbs-granite is not installed: pip install tests/plugin_package")
def test_installed_package_is_discovered_in_a_new_process():
    code = "import rbs_core as rbs; print(sorted(rbs.registry().relations()))"
    environment = {name: value for name, value in os.environ.items() if name != "RBS_PLUGINS"}
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True)
    assert "Granite" in shown.stdout
    off = {**environment, "RBS_PLUGINS": "-granite"}
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=off, check=True)
    assert "Granite" not in shown.stdout
    assert "BondBased" in shown.stdout


def test_installs_and_is_found(tmp_path):
    """Built without network, put into a folder of its own, found through its entry point, passes its own two lines."""
    source = tmp_path / "source"
    (source / "tests").mkdir(parents=True)
    for name in ("pyproject.toml", "rbs_granite.py", "README.md", "tests/test_granite.py"):
        (source / name).write_text((FOLDER / name).read_text(encoding="utf-8"), encoding="utf-8")
    target = tmp_path / "site"
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation", "--no-index"]
    made = subprocess.run(
        [*pip, "--disable-pip-version-check", "--target", str(target), str(source)], capture_output=True, text=True
    )
    if made.returncode and "No module named pip" in made.stderr:
        pytest.skip("this environment has no pip")
    if "invalid command 'bdist_wheel'" in made.stderr:
        pytest.skip("without network this needs the package wheel, or setuptools 70.1 or newer")
    assert made.returncode == 0, made.stderr
    path = os.pathsep.join(filter(None, [str(target), os.environ.get("PYTHONPATH", "")]))
    environment = {**os.environ, "PYTHONPATH": path, "RBS_PLUGINS": ""}
    code = (
        "import rbs_core as rbs; found = rbs.registry(); print(found.relations()['Granite'], found.sources['granite'])"
    )
    shown = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, env=environment, cwd=tmp_path
    )
    assert shown.returncode == 0, shown.stderr
    assert str(target) in shown.stdout
    tested = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", "2D", str(source / "tests")],
        capture_output=True, text=True, env=environment, cwd=tmp_path,
    )  # fmt: skip
    assert tested.returncode == 0, tested.stdout
    assert " passed" in tested.stdout
