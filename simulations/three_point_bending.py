"""Three-point bending of a concrete beam, bond by bond in equilibrium (section 5.1 of Sarego 2016).

A beam of 600 x 150 mm², E = 35.77 GPa, bond-based (Poisson's ratio 1/3) in plane stress, G0 = 9.8 J/m², horizon 15 mm,
three spacings of 5 mm: 3720 nodes. The dissertation of G. Sarego (Padova) says that the largest load, and the
displacement at which the load drops, agree very well with the curve of Carpinteri & Colombo (1989); there is a figure
only, without numbers that could be read.

The dissertation omits the rest. Taken here: 124 x 30 nodes, so 10 mm more than the span of 600 mm beyond either
support; 1 m of thickness, to which forces are in proportion; no notch; two nodes in the middle of the upper edge are
moved down, the node next to each support on the lower edge cannot, and bonds of these nodes do not fail; small
displacements; a bond fails in tension beyond √(4πG0/(9Eδ)) = 1.6e-4. Either all bonds beyond it fail, and equilibrium
is found anew at the same displacement until none does; or one bond after the other fails, at the load at which it does.

What is known: the stiffness of a Timoshenko beam; the load at which its lower edge is stretched to the limit; and, once
there is a crack of the length a, linear fracture mechanics of a beam with span = 4 x depth, P(a) and u(a): the curve of
snap-back that the load goes down on, or to which it drops.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pyvista

import rbs_core as rbs
from rbs_core.command import main
from rbs_plugins import (
    BondBased,
    BoundaryDomain,
    CriticalStretch,
    CSVExporter,
    Damage,
    FractureDissipation,
    Newton,
    PictureExporter,
    ReactionForce,
    SequentiallyLinear,
    StrainEnergy,
    VTKHDFExporter,
    mean,
    read_table,
)
from rbs_plugins.constitutive.bond_based import critical_stretch
from rbs_plugins.fields import (
    damage,
    displacement,
    external_work,
    fracture_dissipation,
    reaction_force,
    strain_energy,
)

SPAN, DEPTH, THICKNESS = 0.6, 0.15, 1.0  # m
E, NU, G0 = 35.77e9, 1 / 3, 9.8  # Pa, 1, J/m²
BENDING = E * THICKNESS * DEPTH**3 / 12  # N m²
SHEAR = 10 * (1 + NU) / (12 + 11 * NU) * E / (2 * (1 + NU)) * THICKNESS * DEPTH  # N, with Cowper's coefficient
CRACKED = 0.35  # damage of a node beside a crack


def scene(
    columns: int = 124,
    rows: int = 30,
    spacing: float = 5e-3,
    m: int = 3,
    path: str = "newton",
    notch: float = 0.0,
    down: float = 1.2e-4,
    steps: int | None = None,
    energy: float = G0,
    partial_volume: str = "linear",
    out: str | Path = "out/three_point_bending",
) -> rbs.Analysis:
    """The beam of columns x rows nodes, m spacings in a horizon.

    `path` is "newton": moved down by `down`, m, in equal steps; or "sequential": one bond fails after the other, at
    most so many times as there are steps. A notch of the given depth, m, goes up from the middle of the lower edge;
    energy is G0 in J/m².
    """
    horizon = m * spacing * (1 + 1e-9)
    out = Path(out)
    length, depth = columns * spacing, rows * spacing
    beam = rbs.Part("beam", rbs.Box.between((-length / 2, 0.0), (length / 2, depth)))
    beam.discretize(spacing, thickness=THICKNESS)
    beam.connect(horizon, reach=horizon + spacing / 2 if partial_volume == "linear" else None)
    if notch:
        beam.bonds.cut(rbs.Segment((0.0, -spacing), (0.0, notch)))
    x, y = beam.positions.T
    lowest, top = y < spacing, y > depth - spacing
    feet = [int(np.argmin(np.where(lowest, np.abs(x - side * SPAN / 2), np.inf))) for side in (-1 + 1e-9, 1 - 1e-9)]
    pressed = top & (np.abs(x) < spacing)
    free = ~pressed
    free[feet] = False
    beam.node_sets["free"] = np.flatnonzero(free)
    critical = CriticalStretch(fracture_energy=energy, within="free")
    concrete = BondBased(beam, E=E, nu=NU, fracture=critical, partial_volume=partial_volume, linear=True)
    supports = BoundaryDomain(beam, feet, displacement=(None, 0.0))
    pin = BoundaryDomain(beam, feet[:1], displacement=(0.0, None))
    ram = BoundaryDomain(beam, pressed, displacement=(None, lambda time: -down * time))
    axis = np.flatnonzero((np.abs(x) < spacing) & (np.abs(y - depth / 2) < spacing))
    ends = np.flatnonzero((np.abs(np.abs(x) - np.abs(x[feet[0]])) < spacing / 4) & (np.abs(y - depth / 2) < spacing))
    columns_of_table = [
        mean(displacement, ram.nodes, component="y", name="u_ram"),
        mean(displacement, axis, component="y", name="u_middle"),
        mean(displacement, ends, component="y", name="u_ends"),
        reaction_force, strain_energy,
    ]  # fmt: skip
    if path == "newton":
        solver: rbs.Statics = Newton(beam, [concrete], [supports, pin, ram], solver="direct")
        more: list[rbs.Relation] = [FractureDissipation(beam)]
        columns_of_table += [fracture_dissipation, external_work]
        steps = steps or 60
    elif path == "sequential":
        solver, more = SequentiallyLinear(beam, [concrete], [supports, pin, ram]), []
        steps = steps or 3000
    else:
        raise ValueError(f'path="{path}": "newton" or "sequential"')
    return rbs.Analysis(
        [
            solver,
            Damage(beam),
            ReactionForce(beam, ram),
            StrainEnergy(beam, [concrete]),
            *more,
            CSVExporter(beam, columns_of_table, out / "curve.csv"),
            VTKHDFExporter(beam, [displacement, damage], out / "beam", when=rbs.every(max(steps // 60, 1)) | rbs.last),
            PictureExporter(beam, damage, out / "damage", limits=(0.0, 0.6), configuration="reference", when=rbs.last),
        ],
        steps=steps,
        title=f"three_point_bending, notch of {notch:g} m",
    )


def measure(analysis: rbs.Analysis) -> dict[str, object]:
    """Stiffness, largest load, load behind the drop and the crack, beside what is known of them."""
    beam = analysis.parts[0]
    solver = next(r for r in analysis.relations if isinstance(r, rbs.Statics))
    concrete = next(r for r in analysis.unique if isinstance(r, BondBased))
    out = next(r.path.parent for r in analysis.relations if isinstance(r, CSVExporter))
    curve = {name: np.array(column) for name, column in read_table(out / "curve.csv").items()}
    down, load = -curve["u_ram"], -curve["reaction_force_1"]
    peak = int(np.argmax(load))
    stiffness = load[0] / (curve["u_ends"] - curve["u_middle"])[0]
    known = 1 / (SPAN**3 / (48 * BENDING) + SPAN / (4 * SHEAR))
    limit = concrete.fracture.s0 or concrete.critical_stretch(concrete.fracture.fracture_energy)
    energy = G0 * (limit / critical_stretch(G0, E, beam.bonds.horizon, "stress")) ** 2
    found = {
        "nodes": len(beam),
        "directed_bonds": len(beam.bonds),
        "critical_stretch": limit,
        "stiffness_N_per_m": float(stiffness),
        "stiffness_error_percent": float(100 * (stiffness / known - 1)),
        "largest_load_N": float(load[peak]),
        "displacement_then_m": float(down[peak]),
        "load_with_edge_at_limit_N": float(E * limit * THICKNESS * DEPTH**2 / (1.5 * SPAN)),
        "equilibria": len(solver.history),
        **the_crack(beam),
    }
    notch = float(analysis.title.split()[-2])
    if notch:  # then the first compliance is not that of the whole beam
        strength = np.sqrt(E * energy) * THICKNESS * DEPTH**1.5 / (SPAN * of_notch(np.array(notch / DEPTH)))
        return {**found, "largest_load_of_fracture_mechanics_N": float(strength)}
    u, P = snap_back(down[0] / load[0], energy)
    if "fracture_dissipation" in curve:
        found["dissipation_over_G0_area"] = float(curve["fracture_dissipation"][-1] / (energy * THICKNESS * DEPTH))
        found["damage_grows"] = bool(np.all(np.diff(curve["fracture_dissipation"]) >= 0))
        draw(out / "curve.png", {"equilibria": (down, load)})
        if peak + 1 < len(load):
            found["load_behind_the_drop_N"] = float(load[peak + 1])
            beyond = u > down[peak + 1]
            found["load_of_fracture_mechanics_there_N"] = float(
                P[np.argmin(u) :][beyond[np.argmin(u) :]].max(initial=0)
            )
        return found
    draw(
        out / "curve.png",
        {"bond by bond": (down, load), "fracture mechanics": (u[1.1 * load[peak] > P], P[1.1 * load[peak] > P])},
    )
    # between two equilibria the load goes to nothing and back
    last = np.flatnonzero(load > 0.02 * load[peak])[-1] + 1
    load, down = load[:last], down[:last]
    work = 0.5 * np.sum(load[:-1] * down[1:] - load[1:] * down[:-1])
    off = down / np.interp(load, P[::-1], u[::-1]) - 1
    some = load < 0.8 * load[peak]
    return {
        **found,
        "work_of_the_path_over_G0_area": float(work / (energy * THICKNESS * DEPTH)),
        "smallest_displacement_behind_peak_m": float(down[peak:].min()),
        "the_same_of_fracture_mechanics_m": float(u.min()),
        "off_fracture_mechanics_least_percent": float(100 * off[some].min(initial=np.inf)),
        "off_fracture_mechanics_mean_percent": float(100 * off[some].mean()) if some.any() else float("nan"),
        "off_fracture_mechanics_most_percent": float(100 * off[some].max(initial=-np.inf)),
    }


def draw(path: Path, curves: dict[str, tuple[np.ndarray, np.ndarray]]) -> None:
    """A picture of loads over displacements."""
    chart = pyvista.Chart2D(x_label="displacement of the ram, mm", y_label="load, kN for 1 m of thickness")
    for (name, (down, load)), color in zip(curves.items(), ("b", "r"), strict=False):
        chart.line(1e3 * down, 1e-3 * load, color=color, label=name)
    chart.show(off_screen=True, screenshot=str(path))


def the_crack(beam: rbs.Part) -> dict[str, object]:
    """How high the cracked nodes reach, and how far the middle of each row of them is from that of the beam."""
    x, y = beam.positions[beam[damage] > CRACKED].T
    rows = np.round(y / beam.spacing, 1)
    away = [abs(x[rows == row].mean()) for row in np.unique(rows)]
    return {
        "cracked_nodes": len(x),
        "height_of_crack_m": float(y.max() + beam.spacing / 2) if len(y) else 0.0,
        "crack_off_middle_m": float(max(away, default=0.0)),
        "width_of_crack_m": float(np.ptp(x) + beam.spacing) if len(x) else 0.0,
    }


def of_notch(share: np.ndarray) -> np.ndarray:
    """K √depth³ thickness/(P span) of a beam with span = 4 depth, cracked over a share of its depth (ASTM E399)."""
    a = share
    bracket = 1.99 - a * (1 - a) * (2.15 - 3.93 * a + 2.7 * a**2)
    return 3 * np.sqrt(a) * bracket / (2 * (1 + 2 * a) * (1 - a) ** 1.5)


def snap_back(compliance: float, energy: float = G0) -> tuple[np.ndarray, np.ndarray]:
    """Displacement u, m, and load P, N, at which a crack is about to grow, from a short one to a long one.

    P = √(E G0)/(K/P), and u = C P with C = compliance + 2 thickness/E ∫ (K/P)² da.
    """
    share = np.linspace(0.002, 0.95, 1000)
    per_load = SPAN * of_notch(share) / (THICKNESS * DEPTH**1.5)
    grown = np.concatenate([[0.0], np.cumsum(np.diff(share) * DEPTH * (per_load[1:] ** 2 + per_load[:-1] ** 2) / 2)])
    load = np.sqrt(E * energy) / per_load
    return (compliance + 2 * THICKNESS / E * grown) * load, load


if __name__ == "__main__":
    sys.exit(main(["run", __file__, *sys.argv[1:]]))
