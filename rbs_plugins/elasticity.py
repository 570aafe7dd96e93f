"""Classical elasticity that cases compare with: wave speeds of an isotropic solid."""

from __future__ import annotations

import math
from dataclasses import dataclass

from scipy.optimize import brentq

from rbs_core import BadInput


@dataclass(frozen=True)
class WaveSpeeds:
    """Speeds of pressure, shear and Rayleigh waves, m/s."""

    pressure: float
    shear: float
    rayleigh: float


def wave_speeds(E: float, nu: float, rho: float, *, plane: str | None = None) -> WaveSpeeds:
    """Wave speeds of an isotropic elastic solid.

    Args:
        E: Young's modulus, Pa.
        nu: Poisson's ratio.
        rho: density, kg/m^3.
        plane: "stress" for a thin plate; None or "strain" for the solid.

    The Rayleigh speed c solves (2 − c²/cs²)² = 4 sqrt(1 − c²/cp²) sqrt(1 − c²/cs²) with the pressure speed of the
    plate or solid (Achenbach 1973, section 5.11).

    Raises:
        BadInput: on values that no stable solid has.
    """
    if not (E > 0 and rho > 0 and -1 < nu < 0.5):
        raise BadInput(f"wave_speeds(E={E}, nu={nu}, rho={rho}): E and rho must be positive and -1 < nu < 0.5")
    shear = math.sqrt(E / (2 * (1 + nu)) / rho)
    stiffness = E / (1 - nu**2) if plane == "stress" else E * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    pressure = math.sqrt(stiffness / rho)

    def rayleigh(x: float) -> float:
        slow, fast = x**2, (x * shear / pressure) ** 2
        return (2 - slow) ** 2 - 4 * math.sqrt(1 - fast) * math.sqrt(1 - slow)

    return WaveSpeeds(pressure, shear, shear * float(brentq(rayleigh, 0.5, 1 - 1e-12)))
