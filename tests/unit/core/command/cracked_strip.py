"""A strip with a crack: a file for `rbs run` that leaves frames, a table and a picture."""

from __future__ import annotations

import rbs_core as rbs
from rbs_plugins import (
    BondBased,
    BoundaryDomain,
    CriticalStretch,
    CSVExporter,
    Damage,
    KineticEnergy,
    VelocityVerlet,
    VTKHDFExporter,
)
from rbs_plugins.fields import damage, density, displacement, kinetic_energy


def scene(n=20, speed=10.0, horizon=3.015, dt=None, nan=0, out="out"):
    """A strip of 0.1 m x 0.05 m whose upper edge moves at `speed` m/s."""
    spacing = 0.1 / n
    strip = rbs.Part("strip", rbs.Box(size=(0.1, 0.05))).discretize(spacing, thickness=spacing)
    strip.connect(horizon=horizon * spacing)
    strip.bonds.cut(rbs.Segment((-0.01, 0.0), (0.01, 0.0)))
    strip[density] = 8000.0
    steel = BondBased(strip, E=192e9, fracture=CriticalStretch(0.01))
    held = BoundaryDomain(strip, rbs.HalfSpace((0, -0.02), normal=(0, -1)), velocity=(0.0, 0.0))
    pulled = BoundaryDomain(strip, rbs.HalfSpace((0, 0.02), normal=(0, 1)), velocity=(None, speed))
    shots = rbs.every(10)
    return rbs.Analysis(
        [
            *VelocityVerlet(strip).step([steel], [held, pulled]),
            *([Spoiler(strip, nan)] if nan else []),
            Damage(strip, when=shots),
            KineticEnergy(strip, when=shots),
            CSVExporter(strip, [kinetic_energy], f"{out}/history.csv", when=shots),
            VTKHDFExporter(strip, [displacement, damage], f"{out}/strip", when=shots),
        ],
        steps=30,
        dt=dt,
        title="strip",
    )


class Spoiler(rbs.Measure):
    """Makes a number infinite in one step."""

    updates = (displacement,)

    def __init__(self, part, step):
        super().__init__(part)
        self.step = step

    def apply(self, clock):
        if clock.step == self.step:
            self[displacement][3, 1] = float("inf")


def measure(analysis):
    strip = analysis.parts[0]
    return {"nodes": len(strip), "directed_bonds": len(strip.bonds), "largest_damage": float(strip[damage].max())}
