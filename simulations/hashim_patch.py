"""Squares under uniform deformations, in equilibrium: sections 4.3.1, 4.4.1 and 5.2.1 of the thesis of Hashim (2021).

    compression   1 x 1 m, E = 1.2 MPa, ν = 0.2: a layer around it moves inwards, λ = 0.8 (4.3.1)
    shear         1 x 1 m, E = 1.2 GPa, ν = 0.2, sheared by 7.38 in 40 steps (4.4.1)
    extension     as compression, but dead tractions pull it out to λ = 1.61334 in 10 steps (5.2.1)

All are correspondence with Hencky's law in plane strain. The thesis gives no λ for the compression, and for the
extension a traction of 5000 kN/m², for which this material has no equilibrium: its largest is 613 kN/m². The printed λ
belongs to 494.1 kN/m² per undeformed area, which is taken here.

A uniform deformation of the layer is one of the whole body if those nodes of the layer that the body sees have complete
families: the layer is to be two horizons deep (`layers=2`), not one, as in the thesis. `data="normal"` moves each side
of the layer by a constant along its normal, and leaves it free across.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

import rbs_core as rbs
from rbs_core.command import main
from rbs_plugins import (
    BoundaryDomain,
    Correspondence,
    CSVExporter,
    Newton,
    PictureExporter,
    SillingControl,
    VTKHDFExporter,
    mean,
    read_table,
)
from rbs_plugins.constitutive.stress import hencky
from rbs_plugins.fields import deformation_gradient, displacement, stress

NU = 0.2
MODULI = {"compression": 1.2e6, "shear": 1.2e9, "extension": 1.2e6}  # Pa
SHEAR, SHORT, LONG = 7.38, 0.8, 1.61334
STEPS = {"compression": 1, "shear": 40, "extension": 10}


def scene(
    case: str = "compression",
    n: int = 20,
    m: float = 1.015,
    layers: float = 2.0,
    data: str = "affine",
    jitter: float = 0.0,
    factor: float = 0.0,
    printed: bool = False,
    steps: int = 0,
    tolerance: float = 1e-10,
    out: str | Path = "out/hashim_patch",
) -> rbs.Analysis:
    """A square of n x n nodes with a horizon of m spacings; time is the share of the deformation or load.

    `layers` is the depth of the layer around it, in horizons. `data` is "affine" for the whole layer as the deformation
    wants it, "normal" for the compression as above, and "all" for all nodes as the deformation wants them. `jitter`
    moves nodes by up to this share of a spacing. `factor` is that of the control of zero-energy modes, 0 for none; with
    `printed` it is the G of the thesis.
    """
    if case not in MODULI:
        raise ValueError(f'case="{case}": one of {", ".join(MODULI)}')
    out, spacing, steps = Path(out), 1.0 / n, steps or STEPS[case]
    plate = square(n, m * spacing, 0.0 if case == "extension" else layers * m * spacing, jitter)
    control = SillingControl(factor, by_family=printed) if factor > 0 else None
    solid = Correspondence(plate, hencky, E=MODULI[case], nu=NU, plane="strain", stabilization=control)
    boundaries = pulled(plate) if case == "extension" else moved(plate, case, data)
    newton = Newton(plate, solid, boundaries, tolerance=tolerance)

    centre = np.flatnonzero(np.abs(plate.positions).max(axis=1) < (0.51 if n % 2 else 0.76) * spacing)
    columns = [
        mean(field, centre, component=pair, name=f"{letter}_{pair}")
        for letter, field in (("F", deformation_gradient), ("P", stress))
        for pair in ("xx", "xy", "yx", "yy")
    ]
    return rbs.Analysis(
        [
            newton,
            CSVExporter(plate, columns, out / "centre.csv"),
            VTKHDFExporter(plate, [displacement, deformation_gradient, stress], out / "plate", when=rbs.last),
            PictureExporter(plate, displacement, out / "displacement", when=rbs.last),
        ],
        dt=1.0 / steps,
        until=1.0,
        title=f"hashim_patch, {case}",
    )


def square(n: int, horizon: float, depth: float, jitter: float) -> rbs.Part:
    """Nodes at the centres of n x n cells around the origin, and a frame of this depth around them."""
    spacing = 1.0 / n
    plate = rbs.Part("plate", rbs.Box(size=(1.0, 1.0))).discretize(spacing)
    if depth > 0:
        wide = 1.0 + 2 * spacing * np.floor(depth / spacing + 1e-6)
        plate.extend("layer", rbs.Box(size=(wide, wide)) - plate.geometry)
    if jitter:
        away = np.random.default_rng(5).uniform(-jitter, jitter, plate.positions.shape) * spacing
        layer = plate.node_sets["layer"]
        places = plate.positions + away
        body = np.setdiff1d(np.arange(len(plate)), layer)
        plate = rbs.Part("plate", rbs.Everywhere(), dimension=2)
        plate.place(places[body], spacing**2, spacing=spacing, thickness=1.0)
        plate.extend("layer", rbs.grids.Cloud(places[layer], spacing**2))
    return plate.connect(horizon)


def target(case: str, share: float = 1.0) -> np.ndarray:
    """The deformation gradient at a share of the load, (2, 2)."""
    if case == "shear":
        return np.array([[1.0, SHEAR * share], [0.0, 1.0]])
    if case == "compression":
        return (1 + (SHORT - 1) * share) * np.eye(2)
    load = share * np.log(LONG) / LONG  # over K2 = E/((1 + ν)(1 − 2ν)): the traction is K2 ln λ/λ
    return brentq(lambda stretch: np.log(stretch) / stretch - load, 1.0, np.e) * np.eye(2)


def moved(plate: rbs.Part, case: str, data: str) -> list[BoundaryDomain]:
    """Prescribed displacements."""
    x, y = plate.positions.T

    def affine(axis: int):
        return lambda time, X: X @ (target(case, time) - np.eye(2))[axis]

    if data in ("affine", "all"):
        where = plate.node_sets["layer"] if data == "affine" else np.arange(len(plate))
        return [BoundaryDomain(plate, where, displacement=(affine(0), affine(1)))]
    if data == "normal" and case == "compression":
        return [
            BoundaryDomain(
                plate,
                np.flatnonzero(sign * place > 0.5),
                displacement=[
                    (lambda time, s=sign: s * 0.5 * (SHORT - 1) * time) if k == axis else None for k in (0, 1)
                ],
            )
            for axis, place in enumerate((x, y))
            for sign in (-1, 1)
        ]
    raise ValueError(f'data="{data}" is not for case="{case}"')


def pulled(plate: rbs.Part) -> list[BoundaryDomain]:
    """Dead forces on the outermost nodes, centre lines on rollers."""
    x, y = plate.positions.T
    stiff = MODULI["extension"] / ((1 + NU) * (1 - 2 * NU))
    force = stiff * np.log(LONG) / LONG * plate.spacing  # N/m, on each node
    found = []
    for axis, place in enumerate((x, y)):
        line = np.flatnonzero(np.abs(place) < 1e-6)
        if not len(line):
            raise ValueError("the extension needs an odd n: nodes on the centre lines")
        found.append(BoundaryDomain(plate, line, displacement=[0.0 if k == axis else None for k in (0, 1)]))
        for sign in (-1, 1):
            outer = np.flatnonzero(sign * place > 0.5 - 0.6 * plate.spacing)
            each = np.full(len(outer), sign * force)
            load = [(lambda time, each=each: each * time) if k == axis else None for k in (0, 1)]
            found.append(BoundaryDomain(plate, outer, force=load))
    return found


# -- results -------------------------------------------------------------------------------------------------------


def theory(case: str, F: np.ndarray) -> dict[str, float]:
    """Logarithmic strain and Cauchy stress (Pa) of a deformation gradient: ε = ½ ln(F F^T), σ = (λ tr ε I + 2G ε)/J."""
    G = MODULI[case] / (2 * (1 + NU))
    lame = 2 * G * NU / (1 - 2 * NU)
    values, axes = np.linalg.eigh(F @ F.T)
    strain = (axes * (0.5 * np.log(values))) @ axes.T
    cauchy = (lame * np.trace(strain) * np.eye(2) + 2 * G * strain) / np.linalg.det(F)
    return {
        "strain_xx": strain[0, 0], "strain_xy": strain[0, 1], "stress_xx": cauchy[0, 0], "stress_xy": cauchy[0, 1],
    }  # fmt: skip


def measure(analysis: rbs.Analysis) -> dict[str, object]:
    """Errors of displacement, deformation gradient and stress in the body and at the centre."""
    newton = next(r for r in analysis.relations if isinstance(r, Newton))
    table = next(r.path for r in analysis.relations if isinstance(r, CSVExporter))
    history = {name: np.array(column) for name, column in read_table(table.with_suffix(".csv")).items()}
    plate, case = analysis.parts[0], analysis.title.partition(", ")[2]
    F, body, X = target(case), plate.body, plate.positions
    wanted = X[body] @ (F - np.eye(2)).T
    off = np.linalg.norm(plate[displacement][body] - wanted, axis=1)
    size = np.linalg.norm(wanted, axis=1)
    moving = size > 1e-9
    gradients, P = plate[deformation_gradient][body], plate[stress][body]
    sigma = P @ np.swapaxes(gradients, 1, 2) / np.linalg.det(gradients)[:, None, None]
    exact = theory(case, F)
    inner = np.abs(X[body]).max(axis=1) <= 0.3
    largest = max(abs(exact["stress_xx"]), abs(exact["stress_xy"]))
    return {
        "nodes_of_the_body": len(body),
        "directed_bonds": len(plate.bonds),
        "solving_s": sum(each.seconds for each in newton.history),
        "iterations": [each.count for each in newton.history],
        "displacement_error": float(off.max() / size.max()),
        "mean_displacement_error": float((off[moving] / size[moving]).mean()),
        "gradient_error": float(np.abs(gradients - F).max()),
        "gradient_error_inside": float(np.abs(gradients[inner] - F).max()),
        "stress_error": float(np.abs(sigma[:, 0, 0] - exact["stress_xx"]).max() / largest),
        **at_the_centre(case, history),
    }


def at_the_centre(case: str, history: dict[str, np.ndarray]) -> dict[str, object]:
    """Relative errors there, at the end and the largest of all steps."""
    errors: dict[str, list[float]] = {}
    for k, share in enumerate(history["time"]):
        if share == 0:
            continue
        F, P = (np.array([[history[f"{a}_{i}{j}"][k] for j in "xy"] for i in "xy"]) for a in "FP")
        wanted, found = theory(case, target(case, share)), theory(case, F)
        cauchy = P @ F.T / np.linalg.det(F)
        found |= {"stress_xx": cauchy[0, 0], "stress_xy": cauchy[0, 1]}
        wanted["F_xy"], found["F_xy"] = target(case, share)[0, 1], F[0, 1]
        for name, value in wanted.items():
            if abs(value) > 1e-9:
                errors.setdefault(name, []).append(abs(found[name] / value - 1))
    last = {f"{name}_error_at_the_centre": each[-1] for name, each in errors.items()}
    return {**last, "largest_error_at_the_centre": max(max(each) for each in errors.values())}


if __name__ == "__main__":
    sys.exit(main(["run", __file__, *sys.argv[1:]]))
