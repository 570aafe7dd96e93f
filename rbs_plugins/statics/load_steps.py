"""Load steps: what solvers of equilibria have in common, whatever finds them."""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rbs_core import BadInput, NotConverged, Part, Relation, Statics, Trigger, always
from rbs_core.relation import Fields
from rbs_core.report import log
from rbs_core.trigger import Clock
from rbs_plugins.boundary.domain import BoundaryDomain
from rbs_plugins.constitutive.bond_based import BondBased
from rbs_plugins.fields import displacement, external_work, volume
from rbs_plugins.statics.kept import Kept
from rbs_plugins.statics.problem import Problem, Vector, as_list, clock_at, first_part
from rbs_plugins.statics.supports import loose_pieces, require_supports

LEAST = 1e-3  # internal forces below this share of the largest ones count as that


@dataclass(frozen=True)
class Iterations:
    """One search for an equilibrium.

    Attributes:
        time: for which loads, s.
        residuals: unbalanced force over internal force behind each iteration, or behind some of them.
        converged: whether it ended in an equilibrium.
        broken: directed bonds that failed in it; they hold again if the step has been given up behind it.
        seconds: wall time.
        count: number of iterations.
    """

    time: float
    residuals: tuple[float, ...]
    converged: bool
    broken: int = 0
    seconds: float = 0.0
    count: int = 0

    def __str__(self) -> str:
        found = "equilibrium" if self.converged else "no equilibrium"
        broke = f", {self.broken} bonds failed" if self.broken else ""
        steps = "" if self.count == len(self.residuals) else f" behind some of {self.count} iterations"
        numbers = " ".join(f"{r:.2e}" for r in self.residuals) or "-"
        return f"time {self.time:.6g}: {found}{broke}, residuals{steps} {numbers}"


@dataclass
class Search:
    """What a search for an equilibrium has come to.

    Attributes:
        residuals: as of Iterations.
        why: it was given up; None if an equilibrium was found.
        count: number of iterations.
        easy: whether a step that was cut may grow again.
    """

    residuals: Sequence[float]
    why: str | None
    count: int
    easy: bool


class NoEquilibrium(ArithmeticError):
    """Why an attempt was given up."""


class LoadSteps(Statics):
    """Equilibria of parts, one for each step of the clock; a subclass says how one is found.

    Args:
        parts, forces, boundaries, tolerance, iterations, cuts, rebalance, when: as of Newton.

    Attributes:
        history: what was tried, one `Iterations` for each search.
    """

    @staticmethod
    def example(part: Part) -> dict[str, Any]:
        """Stretched by its halves."""
        x = part.positions[:, 0]
        half = x <= np.median(x)
        pull: Any = [lambda time: 1e-3 * time * np.ptp(x), *[0.0] * (part.dimension - 1)]
        return {
            "forces": [BondBased(part, 1e9)],
            "boundaries": [
                BoundaryDomain(part, half, displacement=[0.0] * part.dimension),
                BoundaryDomain(part, x == x.max(), displacement=pull),
            ],
        }

    def __init__(
        self,
        parts: Part | Sequence[Part],
        forces: Relation | Sequence[Relation],
        boundaries: Relation | Sequence[Relation] = (),
        *,
        tolerance: float,
        iterations: int,
        cuts: int,
        rebalance: int,
        when: Trigger = always,
    ) -> None:
        every: list[Any] = as_list(parts)
        super().__init__(first_part(type(self).__name__, every), when=when)
        if not 0 < tolerance < 1:
            raise BadInput(f"{self.label}: tolerance={tolerance} must lie between 0 and 1")
        if iterations < 1 or cuts < 0 or rebalance < 1:
            raise BadInput(
                f"{self.label}: iterations={iterations} and rebalance={rebalance} must be at least 1, cuts={cuts} not "
                "negative"
            )
        self._problem = Problem(self.label, every, as_list(forces), as_list(boundaries))  # type: ignore[arg-type]
        self.owns = self._problem.owned
        self.tolerance, self.iterations, self.cuts, self.rebalance = tolerance, iterations, cuts, rebalance
        self.reset()

    # -- contract ---------------------------------------------------------------------------------------------------

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """Volumes, and what forces and loads read."""
        return self._problem.at_nodes(volume)

    @property
    def updates(self) -> Fields:  # type: ignore[override]
        """Displacements, and what the forces update; what forces and loads add up is written."""
        return self._problem.at_nodes(displacement)

    @property
    def offers(self) -> Fields:  # type: ignore[override]
        """The work of motions and loads, and what the forces offer."""
        return self._problem.at_nodes(external_work)

    # -- what a subclass says ---------------------------------------------------------------------------------------

    @abstractmethod
    def _balanced(self, clock: Clock, goal: Vector) -> Search:
        """Searches the equilibrium for the loads of a time, with prescribed displacements as in `goal`.

        Leaves the displacement of it in the problem, and what is not balanced in `_rest`.
        """

    def _bonds_failed(self) -> None:
        """Called when bonds have failed in an equilibrium."""

    def _check_supports(self) -> None:
        """Refuses what no solution could be found for."""
        require_supports(self._problem, self.label)

    # -- life -------------------------------------------------------------------------------------------------------

    def reset(self) -> None:
        self.history: list[Iterations] = []
        self._time = self._step = self._largest = 0.0
        self._rest: Vector = np.zeros(self._problem.size)  # what was not balanced, N
        self._held: Any = None  # unknowns of pieces that have broken off
        self._supported: Any = None  # prescribed unknowns that have been found to hold everything

    def state(self) -> dict[str, Any]:
        held = np.empty(0, np.int64) if self._held is None else self._held
        kept = {"time": self._time, "step": self._step, "largest": self._largest, "held": held}
        return kept | ({"rest": self._rest} if self._works else {})

    def restore(self, state: dict[str, Any]) -> None:
        self._time, self._step, self._largest = (float(state[name]) for name in ("time", "step", "largest"))
        self._held = np.asarray(state["held"]) if len(state["held"]) else None
        self._rest = np.array(state.get("rest", self._rest))

    def attach(self) -> None:
        self._problem.attach(self)
        self._works = any(self.wants((part, external_work)) for part in self._problem.parts)
        if self._rest.size != self._problem.size:
            self._rest = np.zeros(self._problem.size)
        self._evaluations = 0
        self._unbalanced = 0.0  # norm of the unbalanced force, N

    def begin(self, clock: Clock) -> None:
        self._problem.take()

    def items(self) -> int:
        return self._evaluations * sum(len(host.bonds) for host in self._problem.hosts)

    # -- load steps -------------------------------------------------------------------------------------------------

    def apply(self, clock: Clock) -> None:
        start, now, target = self._time, self._time, clock.time
        self._evaluations = 0
        step = min(self._step, target - start) or target - start
        while now < target:
            step = min(step, target - now)
            goal = target if target - now - step < 1e-6 * step else now + step
            u, tried, own = self._problem.u.copy(), len(self.history), (self._largest, self._rest, self._held)
            kept = Kept(self) if self._problem.may_break else None  # else nothing can be given up when states advance
            try:
                easy = self._level(clock_at(clock, goal, goal - now), now)
            except NoEquilibrium as why:
                rest, self._problem.u[...] = self._rest, u
                self._largest, self._rest, self._held = own
                if kept is not None and any(each.broken for each in self.history[tried:]):
                    kept.take_back(clock)
                    self._supported = None
                    self._bonds_failed()
                step *= 0.5
                if step < (target - start) * 0.5 ** (self.cuts + 0.5):
                    raise self._failure(clock, goal, str(why), rest) from None
                log.info("%s: no equilibrium at time %.6g (%s), step cut to %.3g", self.label, goal, why, step)
                continue
            now = self._time = goal
            if easy:
                step *= 2.0
        self._step = step

    def _level(self, clock: Clock, start: float) -> bool:
        """Goes to the loads of a time; whether that was easy."""
        problem = self._problem
        goal = problem.prescribe(clock, start)
        if self._held is not None:
            self._stay(goal, self._held)
        if self._supported is None or not np.array_equal(self._supported, problem.fixed):
            self._check_supports()
            self._supported = problem.fixed.copy()
        before, reactions = problem.u.copy(), self._rest
        easy, broken = True, 0
        for _ in range(self.rebalance):
            begin = time.perf_counter()
            found = self._balanced(clock, goal)
            if found.why is None:
                broken = problem.commit(clock)
                self._largest = max(self._largest, self._internal)
                self._work(before, reactions)
                before, reactions = problem.u.copy(), self._rest
            took = time.perf_counter() - begin
            residuals = tuple(float(each) for each in found.residuals)
            self.history.append(Iterations(clock.time, residuals, found.why is None, broken, took, found.count))
            if found.why is not None:
                raise NoEquilibrium(found.why)
            easy = easy and found.easy
            if not broken:
                return easy
            self._bonds_failed()
            self._hold_loose(goal)
        raise NoEquilibrium(f"bonds went on failing, {self.rebalance} times")

    def _hold_loose(self, goal: Vector) -> None:
        """Pieces that have broken off stay where they are."""
        loose = loose_pieces(self._problem)
        if loose:
            log.info("%s: %s: it has broken off, and stays where it is", self.label, loose[0])
            numbers = np.concatenate([piece.numbers for piece in loose])
            numbers = numbers[~self._problem.fixed[numbers]]
            self._held = numbers if self._held is None else np.union1d(self._held, numbers)
            self._stay(goal, self._held)
            self._supported = self._problem.fixed.copy()

    def _stay(self, goal: Vector, numbers: Any) -> None:
        free = numbers[~self._problem.fixed[numbers]]
        goal[free] = self._problem.u[free]
        self._problem.fixed[free] = True

    def _residual(self, clock: Clock) -> float:
        """Norm of what is not balanced on the free unknowns, over that of the internal forces on all."""
        self._evaluations += 1
        self._rest, internal = self._problem.balance(clock)
        rest = self._unbalanced = float(np.linalg.norm(self._rest[~self._problem.fixed]))
        self._internal = internal
        size = max(internal, LEAST * self._largest)
        return 0.0 if rest == 0.0 else rest / size if size > 0 else np.inf

    # -- results ----------------------------------------------------------------------------------------------------

    def _work(self, before: Vector, old: Vector) -> None:
        """Work of the prescribed motions from one equilibrium to the next: mean reaction times displacement."""
        problem = self._problem
        for part, place in problem.places.items() if self._works else ():
            if self.wants((part, external_work)):
                moved = (problem.u[place] - before[place]) * problem.fixed[place]
                self[part, external_work][...] -= 0.5 * float(np.sum((old[place] + self._rest[place]) * moved))

    def _failure(self, clock: Clock, goal: float, why: str, rest: Vector) -> NotConverged:
        rest = np.where(self._problem.fixed, 0.0, np.nan_to_num(rest, nan=np.inf))
        worst = int(np.argmax(np.abs(rest)))
        tried = "\n  ".join(str(each) for each in self.history[-3:])
        error = NotConverged(
            f"step {clock.step}: {self.label} finds no equilibrium between {self._time:.6g} and {goal:.6g} s: {why}; "
            f"the largest unbalanced force, {rest[worst]:.3g} N, is on {self._problem.named(worst)}. Displacements and "
            "bonds are those of the last equilibrium. Take smaller load steps or more cuts, prescribe displacements in "
            f"place of loads, or look at what holds this node. The last attempts:\n  {tried}"
        )
        error.history = list(self.history)
        return error
