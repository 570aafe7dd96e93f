"""SequentiallyLinear: one bond after the other fails, and the loads are scaled so that it just does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Part, Relation, Statics, Trigger, always
from rbs_core.part import Host
from rbs_core.relation import Fields, Key
from rbs_core.report import log
from rbs_core.trigger import Clock
from rbs_plugins.boundary.domain import BoundaryDomain
from rbs_plugins.constitutive.bond_based import BondBased
from rbs_plugins.constitutive.fracture import CriticalStretch
from rbs_plugins.constitutive.pairwise import PairwiseForce
from rbs_plugins.fields import displacement, dissipation_density, intact, load_factor, volume
from rbs_plugins.statics.bond_limits import BondLimits, require_linear
from rbs_plugins.statics.lowrank import Lowered
from rbs_plugins.statics.problem import Problem, Vector, as_list, clock_at, first_part
from rbs_plugins.statics.solvers import LinearSolver, Singular
from rbs_plugins.statics.stiffness import Stiffness
from rbs_plugins.statics.supports import loose_pieces, require_supports

Failing = list[tuple[Host, NDArray[np.int64]]]  # bonds of hosts

BALANCE = 1e-6  # unbalanced force over the largest, above which a solution is none
GONE = 1e-9  # share of the first stiffness below which nothing carries any load


@dataclass(frozen=True)
class Event:
    """One equilibrium of the path.

    Attributes:
        factor: of the loads and prescribed displacements.
        work: of loads and prescribed displacements at factor 1, J: the stiffness against them.
        bonds: ends (k, 2) of the bonds that are at their limit, and fail next; numbers of nodes of the host.
        host: name of the part or connection of the first of them.
    """

    factor: float
    work: float
    bonds: tuple[tuple[int, int], ...]
    host: str


class SequentiallyLinear(Statics):
    """Linear equilibria, each scaled so that one bond is at its critical stretch, which fails before the next one.

    Args:
        parts: a part, or several.
        forces: linear bond forces (`linear=True`) of these parts and their connections; the bonds of those with a
            CriticalStretch can fail.
        boundaries: boundary domains and loads; what they prescribe at the time 1 s is scaled.
        ties: bonds within this share of the largest load fail together, as those of a symmetric body do.
        when: trigger.

    Attributes:
        history: one `Event` for each equilibrium.
        finished: True when nothing carries load any more; the run ends then.

    Raises:
        BadInput: on forces that are not linear, that have another criterion than a critical stretch, or none that can
            fail; on a piece that nothing holds.

    A step of the clock is one equilibrium, and its number and not its time counts. The factor of the loads, written as
    `load_factor`, goes up and down, so that the path goes through snap-back under any kind of loading: load and
    displacement of every equilibrium belong together (Ni et al. 2019, CMAME 346; Tripaldi 2023, sec. 4.1). A factorised
    stiffness is kept and lowered by what the failed bonds have carried.
    """

    @staticmethod
    def example(part: Part) -> dict[str, Any] | None:
        """Pulled at one end; a bar has but a few bonds to lose."""
        if part.dimension == 1:
            return None
        x = part.positions[:, 0]
        pull: Any = [1e-3 * np.ptp(x), *[0.0] * (part.dimension - 1)]
        return {
            "forces": [BondBased(part, 1e9, CriticalStretch(1e-3), linear=True)],
            "boundaries": [
                BoundaryDomain(part, x <= np.quantile(x, 0.3), displacement=[0.0] * part.dimension),
                BoundaryDomain(part, x >= np.quantile(x, 0.7), displacement=pull),
            ],
        }

    def __init__(
        self,
        parts: Part | Sequence[Part],
        forces: Relation | Sequence[Relation],
        boundaries: Relation | Sequence[Relation] = (),
        *,
        ties: float = 1e-6,
        when: Trigger = always,
    ) -> None:
        every: list[Any] = as_list(parts)
        super().__init__(first_part(type(self).__name__, every), when=when)
        self._problem = Problem(self.label, every, as_list(forces), as_list(boundaries))  # type: ignore[arg-type]
        require_linear(self._problem, self.label)
        self.owns = self._problem.owned
        self.ties = ties
        self._failing: list[PairwiseForce] = [f for f in self._problem.given if getattr(f, "fracture", None)]  # type: ignore[misc]
        self.reset()

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """Volumes, and what forces and loads read."""
        return self._problem.at_nodes(volume)

    @property
    def updates(self) -> Fields:  # type: ignore[override]
        """Displacements, and the state of bonds that can fail."""
        return (*self._problem.at_nodes(displacement), *((force.host, intact) for force in self._failing))

    @property
    def writes(self) -> Fields:  # type: ignore[override]
        """The factor of the loads, and what forces and loads add up."""
        return self._problem.at_nodes(load_factor)

    def keys(self, *words: str) -> list[Key]:
        """As of any owner, but the energy of failing bonds is not recorded."""
        return [key for key in super().keys(*words) if key[1] != dissipation_density]

    def choose_storage(self) -> None:
        """Tangents are of lists."""
        for host in self._problem.hosts:
            host.bonds.need_list(self.label)

    # -- life -------------------------------------------------------------------------------------------------------

    def reset(self) -> None:
        self.history: list[Event] = []
        self.finished = False
        self._critical: Failing = []
        self._since: list[Failing] = []
        self._first = 0.0  # work of the first equilibrium, J
        self._resumed = False

    def state(self) -> dict[str, Any]:
        """The bonds that fail next, and those that have failed since the stiffness was factorised."""
        kept: dict[str, Any] = {"finished": self.finished, "since": len(self._since), "first": self._first}
        for number, events in enumerate([*self._since, self._critical]):
            for place, force in enumerate(self._failing):
                mine = [bonds for host, bonds in events if host is force.host]
                kept[f"event {number} {place}"] = np.concatenate([np.empty(0, np.int64), *mine])
        return kept

    def restore(self, state: dict[str, Any]) -> None:
        self.finished, self._first = bool(state["finished"]), float(state["first"])
        events: list[Failing] = [
            [(force.host, np.asarray(state[f"event {n} {k}"])) for k, force in enumerate(self._failing)]
            for n in range(int(state["since"]) + 1)
        ]
        *self._since, self._critical = [[each for each in event if len(each[1])] for event in events]
        self._resumed = True

    def attach(self) -> None:
        self._problem.attach(self)
        self._K = Stiffness(self._problem, self.label)
        solver = LinearSolver(self._K, "direct", self.part.dimension, self.label)
        self._lowered = Lowered(self._K, solver)
        self._bonds = [BondLimits(force, self.raw((force.host, intact)), self._problem) for force in self._failing]
        self._supported, self._resumed = False, bool(self._since)
        self._factor, self._loads = 0.0, np.zeros(self._problem.size)

    def begin(self, clock: Clock) -> None:
        self._problem.take()

    # -- work -------------------------------------------------------------------------------------------------------

    def apply(self, clock: Clock) -> None:
        problem = self._problem
        self._factor = 0.0
        if not self.finished:
            if self._resumed:
                self._redo(clock)
            self._set(self._critical, 0)
            self._since.append(self._critical)
            self._critical = []
            self._next(clock)
        if self.finished:
            problem.u[...] = 0.0
            clock.end()
        for part in problem.parts:
            self[part, load_factor][...] = self._factor
        problem.give()  # forces of the scaled displacement and scaled loads, for measures
        problem.pull(problem.forces, clock_at(clock, 1.0, clock.dt))
        problem.push(self._factor * self._loads)

    def _set(self, events: Failing, holds: int) -> None:
        for host, bonds in events:
            host.raw(intact)[bonds] = holds

    def _redo(self, clock: Clock) -> None:
        """Factorises again what had been factorised when the run was saved: then every bit comes out the same."""
        self._resumed, self._supported = False, True
        goal, loads, unit = self._posed(clock)
        self._hold_loose(goal, loads)
        for event in self._since:
            self._set(event, 1)
        for event in [[], *self._since]:
            self._set(event, 0)
            self._lowered.solve(loads, np.nan_to_num(goal), self._problem.fixed, unit)

    def _posed(self, clock: Clock) -> tuple[Vector, Vector, Clock]:
        """Prescribed displacements, loads, and the time for which they are."""
        problem, unit = self._problem, clock_at(clock, 1.0, clock.dt)
        problem.u[...] = 0.0
        goal = problem.prescribe(unit, 0.0)
        loads, _ = problem.balance(unit)  # at rest there is nothing but loads
        return goal, loads, unit

    def _next(self, clock: Clock) -> None:
        """The next equilibrium."""
        problem = self._problem
        goal, loads, unit = self._posed(clock)
        self._loads = loads
        if not self._supported:
            require_supports(problem, self.label)
            self._supported = True
        elif not self._hold_loose(goal, loads):
            self._end("what carries the load has fallen apart")
            return
        try:
            u, inner = self._solved(goal, loads, unit)
        except Singular as error:
            self._end(str(error))
            return
        work = float(np.dot(loads, u) - np.dot(inner[problem.fixed], u[problem.fixed]))
        reached = [each.shares(u) for each in self._bonds]
        most = max((float(share.max(initial=0.0)) for share in reached), default=0.0)
        if abs(work) <= GONE * self._first or not most > 0:
            self._end("no bond that can fail carries any load")
            return
        self._first = self._first or abs(work)
        self._factor = factor = 1.0 / most
        problem.u[...] = factor * u
        self._mark(reached, most, factor, work)

    def _solved(self, goal: Vector, loads: Vector, unit: Clock) -> tuple[Vector, Vector]:
        """Displacements under the whole load, and the forces on all nodes then, N.

        Raises:
            Singular: if there is no equilibrium.
        """
        problem = self._problem
        while True:
            u = self._lowered.solve(loads, np.nan_to_num(goal), problem.fixed, unit)
            if self._lowered.fresh:
                self._since = []
            problem.u[...] = u
            forces, internal = problem.balance(unit)
            rest, size = np.linalg.norm(forces[~problem.fixed]), max(internal, float(np.linalg.norm(loads)))
            if rest <= BALANCE * size:
                return u, forces
            if self._lowered.fresh:
                raise Singular("what carries the load has become a mechanism")
            self._lowered.forget()

    def _mark(self, reached: Sequence[NDArray[np.float64]], most: float, factor: float, work: float) -> None:
        """Remembers the bonds that are at their limit."""
        ends: list[tuple[int, int]] = []
        name = ""
        for each, share in zip(self._bonds, reached, strict=True):
            bonds = np.flatnonzero(share >= most * (1.0 - self.ties))
            if len(bonds):
                self._critical.append((each.host, bonds))
                ends += each.ends(bonds)
                name = name or each.host.name
        self.history.append(Event(factor, work, tuple(ends), name))

    def _hold_loose(self, goal: Vector, loads: Vector) -> bool:
        """Pieces that have broken off stay where they are at rest; False if one of them carries a load."""
        for piece in loose_pieces(self._problem):
            free = piece.numbers[~self._problem.fixed[piece.numbers]]
            if np.abs(loads[free]).max(initial=0.0) > 0 or len(free) < len(piece.numbers):
                return False
            goal[free] = 0.0
            self._problem.fixed[free] = True
        return True

    def _end(self, why: str) -> None:
        if not self._first:
            raise BadInput(
                f"{self.label}: there is no first equilibrium: {why}: look at what boundaries prescribe at time 1 s, "
                "and at which bonds may fail (compression, within=)"
            )
        self.finished = True
        log.info("%s: %s; the path ends with %d equilibria", self.label, why, len(self.history))
