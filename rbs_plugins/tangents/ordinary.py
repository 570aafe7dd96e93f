"""The tangent of the ordinary state-based solid: springs, and a chain through the dilatations of its nodes.

The energy of a node is ½ V κ ϑ²/d beside that of its springs, with κ = γ/d and the dilatation ϑ of its family. So the
second derivative is Σ_p C_pᵀ (V γ/d²)_p C_p, C the derivative of the dilatations; what the bonds pull with now, the
share of the dilatation in it, turns with them and is in their springs.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import csr_array

from rbs_core import BadInput, Part
from rbs_core.part import Connection, Host
from rbs_plugins.fields import volume
from rbs_plugins.loops.loop import Loop, Text
from rbs_plugins.loops.rows import row_ranges
from rbs_plugins.tangents.base import Array
from rbs_plugins.tangents.chain import Chain
from rbs_plugins.tangents.matrix import BlockMatrix
from rbs_plugins.tangents.pairwise import NodesOfConnection, SpringTangent
from rbs_plugins.tangents.pattern import Pattern

if TYPE_CHECKING:
    from rbs_plugins.constitutive.dilatation import Dilatation
    from rbs_plugins.constitutive.ordinary import OrdinaryStateBased


class OrdinaryTangent(SpringTangent):
    """The stiffness of a solid on a part, whose nodes may also have bonds of connections.

    What comes from the dilatations of the nodes of the part is all here, also what goes through connections; the
    tangents of solids on these have their springs only. So each is symmetric, and their sum is the derivative of the
    forces. Where there are connections, the ends are the part and the other parts of these.

    Args:
        force: attached; the field `dilatation` must be that of the present displacement at every update.

    Raises:
        BadInput: on a connection whose bonds only one part feels.
    """

    _force: OrdinaryStateBased

    def _build(self) -> None:
        self._links = self._force.dilatation.links_among(self._force._scene)
        for link in self._links:
            require_both(link.host, self._force.label)
        super()._build()
        force, part = self._force, self._force.part
        self.ends = tuple(dict.fromkeys([part, *(end for link in self._links for end in link.ends)]))
        self._versions = [link.host.version for link in self._links]
        own = Pattern.of_families(*self._bonds)
        self._joints = [_Joint(link.host, part, self.ends) for link in self._links]
        pattern = _joined(own, self._joints, sum(len(end) for end in self.ends)) if self._joints else own
        self._chain = Chain(pattern, part.dimension, 1)
        self._chain.weights[:, 0, 0] = force[part, volume] * (force.gamma / part.dimension**2)
        self._growths = [_Growth(each) for each in (force.dilatation, *self._links)]
        for joint in self._joints:
            joint.seek(pattern)
        arguments = {"offsets": self._bonds[0], "neighbors": self._bonds[1], "gradient": self._growths[0].gradient,
                     "starts": pattern.starts, "columns": pattern.columns, "blocks": self._chain.blocks}  # fmt: skip
        self._place_own = Loop(Text.of(place), "place", arguments, row_ranges(len(part)), len(self._bonds[1]))

    def update(self) -> None:
        if [link.host.version for link in self._links] != self._versions:
            self._build()
        super().update()
        time = self._force.now
        self._chain.blocks.fill(0.0)
        for growth in self._growths:
            growth.refresh(*time)
        self._place_own()
        for joint, growth in zip(self._joints, self._growths[1:], strict=True):
            joint.place(growth, self._chain)
        self._chain.changed()

    def matrix(self) -> csr_array[Any]:
        if self._blocks is None:
            self._blocks = BlockMatrix(self._chain.pattern.normal, self._force.host.dimension)
        if self._joints:
            self._blocks.clear()
        self._springs.add_to(self._blocks, afresh=not self._joints)
        self._chain.add_to(self._blocks)
        return self._blocks.matrix

    def multiply(self, v: Array, out: Array) -> None:
        self._springs.multiply(v, out)
        self._chain.multiply(v, out)

    def diagonal(self, out: Array) -> None:
        self._springs.diagonal(out)
        self._chain.diagonal(out)

    @property
    def nbytes(self) -> int:
        """Bytes of springs, chain and matrix."""
        return super().nbytes + self._chain.nbytes + sum(each.gradient.nbytes for each in self._growths)


class _Growth:
    """What the bonds of a host add to dilatations, differentiated.

    Attributes:
        gradient: (m, d) by the place of the neighbor of each bond, 1/m; minus that by the place of the node itself.
        loops: that find it.
    """

    def __init__(self, dilatation: Dilatation) -> None:
        host = dilatation.host
        self.loops: Any = dilatation.loops({"out": [np.zeros(len(end)) for end in dilatation.ends]})
        self.gradient = np.zeros((len(host.bonds), host.dimension))

    def refresh(self, time: float, dt: float) -> None:
        """For the present displacement."""
        self.loops.gradients(self.gradient, time, dt)


class _Joint:
    """The bonds of a connection that add to the dilatations of a part.

    Args:
        connection: whose bonds.
        part: the first of the ends.
        ends: parts whose nodes have columns, one after the other.

    Attributes:
        rows, columns: (b,) node of the part, and number of the neighbor among all nodes, of each such bond.
    """

    def __init__(self, connection: Any, part: Part, ends: Sequence[Part]) -> None:
        nodes = NodesOfConnection(connection)
        before = np.cumsum([0, *(len(end) for end in ends)])
        at = np.concatenate([before[ends.index(end)] + n
                             for end, n in zip(connection.ends, connection.nodes, strict=True)])  # fmt: skip
        offsets, neighbors = connection.bonds.as_rows()
        starts = np.repeat(np.arange(len(at)), np.diff(offsets))
        self._own = connection.ends.index(part)
        self._bonds = np.flatnonzero(nodes.owners[starts] == self._own)
        self.rows, self.columns = at[starts[self._bonds]], at[neighbors[self._bonds]]
        self._others = nodes.owners[neighbors[self._bonds]]

    def seek(self, pattern: Pattern) -> None:
        """Finds the entries of the bonds."""
        self._there, self._here = pattern.find(self.rows, self.columns), pattern.find(self.rows, self.rows)

    def place(self, growth: _Growth, chain: Chain) -> None:
        """Adds the gradients to the blocks of a chain, each in the coordinates of the part of its node."""
        turns, found = growth.loops.turns, growth.gradient[self._bonds]
        np.add.at(chain.blocks[:, 0], self._there, np.einsum("qa,qab->qb", found, turns[self._others]))
        np.add.at(chain.blocks[:, 0], self._here, -found @ turns[self._own])


def place(begin, end, thread, offsets, neighbors, gradient, starts, columns, blocks):
    """Adds gradients of bonds to their entries, and subtracts them from those of the nodes themselves."""
    for i in range(begin, end):
        entry, own = starts[i], starts[i]
        while columns[own] != i:
            own += 1
        for q in range(offsets[i], offsets[i + 1]):
            while columns[entry] != neighbors[q]:
                entry += 1
            for k in range(gradient.shape[1]):
                blocks[entry, 0, k] += gradient[q, k]
                blocks[own, 0, k] -= gradient[q, k]
    return 0


def _joined(own: Pattern, joints: Sequence[_Joint], width: int) -> Pattern:
    """The pattern of a part with entries of connections beside its own."""
    rows = np.concatenate([np.repeat(np.arange(own.rows), np.diff(own.starts)), *(joint.rows for joint in joints)])
    columns = np.concatenate([own.columns, *(joint.columns for joint in joints)])
    keys = np.unique(rows * width + columns)
    starts = np.searchsorted(keys, np.arange(own.rows + 1) * width)
    return Pattern(starts, (keys % width).astype(np.uint32), width)


def require_both(host: Host, label: str) -> None:
    """Raises BadInput for a connection whose bonds only one part feels."""
    if isinstance(host, Connection) and not host.both:
        raise BadInput(
            f"{label}: solids have no tangent where only one part feels the bonds: both=False of '{host.name}'"
        )
