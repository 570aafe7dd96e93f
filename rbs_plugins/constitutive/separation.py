"""Energy that it takes to pull a body apart along a plane, for a solid whose bonds all break at one stretch."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Influence = Callable[[NDArray[np.float64]], NDArray[np.float64]]
DEPTHS, LENGTHS, ANGLES = 48, 64, 48  # points of Gauss-Legendre; doubling them changes the energy by less than 1e-4


def fracture_energy_of_unit_stretch(
    dimension: int, horizon: float, across: float, influence: Influence, gamma: float, pull: float
) -> float:
    """G0/s0² of the linear peridynamic solid, J/m^2, in the continuum.

    Args:
        dimension: 1, 2 or 3.
        horizon: δ, m.
        across: area (1-D) or thickness (2-D), m² or m; 1 in 3-D.
        influence: ω of reference lengths.
        gamma: γ, Pa, see `ordinary.moduli`.
        pull: α m, Pa.

    Two halves move apart by an opening w. A bond that crosses the plane at an angle φ from its normal is extended by
    w cos φ and breaks at s0 |ξ|. With S = w C, C(z, w) = ∫ ω |ξ| cos φ dV over the crossing bonds of a node at depth z
    that still hold, the work of the tractions is

        G0 = 2 ∫ dz ∫ dw ∫ t cos φ dV = s0² α ∫ dz ∫ ω |ξ|² dV + 2 γ/m² ∫ dz ∫ w C² dw.

    The first term is path-independent, bond by bond, as that of Silling & Askari (2005); the second one depends on the
    order in which bonds break, which is this one for a straight crack that opens evenly. Without it (γ = 0) and with
    ω = δ/|ξ| the formulas for a bond-based material follow.
    """
    depths, depth_weights = _points(0.0, horizon, DEPTHS)
    m = _moment(dimension, horizon, across, influence)
    plain = square = 0.0
    for z, share in zip(depths, depth_weights, strict=True):
        r, cosine, volume = _crossing(dimension, z, horizon, across)
        omega = influence(r)
        plain += share * float((omega * r**2 * volume).sum())
        opening = r / cosine  # at which the bond breaks, for a critical stretch of one
        order = np.argsort(-opening)
        c = np.cumsum((omega * r * cosine * volume)[order])
        ends = opening[order]
        # C is constant between the openings at which one bond after the other breaks
        square += share * float((c**2 * 0.5 * (ends**2 - np.append(ends[1:], 0.0) ** 2)).sum())
    return pull / m * plain + 2.0 * gamma / m**2 * square


def _points(low: Any, high: Any, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    half = 0.5 * (high - low)
    return low + half * (nodes + 1.0), half * weights


def _moment(dimension: int, horizon: float, across: float, influence: Influence) -> float:
    """∫ ω |ξ|² dV over the whole family, m^5."""
    r, weights = _points(0.0, horizon, 4 * LENGTHS)
    around = {1: 2.0 * across, 2: 2.0 * math.pi * across, 3: 4.0 * math.pi}[dimension]
    return around * float((influence(r) * r ** (dimension + 1) * weights).sum())


def _crossing(
    dimension: int, z: float, horizon: float, across: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Length, cosine and volume of pieces of a family that lie beyond a plane at a distance z."""
    lengths, weights = _points(z, horizon, LENGTHS)
    if dimension == 1:
        return lengths, np.ones_like(lengths), across * weights
    r = np.repeat(lengths, ANGLES)
    steepest = np.arccos(z / lengths)
    nodes, shares = _points(0.0, 1.0, ANGLES)
    angle = (steepest[:, None] * nodes).ravel()
    piece = (weights * steepest)[:, None] * shares
    ring = {2: 2.0 * across * r, 3: 2.0 * math.pi * r**2 * np.sin(angle)}[dimension]
    return r, np.cos(angle), piece.ravel() * ring
