"""A bar of aluminium rings: longitudinal waves against d'Alembert (sections 2.5 and 3.3 of Hashim 2021).

A bar of 254 mm is clamped at x = 0, free at its other end, and starts with the velocity 100 m/s x/L in its axis. Of the
thesis of N. A. Hashim (Durham) are E = 69 GPa, Poisson's ratio 0.33, 2710 kg/m^3, a lattice of 99 x 5 nodes with a
horizon of 3.015 spacings, time steps of 50 ns and a layer as wide as the horizon whose nodes do not move. It shows
displacement and velocity at x = 254, 127 and 51 mm and the stress and strain at 127 mm, bond-based (2.5) and as
correspondence without control of zero-energy modes (3.3), whose velocities oscillate. There are curves only, "in good
agreement" with theory, no numbers.

Theory is a thin linear bar with waves of √(E/ρ) = 5046 m/s, which come back after 4L/c = 201 µs. It has a closed form.

The thesis omits the rest. Taken here: plane stress, as theory has it; bond-based 1/3 for Poisson's ratio; Hencky's law
for the correspondence, as in the other chapters; nodes in the middle of 99 x 5 square cells that fill the length, so
12.83 mm of depth in place of 12; 1.1 periods. Theory is taken where the columns of nodes nearest to the places are, and
compared with the mean over a column; zero-energy modes change their sign from node to node, so the velocity of the
node on the axis is looked at as well.
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
    Correspondence,
    CSVExporter,
    KineticEnergy,
    PictureExporter,
    Strain,
    StrainEnergy,
    Stress,
    VelocityVerlet,
    VTKHDFExporter,
    mean,
    read_table,
)
from rbs_plugins.constitutive import stress as laws
from rbs_plugins.fields import density, displacement, kinetic_energy, strain, strain_energy, stress, velocity

LENGTH, THICKNESS = 0.254, 1e-3  # m
E, NU, RHO = 69e9, 0.33, 2710.0  # Pa, 1, kg/m^3
SPEED = 100.0  # m/s: of the free end at the start
PLACES = {"254_mm": 0.254, "127_mm": 0.127, "51_mm": 0.051}  # m
WAVE = np.sqrt(E / RHO)
PERIOD = 4 * LENGTH / WAVE


def scene(
    model: str = "bond-based",
    n: int = 99,
    rows: int = 5,
    m: float = 3.015,
    dt: float = 5e-8,
    periods: float = 1.1,
    plane: str = "stress",
    law: str = "hencky",
    stabilization: str = "none",
    surface_correction: str = "none",
    linear: bool = False,
    out: str | Path = "out/aluminium_bar",
    frames: int = 100,
) -> rbs.Analysis:
    """The bar with n x rows nodes and m spacings in a horizon; dt is that for n = 99.

    `model` is "bond-based", which takes `surface_correction` and `linear`, or "correspondence", which takes `law` and
    `stabilization`.
    """
    spacing = LENGTH / n
    dt = dt * 99 / n
    until = periods * PERIOD
    shots = rbs.every(max(round(until / dt / frames), 1)) | rbs.last
    out = Path(out)

    depth = rows * spacing
    layer = int(m) * spacing
    bar = rbs.Part("bar", rbs.Box.between((-layer, -depth / 2), (LENGTH, depth / 2)))
    bar.discretize(spacing, thickness=THICKNESS)
    bar.connect(horizon=m * spacing)
    bar[density] = RHO
    bar[velocity] = lambda X: SPEED / LENGTH * np.column_stack([np.maximum(X[:, 0], 0.0), 0.0 * X[:, 0]])

    if model == "bond-based":
        nu = 1 / 3 if plane == "stress" else 1 / 4
        solid = BondBased(bar, E=E, nu=nu, plane=plane, surface_correction=surface_correction, linear=linear)
    elif model == "correspondence":
        control = None if stabilization == "none" else stabilization
        solid = Correspondence(bar, getattr(laws, law), E=E, nu=NU, plane=plane, stabilization=control)
    else:
        raise ValueError(f'model="{model}": "bond-based" or "correspondence"')
    clamp = BoundaryDomain(bar, rbs.Box.between((-layer, -depth), (0.0, depth)), velocity=(0.0, 0.0))

    columns = {name: column(bar, x) for name, x in PLACES.items()}
    waves = [
        mean(field, where, component="x", name=f"{letter}_{name}")
        for letter, field in (("u", displacement), ("v", velocity))
        for name, where in columns.items()
    ]
    axis = [
        mean(velocity, where[len(where) // 2 : len(where) // 2 + 1], component="x", name=f"v_of_one_node_{name}")
        for name, where in columns.items()
    ]
    middle = [
        mean(field, columns["127_mm"], component="xx", name=f"{name}_127_mm")
        for name, field in (("strain", strain), ("stress", stress))
    ]
    return rbs.Analysis(
        [
            *VelocityVerlet(bar).step(forces=[solid], boundaries=[clamp]),
            KineticEnergy(bar),
            StrainEnergy(bar, [solid]),
            Strain(bar, when=shots),
            *([Stress(bar, [solid], when=shots)] if model == "bond-based" else []),  # the other one has its own
            CSVExporter(bar, [*waves, *axis, kinetic_energy, strain_energy], out / "history.csv"),
            CSVExporter(bar, middle, out / "stress_strain.csv", when=shots),
            VTKHDFExporter(bar, [displacement, velocity, strain, stress], out / "bar", when=shots),
            PictureExporter(bar, displacement, out / "displacement", component="x", scale=5.0, when=rbs.last),
            rbs.Checkpoint(out / "checkpoint.npz", when=rbs.realtime(60)),
        ],
        dt=dt,
        until=until,
        title=f"aluminium_bar, {model}",
    )


def column(bar: rbs.Part, x: float) -> np.ndarray:
    """The nodes that are nearest to x, one in each row."""
    distance = np.abs(bar.positions[:, 0] - x)
    return np.flatnonzero(distance < distance.min() + 1e-6 * bar.spacing)


def theory(x: float, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Displacement, velocity and strain of the thin bar: two waves that run to the left and to the right.

    Mirrored at both ends, the velocity at the start is a triangular wave over x of the period 4 L.
    """
    ahead, behind = x + WAVE * time, x - WAVE * time

    def start(x: np.ndarray) -> np.ndarray:
        return SPEED * (1 - np.abs((x / LENGTH + 1) % 4 - 2))

    def its_integral(x: np.ndarray) -> np.ndarray:
        y = (x / LENGTH + 1) % 4 - 1
        return SPEED * LENGTH * np.where(y < 1, y**2 / 2, 1 - (y - 2) ** 2 / 2)

    u = (its_integral(ahead) - its_integral(behind)) / (2 * WAVE)
    return u, (start(ahead) + start(behind)) / 2, (start(ahead) - start(behind)) / (2 * WAVE)


def measure(analysis: rbs.Analysis) -> dict[str, object]:
    """Errors over time of displacement and velocity at three places, the period, stress over strain, and the energy."""
    bar = analysis.parts[0]
    tables = {r.path.stem: r.path.with_suffix(".csv") for r in analysis.relations if isinstance(r, CSVExporter)}
    history, middle = ({k: np.array(v) for k, v in read_table(tables[name]).items()} for name in tables)
    time = history["time"]
    first = time <= PERIOD
    energy = history["kinetic_energy"] + history["strain_energy"]
    found: dict[str, object] = {"nodes": len(bar), "directed_bonds": len(bar.bonds)}
    window = round(4 * bar.bonds.horizon / WAVE / (time[1] - time[0]))
    for name, place in PLACES.items():
        at = float(bar.positions[column(bar, place)[0], 0])
        u, v, _ = theory(at, time)
        errors = {
            "displacement": history[f"u_{name}"] - u,
            "velocity": history[f"v_{name}"] - v,
        }
        smooth = running_mean(errors["velocity"], window)
        found[f"displacement_error_{name}"] = rms(errors["displacement"][first]) / rms(u[first])
        found[f"velocity_error_{name}"] = rms(errors["velocity"][first]) / rms(v[first])
        found[f"mean_velocity_error_{name}"] = rms(smooth[first]) / rms(v[first])
        found[f"oscillation_of_velocity_{name}"] = rms((errors["velocity"] - smooth)[first]) / rms(v[first])
        alone = history[f"v_of_one_node_{name}"] - v
        found[f"oscillation_of_one_node_{name}"] = rms((alone - running_mean(alone, window))[first]) / rms(v[first])
        found[f"largest_displacement_{name}_m"] = float(history[f"u_{name}"].max())
        found[f"largest_displacement_{name}_of_theory_m"] = float(u.max())
    crossings = zeros(time, history["u_254_mm"])
    slope = np.sum(middle["strain_127_mm"] * middle["stress_127_mm"]) / np.sum(middle["strain_127_mm"] ** 2)
    wanted = theory(float(bar.positions[column(bar, 0.127)[0], 0]), middle["time"])[2]
    return {
        **found,
        "half_period_s": float(crossings[0]),
        "period_s": float(crossings[1]) if len(crossings) > 1 else float("nan"),
        "period_error": float(crossings[1] / PERIOD - 1) if len(crossings) > 1 else float("nan"),
        "stress_over_strain_Pa": float(slope),
        "strain_error_127_mm": rms(middle["strain_127_mm"] - wanted) / rms(wanted),
        "stress_error_127_mm": rms(middle["stress_127_mm"] - E * wanted) / rms(E * wanted),
        "energy_drift": float(np.abs(energy / energy[0] - 1).max()),
    }


def rms(values: np.ndarray) -> float:
    """Root of the mean of the squares."""
    return float(np.sqrt(np.mean(np.square(values))))


def running_mean(values: np.ndarray, window: int) -> np.ndarray:
    """The mean over as many values around each one, fewer at the ends."""
    sums = np.convolve(values, np.ones(window), mode="same")
    return sums / np.convolve(np.ones(len(values)), np.ones(window), mode="same")


def zeros(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """When the values change their sign after the start."""
    at = np.flatnonzero(values[1:-1] * values[2:] <= 0) + 1
    return time[at] - values[at] * (time[at + 1] - time[at]) / (values[at + 1] - values[at])


if __name__ == "__main__":
    sys.exit(main(["run", __file__, *sys.argv[1:]]))
