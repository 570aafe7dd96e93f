"""Physics conformance: what every relation must do, whoever wrote it.

A plugin author needs two lines in a test file:

    from rbs_plugins.testing import conformance
    test_granite = conformance("rbs_granite")

Every check is a plain function that can be called on its own, see `forces`, `tangents` and `scenes`.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import rbs_core as rbs
from rbs_core.testing import isolated_registry
from rbs_plugins.testing.forces import (
    FORCES,
    check_angular_momentum,
    check_breaking,
    check_energy,
    check_mirror,
    check_momentum,
    check_objectivity,
    check_permutation,
    check_rest,
    check_rigid_motion,
    check_stable_step,
    check_threads,
    rotation,
)
from rbs_plugins.testing.scenes import (
    SCENES,
    check_going_on,
    check_order,
    check_scene,
    check_storages,
    measured_order,
    scene_of,
)
from rbs_plugins.testing.specimen import CLOUDS, FEW, MANY, NotApplicable, RelationClass, Specimen, again, body, ends
from rbs_plugins.testing.tangents import TANGENTS, check_tangent, check_tangent_matrix, check_tangent_threads


@dataclass(frozen=True)
class Case:
    """One check of one relation, to be run as a test."""

    check: Callable[..., None]
    relation_class: RelationClass
    dimension: int
    cloud: str
    plugin: Any = None

    @property
    def name(self) -> str:
        """Identifies the test."""
        check = self.check.__name__.removeprefix("check_")
        return f"{self.relation_class.__name__}-{check}-{self.dimension}D-{self.cloud}"

    def run(self) -> None:
        """Raises AssertionError, an error of the kernel, or NotApplicable."""
        with _registered(self.plugin):
            self.check(self.relation_class, self.dimension, self.cloud)


def cases(what: str | Sequence[RelationClass] | None = None) -> list[Case]:
    """Every check of every relation; what is as in `conformance`."""
    plugin = importlib.import_module(what) if isinstance(what, str) else None
    if plugin is not None:
        with isolated_registry(plugin) as found:
            classes = list(found.relations().values())
        assert classes, f"{what} offers no relation: does it have an @rbs.hookimpl function rbs_relations?"
    else:
        classes = list(rbs.registry().relations().values()) if what is None else list(what)  # type: ignore[arg-type]
    made = []
    for each in classes:
        forces = FORCES if each.role == "constitutive" else {}
        for check, dimensions in forces.items():
            made += [Case(check, each, d, cloud, plugin) for d in dimensions for cloud in _clouds(d)]
        for check, clouds in {**SCENES, **(TANGENTS if hasattr(each, "tangent") else {})}.items():
            made += [Case(check, each, d, cloud, plugin) for d in (1, 2, 3) for cloud in clouds if cloud in _clouds(d)]
    return made


def _clouds(dimension: int) -> tuple[str, ...]:
    """All clouds in 2-D; single precision, which is the same code in every dimension, not in the others."""
    return tuple(cloud for cloud in CLOUDS if dimension == 2 or cloud != "single")


def conformance(
    what: str | Sequence[RelationClass] | None = None, *, marks: Callable[[Case], Sequence[Any]] = lambda _: ()
) -> Callable[..., None]:
    """A pytest function, parametrised over every check of every relation.

    Args:
        what: name of the module of a plugin, or relation classes; everything that is registered if not given.
        marks: pytest marks of a case, e.g. to leave some of them to longer runs.
    """
    import pytest

    every = [pytest.param(case, id=case.name, marks=marks(case)) for case in cases(what)]

    @pytest.mark.parametrize("case", every)
    def test(case: Case) -> None:
        try:
            case.run()
        except NotApplicable as reason:
            pytest.skip(str(reason))

    return test


@contextmanager
def _registered(plugin: Any) -> Iterator[None]:
    """For the length of a block a registry that knows the plugin, so that laws may ask for its fields by name."""
    if plugin is None or rbs.registry().manager.is_registered(plugin):
        yield
        return
    import rbs_plugins

    with isolated_registry(*dict.fromkeys([rbs_plugins, plugin])):
        yield


__all__ = [
    "CLOUDS",
    "FEW",
    "MANY",
    "Case",
    "NotApplicable",
    "Specimen",
    "again",
    "body",
    "cases",
    "check_angular_momentum",
    "check_breaking",
    "check_energy",
    "check_going_on",
    "check_mirror",
    "check_momentum",
    "check_objectivity",
    "check_order",
    "check_permutation",
    "check_rest",
    "check_rigid_motion",
    "check_scene",
    "check_stable_step",
    "check_storages",
    "check_tangent",
    "check_tangent_matrix",
    "check_tangent_threads",
    "check_threads",
    "conformance",
    "ends",
    "measured_order",
    "rotation",
    "scene_of",
]
