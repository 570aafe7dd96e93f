"""Kalthoff-Winkler: a notched plate that is hit cracks at 70 degrees to its notches (Kalthoff & Winkler 1988).

The case of section 5.1 of G. Sarego's dissertation: a plate of 50 mm x 100 mm with two horizontal notches of 25 mm, of
which the upper half is simulated, on 50 x 50 nodes with a horizon of 4 mm and a time step of 125 ns. E = 190 GPa,
Poisson's ratio 1/4, so plane strain. The crack leaves the tip of the notch at about 70 degrees, in the experiment
as well as in the dissertation, where a second crack grows from the right edge.

The dissertation omits the rest. Taken here: 8000 kg/m^3 and G0 = 22.13 kJ/m^2, usual for the maraging steel of the
experiment; 12.5 mm from the axis of symmetry to the notch, half of the usual, as the plate is half of the usual one;
the edge between the notches moves at 16.5 m/s from the first moment on, half of the speed (33 m/s) of a projectile of
the same impedance. This edge is one row of nodes, and so is the axis of symmetry, whose nodes do not move across it.
simulations/README.md tells what changes with these choices.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.ndimage import label

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

WIDTH, HALF, NOTCH, THICKNESS = 0.05, 0.05, 0.025, 0.009  # m: along the notch, of half of the plate, of the notch
E, NU, RHO = 190e9, 1 / 4, 8000.0  # Pa, 1, kg/m^3
CRACKED = 0.38  # damage of a node beside a crack: 20 of its 48 bonds cross a straight one, 0.42
NEVER = 1.0  # s

cracked_at = rbs.Field("cracked_at", "node", "scalar", "s", "t_c", "When a crack came by.", initial=NEVER)


class CrackTimes(rbs.Measure):
    """Writes when each node cracked."""

    reads = (damage,)
    updates = (cracked_at,)

    def apply(self, clock: rbs.Clock) -> None:
        """Looks at all nodes whose damage says that a crack passes beside them."""
        fresh = (self[damage] > CRACKED) & (self[cracked_at] == NEVER)
        self[cracked_at][fresh] = clock.time


def scene(
    n: int = 50,
    horizon: float = 4e-3,
    speed: float = 16.5,
    fracture_energy: float = 22.13e3,
    axis: float = 0.0125,
    half: bool = True,
    rows: int = 1,
    until: float = 100e-6,
    dt: float = 125e-9,
    release: str = "at once",
    partial_volume: str = "none",
    out: str | Path = "out/kalthoff_winkler",
    frames: int = 100,
) -> rbs.Analysis:
    """The upper half of the plate with n x n nodes, or the whole one; dt is that for n = 50.

    `axis` is the distance of the notch from the axis of symmetry, `rows` how many rows of nodes the projectile moves.
    """
    spacing = WIDTH / n
    dt = dt * 50 / n
    shots = rbs.every(max(round(until / dt / frames), 1)) | rbs.last
    out = Path(out)

    plate = rbs.Part("plate", rbs.Box.between((0.0, 0.0 if half else -HALF), (WIDTH, HALF)))
    plate.discretize(spacing, thickness=THICKNESS)
    plate.connect(horizon=horizon * (1 + 1e-9))
    for y in (axis,) if half else (axis, -axis):
        plate.bonds.cut(rbs.Segment((0.0, y), (NOTCH, y)))
    plate[density] = RHO

    brittle = CriticalStretch(fracture_energy=fracture_energy, release=release)
    steel = BondBased(plate, E=E, nu=NU, plane="strain", fracture=brittle, partial_volume=partial_volume)
    below = axis - 1e-3 * spacing  # with n = 50 the notch runs along a row of nodes, which belong to its upper side
    edge = rbs.Box.between((0.0, -below), (rows * spacing, below))
    boundaries = [BoundaryDomain(plate, edge, velocity=(speed, None))]
    if half:
        rollers = rbs.Box.between((0.0, 0.0), (WIDTH, spacing))
        boundaries.append(BoundaryDomain(plate, rollers, velocity=(None, 0.0)))

    energies = [kinetic_energy, strain_energy, fracture_dissipation, external_work]
    return rbs.Analysis(
        [
            *VelocityVerlet(plate).step(forces=[steel], boundaries=boundaries),
            Damage(plate, when=shots),
            CrackTimes(plate, when=shots),
            KineticEnergy(plate, when=shots),
            StrainEnergy(plate, [steel], when=shots),
            FractureDissipation(plate, when=shots),
            CSVExporter(plate, energies, out / "history.csv", when=shots),
            VTKHDFExporter(plate, [displacement, velocity, damage, cracked_at], out / "plate", when=shots),
            PictureExporter(plate, damage, out / "damage", limits=(0.0, 0.6), configuration="reference", when=rbs.last),
            rbs.Checkpoint(out / "checkpoint.npz", when=rbs.realtime(60)),
        ],
        dt=dt,
        until=until,
        title=f"kalthoff_winkler, {speed:g} m/s",
    )


def measure(analysis: rbs.Analysis) -> dict[str, object]:
    """Angle of the crack, when it starts, how fast it runs, whether the far edge cracks, and the energy balance."""
    plate = analysis.parts[0]
    out = next(r.path.parent for r in analysis.relations if isinstance(r, CSVExporter))
    history = {name: np.array(column) for name, column in read_table(out / "history.csv").items()}
    found = sum(history[name] for name in ("kinetic_energy", "strain_energy", "fracture_dissipation"))
    picture = plate[damage].reshape(plate.grid.shape[::-1])
    mirrored = picture[: len(picture) // 2][::-1] - picture[len(picture) // 2 :]
    return {
        "nodes": len(plate),
        "directed_bonds": len(plate.bonds),
        "broken_directed_bonds": int(np.count_nonzero(~plate.bonds.intact)),
        **the_crack(plate, history["time"]),
        "rayleigh_speed_m_per_s": wave_speeds(E, NU, RHO).rayleigh,
        "asymmetry_of_damage_up_down": float(np.abs(mirrored).max()) if plate.geometry.bounds[0][1] < 0 else 0.0,
        "fracture_dissipation_J": float(history["fracture_dissipation"][-1]),
        "energy_error": float(np.abs(found / history["external_work"] - 1)[-1]),
    }


def the_crack(plate: rbs.Part, times: np.ndarray) -> dict[str, object]:
    """The crack that leaves the upper notch: its angle over the first 20 mm, its start and its speed."""
    x, y, when = *plate.positions.T, plate[cracked_at]
    spacing = plate.spacing
    # nodes that cracked and hang together with the notch, and those on the right edge
    shape = plate.grid.shape[::-1]
    names = label((when < NEVER).reshape(shape), np.ones((3, 3)))[0].ravel()
    notch = np.flatnonzero((when <= times[0]) & (y > 0))
    start = np.array([NOTCH, y[notch].mean()])
    ours = (names == names[notch[0]]) & (when > times[0]) & (x > NOTCH - 2 * spacing) & (y > start[1])
    far = (when < NEVER) & (x > WIDTH - 2 * spacing) & (np.abs(y) < HALF / 2)
    way = np.column_stack([x, y]) - start
    distance = np.hypot(*way.T)
    near = ours & (distance < 0.02)
    tip = np.array([distance[ours & (when <= time)].max(initial=0.0) for time in times])
    speed = crack_speed(times, tip)
    result: dict[str, object] = {"cracked_nodes": int(ours.sum())}
    if near.sum() > 2:
        # the straight line through the nodes with the least sum of squared distances
        along = np.linalg.svd(way[near] - way[near].mean(axis=0))[2][0]
        end = way[ours][np.argmax(distance[ours])]
        result |= {
            "crack_angle_deg": float(np.degrees(np.arctan2(along[1], along[0])) % 180),
            "angle_from_notch_to_end_deg": float(np.degrees(np.arctan2(end[1], end[0]))),
            "starts_at_s": float(when[near].min()),
            "end_of_crack_m": (start + end).tolist(),
            "end_of_crack_at_s": float(when[ours].max()),
            "tip_speed_mean_m_per_s": float(speed.mean()) if len(speed) else 0.0,
            "tip_speed_largest_m_per_s": float(speed.max(initial=0.0)),
        }
    if far.any():
        first = np.flatnonzero(far)[np.argmin(when[far])]
        result |= {"right_edge_cracks_at_s": float(when[first]), "right_edge_cracks_at_y_m": float(y[first])}
    return {**result, "tip_history_s_m": np.column_stack([times, tip])}


def crack_speed(time: np.ndarray, tip: np.ndarray, window: int = 9) -> np.ndarray:
    """Speeds of the tip while it runs: slopes of straight lines through `window` records."""
    running = np.flatnonzero((tip > 0.002) & (tip < 0.95 * tip.max()))
    starts = running[: max(len(running) - window + 1, 0)]
    return np.array([np.polyfit(time[i : i + window], tip[i : i + window], 1)[0] for i in starts])


if __name__ == "__main__":
    sys.exit(main(["run", __file__, *sys.argv[1:]]))
