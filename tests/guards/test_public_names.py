"""The public names, word by word: whoever changes them changes this page and the documentation with it."""

from __future__ import annotations

import pytest

import rbs_core
import rbs_plugins

KERNEL = [
    "Analysis",
    "BadCheckpoint",
    "BadInput",
    "BadLaw",
    "Ball",
    "Bar",
    "Bonds",
    "Boundary",
    "Box",
    "Capsule",
    "Checkpoint",
    "Circle",
    "Clock",
    "Cone",
    "Connection",
    "Constitutive",
    "CoordinateSystem",
    "Cuboid",
    "Cylinder",
    "DishonestRelation",
    "Disk",
    "Everywhere",
    "Exporter",
    "FictitiousLayer",
    "Field",
    "FieldClash",
    "Geometry",
    "HalfSpace",
    "Integrator",
    "Line",
    "Measure",
    "MissingField",
    "Neighborhood",
    "Node",
    "NotConverged",
    "NotFinite",
    "Nowhere",
    "Part",
    "Plane",
    "Point",
    "Polygon",
    "Prism",
    "Pyramid",
    "RBSError",
    "Ray",
    "Rectangle",
    "RegularPolygon",
    "Relation",
    "Report",
    "Ring",
    "Segment",
    "Slab",
    "Statics",
    "Status",
    "Surface",
    "SurfaceMesh",
    "Tetrahedron",
    "Torus",
    "Triangle",
    "TriangulatedSurface",
    "Trigger",
    "Tube",
    "UndeclaredField",
    "UnstableStep",
    "Where",
    "always",
    "at",
    "between",
    "configure_logging",
    "convert",
    "convert_vectors",
    "every",
    "grids",
    "hookimpl",
    "intact",
    "is_fictitious",
    "last",
    "once",
    "realtime",
    "reference_position",
    "registry",
    "volume",
    "world",
]

PLUGINS = [
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
    "Newton",
    "OrdinaryStateBased",
    "PairwiseForce",
    "PeridynamicStress",
    "PictureExporter",
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


@pytest.mark.parametrize(("package", "names"), [(rbs_core, KERNEL), (rbs_plugins, PLUGINS)], ids=["core", "plugins"])
def test_the_public_names_are_these(package, names):
    assert list(package.__all__) == names


@pytest.mark.parametrize("package", [rbs_core, rbs_plugins], ids=["core", "plugins"])
def test_they_exist_and_are_sorted(package):
    assert all(hasattr(package, name) for name in package.__all__)
    assert sorted(package.__all__) == sorted(set(package.__all__))


def test_the_kernel_makes_no_other_name_public():
    """Submodules are there as attributes; everything else that does not start with an underscore is on the list."""
    extra = {
        name
        for name, value in vars(rbs_core).items()
        if not name.startswith("_") and name not in rbs_core.__all__ and type(value).__name__ != "module"
    }
    assert not extra
