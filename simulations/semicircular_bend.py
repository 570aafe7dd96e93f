"""Semi-circular bend: a half disk of PMMA with an inclined crack, under mode I to mode II (section 5.2 of Sarego 2016).

A half disk of 50 mm radius and 5 mm thickness stands on two supports 52 mm apart and is pressed on its top. A crack of
15 mm starts from the middle of its flat edge, at β = 0°, 10°, 30° or 50° from the vertical. The experiments are those
of Ayatollahi, Aliha & Hassani (2006); the dissertation of G. Sarego (Padova) compares cracks with them by eye, for an
ordinary state-based solid in plane stress, with δ = 3 mm and m = 2 to 4, and m = 3 and δ = 6 to 2 mm. The critical
stretch is that of a bond-based material, √(4πG0/(9Eδ)).

The dissertation omits the rest. Taken here: E = 2.94 GPa and Poisson's ratio 0.38, which it gives for the PMMA of its
next example; 1190 kg/m³; K_IC = 2 MPa√m, so G0 = K²/E = 1361 J/m²; the top, 3 mm wide and deep, moves down at a speed
that grows to 0.25 m/s within 0.2 ms. The supports, of the same size, cannot move up or down. Bonds within two horizons
of top and supports cannot break. What the crack of a linear elastic body does is known: it starts straight on for β =
0°, and at 70.5° to itself in pure mode II (largest hoop stress, Erdogan & Sih 1963).
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import rbs_core as rbs
from rbs_core.command import main
from rbs_plugins import (
    BoundaryDomain,
    CriticalStretch,
    CSVExporter,
    Damage,
    FractureDissipation,
    KineticEnergy,
    OrdinaryStateBased,
    PictureExporter,
    StrainEnergy,
    VelocityVerlet,
    VTKHDFExporter,
    read_table,
    total,
)
from rbs_plugins.fields import (
    damage,
    density,
    displacement,
    external_work,
    force_density,
    fracture_dissipation,
    kinetic_energy,
    strain_energy,
    velocity,
    volume,
)

RADIUS, CRACK, SUPPORT, THICKNESS = 0.05, 0.015, 0.026, 0.005  # m
E, NU, RHO = 2.94e9, 0.38, 1190.0  # Pa, 1, kg/m^3
PAD = 0.003  # m: width and depth of what presses and what supports
CRACKED = 0.35  # damage of a node beside a crack: about 0.4

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
    beta: float = 0.0,
    horizon: float = 3e-3,
    m: int = 3,
    toughness: float = 2e6,
    speed: float = 0.25,
    fracture: str = "bond-based stretch",
    until: float = 3e-3,
    courant: float = 0.7,
    out: str | Path = "out/semicircular_bend",
    frames: int = 100,
) -> rbs.Analysis:
    """The half disk with a crack at `beta` degrees from the vertical, and m spacings in a horizon.

    `fracture` is "bond-based stretch", as published, or "stretch", with which the solid takes G0 = `toughness`²/E.
    """
    spacing = horizon / m
    dt = courant * spacing / np.sqrt(E / RHO)
    shots = rbs.every(max(round(until / dt / frames), 1)) | rbs.last
    out = Path(out)

    half = rbs.Disk(RADIUS, (0.0, 0.0)) & rbs.Box.between((-RADIUS, 0.0), (RADIUS, RADIUS))
    disk = rbs.Part("disk", half).discretize(spacing, thickness=THICKNESS).connect(horizon * (1 + 1e-9))
    angle = np.radians(beta)
    disk.bonds.cut(rbs.Segment((0.0, -spacing), (CRACK * np.sin(angle), CRACK * np.cos(angle))))
    disk[density] = RHO

    places = ((0.0, RADIUS), (-SUPPORT, 0.0), (SUPPORT, 0.0))
    pads = [rbs.Box(size=(PAD, 2 * PAD), center=place) for place in places]
    top = BoundaryDomain(disk, pads[0], velocity=(None, lambda time: -speed * min(time / 2e-4, 1.0)))
    supports = BoundaryDomain(disk, pads[1] | pads[2], velocity=(None, 0.0))
    firm = [rbs.Disk(PAD + 2 * horizon, place) for place in places]
    may_break = rbs.Box(size=(4 * RADIUS, 4 * RADIUS)) - (firm[0] | firm[1] | firm[2])

    G0 = toughness**2 / E
    limit = {"s0": np.sqrt(4 * np.pi * G0 / (9 * E * horizon))} if fracture != "stretch" else {"fracture_energy": G0}
    solid = OrdinaryStateBased(disk, E=E, nu=NU, fracture=CriticalStretch(**limit, within=may_break))

    energies = [kinetic_energy, strain_energy, fracture_dissipation, external_work]
    force = total(force_density, pads[0], component="y", weights=volume, name="force")
    return rbs.Analysis(
        [
            *VelocityVerlet(disk).step(forces=[solid], boundaries=[top, supports]),
            Damage(disk, when=shots | rbs.once),
            CrackTimes(disk, when=shots | rbs.once),
            KineticEnergy(disk, when=shots),
            StrainEnergy(disk, [solid], when=shots),
            FractureDissipation(disk, when=shots),
            CSVExporter(disk, [force, *energies], out / "history.csv", when=shots),
            VTKHDFExporter(disk, [displacement, velocity, damage, cracked_at], out / "disk", when=shots),
            PictureExporter(disk, damage, out / "damage", limits=(0.0, 0.6), configuration="reference", when=rbs.last),
            rbs.Checkpoint(out / "checkpoint.npz", when=rbs.realtime(60)),
        ],
        dt=dt,
        until=until,
        title=f"semicircular_bend, {beta:g} degrees",
    )


def measure(analysis: rbs.Analysis) -> dict[str, object]:
    """Angles of the crack, where it goes, the largest load and the energy balance."""
    disk = analysis.parts[0]
    out = next(r.path.parent for r in analysis.relations if isinstance(r, CSVExporter))
    history = {name: np.array(column) for name, column in read_table(out / "history.csv").items()}
    found = sum(history[name] for name in ("kinetic_energy", "strain_energy", "fracture_dissipation"))
    return {
        "nodes": len(disk),
        "directed_bonds": len(disk.bonds),
        **the_crack(disk),
        "largest_load_N": float(np.abs(history["force"]).max()),
        "kinetic_share_at_largest_load": float(
            (history["kinetic_energy"] / found)[np.argmax(np.abs(history["force"]))]
        ),
        "fracture_dissipation_J": float(history["fracture_dissipation"][-1]),
        "energy_error": float(abs(found[-1] / history["external_work"][-1] - 1)),
    }


def the_crack(disk: rbs.Part) -> dict[str, object]:
    """How the nodes that have cracked lie to the notch: its middle line from the tip on, and its end."""
    when = disk[cracked_at]
    notch = disk.positions[when == when.min()]
    along = np.linalg.svd(notch - notch.mean(axis=0))[2][0]  # the straight line between the nodes on both sides
    beta = np.arctan2(*(along * np.sign(along[1])))
    new = (when > when.min()) & (when < NEVER)
    way = disk.positions - CRACK * np.array([np.sin(beta), np.cos(beta)])
    distance = np.hypot(*way.T)
    horizon = disk.bonds.horizon
    near = new & (distance > horizon) & (distance < 4 * horizon)
    if not near.any():
        return {"cracked_nodes": int(new.sum())}
    x, y = way[near].mean(axis=0)
    end = disk.positions[new][np.argmax(disk.positions[new, 1])]
    return {
        "cracked_nodes": int(new.sum()),
        # counted from the direction of the notch to the left
        "kink_angle_deg": float(np.degrees(np.arctan2(-x, y) + beta)),
        "starts_at_s": float(when[new].min()),
        "end_of_crack_m": end.tolist(),
        "middle_line_m": middle_line(disk, new),
    }


def middle_line(disk: rbs.Part, new: np.ndarray, width: float = 2e-3) -> np.ndarray:
    """Points (k, 2), m, on the crack: the mean of the cracked nodes in layers of a height `width`."""
    cracked = disk.positions[new]
    layers = np.floor(cracked[:, 1] / width)
    return np.array([cracked[layers == layer].mean(axis=0) for layer in np.unique(layers)])


if __name__ == "__main__":
    sys.exit(main(["run", __file__, *sys.argv[1:]]))
