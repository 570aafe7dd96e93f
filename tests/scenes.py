"""Small scenes in one, two and three dimensions, shared by tests and benchmarks.

Each function makes new parts and relations at every call, so two scenes never share anything:

    scene = plate(n=40)
    scene.analysis(rbs.Checkpoint(path)).run(steps=60, dt=scene.dt)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import rbs_core as rbs
from rbs_plugins import (
    BondBased,
    BoundaryDomain,
    Criterion,
    CriticalStretch,
    CSVExporter,
    Damage,
    FractureDissipation,
    KineticEnergy,
    StrainEnergy,
    VelocityVerlet,
)
from rbs_plugins.fields import density, external_work, fracture_dissipation, kinetic_energy, strain_energy

E, RHO = 192e9, 8000.0  # Pa, kg/m^3: the steel of Madenci & Oterkus (2014), section 9.2


@dataclass
class Scene:
    """A scene before it runs.

    Attributes:
        part: the part, discretized and connected.
        force: its constitutive relation.
        boundaries: its boundary domains.
        relations: one time step, in order.
        dt: a stable time step, s.
    """

    part: rbs.Part
    force: BondBased
    boundaries: list[BoundaryDomain]
    relations: list[rbs.Relation]
    dt: float

    def analysis(self, *more: rbs.Relation) -> rbs.Analysis:
        """An analysis of these relations, and more at the end."""
        return rbs.Analysis([*self.relations, *more], dt=self.dt)


def bar(n: int = 50, *, horizon_ratio: float = 3.0, speed: float = 1.0, fracture: Criterion | None = None) -> Scene:
    """A bar of 1 m with n nodes, held by its left family of nodes and pulled at the right one, m/s."""
    spacing = 1.0 / n
    part = rbs.Part("bar", rbs.Box(size=1.0, center=0.5)).discretize(spacing, area=1e-4)
    grip = horizon_ratio * spacing
    return _pulled(part, horizon_ratio, (0.0,), (speed,), grip, fracture)


def plate(
    n: int = 40,
    *,
    horizon_ratio: float = 3.015,
    speed: float = 20.0,
    s0: float = 0.04472,
    cracked: bool = True,
    energies: str | Path | None = None,
) -> Scene:
    """The square plate with a pre-existing crack of Madenci & Oterkus (2014), section 9.2: 0.05 m, crack of 0.01 m.

    Args:
        n: nodes along each side; three rows more at the upper and the lower edge take the motion.
        horizon_ratio: horizon over spacing.
        speed: of either edge, m/s.
        s0: critical stretch of bonds in the middle half of the plate.
        cracked: whether the crack is there.
        energies: path of a table to write energies to, every 10 steps.
    """
    side = 0.05
    spacing = side / n
    part = rbs.Part("plate", rbs.Box(size=(side, side + 6 * spacing))).discretize(spacing, thickness=spacing)
    part.connect(horizon=horizon_ratio * spacing)
    if cracked:
        part.bonds.cut(rbs.Segment((-side / 10, 0.0), (side / 10, 0.0)))
    part[density] = RHO
    force = BondBased(part, E=E, fracture=CriticalStretch(s0, within=rbs.Box(size=(side, side / 2))))
    upper = BoundaryDomain(part, rbs.HalfSpace((0, +side / 2), normal=(0, +1)), velocity=(None, +speed))
    lower = BoundaryDomain(part, rbs.HalfSpace((0, -side / 2), normal=(0, -1)), velocity=(None, -speed))
    shots = rbs.every(10)
    relations = [*VelocityVerlet(part).step([force], [upper, lower]), Damage(part, when=shots)]
    if energies is not None:
        table = [kinetic_energy, strain_energy, external_work, fracture_dissipation]
        relations += [
            KineticEnergy(part, when=shots),
            StrainEnergy(part, [force], when=shots),
            FractureDissipation(part, when=shots),
            CSVExporter(part, table, energies, when=shots),
        ]
    return Scene(part, force, [upper, lower], relations, dt=1.3367e-8 * 500 / n)  # the published step, for n = 500


def block(n: int = 8, *, horizon_ratio: float = 3.015, speed: float = 1.0, fracture: Criterion | None = None) -> Scene:
    """A cube of 0.1 m with n nodes along each edge, held at the bottom and pulled at the top, m/s."""
    spacing = 0.1 / n
    part = rbs.Part("block", rbs.Box(size=(0.1, 0.1, 0.1))).discretize(spacing)
    return _pulled(part, horizon_ratio, (0.0, 0.0, 0.0), (None, None, speed), 1.5 * spacing, fracture)


def _pulled(
    part: rbs.Part,
    horizon_ratio: float,
    below: Sequence[float | None],
    above: Sequence[float | None],
    grip: float,
    fracture: Criterion | None,
) -> Scene:
    """A part whose ends along its last axis have given velocities."""
    assert part.spacing is not None
    part.connect(horizon=horizon_ratio * part.spacing)
    part[density] = RHO
    force = BondBased(part, E=E, fracture=fracture)
    low, high = (float(bound[-1]) for bound in part.geometry.bounds)
    ends = [
        BoundaryDomain(part, lambda points: points[:, -1] < low + grip, velocity=tuple(below)),
        BoundaryDomain(part, lambda points: points[:, -1] > high - grip, velocity=tuple(above)),
    ]
    relations = VelocityVerlet(part).step([force], ends)
    # half the time in which the fastest wave, sqrt(1.2 E / rho) in 3-D with a Poisson's ratio of 1/4, passes a cell
    return Scene(part, force, ends, relations, dt=0.5 * part.spacing / (1.2 * E / RHO) ** 0.5)
