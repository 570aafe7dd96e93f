"""SequentiallyLinear: one bond after the other fails, and the loads are scaled so that it just does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Part, Relation, Statics, Trigger, always
from rbs_core.part import Connection, Host
from rbs_core.relation import Fields
from rbs_core.report import log
from rbs_core.trigger import Clock
from rbs_plugins.boundary.domain import BoundaryDomain
from rbs_plugins.constitutive.bond_based import BondBased
from rbs_plugins.constitutive.fracture import CriticalStretch
from rbs_plugins.constitutive.pairwise import PairwiseForce
from rbs_plugins.fields import displacement, intact, load_factor, volume
from rbs_plugins.loops.joint import End
from rbs_plugins.statics.lowrank import Lowered
from rbs_plugins.statics.problem import Problem, Vector, as_list, clock_at
from rbs_plugins.statics.solvers import LinearSolver, Singular
from rbs_plugins.statics.stiffness import Stiffness
from rbs_plugins.statics.supports import loose_pieces, require_supports

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
    def example(part: Part) -> dict[str, Any]:
        """Pulled at one end."""
        x = part.positions[:, 0]
        pull: Any = [1e-3 * np.ptp(x), *[0.0] * (part.dimension - 1)]
        return {
            "forces": [BondBased(part, 1e9, CriticalStretch(1e-3), linear=True)],
            "boundaries": [
                BoundaryDomain(part, x <= np.median(x), displacement=[0.0] * part.dimension),
                BoundaryDomain(part, x == x.max(), displacement=pull),
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
        super().__init__(every[0], when=when)
        self._problem = Problem(self.label, every, as_list(forces), as_list(boundaries))  # type: ignore[arg-type]
        self._check(self._problem.given)
        self.owns = self._problem.owned
        self.ties = ties
        self._failing: list[PairwiseForce] = [f for f in self._problem.given if getattr(f, "fracture", None)]  # type: ignore[misc]
        self.reads: Fields = tuple((part, volume) for part in every)
        self.updates: Fields = (
            *((part, displacement) for part in every), *((force.host, intact) for force in self._failing)
        )  # fmt: skip
        self.writes: Fields = tuple((part, load_factor) for part in every)
        self.reset()

    def _check(self, forces: Sequence[Relation]) -> None:
        for force in forces:
            if not getattr(force, "linear", False):
                raise BadInput(f"{self.label}: {force.label} is not linear: make it with linear=True, or take Newton")
            criterion = getattr(force, "fracture", None)
            if criterion is not None and not isinstance(criterion, CriticalStretch):
                raise BadInput(
                    f"{self.label}: {force.label} fails by {criterion!r}; only a CriticalStretch tells at which load a "
                    "bond fails: take that, or Newton"
                )
        if not any(getattr(force, "fracture", None) for force in forces):
            raise BadInput(f"{self.label}: no force has a criterion, so that nothing can fail: give fracture=, or take "
                           "Newton")  # fmt: skip

    def choose_storage(self) -> None:
        """Tangents are of lists."""
        for host in self._problem.hosts:
            host.bonds.need_list(self.label)

    # -- life -------------------------------------------------------------------------------------------------------

    def reset(self) -> None:
        self.history: list[Event] = []
        self.finished = False
        self._critical: list[tuple[Host, NDArray[np.int64]]] = []

    def state(self) -> dict[str, Any]:
        """The bonds that fail next."""
        kept: dict[str, Any] = {"finished": self.finished}
        for number, force in enumerate(self._failing):
            mine = [bonds for host, bonds in self._critical if host is force.host]
            kept[f"critical {number}"] = np.concatenate([np.empty(0, np.int64), *mine])
        return kept

    def restore(self, state: dict[str, Any]) -> None:
        self.finished = bool(state["finished"])
        each = [(force.host, np.asarray(state[f"critical {n}"])) for n, force in enumerate(self._failing)]
        self._critical = [(host, bonds) for host, bonds in each if len(bonds)]

    def attach(self) -> None:
        self._problem.attach(self)
        self._K = Stiffness(self._problem, self.label)
        solver = LinearSolver(self._K, "direct", self.part.dimension, self.label)
        self._lowered = Lowered(self._K, solver)
        self._bonds = [_Limits(force, self.raw((force.host, intact)), self._problem) for force in self._failing]
        self._first = 0.0
        self._supported = False

    def begin(self, clock: Clock) -> None:
        self._problem.take()

    # -- work -------------------------------------------------------------------------------------------------------

    def apply(self, clock: Clock) -> None:
        problem = self._problem
        for part in problem.parts:
            self[part, load_factor][...] = 0.0
        if not self.finished:
            self._fail()
            self._next(clock)
        if self.finished:
            problem.u[...] = 0.0
            clock.end()
        problem.balance(clock_at(clock, 0.0, clock.dt))  # forces of the scaled displacement, for measures

    def _fail(self) -> None:
        for host, bonds in self._critical:
            host.raw(intact)[bonds] = 0
        self._critical = []

    def _next(self, clock: Clock) -> None:
        """The next equilibrium."""
        problem, unit = self._problem, clock_at(clock, 1.0, clock.dt)
        problem.u[...] = 0.0
        goal = problem.prescribe(unit, 0.0)
        loads, _ = problem.balance(unit)  # at rest there is nothing but loads
        if not self._supported:
            require_supports(problem, self.label)
            self._supported = True
        elif not self._hold_loose(goal, loads):
            self._end("what carries the load has fallen apart")
            return
        try:
            u = self._lowered.solve(loads, np.nan_to_num(goal), problem.fixed)
        except Singular as error:
            self._end(str(error))
            return
        problem.u[...] = u
        inner, _ = problem.balance(unit)
        work = float(np.dot(loads, u) - np.dot(inner[problem.fixed], u[problem.fixed]))
        self._first = self._first or abs(work)
        reached = [each.shares(u) for each in self._bonds]
        most = max((float(share.max(initial=0.0)) for share in reached), default=0.0)
        if abs(work) <= GONE * self._first or not most > 0:
            self._end("no bond that can fail carries any load")
            return
        factor = 1.0 / most
        problem.u[...] = factor * u
        for part in problem.parts:
            self[part, load_factor][...] = factor
        self._mark(reached, most, factor, work)

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
        self.finished = True
        log.info("%s: %s; the path ends with %d equilibria", self.label, why, len(self.history))


class _Limits:
    """The bonds of a force, and at which stretch each fails.

    Args:
        force: with a CriticalStretch.
        holds: (m,) state of the bonds.
        problem: whose unknowns the ends are.
    """

    def __init__(self, force: PairwiseForce, holds: NDArray[Any], problem: Problem) -> None:
        self.host, self._holds = force.host, holds
        offsets, neighbors = force.host.bonds.as_rows()
        self._i = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
        self._j = neighbors.astype(np.int64)
        nodes = np.concatenate(self.host.nodes) if isinstance(self.host, Connection) else np.arange(len(self.host))
        self._nodes = nodes
        first = self._unknowns(problem)
        positions = force.host.bonds.positions
        bond = positions[self._j] - positions[self._i]
        self._direction = bond / np.sum(bond * bond, axis=1)[:, None]
        self._at = (first[self._i], first[self._j])
        self._turns = _turns(force.host)
        criterion = force.fracture
        assert isinstance(criterion, CriticalStretch)
        self._tension, self._compression = criterion.limits(force, self._i, self._j)

    def _unknowns(self, problem: Problem) -> NDArray[np.int64]:
        """(n, d) numbers of the unknowns of the nodes of the host."""
        parts = self.host.ends if isinstance(self.host, Connection) else (self.host,)
        own = self.host.nodes if isinstance(self.host, Connection) else (np.arange(len(self.host)),)
        d = self.host.dimension
        each = [
            problem.places[part].start + nodes[:, None] * d + np.arange(d)  # type: ignore[index]
            for part, nodes in zip(parts, own, strict=True)
        ]
        return np.concatenate(each)

    def shares(self, u: Vector) -> NDArray[np.float64]:
        """(m,) stretch over critical stretch; zero for what has failed."""
        i, j = self._at
        moved = [u[numbers] if self._turns is None else np.einsum("nak,nk->na", self._turns[end], u[numbers])
                 for numbers, end in ((i, self._i), (j, self._j))]  # fmt: skip
        stretch = np.sum((moved[1] - moved[0]) * self._direction, axis=1)
        share = np.maximum(stretch / self._tension, -stretch / self._compression)
        return np.where(self._holds != 0, share, 0.0)

    def ends(self, bonds: NDArray[np.int64]) -> list[tuple[int, int]]:
        """Nodes of some bonds, each pair once."""
        i, j = self._nodes[self._i[bonds]], self._nodes[self._j[bonds]]
        once = self._i[bonds] < self._j[bonds]
        return list(zip(i[once].tolist(), j[once].tolist(), strict=True))


def _turns(host: Host) -> NDArray[np.float64] | None:
    """(n, d, d) from components in the part of each node to those in which the bonds are; None if they are the same."""
    if not isinstance(host, Connection):
        return None
    ends = [End(part) for part in host.ends]
    if not any(end.may_move for end in ends):
        return None
    return np.repeat([end.turn for end in ends], [len(nodes) for nodes in host.nodes], axis=0)
