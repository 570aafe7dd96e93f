"""Plates in plane strain, in equilibrium, with and without damage: sections 3.3, 4.3.2 and 6.3 of the thesis of Hashim.

    tension   1 x 0.5 m, E = 200 GPa, ν = 0.33, pulled by 200 MPa on its outermost columns (3.3.1, 4.3.2)
    hole      50 x 50 mm with a hole of 10 mm, E = 192 GPa, ν = 0.33; layers above and below are pulled apart, each by
              0.275 mm in 1000 steps; critical stretch of 2 % (3.3.2)
    long      150 x 50 mm with a hole of 20 mm, E = 210 GPa, ν = 0.33; layers to the left and right are pulled apart,
              each by 0.1 mm in 15 steps; bonds soften from 0.15 % and fail at 0.2 % (6.3.1)
    crack     50 x 50 mm with a crack of 10 mm in its middle, E = 192 GPa, ν = 0.33; layers above and below are pulled
              apart, each by 0.016 mm in 15 steps; bonds soften and fail as above (6.3.2)

All are correspondence with Hencky's law; `model="bond-based"` with ν = 1/4. Units are read so that the numbers have a
meaning: the body force of 3.3.1 is 200 MPa over the spacing, 2.7541e-7 mm per step (3.3.2) are metres, and so
are the 1e4 mm of 6.3.1 with the other sign of the exponent. Layers are held across the pull, their bonds cannot break,
and bonds over the hole are kept, of which the thesis says nothing; nor does it say where its crack of 10 mm lies.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import rbs_core as rbs
from rbs_core.command import main
from rbs_plugins import (
    AdaptiveDynamicRelaxation,
    BondBased,
    BondSoftening,
    BoundaryDomain,
    Correspondence,
    CriticalStretch,
    CSVExporter,
    Damage,
    Newton,
    PictureExporter,
    SillingControl,
    VTKHDFExporter,
    read_table,
    total,
)
from rbs_plugins.constitutive.stress import hencky
from rbs_plugins.fields import damage, deformation_gradient, displacement, force_density, stress, volume

NU = 0.33
TRACTION = 200e6  # Pa
NEVER = 2.0  # s: behind the end


@dataclass(frozen=True)
class Plate:
    """Width and height, m; E, Pa; radius of the hole, m; axis and size of the pull, m; steps; stretches."""

    size: tuple[float, float]
    E: float
    radius: float
    axis: int
    pull: float
    steps: int
    stretches: tuple[float, ...]


CASES = {
    "tension": Plate((1.0, 0.5), 200e9, 0.0, 0, 0.0, 1, ()),
    "hole": Plate((0.05, 0.05), 192e9, 0.005, 1, 2.7541e-4, 1000, (0.02,)),
    "long": Plate((0.15, 0.05), 210e9, 0.010, 0, 1e-4, 15, (0.0015, 0.002)),
    "crack": Plate((0.05, 0.05), 192e9, 0.0, 1, 1.6e-5, 15, (0.0015, 0.002)),
}
CRACK = 0.01  # m
CRACKED = 0.3  # damage of a node beside a crack: about 0.4

damaged_at = rbs.Field("damaged_at", "node", "scalar", "s", "t_d", "When its first bond failed.", initial=NEVER)


class DamageTimes(rbs.Measure):
    """Writes when the first bond of each node failed, those of the crack that was there not counted."""

    reads = (damage,)
    updates = (damaged_at,)

    def begin(self, clock: rbs.Clock) -> None:
        offsets, _ = self.part.bonds.as_rows()
        holds = self.part.bonds.intact if self.part.bonds.has_broken else np.ones(offsets[-1])
        self._before = 1 - np.add.reduceat(holds.astype(float), offsets[:-1]) / np.diff(offsets)

    def apply(self, clock: rbs.Clock) -> None:
        """Looks at all nodes that have more damage than at the start."""
        fresh = (self[damage] > self._before + 1e-9) & (self[damaged_at] == NEVER)
        self[damaged_at][fresh] = clock.time


def scene(
    case: str = "long",
    n: int = 0,
    m: float = 3.015,
    factor: float = 0.1,
    model: str = "correspondence",
    fracture: str = "",
    solver: str = "",
    share: float = 1.0,
    steps: int = 0,
    tolerance: float = 1e-8,
    out: str | Path = "out/hashim_plates",
) -> rbs.Analysis:
    """A plate with n columns of nodes and a horizon of m spacings; time is the share of the load, up to `share`.

    `factor` is that of the control of zero-energy modes, 0 for none. `fracture` is "softening", "stretch" (the larger
    stretch alone) or "none". `solver` is "newton", "relaxation", or "one iteration": relaxation that makes one
    iteration in each of the steps, as in 3.3.2 (default there). Newton's method does not get past the load at which
    softening bonds let go, so these are relaxed if nothing else is said.
    """
    if case not in CASES:
        raise ValueError(f'case="{case}": one of {", ".join(CASES)}')
    given, out = CASES[case], Path(out)
    spacing = given.size[0] / (n or (150 if case == "long" else 50))
    plate = body(given, spacing, m * spacing)
    if case == "crack":
        plate.bonds.cut(rbs.Segment((-CRACK / 2, 0.0), (CRACK / 2, 0.0)))
    fracture = fracture or {0: "none", 1: "stretch", 2: "softening"}[len(given.stretches)]
    if fracture not in ("none", "stretch", "softening")[: 1 + len(given.stretches)]:
        raise ValueError(f'fracture="{fracture}" is not for case="{case}"')
    criterion = None
    if fracture == "stretch":
        criterion = CriticalStretch(given.stretches[-1], within="body")
    elif fracture == "softening":
        criterion = BondSoftening(*given.stretches, within="body")
    usual = "one iteration" if case == "hole" and fracture != "none" else "newton"
    solver = solver or ("relaxation" if fracture == "softening" else usual)
    if model == "correspondence":
        control = SillingControl(factor) if factor > 0 else None
        solid = Correspondence(plate, hencky, criterion, E=given.E, nu=NU, plane="strain", stabilization=control)
    elif model == "bond-based":
        solid = BondBased(plate, E=given.E, nu=0.25, plane="strain", fracture=criterion)
    else:
        raise ValueError(f'model="{model}": "correspondence" or "bond-based"')
    boundaries = tension(plate) if case == "tension" else pulled(plate, given)
    if solver == "newton":
        statics = Newton(plate, solid, boundaries, tolerance=tolerance)
    else:
        per_step = 1 if solver == "one iteration" else None
        statics = AdaptiveDynamicRelaxation(plate, solid, boundaries, tolerance=tolerance, per_step=per_step)

    letter = "xy"[given.axis]
    grip = np.flatnonzero(plate.positions[:, given.axis] > given.size[given.axis] / 2)
    relations = [statics, Damage(plate), DamageTimes(plate)]
    fields = [displacement, damage, damaged_at]
    if model == "correspondence":
        fields += [deformation_gradient, stress]
    if len(grip):
        force = total(force_density, grip, component=letter, weights=volume, name="force")
        relations.append(CSVExporter(plate, [force], out / "history.csv"))
    return rbs.Analysis(
        [
            *relations,
            VTKHDFExporter(plate, fields, out / "plate", when=rbs.last),
            PictureExporter(plate, displacement if case == "tension" else damage, out / "picture", when=rbs.last),
        ],
        dt=share / (steps or given.steps),
        until=share,
        title=f"hashim_plates, {case}",
    )


def body(given: Plate, spacing: float, horizon: float) -> rbs.Part:
    """Nodes at the centres of cells around the origin, with layers at the ends that are pulled."""
    shape: rbs.Geometry = rbs.Box(size=given.size)
    if given.radius > 0:
        shape = shape - rbs.Disk(given.radius, (0.0, 0.0))
    plate = rbs.Part("plate", shape).discretize(spacing)
    if given.pull > 0:
        for name, sign in (("lower", "-"), ("upper", "+")):
            plate.extend(name, f"{sign}{'xy'[given.axis]}", thickness=horizon)
    return plate.connect(horizon)


def tension(plate: rbs.Part) -> list[BoundaryDomain]:
    """The load, and two nodes of the middle row that move as theory says."""
    x, y = plate.positions.T
    middle = np.flatnonzero(np.abs(y) < 0.6 * plate.spacing)
    pins = middle[[np.argmin(np.abs(x[middle])), np.argmax(x[middle])]]
    first, second = (plate.positions[pin] @ np.diag(strains("tension")) for pin in pins)
    ends = [(np.flatnonzero(sign * x > 0.5 - 0.6 * plate.spacing), sign) for sign in (-1, 1)]
    return [
        BoundaryDomain(plate, pins[:1], displacement=tuple(lambda time, u=u: u * time for u in first)),
        BoundaryDomain(plate, pins[1:], displacement=(None, lambda time: second[1] * time)),
        *(
            BoundaryDomain(plate, end, body_force=(lambda time, s=sign: s * TRACTION / plate.spacing * time, None))
            for end, sign in ends
        ),
    ]


def strains(case: str) -> np.ndarray:
    """ε_xx and ε_yy of plane strain under the traction."""
    return TRACTION * (1 + NU) / CASES[case].E * np.array([1 - NU, -NU])


def pulled(plate: rbs.Part, given: Plate) -> list[BoundaryDomain]:
    """Layers that move along the pull and are held across."""
    return [
        BoundaryDomain(
            plate,
            name,
            displacement=[
                (lambda time, s=sign: s * given.pull * time) if axis == given.axis else 0.0 for axis in (0, 1)
            ],
        )
        for name, sign in (("lower", -1), ("upper", 1))
    ]


# -- results -------------------------------------------------------------------------------------------------------


def measure(analysis: rbs.Analysis) -> dict[str, object]:
    """Displacements along the axes, forces, and where and when bonds failed."""
    statics = next(r for r in analysis.relations if isinstance(r, Newton | AdaptiveDynamicRelaxation))
    plate, case = analysis.parts[0], analysis.title.partition(", ")[2]
    given, u, X = CASES[case], plate[displacement], plate.positions
    found: dict[str, object] = {
        "nodes_of_the_body": len(plate.body),
        "directed_bonds": len(plate.bonds),
        "solving_s": sum(each.seconds for each in statics.history),
        "iterations": sum(each.count for each in statics.history),
        "searches": len(statics.history),
        "broken": [[each.time, each.broken] for each in statics.history if each.broken],
    }
    if case == "tension":
        wanted = X @ np.diag(strains(case))
        inner = np.abs(X[:, 0]) <= 0.4
        across = np.abs(X[:, 0]) < 0.6 * plate.spacing
        return {
            **found,
            "u_x_error": float(np.abs(u - wanted)[inner, 0].max() / np.abs(wanted[inner, 0]).max()),
            "u_y_error": float(np.abs(u - wanted)[across, 1].max() / np.abs(wanted[across, 1]).max()),
            "u_x_of_the_end_m": float(u[np.argmax(X[:, 0]), 0]),
            "u_x_of_the_end_in_theory_m": float(wanted[np.argmax(X[:, 0]), 0]),
        }
    table = next(r.path for r in analysis.relations if isinstance(r, CSVExporter))
    history = read_table(table.with_suffix(".csv"))
    force = -np.array(history["force"])
    along, across = given.axis, 1 - given.axis
    reactions = {
        "largest_force_N_per_m": float(force.max()),
        "at_displacement_m": float(given.pull * history["time"][int(np.argmax(force))]),
        "force_at_the_end_N_per_m": float(force[-1]),
    }
    lines = {}
    for name, axis in (("along", along), ("across", across)):
        line = plate.body[np.abs(X[plate.body, 1 - axis]) < 0.6 * plate.spacing]
        lines[f"{name}_the_pull"] = np.hstack([X[line], u[line]]).tolist()
    if stress in plate:
        row = plate.body[np.abs(X[plate.body, along]) < 0.6 * plate.spacing]
        peak = row[np.argmax(plate[stress][row, along, along])]
        lines["largest_stress_in_the_section_Pa"] = float(plate[stress][peak, along, along])
        lines["at_m"] = X[peak].tolist()
    return {**found, **reactions, **lines, **the_crack(plate, given)}


def the_crack(plate: rbs.Part, given: Plate) -> dict[str, object]:
    """Where and when bonds failed."""
    when, X = plate[damaged_at], plate.positions
    body = plate.body
    new = body[when[body] < NEVER]
    if not len(new):
        return {"damaged_nodes": 0}
    along, across = given.axis, 1 - given.axis
    first = new[when[new] == when[new].min()]
    tips = [[float(time), float(np.abs(X[new[when[new] <= time], across]).max())] for time in np.unique(when[new])]
    return {
        "damaged_nodes": len(new),
        "first_at_share": float(when[first[0]]),
        "first_nodes_m": X[first].tolist(),
        "reach_across_m": tips,
        "half_width_of_the_crack_m": float(np.abs(X[new[plate[damage][new] > CRACKED], along]).max(initial=0.0)),
        "half_width_of_the_damage_m": float(np.abs(X[new, along]).max()),
        "largest_damage": float(plate[damage][body].max()),
        "asymmetry_of_damage": asymmetry(plate),
    }


def asymmetry(plate: rbs.Part) -> float:
    """Largest difference of the damage of nodes that are mirror images in x or y."""
    X, values = np.round(plate.positions / plate.spacing, 3), plate[damage]
    place = {tuple(each): value for each, value in zip((X + 0.0).tolist(), values, strict=True)}
    return max(
        abs(value - place[(sx * x + 0.0, sy * y + 0.0)])
        for (x, y), value in place.items()
        for sx, sy in ((-1, 1), (1, -1))
    )


if __name__ == "__main__":
    sys.exit(main(["run", __file__, *sys.argv[1:]]))
