"""Newton: equilibria by Newton's method, load step after load step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from rbs_core import BadInput, NotFinite, Part, Relation, Trigger, always
from rbs_core.trigger import Clock
from rbs_plugins.statics.load_steps import Iterations, LoadSteps, Search
from rbs_plugins.statics.problem import Vector
from rbs_plugins.statics.solvers import LinearSolver, Singular
from rbs_plugins.statics.stiffness import Stiffness

__all__ = ["Iterations", "Newton"]

FEW = 5  # iterations up to which a step that was cut may grow again
SHORTEST = 2.0**-10  # share of a change that a line search takes at least
LOOSEST = 1e-3  # tolerance of a linear solution, relative


class Newton(LoadSteps):
    """Equilibria of parts under prescribed motions and loads, by Newton's method.

    Args:
        parts: a part, or several.
        forces: constitutive relations of these parts and of connections of them; each has a `tangent()`.
        boundaries: boundary domains, and other relations that add to the force density.
        tolerance: of the residual: norm of the unbalanced forces on what is free, over the norm of the internal forces
            on all nodes, supports among them (or a thousandth of the largest that an equilibrium has had: a body that
            has fallen apart has none).
        iterations: at most so many in one search for an equilibrium.
        line_search: True halves the change of an iteration until the unbalanced force gets smaller by it.
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
            Displacements and bonds are those of the last equilibrium then, and nothing behind this has been done.

    A step of the clock is a load step: loads and prescribed displacements are those of its end. In one where no
    equilibrium is found, everything is as before, and steps in between are taken. Bonds do not fail, and internal
    states do not advance, while an equilibrium is searched; where bonds fail in it, equilibrium is found again at the
    same load until none does. A piece that has broken off from all supports stays where it is, and so does a node in a
    direction in which no bond is left to hold it. The residual counts reactions in its norm, which is how Hashim (2021)
    must have done it to print his tables 5.2 to 5.4.
    """

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
        super().__init__(
            parts, forces, boundaries, tolerance=tolerance, iterations=iterations, cuts=cuts, rebalance=rebalance,
            when=when,
        )  # fmt: skip
        if not 0 <= reuse < 1:
            raise BadInput(f"{self.label}: reuse={reuse} must be at least 0 and less than 1")
        self.line_search, self.reuse, self._solver_name = line_search, reuse, solver

    def choose_storage(self) -> None:
        """Tangents are of lists."""
        for host in self._problem.hosts:
            host.bonds.need_list(self.label)

    def attach(self) -> None:
        super().attach()
        self._K = Stiffness(self._problem, self.label)
        slow = "_solver" in self.__dict__ and self._solver.slow
        self._solver: LinearSolver = LinearSolver(self._K, self._solver_name, self.part.dimension, self.label)
        self._solver.slow = slow
        self._bonds_failed()

    def reset(self) -> None:
        super().reset()
        if hasattr(self, "_solver"):
            self._solver.slow = False

    def state(self) -> dict[str, Any]:
        return {**super().state(), "slow": self._solver.slow}

    def restore(self, state: dict[str, Any]) -> None:
        super().restore(state)
        self._solver.slow = bool(state["slow"])

    def begin(self, clock: Clock) -> None:
        super().begin(clock)
        self._solver.holds = any(host.bonds.has_broken for host in self._problem.hosts)

    @property
    def solved(self) -> dict[str, int]:
        """Names of the linear solvers, with how often each has solved."""
        return dict(self._solver.used)

    @property
    def nbytes(self) -> int:
        """Bytes of the tangents."""
        return self._K.nbytes if hasattr(self, "_K") else 0

    def _check_supports(self) -> None:
        if not self._K.grounded:
            super()._check_supports()

    def _hold_loose(self, goal: Vector) -> None:
        if not self._K.grounded:
            super()._hold_loose(goal)

    def _bonds_failed(self) -> None:
        self._known = False  # whether K is that of the bonds that there are
        self._solver.holds = any(host.bonds.has_broken for host in self._problem.hosts)

    def _balanced(self, clock: Clock, goal: Vector) -> Search:
        residuals: list[float] = []
        try:
            why = self._iterate(clock, goal, residuals)
        except (Singular, NotFinite) as error:
            why = str(error)
        return Search(residuals, why, len(residuals), len(residuals) <= FEW)

    def _iterate(self, clock: Clock, goal: Vector, residuals: list[float]) -> str | None:
        """Adds the residuals of the iterations; says why they did not end in an equilibrium, None if they did."""
        problem = self._problem
        jump = np.where(problem.fixed, np.nan_to_num(goal) - problem.u, 0.0)
        moved = bool(jump.any())
        norm = self._residual(clock)
        if norm <= self.tolerance and not moved:
            return None
        for number in range(self.iterations):
            change = self._change(clock, jump if moved and number == 0 else None, norm, residuals)
            before = self._unbalanced
            problem.u += change
            last, norm = norm, self._residual(clock)
            if self.line_search and (number or not moved):
                norm = self._shorter(clock, change, norm, before)
            residuals.append(norm)
            if norm <= self.tolerance or (number and norm > 0.5 * last and self._is_round_off()):
                return None
            if not np.isfinite(norm):
                return "the residual is not finite"
        return f"{self.iterations} iterations did not reach the tolerance {self.tolerance:g}"

    def _is_round_off(self) -> bool:
        """True if what is not balanced is no more than what rounded positions make of it."""
        problem, free = self._problem, ~self._problem.fixed
        size = max(np.abs(part.positions).max() for part in problem.parts)
        # what has run away is no excuse: displacements count up to the size of the bodies and of what is prescribed
        size += min(np.abs(problem.u).max(), size + np.abs(problem.u[problem.fixed]).max(initial=0.0))
        least = np.finfo(np.float64).eps * size * float(np.linalg.norm(self._K.diagonal()[free]))
        return float(np.linalg.norm(self._rest[free])) <= least

    def _change(self, clock: Clock, jump: Vector | None, norm: float, residuals: Sequence[float]) -> Vector:
        """Displacements that would balance everything if K were constant."""
        fixed = self._problem.fixed
        falling = len(residuals) > 1 and residuals[-1] <= self.reuse * residuals[-2]
        if not self._known or not (self._K.constant or (self._solver.has_factor and falling)):
            self._K.update(clock)
            self._solver.forget()
            self._known = True
        rhs = self._rest
        if jump is not None:
            moving = np.zeros(self._problem.size)
            self._K.multiply(jump, moving)
            rhs = rhs - moving
        # what a jump of supports stirs up is many times the internal force that is left of it
        least = 0.01 * self.tolerance if jump is not None else 0.1 * self.tolerance / (norm if norm < 1.0 else 1.0)
        loosest = least if self._K.constant else LOOSEST
        if fixed.all():
            return np.zeros_like(rhs) if jump is None else jump
        change = self._solver.solve(rhs, fixed, float(np.clip(norm, min(least, 0.1), loosest)))
        return change if jump is None else change + jump

    def _shorter(self, clock: Clock, change: Vector, norm: float, before: float) -> float:
        """Halves a change until it makes the unbalanced force smaller than it was before, N; the residual then."""
        share = 1.0
        while not self._unbalanced < before and share > SHORTEST:
            share *= 0.5
            self._problem.u -= share * change
            norm = self._residual(clock)
        return norm
