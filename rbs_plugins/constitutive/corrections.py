"""Corrections of the sum over a family: partial volumes of neighbors at the edge of the horizon."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput
from rbs_core.part import Host
from rbs_plugins.fields import volume_fraction


def linear_band(part: Host, lengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """Share of the neighbor's cell within the horizon δ, linear over a band of one spacing Δ.

    β = 1 up to δ − Δ/2, 0 from δ + Δ/2 on, straight in between (Madenci & Oterkus 2014, section 7.2: the band is as
    wide as one cell). Neighbors beyond δ are not in the family, so β of a bond lies in [1/2, 1].
    """
    if part.spacing is None:
        raise BadInput(
            f"part '{part.name}' has no spacing, which partial_volume='linear' needs: part.place(..., spacing=...)"
        )
    band = (part.bonds.horizon + part.spacing / 2 - lengths) / part.spacing
    return np.clip(band, 0.0, 1.0)


PARTIAL_VOLUMES: dict[str, Callable[[Host, NDArray[np.float64]], NDArray[np.float64]] | None] = {
    "none": None,
    "linear": linear_band,
}


def set_partial_volume(part: Host, name: str) -> bool:
    """Sets the volume fraction of a part by the name of a rule.

    Returns:
        True if neighbors count with a fraction.

    Raises:
        BadInput: on an unknown name, or if the part already has fractions of another rule.
    """
    if name not in PARTIAL_VOLUMES:
        raise BadInput(f"partial_volume={name!r} must be one of {', '.join(PARTIAL_VOLUMES)}")
    rule = PARTIAL_VOLUMES[name]
    if rule is None:
        return False
    before = part.raw(volume_fraction).copy() if volume_fraction in part else None
    part.bonds.tabulate(volume_fraction, lambda lengths: rule(part, lengths))
    if before is not None and not np.array_equal(part.raw(volume_fraction), before):
        part.raw(volume_fraction)[...] = before
        raise BadInput(f"part '{part.name}' already has other volume fractions: use one rule for all its relations")
    return True
