"""The vocabulary: every field that the built-in relations use, with symbol, unit and one sentence."""

from __future__ import annotations

from rbs_core.fields import Field, intact, is_fictitious, reference_position, volume

displacement = Field("displacement", "node", "vector", "m", "u", "Position minus reference position.")
velocity = Field("velocity", "node", "vector", "m/s", "v", "Rate of the displacement.")
density = Field("density", "node", "scalar", "kg/m^3", "ρ", "Mass per reference volume.")
force_density = Field(
    "force_density", "node", "vector", "N/m^3", "L + b", "Force per volume on a node, of bonds and of loads together."
)
damage = Field("damage", "node", "scalar", "1", "φ", "Broken share of the family, by volume: 1 − Σ μV / ΣV.")
strain_energy_density = Field(
    "strain_energy_density", "node", "scalar", "J/m^3", "W", "Half of the energy in the intact bonds of a node."
)
dissipation_density = Field(
    "dissipation_density", "node", "scalar", "J/m^3", "D", "Half of the energy that the broken bonds of a node held."
)
deformation_gradient = Field(
    "deformation_gradient", "node", "tensor", "1", "F", "Deformation of the family of a node as a whole."
)
strain = Field("strain", "node", "tensor", "1", "ε", "Strain of the family of a node as a whole.")
stress = Field("stress", "node", "tensor", "Pa", "ν", "Collapsed stress: force states of the family times its bonds.")
peridynamic_stress = Field(
    "peridynamic_stress",
    "node",
    "tensor",
    "Pa",
    "ν_k",
    "Stress of all bonds that pass the cell of a node, mean of the cell.",
)
plastic_strain = Field(
    "plastic_strain", "node", "tensor", "1", "ε_p", "Plastic part of the strain, without change of volume."
)
equivalent_plastic_strain = Field(
    "equivalent_plastic_strain", "node", "scalar", "1", "α", "Length of the path of the plastic strain, times √(2/3)."
)
breakable = Field(
    "breakable", "bond", "scalar", "1", "b", "1 where the bond may break, 0 in a no-fail zone.", "uint8", 1
)
critical_stretch = Field(
    "critical_stretch", "node", "scalar", "1", "s0", "Stretch beyond which the bonds of the node fail."
)
volume_fraction = Field(
    "volume_fraction",
    "bond",
    "scalar",
    "1",
    "β",
    "Share of the neighbor's cell that lies within the horizon.",
    initial=1,
)
largest_stretch = Field("largest_stretch", "bond", "scalar", "1", "s_max", "Largest stretch that the bond has had.")
contact_distance = Field(
    "contact_distance", "bond", "scalar", "m", "d", "Distance of two nodes below which they repel each other."
)
bond_energy = Field("bond_energy", "bond", "scalar", "J/m^6", "w", "Work that the force of the bond has taken so far.")
bond_force = Field("bond_force", "bond", "scalar", "N/m^6", "f", "Pairwise force at which that work has arrived.")
bond_extension = Field("bond_extension", "bond", "scalar", "m", "e", "Extension at which that work has arrived.")
mean_bond_energy = Field(
    "mean_bond_energy",
    "node",
    "scalar",
    "J/m^6",
    "w",
    "Energy that a mean bond of the node holds: 2W / Σ βV.",
)
influence = Field("influence", "bond", "scalar", "1", "ω", "Influence function: how much a bond counts in its family.")
inverse_weighted_volume = Field(
    "inverse_weighted_volume",
    "node",
    "scalar",
    "1/m^5",
    "1/m",
    "One over the weighted volume Σ ω ξ² V of the family.",
)
dilatation = Field(
    "dilatation", "node", "scalar", "1", "ϑ", "Growth of the family, the trace of a small strain (in 2-D in the plane)."
)
deviatoric_modulus = Field(
    "deviatoric_modulus",
    "node",
    "scalar",
    "Pa",
    "α m",
    "Pull of a bond per extension, times m: 15 μ in 3-D, 8 μ in 2-D.",
)
dilatational_modulus = Field(
    "dilatational_modulus",
    "node",
    "scalar",
    "Pa",
    "κ",
    "Pull of a bond per length and dilatation, times m: 3K − 5μ in 3-D.",
)
kinetic_energy = Field("kinetic_energy", "part", "scalar", "J", "T", "Kinetic energy of the part.")
strain_energy = Field("strain_energy", "part", "scalar", "J", "U", "Energy in the intact bonds of the part.")
load_factor = Field(
    "load_factor",
    "part",
    "scalar",
    "1",
    "λ",
    "Loads of this equilibrium over those that were prescribed.",
)
external_work = Field("external_work", "part", "scalar", "J", "A", "Work that boundary domains have done on the part.")
viscous_dissipation = Field(
    "viscous_dissipation", "part", "scalar", "J", "Ψ", "Energy that viscous damping has taken from the part."
)
fracture_dissipation = Field(
    "fracture_dissipation", "part", "scalar", "J", "Φ", "Energy that the bonds held when they broke."
)
singular_families = Field(
    "singular_families", "part", "scalar", "1", "n", "Number of nodes whose bonds span no volume: they show no strain."
)
reaction_force = Field("reaction_force", "part", "vector", "N", "R", "Force that holds the nodes of a region.")
crack_tip = Field("crack_tip", "part", "vector", "m", "x", "Foremost damaged place, in the reference configuration.")
crack_tip_speed = Field("crack_tip_speed", "part", "scalar", "m/s", "v", "Speed of the crack tip along its direction.")
j_integral = Field(
    "j_integral", "part", "scalar", "J/m^2", "J", "Energy release rate of a straight crack, the J-integral."
)

VOCABULARY = (
    displacement,
    velocity,
    density,
    force_density,
    damage,
    strain_energy_density,
    dissipation_density,
    deformation_gradient,
    strain,
    stress,
    peridynamic_stress,
    plastic_strain,
    equivalent_plastic_strain,
    critical_stretch,
    breakable,
    volume_fraction,
    largest_stretch,
    contact_distance,
    bond_energy,
    bond_force,
    bond_extension,
    mean_bond_energy,
    influence,
    inverse_weighted_volume,
    dilatation,
    deviatoric_modulus,
    dilatational_modulus,
    kinetic_energy,
    strain_energy,
    external_work,
    load_factor,
    viscous_dissipation,
    fracture_dissipation,
    singular_families,
    reaction_force,
    crack_tip,
    crack_tip_speed,
    j_integral,
)

__all__ = [
    *(field.name for field in VOCABULARY),
    "VOCABULARY",
    "intact",
    "is_fictitious",
    "reference_position",
    "volume",
]
