"""The physics of RBS: constitutive models, integrators, boundary domains, measures and exporters.

Everything here enters through the same door as a stranger's package: the entry point and the hooks at the end.
"""

from __future__ import annotations

from collections.abc import Iterable

import rbs_core as rbs
from rbs_plugins import fields
from rbs_plugins.boundary.contact import ShortRangeRepulsion
from rbs_plugins.boundary.damping import ViscousDamping
from rbs_plugins.boundary.domain import BoundaryDomain
from rbs_plugins.boundary.motion import Rotation, Translation
from rbs_plugins.boundary.search import Search
from rbs_plugins.constitutive.bond_based import BondBased
from rbs_plugins.constitutive.fracture import Criterion, CriticalStretch, Damage
from rbs_plugins.constitutive.pairwise import PairwiseForce
from rbs_plugins.constitutive.strength import Weibull
from rbs_plugins.exporters.picture import PictureExporter
from rbs_plugins.exporters.table import CSVExporter, read_table
from rbs_plugins.exporters.vtk import VTKExporter
from rbs_plugins.exporters.vtkhdf import VTKHDFExporter
from rbs_plugins.integrators.explicit import Drift, Kick, SymplecticEuler, VelocityVerlet
from rbs_plugins.measures import FractureDissipation, KineticEnergy, StrainEnergy

__all__ = [
    "BondBased",
    "BoundaryDomain",
    "CSVExporter",
    "Criterion",
    "CriticalStretch",
    "Damage",
    "Drift",
    "FractureDissipation",
    "Kick",
    "KineticEnergy",
    "PairwiseForce",
    "PictureExporter",
    "Rotation",
    "Search",
    "ShortRangeRepulsion",
    "StrainEnergy",
    "SymplecticEuler",
    "Translation",
    "VTKExporter",
    "VTKHDFExporter",
    "VelocityVerlet",
    "ViscousDamping",
    "Weibull",
    "fields",
    "read_table",
]


@rbs.hookimpl
def rbs_relations() -> Iterable[type[rbs.Relation]]:
    """The built-in relations."""
    return [
        PairwiseForce, BondBased, ShortRangeRepulsion, Search, Damage, Kick, Drift, BoundaryDomain, ViscousDamping,
        Translation, Rotation, KineticEnergy, StrainEnergy, FractureDissipation, VTKExporter, VTKHDFExporter,
        CSVExporter, PictureExporter,
    ]  # fmt: skip


@rbs.hookimpl
def rbs_fields() -> Iterable[rbs.Field]:
    """The built-in vocabulary."""
    return fields.VOCABULARY


@rbs.hookimpl
def rbs_geometries() -> Iterable[type[rbs.Geometry]]:
    """The geometries of the kernel."""
    return [rbs.Box, rbs.Ball, rbs.HalfSpace, rbs.Everywhere, rbs.Nowhere, rbs.Where]
