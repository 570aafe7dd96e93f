"""A square plate of PMMA with an inclined crack, pulled along its diagonal: three criteria (Sarego 2016, 5.2).

A plate of 150 mm x 150 mm x 5 mm has a crack of 45 mm in its centre and a hole of 4 mm radius near two opposite
corners: one hole is held by a pin, the other pulled away along the diagonal. The angle α between the crack and the
normal of the diagonal is 45°; 0° would be pure mode I, 62.5° pure mode II. The experiments are those of Ayatollahi &
Aliha (2009); the dissertation of G. Sarego (Padova) compares by eye, for an ordinary state-based solid in plane stress
with E = 2.94 GPa and Poisson's ratio 0.38, and three criteria: the critical stretch of a bond-based material, a
critical energy of the bond, and one of its nodes. The first two give sharp cracks, the third smears the damage.

The dissertation omits the rest. Taken here: δ = 5 mm, m = 3; holes 20 mm from both edges; pins that hold all nodes
within one spacing of the rim; 1190 kg/m³; K_IC = 2 MPa√m, so G0 = K²/E = 1361 J/m²; a pull that grows to 0.3 m/s within
0.2 ms. Bonds within two horizons of a hole cannot break. The third criterion compares the energy of a mean bond of both
nodes with the limit of the second one (see CriticalNodalEnergy), because the dissertation compares different units.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import rbs_core as rbs
from rbs_core.command import main
from rbs_plugins import (
    BoundaryDomain,
    CriticalBondEnergy,
    CriticalNodalEnergy,
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
    critical_bond_energy,
    read_table,
    total,
)
from rbs_plugins.constitutive.bond_based import critical_stretch
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

SIDE, CRACK, HOLE, THICKNESS = 0.15, 0.045, 0.004, 0.005  # m
E, NU, RHO = 2.94e9, 0.38, 1190.0  # Pa, 1, kg/m^3
CRACKED = 0.35  # damage of a node beside a crack: about 0.4
DAMAGED = 0.15  # of a node that is damaged at all
NEVER = 1.0  # s
DIAGONAL = np.array([1.0, 1.0]) / np.sqrt(2)

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
    alpha: float = 45.0,
    criterion: str = "stretch",
    mode: str = "tension",
    horizon: float = 5e-3,
    m: int = 3,
    toughness: float = 2e6,
    hole: float = 0.02,
    speed: float = 0.3,
    until: float = 5e-3,
    courant: float = 0.7,
    out: str | Path = "out/diagonal_plate",
    frames: int = 100,
) -> rbs.Analysis:
    """The plate with a crack at `alpha` degrees, and m spacings in a horizon; `hole` is its distance from the edges.

    `criterion` is "stretch", "bond energy" or "nodal energy"; `mode` says whether shortened bonds fail by energy, too.
    """
    spacing = horizon / m
    dt = courant * spacing / np.sqrt(E / RHO)
    shots = rbs.every(max(round(until / dt / frames), 1)) | rbs.last
    out = Path(out)

    place = SIDE / 2 - hole
    holes = [rbs.Disk(HOLE, (place, place)), rbs.Disk(HOLE, (-place, -place))]
    plate = rbs.Part("plate", rbs.Box(size=(SIDE, SIDE)) - (holes[0] | holes[1]))
    plate.discretize(spacing, thickness=THICKNESS).connect(horizon * (1 + 1e-9))
    angle = np.radians(135 + alpha)
    end = CRACK / 2 * np.array([np.cos(angle), np.sin(angle)])
    plate.bonds.cut(rbs.Segment(-end, end))
    plate[density] = RHO

    rims = [rbs.Disk(HOLE + spacing, each.center) for each in holes]
    pull = BoundaryDomain(plate, rims[0], velocity=(lambda time: speed * min(time / 2e-4, 1.0) * DIAGONAL[0],) * 2)
    pin = BoundaryDomain(plate, rims[1], velocity=(0.0, 0.0))
    firm = [rbs.Disk(HOLE + 2 * horizon, each.center) for each in holes]
    may_break = rbs.Box(size=(2 * SIDE, 2 * SIDE)) - (firm[0] | firm[1])

    G0 = toughness**2 / E
    criteria = {
        "stretch": CriticalStretch(critical_stretch(G0, E, horizon, "stress"), within=may_break),
        "bond energy": CriticalBondEnergy(fracture_energy=G0, mode=mode, within=may_break),
        "nodal energy": CriticalNodalEnergy(
            critical_bond_energy(G0, 2, horizon, THICKNESS), mode=mode, within=may_break
        ),
    }
    solid = OrdinaryStateBased(plate, E=E, nu=NU, fracture=criteria[criterion])

    energies = [kinetic_energy, strain_energy, fracture_dissipation, external_work]
    force = total(force_density, rims[1], component="x", weights=volume, name="force")
    return rbs.Analysis(
        [
            *VelocityVerlet(plate).step(forces=[solid], boundaries=[pull, pin]),
            Damage(plate, when=shots | rbs.once),
            CrackTimes(plate, when=shots | rbs.once),
            KineticEnergy(plate, when=shots),
            StrainEnergy(plate, [solid], when=shots),
            FractureDissipation(plate, when=shots),
            CSVExporter(plate, [force, *energies], out / "history.csv", when=shots),
            VTKHDFExporter(plate, [displacement, velocity, damage, cracked_at], out / "plate", when=shots),
            PictureExporter(plate, damage, out / "damage", limits=(0.0, 0.6), configuration="reference", when=rbs.last),
            rbs.Checkpoint(out / "checkpoint.npz", when=rbs.realtime(60)),
        ],
        dt=dt,
        until=until,
        title=f"diagonal_plate, {criterion}",
    )


def measure(analysis: rbs.Analysis) -> dict[str, object]:
    """Angles of the cracks at both tips, how wide the damage is, the largest load and the energy balance."""
    plate = analysis.parts[0]
    out = next(r.path.parent for r in analysis.relations if isinstance(r, CSVExporter))
    history = {name: np.array(column) for name, column in read_table(out / "history.csv").items()}
    found = sum(history[name] for name in ("kinetic_energy", "strain_energy", "fracture_dissipation"))
    return {
        "nodes": len(plate),
        "directed_bonds": len(plate.bonds),
        **the_cracks(plate),
        "largest_load_N": float(np.sqrt(2) * np.abs(history["force"]).max()),
        "kinetic_share_at_largest_load": float(
            (history["kinetic_energy"] / found)[np.argmax(np.abs(history["force"]))]
        ),
        "fracture_dissipation_J": float(history["fracture_dissipation"][-1]),
        "energy_error": float(abs(found[-1] / history["external_work"][-1] - 1)),
    }


def the_cracks(plate: rbs.Part) -> dict[str, object]:
    """What has grown from both tips of the first crack, and how wide it is."""
    when, broken, positions = plate[cracked_at], plate[damage], plate.positions
    horizon = plate.bonds.horizon
    before = positions[when == when.min()]
    along = np.linalg.svd(before)[2][0]  # the straight line between the nodes on both sides
    new = (when > when.min()) & (when < NEVER)
    result: dict[str, object] = {"cracked_nodes": int(new.sum())}
    if not new.any():
        return result
    lengths = []
    for name, sign in (("one", 1.0), ("other", -1.0)):
        direction = sign * along
        way = positions - CRACK / 2 * direction
        distance = np.hypot(*way.T)
        side = new & (positions @ direction > 0)
        near = side & (distance > horizon) & (distance < 4 * horizon)
        x, y = way[near].mean(axis=0) if near.any() else direction
        turned = np.arctan2(direction[0] * y - direction[1] * x, direction @ (x, y))
        lengths.append(distance[side].max(initial=0.0))
        result |= {
            f"kink_angle_of_{name}_tip_deg": float(np.degrees(turned)),  # to the left, as seen from the centre
            f"end_of_{name}_crack_m": positions[side][np.argmax(distance[side])].tolist() if side.any() else [],
        }
    cell = plate.spacing**2
    # away from the first crack, where nodes are damaged from the start
    apart = np.abs(positions @ along) > CRACK / 2 + horizon
    result["width_of_damage_m"] = float(
        ((broken > DAMAGED) & apart).sum() * cell / max(sum(lengths) - 2 * horizon, 1e-9)
    )
    return {**result, "starts_at_s": float(when[new].min())}


if __name__ == "__main__":
    sys.exit(main(["run", __file__, *sys.argv[1:]]))
