"""The tangent of forces whose bonds know nothing of each other: one spring for each bond."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import csr_array

from rbs_core import BadInput
from rbs_core.part import Connection
from rbs_plugins.loops.arguments import Argument
from rbs_plugins.loops.joint import JointLoops
from rbs_plugins.loops.lattice import LatticeLoops
from rbs_plugins.loops.source import plain
from rbs_plugins.tangents.base import Array, Tangent
from rbs_plugins.tangents.matrix import BlockMatrix
from rbs_plugins.tangents.pattern import Pattern
from rbs_plugins.tangents.springs import Springs

if TYPE_CHECKING:
    from rbs_plugins.constitutive.bond_force import BondForce

SAMPLES = 8  # times that the two ends of a bond change their places


class SpringTangent(Tangent):
    """B = k n⊗n + P/|Y| (I − n⊗n) for every bond, of its pull P, the slope k of that by the length, its direction n.

    Args:
        force: attached; what its law asks for beside the deformation of the bond (fields at nodes, time) is held.

    Raises:
        BadInput: if the bonds are not stored as list.
    """

    def __init__(self, force: BondForce) -> None:
        require_list(force)
        self.ends, self.symmetric = force.ends, force.follows_potential
        self.constant = force.linear and force.proportional
        self._force = force
        self._build()
        self.update()

    def _build(self) -> None:
        """For the bonds that there are."""
        force = self._force
        self._bound = force.host.version
        self._bonds = force.host.bonds.as_rows()
        self._place = force.host.positions.copy()  # of the nodes, when linearised about them
        self._springs = Springs(*self._bonds, self._place, straight=force.linear)
        self._nodes = NodesOfConnection(force.host) if isinstance(force.host, Connection) else None
        self._blocks: BlockMatrix | None = None

    def update(self) -> None:
        if self._force.outdated_bonds:
            self._force.attach()
        if self._bound != self._force.host.version:
            self._build()
        loops = self._force.held_loops()
        assert not isinstance(loops, LatticeLoops)
        if not loops.springs(self._springs.along, self._springs.across, *self._force.now):
            raise self._force.blame()
        if not self._force.linear:
            self._place[...] = loops.position
        if self._nodes is not None:
            assert isinstance(loops, JointLoops)
            self._nodes.turns = loops.turns

    def matrix(self) -> csr_array[Any]:
        if self._blocks is None:
            pattern, nodes = Pattern.of_families(*self._bonds), self._nodes
            count, places = (pattern.rows, None) if nodes is None else (nodes.count, nodes.places)
            self._blocks = BlockMatrix(pattern, self._force.host.dimension, places, count)
        self._springs.add_to(self._blocks, afresh=True)
        if self._nodes is not None and self._nodes.turned:
            self._blocks.turn(self._nodes.owners, self._nodes.turns)
        return self._blocks.matrix

    def multiply(self, v: Array, out: Array) -> None:
        if self._nodes is None:
            self._springs.multiply(v, out)
        else:
            felt = np.zeros(len(self._nodes.places) * self._nodes.dimension)
            self._springs.multiply(self._nodes.take(v), felt)
            self._nodes.bring(felt, out)

    def diagonal(self, out: Array) -> None:
        if self._nodes is None:
            self._springs.diagonal(out)
        elif self._nodes.turned:  # a diagonal in turned coordinates needs whole blocks
            out += self.matrix().diagonal()
        else:
            felt = np.zeros(len(self._nodes.places) * self._nodes.dimension)
            self._springs.diagonal(felt)
            self._nodes.bring(felt, out)

    @property
    def nbytes(self) -> int:
        """Bytes of springs and matrix."""
        return self._springs.nbytes + (0 if self._blocks is None else self._blocks.nbytes)


class NodesOfConnection:
    """The nodes that bonds of a connection act on, among all nodes of its parts.

    Attributes:
        places: (k,) ascending numbers of the nodes, those of the second part behind all of the first.
        count: number of all nodes.
        owners: (k,) which part a node belongs to.
        turns: (parts, d, d) from components in a part to those in the world.
    """

    def __init__(self, connection: Connection) -> None:
        self.dimension = connection.dimension
        sizes = [len(end) for end in connection.ends]
        before = np.cumsum([0, *sizes])
        self.count = int(before[-1])
        self.places = np.concatenate([n + b for n, b in zip(connection.nodes, before, strict=False)])
        self.owners = np.repeat(np.arange(len(sizes)), [len(n) for n in connection.nodes]).astype(np.uint8)
        self.turns = np.array([np.eye(self.dimension)] * len(sizes))

    @property
    def turned(self) -> bool:
        """True if a part is turned in the world."""
        return bool((self.turns != np.eye(self.dimension)).any())

    def take(self, v: Array) -> Array:
        """Components in the world, of these nodes, of a vector of all nodes."""
        own = v.reshape(-1, self.dimension)[self.places]
        return np.ascontiguousarray(self._turn(own, "kab,kb->ka") if self.turned else own).reshape(-1)

    def bring(self, own: Array, out: Array) -> None:
        """Adds a vector of these nodes, in the world, to one of all nodes."""
        rows = own.reshape(-1, self.dimension)
        out.reshape(-1, self.dimension)[self.places] += self._turn(rows, "kba,kb->ka") if self.turned else rows

    def _turn(self, rows: Array, way: str) -> Array:
        return np.asarray(np.einsum(way, self.turns[self.owners], rows))


def require_list(force: Any) -> None:
    """Raises BadInput for bonds that are not stored as list."""
    if force.host.bonds.storage != "list":
        raise BadInput(
            f"{force.label}: a tangent needs the bonds as list, and they are stored as {force.host.bonds.storage}: "
            "connect the part with storage='list'"
        )


def pulls_alike(law: Callable[..., Any], arguments: tuple[Argument, ...]) -> bool:
    """True if a law gives the same when the two ends of a bond change their places, with any numbers at them.

    False for one that Python cannot follow: nothing is lost by that but time.
    """
    if not any(each.kind == "node" for each in arguments):
        return True
    rng = np.random.default_rng(0)
    swap = {"_i": "_j", "_j": "_i"}
    for _ in range(SAMPLES):
        names = dict.fromkeys(side for a in arguments for side in _both_sides(a))
        values = {name: float(rng.uniform(0.1, 1.0)) for name in names}
        values |= {a.name: a.value for a in arguments if a.value is not None}
        turned = [a.name[:-2] + swap[a.name[-2:]] if a.kind == "node" else a.name for a in arguments]
        try:
            one = plain(law)(*(values[a.name] for a in arguments))
            two = plain(law)(*(values[name] for name in turned))
        except Exception:  # whatever a user's function raises: the compiler says it better
            return False
        if not np.isclose(one, two, rtol=1e-12, atol=0.0):
            return False
    return True


def _both_sides(argument: Argument) -> tuple[str, ...]:
    if argument.kind != "node":
        return (argument.name,)
    return argument.name[:-2] + "_i", argument.name[:-2] + "_j"
