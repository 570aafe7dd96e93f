"""A crack that branches in soda-lime glass (after Ha & Bobaru 2010, 2011), the case that most programs show.

A plate of 0.1 m x 0.04 m with a crack from the middle of its left edge to its center; at time 0 a tension of 2 MPa
appears on both long edges and stays. E = 72 GPa, 2440 kg/m^3, G0 = 3.8 J/m^2. Spacing 0.25 mm, horizon 1 mm, time step
45 ns and 43 µs are those of the example that comes with CabanaPD. What is expected: the crack branches, and its tip
is slower than the Rayleigh wave.

Readings taken: plane stress (Poisson's ratio 1/3), so s0 = sqrt(4πG0/(9Eδ)); the load acts on the outermost row of
nodes of each edge (`rows`); bonds fail in tension, and carry nothing from then on. simulations/README.md tells what
changes with them.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import rbs_core as rbs
from rbs_core.command import main
from rbs_plugins import (
    BondBased,
    BoundaryDomain,
    CriticalStretch,
    CSVExporter,
    Damage,
    FractureDissipation,
    KineticEnergy,
    PictureExporter,
    StrainEnergy,
    VelocityVerlet,
    VTKHDFExporter,
    read_table,
)
from rbs_plugins.elasticity import wave_speeds
from rbs_plugins.fields import (
    damage,
    density,
    displacement,
    external_work,
    fracture_dissipation,
    kinetic_energy,
    strain_energy,
    velocity,
)

LENGTH, HEIGHT, THICKNESS = 0.1, 0.04, 0.002  # m
E, NU, RHO = 72e9, 1 / 3, 2440.0  # Pa, 1, kg/m^3
EDGE = 0.002  # m beside the loaded edges that are not looked at: nodes at their ends may come off
CRACKED = 0.35  # damage of a node beside a crack: 20 of its 48 bonds cross a straight one, 0.42

tip = rbs.Field("tip", "part", "scalar", "m", "x", "Rightmost x of the cracked nodes.")
spread = rbs.Field("spread", "part", "scalar", "m", "|y|", "Largest distance of a cracked node from the axis.")


class CrackTip(rbs.Measure):
    """Writes how far to the right and how far from the axis nodes are cracked."""

    reads = (damage, rbs.reference_position)
    writes = (tip, spread)

    def apply(self, clock: rbs.Clock) -> None:
        """Looks at the nodes whose damage says that a crack passes beside them."""
        positions = self[rbs.reference_position]
        x, y = positions[(self[damage] > CRACKED) & (np.abs(positions[:, 1]) < HEIGHT / 2 - EDGE)].T
        self[tip][...] = x.max(initial=-LENGTH / 2)
        self[spread][...] = np.abs(y).max(initial=0.0)


def scene(
    n: int = 400,
    horizon: float = 1e-3,
    stress: float = 2e6,
    fracture_energy: float = 3.8,
    until: float = 43e-6,
    dt: float = 45e-9,
    rows: int = 1,
    release: str = "at once",
    partial_volume: str = "none",
    out: str | Path = "out/crack_branching",
    frames: int = 100,
) -> rbs.Analysis:
    """The plate with n nodes along it, pulled by `stress` on its long edges; dt is that for n = 400."""
    spacing = LENGTH / n
    dt = dt * 400 / n
    shots = rbs.every(max(round(until / dt / frames), 1)) | rbs.last
    out = Path(out)

    plate = rbs.Part("plate", rbs.Box(size=(LENGTH, HEIGHT)))
    plate.discretize(spacing, thickness=THICKNESS)
    plate.connect(horizon=horizon * (1 + 1e-9))
    plate.bonds.cut(rbs.Segment((-LENGTH / 2, 0.0), (0.0, 0.0)))
    plate[density] = RHO

    brittle = CriticalStretch(fracture_energy=fracture_energy, release=release)
    glass = BondBased(plate, E=E, nu=NU, fracture=brittle, partial_volume=partial_volume)
    edge, load = HEIGHT / 2 - rows * spacing, stress * LENGTH * THICKNESS
    upper = BoundaryDomain(plate, rbs.HalfSpace((0, +edge), normal=(0, +1)), force=(None, +load))
    lower = BoundaryDomain(plate, rbs.HalfSpace((0, -edge), normal=(0, -1)), force=(None, -load))

    energies = [kinetic_energy, strain_energy, fracture_dissipation, external_work]
    return rbs.Analysis(
        [
            *VelocityVerlet(plate).step(forces=[glass], boundaries=[upper, lower]),
            Damage(plate, when=shots),
            CrackTip(plate, when=shots),
            KineticEnergy(plate, when=shots),
            StrainEnergy(plate, [glass], when=shots),
            FractureDissipation(plate, when=shots),
            CSVExporter(plate, [tip, spread, *energies], out / "history.csv", when=shots),
            VTKHDFExporter(plate, [displacement, velocity, damage], out / "plate", when=shots),
            PictureExporter(plate, damage, out / "damage", limits=(0.0, 0.6), size=(1400, 700), when=rbs.last),
            rbs.Checkpoint(out / "checkpoint.npz", when=rbs.realtime(60)),
        ],
        dt=dt,
        until=until,
        title=f"crack_branching, {stress / 1e6:g} MPa",
    )


def measure(analysis: rbs.Analysis) -> dict[str, object]:
    """When the crack starts, where it branches, how fast it runs, and the energy balance."""
    plate = analysis.parts[0]
    out = next(r.path.parent for r in analysis.relations if isinstance(r, CSVExporter))
    history = {name: np.array(column) for name, column in read_table(out / "history.csv").items()}
    time, place, away = (history[name] for name in ("time", "tip", "spread"))
    picture = plate[damage].reshape(plate.grid.shape[::-1])
    found = sum(history[name] for name in ("kinetic_energy", "strain_energy", "fracture_dissipation"))
    waves = wave_speeds(E, NU, RHO, plane="stress")
    speed = crack_speed(time, place)
    x, fronts = fronts_along(picture, plate.spacing)
    split = x[(x > 0) & (fronts >= 2)]
    return {
        "nodes": len(plate),
        "directed_bonds": len(plate.bonds),
        "broken_directed_bonds": int(np.count_nonzero(~plate.bonds.intact)),
        "asymmetry_of_damage_up_down": float(np.abs(picture - picture[::-1, :]).max()),
        "starts_at_s": first(time, place > 2 * plate.spacing),
        "branches_at_s": first(time, place > split.min()) if len(split) else float("inf"),
        "branches_at_m": float(split.min()) if len(split) else float("inf"),
        "cracks_side_by_side": int(fronts.max()),
        "largest_distance_from_axis_m": float(away[-1]),
        "tip_at_the_end_m": float(place[-1]),
        "right_edge_reached_at_s": first(time, place > LENGTH / 2 - 2 * plate.spacing),
        "tip_speed_mean_m_per_s": float(np.mean(speed)) if len(speed) else 0.0,
        "tip_speed_largest_m_per_s": float(np.max(speed, initial=0.0)),
        "rayleigh_speed_m_per_s": waves.rayleigh,
        "fracture_dissipation_J": float(history["fracture_dissipation"][-1]),
        "energy_error": float(abs(found[-1] / history["external_work"][-1] - 1)),
        "tip_history_s_m": np.column_stack([time, place]),
    }


def first(time: np.ndarray, happened: np.ndarray) -> float:
    """First time at which something has happened; infinity if never."""
    return float(time[np.argmax(happened)]) if happened.any() else float("inf")


def crack_speed(time: np.ndarray, place: np.ndarray, window: int = 9) -> np.ndarray:
    """Speeds of the tip while it runs inside of the plate: slopes of straight lines through `window` records."""
    running = np.flatnonzero((place > 0.001) & (place < 0.48 * LENGTH))
    starts = running[: max(len(running) - window + 1, 0)]
    return np.array([np.polyfit(time[i : i + window], place[i : i + window], 1)[0] for i in starts])


def fronts_along(picture: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """How many cracks lie above each other at each x: runs of cracked nodes with at least 1 mm between them."""
    gap = round(1e-3 / spacing)
    x = (np.arange(picture.shape[1]) + 0.5) * spacing - LENGTH / 2
    edge = round(EDGE / spacing)
    rows = [np.flatnonzero(column > CRACKED) for column in picture[edge:-edge].T]
    return x, np.array([0 if not len(row) else 1 + np.count_nonzero(np.diff(row) > gap) for row in rows])


if __name__ == "__main__":
    sys.exit(main(["run", __file__, *sys.argv[1:]]))
