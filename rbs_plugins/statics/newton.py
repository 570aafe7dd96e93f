"""Newton: equilibria by Newton's method, load step after load step."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rbs_core import BadInput, NotConverged, NotFinite, Part, Relation, Statics, Trigger, always
from rbs_core.relation import Fields
from rbs_core.report import log
from rbs_core.trigger import Clock
from rbs_plugins.boundary.domain import BoundaryDomain
from rbs_plugins.constitutive.bond_based import BondBased
from rbs_plugins.fields import displacement, external_work, volume
from rbs_plugins.statics.problem import Problem, Vector, as_list, clock_at
from rbs_plugins.statics.solvers import LinearSolver, Singular
from rbs_plugins.statics.stiffness import Stiffness
from rbs_plugins.statics.supports import loose_pieces, require_supports

FEW = 5  # iterations up to which a step that was cut may grow again
LOOSEST = 1e-3  # tolerance of a linear solution, relative


@dataclass(frozen=True)
class Iterations:
    """One search for an equilibrium.

    Attributes:
        time: for which loads, s.
        residuals: unbalanced force over internal force behind each iteration.
        converged: whether it ended in an equilibrium.
        broken: directed bonds that failed in it.
        seconds: wall time.
    """

    time: float
    residuals: tuple[float, ...]
    converged: bool
    broken: int = 0
    seconds: float = 0.0

    def __str__(self) -> str:
        found = "equilibrium" if self.converged else "no equilibrium"
        broke = f", {self.broken} bonds failed" if self.broken else ""
        return f"time {self.time:.6g}: {found}{broke}, residuals {' '.join(f'{r:.2e}' for r in self.residuals) or '-'}"


class _NoEquilibrium(ArithmeticError):
    """Why an attempt was given up."""


class Newton(Statics):
    """Equilibria of parts under prescribed motions and loads, by Newton's method.

    Args:
        parts: a part, or several.
        forces: constitutive relations of these parts and of connections of them; each has a `tangent()`.
        boundaries: boundary domains, and other relations that add to the force density.
        tolerance: of the residual: norm of the unbalanced forces on what is free, over the norm of the internal forces
            on all nodes, supports among them.
        iterations: at most so many in one search for an equilibrium.
        line_search: True shortens an iteration that makes the residual larger.
        cuts: how often a step may be halved where no equilibrium is found; it grows again afterwards.
        solver: of the linear equations, see LinearSolver.
        reuse: a factorisation is kept as long as each iteration leaves at most this share of the residual; 0 makes a
            new one in each iteration (full Newton).
        rebalance: how often bonds may fail and equilibrium be found anew at one load.
        when: trigger.

    Attributes:
        history: what was tried, one `Iterations` for each search.

    Raises:
        BadInput: on forces or boundaries that do not fit; at the start of the run on a piece that nothing holds.
        NotConverged: if no equilibrium is found, with the history and the node with the largest unbalanced force.
            Displacements are those of the last equilibrium then, and nothing behind this relation has been done.

    A step of the clock is a load step: loads and prescribed displacements are those of its end. In one where no
    equilibrium is found, steps in between are taken. Bonds do not fail, and internal states do not advance, while an
    equilibrium is searched; where bonds fail in it, equilibrium is found again at the same load until none does. A
    piece that has broken off from all supports stays where it is. The residual counts reactions in its norm, which is
    how Hashim (2021) must have done it to print his tables 5.2 to 5.4.
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
        tolerance: float = 1e-8,
        iterations: int = 25,
        line_search: bool = False,
        cuts: int = 10,
        solver: str = "auto",
        reuse: float = 0.0,
        rebalance: int = 1000,
        when: Trigger = always,
    ) -> None:
        every: list[Any] = as_list(parts)
        super().__init__(every[0], when=when)
        if not 0 < tolerance < 1:
            raise BadInput(f"{self.label}: tolerance={tolerance} must lie between 0 and 1")
        if iterations < 1 or cuts < 0 or rebalance < 1 or not 0 <= reuse < 1:
            raise BadInput(
                f"{self.label}: iterations={iterations} and rebalance={rebalance} must be at least 1, cuts={cuts} not "
                f"negative, reuse={reuse} between 0 and 1"
            )
        self._problem = Problem(self.label, every, as_list(forces), as_list(boundaries))  # type: ignore[arg-type]
        self.owns = self._problem.owned
        self.tolerance, self.iterations, self.line_search = tolerance, iterations, line_search
        self.cuts, self.reuse, self.rebalance, self._solver_name = cuts, reuse, rebalance, solver
        self.reads: Fields = tuple((part, volume) for part in every)
        self.updates: Fields = tuple((part, displacement) for part in every)
        self.offers: Fields = tuple((part, external_work) for part in every)
        self.reset()

    def choose_storage(self) -> None:
        """Tangents are of lists."""
        for host in self._problem.hosts:
            host.bonds.need_list(self.label)

    # -- life -------------------------------------------------------------------------------------------------------

    def reset(self) -> None:
        self.history: list[Iterations] = []
        self._time = self._step = 0.0
        self._held: Any = None  # unknowns of pieces that have broken off
        self._supported: Any = None  # prescribed unknowns that have been found to hold everything

    def state(self) -> dict[str, Any]:
        return {"time": self._time, "step": self._step}

    def restore(self, state: dict[str, Any]) -> None:
        self._time, self._step = float(state["time"]), float(state["step"])

    def attach(self) -> None:
        problem = self._problem
        problem.attach(self)
        self._K = Stiffness(problem, self.label)
        self._solver = LinearSolver(self._K, self._solver_name, self.part.dimension, self.label)
        self._known = False  # whether K is that of the bonds that there are
        self._rest = np.zeros(problem.size)
        self._evaluations = 0

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
            kept = self._problem.u.copy()
            try:
                most = self._level(clock_at(clock, goal, goal - now), now)
            except _NoEquilibrium as why:
                self._problem.u[...] = kept
                step *= 0.5
                if step < (target - start) * 0.5 ** (self.cuts + 0.5):
                    raise self._failure(clock, goal, str(why)) from None
                log.info("%s: no equilibrium at time %.6g (%s), step cut to %.3g", self.label, goal, why, step)
                continue
            now = self._time = goal
            if most <= FEW:
                step *= 2.0
        self._step = step

    def _level(self, clock: Clock, start: float) -> int:
        """Goes to the loads of a time; the largest number of iterations that an equilibrium took."""
        problem = self._problem
        goal = problem.prescribe(clock, start)
        if self._held is not None:
            self._stay(goal, self._held)
        if self._supported is None or not np.array_equal(self._supported, problem.fixed):
            require_supports(problem, self.label)
            self._supported = problem.fixed.copy()
        before, reactions = problem.u.copy(), self._rest
        most, broken = 0, 0
        for _ in range(self.rebalance):
            begin = time.perf_counter()
            residuals, why = self._balanced(clock, goal)
            if why is None:
                broken = problem.commit(clock)
            self.history.append(
                Iterations(clock.time, tuple(residuals), why is None, broken, time.perf_counter() - begin)
            )
            if why is not None:
                raise _NoEquilibrium(why)
            most = max(most, len(residuals))
            if not broken:
                self._work(before, reactions)
                return most
            self._known = False
            self._hold_loose(goal)
        raise _NoEquilibrium(f"bonds went on failing, {self.rebalance} times")

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

    # -- one equilibrium --------------------------------------------------------------------------------------------

    def _balanced(self, clock: Clock, goal: Vector) -> tuple[list[float], str | None]:
        """Residuals of the iterations, and why they did not end in an equilibrium; None if they did."""
        problem, fixed = self._problem, self._problem.fixed
        residuals: list[float] = []
        jump = np.where(fixed, np.nan_to_num(goal) - problem.u, 0.0)
        moved = bool(jump.any())
        try:
            norm = self._residual(clock)
            if norm <= self.tolerance and not moved:
                return residuals, None
            for number in range(self.iterations):
                change = self._change(jump if moved and number == 0 else None, norm, residuals)
                problem.u += change
                last, norm = norm, self._residual(clock)
                if self.line_search and norm > last and (number or not moved):
                    norm = self._shorter(clock, change, norm)
                residuals.append(norm)
                if norm <= self.tolerance:
                    return residuals, None
                if not np.isfinite(norm):
                    return residuals, "the residual is not finite"
        except Singular as error:
            return residuals, str(error)
        except NotFinite as error:
            return residuals, str(error)
        return residuals, f"{self.iterations} iterations did not reach the tolerance {self.tolerance:g}"

    def _residual(self, clock: Clock) -> float:
        self._evaluations += 1
        self._rest, internal = self._problem.balance(clock)
        rest = float(np.linalg.norm(self._rest[~self._problem.fixed]))
        return 0.0 if rest == 0.0 else rest / internal if internal > 0 else np.inf

    def _change(self, jump: Vector | None, norm: float, residuals: Sequence[float]) -> Vector:
        """Displacements that would balance everything if K were constant."""
        fixed = self._problem.fixed
        falling = len(residuals) > 1 and residuals[-1] <= self.reuse * residuals[-2]
        if not self._known or not (self._K.constant or (self._solver.has_factor and falling)):
            self._K.update()
            self._solver.forget()
            self._known = True
        rhs = self._rest
        if jump is not None:
            moving = np.zeros(self._problem.size)
            self._K.multiply(jump, moving)
            rhs = rhs - moving
        least = 0.1 * self.tolerance / max(norm if np.isfinite(norm) else 1.0, 1.0)
        loosest = least if self._K.constant else LOOSEST
        if fixed.all():
            return np.zeros_like(rhs) if jump is None else jump
        change = self._solver.solve(rhs, fixed, float(np.clip(norm, least, loosest)))
        return change if jump is None else change + jump

    def _shorter(self, clock: Clock, change: Vector, norm: float) -> float:
        """Takes parts of a change back as long as the residual gets smaller by it."""
        share = 1.0
        while share > 1 / 64:
            self._problem.u -= 0.5 * share * change
            shorter = self._residual(clock)
            if not shorter < norm:
                self._problem.u += 0.5 * share * change
                return self._residual(clock)
            share, norm = 0.5 * share, shorter
        return norm

    # -- results ----------------------------------------------------------------------------------------------------

    def _work(self, before: Vector, old: Vector) -> None:
        """Work of the prescribed motions along a step: mean reaction times displacement."""
        problem = self._problem
        for part, place in problem.places.items():
            if self.wants((part, external_work)):
                moved = (problem.u[place] - before[place]) * problem.fixed[place]
                self[part, external_work][...] -= 0.5 * float(np.sum((old[place] + self._rest[place]) * moved))

    def _failure(self, clock: Clock, goal: float, why: str) -> NotConverged:
        rest = np.where(self._problem.fixed, 0.0, np.nan_to_num(self._rest, nan=np.inf))
        worst = int(np.argmax(np.abs(rest)))
        tried = "\n  ".join(str(each) for each in self.history[-3:])
        error = NotConverged(
            f"step {clock.step}: {self.label} finds no equilibrium between {self._time:.6g} and {goal:.6g} s: {why}; "
            f"the largest unbalanced force, {rest[worst]:.3g} N, is on {self._problem.named(worst)}. Displacements are "
            "those of the last equilibrium. Take smaller load steps or more cuts, prescribe displacements in place of "
            f"loads, or look at what holds this node. The last attempts:\n  {tried}"
        )
        error.history = list(self.history)
        return error
