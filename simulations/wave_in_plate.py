"""Elastic wave in a plate under a short vertical force on its edge (Dally & Thau 1967; Nishawala et al. 2016).

Also section 4.1 and appendix A of A. Jenabidehkordi's dissertation (Bauhaus-Universität Weimar, 2021). A CR-39 plate of
1.0 m x 0.5 m x 6.655 mm with its upper edge at y = 0; a force rises to its peak at 10 µs, falls to nothing at 20 µs and
pushes the four nodes |x| <= h, y > -2.1 h down. Readings taken: the peak of 20.7e3 is in newton and in total, and
c = 9E/(πtδ³), the plane-stress constant for Poisson's ratio 1/3 (the dissertation prints two others).

What is measured are wave speeds, as slopes of position against time: of the pressure pulse down the axis, of the shear
pulse along a ray, of the Rayleigh pulse along the edge.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

import rbs_core as rbs
from rbs_core.command import main
from rbs_plugins import (
    BondBased,
    BoundaryDomain,
    CSVExporter,
    KineticEnergy,
    PictureExporter,
    StrainEnergy,
    VelocityVerlet,
    VTKExporter,
    read_table,
)
from rbs_plugins.elasticity import wave_speeds
from rbs_plugins.fields import density, displacement, external_work, kinetic_energy, strain_energy, velocity

LENGTH, DEPTH, THICKNESS = 1.0, 0.5, 6.655e-3  # m
E, NU, RHO = 3.85e9, 1 / 3, 1300.0  # Pa, 1, kg/m^3
PEAK, RISE = 20.7e3, 10e-6  # N, s
PICTURE = 107e-6  # s
RAY = math.radians(40)  # from the axis: a vertical point force sends most of its shear wave about there


def force(time: float) -> tuple[float, float]:
    """The triangular pulse, N."""
    return 0.0, -PEAK * max(0.0, 1.0 - abs(time / RISE - 1.0))


class Lines(rbs.Measure):
    """Keeps the velocity along three lines of nodes from the source: down the axis, along the edge, along a ray."""

    reads = (velocity,)

    def __init__(self, part: rbs.Part, *, when: rbs.Trigger = rbs.always) -> None:
        """Picks the nodes of the three lines."""
        super().__init__(part, when=when)
        spacing = part.spacing
        nx, ny = part.grid.shape
        self.radius = spacing * (0.5 + np.arange(int(0.35 * LENGTH / spacing)))
        turns = {"axis": 0.0, "edge": math.pi / 2, "ray": RAY}
        self.nodes = {}
        for name, turn in turns.items():
            column = np.rint(self.radius * math.sin(turn) / spacing - 0.5).astype(int).clip(0) + nx // 2
            row = ny - 1 - np.rint(self.radius * math.cos(turn) / spacing - 0.5).astype(int).clip(0)
            self.nodes[name] = column + nx * row
        # along the axis and the edge the vertical velocity, along the ray the one across it
        self.across = {"axis": (0.0, -1.0), "edge": (0.0, -1.0), "ray": (-math.cos(RAY), -math.sin(RAY))}
        self.history: dict[str, list[Any]] = {"time": [], "axis": [], "edge": [], "ray": []}

    def apply(self, clock: rbs.Clock) -> None:
        """Takes the velocities of now."""
        self.history["time"].append(clock.time)
        for name, nodes in self.nodes.items():
            self.history[name].append(self[velocity][nodes] @ np.array(self.across[name]))

    def state(self) -> dict[str, Any]:
        """For checkpoints."""
        return {name: np.array(values) for name, values in self.history.items()}

    def restore(self, state: dict[str, Any]) -> None:
        """From a checkpoint."""
        self.history = {name: list(state[name]) for name in self.history}


def scene(
    n: int = 1024,
    until: float = 208e-6,
    partial_volume: str = "none",
    out: str | Path = "out/wave_in_plate",
    frames: int = 20,
) -> rbs.Analysis:
    """The plate with n nodes along its length; pictures at 107 µs, if the run gets there."""
    spacing = LENGTH / n
    dt = 0.125e-6 * 1024 / n
    shots = rbs.every(max(round(until / dt / frames), 1))
    often = rbs.every(8)
    out = Path(out)

    plate = rbs.Part("plate", rbs.Box(size=(LENGTH, DEPTH), center=(0.0, -DEPTH / 2)))
    plate.discretize(spacing, thickness=THICKNESS)
    plate.connect(horizon=3 * spacing)
    plate[density] = RHO

    elastic = BondBased(plate, E=E, nu=NU, partial_volume=partial_volume)
    source = rbs.Where(lambda points: (np.abs(points[:, 0]) <= spacing) & (points[:, 1] > -2.1 * spacing))
    push = BoundaryDomain(plate, source, force=force)

    return rbs.Analysis(
        [
            *VelocityVerlet(plate).step(forces=[elastic], boundaries=[push]),
            Lines(plate, when=often),
            KineticEnergy(plate, when=often),
            StrainEnergy(plate, [elastic], when=often),
            CSVExporter(plate, [kinetic_energy, strain_energy, external_work], out / "energies.csv", when=often),
            VTKExporter(plate, [displacement, velocity], out / "plate", when=shots),
            PictureExporter(plate, velocity, out / "velocity", limits=(0.0, 10.0), when=rbs.at(PICTURE)),
            PictureExporter(plate, displacement, out / "displacement", component="y", when=rbs.at(PICTURE)),
            rbs.Checkpoint(out / "checkpoint.npz", when=rbs.realtime(60)),
        ],
        dt=dt,
        until=until,
        title="wave_in_plate",
    )


def measure(analysis: rbs.Analysis) -> dict[str, object]:
    """Wave speeds beside the classical ones, symmetry, and the energy balance."""
    plate = analysis.parts[0]
    lines = next(r for r in analysis.relations if isinstance(r, Lines))
    elastic = next(r for r in analysis.relations if isinstance(r, BondBased))
    record = int(np.argmin(np.abs(np.array(lines.history["time"]) - PICTURE)))
    table = next(r.path for r in analysis.relations if isinstance(r, CSVExporter))
    energy = {name: np.array(column) for name, column in read_table(table).items()}
    expected = wave_speeds(E, NU, RHO, plane="stress")
    found = {
        "pressure": pulse_speed(lines, "axis", expected.pressure),
        "shear": pulse_speed(lines, "ray", expected.shear),
        "rayleigh": pulse_speed(lines, "edge", expected.rayleigh),
    }
    total = energy["kinetic_energy"] + energy["strain_energy"]
    after = energy["time"] > 2 * RISE + 1e-6
    u = plate[displacement].reshape(*plate.grid.shape[::-1], 2)
    mirrored = u[:, ::-1] * (-1, 1)
    result: dict[str, object] = {"nodes": len(plate), "directed_bonds": len(plate.bonds)}
    for name, speed in found.items():
        classical = getattr(expected, name)
        result[f"{name}_speed_m_per_s"] = speed
        result[f"{name}_speed_classical_m_per_s"] = classical
        result[f"{name}_speed_error"] = speed / classical - 1
    return {
        **result,
        "speed_factor_of_the_family": family_factor(plate, elastic.parameters["partial_volume"]),
        "pressure_pulse_at_107_us_m": pulse_place(lines, "axis", expected.pressure, record),
        "asymmetry_left_right": float(np.abs(u - mirrored).max() / np.abs(u).max()),
        "energy_J": float(total[-1]),
        "energy_drift_after_load": float(np.ptp(total[after]) / total[after].mean()),
        "energy_error": float(abs(total[-1] / energy["external_work"][-1] - 1)),
    }


def pulse_speed(lines: Lines, name: str, guess: float, start: float = 50e-6) -> float:
    """Slope of the place of the leading pulse against time, from `start` until 107 µs."""
    records = [k for k, time in enumerate(lines.history["time"]) if start <= time <= PICTURE * (1 + 1e-9)]
    times = [lines.history["time"][k] for k in records]
    return float(np.polyfit(times, [pulse_place(lines, name, guess, k) for k in records], 1)[0])


def pulse_place(lines: Lines, name: str, guess: float, record: int) -> float:
    """Distance of the leading pulse from the source, m: the middle of its first lobe at half of its height.

    The lobe is the largest value within 15 % of where a wave of speed `guess` that left at the peak of the load should
    be. Shorter waves lag behind the lobe (the family is a low-pass), so its crest wanders while its middle does not.
    """
    radius, values = lines.radius, lines.history[name][record]
    near = np.flatnonzero(np.abs(radius / (guess * (lines.history["time"][record] - RISE)) - 1) < 0.15)
    crest = near[np.argmax(values[near])]
    half = values[crest] / 2
    inner = crest - np.argmax(values[crest::-1] <= half)
    outer = crest + np.argmax(values[crest:] <= half)
    ends = (
        np.interp(half, values[[inner, inner + 1]], radius[[inner, inner + 1]]),
        np.interp(half, values[[outer, outer - 1]], radius[[outer, outer - 1]]),
    )
    return float(np.mean(ends))


def family_factor(part: rbs.Part, partial_volume: str) -> float:
    """Speed of long waves over the classical one that the finite sum over a family brings: sqrt(Σβ|ξ|V / ∫|ξ|dV)."""
    middle = part.where(lambda points: np.hypot(points[:, 0], points[:, 1] + DEPTH / 2) < part.spacing)[0]
    family = part.bonds.family(int(middle))
    lengths, horizon = part.bonds.lengths[family], part.bonds.horizon
    band = np.clip((horizon + part.spacing / 2 - lengths) / part.spacing, 0, 1) if partial_volume == "linear" else 1.0
    return math.sqrt(float(np.sum(band * lengths)) * part.spacing**2 / (2 * math.pi * horizon**3 / 3))


if __name__ == "__main__":
    sys.exit(main(["run", __file__, *sys.argv[1:]]))
