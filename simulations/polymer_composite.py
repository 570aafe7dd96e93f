"""A polymer with stiff particles, pulled until it breaks (Jenabidehkordi 2021, 4.3; Jenabidehkordi et al. 2020).

A cube of polyethylene, 10 µm wide on 100 nodes (`n=100`), with 500 particles of 800 nm at random places, which may
stick out of it. Each particle is a part of its own, bonded to the matrix by a connection. Three layers of nodes above
and below the cube are its grips; they move apart. There are three kinds of bonds: those of the matrix, those of the
particles, which are `alpha` times as stiff and as dense, and those of the interface, which break in tension and hold
in compression. The material is ordinary state-based with a Poisson's ratio of 0.42 (or, with `model=bond-based`, one of
1/4). What is measured is a macroscopic curve of stress against strain, from the forces on the grips and their
distance, by relations of this script.

The dissertation leaves much open, and some of it cannot be. Taken here:

* E = 1.035 N/mm^2 as printed, and 955 kg/m^3 (real polyethylene has about a thousand times the stiffness; all stresses
  are proportional to it).
* Each grip moves at 5 mm/s instead of 25 nm/s, with which a run would take some 10^9 steps; the kinetic energy over the
  work is in `result.json`. The body starts with the velocities of a uniform extension of its matrix, in which the
  particles move along.
* The grips are as dense as the particles, so that their bonds to these do not need a shorter time step.
* Critical stretches, of which none is given: 1 % in the matrix, 2 % at the interface, 5 % in the particles.
* Particles do not overlap; there are no bonds between two of them, as in the dissertation.
* Stress is the mean of the two reactions over the area, half of what equation 4.1 adds up.

`n` smaller than 100 is a smaller cube with as many particles per volume. simulations/README.md has the numbers, and
what changes with these choices.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

import rbs_core as rbs
from rbs_core.command import main
from rbs_plugins import (
    BondBased,
    BoundaryDomain,
    CriticalStretch,
    CSVExporter,
    Damage,
    OrdinaryStateBased,
    PairwiseForce,
    PictureExporter,
    VelocityVerlet,
    VTKHDFExporter,
    read_table,
)
from rbs_plugins.fields import damage, density, displacement, external_work, force_density, intact, velocity, volume

SPACING, RADIUS = 1e-7, 4e-7  # m
E, NU, RHO = 1.035e6, 0.42, 955.0  # Pa, 1, kg/m^3
PUBLISHED = 100  # nodes along the cube
LAYERS = 3  # of nodes in a grip

stress = rbs.Field("stress", "part", "scalar", "Pa", "σ", "Mean reaction of the grips per area.")
strain = rbs.Field("strain", "part", "scalar", "1", "ε", "Mean relative change of the distance of opposite grip nodes.")
moving = rbs.Field("moving", "part", "scalar", "J", "T", "Kinetic energy of all parts.")
broken = rbs.Field("broken", "part", "vector", "1", "n", "Broken bonds of the matrix, of the interface, of particles.")
crack = rbs.Field("crack", "node", "scalar", "1", "φ", "Damage of the matrix with its interface; -0.1 in a particle.")


def linear(stretch, c):
    """The law of bond-based interfaces."""
    return c * stretch


class StressStrain(rbs.Measure):
    """Writes macroscopic stress and strain of a part between two grips (equations 4.1 and 4.2)."""

    reads = (rbs.reference_position, displacement, force_density, volume)
    writes = (stress, strain)

    def __init__(self, part: rbs.Part, lower: np.ndarray, upper: np.ndarray, area: float) -> None:
        """Takes the nodes of the grips, `area` in m^2, and finds for each lower node the upper one opposite to it."""
        super().__init__(part)
        x, y, z = part.positions.T
        self.lower = lower[np.lexsort((z[lower], y[lower], x[lower]))]
        self.upper = upper[np.lexsort((-z[upper], y[upper], x[upper]))]
        self.area = area

    def apply(self, clock: rbs.Clock) -> None:
        """Sums reactions and elongations of all pairs of nodes."""
        force = self[force_density][:, 2] * self[volume]
        self[stress][...] = (force[self.lower].sum() - force[self.upper].sum()) / (2 * self.area)
        length = self[rbs.reference_position][self.upper, 2] - self[rbs.reference_position][self.lower, 2]
        longer = self[displacement][self.upper, 2] - self[displacement][self.lower, 2]
        self[strain][...] = np.mean(longer / length)


class KineticEnergyOfAll(rbs.Measure):
    """Writes the kinetic energy of several parts together, as a field of the first."""

    writes = (moving,)

    def __init__(self, parts: list[rbs.Part], *, when: rbs.Trigger = rbs.always) -> None:
        """Takes the parts."""
        super().__init__(parts[0], when=when)
        self.all = parts
        self.reads = tuple((part, field) for part in parts for field in (velocity, density, volume))

    def apply(self, clock: rbs.Clock) -> None:
        """Adds them up."""
        each = ((self[part, density] * self[part, volume]) @ (self[part, velocity] ** 2) for part in self.all)
        self[moving][...] = 0.5 * sum(energy.sum() for energy in each)


class Cracks(rbs.Measure):
    """Counts broken bonds of each kind, and writes the damage of matrix nodes, whose interface bonds count as well.

    A section through the middle, a part of its own that only shows, gets what the nodes there hold.
    """

    storages = ("list", "lattice")

    def __init__(
        self,
        matrix: rbs.Part,
        particles: list[rbs.Part],
        interfaces: list[rbs.Connection],
        section: rbs.Part,
        *,
        when: rbs.Trigger = rbs.always,
    ) -> None:
        """Takes the parts, the connections of the interfaces, and the part that shows."""
        super().__init__(matrix, when=when)
        self.particles, self.interfaces, self.section = particles, interfaces, section
        self.reads = (damage, *((host, intact) for host in (matrix, *particles, *interfaces)))
        self.writes = (crack, broken, (section, crack))
        self.own = matrix.bonds.counts()
        self.joint = [owners(interface) for interface in interfaces]
        # a node of the section shows the node of the matrix at the same place, or none
        places = matrix.positions
        middle = np.flatnonzero(np.abs(places[:, 1] - SPACING / 2) < SPACING / 2)
        far, found = cKDTree(places[middle][:, ::2]).query(section.positions)
        self.shows = np.where(far < SPACING / 2, middle[found], -1)

    def apply(self, clock: rbs.Clock) -> None:
        """Looks at all bonds."""
        lost, total, debonded = self[damage] * self.own, self.own.astype(float), 0
        for interface, (nodes, count) in zip(self.interfaces, self.joint, strict=True):
            gone = ~interface.bonds.intact[: len(nodes)]
            debonded += gone.sum()
            np.add.at(lost, nodes[gone], 1.0)
            total[interface.nodes[0]] += count
        own = np.count_nonzero(~self.part.bonds.intact)
        inside = sum(np.count_nonzero(~particle.bonds.intact) for particle in self.particles)
        self[broken][:] = own / 2, debonded, inside / 2  # bonds of a part are stored from both of their ends
        self[crack][:] = lost / total
        self[self.section, crack][:] = np.where(self.shows < 0, -0.1, self[crack][self.shows])


def owners(interface: rbs.Connection) -> tuple[np.ndarray, np.ndarray]:
    """The matrix node of each bond that starts in the matrix, and how many each node of the interface there has."""
    offsets, _ = interface.bonds.as_rows()
    count = np.diff(offsets)[: len(interface.nodes[0])]
    return np.repeat(interface.nodes[0], count), count


def places_of_particles(number: int, edge: float, seed: int) -> np.ndarray:
    """Centers of balls that do not overlap, (k, 3), at random places in a cube."""
    random = np.random.default_rng(seed)
    centers = np.empty((0, 3))
    for _ in range(200_000):
        if len(centers) == number:
            return centers
        new = random.uniform(-edge / 2, edge / 2, 3)
        if not len(centers) or np.linalg.norm(centers - new, axis=1).min() > 2 * RADIUS:
            centers = np.vstack([centers, new])
    raise rbs.BadInput(f"there is no room for {number} particles: take fewer")


def grid_around(center: np.ndarray, edge: float) -> rbs.grids.Grid:
    """The nodes of the grid of the cube in the box around a particle."""
    low = np.floor((np.clip(center - RADIUS, -edge / 2, edge / 2) + edge / 2) / SPACING)
    high = np.ceil((np.clip(center + RADIUS, -edge / 2, edge / 2) + edge / 2) / SPACING)
    return rbs.grids.uniform(low * SPACING - edge / 2, high * SPACING - edge / 2, SPACING)


def scene(
    n: int = 30,
    particles: int = 500,
    alpha: float = 2.0,
    matrix_stretch: float = 0.01,
    interface_stretch: float = 0.02,
    particle_stretch: float = 0.05,
    model: str = "state-based",
    strain_at_end: float = 0.012,
    speed: float = 5e-3,
    seed: int = 1,
    out: str | Path = "out/polymer_composite",
    frames: int = 60,
    pictures: int = 6,
) -> rbs.Analysis:
    """The cube with n nodes along its edge, and as many particles per volume as `particles` in the full one."""
    edge, horizon = n * SPACING, 3 * SPACING * (1 + 1e-9)
    duration = strain_at_end * edge / (2 * speed)
    out = Path(out)

    # matrix and grips are one part, each particle is another one; a hole in the matrix for each particle
    centers = places_of_particles(round(particles * (n / PUBLISHED) ** 3), edge, seed)
    cube = rbs.Box(size=(edge, edge, edge))
    nearest = cKDTree(centers if len(centers) else [[10 * edge] * 3])
    in_particle = rbs.Where(lambda points: nearest.query(points)[0] <= RADIUS, dimension=3) & cube
    matrix = rbs.Part("matrix", rbs.Box(size=(edge, edge, edge + 2 * LAYERS * SPACING)) - in_particle)
    matrix.discretize(SPACING).connect(horizon)
    balls = [rbs.Part(f"particle {k}", rbs.Ball(RADIUS, center) & cube) for k, center in enumerate(centers)]
    for ball, center in zip(balls, centers, strict=True):
        ball.discretize(grid_around(center, edge)).connect(horizon)
    bodies = [matrix, *balls]

    def uniform_extension(points: np.ndarray) -> np.ndarray:
        """Velocities that rise from one grip to the other."""
        return np.clip(points / edge, -0.5, 0.5) * (0.0, 0.0, 2 * speed)

    matrix[density] = lambda points: np.where(cube.contains(points), RHO, alpha * RHO)
    matrix[velocity] = uniform_extension
    for ball, center in zip(balls, centers, strict=True):
        ball[density], ball[velocity] = alpha * RHO, uniform_extension(center)

    # three kinds of bonds; those of an interface get the shares of the materials of both ends
    material, given = (OrdinaryStateBased, {"nu": NU}) if model == "state-based" else (BondBased, {})
    tough = CriticalStretch(particle_stretch)
    polymer = material(matrix, E=E, fracture=CriticalStretch(matrix_stretch), **given)
    inside = [material(ball, E=alpha * E, fracture=tough, **given) for ball in balls]

    def bonds_between(
        solid: PairwiseForce, there: rbs.Geometry, criterion: CriticalStretch, name: str
    ) -> PairwiseForce:
        """The bonds of a particle with nodes of the matrix part in a region."""
        joint = rbs.Connection(
            matrix, solid.part, horizon, where=lambda starts, ends: there.contains(starts), name=name
        )
        if material is OrdinaryStateBased:
            return OrdinaryStateBased(joint, between=(polymer, solid), fracture=criterion)
        return PairwiseForce(joint, linear, criterion, c=(polymer.c + solid.c) / 2)

    debonding = CriticalStretch(interface_stretch)
    glue = [bonds_between(solid, cube, debonding, f"interface of {solid.part.name}") for solid in inside]
    near_grip = edge / 2 + SPACING / 2 - horizon  # from there on a node is bonded to the first layer of a grip
    held = [
        bonds_between(solid, ~cube, tough, f"grip to {solid.part.name}")
        for solid in inside
        if np.abs(solid.part.positions[:, 2]).max() >= near_grip
    ]

    grips = [rbs.HalfSpace((0, 0, side * edge / 2), normal=(0, 0, side)) for side in (-1, +1)]
    moved = [
        BoundaryDomain(matrix, grip, velocity=(None, None, side * speed))
        for grip, side in zip(grips, (-1, +1), strict=True)
    ]
    verlets = [VelocityVerlet(body) for body in bodies]

    shots = rbs.at(np.linspace(0.0, duration, frames + 1)[1:])
    drawn = rbs.at(np.linspace(0.0, duration, pictures + 1)[1:])
    section = rbs.Part("section", rbs.Box(size=(edge, edge + 2 * LAYERS * SPACING))).discretize(SPACING)
    return rbs.Analysis(
        [
            *(verlet.kick for verlet in verlets),
            *moved,
            *(verlet.drift for verlet in verlets),
            polymer,
            *inside,
            *glue,
            *held,
            *(verlet.kick for verlet in verlets),
            *moved,
            StressStrain(matrix, *(matrix.where(grip) for grip in grips), area=edge**2),
            CSVExporter(matrix, [strain, stress], out / "stress_strain.csv"),
            Damage(matrix, when=shots | drawn),
            Cracks(matrix, balls, [each.host for each in glue], section, when=shots | drawn),
            KineticEnergyOfAll(bodies, when=shots),
            CSVExporter(matrix, [strain, stress, broken, moving, external_work], out / "history.csv", when=shots),
            VTKHDFExporter(matrix, [displacement, crack], out / "matrix", when=drawn),
            PictureExporter(section, crack, out / "section", limits=(-0.1, 0.6), configuration="reference", when=drawn),
            rbs.Checkpoint(out / "checkpoint.npz", when=rbs.realtime(120)),
        ],
        until=duration,
        title=f"polymer_composite, {len(balls)} particles, {n} nodes along the cube",
    )


def measure(analysis: rbs.Analysis) -> dict[str, object]:
    """Modulus and its bounds, the peak of the curve, what broke when, and how quasi-static the run was."""
    matrix, balls = analysis.parts[0], [part for part in analysis.parts if part.name.startswith("particle ")]
    out = next(r.path.parent for r in analysis.relations if isinstance(r, CSVExporter))
    curve, history = (
        {name: np.array(column) for name, column in read_table(out / f"{name}.csv").items()}
        for name in ("stress_strain", "history")
    )
    hosts = {r.host for r in analysis.relations if isinstance(r, PairwiseForce)}
    nu = NU if any(isinstance(r, OrdinaryStateBased) for r in analysis.relations) else 1 / 4
    inside = sum(len(ball) for ball in balls)
    in_cube = round(np.ptp(matrix.positions[:, 0]) / SPACING + 1) ** 3
    bonds = {name: history[f"broken_{k}"] for k, name in enumerate(("matrix", "interface", "particle"))}
    total = sum(bonds.values())
    ratio = history["moving"] / history["external_work"]
    breaks = int(np.argmax(total > 0)) if total.any() else -1
    alpha = balls[0][density][0] / RHO if balls else 1.0
    peak = int(np.argmax(curve["stress"]))
    # the slope up to half of the strain at which the first bond breaks
    first = history["strain"][breaks]
    start = curve["strain"] < first / 2
    modulus = np.polyfit(curve["strain"][start], curve["stress"][start], 1)[0]
    result = {
        "nodes": len(matrix) + inside,
        "directed_bonds": sum(len(host.bonds) for host in hosts),
        "particles": len(balls),
        "volume_fraction": inside / in_cube,
        "modulus_over_E": modulus / E,
        **bounds(inside / in_cube, alpha, nu),
        "first_break_before_strain": float(first) if total.any() else float("inf"),
        "peak_stress_over_E": float(curve["stress"][peak] / E),
        "peak_at_strain": float(curve["strain"][peak]),
        "last_stress_over_peak": float(curve["stress"][-1] / curve["stress"][peak]),
        "kinetic_energy_over_work_then": float(ratio[breaks]),
        "kinetic_energy_over_work_at_peak": float(np.interp(curve["strain"][peak], history["strain"], ratio)),
    }
    for name, count in bonds.items():
        then = history["strain"][np.argmax(count > 0)] if count.any() else float("inf")
        result |= {f"broken_bonds_{name}": int(count[-1]), f"{name}_breaks_before_strain": float(then)}
    steps = slice(None, None, max(len(curve["strain"]) // 200, 1))
    return {**result, "curve_strain_stress_over_E": np.column_stack([curve["strain"], curve["stress"] / E])[steps]}


def bounds(fraction: float, alpha: float, nu: float) -> dict[str, float]:
    """Bounds of Young's modulus of a mixture over that of its matrix (Hashin & Shtrikman 1963)."""
    voigt, reuss = 1 - fraction + alpha * fraction, 1 / (1 - fraction + fraction / alpha)

    def mixture(one: float, other: float, share: float) -> float:
        """E of a mixture with a share of the other, the one being the softest or the stiffest (in E of the matrix)."""
        bulk, shear = 1 / (3 * (1 - 2 * nu)), 1 / (2 * (1 + nu))
        K1, G1, K2, G2 = bulk * one, shear * one, bulk * other, shear * other
        if K1 == K2:
            return one
        K = K1 + share / (1 / (K2 - K1) + 3 * (1 - share) / (3 * K1 + 4 * G1))
        G = G1 + share / (1 / (G2 - G1) + 6 * (1 - share) * (K1 + 2 * G1) / (5 * G1 * (3 * K1 + 4 * G1)))
        return 9 * K * G / (3 * K + G)

    lower, upper = mixture(1.0, alpha, fraction), mixture(alpha, 1.0, 1 - fraction)
    return {"reuss": reuss, "hashin_shtrikman_lower": lower, "hashin_shtrikman_upper": upper, "voigt": voigt}


if __name__ == "__main__":
    sys.exit(main(["run", __file__, *sys.argv[1:]]))
