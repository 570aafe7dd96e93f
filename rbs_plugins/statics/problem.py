"""What a static solver balances: the displacements of some parts, forces, loads, and prescribed motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Field, Part, Relation
from rbs_core.part import Host
from rbs_core.relation import Fields
from rbs_core.schedule import with_feeders
from rbs_core.trigger import Clock
from rbs_plugins.boundary.domain import BoundaryDomain
from rbs_plugins.fields import displacement, force_density, intact, volume

Vector = NDArray[np.float64]


def as_list(given: object) -> list[object]:
    """A list of what is given alone or as a list."""
    return list(given) if isinstance(given, list | tuple) else [given]


def first_part(owner: str, parts: Sequence[object]) -> Part:
    """The first of some parts.

    Raises:
        BadInput: if there is none, one is no part or is there twice, or they differ in dimension.
    """
    if not parts:
        raise BadInput(f"{owner}: give a part, or a list of parts")
    for number, part in enumerate(parts):
        if not isinstance(part, Part):
            raise BadInput(f"{owner}: {part!r} is no Part")
        if part in parts[:number]:
            raise BadInput(f"{owner}: part '{part.name}' is given twice")
    first, *others = (part for part in parts if isinstance(part, Part))
    for other in others:
        if other.dimension != first.dimension:
            raise BadInput(
                f"{owner}: part '{first.name}' has dimension {first.dimension}, '{other.name}' has {other.dimension}: "
                "take a solver for each"
            )
    return first


class Problem:
    """The unknowns of a static solver, and the forces on them.

    Args:
        owner: name for messages.
        parts: whose displacements are unknown.
        forces: relations that add to the force density of these parts.
        boundaries: motions (BoundaryDomain) and loads (whatever else adds to the force density).

    Attributes:
        parts: in the order of the unknowns.
        forces: with their feeders, in order.
        loads, motions: the boundaries, sorted.
        size: number of unknowns, once attached; number i·d + k of a part is component k of its node i, behind those of
            earlier parts.
        u: (size,) displacement, m.
        fixed: (size,) bool, prescribed unknowns of this step.

    Raises:
        BadInput: on parts in single precision, forces or boundaries of other parts or of no use here.
    """

    def __init__(
        self, owner: str, parts: Sequence[Part], forces: Sequence[Relation], boundaries: Sequence[Relation]
    ) -> None:
        self._owner, self.parts = owner, list(parts)
        self._check(forces, boundaries)
        self.size = 0  # until attached
        self.given = list(forces)
        self.forces = with_feeders(forces)
        self.motions = [each for each in boundaries if isinstance(each, BoundaryDomain) and each.moves]
        self.loads = [each for each in boundaries if each not in self.motions]

    def _check(self, forces: Sequence[Relation], boundaries: Sequence[Relation]) -> None:
        for part in self.parts:
            if part.precision == "single":
                raise BadInput(f"{self._owner}: part '{part.name}' is in single precision, equilibria need double")
        if not forces:
            raise BadInput(f"{self._owner}: forces= is empty: give the constitutive relations")
        if not any(getattr(each, "role", None) == "constitutive" for each in forces):
            raise BadInput(f"{self._owner}: forces= holds no constitutive relation, got {list(forces)!r}")
        given = [*forces, *boundaries]
        for number, each in enumerate(given):
            if not isinstance(each, Relation):
                raise BadInput(f"{self._owner}: {each!r} is no relation: list relations in forces= and boundaries=")
            if each in given[:number]:
                raise BadInput(f"{self._owner}: {each!r} is listed twice, and would act twice")
            moves = isinstance(each, BoundaryDomain) and each.moves
            adds = [host for host, field in each.keys("adds") if field == force_density]
            if not (moves or adds) or (moves and each in forces):
                raise BadInput(
                    f"{self._owner}: {each!r} adds nothing to the force density: forces= takes constitutive relations, "
                    "boundaries= takes boundary domains and loads"
                )
            strange = [part.name for part in (*each.parts, *adds) if part not in self.parts]
            if strange:
                raise BadInput(
                    f"{self._owner}: {each.label} acts on part '{strange[0]}', which is not among its parts: add it, "
                    "with all of its displacements prescribed if it is only led"
                )

    def at_nodes(self, *fields: Field) -> Fields:
        """Fields of all parts, as a contract names them."""
        return tuple((part, field) for part in self.parts for field in fields)

    @property
    def owned(self) -> tuple[Relation, ...]:
        """Relations that are applied here: loads, and forces with their feeders."""
        return (*self.loads, *self.forces)

    @property
    def hosts(self) -> list[Host]:
        """The parts and connections whose bonds carry the forces."""
        return list(dict.fromkeys(host for host in (getattr(each, "host", each.part) for each in self.given)))

    # -- arrays -----------------------------------------------------------------------------------------------------

    def attach(self, relation: Relation) -> None:
        """Fetches the arrays that the relation names in its contract."""
        for motion in self.motions:
            if motion.outdated:
                raise BadInput(f"{motion.label} was made for other nodes than part '{motion.part.name}' has now")
        self._fields = {part: (relation[part, displacement], relation[part, force_density]) for part in self.parts}
        sizes = [len(part) * part.dimension for part in self.parts]
        ends = np.cumsum([0, *sizes]).tolist()
        self.size = ends[-1]
        self.places = {p: slice(a, b) for p, a, b in zip(self.parts, ends[:-1], ends[1:], strict=True)}
        self._shared = len(self.parts) == 1
        first = self._fields[self.parts[0]]
        self.u = first[0].reshape(-1) if self._shared else np.empty(self.size)
        self.volumes = np.concatenate([np.repeat(relation[part, volume], part.dimension) for part in self.parts])
        self.fixed = np.zeros(self.size, bool)
        made = dict.fromkeys(key for each in self.owned for key in each.keys("writes", "adds"))
        self._sums = [host.raw(field) for host, field in made]
        breaking = dict.fromkeys(key for each in self.forces for key in each.keys("updates") if key[1] == intact)
        self._breaking = [host for host, _ in breaking]
        self.take()

    @property
    def may_break(self) -> bool:
        """True if bonds can fail."""
        return bool(self._breaking)

    def take(self) -> None:
        """Takes the displacement of the parts as it is."""
        if not self._shared:
            for part, place in self.places.items():
                self.u[place] = self._fields[part][0].reshape(-1)

    def give(self) -> None:
        """Gives the displacement to the parts."""
        if not self._shared:
            for part, place in self.places.items():
                self._fields[part][0].reshape(-1)[:] = self.u[place]

    def node_of(self, number: int) -> tuple[Part, int, int]:
        """Part, node and component of an unknown."""
        for part, place in self.places.items():
            if place.start <= number < place.stop:
                node, axis = divmod(number - place.start, part.dimension)
                return part, node, axis
        raise IndexError(number)

    def named(self, number: int) -> str:
        """The node of an unknown, for messages."""
        part, node, axis = self.node_of(number)
        return f"component {axis} of node {node} of part '{part.name}' at {part.positions[node].tolist()}"

    # -- prescribed motions -----------------------------------------------------------------------------------------

    def prescribe(self, clock: Clock, start: float) -> Vector:
        """Sets `fixed` for a step and returns (size,) the displacement to reach, m, where it is prescribed.

        Args:
            clock: time to reach.
            start: time of the displacement that there is, s; a prescribed velocity is integrated from there.

        Raises:
            BadInput: if two motions want something else of one component of a node.
        """
        goal = np.full(self.size, np.nan)
        for motion in self.motions:
            if not motion.when(clock):
                continue
            part, place = motion.part, self.places[motion.part]
            for axis, value in motion.prescribed(start, clock.time):
                numbers = place.start + motion.nodes * part.dimension + axis
                wanted = value + (self.u[numbers] if motion.kind == "velocity" else 0.0)
                clash = np.flatnonzero(~np.isnan(goal[numbers]) & (np.abs(goal[numbers] - wanted) > 0))
                if len(clash):
                    raise BadInput(
                        f"{self._owner}: {motion!r} and an earlier motion want different displacements of "
                        f"{self.named(int(numbers[clash[0]]))}: take the node out of one of the regions"
                    )
                goal[numbers] = wanted
        self.fixed = ~np.isnan(goal)
        return goal

    # -- forces -----------------------------------------------------------------------------------------------------

    def balance(self, clock: Clock) -> tuple[Vector, float]:
        """The force that is not balanced, (size,), N, damage held; and the norm of the internal forces, N."""
        self._hold(True)
        self._apply(self.forces, clock, clear=True)
        internal = float(np.linalg.norm(self._total()))
        self._apply(self.loads, clock)
        return self._total(), internal

    def commit(self, clock: Clock) -> int:
        """The state that there is becomes one of the path: states advance, bonds fail; how many did.

        Loads and forces are left in the force density, as at the end of a step of dynamics.
        """
        self._hold(False)
        before = self.holding()
        self._apply(self.owned, clock, clear=True)
        return before - self.holding()

    def holding(self) -> int:
        """Number of directed bonds that hold, among those that can fail."""
        return sum(_holding(host) for host in self._breaking)

    def pull(self, relations: Sequence[Relation], clock: Clock) -> None:
        """Sums some of the forces and loads in the parts, damage held, for the displacements that the parts have.

        For solvers that move the parts themselves: `give` before, `take` when they are done.
        """
        self._hold(True)
        self._sum(relations, clock)

    def push(self, forces: Vector) -> None:
        """Adds forces (size,), N, to the force density of the parts."""
        for part, place in self.places.items():
            self._fields[part][1].reshape(-1)[:] += forces[place] / self.volumes[place]

    def _hold(self, hold: bool) -> None:
        for each in self.owned:
            if hasattr(each, "hold"):
                each.hold = hold

    def _apply(self, relations: Sequence[Relation], clock: Clock, clear: bool = False) -> None:
        self.give()
        self._sum(relations, clock, clear)

    def _sum(self, relations: Sequence[Relation], clock: Clock, clear: bool = True) -> None:
        if clear:
            for array in self._sums:
                array.fill(0)
        for each in relations:
            if each.when(clock):
                each.apply(clock)

    def _total(self) -> Vector:
        if self._shared:
            return self._fields[self.parts[0]][1].reshape(-1) * self.volumes
        return np.concatenate([self._fields[part][1].reshape(-1) for part in self.parts]) * self.volumes


def _holding(host: Host) -> int:
    """Directed bonds that hold: one byte each in a list, one bit for both directions in a lattice."""
    array = host.raw(intact)
    if host.bonds.storage == "list":
        return int(np.count_nonzero(array))
    return 2 * int(np.unpackbits(array.view(np.uint8)).sum(dtype=np.int64))


def clock_at(clock: Clock, time: float, dt: float) -> Clock:
    """A clock of the same step at another time, s."""
    return replace(clock, time=time, dt=dt)
