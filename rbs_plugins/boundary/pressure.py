"""Pressure: a load on a surface that follows the body as it turns and stretches."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from rbs_core import BadInput, Boundary, Part, Trigger, always
from rbs_core.trigger import Clock
from rbs_plugins.boundary.values import Values
from rbs_plugins.constitutive.bonded import require_bonds
from rbs_plugins.fields import displacement, external_work, force_density, volume
from rbs_plugins.measures.family import inverses
from rbs_plugins.tangents.base import Tangent

Normal = ArrayLike | Callable[[NDArray[np.float64]], ArrayLike] | None


class Pressure(Boundary):
    """Pressure on the nodes of a surface: f = −p A J F⁻ᵀN on each, with F of its family (Nanson's formula).

    Args:
        part: connected part.
        region: nodes of the layer that carries the load: geometry, mask (n,), indices, function, or a node set.
        pressure: Pa, positive towards the body; a number, an array (k,), or a function of (time) or (time, positions).
        normal: outward normal N in the reference configuration: a vector (d,), or a function that gives (k, d) for
            positions (k, d); towards the nearest point of the surface of the part's geometry if not given.
        area: of the whole surface, m², shared out by volume; the volume of each node over the spacing if not given.
        when: trigger.

    Raises:
        BadInput: on a region without nodes, a normal without direction, an area that is not positive, or a node whose
            family gives no deformation gradient.

    The force turns with the family of the node and grows with its surface, so it has a tangent, which is in general not
    symmetric. A dead load, which keeps direction and size, is BoundaryDomain(force=...). The family is that of the
    start: bonds that fail later still tell F. Its work on the part is offered as `external_work`.
    """

    @staticmethod
    def example(part: Part) -> dict[str, Any]:
        """On the end of the body."""
        x = part.positions[:, 0]
        return {"region": x >= np.quantile(x, 0.8), "pressure": 1e3, "normal": np.eye(part.dimension)[0]}

    reads = (displacement, volume)
    adds = (force_density,)
    offers = (external_work,)

    def __init__(
        self,
        part: Part,
        region: Any,
        pressure: Any,
        *,
        normal: Normal = None,
        area: float | None = None,
        when: Trigger = always,
    ) -> None:
        super().__init__(part, when=when)
        require_bonds(type(self).__name__, part)
        self.nodes = part.where(region)
        if not len(self.nodes):
            raise BadInput(f"{self.label}: no node lies in {region!r}: check the region or the spacing")
        if area is not None and not (np.isfinite(area) and area > 0):
            raise BadInput(f"{self.label}: area={area} must be positive and finite")
        if area is None and part.spacing is None:
            raise BadInput(f"{self.label}: part '{part.name}' has no spacing that gives the area of a node: give area=")
        places = part.positions[self.nodes]
        given = [pressure] if part.dimension == 1 else [pressure, *[None] * (part.dimension - 1)]
        self._values = Values(f"{self.label}, pressure", given, places, steady=True)
        self._area, self._normals = area, self._outward(normal, places)
        self._find_families()
        self.hold = False
        self.reset()

    def _outward(self, normal: Normal, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """Unit normals (k, d)."""
        if normal is None:
            arrows = self.part.geometry.projection(places) - places
        else:
            arrows = np.asarray(normal(places) if callable(normal) else normal, np.float64)
        try:
            arrows = np.broadcast_to(arrows, places.shape)
        except ValueError:
            raise BadInput(f"{self.label}: normals have shape {arrows.shape}, not {places.shape}") from None
        sizes = np.linalg.norm(arrows, axis=1)
        bad = np.flatnonzero(~(np.isfinite(sizes) & (sizes > 0)))
        if len(bad):
            raise BadInput(
                f"{self.label}: the normal of the node at {places[bad[0]].tolist()} has no direction: give normal="
            )
        return arrows / sizes[:, None]

    def _find_families(self) -> None:
        """Weights g of every family of the region: F = I + Σ (u_j − u_i)⊗g_j, g_j = V_j K⁻¹ξ_j."""
        offsets, neighbors = self.part.bonds.as_rows()
        counts = np.diff(offsets)[self.nodes]
        bonds = np.concatenate([np.arange(offsets[i], offsets[i + 1]) for i in self.nodes])
        self._row = np.repeat(np.arange(len(self.nodes)), counts)
        self._other = neighbors[bonds].astype(np.int64)
        self._starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
        xi = self.part.positions[self._other] - self.part.positions[self.nodes][self._row]
        weighted = xi * self.part[volume][self._other][:, None]
        shape = self._summed(xi[:, :, None] * weighted[:, None, :])
        inverse, regular = inverses(shape)
        if not regular.all():
            place = self.part.positions[self.nodes[~regular][0]].tolist()
            raise BadInput(
                f"{self.label}: the family of the node at {place} lies in a plane or line: it has no deformation "
                "gradient: take more neighbors, or a dead load"
            )
        self._g = np.einsum("qkm,qm->qk", inverse[self._row], weighted)

    def _summed(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.add.reduceat(values, self._starts, axis=0)

    # -- work -------------------------------------------------------------------------------------------------------

    def reset(self) -> None:
        self._before: dict[str, NDArray[np.float64]] = {}

    def state(self) -> dict[str, Any]:
        return dict(self._before)

    def restore(self, state: dict[str, Any]) -> None:
        self._before = {name: np.array(value) for name, value in state.items()}

    def attach(self) -> None:
        self._size = self[volume][self.nodes]
        total = self._size.sum()
        self._areas = self._size / self.part.spacing if self._area is None else self._area * self._size / total
        self._works = self.wants(external_work)
        if self._works and self.when != always:
            raise BadInput(
                f"{self.label}: its work can only be followed if it acts in every step, not when={self.when}"
            )

    def begin(self, clock: Clock) -> None:
        if self._works and not self._before:
            self._before = {"path": self[displacement][self.nodes], "value": self.forces(clock.time)}

    def gradients(self) -> NDArray[np.float64]:
        """F (k, d, d) of the nodes now."""
        u = self[displacement].astype(np.float64)
        moved = u[self._other] - u[self.nodes][self._row]
        return np.eye(self.part.dimension) + self._summed(moved[:, :, None] * self._g[:, None, :])

    def forces(self, time: float) -> NDArray[np.float64]:
        """(k, d) force on the nodes at a time, N."""
        F = self.gradients()
        turned = np.einsum("kba,kb->ka", np.linalg.inv(F), self._normals)
        return -(self.sizes(time) * np.linalg.det(F))[:, None] * turned

    def sizes(self, time: float) -> NDArray[np.float64]:
        """(k,) p A at a time, N."""
        ((_, pressure),) = self._values.at(time)
        return pressure * self._areas

    def apply(self, clock: Clock) -> None:
        force = self.forces(clock.time)
        self[force_density][self.nodes] += force / self._size[:, None]
        if self._works and not self.hold:
            path = self[displacement][self.nodes]
            mean = 0.5 * (self._before["value"] + force)
            self[external_work][...] += np.sum(mean * (path - self._before["path"]))
            self._before = {"path": path, "value": force}
        self._now = clock.time

    def node_items(self) -> int:
        return len(self.nodes)

    def tangent(self) -> PressureTangent:
        """The derivative of the load, for static solvers."""
        return PressureTangent(self)


class PressureTangent(Tangent):
    """−∂f/∂u of a pressure: p A J (F⁻ᵀ_aB F⁻ᵀ_cD − F⁻ᵀ_aD F⁻ᵀ_cB) N_B g_D for a row (node, a) and a column (end, c)."""

    symmetric = False

    def __init__(self, of: Pressure) -> None:
        self._of, self.ends = of, (of.part,)
        self._matrix = csr_array((self.size, self.size))

    def update(self) -> None:
        of, d = self._of, self._of.part.dimension
        F = of.gradients()
        cofactor = np.linalg.inv(F).transpose(0, 2, 1)
        size = of.sizes(of._now) * np.linalg.det(F)
        turned = np.einsum("kaB,kB->ka", cofactor, of._normals)
        # D_(a)(c)(D) of each node, then times g of each end
        change = turned[:, :, None, None] * cofactor[:, None, :, :]
        change = change - cofactor[:, :, None, :] * turned[:, None, :, None]
        blocks = np.einsum("qacD,qD->qac", (size[:, None, None, None] * change)[of._row], of._g)
        own = -of._summed(blocks)
        rows = np.concatenate([of.nodes[of._row], of.nodes])
        columns = np.concatenate([of._other, of.nodes])
        values = np.concatenate([blocks, own])
        a, c = (index.ravel() for index in np.indices((d, d)))
        place = ((rows[:, None] * d + a).ravel(), (columns[:, None] * d + c).ravel())
        self._matrix = csr_array((values.reshape(len(rows), -1).ravel(), place), shape=(self.size, self.size))
        self._matrix.sum_duplicates()

    def matrix(self) -> csr_array:
        return self._matrix

    def multiply(self, v: NDArray[np.float64], out: NDArray[np.float64]) -> None:
        out += self._matrix @ v

    def diagonal(self, out: NDArray[np.float64]) -> None:
        out += self._matrix.diagonal()
