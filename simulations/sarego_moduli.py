"""Moduli of a plate in tension, recovered in three ways (section 4.2 of Sarego 2016).

A plate of 8 x 2 mm², of an ordinary state-based solid in plane stress with E = 71 GPa, is pulled by uniform forces on
the layer of nodes at each end. Its moduli come back from the equilibrium in three ways: from two neighbors of the node
in the middle ("double node"), from all nodes that are two horizons away from edges ("internal node"), and from strain
and stress tensor of the node in the middle. The dissertation of G. Sarego (Padova) compares them for several ratios m
of horizon and spacing, horizons, Poisson's ratios, and nine influence functions.

The tensor method sees one whole family under a uniform strain: its errors are those of the lattice and depend on m, ν
and ω alone. `closed_form` has them as a sum over the neighbors of one node. The areal modulus E/(1 − ν) is exact for
every family, so the error of E is −ν/(1 − ν) times that of ν.

In table 4.2, of the influence functions, the headings of E and ν are interchanged, because only so does that factor
fit; so are the rows r and δ − r. The last function was exp(1/(r − δ/4)) with lengths in mm. |δ/(2r − δ)| is infinite
for nodes at r = δ/2, which exist where m is even, and refused here. δ − r is negative for neighbors beyond the horizon
whose cells lie partly within: here they do not count, in the table they do (`clipped=False` of `closed_form`).

The dissertation omits the rest. Taken here: nodes on the edges, each with a whole volume, as in its listings, and in
the middle, so that the plate is up to a spacing larger or smaller where spacings do not fit; 1 mm of thickness; nodes
on the axes of symmetry stay on them; the two nodes are those next to the middle; the stress of the first two methods
is the force over the number of rows times the spacing.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import rbs_core as rbs
from rbs_core.command import main
from rbs_plugins import BoundaryDomain, Newton, OrdinaryStateBased, PictureExporter, Strain, Stress, VTKHDFExporter
from rbs_plugins.constitutive.influence import influences
from rbs_plugins.fields import displacement, strain, stress

LENGTH, DEPTH, THICKNESS = 8e-3, 2e-3, 1e-3  # m
E = 71e9  # Pa
TRACTION = 1e6  # Pa: what is linear does not depend on it
MILLIMETRE = 1e-3


def in_millimetres(reference_length, horizon):
    """exp(1 mm/(|ξ| − δ/4)): the last function of table 4.2 as it was computed."""
    return np.exp(MILLIMETRE / (reference_length - 0.25 * horizon))


FUNCTIONS = {"in_millimetres": in_millimetres}


def scene(
    nu: float = 0.1,
    m: int = 6,
    horizon: float = 0.3e-3,
    influence: str = "constant",
    load: str = "tension",
    out: str | Path = "out/sarego_moduli",
) -> rbs.Analysis:
    """The plate with m spacings in a horizon; `influence` is a name of the package or "in_millimetres".

    `load` is "tension", or "strain": every node is displaced as in the plate without a surface, and nothing is solved.
    """
    spacing = horizon / m
    out = Path(out)
    length, depth = (2 * spacing * round(size / spacing / 2) for size in (LENGTH, DEPTH))
    plate = rbs.Part("plate", rbs.Box(size=(length + spacing, depth + spacing)))
    plate.discretize(spacing, thickness=THICKNESS)
    plate.connect(horizon, reach=horizon + spacing / 2, storage="list")
    omega = FUNCTIONS.get(influence, influence)
    solid = OrdinaryStateBased(plate, E=E, nu=nu, influence=omega, partial_volume="linear", linear=True)

    if load == "strain":
        plate[displacement] = lambda X: TRACTION / E * X * (1.0, -nu)
        equilibrium: list[rbs.Relation] = [solid]
    elif load == "tension":
        x, y = plate.positions.T
        force = TRACTION * depth * THICKNESS
        ends = [
            BoundaryDomain(plate, np.abs(x - side * length / 2) < spacing / 4, force=(side * force, 0.0))
            for side in (-1, 1)
        ]
        middle = BoundaryDomain(plate, np.abs(x) < spacing / 4, displacement=(0.0, None))
        axis = BoundaryDomain(plate, np.abs(y) < spacing / 4, displacement=(None, 0.0))
        equilibrium = [Newton(plate, [solid], [*ends, middle, axis])]
    else:
        raise ValueError(f'load="{load}": "tension" or "strain"')
    return rbs.Analysis(
        [
            *equilibrium,
            Strain(plate, influence=omega),
            Stress(plate, [solid], influence=omega),
            VTKHDFExporter(plate, [displacement, strain, stress], out / "plate", when=rbs.last),
            PictureExporter(plate, displacement, out / "u_x", component="x", when=rbs.last),
        ],
        dt=1.0,
        steps=1,
        title=f"sarego_moduli, m = {m}, {influence}",
    )


def measure(analysis: rbs.Analysis) -> dict[str, object]:
    """Errors of E and Poisson's ratio by three methods, percent, and of the displacements away from edges."""
    plate = analysis.parts[0]
    solid = next(r for r in analysis.unique if isinstance(r, OrdinaryStateBased))
    nu, spacing, horizon = float(solid.nu), plate.spacing, plate.bonds.horizon
    x, y = plate.positions.T
    u = plate[displacement] - plate[displacement][node_at(plate, 0.0, 0.0)]
    center = node_at(plate, 0.0, 0.0)
    found: dict[str, object] = {"nodes": len(plate), "directed_bonds": len(plate.bonds)}

    def errors(name: str, modulus: float, ratio: float) -> None:
        found[f"E_error_{name}_percent"] = 100 * (modulus / E - 1)
        found[f"nu_error_{name}_percent"] = 100 * (ratio / nu - 1)

    errors("tensor", *tensor_method(plate[strain][center], plate[stress][center]))
    expected = closed_form(nu, round(horizon / spacing), solid.dilatation.influence, horizon)
    found["E_error_closed_form_percent"], found["nu_error_closed_form_percent"] = expected
    newton = [r for r in analysis.relations if isinstance(r, Newton)]
    if not newton:
        return found

    length, depth = np.ptp(x), np.ptp(y)
    stressed = TRACTION * depth / (depth + spacing)
    along = u[node_at(plate, spacing, 0.0), 0] / spacing
    across = u[node_at(plate, 0.0, spacing), 1] / spacing
    errors("double", stressed / along, -across / along)
    inside = (np.abs(x) < length / 2 - 2 * horizon) & (np.abs(y) < depth / 2 - 2 * horizon)
    if inside.sum() > 1:
        beside, above = inside & (np.abs(x) > spacing / 2), inside & (np.abs(y) > spacing / 2)
        along, across = np.mean(u[beside, 0] / x[beside]), np.mean(u[above, 1] / y[above])
        errors("internal", stressed / along, -across / along)
        wanted = TRACTION / E * plate.positions * (1.0, -nu)
        for axis, name in enumerate("xy"):
            away = np.abs(u - wanted)[inside, axis].max()
            found[f"u_{name}_error_inside_percent"] = float(100 * away / np.abs(wanted[inside, axis]).max())
    found["solve_seconds"] = sum(each.seconds for each in newton[0].history)
    return found


def node_at(plate: rbs.Part, x: float, y: float) -> int:
    """The node nearest to a place."""
    return int(np.argmin(np.hypot(*(plate.positions - (x, y)).T)))


def tensor_method(strain: np.ndarray, stress: np.ndarray) -> tuple[float, float]:
    """E and Poisson's ratio of a strain and stress (2, 2) in plane stress (Sarego's eq. 4.17)."""
    matrix = np.array([[stress[1, 1], strain[0, 0]], [stress[0, 0], strain[1, 1]]])
    nu, modulus = np.linalg.solve(matrix, np.diag(stress))
    return float(modulus), float(nu)


def closed_form(nu: float, m: int, influence: object, horizon: float = 0.3e-3, clipped: bool = True) -> tuple:
    """Errors of the tensor method, percent of E and of ν: a sum over the neighbors of a node in an endless grid.

    t = (γ (ωx•e)/q + 8μ e) ω/q with γ = 2(3ν − 1)E/(1 − ν²), in a uniform strain, and the linear partial volume.
    """
    span = np.arange(-m - 1, m + 2)
    bonds = np.stack(np.meshgrid(span, span), -1).reshape(-1, 2) * horizon / m
    length = np.hypot(*bonds.T)
    share = np.clip((horizon - length) * m / horizon + 0.5, 0.0, 1.0) * (length > 0)
    bonds, length, share = bonds[share > 0], length[share > 0], share[share > 0]
    if clipped:
        omega = influences(influence, length, horizon, horizon / m, "closed form")
    else:
        omega = influence(length, horizon)  # type: ignore[operator]
    mu, gamma = E / (2 * (1 + nu)), 2 * (3 * nu - 1) * E / (1 - nu**2)
    stretched = np.diag([1.0, -nu])
    e = np.einsum("ki,ij,kj->k", bonds, stretched, bonds) / length
    q = np.sum(omega * length**2 * share)
    t = (gamma * np.sum(omega * length * e * share) / q * length + 8 * mu * e) * omega / q
    stress = np.einsum("k,ki,kj->ij", t * share / length, bonds, bonds)
    modulus, ratio = tensor_method(stretched, stress)
    return 100 * (modulus / E - 1), 100 * (ratio / nu - 1)


if __name__ == "__main__":
    sys.exit(main(["run", __file__, *sys.argv[1:]]))
