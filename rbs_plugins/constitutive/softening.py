"""Bonds that soften before they fail."""

from __future__ import annotations

from typing import Any

import numpy as np

from rbs_core import BadInput, Geometry
from rbs_plugins.constitutive.fracture import Criterion, beyond_tension
from rbs_plugins.functions import tanh


def soften(largest_stretch, s_min, s0, sharpness):
    """T_s: 1 below s_min, ½ [1 − tanh(β (s_min + s0 − 2s)/(s_min − s0))] up to s0, 0 beyond (Hashim 2021, eq. 6.1)."""
    falling = 0.5 * (1.0 - tanh(sharpness * (s_min + s0 - 2.0 * largest_stretch) / (s_min - s0)))
    return 1.0 if largest_stretch < s_min else (0.0 if largest_stretch > s0 else falling)


def soften_slope(largest_stretch, s_min, s0, sharpness):
    """dT_s/ds = −β sech²(n)/(s0 − s_min) between the two stretches, n the argument of tanh above.

    Hashim (2021, eq. 6.7) prints ∂q/∂n = tanh²(n − 1) where it is tanh²(n) − 1.
    """
    level = tanh(sharpness * (s_min + s0 - 2.0 * largest_stretch) / (s_min - s0))
    falling = sharpness * (1.0 - level * level) / (s_min - s0)
    return 0.0 if largest_stretch < s_min or largest_stretch > s0 else falling


class BondSoftening(Criterion):
    """The force state of a bond fades between two stretches and the bond is deleted at the second (Hashim 2021, 6.2.1).

    Args:
        s_min: stretch at which softening begins.
        s0: critical stretch, at which the bond is deleted.
        sharpness: β; 3 is hers: T_s falls from 0.9975 at s_min to 0.0025 at s0.
        within: only bonds with both ends in this geometry may soften to failure.
        release: "at once" or "next step", see Criterion.

    Raises:
        BadInput: unless 0 < s_min < s0 and the sharpness is positive.

    Both force states of a bond, those of the zero-energy control included, are multiplied by T_s of the largest stretch
    that the bond has had (she gives no rule for unloading; here nothing heals). Shape tensor and deformation gradient
    count softened bonds fully until they are deleted, as printed; so torque is balanced only up to the size of the
    softened forces, and energy is lost. Bonds must be stored as list.
    """

    softening = staticmethod(soften)
    slope = staticmethod(soften_slope)

    def __init__(
        self, s_min: float, s0: float, *, sharpness: float = 3.0, within: Geometry | None = None,
        release: str = "at once",
    ) -> None:  # fmt: skip
        if not (np.isfinite([s_min, s0, sharpness]).all() and 0 < s_min < s0 and sharpness > 0):
            raise BadInput(
                f"BondSoftening({s_min}, {s0}, sharpness={sharpness}): give 0 < s_min < s0 and sharpness > 0"
            )
        super().__init__(beyond_tension, within=within, release=release, s_min=s_min, s0=s0, sharpness=sharpness)

    def parameters(self, force: Any) -> dict[str, float]:
        return dict(self._parameters)
