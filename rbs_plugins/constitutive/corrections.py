"""Partial volumes: how much of a neighbor's cell lies within the horizon."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput
from rbs_core.part import Host
from rbs_core.part.storage import TOLERANCE
from rbs_plugins.fields import volume_fraction

Array = NDArray[np.float64]
Rule = Callable[[Host, Array], Array]
# Slices of a cell in 3-D: nodes and weights of Gauss-Legendre on [-1/2, 1/2].
SLICES = 24


def linear_band(part: Host, bonds: Array) -> Array:
    """Share of the neighbor's cell within the horizon δ, linear over a band of one spacing Δ.

    β = 1 up to δ − Δ/2, 0 from δ + Δ/2 on, straight in between (Madenci & Oterkus 2014, section 7.2: the band is as
    wide as one cell). Where bonds reach no further than δ, β lies in [1/2, 1]; a reach of δ + Δ/2 gives the whole band.

    Args:
        part: whose bonds.
        bonds: ξ (k, d), m.

    Raises:
        BadInput: if the part has no spacing.
    """
    spacing = _spacing(part, "linear")
    lengths = np.sqrt((bonds * bonds).sum(axis=1))
    return np.clip((part.bonds.horizon + spacing / 2 - lengths) / spacing, 0.0, 1.0)


def cell_share(part: Host, bonds: Array) -> Array:
    """Share of the neighbor's cell within the horizon: a segment, square or cube as wide as the spacing.

    In 1-D and 2-D the closed form (of segments and arcs, as Seleson 2014 has it); in 3-D the areas of 24 slices
    of the cell, by Gauss-Legendre, good to 1e-5 of the cell from δ = 2Δ on. Whole cells reach up to δ + √d Δ/2.

    Args and raises as `linear_band`.
    """
    spacing = _spacing(part, "exact")
    # sorted, so that cells which differ in the order of components only get the same share, to the bit
    radius, middle = part.bonds.horizon / spacing, np.sort(np.abs(bonds) / spacing, axis=1)
    share = np.ones(len(middle))
    inner, outer = np.maximum(middle - 0.5, 0.0), middle + 0.5
    share[(inner**2).sum(axis=1) >= radius**2] = 0.0
    edge = np.flatnonzero((share > 0) & ((outer**2).sum(axis=1) > radius**2))
    share[edge] = _share_of_unit_cell(middle[edge], radius)
    return share


def _share_of_unit_cell(middle: Array, radius: float) -> Array:
    if middle.shape[1] == 1:
        return np.clip(radius + 0.5 - middle[:, 0], 0.0, 1.0)
    if middle.shape[1] == 2:
        return np.clip(_square_in_disk(middle, np.full(len(middle), radius)), 0.0, 1.0)
    low, *others = middle.T  # sliced across the axis of the smallest component, along which areas change least
    total = np.zeros(len(middle))
    for place, weight in zip(*np.polynomial.legendre.leggauss(SLICES), strict=True):
        disk = np.sqrt(np.maximum(radius**2 - (low + 0.5 * place) ** 2, 0.0))
        total += 0.5 * weight * _square_in_disk(np.stack(others, axis=1), disk)
    return np.clip(total, 0.0, 1.0)


def _square_in_disk(middle: Array, radius: Array) -> Array:
    """Areas of unit squares around (k, 2) within disks (k,) around the origin."""
    total = np.zeros(len(middle))
    for one, two in product((-0.5, 0.5), repeat=2):
        total += np.sign(one * two) * _corner_in_disk(middle[:, 0] + one, middle[:, 1] + two, radius)
    return total


def _corner_in_disk(a: Array, b: Array, radius: Array) -> Array:
    """Area of the rectangle from the origin to (a, b) within a disk around the origin, negative where a b is."""
    x, y = np.minimum(np.abs(a), radius), np.minimum(np.abs(b), radius)
    # from x = 0 to where the circle leaves through the upper side, and from there under the arc
    start = np.minimum(np.sqrt(np.maximum(radius**2 - y**2, 0.0)), x)
    area = y * start + _under_arc(x, radius) - _under_arc(start, radius)
    return np.asarray(np.sign(a) * np.sign(b) * area)


def _under_arc(x: Array, radius: Array) -> Array:
    """∫ sqrt(R² − x²) from 0 to x."""
    angle = np.arcsin(np.divide(x, radius, out=np.zeros_like(x), where=radius > 0))
    return 0.5 * (x * np.sqrt(np.maximum(radius**2 - x**2, 0.0)) + radius**2 * angle)


def _spacing(part: Host, rule: str) -> float:
    if part.spacing is None:
        raise BadInput(
            f"part '{part.name}' has no spacing, which partial_volume='{rule}' needs: part.place(..., spacing=...)"
        )
    return part.spacing


PARTIAL_VOLUMES: dict[str, Rule | None] = {"none": None, "linear": linear_band, "exact": cell_share}


def share_of(part: Host, name: str, bonds: Array) -> Array:
    """β (k,) of bonds ξ (k, d) of a part by the name of a rule."""
    rule = PARTIAL_VOLUMES[name]
    return np.ones(len(bonds)) if rule is None else rule(part, bonds)


def set_partial_volume(part: Host, name: str) -> bool:
    """Sets the volume fraction of a part by the name of a rule.

    Returns:
        True if neighbors count with a fraction.

    Raises:
        BadInput: on an unknown name, if the part already has fractions of another rule, or if its bonds reach beyond
            the horizon and shall all count fully.
    """
    if name not in PARTIAL_VOLUMES:
        raise BadInput(f"partial_volume={name!r} must be one of {', '.join(PARTIAL_VOLUMES)}")
    rule = PARTIAL_VOLUMES[name]
    if rule is None:
        if part.bonds.reach > part.bonds.horizon * (1 + TOLERANCE):
            raise BadInput(
                f"part '{part.name}' has bonds beyond its horizon (reach={part.bonds.reach:g} m), which count with a "
                "partial volume only: partial_volume='linear' or 'exact', or connect without reach"
            )
        return False
    before = part.raw(volume_fraction).copy() if volume_fraction in part else None
    part.bonds.tabulate(volume_fraction, lambda bonds: rule(part, bonds))
    if before is not None and not np.array_equal(part.raw(volume_fraction), before):
        part.raw(volume_fraction)[...] = before
        raise BadInput(f"part '{part.name}' already has other volume fractions: use one rule for all its relations")
    return True
