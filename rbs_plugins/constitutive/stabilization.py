"""Control of zero-energy modes: deformations of a family that its deformation gradient does not see.

Both controls add ω g z to the force state, z⟨ξ⟩ = Y⟨ξ⟩ − F ξ, which vanishes for every uniform deformation. As
Σ ω V z⊗ξ = 0, the force is that of the energy ½ g Σ ω V |z|² per volume: momentum, torque and energy are kept.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

from rbs_core import BadInput
from rbs_plugins.constitutive.moduli import Moduli


class ZeroEnergyControl(ABC):
    """What a control says about g.

    Args:
        factor: dimensionless, of g.

    Attributes:
        even: whether g is the same at all nodes.
        by_family: whether g of a node is divided by Σ ωV of all bonds that it ever had, m^3.

    Raises:
        BadInput: if the factor is not positive and finite.
    """

    even: bool = False
    by_family: bool = False

    def __init__(self, factor: float) -> None:
        if not (math.isfinite(factor) and factor > 0):
            raise BadInput(f"{type(self).__name__}: the factor {factor} must be positive and finite")
        self.factor = factor

    @abstractmethod
    def gains(self, moduli: Moduli, case: str, horizon: float, across: float, unit: float) -> tuple[float, float]:
        """Flat and trace share of g, Pa: g V0 δ² of a node is the first plus the second times tr(V0 δ² K^-1).

        Args:
            moduli: of the material.
            case: "1-D", "stress", "strain" or "3-D".
            horizon: δ, m.
            across: thickness (m) or area (m²), 1 in 3-D.
            unit: V0 δ², m^5.
        """

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.factor!r})"


class SillingControl(ZeroEnergyControl):
    """g = factor C with C = 18K/(πδ⁵) in 3-D, 12K'/(πhδ⁴) in 2-D and 2E/(Aδ³) in 1-D (Silling 2017).

    Args:
        factor: dimensionless, of order 1; 0.1 to 0.4 is used for beams.
        by_family: divides g of each node by Σ ωV of its family, as printed; the factor is in m^3 then. Only for bonds
            stored as list.

    K' is the bulk modulus of the plane: E/(2(1 − ν)) in plane stress, E/(2(1 + ν)(1 − 2ν)) in plane strain. Silling
    divides the micromodulus by Σ ωV, which leaves a dimension in the factor for the constants as printed by Hashim
    (2021, eq. 5.12 to 5.15); here the influence function is divided by its mean over the bonds of the part instead, so
    that the factor has no dimension and the unit of ω no effect. As printed, it depends on the spacing, and nodes at a
    surface are held tighter: to compare with her tables.
    """

    def __init__(self, factor: float = 0.3, *, by_family: bool = False) -> None:
        super().__init__(factor)
        self.even, self.by_family = not by_family, by_family

    def gains(self, moduli: Moduli, case: str, horizon: float, across: float, unit: float) -> tuple[float, float]:
        constant = {"1-D": 2 * moduli.E / (across * horizon**3), "3-D": 18 * moduli.K / (math.pi * horizon**5)}.get(
            case, 12 * moduli.bulk(case) / (math.pi * across * horizon**4)
        )
        return self.factor * constant * unit, 0.0

    def __repr__(self) -> str:
        return f"SillingControl({self.factor!r}{', by_family=True' if self.by_family else ''})"


class WanControl(ZeroEnergyControl):
    """g from the elastic constants and the shape tensor alone: K1 = C : K^-1 (Wan, Chen, Chu & Liu 2019).

    Args:
        factor: 1 is theirs.

    C is the tensor of elasticity. Of K1 its isotropic part is taken, g = (d λ + 2G) tr(K^-1)/d: where K is isotropic,
    as inside a regular grid, that is all of it. Near a surface the rest of K1, which does not turn with the body, would
    make forces of a rotation and a torque.
    """

    def __init__(self, factor: float = 1.0) -> None:
        super().__init__(factor)

    def gains(self, moduli: Moduli, case: str, horizon: float, across: float, unit: float) -> tuple[float, float]:
        d = {"1-D": 1, "3-D": 3}.get(case, 2)
        return 0.0, self.factor * (moduli.plane_lame(case) + 2 * moduli.G / d)
