"""Influence functions ω: plain functions of the reference length |ξ| and the horizon δ, without dimension.

    def mine(reference_length, horizon):
        return (1.0 - reference_length / horizon) ** 2

One that needs the spacing h of the grid names `spacing` as a third argument. They are computed once for a run, not once
for a step, so they may be as costly as they like. Multiplying ω by a number changes no model of this package.

The first nine are those that Sarego (2016, section 4.2.3) compares; where its text forgets a length (r for r/δ, δ − r
for 1 − r/δ, and so on) the horizon is put in. The last of the nine is printed with the numerators 1 and δ: δ here.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, BadLaw
from rbs_core.part import Host
from rbs_plugins.fields import influence as influence_field

Influence = Callable[..., Any]
_KNOWN = ("reference_length", "horizon", "spacing")


def constant(reference_length, horizon):
    """1 for all bonds."""
    return 1.0 + 0.0 * reference_length


def gaussian(reference_length, horizon):
    """exp(−|ξ|²/δ²)."""
    return np.exp(-((reference_length / horizon) ** 2))


def linear(reference_length, horizon):
    """|ξ|/δ: grows with the length."""
    return reference_length / horizon


def conical(reference_length, horizon):
    """1 − |ξ|/δ."""
    return 1.0 - reference_length / horizon


def inverse(reference_length, horizon):
    """δ/|ξ|."""
    return horizon / reference_length


def inverse_fourth(reference_length, horizon):
    """(δ/|ξ|)⁴."""
    return (horizon / reference_length) ** 4


def hyperbolic(reference_length, horizon, spacing):
    """δ/(δ + h/2 − |ξ|): highest at the edge of the horizon."""
    return horizon / (horizon + 0.5 * spacing - reference_length)


def double_hyperbolic(reference_length, horizon):
    """|δ/(2|ξ| − δ)|: infinite, and refused, for a bond of half the horizon."""
    return np.abs(horizon / (2.0 * reference_length - horizon))


def exponential(reference_length, horizon):
    """exp(δ/(|ξ| − δ/4)): infinite, and refused, right above a quarter of the horizon."""
    return np.exp(horizon / (reference_length - 0.25 * horizon))


def cubic_spline(reference_length, horizon):
    """1 − 6q² + 6q³ up to q = |ξ|/δ = ½, then 2(1 − q)³ (Monaghan & Lattanzio 1985, scaled to 1 at the centre)."""
    q = reference_length / horizon
    return 2.0 * np.maximum(1.0 - q, 0.0) ** 3 - 8.0 * np.maximum(0.5 - q, 0.0) ** 3


FUNCTIONS: dict[str, Influence] = {
    each.__name__: each
    for each in (
        constant, gaussian, linear, conical, inverse, inverse_fourth, hyperbolic, double_hyperbolic, exponential,
        cubic_spline,
    )
}  # fmt: skip


def influences(
    influence: Influence | str, lengths: NDArray[np.float64], horizon: float, spacing: float | None, label: str
) -> NDArray[np.float64]:
    """The influence function of bonds.

    Args:
        influence: plain function, or the name of one of this module.
        lengths: reference lengths (k,), m.
        horizon: δ, m.
        spacing: of the grid, m, if there is one.
        label: who asks, for messages.

    Returns:
        (k,), dimensionless.

    Raises:
        BadLaw: on an unknown name, or unknown argument names.
        BadInput: if it is negative, infinite or no number for some bond, or the spacing is missing.
    """
    function = influence_function(influence, label)
    given: dict[str, float | None] = {"horizon": horizon, "spacing": spacing}
    rest = {name: given[name] for name in list(inspect.signature(function).parameters)[1:]}
    if rest.get("spacing", 0.0) is None:
        raise BadInput(f"{label}: '{function.__name__}' needs the spacing of the grid: part.place(..., spacing=...)")
    different, place = np.unique(lengths, return_inverse=True)
    with np.errstate(all="ignore"):
        try:
            values = np.broadcast_to(np.asarray(function(different, **rest), np.float64), different.shape)
        except (ValueError, TypeError):  # a function with branches takes one number at a time
            values = np.array([float(function(length, **rest)) for length in different.tolist()])
    # bonds may reach beyond the horizon, to cells that lie partly within; what falls to zero there stays zero
    values = np.where(different > horizon, np.maximum(values, 0.0), values)
    bad = np.flatnonzero(~(np.isfinite(values) & (values >= 0)))
    if len(bad):
        raise BadInput(
            f"{label}: the influence '{function.__name__}' of a bond of length {different[bad[0]]:g} is "
            f"{values[bad[0]]}: it must be finite and not negative; take another function or horizon"
        )
    return np.asarray(values[place].reshape(lengths.shape))


def set_influence(host: Host, influence: Influence | str, label: str) -> dict[str, float]:
    """Sets the influence of the bonds of a part or connection.

    Returns:
        What to give laws that ask for `influence`: {"influence": 1.0} if it is constant; no field is set then.

    Raises:
        BadLaw, BadInput: as `influences`; also if the bonds have another influence already.
    """
    if influence_function(influence, label) is constant:
        return {"influence": 1.0}
    before = host.raw(influence_field).copy() if influence_field in host else None
    horizon, spacing = host.bonds.horizon, host.spacing

    def of_bonds(bonds: NDArray[np.float64]) -> NDArray[np.float64]:
        return influences(influence, np.sqrt((bonds * bonds).sum(axis=1)), horizon, spacing, label)

    host.bonds.tabulate(influence_field, of_bonds)
    if before is not None and not np.allclose(host.raw(influence_field), before, rtol=1e-12):
        host.raw(influence_field)[...] = before
        raise BadInput(f"{label}: '{host.name}' already has another influence function: use one for all its relations")
    return {}


def influence_at(
    influence: Influence | str, horizon: float, spacing: float | None, label: str
) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """The influence as a function of reference lengths alone."""
    return lambda lengths: influences(influence, np.asarray(lengths, np.float64), horizon, spacing, label)


def influence_function(influence: Influence | str, label: str) -> Influence:
    """The function itself, after looking at its argument names.

    Raises:
        BadLaw: on an unknown name, or unknown argument names.
    """
    function = FUNCTIONS.get(influence) if isinstance(influence, str) else influence
    if function is None or not callable(function):
        raise BadLaw(f"{label}: influence={influence!r} must be a function, or one of {', '.join(FUNCTIONS)}")
    names = tuple(inspect.signature(function).parameters)
    if names[:1] != _KNOWN[:1] or not set(names) <= set(_KNOWN):
        raise BadLaw(
            f"{label}: the influence '{function.__name__}' takes {', '.join(names) or 'nothing'}: it must take "
            "reference_length, and may take horizon and spacing behind it"
        )
    return function
