"""AdaptiveDynamicRelaxation: equilibria by damped dynamics with masses of its own, without a tangent."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, NotFinite, Part, Relation, Trigger, always
from rbs_core.report import log
from rbs_core.trigger import Clock
from rbs_plugins.boundary.domain import BoundaryDomain
from rbs_plugins.fields import density, displacement, force_density, volume
from rbs_plugins.statics.bodies import Body
from rbs_plugins.statics.load_steps import LEAST, Iterations, LoadSteps, Search
from rbs_plugins.statics.problem import Vector
from rbs_plugins.statics.supports import loose_pieces

DAMPINGS = ("viscous", "kinetic")
STRONGEST = 1.9  # largest damping, over the step, which is 1
SAFETY = 1.05  # of the fictitious density over the least one that is stable at rest
EXPLODED = 1e3  # unbalanced force over the largest one of the first iterations, which says that the density is too low
HEAVIER = 4.0  # and by how much it is multiplied then
TRIES = 8
FIRST = 10


class _Exploded(ArithmeticError):
    """Says that the fictitious density is too low."""


class AdaptiveDynamicRelaxation(LoadSteps):
    """Equilibria by dynamics that are damped as well as can be: for forces without a tangent, and for lattices.

    Args:
        parts, forces, boundaries, tolerance, cuts, rebalance, when: as of Newton; forces need no tangent.
        iterations: at most so many in one search for an equilibrium.
        damping: "viscous", or "kinetic": no damping, but motion begins anew from rest whenever its energy has passed a
            maximum.
        per_step: so many iterations in each step of the clock, converged or not, for loads that go on while the parts
            follow; None (default) looks for equilibrium in each step.

    Attributes:
        history: one `Iterations` for each search, with the residuals behind iterations 1, 2, 4, 8, ... and the last.

    Raises:
        BadInput: as Newton, on an unknown damping, and at the start of the run if a force knows no bound of its
            stiffness. What nothing holds is no error: it may be in equilibrium all the same.
        NotConverged: as Newton.

    The motion is λ ü + c λ u̇ = L + b with a time step of 1. The fictitious density λ = ¼ Σ|K_ij| of each node (by
    Gershgorin's circles, times 1.05) makes that stable; it comes from the stiffness bound of the forces, and no density
    is looked at. If it explodes all the same, as materials that stiffen may let it, λ is made larger. The damping is
    that which is critical for the mode that moves: c = 2 √(v·Kv / v·λv), no more than 1.9, and none where v·Kv, found
    from the change of the forces, is negative (Underwood 1983; Kilic & Madenci 2010; with the displacement in place of
    v there, and in Hashim 2021, eqs. 3.29 to 3.39, whose λ⁻¹ must be λ). Searched is an equilibrium in which what is
    unbalanced, and √(v·Kv / v·λv) |λ v|, the force that the motion will bring, are below `tolerance` times the internal
    forces. A step begins with displacements that go on as in the last one, where those are nearer to equilibrium.

    The number of iterations grows with the slenderness of a body and its number of nodes along the longest axis: some
    hundreds for compact bodies, ten thousand for slender beams, which Newton's method solves in a few.
    """

    storages = ("list", "lattice")  # what the forces can

    def __init__(
        self,
        parts: Part | Sequence[Part],
        forces: Relation | Sequence[Relation],
        boundaries: Relation | Sequence[Relation] = (),
        *,
        tolerance: float = 1e-8,
        iterations: int = 100_000,
        damping: str = "viscous",
        per_step: int | None = None,
        cuts: int = 2,
        rebalance: int = 1000,
        when: Trigger = always,
    ) -> None:
        super().__init__(
            parts, forces, boundaries, tolerance=tolerance, iterations=iterations, cuts=cuts, rebalance=rebalance,
            when=when,
        )  # fmt: skip
        if damping not in DAMPINGS:
            raise BadInput(f"{self.label}: damping={damping!r} must be one of {', '.join(DAMPINGS)}")
        if per_step is not None and per_step < 1:
            raise BadInput(f"{self.label}: per_step={per_step} must be at least 1")
        self.damping, self.per_step = damping, per_step

    def choose_storage(self) -> None:
        """The forces choose, each for itself."""

    # -- life -------------------------------------------------------------------------------------------------------

    def reset(self) -> None:
        super().reset()
        for body in getattr(self, "_bodies", {}).values():
            body.stop()
        self._grounded: bool | None = None  # whether nothing was loose at first, but may break off
        self._factor = 1.0  # of the fictitious density, over the one at rest
        self._next = (0.0, 0.5)  # what of the velocity to keep, and the push of the forces
        self._level_time = math.nan  # of the loads that are searched an equilibrium for
        # where the last step began, m, when, s, and its displacements over its length, m/s
        self._trend: dict[str, Any] = {"u": np.empty(0), "time": -1.0, "rate": np.empty(0)}

    def attach(self) -> None:
        super().attach()
        problem = self._problem
        bounds = self._bounds()
        before = getattr(self, "_bodies", {})
        self._bodies = {
            part: Body(self[part, displacement], self[part, force_density], self[part, volume], before.get(part))
            for part in problem.parts
        }
        self._least = {part: SAFETY * 0.25 * bound for part, bound in bounds.items()}
        self._steady = [each for each in problem.loads if isinstance(each, BoundaryDomain)]
        self._others = [each for each in problem.loads if each not in self._steady]

    def _weigh(self) -> None:
        for part, body in self._bodies.items():
            body.weigh(self._factor * self._least[part], self._problem.fixed[self._problem.places[part]])

    def _bounds(self) -> dict[Part, NDArray[np.float64]]:
        """Bound of the stiffness at each node, N/m^4."""
        total = {part: np.zeros(len(part)) for part in self._problem.parts}
        for each in self._problem.owned:
            if hasattr(each, "stiffness_bounds"):
                found = each.stiffness_bounds()
            else:
                found = {part: bound * part[density] for part, bound in each.squared_frequencies().items()}
            for part, bound in found.items():
                total[part] += bound
        lost = [part.name for part, bound in total.items() if not bound.any()]
        if lost:
            raise BadInput(f"{self.label}: no force on part '{lost[0]}' knows a bound of its stiffness")
        return total

    @property
    def nbytes(self) -> int:
        """What the bodies keep."""
        return sum(body.nbytes for body in getattr(self, "_bodies", {}).values())

    # -- one equilibrium --------------------------------------------------------------------------------------------

    def _check_supports(self) -> None:
        """Pieces that nothing holds may balance themselves; only where none is loose, those that break off are held."""
        if self._grounded is None:
            self._grounded = self._problem.may_break and not loose_pieces(self._problem)

    def _hold_loose(self, goal: Vector) -> None:
        if self._grounded:
            super()._hold_loose(goal)

    def _balanced(self, clock: Clock, goal: Vector) -> Search:
        problem, first = self._problem, self._problem.u.copy()
        residuals: list[float] = []
        why: str | None = None
        count = 0
        for _ in range(TRIES):
            problem.u[...] = first
            try:
                why, count = self._settle(clock, goal, residuals)
                problem.take()
                self._residual(clock)
                break
            except (_Exploded, NotFinite) as error:
                why = f"the motion explodes, also with {self._factor:g} times the fictitious density at rest: {error}"
                self._factor *= HEAVIER
                log.info("%s: the motion explodes, fictitious density %g times that at rest", self.label, self._factor)
        return Search(residuals, why, count, 4 * count < self.iterations)

    def _settle(self, clock: Clock, goal: Vector, residuals: list[float]) -> tuple[str | None, int]:
        """Moves the parts until they rest; why they do not, and the number of iterations."""
        self._start(clock, goal)
        largest, push, floor = 0.0, (0.0, 0.5), self._round_off()
        for number in range(1, self.iterations + 1):
            self._problem.pull([*self._problem.forces, *self._others], clock)
            rest, internal, omega, momentum, power = self._move(*push)
            self._evaluations += 1
            size = max(internal, LEAST * self._largest)
            done = max(rest, omega * momentum) <= max(self.tolerance * size, floor)
            residual = rest / size if size > 0 else math.inf if rest > 0 else 0.0
            if number & (number - 1) == 0 or done:
                residuals.append(residual)
            if done:
                return None, number
            if number <= FIRST:
                largest = max(largest, rest, self.tolerance * size)
            elif not rest <= EXPLODED * largest:
                raise _Exploded(f"unbalanced force {rest:.3g} N behind {number} iterations")
            push = self._push(omega, power)
        residuals.append(residual)
        return f"{self.iterations} iterations did not reach the tolerance {self.tolerance:g}", self.iterations

    def _round_off(self) -> float:
        """What rounded positions leave unbalanced, N."""
        problem = self._problem
        size = max(np.abs(part.positions).max() for part in problem.parts) + np.abs(problem.u).max()
        stiff = [self._least[part] * self[part, volume] for part in problem.parts]
        return float(np.finfo(np.float64).eps * size * math.sqrt(sum(float(np.sum(each**2)) for each in stiff)))

    def _start(self, clock: Clock, goal: Vector) -> None:
        """At rest, with the prescribed displacements and loads of a time."""
        problem = self._problem
        before = problem.u.copy()
        problem.u[problem.fixed] = goal[problem.fixed]
        if self._level_time != clock.time:
            self._level_time = clock.time
            self._go_on(clock, before)
        for body in self._bodies.values():
            body.stop()
        self._load(clock)

    def _load(self, clock: Clock) -> None:
        """Tells the bodies what is fixed and which loads act, and gives the parts their displacements."""
        problem = self._problem
        problem.give()
        problem.pull(self._steady, clock)
        self._weigh()
        for body in self._bodies.values():
            body.take_load()

    def _go_on(self, clock: Clock, before: Vector) -> None:
        """Displacements that go on as in the last step, if those are nearer to equilibrium.

        Args:
            clock: time and length of this step.
            before: displacements from which it begins.
        """
        u, free = self._problem.u, ~self._problem.fixed
        if self._time > self._trend["time"]:
            if self._trend["u"].size:
                self._trend["rate"] = (before - self._trend["u"]) / (self._time - self._trend["time"])
            self._trend |= {"time": self._time, "u": before}
        if not self._trend["rate"].size:
            return
        here, first = u.copy(), self._residual(clock)
        u[free] += clock.dt * self._trend["rate"][free]
        try:
            nearer = self._residual(clock) < first
        except NotFinite:
            nearer = False
        if not nearer:
            u[...] = here

    def _move(self, keep: float, push: float) -> tuple[float, float, float, float, float]:
        """One iteration of all parts: unbalanced and internal force, N, frequency, momentum over the step, power."""
        sums = np.zeros(6)
        for body in self._bodies.values():
            sums += body.move(keep, push)
        rest, internal, bending, inertia, momentum, power = sums.tolist()
        omega = math.sqrt(bending / inertia) if bending > 0 and inertia > 0 else 0.0
        return math.sqrt(rest), math.sqrt(internal), omega, math.sqrt(momentum), power

    def _push(self, omega: float, power: float) -> tuple[float, float]:
        """What of the velocity to keep in the next iteration, and the push of the forces."""
        if self.damping == "kinetic":
            return (0.0, 0.5) if power < 0 else (1.0, 1.0)
        c = min(2.0 * omega, STRONGEST)
        return (2.0 - c) / (2.0 + c), 2.0 / (2.0 + c)

    # -- some iterations per step -----------------------------------------------------------------------------------

    def apply(self, clock: Clock) -> None:
        if self.per_step is None:
            super().apply(clock)
            return
        self._evaluations = 0
        problem, before = self._problem, self._problem.u.copy()
        goal = problem.prescribe(clock, self._time)
        problem.u[problem.fixed] = goal[problem.fixed]
        self._load(clock)
        for _ in range(self.per_step):
            problem.pull([*problem.forces, *self._others], clock)
            _, _, omega, _, power = self._move(*self._next)
            self._next = self._push(omega, power)
        problem.take()
        reactions = self._rest
        residual = self._residual(clock)
        broken = problem.commit(clock)
        self._work(before, reactions)
        self._time = clock.time
        self.history.append(Iterations(clock.time, (residual,), residual <= self.tolerance, broken, 0.0, self.per_step))

    def state(self) -> dict[str, Any]:
        kept: dict[str, Any] = {**super().state(), "factor": self._factor, "next": np.array(self._next)}
        kept |= {f"trend {name}": value for name, value in self._trend.items()}
        for number, body in enumerate(self._bodies.values()):
            kept |= {f"v {number}": body.v, f"rest {number}": body.rest}
        return kept

    def restore(self, state: dict[str, Any]) -> None:
        super().restore(state)
        keep, push = state["next"]
        self._factor, self._next = float(state["factor"]), (float(keep), float(push))
        self._trend = {name: state[f"trend {name}"] for name in self._trend}
        for number, body in enumerate(self._bodies.values()):
            body.v[...], body.rest[...] = state[f"v {number}"], state[f"rest {number}"]
