"""Strength that differs from node to node: what holds for the bond between two nodes, and random fields."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Field, Part
from rbs_plugins.fields import critical_stretch

if TYPE_CHECKING:
    from rbs_plugins.constitutive.pairwise import PairwiseForce


def beyond_mean(stretch, critical_stretch_i, critical_stretch_j):
    """True if stretched beyond the mean limit of both ends."""
    return stretch > 0.5 * (critical_stretch_i + critical_stretch_j)


def shortened_beyond_mean(stretch, critical_stretch_i, critical_stretch_j):
    """True if shortened beyond the mean limit of both ends."""
    return stretch < -0.5 * (critical_stretch_i + critical_stretch_j)


def either_way_beyond_mean(stretch, critical_stretch_i, critical_stretch_j):
    """True if stretched or shortened beyond the mean limit of both ends."""
    return abs(stretch) > 0.5 * (critical_stretch_i + critical_stretch_j)


def beyond_minimum(stretch, critical_stretch_i, critical_stretch_j):
    """True if stretched beyond the limit of the weaker end."""
    return (stretch > critical_stretch_i) | (stretch > critical_stretch_j)


def shortened_beyond_minimum(stretch, critical_stretch_i, critical_stretch_j):
    """True if shortened beyond the limit of the weaker end."""
    return (stretch < -critical_stretch_i) | (stretch < -critical_stretch_j)


def either_way_beyond_minimum(stretch, critical_stretch_i, critical_stretch_j):
    """True if stretched or shortened beyond the limit of the weaker end."""
    return (abs(stretch) > critical_stretch_i) | (abs(stretch) > critical_stretch_j)


# By the rule and the mode of a critical stretch.
GRADED: dict[str, dict[str, Callable[..., Any]]] = {
    "mean": {
        "tension": beyond_mean,
        "compression": shortened_beyond_mean,
        "both": either_way_beyond_mean,
    },
    "minimum": {
        "tension": beyond_minimum,
        "compression": shortened_beyond_minimum,
        "both": either_way_beyond_minimum,
    },
}


def is_graded(value: Any) -> bool:
    """True for a limit that may differ from node to node, False for a number or None.

    Raises:
        BadInput: for a field that is not the critical stretch.
    """
    if isinstance(value, Field) and value != critical_stretch:
        raise BadInput(
            f"CriticalStretch: '{value.name}' is not the field critical_stretch: set part[critical_stretch], or write "
            f"a Criterion with the arguments {value.name}_i and {value.name}_j"
        )
    return isinstance(value, Field) or callable(value) or np.ndim(value) > 0


def set_limits(force: PairwiseForce, given: Any, from_energy: bool) -> None:
    """Sets the critical stretch at the nodes of a force.

    Args:
        force: whose bonds fail.
        given: array (n,), or function of the positions (n, d); or the field itself, which the script has set.
        from_energy: whether these are fracture energies, J/m^2.

    Raises:
        BadInput: on a limit that is not positive, an array for a connection of two parts, or limits that a part already
            has and that differ.
    """
    if isinstance(given, Field):
        return
    if len(force.ends) > 1 and not callable(given):
        raise BadInput(f"{force.label}: an array of limits belongs to one part: give a function of the positions")
    for end in force.ends:
        values = np.asarray(given(end.positions) if callable(given) else given, np.float64)
        if values.shape != (len(end),):
            raise BadInput(f"{force.label}: limits must be one per node, ({len(end)},), got shape {values.shape}")
        bad = np.flatnonzero(~(np.isfinite(values) & (values > 0)))
        if len(bad):
            where = end.positions[bad[0]].tolist()
            raise BadInput(f"{force.label}: the limit of node {bad[0]} at {where} is {values[bad[0]]:g}, not positive")
        if from_energy:
            values = _from_energies(force, values)
        _set(end, values)


def _from_energies(force: PairwiseForce, energies: NDArray[np.float64]) -> NDArray[np.float64]:
    """Critical stretches (n,) for fracture energies (n,); of linear materials they go with the root."""
    low, high = float(energies.min()), float(energies.max())
    one, two = (force.critical_stretch(energy) / math.sqrt(energy) for energy in (low, high))
    if math.isclose(one, two, rel_tol=1e-9):
        return np.asarray(one * np.sqrt(energies))
    different, places = np.unique(energies, return_inverse=True)
    return np.array([force.critical_stretch(energy) for energy in different.tolist()])[places]


def _set(part: Part, values: NDArray[np.float64]) -> None:
    before = part[critical_stretch].copy() if critical_stretch in part else None
    part[critical_stretch] = values
    if before is not None and not np.array_equal(part[critical_stretch], before):
        part[critical_stretch] = before
        raise BadInput(
            f"part '{part.name}' already has other limits: use one criterion for all its forces, or "
            "CriticalStretch(critical_stretch) for the field as the script has set it"
        )


class Weibull:
    """Random limits, P(limit < s) = 1 − exp(−((s − least)/scale)^shape), each node for itself (Weibull 1951).

    Args:
        scale: positive; of a stretch or an energy, whatever it is given for.
        shape: the modulus m, positive: the larger, the less scatter. 5 to 20 is usual for ceramics and rock.
        seed: whole number; the same seed gives the same values for the same number of nodes.
        least: no limit is below.

    Raises:
        BadInput: on a scale or shape that is not positive, or a least limit below zero.

    A bond by the rule "minimum" has again such a limit, with the scale divided by 2^(1/shape). Values of neighbors do
    not depend on each other, so the scatter of a specimen depends on the spacing.
    """

    def __init__(self, scale: float, shape: float, *, seed: int, least: float = 0.0) -> None:
        for name, value in (("scale", scale), ("shape", shape)):
            if not (math.isfinite(value) and value > 0):
                raise BadInput(f"Weibull: {name}={value} must be positive and finite")
        if not (math.isfinite(least) and least >= 0):
            raise BadInput(f"Weibull: least={least} must not be below zero")
        self.scale, self.shape, self.seed, self.least = scale, shape, seed, least

    def __call__(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,) values for nodes at positions (n, d)."""
        return self.least + self.scale * np.random.default_rng(self.seed).weibull(self.shape, len(positions))

    def __repr__(self) -> str:
        least = f", least={self.least!r}" if self.least else ""
        return f"Weibull({self.scale!r}, {self.shape!r}, seed={self.seed!r}{least})"
