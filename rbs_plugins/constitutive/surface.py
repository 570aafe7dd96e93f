"""Surface correction: bonds near a surface are made stiffer, since the nodes there have no whole families."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput
from rbs_core.part import Connection, Host, Lattice, Rows
from rbs_plugins.constitutive.corrections import share_of
from rbs_plugins.fields import volume
from rbs_plugins.loops.arguments import Argument
from rbs_plugins.loops.recipe import Recipe
from rbs_plugins.loops.surface import DIRECTIONS, VOLUMES

Array = NDArray[np.float64]

# How factors of the two ends make that of a bond, by the method.
METHODS = {"none": "", "volume": VOLUMES, "force density": DIRECTIONS, "energy": DIRECTIONS}
SAMPLES = 512  # lengths at which the stiffness of a law is looked at


class SurfaceCorrection:
    """Factors λ of bonds, from sums over the families of their ends compared with the integral over a whole family.

    Args:
        method: "none"; "volume", λ = 2 V0 / (V_i + V_j) with the volumes V of the families, own cells included, and V0
            of the ball of radius δ; "force density" or "energy", with ratios h of a whole family to that of a node
            for a small uniaxial stretch along each axis, their means k = (h_i + h_j) / 2 over the two ends, and
            λ = [Σ (n / k)²]^(-1/2) with the direction n of the undeformed bond. What is compared is the force density
            of the bonds on the one side minus that of those on the other, or the strain energy density.
        host: part whose bonds are corrected.
        partial_volume: name of the rule by which neighbors count.
        law: of the bonds, and its resolved arguments.

    Raises:
        BadInput: on an unknown method, for a connection, or if the stiffness of the law at rest cannot be known.

    Sources: volume method Bobaru et al. (2016), chapter 2; the others Madenci & Oterkus (2014), chapter 4; all in Le &
    Bobaru (2018). The mean over the ends is taken with a plus (printed elsewhere with a minus, by which bonds in the
    bulk would vanish). As in these, what a node is compared with is the integral of the continuum; so λ also takes away
    the error of the sum in the bulk. All bonds that were ever there count, broken ones too: cracks stay soft.
    """

    def __init__(
        self,
        method: str,
        host: Host,
        partial_volume: str,
        law: Callable[..., Any],
        law_arguments: tuple[Argument, ...],
    ) -> None:
        if method not in METHODS:
            raise BadInput(f"surface_correction={method!r} must be one of {', '.join(METHODS)}")
        self.method, self.kind = method, METHODS[method]
        self._host, self._partial_volume = host, partial_volume
        if method != "none" and isinstance(host, Connection):
            raise BadInput(
                f"surface_correction={method!r} belongs to the families of one part: the bonds of '{host.name}' are "
                "none, leave it out"
            )
        if self.kind == DIRECTIONS:
            self._lengths = np.linspace(host.bonds.reach / SAMPLES, host.bonds.reach, SAMPLES)
            found = Recipe(host.dimension, law, law_arguments).slopes(self._lengths)
            if found is None or not (np.isfinite(found).all() and self._whole(found) > 0):
                raise BadInput(
                    f"surface_correction={method!r} compares stiffnesses at rest, and that of the law '{law.__name__}' "
                    "is zero, or depends on more than the deformation of its bond: take 'volume'"
                )
            self._slopes = found

    @cached_property
    def factors(self) -> Array:
        """What the ends of a bond contribute: (n, 1) V / V0 of the volume method, (n, d) ratios h along the axes.

        (n, 0) without a correction. Found once: when volumes and bonds change later, they stay.
        """
        if self.method == "none":
            return np.empty((len(self._host), 0))
        if self.method == "volume":
            own = self._host[volume].astype(np.float64)[:, None]
            families = family_sums(self._host, lambda bonds: self._share(bonds)[:, None])
            return (families + own) / self._ball()
        found = family_sums(self._host, self._stiffness)
        # where no bond has a component along an axis, the factor along it is never asked for
        return np.divide(self._whole(self._slopes), found, out=np.ones_like(found), where=found > 0)

    @property
    def nbytes(self) -> int:
        """Bytes of the factors."""
        return 0 if self.method == "none" else self.factors.nbytes

    def _share(self, bonds: Array) -> Array:
        return share_of(self._host, self._partial_volume, bonds)

    def _ball(self) -> float:
        """Volume V0 of a whole family, m^3."""
        unit = {1: 2.0, 2: math.pi, 3: 4.0 / 3.0 * math.pi}[self._host.dimension]
        return unit * self._host.bonds.horizon**self._host.dimension * _across(self._host)

    def _stiffness(self, bonds: Array) -> Array:
        """(k, d) what bonds ξ (k, d) add to the sums for a unit stretch along each axis, per volume."""
        lengths = np.sqrt((bonds * bonds).sum(axis=1))
        along = np.abs(bonds) / lengths[:, None]
        each = np.interp(lengths, self._lengths, self._slopes) * self._share(bonds)
        if self.method == "force density":
            return np.asarray(each[:, None] * along**3)
        return np.asarray((each * lengths)[:, None] * along**4)

    def _whole(self, slopes: Array) -> float:
        """The same of a whole family: the integral over all lengths, times that over all directions."""
        power = 3 if self.method == "force density" else 4
        angles = {
            (1, 3): 2.0, (2, 3): 8.0 / 3.0, (3, 3): math.pi,
            (1, 4): 2.0, (2, 4): 0.75 * math.pi, (3, 4): 0.8 * math.pi,
        }[self._host.dimension, power]  # fmt: skip
        nodes, weights = np.polynomial.legendre.leggauss(SAMPLES // 4)
        lengths = 0.5 * self._host.bonds.horizon * (nodes + 1.0)
        radial = np.interp(lengths, self._lengths, slopes) * lengths ** (self._host.dimension - 4 + power)
        return float(0.5 * self._host.bonds.horizon * (weights @ radial) * angles * _across(self._host))


def _across(host: Host) -> float:
    return host.thickness or host.area or 1.0


def family_sums(part: Host, function: Callable[[Array], Array]) -> Array:
    """Sums over families Σ_j g(ξ) V_j, of all bonds that were ever there.

    Args:
        part: whose bonds.
        function: g of the reference bonds ξ (k, d) -> (k, q), alike for ξ and −ξ.

    Returns:
        (n, q).
    """
    stored = part.bonds.stored
    volumes = part[volume].astype(np.float64)
    if isinstance(stored, Lattice):
        at_cells = np.zeros(stored.size)
        at_cells[stored.cells] = volumes
        weights = function(stored.spacing * stored.vectors.astype(np.float64))
        total = np.zeros((len(volumes), weights.shape[1]))
        ways = zip([*weights[::-1], *weights], stored.directed(stored.present), strict=True)
        for weight, (distance, there) in ways:
            total += np.where(there, at_cells[stored.cells + distance], 0.0)[:, None] * weight
        return total
    assert isinstance(stored, Rows)
    sums: Any = 0.0
    for _, nodes, others, bonds in stored.runs():
        columns = (function(bonds) * volumes[others][:, None]).T
        sums = sums + np.stack([np.bincount(nodes, column, len(volumes)) for column in columns], axis=1)
    return np.asarray(sums)
