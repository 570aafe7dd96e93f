"""Direction of a crack under tension and shear, which depends on Poisson's ratio (section 5.2 of Sarego 2016).

A square plate, notched from its left edge to its centre, is stretched and sheared at the same rate v/a, so that σ22 = E
v t/a, σ12 = μ v t/a and σ11 = 0. The largest principal stress is normal to a line at ψ = ½ arctan(1/(1 + ν)) from the
notch: 21.14° for ν = 0.1 (21.17° in print) and 17.77° for ν = 0.4. The dissertation of G. Sarego (Padova), after
Silling et al. (2007), says that cracks begin to follow it as m = δ/h grows from 3 to 7. Ordinary state-based solid in
plane stress, critical stretch 0.1 %.

The dissertation omits the rest. Taken here: a = 100 mm, horizon 3 mm, E = 100 GPa, 8000 kg/m³, v = 0.1 m/s. All four
edges, one horizon deep, follow the uniform strain; all nodes start with its velocity, so no wave runs. The influence
function is constant, and only bonds inside of the edges may break.

Mohr's circle knows nothing of the notch. With K_II/K_I = 1/(2 + 2ν) the largest hoop stress around its tip is at 38.2°
for ν = 0.1 and 33.6° for ν = 0.4 (`kink_of_largest_hoop_stress_deg`; Erdogan & Sih 1963, for an infinite plate).
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
)
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

SIDE, E, RHO = 0.1, 100e9, 8000.0  # m, Pa, kg/m^3
CRACKED = 0.3  # damage of a node beside a crack: about 0.4

tip = rbs.Field("tip", "part", "scalar", "m", "x", "Rightmost x of the cracked nodes.")


class CrackTip(rbs.Measure):
    """Writes how far to the right nodes are cracked."""

    reads = (damage, rbs.reference_position)
    writes = (tip,)

    def apply(self, clock: rbs.Clock) -> None:
        """Looks at the nodes whose damage says that a crack passes beside them."""
        self[tip][...] = self[rbs.reference_position][self[damage] > CRACKED, 0].max(initial=0.0)


def scene(
    nu: float = 0.1,
    m: int = 3,
    horizon: float = 3e-3,
    s0: float = 1e-3,
    speed: float = 0.1,
    edges: str = "all",
    influence: str = "constant",
    until: float = 0.3e-3,
    courant: float = 0.7,
    out: str | Path = "out/sarego_poisson_angle",
    frames: int = 50,
) -> rbs.Analysis:
    """The plate for a Poisson's ratio, with m spacings in a horizon; `edges` that move: "all", or "top and bottom"."""
    spacing = horizon / m
    dt = courant * spacing / np.sqrt(E / RHO)
    shots = rbs.every(max(round(until / dt / frames), 1)) | rbs.last
    out = Path(out)

    plate = rbs.Part("plate", rbs.Box(size=(SIDE, SIDE)))
    plate.discretize(spacing, thickness=spacing)
    plate.connect(horizon=horizon * (1 + 1e-9))
    plate.bonds.cut(rbs.Segment((-SIDE / 2, 0.0), (0.0, 0.0)))
    plate[density] = RHO

    def flow(positions: np.ndarray) -> np.ndarray:
        """Velocity (n, 2) of the uniform strain: stretch and shear at the rate v/a, and no stress along the notch."""
        x, y = positions.T
        return speed / SIDE * np.column_stack([y - nu * x, y])

    plate[velocity] = flow(plate.positions)
    inner = rbs.Box(size=(SIDE - 2 * horizon, SIDE - 2 * horizon))
    moved = ~inner if edges == "all" else ~rbs.Box(size=(2 * SIDE, SIDE - 2 * horizon))
    nodes = plate.where(moved)
    grip = BoundaryDomain(plate, nodes, velocity=flow(plate.positions[nodes]))
    brittle = CriticalStretch(s0, within=inner)
    solid = OrdinaryStateBased(plate, E=E, nu=nu, fracture=brittle, influence=influence)

    energies = [kinetic_energy, strain_energy, fracture_dissipation, external_work]
    return rbs.Analysis(
        [
            *VelocityVerlet(plate).step(forces=[solid], boundaries=[grip]),
            Damage(plate, when=shots),
            CrackTip(plate, when=shots),
            KineticEnergy(plate, when=shots),
            StrainEnergy(plate, [solid], when=shots),
            FractureDissipation(plate, when=shots),
            CSVExporter(plate, [tip, *energies], out / "history.csv", when=shots),
            VTKHDFExporter(plate, [displacement, velocity, damage], out / "plate", when=shots),
            PictureExporter(plate, damage, out / "damage", limits=(0.0, 0.6), configuration="reference", when=rbs.last),
            rbs.Checkpoint(out / "checkpoint.npz", when=rbs.realtime(60)),
        ],
        dt=dt,
        until=until,
        title=f"sarego_poisson_angle, nu = {nu:g}, m = {m}",
    )


def measure(analysis: rbs.Analysis) -> dict[str, object]:
    """Angle of the crack from the notch at several distances of its tip, and the two theories."""
    plate = analysis.parts[0]
    solid = next(r for r in analysis.relations if isinstance(r, OrdinaryStateBased))
    out = next(r.path.parent for r in analysis.relations if isinstance(r, CSVExporter))
    history = {name: np.array(column) for name, column in read_table(out / "history.csv").items()}
    nu, horizon = float(solid.nu), plate.bonds.horizon
    ratio = 1 / (2 + 2 * nu)
    started = np.flatnonzero(history["tip"] > horizon)
    return {
        "nodes": len(plate),
        "directed_bonds": len(plate.bonds),
        "angle_deg": angle(plate, horizon, 5 * horizon),
        "angle_near_the_tip_deg": angle(plate, horizon, 3 * horizon),
        "angle_from_notch_to_end_deg": angle(plate, history["tip"][-1] - horizon, np.inf),
        "angle_of_largest_principal_stress_deg": float(np.degrees(0.5 * np.arctan(2 * ratio))),
        "kink_of_largest_hoop_stress_deg": float(
            np.degrees(2 * np.arctan((np.sqrt(1 + 8 * ratio**2) - 1) / (4 * ratio)))
        ),
        "starts_at_s": float(history["time"][started[0]]) if len(started) else float("inf"),
        "tip_at_the_end_m": float(history["tip"][-1]),
        "energy_error": energy_error(history),
    }


def angle(plate: rbs.Part, near: float, far: float) -> float:
    """Angle below the notch's axis, degrees, of the cracked nodes at these distances from its tip, by damage."""
    x, y = plate.positions.T
    distance = np.hypot(x, y)
    crack = (plate[damage] > CRACKED) & (x > 0) & (distance > near) & (distance < far)
    weights = plate[damage][crack]
    return float(np.degrees(np.arctan2(-(weights * y[crack]).sum(), (weights * x[crack]).sum())))


def energy_error(history: dict[str, np.ndarray]) -> float:
    """How far kinetic, strain and fracture energy have grown apart from the work, in units of all of it."""
    found = sum(history[name] for name in ("kinetic_energy", "strain_energy", "fracture_dissipation"))
    return float(abs(found[-1] - found[0] - history["external_work"][-1] + history["external_work"][0]) / found.max())


if __name__ == "__main__":
    sys.exit(main(["run", __file__, *sys.argv[1:]]))
