"""The physics of RBS: constitutive models, integrators, boundary domains, measures and exporters.

Everything here enters through the same door as a stranger's package: the entry point and the hooks at the end.
"""

from __future__ import annotations

from collections.abc import Iterable

import rbs_core as rbs
from rbs_plugins import fields
from rbs_plugins.boundary.contact import ShortRangeRepulsion
from rbs_plugins.boundary.domain import BoundaryDomain
from rbs_plugins.boundary.motion import Rotation, Translation
from rbs_plugins.boundary.search import Search
from rbs_plugins.constitutive.bond_based import BondBased
from rbs_plugins.constitutive.correspondence import Correspondence
from rbs_plugins.constitutive.deformation_criteria import (
    CriticalEquivalentStrain,
    CriticalShearStrain,
    CriticalVolumetricStrain,
    MaximumPrincipalStress,
)
from rbs_plugins.constitutive.fracture import Criterion, CriticalStretch, Damage
from rbs_plugins.constitutive.pairwise import PairwiseForce
from rbs_plugins.constitutive.softening import BondSoftening
from rbs_plugins.constitutive.stabilization import SillingControl, WanControl
from rbs_plugins.exporters.picture import PictureExporter
from rbs_plugins.exporters.table import CSVExporter, read_table
from rbs_plugins.exporters.vtk import VTKExporter
from rbs_plugins.exporters.vtkhdf import VTKHDFExporter
from rbs_plugins.integrators.explicit import Drift, Kick, SymplecticEuler, VelocityVerlet
from rbs_plugins.measures import FractureDissipation, KineticEnergy, StrainEnergy

__all__ = [
    "BondBased",
    "BondSoftening",
    "BoundaryDomain",
    "CSVExporter",
    "Correspondence",
    "Criterion",
    "CriticalEquivalentStrain",
    "CriticalShearStrain",
    "CriticalStretch",
    "CriticalVolumetricStrain",
    "Damage",
    "Drift",
    "FractureDissipation",
    "Kick",
    "KineticEnergy",
    "MaximumPrincipalStress",
    "PairwiseForce",
    "PictureExporter",
    "Rotation",
    "Search",
    "ShortRangeRepulsion",
    "SillingControl",
    "StrainEnergy",
    "SymplecticEuler",
    "Translation",
    "VTKExporter",
    "VTKHDFExporter",
    "VelocityVerlet",
    "WanControl",
    "fields",
    "read_table",
]


@rbs.hookimpl
def rbs_relations() -> Iterable[type[rbs.Relation]]:
    """The built-in relations."""
    return [
        PairwiseForce, BondBased, Correspondence, ShortRangeRepulsion, Search, Damage, Kick, Drift, BoundaryDomain,
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
