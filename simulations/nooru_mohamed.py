"""Nooru-Mohamed's double-edge-notched concrete under shear and tension: three criteria (section 5.2 of Sarego 2016).

A plate of concrete, 200 mm x 200 mm x 50 mm, has notches of 25 mm in the middle of its left and right edge. It is
sheared first, then pulled apart; two curved cracks leave the notches, each the image of the other under a turn by 180°
(Nooru-Mohamed 1992, load path 4). The dissertation of G. Sarego (Padova) compares with the front of the specimen by
eye: ordinary state-based solid in plane strain, E = 30 GPa, Poisson's ratio 0.2, G0 = 110 J/m², δ = 20 mm and m = 3 to
start from, time step 500 ns, three criteria: the critical stretch of a bond-based material in plane stress, a critical
energy of the bond, and one of its nodes, which smears the damage.

The dissertation omits the load. Taken here: a shear force of 10 kN, as in load path 4b, that grows in 0.5 ms and stays.
It pushes the upper part of the left edge to the right and the lower part of the right edge to the left. From 1 ms on
the upper and lower edge, one horizon deep, move apart at 0.05 m/s, and slide freely. 2400 kg/m³; a damping of 10 % of a
wave that is as long as two plates lets the shear settle. Notches have no width. Bonds at the edges, one horizon deep,
cannot break. The third criterion is that of diagonal_plate.py. The horizon is 10 mm here unless told otherwise.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.ndimage import label

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
    ViscousDamping,
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
    viscous_dissipation,
    volume,
)

SIDE, NOTCH, THICKNESS = 0.2, 0.025, 0.05  # m
E, NU, RHO, G0 = 30e9, 0.2, 2400.0, 110.0  # Pa, 1, kg/m^3, J/m^2
SETTLED = 1e-3  # s: when the shear has come to rest
CRACKED = 0.35  # damage of a node beside a crack: about 0.4
DAMAGED = 0.15  # of a node that is damaged at all
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
    shear: float = 10e3,
    criterion: str = "stretch",
    mode: str = "tension",
    horizon: float = 10e-3,
    m: int = 3,
    speed: float = 0.05,
    damping: float = 0.1,
    until: float = 3e-3,
    dt: float = 500e-9,
    out: str | Path = "out/nooru_mohamed",
    frames: int = 100,
) -> rbs.Analysis:
    """The plate under a `shear` force, N, with m spacings in a horizon; `dt` is that for spacings from 3.3 mm on.

    `criterion` is "stretch", "bond energy" or "nodal energy"; `mode` says whether shortened bonds fail by energy, too.
    """
    spacing = horizon / m
    dt = dt * min(spacing / (10e-3 / 3), 1.0)
    shots = rbs.every(max(round(until / dt / frames), 1)) | rbs.last
    out = Path(out)

    half = SIDE / 2
    plate = rbs.Part("plate", rbs.Box(size=(SIDE, SIDE)))
    plate.discretize(spacing, thickness=THICKNESS).connect(horizon * (1 + 1e-9))
    plate.bonds.cut(rbs.Segment((-half, 0.0), (NOTCH - half, 0.0)) | rbs.Segment((half - NOTCH, 0.0), (half, 0.0)))
    plate[density] = RHO

    def pushed(time: float) -> float:
        return shear * min(time / (0.5 * SETTLED), 1.0)

    left = rbs.Box.between((-half, horizon), (horizon - half, half))
    right = rbs.Box.between((half - horizon, -half), (half, -horizon))
    push = [
        BoundaryDomain(plate, left, force=(pushed, None)),
        BoundaryDomain(plate, right, force=(lambda time: -pushed(time), None)),
    ]
    up, down = rbs.HalfSpace((0, half - horizon), normal=(0, 1)), rbs.HalfSpace((0, horizon - half), normal=(0, -1))
    pull = [
        BoundaryDomain(plate, up, velocity=(None, lambda time: 0.5 * speed * (time > SETTLED))),
        BoundaryDomain(plate, down, velocity=(None, lambda time: -0.5 * speed * (time > SETTLED))),
    ]
    slowest = np.pi / SIDE * np.sqrt(E / RHO)  # angular frequency of a wave as long as two plates, rad/s
    resist = [ViscousDamping(plate, ratio=damping, frequency=slowest)] if damping else []

    may_break = rbs.Box(size=(SIDE - 2 * horizon, SIDE - 2 * horizon))
    criteria = {
        "stretch": CriticalStretch(critical_stretch(G0, E, horizon, "stress"), within=may_break),
        "bond energy": CriticalBondEnergy(fracture_energy=G0, mode=mode, within=may_break),
        "nodal energy": CriticalNodalEnergy(
            critical_bond_energy(G0, 2, horizon, THICKNESS), mode=mode, within=may_break
        ),
    }
    solid = OrdinaryStateBased(plate, E=E, nu=NU, plane="strain", fracture=criteria[criterion])

    energies = [kinetic_energy, strain_energy, fracture_dissipation, external_work]
    energies += [viscous_dissipation] if damping else []
    force = total(force_density, up, component="y", weights=volume, name="force")
    return rbs.Analysis(
        [
            *VelocityVerlet(plate).step(forces=[solid], boundaries=[*push, *pull, *resist]),
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
        title=f"nooru_mohamed, {criterion}, {shear / 1e3:g} kN",
    )


def measure(analysis: rbs.Analysis) -> dict[str, object]:
    """Where the cracks go, how alike they are, how wide the damage is, the largest pull and the energy balance."""
    plate = analysis.parts[0]
    out = next(r.path.parent for r in analysis.relations if isinstance(r, CSVExporter))
    history = {name: np.array(column) for name, column in read_table(out / "history.csv").items()}
    kinds = ("kinetic_energy", "strain_energy", "fracture_dissipation", "viscous_dissipation")
    found = sum(history[name] for name in kinds if name in history)
    picture = plate[damage].reshape(plate.grid.shape[::-1])
    return {
        "nodes": len(plate),
        "directed_bonds": len(plate.bonds),
        **the_cracks(plate),
        "asymmetry_of_damage_under_half_a_turn": float(np.abs(picture - picture[::-1, ::-1]).max()),
        "largest_pull_N": float(np.abs(history["force"]).max()),
        "fracture_dissipation_J": float(history["fracture_dissipation"][-1]),
        "energy_error": float(abs(found[-1] / history["external_work"][-1] - 1)),
    }


def the_cracks(plate: rbs.Part) -> dict[str, object]:
    """What has grown from the tips of both notches, and how wide it is."""
    when, positions = plate[cracked_at], plate.positions
    horizon, inner = plate.bonds.horizon, SIDE / 2 - NOTCH
    new = (when > when.min()) & (when < NEVER) & (np.abs(positions[:, 0]) < inner)
    result: dict[str, object] = {"cracked_nodes": int(new.sum())}
    if not new.any():
        return result
    shape = plate.grid.shape[::-1]
    names = label((when < NEVER).reshape(shape), np.ones((3, 3)))[0].ravel()  # of what hangs together
    lengths = []
    for name, sign in (("left", 1.0), ("right", -1.0)):
        way = sign * positions + (inner, 0.0)  # of the right crack the image under half a turn
        notch, other = ((when == when.min()) & (side * positions[:, 0] < -inner) for side in (sign, -sign))
        mine = new & np.isin(names, names[notch])
        if np.isin(names[notch], names[other]).any():  # they have met
            mine &= sign * positions[:, 0] < 0
        near = mine & (np.hypot(*way.T) < 3 * horizon)
        lengths.append(np.hypot(*way[mine].T).max(initial=0.0))
        if near.any():
            x, y = way[near].mean(axis=0)
            line = sign * middle_line(sign * positions[mine])
            result |= {
                f"angle_of_{name}_crack_deg": float(np.degrees(np.arctan2(y, x))),
                f"{name}_crack_goes_to_m": line[-1].tolist(),
                f"middle_line_of_{name}_crack_m": line,
            }
    damaged = (plate[damage] > DAMAGED) & (np.abs(positions[:, 0]) < inner - horizon)
    width = damaged.sum() * plate.spacing**2 / max(sum(lengths) - 2 * horizon, horizon)
    return {**result, "width_of_damage_m": float(width), "starts_at_s": float(when[new].min())}


def middle_line(cracked: np.ndarray, width: float = 10e-3) -> np.ndarray:
    """Points (k, 2), m, on the crack: the mean of the cracked nodes in strips of a width."""
    strips = np.floor(cracked[:, 0] / width)
    return np.array([cracked[strips == strip].mean(axis=0) for strip in np.unique(strips)])


if __name__ == "__main__":
    sys.exit(main(["run", __file__, *sys.argv[1:]]))
