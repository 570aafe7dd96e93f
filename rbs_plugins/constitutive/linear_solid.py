"""The linear peridynamic solid as plain functions of bond quantities, and its constants."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core import BadInput
from rbs_core.part import Host


def linear_solid(
    extension, reference_length, influence, dilatation_i, dilatation_j,
    inverse_weighted_volume_i, inverse_weighted_volume_j, dilatational_modulus_i, dilatational_modulus_j,
    deviatoric_modulus_i, deviatoric_modulus_j,
):  # fmt: skip
    """Pull of both ends of a bond, t_i + t_j, with t = ω (κ ϑ |ξ| + α m e) / m."""
    own, other = inverse_weighted_volume_i, inverse_weighted_volume_j
    grown = own * dilatational_modulus_i * dilatation_i + other * dilatational_modulus_j * dilatation_j
    stiff = own * deviatoric_modulus_i + other * deviatoric_modulus_j
    return influence * (grown * reference_length + stiff * extension)


def of_one_material(
    extension, reference_length, influence, dilatation_i, dilatation_j,
    inverse_weighted_volume_i, inverse_weighted_volume_j, dilatational_modulus_i, dilatational_modulus_j,
    deviatoric_modulus_i, deviatoric_modulus_j,
):  # fmt: skip
    """The same where both ends have the same constants, with fewer products."""
    own, other = inverse_weighted_volume_i, inverse_weighted_volume_j
    grown = dilatational_modulus_i * (own * dilatation_i + other * dilatation_j)
    return influence * (grown * reference_length + deviatoric_modulus_i * (own + other) * extension)


def own_pull(
    extension, reference_length, influence, dilatation_i, inverse_weighted_volume_i, dilatational_modulus_i,
    deviatoric_modulus_i,
):  # fmt: skip
    """The scalar force state t of the node, ω (κ ϑ |ξ| + α m e) / m."""
    grown = dilatational_modulus_i * dilatation_i * reference_length
    return influence * inverse_weighted_volume_i * (grown + deviatoric_modulus_i * extension)


def held(
    extension, reference_length, influence, dilatation_i, dilatation_j,
    inverse_weighted_volume_i, inverse_weighted_volume_j, dilatational_modulus_i, dilatational_modulus_j,
    deviatoric_modulus_i, deviatoric_modulus_j,
):  # fmt: skip
    """What the bond holds: half of its pull times its extension, since the solid is linear in all extensions."""
    pull = linear_solid(
        extension, reference_length, influence, dilatation_i, dilatation_j,
        inverse_weighted_volume_i, inverse_weighted_volume_j, dilatational_modulus_i, dilatational_modulus_j,
        deviatoric_modulus_i, deviatoric_modulus_j,
    )  # fmt: skip
    return 0.5 * pull * extension


def beyond_in_tension(
    extension, reference_length, influence, dilatation_i, dilatation_j,
    inverse_weighted_volume_i, inverse_weighted_volume_j, dilatational_modulus_i, dilatational_modulus_j,
    deviatoric_modulus_i, deviatoric_modulus_j, w0,
):  # fmt: skip
    """True for a lengthened bond that holds more than w0."""
    energy = held(
        extension, reference_length, influence, dilatation_i, dilatation_j,
        inverse_weighted_volume_i, inverse_weighted_volume_j, dilatational_modulus_i, dilatational_modulus_j,
        deviatoric_modulus_i, deviatoric_modulus_j,
    )  # fmt: skip
    return (energy > w0) & (extension > 0.0)


def beyond(
    extension, reference_length, influence, dilatation_i, dilatation_j,
    inverse_weighted_volume_i, inverse_weighted_volume_j, dilatational_modulus_i, dilatational_modulus_j,
    deviatoric_modulus_i, deviatoric_modulus_j, w0,
):  # fmt: skip
    """True for a bond that holds more than w0."""
    energy = held(
        extension, reference_length, influence, dilatation_i, dilatation_j,
        inverse_weighted_volume_i, inverse_weighted_volume_j, dilatational_modulus_i, dilatational_modulus_j,
        deviatoric_modulus_i, deviatoric_modulus_j,
    )  # fmt: skip
    return energy > w0


def freed(
    extension, reference_length, influence, dilatation_i, dilatation_j,
    inverse_weighted_volume_i, inverse_weighted_volume_j, dilatational_modulus_i, dilatational_modulus_j,
    deviatoric_modulus_i, deviatoric_modulus_j,
):  # fmt: skip
    """What the solid loses with the bond, but for the square of the bond's own share of the dilatations."""
    own, other = inverse_weighted_volume_i, inverse_weighted_volume_j
    grown = own * dilatational_modulus_i * dilatation_i + other * dilatational_modulus_j * dilatation_j
    stiff = own * deviatoric_modulus_i + other * deviatoric_modulus_j
    return influence * (grown * reference_length + 0.5 * stiff * extension) * extension


def stiffest(
    influence, inverse_weighted_volume_i, inverse_weighted_volume_j, deviatoric_modulus_i, deviatoric_modulus_j
):  # fmt: skip
    """Force per extension of bonds that together are at least as stiff as the solid."""
    return influence * (
        inverse_weighted_volume_i * deviatoric_modulus_i + inverse_weighted_volume_j * deviatoric_modulus_j
    )


def moduli(case: str, E: Any, nu: Any) -> tuple[Any, Any]:
    """Constants of the solid: γ and α m, Pa, with t = γ/m² S ω |ξ| + α ω e and S = Σ ω |ξ| e V = ϑ m/d.

    Args:
        case: "1-D", "stress", "strain" or "3-D".
        E: Young's modulus, Pa.
        nu: Poisson's ratio.

    3-D: γ = 9K − 15μ, α m = 15μ (Silling et al. 2007). 2-D: α m = 8μ and γ = 2(3ν − 1)E/(1 − ν²) in plane stress,
    2(4ν − 1)E/((1 − 2ν)(1 + ν)) in plane strain: the models of Le, Chan & Schwartz (2014) in the form of the first.
    1-D: a bar with γ = 0 and α m = E.
    """
    shear = E / (2 * (1 + nu))
    if case == "1-D":
        return 0.0 * E, E + 0.0 * nu
    if case == "3-D":
        return 3 * E / (1 - 2 * nu) - 15 * shear, 15 * shear
    if case == "stress":
        return 2 * (3 * nu - 1) * E / (1 - nu**2), 8 * shear
    return 2 * (4 * nu - 1) * E / ((1 - 2 * nu) * (1 + nu)), 8 * shear


def constants(name: str, case: str, part: Host, E: ArrayLike | None, nu: ArrayLike | None) -> tuple[Any, Any]:
    """Young's modulus and Poisson's ratio of the nodes, after checking them: numbers, or arrays (n,).

    Raises:
        BadInput: if a node has constants that no stable solid has.
    """
    if E is None or (nu is None and case != "1-D"):
        raise BadInput(f"{name} '{part.name}': give {'E' if case == '1-D' else 'E and nu'}")
    if case == "1-D" and nu is not None:
        raise BadInput(f"{name} '{part.name}': a 1-D part has no Poisson's ratio: leave nu out")
    found = [_of_nodes(name, part, what, value) for what, value in (("E", E), ("nu", 0.0 if nu is None else nu))]
    young, ratio = found
    _require(name, part, "E", young, np.isfinite(young) & (young > 0), "positive and finite, in Pa")
    _require(name, part, "nu", ratio, (ratio > -1.0) & (ratio < 0.5), "between -1 and 0.5 (exclusive)")
    return young, ratio


def _of_nodes(name: str, part: Host, what: str, value: ArrayLike) -> Any:
    try:
        found = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        found = np.empty((0, 0))
    if found.shape not in ((), (len(part),)):
        raise BadInput(f"{name} '{part.name}': {what} must be a number, or one for each of {len(part)} nodes")
    return found


def _require(name: str, part: Host, what: str, values: NDArray[Any], good: NDArray[np.bool_], wanted: str) -> None:
    if np.all(good):
        return
    if values.ndim == 0:
        raise BadInput(f"{name} '{part.name}': {what}={values} must be {wanted}")
    node = int(np.flatnonzero(~good)[0])
    where = part.positions[node].tolist()
    raise BadInput(f"{name} '{part.name}': {what}={values[node]} of node {node} at {where} must be {wanted}")
