"""Failure of bonds by the strain or stress of their ends, for Correspondence: plain functions that are true at failure.

A bond has the mean of what its two ends have: of Green's strains, E = ½ (E_i + E_j), or of Cauchy's stresses (reviewed
by Hashim 2021, section 2.4). As F is that of a whole family, all bonds of a place fail together, whatever their
direction. A user's own function may ask for the same: F_i, F_j, P_i, P_j (3 x 3 tuples, see `rbs_plugins.tensors`),
beside stretch, length and so on.
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt
from typing import Any, ClassVar

import numpy as np

from rbs_core import BadInput, Geometry
from rbs_plugins.constitutive.fracture import Criterion
from rbs_plugins.tensors import (
    added,
    cauchy_stress,
    determinant,
    deviator,
    green_strain,
    identity,
    inner,
    principal,
    scaled,
)


def mean_strain(F_i, F_j):
    """½ (E_i + E_j)."""
    return scaled(added(green_strain(F_i), green_strain(F_j)), 0.5)


def beyond_equivalent_strain(F_i, F_j, critical_strain):
    """sqrt(2/3 e:e) of the mean strain, e its deviator."""
    e = deviator(mean_strain(F_i, F_j))
    return sqrt(0.6666666666666666 * inner(e, e)) > critical_strain


def beyond_volumetric_strain(F_i, F_j, critical_strain):
    """(1 + E1)(1 + E2)(1 + E3) − 1 of the principal values of the mean strain."""
    return determinant(added(identity(), mean_strain(F_i, F_j))) - 1.0 > critical_strain


def beyond_shear_strain(F_i, F_j, critical_strain):
    """E1 − E3 of the principal values of the mean strain: the largest engineering shear strain."""
    values, _ = principal(mean_strain(F_i, F_j))
    return max(values[0], values[1], values[2]) - min(values[0], values[1], values[2]) > critical_strain


def beyond_principal_stress(F_i, F_j, P_i, P_j, critical_stress):
    """Largest principal value of the mean Cauchy stress."""
    values, _ = principal(scaled(added(cauchy_stress(P_i, F_i), cauchy_stress(P_j, F_j)), 0.5))
    return max(values[0], values[1], values[2]) > critical_stress


class _Limit(Criterion):
    """A criterion with one positive limit."""

    fails: ClassVar[Callable[..., Any]]
    limit: ClassVar[str]

    def __init__(self, limit: float, *, within: Geometry | None = None, release: str = "at once") -> None:
        if not (np.isfinite(limit) and limit > 0):
            raise BadInput(f"{type(self).__name__}({limit!r}): the limit must be positive and finite")
        super().__init__(type(self).fails, within=within, release=release, **{self.limit: limit})

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._parameters[self.limit]!r}{self._options})"


class CriticalEquivalentStrain(_Limit):
    """A bond fails once sqrt(2/3 e:e) of the mean Green strain of its ends exceeds a limit (Hashim 2021, eq. 2.27).

    Args:
        limit: critical strain.
        within: only bonds with both ends in this geometry may break.
        release: "at once" or "next step", see Criterion.

    Raises:
        BadInput: if the limit is not positive.

    e is the deviator with all its three shear components; the thesis prints two of them as a sum in one square.
    """

    fails = staticmethod(beyond_equivalent_strain)
    limit = "critical_strain"


class CriticalVolumetricStrain(_Limit):
    """A bond fails once (1 + E1)(1 + E2)(1 + E3) − 1 of the mean Green strain exceeds a limit (Hashim 2021, eq. 2.29).

    Args:
        limit: critical strain.
        within: only bonds with both ends in this geometry may break.
        release: "at once" or "next step", see Criterion.

    Raises:
        BadInput: if the limit is not positive.
    """

    fails = staticmethod(beyond_volumetric_strain)
    limit = "critical_strain"


class CriticalShearStrain(_Limit):
    """A bond fails once the largest shear strain E1 − E3 of the mean Green strain exceeds a limit.

    Args:
        limit: critical engineering shear strain.
        within: only bonds with both ends in this geometry may break.
        release: "at once" or "next step", see Criterion.

    Raises:
        BadInput: if the limit is not positive.
    """

    fails = staticmethod(beyond_shear_strain)
    limit = "critical_strain"


class MaximumPrincipalStress(_Limit):
    """A bond fails once the largest principal value of the mean Cauchy stress exceeds a limit (Hashim 2021, eq. 2.34).

    Args:
        limit: tensile strength, Pa.
        within: only bonds with both ends in this geometry may break.
        release: "at once" or "next step", see Criterion.

    Raises:
        BadInput: if the limit is not positive.
    """

    fails = staticmethod(beyond_principal_stress)
    limit = "critical_stress"
