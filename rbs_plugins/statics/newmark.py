"""Newmark: implicit dynamics, on the machinery of load steps and Newton's method."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from rbs_core import BadInput, Part, Relation, Trigger, always
from rbs_core.relation import Fields
from rbs_core.trigger import Clock
from rbs_plugins.boundary.damping import ViscousDamping
from rbs_plugins.fields import density, displacement, external_work, velocity, volume
from rbs_plugins.statics.load_steps import LEAST, Iterations, NoEquilibrium
from rbs_plugins.statics.newton import Newton
from rbs_plugins.statics.problem import Vector, clock_at


class Newmark(Newton):
    """Implicit dynamics: in each step the balance of forces and inertia, by Newton's method (Newmark 1959).

    Args:
        parts, forces, boundaries, tolerance, iterations, line_search, cuts, solver, reuse, when: as of Newton.
        beta, gamma: u' = u + dt v + dt² [(½ − β) a + β a'] and v' = v + dt [(1 − γ) a + γ a'], primes at the end of the
            step. ¼ and ½, the default, is the mean acceleration (trapezoidal rule): second order, stable for every dt,
            no damping. γ above ½ damps what is too fast for the step, at first order.

    Attributes:
        history: one `Iterations` for each step.

    Raises:
        BadInput: as Newton; unless 2β >= γ >= ½, where every dt is stable; at the start of the run, if a density is not
            positive. Nothing need be held.
        NotConverged: as Newton; a step in which no balance is found is halved.

    The acceleration at the beginning of a step is (L + b)/ρ there, so nothing is kept but displacement and velocity:
    the relation can take over from a static solver, from explicit steps, and from a checkpoint. The residual counts
    internal forces and inertia in its norm. Bonds fail at the end of steps, and the next step feels it. Viscous damping
    among the boundaries is implicit, too. Prescribed motions give displacements as in Newton, and velocities at the end
    of the step as in velocity Verlet.
    """

    def __init__(
        self,
        parts: Part | Sequence[Part],
        forces: Relation | Sequence[Relation],
        boundaries: Relation | Sequence[Relation] = (),
        *,
        beta: float = 0.25,
        gamma: float = 0.5,
        tolerance: float = 1e-8,
        iterations: int = 25,
        line_search: bool = False,
        cuts: int = 10,
        solver: str = "auto",
        reuse: float = 0.0,
        when: Trigger = always,
    ) -> None:
        super().__init__(
            parts, forces, boundaries, tolerance=tolerance, iterations=iterations, line_search=line_search, cuts=cuts,
            solver=solver, reuse=reuse, when=when,
        )  # fmt: skip
        if not (math.isfinite(beta) and 2.0 * beta >= gamma >= 0.5):
            raise BadInput(f"{self.label}: beta={beta} and gamma={gamma} are stable for every dt only if 2β >= γ >= ½")
        self.beta, self.gamma = beta, gamma

    # -- contract ---------------------------------------------------------------------------------------------------

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """Volumes and densities, and what forces and loads read."""
        return self._problem.at_nodes(volume, density)

    @property
    def updates(self) -> Fields:  # type: ignore[override]
        """Displacements and velocities, and what the forces update; what forces and loads add up is written."""
        return self._problem.at_nodes(displacement, velocity)

    def _check_supports(self) -> None:
        """Inertia holds everything."""

    # -- life -------------------------------------------------------------------------------------------------------

    def attach(self) -> None:
        super().attach()
        problem = self._problem
        for part in problem.parts:
            bad = np.flatnonzero(~(self[part, density] > 0))
            if len(bad):
                node = f"node {bad[0]} of part '{part.name}' at {part.positions[bad[0]].tolist()}"
                raise BadInput(f"{self.label}: the density of {node} is not positive")
        self._mass = problem.volumes * _flat([np.repeat(self[part, density], part.dimension) for part in problem.parts])
        self._drag = np.zeros(problem.size)  # N s/m
        for each in problem.loads:
            if isinstance(each, ViscousDamping):
                self._drag[problem.places[each.part]] += np.repeat(each.coefficients, each.part.dimension)
        self._drag *= problem.volumes
        self._length = 0.0  # of the step that the stiffness is for, s

    @property
    def _velocity(self) -> Vector:
        return _flat([self[part, velocity].reshape(-1) for part in self._problem.parts]).copy()

    def _set_velocity(self, v: Vector) -> None:
        for part, place in self._problem.places.items():
            self[part, velocity].reshape(-1)[:] = v[place]

    # -- one step ---------------------------------------------------------------------------------------------------

    def apply(self, clock: Clock) -> None:
        self._time = (clock.step - 1) * clock.dt  # whoever has moved the parts until then
        super().apply(clock)

    def _level(self, clock: Clock, start: float) -> bool:
        """From one time to another in one step; whether that was easy."""
        problem, dt, begin = self._problem, clock.dt, time.perf_counter()
        u, v = problem.u.copy(), self._velocity
        force, _ = problem.balance(clock_at(clock, start, dt))
        a = force / self._mass
        goal = problem.prescribe(clock, start)
        self._shift(dt)
        self._predicted = u + dt * v + (0.5 - self.beta) * dt * dt * a
        self._gained = v + (1.0 - self.gamma) * dt * a
        found = self._balanced(clock, goal)
        took = time.perf_counter() - begin
        residuals = tuple(float(each) for each in found.residuals)
        if found.why is not None:
            self.history.append(Iterations(clock.time, residuals, False, 0, took, found.count))
            self._set_velocity(v)
            raise NoEquilibrium(found.why)
        self._set_velocity(self._speed(clock))
        broken = problem.commit(clock)
        self._largest = max(self._largest, self._internal)
        self.history.append(Iterations(clock.time, residuals, True, broken, took, found.count))
        if broken:
            self._bonds_failed()
        self._follow_work(u, v, force)
        return found.easy

    def _shift(self, dt: float) -> None:
        """Lets the stiffness be that of a step of this length, inertia and damping in it."""
        if dt != self._length:
            self._length = dt
            self._K.shift = (self._mass + self.gamma * dt * self._drag) / (self.beta * dt * dt)
            self._known = False

    def _acceleration(self) -> Vector:
        """At the end of the step, of the displacement that is tried."""
        return (self._problem.u - self._predicted) / (self.beta * self._length * self._length)

    def _speed(self, clock: Clock) -> Vector:
        """Velocity at the end of the step; the prescribed one where there is one."""
        problem = self._problem
        v = self._gained + self.gamma * self._length * self._acceleration()
        for motion in problem.motions:
            if motion.when(clock):
                first, dimension = problem.places[motion.part].start, motion.part.dimension
                for axis, value in motion.speeds(clock):
                    v[first + motion.nodes * dimension + axis] = value
        return v

    def _residual(self, clock: Clock) -> float:
        """Norm of what is not balanced on the free unknowns, over that of internal forces and inertia."""
        self._evaluations += 1
        problem, a = self._problem, self._acceleration()
        if self._drag.any():
            self._set_velocity(self._gained + self.gamma * self._length * a)
        force, internal = problem.balance(clock)
        inertia = np.where(problem.fixed, 0.0, self._mass * a)
        self._force, self._rest = force, force - inertia
        self._internal = internal + float(np.linalg.norm(inertia))
        rest, size = float(np.linalg.norm(self._rest[~problem.fixed])), max(self._internal, LEAST * self._largest)
        return 0.0 if rest == 0.0 else rest / size if size > 0 else np.inf

    def _follow_work(self, u: Vector, v: Vector, force: Vector) -> None:
        """Work of the prescribed motions: mean reaction times displacement, and the kinetic energy of their nodes."""
        problem, now = self._problem, self._velocity
        for part, place in problem.places.items():
            if self.wants((part, external_work)):
                reaction = -0.5 * (force[place] + self._force[place]) * (problem.u[place] - u[place])
                kinetic = 0.5 * self._mass[place] * (now[place] ** 2 - v[place] ** 2)
                self[part, external_work][...] += float(np.sum((reaction + kinetic)[problem.fixed[place]]))


def _flat(arrays: Sequence[Any]) -> Vector:
    return arrays[0] if len(arrays) == 1 else np.concatenate(arrays)
