"""The whole extension API: five hooks, called with keyword arguments, none of them in every step.

Work done in every step is a relation, so that its place in the order and its cost are visible. No hook stops at the
first result: the order of plugins carries no meaning.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import pluggy

if TYPE_CHECKING:
    from rbs_core.analysis import Analysis
    from rbs_core.fields import Field
    from rbs_core.geometry import Geometry
    from rbs_core.relation import Relation
    from rbs_core.report import Report

hookspec = pluggy.HookspecMarker("rbs")
hookimpl = pluggy.HookimplMarker("rbs")


@hookspec
def rbs_relations() -> Iterable[type[Relation]]:  # type: ignore[empty-body]
    """The relation classes that this plugin offers."""


@hookspec
def rbs_fields() -> Iterable[Field]:  # type: ignore[empty-body]
    """The fields that this plugin adds to the vocabulary; laws may ask for them by name."""


@hookspec
def rbs_geometries() -> Iterable[type[Geometry]]:  # type: ignore[empty-body]
    """The geometry classes that this plugin offers."""


@hookspec
def rbs_analysis_started(analysis: Analysis) -> None:
    """Called after allocation and compilation, before the first step."""


@hookspec
def rbs_analysis_finished(analysis: Analysis, report: Report) -> None:
    """Called after the last step, an interruption or an error."""
