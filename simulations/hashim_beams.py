"""Beams under large displacements, in equilibrium: sections 4.4, 5.2 and 6.3.3 of the thesis of Hashim (Durham 2021).

    clamped            254 x 5.08 mm, E = 68.95 GPa, ν = 0.25, under a pressure of 276 kPa, held at both ends (5.2.2)
    simply supported   the same beam, both ends on a pin (5.2.3; 4.4.3 with `on_edges=True`)
    cantilever         10 x 1 m, E = 12 MPa, ν = 0.2, under 100 kN at its end (5.2.4; 4.4.2 with `on_edges=True`)
    notched            the same cantilever, 0.15 m deep notch from the top at 1 m from the clamp, under 6 kN (6.3.3)

All are correspondence with Hencky's law in plane strain, loaded in ten equal steps; Newton's method with a tolerance of
1e-10. The slender beam is modelled up to its middle. Of what the thesis leaves open, the following readings give its
tables to all or nearly all digits:

* supports lie in a fictitious layer of 1, 2 or 3 columns for δ = 1.015, 2.015, 3.015 Δx; a clamp holds u_x of all its
  nodes and u_y of those on the axis, a pin only the node on the axis next to the body;
* the middle of the slender beam is the last column of the body, with u_x = 0, without a layer;
* the norm of the unbalanced forces is divided by that of loads and reactions; Newton takes that of internal forces,
  reactions among them, which is the same near equilibrium;
* her constant G is in the unit of a volume (`printed=True`). In the slender beams it is to be multiplied by 2.54e-4;
* nodes of chapter 5 lie at the centres of their cells, those of chapter 4 also on the edges, where all have the
  volume L d0/N and the end force acts on one node.

References are the strip of von Kármán with immovable ends (plane strain), and the elastica. The notched beam lacks its
stretches: taken here is a critical stretch of 1.65 %, with which it holds up to 4.2 kN, as published; with `s_min`,
bonds soften from there on. Bonds of the layer cannot break, or they would do so first.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

import rbs_core as rbs
from rbs_core.command import main
from rbs_plugins import (
    AdaptiveDynamicRelaxation,
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
    mean,
    read_table,
)
from rbs_plugins.constitutive.stress import hencky
from rbs_plugins.fields import damage, deformation_gradient, displacement, stress, volume


@dataclass(frozen=True)
class Beam:
    """Length to its free end or middle, depth, m; E, Pa; ν; the whole load; the factor of printed constants, m^3."""

    length: float
    depth: float
    E: float
    nu: float
    load: float
    unit: float = 1.0


SLENDER = Beam(0.127, 5.08e-3, 68.95e9, 0.25, 276e3, 2.54e-4)  # Pa on top
CASES = {
    "clamped": SLENDER,
    "simply supported": SLENDER,
    "cantilever": Beam(10.0, 1.0, 12e6, 0.2, 100e3),  # N/m
    "notched": Beam(10.0, 1.0, 12e6, 0.2, 6e3),
}
NOTCH = (1.0, 0.15)  # m: from the clamp, deep
CRACKED = 0.25  # damage: more than beside the notch


def scene(
    case: str = "clamped",
    rows: int = 0,
    m: float = 3.015,
    factor: float = 0.0,
    printed: bool = False,
    on_edges: bool = False,
    share: float = 1.0,
    steps: int = 10,
    tolerance: float = 1e-10,
    solver: str = "newton",
    s_min: float = 0.0,
    s0: float = 0.0165,
    out: str | Path = "out/hashim_beams",
) -> rbs.Analysis:
    """A beam of some rows of nodes (3 if slender, 5 if not), a horizon of m spacings; time is the share of the load.

    `factor` is that of the control of zero-energy modes, 0 for none; with `printed` it is the G of the thesis. `share`
    is how much of the load is applied, in how many `steps`. `solver` is "newton" or "relaxation". `s_min` and `s0` are
    the stretches of the notched beam.
    """
    if case not in CASES:
        raise ValueError(f'case="{case}": one of {", ".join(CASES)}')
    beam, out = CASES[case], Path(out)
    rows = rows or (3 if beam is SLENDER else 5)
    part, layer = lattice(beam, rows, m, on_edges)
    control = None
    if factor > 0:
        control = SillingControl(factor * (beam.unit if printed else 1.0), by_family=printed)
    fracture = None
    if case == "notched":
        top = beam.depth / 2
        part.bonds.cut(rbs.Segment((NOTCH[0], top - NOTCH[1]), (NOTCH[0], 2 * top)))
        fracture = BondSoftening(s_min, s0, within="body") if s_min > 0 else CriticalStretch(s0, within="body")
    solid = Correspondence(
        part, hencky, fracture, E=beam.E, nu=beam.nu, plane="strain", stabilization=control
    )  # fmt: skip
    supports = supported(case, part, layer)
    kind = {"newton": Newton, "relaxation": AdaptiveDynamicRelaxation}[solver]
    statics = kind(part, solid, [*supports, loaded(beam, part, on_edges)], tolerance=tolerance)

    columns = [mean(displacement, [axis_node(part)], component=c, name=name) for c, name in (("x", "u"), ("y", "v"))]
    return rbs.Analysis(
        [
            statics,
            Damage(part),
            CSVExporter(part, columns, out / "history.csv"),
            VTKHDFExporter(part, [displacement, deformation_gradient, stress, damage], out / "beam"),
            PictureExporter(part, damage if fracture else displacement, out / "picture", when=rbs.last),
        ],
        dt=share / steps,
        until=share,
        title=f"hashim_beams, {case}",
    )


def lattice(beam: Beam, rows: int, m: float, on_edges: bool) -> tuple[rbs.Part, np.ndarray]:
    """The beam along x from 0 on, its axis at y = 0, and the nodes of the layer that supports it."""
    spacing = beam.depth / (rows - 1 if on_edges else rows)
    more = spacing / 2 if on_edges else 0.0
    box = rbs.Box.between((-more, -beam.depth / 2 - more), (beam.length + more, beam.depth / 2 + more))
    part = rbs.Part("beam", box).discretize(spacing)
    layer = part.extend("support", "-x", thickness=m * spacing)
    part.connect(m * spacing)
    if on_edges:
        part[volume] = beam.length * beam.depth / len(part.body)
    return part, layer.nodes


def end_column(part: rbs.Part) -> np.ndarray:
    """Nodes of the last column of the body."""
    x = part.positions[part.body, 0]
    return part.body[x > x.max() - 1e-6 * part.spacing]


def axis_node(part: rbs.Part) -> int:
    """The node of the last column that lies on the axis."""
    column = end_column(part)
    return int(column[np.argmin(np.abs(part.positions[column, 1]))])


def supported(case: str, part: rbs.Part, layer: np.ndarray) -> list[BoundaryDomain]:
    """What holds the beam."""
    x, y = part.positions.T
    axis = layer[np.abs(y[layer]) < 1e-6 * part.spacing]
    if case == "simply supported":
        held = [BoundaryDomain(part, axis[[np.argmax(x[axis])]], displacement=(0.0, 0.0))]
    else:
        held = [
            BoundaryDomain(part, layer, displacement=(0.0, None)),
            BoundaryDomain(part, axis, displacement=(None, 0.0)),
        ]
    if case in ("clamped", "simply supported"):
        held.append(BoundaryDomain(part, end_column(part), displacement=(0.0, None)))
    return held


def loaded(beam: Beam, part: rbs.Part, on_edges: bool) -> BoundaryDomain:
    """Pressure on the upper nodes, or a force at the end, that grow with time; they keep their direction."""
    y = part.positions[:, 1]
    if beam is SLENDER:
        nodes = part.body[y[part.body] > y.max() - 1e-6 * part.spacing]
        each = np.full(len(nodes), -beam.load * part.spacing)
    else:
        nodes = np.array([axis_node(part)]) if on_edges else end_column(part)
        each = np.full(len(nodes), -beam.load / len(nodes))
    return BoundaryDomain(part, nodes, force=(None, lambda time: each * time))


# -- theory --------------------------------------------------------------------------------------------------------


def strip(case: str, share: float) -> float:
    """Deflection of the middle over the depth, of a strip in cylindrical bending whose ends cannot approach.

    With a tension S, k² = S L²/(4D) and E' = E/(1 − ν²): Timoshenko & Woinowsky-Krieger (1959), chapter 1.
    """
    L, h = 2 * SLENDER.length, SLENDER.depth
    stiff = SLENDER.E / (1 - SLENDER.nu**2)
    D, q = stiff * h**3 / 12, SLENDER.load * share
    nodes, weights = np.polynomial.legendre.leggauss(200)
    x = L / 4 * (nodes + 1)  # the left half

    def shape(k: float, x: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
        """Deflection and slope."""
        arch = q * L**4 / (16 * k**4 * D) * (k / np.tanh(k) if case == "clamped" else 1.0)
        a = k * (1 - 2 * np.asarray(x) / L)
        w = arch * (np.cosh(a) / np.cosh(k) - 1) + q * L**2 * (L - x) * x / (8 * k**2 * D)
        slope = -arch * 2 * k / L * np.sinh(a) / np.cosh(k) + q * L**2 * (L - 2 * x) / (8 * k**2 * D)
        return w, slope

    def excess(k: float) -> float:
        longer = 2 * L / 4 * np.sum(weights * 0.5 * shape(k, x)[1] ** 2)
        return float(longer - 4 * D * k**2 / (stiff * h * L))

    k = brentq(excess, 1e-3, 100.0, xtol=1e-12)
    return float(shape(k, L / 2)[0] / h)


def elastica(load: float, plane: str = "strain") -> tuple[float, float]:
    """Drop of the end of the cantilever and how much it comes nearer to the clamp, over L; no extension.

    With α = P L²/(EI) and k² = (1 + sin θ)/2, θ the slope at the end: √α = K(k) − F(φ, k), sin φ = 1/(k√2).
    """
    beam = CASES["cantilever"]
    bending = beam.E * beam.depth**3 / 12 / (1.0 if plane == "stress" else 1 - beam.nu**2)
    root = np.sqrt(load * beam.length**2 / bending)

    def angles(end: float) -> tuple[float, float]:
        k2 = (1 + np.sin(end)) / 2
        return k2, float(np.arcsin(min(1 / np.sqrt(2 * k2), 1.0)))

    def excess(end: float) -> float:
        k2, phi = angles(end)
        return float(ellipk(k2) - ellipkinc(phi, k2) - root)

    end = brentq(excess, 1e-9, np.pi / 2 - 1e-12, xtol=1e-14)
    k2, phi = angles(end)
    drop = 1 - 2 / root * (ellipe(k2) - ellipeinc(phi, k2))
    return float(drop), float(1 - np.sqrt(2 * np.sin(end)) / root)


# -- results -------------------------------------------------------------------------------------------------------


def measure(analysis: rbs.Analysis) -> dict[str, object]:
    """Displacement of the end or middle beside theory, and the residuals of the last steps."""
    statics = next(r for r in analysis.relations if isinstance(r, Newton | AdaptiveDynamicRelaxation))
    table = next(r.path for r in analysis.relations if isinstance(r, CSVExporter))
    history = {name: np.array(column) for name, column in read_table(table.with_suffix(".csv")).items()}
    part, case = analysis.parts[0], analysis.title.partition(", ")[2]
    beam, share = CASES[case], history["time"]
    found: dict[str, object] = {
        "nodes_of_the_body": len(part.body),
        "directed_bonds": len(part.bonds),
        "solving_s": sum(each.seconds for each in statics.history),
        "iterations": [each.count for each in statics.history],
        "residuals": [list(each.residuals) for each in statics.history],
        "times_of_searches": [each.time for each in statics.history],
    }
    if beam is SLENDER:
        w = -history["v"] / beam.depth
        theory = [strip(case, each) for each in share if each > 0]
        return {**found, "w_over_depth": w.tolist(), "of_theory": theory, "error": w[-1] / theory[-1] - 1}
    v, u = -history["v"] / beam.length, -history["u"] / beam.length
    found |= {"v_over_length": v.tolist(), "u_over_length": u.tolist()}
    if case == "notched":
        cracked = part.positions[part[damage] > CRACKED]
        return {
            **found,
            "broken": [[each.time * beam.load, each.broken] for each in statics.history if each.broken],
            "cracked_x_m": [float(x) for x in (cracked[:, 0].min(), cracked[:, 0].max())] if len(cracked) else [],
            "cracked_down_to_y_m": float(cracked[:, 1].min()) if len(cracked) else beam.depth / 2,
        }
    for plane in ("strain", "stress"):
        drop, nearer = elastica(beam.load * share[-1], plane)
        found |= {
            f"v_of_elastica_in_plane_{plane}": drop,
            f"u_of_elastica_in_plane_{plane}": nearer,
            f"v_error_in_plane_{plane}": v[-1] / drop - 1,
            f"u_error_in_plane_{plane}": u[-1] / nearer - 1,
        }
    return found


if __name__ == "__main__":
    sys.exit(main(["run", __file__, *sys.argv[1:]]))
