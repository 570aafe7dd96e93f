"""Constants of an isotropic elastic solid: any two of them determine the others."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rbs_core import BadInput


@dataclass(frozen=True)
class Moduli:
    """An isotropic elastic solid.

    Attributes:
        E: Young's modulus, Pa.
        nu: Poisson's ratio.
    """

    E: float
    nu: float

    @property
    def K(self) -> float:
        """Bulk modulus of the solid, Pa."""
        return self.E / (3 * (1 - 2 * self.nu))

    @property
    def G(self) -> float:
        """Shear modulus, Pa."""
        return self.E / (2 * (1 + self.nu))

    @property
    def lame(self) -> float:
        """Lamé's first constant λ, Pa."""
        return self.E * self.nu / ((1 + self.nu) * (1 - 2 * self.nu))

    def plane_lame(self, case: str) -> float:
        """λ as it acts among the strains of a part: of the solid; 2λG/(λ + 2G) in plane stress.

        Args:
            case: "1-D" (where λ + 2G is E), "stress", "strain" or "3-D".
        """
        if case == "1-D":
            return self.E - 2 * self.G
        return 2 * self.lame * self.G / (self.lame + 2 * self.G) if case == "stress" else self.lame

    def bulk(self, case: str) -> float:
        """Stress over change of length, area or volume, Pa: E, λ' + G or K (Le, Chan & Schwartz 2014 in a plane)."""
        return self.K if case == "3-D" else self.E if case == "1-D" else self.plane_lame(case) + self.G

    @classmethod
    def of(
        cls, name: str, E: float | None = None, nu: float | None = None, K: float | None = None, G: float | None = None
    ) -> Moduli:
        """From two constants.

        Raises:
            BadInput: on any other number of them, or values that no stable solid has.
        """
        given = {key: value for key, value in (("E", E), ("nu", nu), ("K", K), ("G", G)) if value is not None}
        if len(given) != 2:
            raise BadInput(f"{name}: give exactly two of E, nu, K and G, got {', '.join(given) or 'none'}")
        for key, value in given.items():
            if not (math.isfinite(value) and (value > 0 or key == "nu")):
                raise BadInput(f"{name}: {key}={value} must be positive and finite")
        if nu is None:
            if E is None:
                assert K is not None
                assert G is not None
                nu = (3 * K - 2 * G) / (2 * (3 * K + G))
            else:
                nu = E / (2 * G) - 1 if G is not None else 0.5 - E / (6 * (K or 1.0))
        if not -1 < nu < 0.5:
            values = ", ".join(f"{key}={value}" for key, value in given.items())
            raise BadInput(f"{name}: {values} mean a Poisson's ratio of {nu:.6g}: it must lie between -1 and 0.5")
        if E is None:
            E = 2 * G * (1 + nu) if G is not None else 3 * (K or 0.0) * (1 - 2 * nu)
        return cls(float(E), float(nu))
