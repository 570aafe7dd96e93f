"""What all tests share: a fresh analysis, numpy errors raised, seeded numbers, and the two flags of slow tests."""

from __future__ import annotations

import re
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

# With --verify only: tests whose loops take long to compile, and that look at more kinds of what others look at.
LONGER = re.compile(
    r"""
    test_(correspondence_suite|strength|crossing|surface|plane_waves|fracture_energy)\.py
    | test_(recipe_vectorised|loop_together|drive|lattice_(agrees|skips|changes))\.py
    | test_functions\.py::test_a_law
    | test_correspondence\.py::test_(softened_bonds|a_law_of_ones_own|bonds_that_soften)
    | test_correspondence_hold\.py::test_nothing_moves_on\[1
    | test_stabilization\.py::test_control_by_family
    | tangents/test_ordinary\.py::test_(another_material|parts_that_are)
    | tangents/test_pairwise\.py::test_a_law_that_asks\S*its_slope
    | test_cases\.py::test_particles_as_parts
    | test_pairwise\.py::test_forces_and\S*3-grid-linear
    | test_pairwise_by_hand\.py::test_(quadrature_of_a_kink|stable_step_takes)
    | test_ordinary\.py::test_(any_strain\S*\[(3-D|strain)|a_criterion_may)
    | test_solids\.py::test_nooru_mohamed_coarse
    | test_documents\.py::test_code_runs\S*howto_(write_a_law|several_parts)
    | test_command_sessions\.py::test_a_session\[(interrupted|help)
    | test_run_process\.py::test_(exit_codes|list_and|quiet)
    | test_correspondence\.py::test_(strain_and_stress_break|checkerboard|plastic_strains|nodes_that_lose|bar_yields)
    | test_correspondence\.py::test_uniform_deformation_is_exact\[(1|3|2-(stress|strain)-lattice)
    | test_dilatation\.py::test_the_trace\S*\[(linear|conical|inverse_fourth|hyperbolic|exponential)
    | test_ordinary\.py::test_(growth\S*\[3|the_bond_based\S*\[3|the_energy_balance\S*\[0\.3)
    | test_pairwise\.py::test_(stable_step\S*\[[13]|breaking\S*\[[13]|forces_and\S*\[(1|3-jittered|2-grid-none))
    | test_pairwise_by_hand\.py::test_quadrature\S*\[exponential
    | test_fracture\.py::test_the_energy_balance\S*\[both-next
    | test_lattice\.py::test_both_representations_agree\[(partial|late|no-fail|fields|everything-3)
    | test_loop_plain\.py::\S*\[(one\ lattice|several)
    | test_failure\.py::test_(mean_energy|secant|work_of|energies)
    | test_strain\.py::test_affine\S*\[(constant-1-[gjs]|constant-3-[gjs]|conical-[13]|conical-2-[gs])
    | test_stress\.py::test_it_is_the_sum\S*\[(1|3|2-grid)
    | test_stress\.py::test_in_a_uniform\S*\[(1|2-Bond\S*list|2-Ord\S*list|3-Ord)
    | test_separation\.py::test_quadrature\S*\[3
    | test_corrections\.py::test_shares\S*\[3-0\.0001-[01]
    | test_contact\.py::test_an_elastic\S*\[[13]
    | test_motion\.py::test_many_turns
    | test_energy\.py::test_strain_energy_of_a\S*\[[13]
    | test_j_integral\.py::test_it_is_the\S*Ordinary
    | test_cases\.py::test_polymer_composite_coarse
    | test_statics\.py::test_(three_point_bending|sarego_moduli)_coarse
    | test_threads\.py::test_one_two_and_four
    | test_solids\.py::test_(semicircular_bend_coarse|diagonal|sarego|nooru_mohamed_coarse\[(bond|nodal))
    | test_cases\.py::test_plate_with_crack_coarse  # the plate itself runs at full size in CI
    | test_plugin_package\.py::test_granite  # so does the own test of the package
    | test_recipe_linear\.py::test_(forces\S*(list|solid)|list\S*solid|the_energy)
    | test_command_sessions\.py::test_a_session\[(wrong|run_and|failing)
    | test_memory\.py::test_(each_part|a_scene\S*(single|False|True-list|True-lattice-[12]))
    | test_bars\.py::test_aluminium_bar_coarse\[correspondence
    | test_documents\.py::test_code_runs\S*explain_extremes
    """,
    re.VERBOSE,
)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds --verify and --bench."""
    for name, text in FLAGS.items():
        parser.addoption(f"--{name}", action="store_true", help=text)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Skips what is marked verify or bench, unless the flag of that name is given."""
    for item in items:
        if LONGER.search(item.nodeid):
            item.add_marker(pytest.mark.verify)
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
