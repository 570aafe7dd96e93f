"""Explicit time integration as visible parts: kicks change velocities, drifts change displacements."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import ClassVar

import numpy as np

from rbs_core import BadInput, Boundary, Integrator, Part, Relation, Trigger, always
from rbs_core.trigger import Clock
from rbs_plugins.fields import density, displacement, force_density, velocity
from rbs_plugins.loops import BATCH_BELOW, Loop, Text, flat
from rbs_plugins.loops.nodes import add_divided, add_scaled


def _adding(out: np.ndarray, a: np.ndarray) -> Loop:
    """The loop out += factor * a."""
    return Loop(Text.of(add_scaled), "add_scaled", {"out": flat(out), "a": flat(a), "factor": 1.0}, out.size)


class Kick(Integrator):
    """Velocity from force: v += share · dt · f / ρ.

    Args:
        part: the part that moves.
        share: of the time step.
        when: trigger.

    Raises:
        BadInput: at the start of the run, if a density is not positive.
    """

    example = {}
    reads = (force_density, density)
    updates = (velocity,)

    def __init__(self, part: Part, share: float = 1.0, *, when: Trigger = always) -> None:
        super().__init__(part, when=when)
        self.share = share

    def attach(self) -> None:
        mass = self[density]
        bad = np.flatnonzero(~(mass > 0))
        if len(bad):
            where = self.part.positions[bad[0]].tolist()
            raise BadInput(f"{self.label}: the density of node {bad[0]} at {where} is {mass[bad[0]]}, not positive")
        uniform = self.constant(density)
        if uniform is not None:
            self._scale = self.share / uniform
            self._loop = _adding(self[velocity], self[force_density])
        else:
            self._scale = self.share
            v = self[velocity]
            arrays = {"out": v, "a": self[force_density], "divisor": mass, "factor": 1.0}
            self._loop = Loop(Text.of(add_divided), "add_divided", arrays, len(mass), v.size)

    def apply(self, clock: Clock) -> None:
        self._loop.set(factor=self._scale * clock.dt)
        self._loop()

    def batch_key(self) -> Hashable:
        return ("kick", self._loop.kind) if len(self.part) < BATCH_BELOW else None

    def batch(self, relations: Sequence[Relation]) -> Callable[[Clock], None]:
        kicks = [each for each in relations if isinstance(each, Kick)]
        loop, scales = kicks[0]._loop.merged([each._loop for each in kicks[1:]]), np.array([k._scale for k in kicks])

        def apply(clock: Clock) -> None:
            loop.set(factor=scales * clock.dt)
            loop()

        return apply


class Drift(Integrator):
    """Displacement from velocity: u += dt · v."""

    example = {}
    reads = (velocity,)
    updates = (displacement,)

    def attach(self) -> None:
        self._loop = _adding(self[displacement], self[velocity])

    def apply(self, clock: Clock) -> None:
        self._loop.set(factor=clock.dt)
        self._loop()

    def batch_key(self) -> Hashable:
        return ("drift", self._loop.kind) if len(self.part) < BATCH_BELOW else None

    def batch(self, relations: Sequence[Relation]) -> Callable[[Clock], None]:
        drifts = [each for each in relations if isinstance(each, Drift)]
        loop = drifts[0]._loop.merged([each._loop for each in drifts[1:]])

        def apply(clock: Clock) -> None:
            loop.set(factor=clock.dt)
            loop()

        return apply


class VelocityVerlet:
    """Velocity Verlet: half kick, drift, forces, half kick; second order, energy bounded (Swope et al. 1982).

    Args:
        part: the part that moves.

    `kick` and `drift` are relations to list; `step` lists them for the common case. At the end of a step displacement,
    velocity and force belong to the same time.
    """

    order: ClassVar[int] = 2

    def __init__(self, part: Part) -> None:
        self.part = part
        self.kick = Kick(part, share=0.5)
        self.drift = Drift(part)

    def step(self, forces: Sequence[Relation], boundaries: Sequence[Boundary] = ()) -> list[Relation]:
        """The relations of one time step.

        Prescribed motions stand behind both kicks, so that exported velocities are the prescribed ones; loads
        (boundary domains that add to the force) stand beside the forces.
        """
        motions, loads = _split(boundaries)
        return [self.kick, *motions, self.drift, *loads, *forces, self.kick, *motions]


class SymplecticEuler:
    """Symplectic (semi-implicit) Euler: forces, full kick, drift; first order, energy bounded.

    At the end of a step displacement and velocity belong to the new time, the force to the one before.
    """

    order: ClassVar[int] = 1

    def __init__(self, part: Part) -> None:
        self.part = part
        self.kick = Kick(part, share=1.0)
        self.drift = Drift(part)

    def step(self, forces: Sequence[Relation], boundaries: Sequence[Boundary] = ()) -> list[Relation]:
        """The relations of one time step."""
        motions, loads = _split(boundaries)
        return [*loads, *forces, self.kick, *motions, self.drift]


def _split(boundaries: Sequence[Boundary]) -> tuple[list[Boundary], list[Boundary]]:
    """Motions (which change velocities) and loads (which add to the force)."""
    loads = [each for each in boundaries if force_density in each.adds]
    return [each for each in boundaries if each not in loads], loads
