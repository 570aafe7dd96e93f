"""Beams of a bond-based material in equilibrium against theory (section 4.1 of Sarego 2016).

A beam of 30 x 1.5 mm², E = 70 GPa, plane stress, bond-based (Poisson's ratio 1/3), on 400 x 20 nodes with a horizon of
three spacings: a cantilever under a force or a moment at its tip, and a beam on two supports under a uniform load. The
dissertation of G. Sarego (Padova) compares deflections with those of finite elements on as many nodes: they are within
4.5 %, 5.5 % and 3.5 % away from loads and supports. It then refines the grid, first with three spacings in a horizon,
then with a horizon of 0.6 mm; these errors are in figures only. The beam is too soft, because nodes at its edges lack
neighbors, and stiffens where the grid is refined. Here the beam of Timoshenko stands in for finite elements.

The dissertation omits the rest. Taken here: nodes in the middle of square cells that fill the beam; whole columns of
nodes of the beam are clamped, as far as a horizon reaches, and as many share the load at the tip, a moment as a linear
distribution over the depth; supports are the first and the last column, which cannot move up or down; the uniform
load acts on the uppermost row. `clamp="outside"` clamps a layer beyond the end of the beam instead.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import rbs_core as rbs
from rbs_core.command import main
from rbs_plugins import BondBased, BoundaryDomain, Newton, PictureExporter, VTKHDFExporter
from rbs_plugins.fields import displacement, volume

LENGTH, DEPTH, THICKNESS = 30e-3, 1.5e-3, 1e-3  # m
E, NU = 70e9, 1 / 3  # Pa, 1
FORCE, MOMENT = 1e3, 10.0  # N, N m: in total; what is linear does not depend on them
BENDING = E * THICKNESS * DEPTH**3 / 12  # N m²
SHEAR = 10 * (1 + NU) / (12 + 11 * NU) * E / (2 * (1 + NU)) * THICKNESS * DEPTH  # N, with Cowper's coefficient

PUBLISHED = {"force": 4.5, "moment": 5.5, "uniform": 3.5}  # percent: largest errors


def scene(
    load: str = "force",
    n: int = 400,
    m: int = 3,
    clamped: int | None = None,
    loaded: int | None = None,
    clamp: str = "inside",
    partial_volume: str = "linear",
    out: str | Path = "out/sarego_beam",
) -> rbs.Analysis:
    """The beam with n nodes along it and m spacings in a horizon.

    `load` is "force" or "moment" at the tip of a cantilever, or "uniform" between two supports. `clamped` and `loaded`
    count columns of nodes, m if not given; `clamp` is "inside" or "outside" of the length.
    """
    clamped, loaded = clamped or m, loaded or m
    spacing = LENGTH / n
    horizon = m * spacing * (1 + 1e-9)
    out = Path(out)
    beam = rbs.Part("beam", rbs.Box.between((0.0, -DEPTH / 2), (LENGTH, DEPTH / 2)))
    beam.discretize(spacing, thickness=THICKNESS)
    if clamp == "outside":
        beam.extend("layer", "-x", thickness=clamped * spacing)
    elif clamp != "inside":
        raise ValueError(f'clamp="{clamp}": "inside" or "outside"')
    reach = horizon + spacing / 2 if partial_volume == "linear" else None
    beam.connect(horizon, reach=reach)
    solid = BondBased(beam, E=E, nu=NU, partial_volume=partial_volume, linear=True)

    x, y = beam.positions.T
    tip = x > LENGTH - loaded * spacing
    held = "layer" if clamp == "outside" else x < clamped * spacing
    if load == "uniform":
        supports = BoundaryDomain(beam, np.minimum(x, LENGTH - x) < spacing, displacement=(None, 0.0))
        pin = BoundaryDomain(beam, [np.argmin(x + np.abs(y))], displacement=(0.0, None))
        pressure = BoundaryDomain(beam, y > DEPTH / 2 - spacing, force=(0.0, -FORCE))
        boundaries = [supports, pin, pressure]
    elif load == "force":
        boundaries = [
            BoundaryDomain(beam, held, displacement=(0.0, 0.0)), BoundaryDomain(beam, tip, force=(0.0, -FORCE))
        ]  # fmt: skip
    elif load == "moment":
        density = MOMENT / np.sum(beam[volume][tip] * y[tip] ** 2)
        boundaries = [
            BoundaryDomain(beam, held, displacement=(0.0, 0.0)),
            BoundaryDomain(beam, tip, body_force=(density * y[tip], 0.0)),
        ]
    else:
        raise ValueError(f'load="{load}": "force", "moment" or "uniform"')
    return rbs.Analysis(
        [
            Newton(beam, [solid], boundaries, solver="direct"),
            VTKHDFExporter(beam, [displacement], out / "beam", when=rbs.last),
            PictureExporter(beam, displacement, out / "deflection", component="y", when=rbs.last),
        ],
        dt=1.0,
        steps=1,
        title=f"sarego_beam, {load}, {n} nodes, m = {m}",
    )


def theory(load: str, x: np.ndarray) -> np.ndarray:
    """Deflection of a Timoshenko beam, m, downwards negative."""
    if load == "force":
        return -FORCE * (x**2 * (3 * LENGTH - x) / (6 * BENDING) + x / SHEAR)
    if load == "moment":
        return -MOMENT * x**2 / (2 * BENDING)
    q = FORCE / LENGTH
    return -q * x * (LENGTH**3 - 2 * LENGTH * x**2 + x**3) / (24 * BENDING) - q * x * (LENGTH - x) / (2 * SHEAR)


def measure(analysis: rbs.Analysis) -> dict[str, object]:
    """Errors of the deflection, percent of theory at the same place, and how far from supports they are as published.

    `error` is that at the tip, or in the middle between two supports; `largest` of all columns further than a tenth of
    the length from clamp and supports.
    """
    beam = analysis.parts[0]
    load = analysis.title.split(", ")[1]
    columns, index = np.unique(np.round(beam.positions[:, 0] / beam.spacing, 3), return_inverse=True)
    deflection = np.bincount(index, beam[displacement][:, 1]) / np.bincount(index)
    body = columns > 0
    x, deflection = columns[body] * beam.spacing, deflection[body]
    error = 100 * (deflection / theory(load, x) - 1)
    place = len(x) // 2 if load == "uniform" else -1
    away = np.minimum(x, LENGTH - x) if load == "uniform" else x
    worse = away[np.abs(error) > PUBLISHED[load]]
    newton = next(r for r in analysis.relations if isinstance(r, Newton))
    return {
        "nodes": len(beam),
        "directed_bonds": len(beam.bonds),
        "deflection_m": float(deflection[place]),
        "deflection_of_theory_m": float(theory(load, x)[place]),
        "error_percent": float(error[place]),
        "largest_error_percent": float(np.abs(error[away > 0.1 * LENGTH]).max()),
        "as_published_beyond_m": float(worse.max()) if len(worse) else 0.0,
        "residual": newton.history[-1].residuals[-1],
        "solve_seconds": sum(each.seconds for each in newton.history),
    }


if __name__ == "__main__":
    sys.exit(main(["run", __file__, *sys.argv[1:]]))
