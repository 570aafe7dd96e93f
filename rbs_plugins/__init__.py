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
from rbs_plugins.boundary.pressure import Pressure
from rbs_plugins.boundary.search import Search
from rbs_plugins.constitutive.bond_based import BondBased
from rbs_plugins.constitutive.bond_energy import BondEnergy, MeanBondEnergy
from rbs_plugins.constitutive.correspondence import Correspondence
from rbs_plugins.constitutive.deformation_criteria import (
    CriticalEquivalentStrain,
    CriticalShearStrain,
    CriticalVolumetricStrain,
    MaximumPrincipalStress,
)
from rbs_plugins.constitutive.dilatation import Dilatation
from rbs_plugins.constitutive.failure import CriticalBondEnergy, CriticalNodalEnergy, critical_bond_energy
from rbs_plugins.constitutive.fracture import Criterion, CriticalStretch, Damage
from rbs_plugins.constitutive.ordinary import OrdinaryStateBased
from rbs_plugins.constitutive.pairwise import PairwiseForce
from rbs_plugins.constitutive.softening import BondSoftening
from rbs_plugins.constitutive.stabilization import SillingControl, WanControl
from rbs_plugins.constitutive.strength import Weibull
from rbs_plugins.exporters.animation import AnimationExporter
from rbs_plugins.exporters.connections import ConnectionExporter
from rbs_plugins.exporters.crack_path import CrackPath, crack_paths
from rbs_plugins.exporters.hdf5 import HDF5Exporter
from rbs_plugins.exporters.neighborhoods import NeighborhoodExporter
from rbs_plugins.exporters.picture import PictureExporter
from rbs_plugins.exporters.reductions import largest, mean, smallest, total
from rbs_plugins.exporters.run import read_run
from rbs_plugins.exporters.table import CSVExporter, read_table
from rbs_plugins.exporters.text import TextExporter
from rbs_plugins.exporters.vtk import VTKExporter
from rbs_plugins.exporters.vtkhdf import VTKHDFExporter
from rbs_plugins.integrators.explicit import Drift, Kick, SymplecticEuler, VelocityVerlet
from rbs_plugins.measures.crack import CrackTip
from rbs_plugins.measures.crossing import PeridynamicStress
from rbs_plugins.measures.energy import FractureDissipation, KineticEnergy, StrainEnergy
from rbs_plugins.measures.j_integral import JIntegral
from rbs_plugins.measures.reaction import ReactionForce
from rbs_plugins.measures.strain import Strain
from rbs_plugins.measures.stress import Stress
from rbs_plugins.statics.newmark import Newmark
from rbs_plugins.statics.newton import Newton
from rbs_plugins.statics.relaxation import AdaptiveDynamicRelaxation
from rbs_plugins.statics.sequential import SequentiallyLinear

__all__ = [
    "AdaptiveDynamicRelaxation",
    "AnimationExporter",
    "BondBased",
    "BondEnergy",
    "BondSoftening",
    "BoundaryDomain",
    "CSVExporter",
    "ConnectionExporter",
    "Correspondence",
    "CrackPath",
    "CrackTip",
    "Criterion",
    "CriticalBondEnergy",
    "CriticalEquivalentStrain",
    "CriticalNodalEnergy",
    "CriticalShearStrain",
    "CriticalStretch",
    "CriticalVolumetricStrain",
    "Damage",
    "Dilatation",
    "Drift",
    "FractureDissipation",
    "HDF5Exporter",
    "JIntegral",
    "Kick",
    "KineticEnergy",
    "MaximumPrincipalStress",
    "MeanBondEnergy",
    "NeighborhoodExporter",
    "Newmark",
    "Newton",
    "OrdinaryStateBased",
    "PairwiseForce",
    "PeridynamicStress",
    "PictureExporter",
    "Pressure",
    "ReactionForce",
    "Rotation",
    "Search",
    "SequentiallyLinear",
    "ShortRangeRepulsion",
    "SillingControl",
    "Strain",
    "StrainEnergy",
    "Stress",
    "SymplecticEuler",
    "TextExporter",
    "Translation",
    "VTKExporter",
    "VTKHDFExporter",
    "VelocityVerlet",
    "ViscousDamping",
    "WanControl",
    "Weibull",
    "crack_paths",
    "critical_bond_energy",
    "fields",
    "largest",
    "mean",
    "read_run",
    "read_table",
    "smallest",
    "total",
]


@rbs.hookimpl
def rbs_relations() -> Iterable[type[rbs.Relation]]:
    """The built-in relations."""
    return [
        PairwiseForce,
        BondBased,
        OrdinaryStateBased,
        Correspondence,
        Dilatation,
        BondEnergy,
        MeanBondEnergy,
        ShortRangeRepulsion,
        Search,
        Damage,
        Kick,
        Drift,
        BoundaryDomain,
        Pressure,
        ViscousDamping,
        Translation,
        Rotation,
        Newton,
        SequentiallyLinear,
        AdaptiveDynamicRelaxation,
        Newmark,
        KineticEnergy,
        StrainEnergy,
        FractureDissipation,
        Strain,
        Stress,
        PeridynamicStress,
        ReactionForce,
        CrackTip,
        JIntegral,
        CrackPath,
        VTKExporter,
        VTKHDFExporter,
        HDF5Exporter,
        CSVExporter,
        TextExporter,
        PictureExporter,
        AnimationExporter,
        NeighborhoodExporter,
        ConnectionExporter,
    ]


@rbs.hookimpl
def rbs_fields() -> Iterable[rbs.Field]:
    """The built-in vocabulary."""
    return fields.VOCABULARY


@rbs.hookimpl
def rbs_geometries() -> Iterable[type[rbs.Geometry]]:
    """The geometries of the kernel."""
    return [
        rbs.Ball, rbs.Bar, rbs.Box, rbs.Capsule, rbs.Circle, rbs.Cone, rbs.Cuboid, rbs.Cylinder, rbs.Disk,
        rbs.Everywhere, rbs.HalfSpace, rbs.Line, rbs.Nowhere, rbs.Plane, rbs.Point, rbs.Polygon, rbs.Prism,
        rbs.Pyramid, rbs.Ray, rbs.Rectangle, rbs.RegularPolygon, rbs.Ring, rbs.Segment, rbs.Slab,
        rbs.SurfaceMesh, rbs.Tetrahedron, rbs.Torus, rbs.Triangle, rbs.TriangulatedSurface, rbs.Tube, rbs.Where,
    ]  # fmt: skip
