"""Bond-based elasticity: f = c s, with the micromodulus c from Young's or bulk modulus, horizon and dimension."""

from __future__ import annotations

import math
from typing import Any

from rbs_core import BadInput, Part, Trigger, always
from rbs_core.part import Connection, Host
from rbs_plugins.constitutive.bonded import require_bonds
from rbs_plugins.constitutive.fracture import Criterion
from rbs_plugins.constitutive.pairwise import PairwiseForce

# Poisson's ratio that a pair potential gives: Cauchy's relations in 3-D and plane strain, 1/3 in plane stress.
POISSON = {"stress": 1 / 3, "strain": 1 / 4, "3-D": 1 / 4}
# Published cases round the ratio to two digits (0.33, 0.25); anything else is another material.
POISSON_TOLERANCE = 5e-3


def proportional(stretch, c):
    """Pairwise force of the prototype microelastic brittle material (Silling & Askari 2005, eq. 11)."""
    return c * stretch


def proportional_potential(stretch, reference_length, c):
    """Its micropotential w = c s^2 |ξ| / 2 (Silling & Askari 2005, eq. 12)."""
    return 0.5 * c * stretch * stretch * reference_length


def beyond_in_tension(stretch, reference_length, c, w0):
    """True for a lengthened bond that holds more than w0."""
    return (0.5 * c * stretch * stretch * reference_length > w0) & (stretch > 0.0)


def beyond(stretch, reference_length, c, w0):
    """True for a bond that holds more than w0."""
    return 0.5 * c * stretch * stretch * reference_length > w0


def micromodulus(E: float, horizon: float, case: str, across: float = 1.0) -> float:
    """Micromodulus c in N/m^6 for a constant micromodulus function and the whole family.

    Args:
        E: Young's modulus, Pa.
        horizon: δ, m.
        case: "1-D" 2E/(Aδ²), "stress" 9E/(πhδ³), "strain" 48E/(5πhδ³) or "3-D" 12E/(πδ⁴)
            (Silling & Askari 2005; Gerstle, Sau & Silling 2005; Madenci & Oterkus 2014).
        across: area A (1-D, m²) or thickness h (2-D, m).
    """
    return {
        "1-D": 2 * E / (across * horizon**2),
        "stress": 9 * E / (math.pi * across * horizon**3),
        "strain": 48 * E / (5 * math.pi * across * horizon**3),
        "3-D": 12 * E / (math.pi * horizon**4),
    }[case]


def critical_stretch(fracture_energy: float, E: float, horizon: float, case: str) -> float:
    """Critical stretch whose bonds across a unit area hold the fracture energy G0.

    G0 = ∫ ½ c s0² |ξ| over all bonds through the area: 3-D sqrt(5G0/(6Eδ)) = sqrt(5G0/(9Kδ)) (Silling & Askari 2005,
    eq. 27), plane stress sqrt(4πG0/(9Eδ)), plane strain sqrt(5πG0/(12Eδ)), and 1-D sqrt(3G0/(Eδ)), where
    G0 = A ½ c s0² ∫_0^δ (δ² − z²)/2 dz.
    """
    factor = {"1-D": 3.0, "stress": 4 * math.pi / 9, "strain": 5 * math.pi / 12, "3-D": 5 / 6}[case]
    return math.sqrt(factor * fracture_energy / (E * horizon))


class BondBased(PairwiseForce):
    """Bond-based elastic material, brittle if a criterion is given.

    Args:
        part: connected part, or connection; its dimension, thickness or area, and horizon decide the constants.
        E: Young's modulus, Pa; or give K or c instead.
        fracture: when bonds fail.
        K: bulk modulus, Pa (2-D and 3-D; E = 3K(1 − 2ν)).
        nu: Poisson's ratio, only checked: a pair potential has 1/4 (3-D, plane strain) or 1/3 (plane stress).
        plane: "stress" (default) or "strain", 2-D parts only.
        c: the micromodulus itself, N/m^6.
        partial_volume: "none", "linear" or "exact", see PairwiseForce.
        surface_correction: "none", "volume", "force density" or "energy", see SurfaceCorrection.
        linear: small displacements, see PairwiseForce.
        active: whether nodes that nothing has reached are skipped, see PairwiseForce.
        **parameters: numbers that law and criterion ask for, see PairwiseForce.

    Raises:
        BadInput: on a modulus that is not positive, too many or no moduli, or a Poisson's ratio it cannot have.
    """

    law = staticmethod(proportional)
    potential: Any = staticmethod(proportional_potential)
    slope: Any = None  # of a subclass whose law has one, see PairwiseForce
    own_parameters = ("c",)
    example = {"E": 1e9}

    def __init__(
        self,
        part: Part | Connection,
        E: float | None = None,
        fracture: Criterion | None = None,
        *,
        K: float | None = None,
        nu: float | None = None,
        plane: str | None = None,
        c: float | None = None,
        partial_volume: str = "none",
        surface_correction: str = "none",
        linear: bool = False,
        active: bool | None = None,
        when: Trigger = always,
        **parameters: float,
    ) -> None:
        name = type(self).__name__
        require_bonds(name, part)
        self.case = plane_of(name, part, plane)
        self.E, self.horizon = _young(name, self.case, E, K, nu, c), part.bonds.horizon
        if c is None:
            assert self.E is not None
            c = micromodulus(self.E, self.horizon, self.case, across_of(name, part))
        self.c = c
        own_law = type(self).law is not proportional
        potential = None if own_law and type(self).potential is proportional_potential else type(self).potential
        super().__init__(
            part,
            type(self).law,
            fracture,
            potential=potential,
            slope=type(self).slope,
            partial_volume=partial_volume,
            surface_correction=surface_correction,
            linear=linear,
            active=active,
            when=when,
            c=c,
            **parameters,
        )

    @property
    def holds_beyond(self) -> dict[str, Any] | None:  # type: ignore[override]
        """Criteria of what a bond holds, of the linear law."""
        return {"tension": beyond_in_tension, "both": beyond} if type(self).law is proportional else None

    @property
    def proportional(self) -> bool:
        return type(self).law is proportional

    @property
    def path_dependent(self) -> bool:  # type: ignore[override]
        """False: a spring holds what it has taken."""
        return type(self).law is not proportional

    def critical_stretch(self, fracture_energy: float) -> float:
        """Critical stretch of the linear material for a fracture energy G0, J/m^2."""
        if self.E is None:
            raise BadInput(f"{type(self).__name__}: a fracture energy needs E or K, not only the micromodulus c")
        if type(self).law is not proportional:
            raise BadInput(f"{type(self).__name__}: the formula for fracture energy holds for f = c s: give s0 instead")
        return critical_stretch(fracture_energy, self.E, self.horizon, self.case)


def plane_of(name: str, part: Host, plane: str | None) -> str:
    """The case of a part: "1-D", "stress", "strain" or "3-D".

    Raises:
        BadInput: on a plane that there is not.
    """
    if plane is not None and (part.dimension != 2 or plane not in ("stress", "strain")):
        raise BadInput(f"{name}: plane={plane!r} must be 'stress' or 'strain', and only for 2-D parts")
    return {1: "1-D", 2: plane or "stress", 3: "3-D"}[part.dimension]


def across_of(name: str, host: Host) -> float:
    """Thickness of a 2-D part, area of a 1-D one, 1 in 3-D.

    Raises:
        BadInput: on a connection of two parts that differ in it.
    """
    ends = host.ends if isinstance(host, Connection) else (host,)
    sizes = {end.thickness or end.area or 1.0 for end in ends}
    if len(sizes) > 1:
        what = "thickness" if host.dimension == 2 else "area"
        raise BadInput(
            f"{name} '{host.name}': the parts differ in {what} ({', '.join(f'{s:g}' for s in sorted(sizes))}), so a "
            "modulus gives no micromodulus: give c= itself, or a PairwiseForce"
        )
    return float(sizes.pop())


def _young(name: str, case: str, E: float | None, K: float | None, nu: float | None, c: float | None) -> float | None:
    """Young's modulus from what is given, after checking it."""
    given = {key: value for key, value in (("E", E), ("K", K), ("c", c)) if value is not None}
    if len(given) != 1:
        raise BadInput(f"{name}: give exactly one of E, K and c, got {', '.join(given) or 'none'}")
    for key, value in given.items():
        if not (math.isfinite(value) and value > 0):
            raise BadInput(f"{name}: {key}={value} must be positive and finite")
    if case == "1-D":
        if K is not None or nu is not None:
            raise BadInput(f"{name}: a 1-D part has no bulk modulus and no Poisson's ratio: give E")
        return E
    ratio = POISSON[case]
    if nu is not None and not abs(nu - ratio) <= POISSON_TOLERANCE:
        where = case if case == "3-D" else f"plane {case}"
        raise BadInput(
            f"{name}: a bond-based material in {where} has Poisson's ratio {ratio:.4g}, it cannot have {nu}: leave nu "
            "out, or take another model"
        )
    return 3 * K * (1 - 2 * ratio) if K is not None else E
