"""BoundaryDomain: nodes whose motion is prescribed, or on which a load acts."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Boundary, Everywhere, Field, Part, Trigger, always
from rbs_core.trigger import Clock
from rbs_plugins.boundary.values import Component, Values
from rbs_plugins.fields import density, displacement, external_work, force_density, velocity, volume

KINDS = ("velocity", "displacement", "force", "body_force")


class BoundaryDomain(Boundary):
    """Prescribes motion or load on some nodes; exactly one of the four kinds.

    Args:
        part: the part.
        region: geometry, mask (n,), indices, function of the positions, or name of a node set.
        velocity: m/s. Stands between kick and drift; a function of time is taken at mid-step there (so the drift is of
            second order), and at the end of the step where the domain is listed a second time.
        displacement: m. Sets the velocity with which the drift of this step arrives there; where the domain is listed a
            second time, that of the end of the step, by a central difference of what is prescribed.
        force: N. A number is the total on the region, shared out by volume; an array is the force on each node.
        body_force: N/m^3.
        when: trigger.

    Each takes one entry per component: None (free), a number, an array with one number per node of the region (in
    ascending order of nodes) or a function of (time) or (time, positions); or a function that returns all components.
    Functions depend on nothing but their arguments: they are called at other times than those of the run, too. The
    components of a displacement are the same at all times.

    Raises:
        BadInput: on no or several kinds, a region without nodes, or values of a wrong shape or not finite; at the start
            of the run if another motion prescribes something else for the same component of the same node.

    Its work on the part is offered as `external_work`. For a motion it is the impulse that turns the kicked velocity
    into the prescribed one, times the mean of the prescribed velocity before and after (which makes the energy balance
    of velocity Verlet close to second order); for a load the trapezoidal rule along the path.
    """

    example = {"region": Everywhere(), "velocity": lambda time, positions: 0.0 * positions}

    def __init__(
        self,
        part: Part,
        region: Any,
        *,
        velocity: Any = None,
        displacement: Any = None,
        force: Any = None,
        body_force: Any = None,
        when: Trigger = always,
    ) -> None:
        super().__init__(part, when=when)
        given = dict(zip(KINDS, (velocity, displacement, force, body_force), strict=True))
        named = [kind for kind, value in given.items() if value is not None]
        if len(named) != 1:
            raise BadInput(f"{self.label}: prescribe exactly one of {', '.join(KINDS)}, got {named or 'none'}")
        self.kind = named[0]
        self.nodes = part.where(region)
        if not len(self.nodes):
            raise BadInput(f"{self.label}: no node lies in {region!r}: check the region or the spacing")
        owner, steady = f"{self.label}, {self.kind}", self.kind == "displacement"
        self._values = Values(owner, given[self.kind], part.positions[self.nodes], steady)
        self.hold = False  # True while a static solver tries displacements that are no path to do work on
        self._digest = self._values.digest()  # now: during a run functions are not asked about other times
        self.reset()

    @property
    def moves(self) -> bool:
        """True for a prescribed motion, False for a load."""
        return self.kind in ("velocity", "displacement")

    # -- contract ---------------------------------------------------------------------------------------------------

    @property
    def reads(self) -> tuple[Field, ...]:  # type: ignore[override]
        """What the kind and the work need."""
        return (displacement, density, volume) if self.moves else (displacement, volume)

    @property
    def updates(self) -> tuple[Field, ...]:  # type: ignore[override]
        """Velocity, for a motion."""
        return (velocity,) if self.moves else ()

    @property
    def adds(self) -> tuple[Field, ...]:  # type: ignore[override]
        """Force density, for a load."""
        return () if self.moves else (force_density,)

    offers = (external_work,)

    def identity(self) -> dict[str, Any]:
        """The parameters, the nodes that were found and what is prescribed on them at a few times."""
        return {**self.parameters, "nodes": self.nodes, "values": self._digest}

    def node_items(self) -> int:
        return len(self.nodes)

    def reset(self) -> None:
        self._step = -1
        self._before: dict[str, NDArray[np.float64]] = {}

    # -- work -------------------------------------------------------------------------------------------------------

    def attach(self) -> None:
        self._u = self[displacement]
        self._size = self[volume][self.nodes]
        self._works = self.wants(external_work)
        if self._works and self.when != always:
            raise BadInput(
                f"{self.label}: its work can only be followed if it acts in every step, not when={self.when}: let the "
                "prescribed value depend on time instead"
            )
        if self.moves:
            self._check_others()
            self._v, self._mass = self[velocity], self[density][self.nodes] * self._size
        else:
            self._f = self[force_density]

    def _check_others(self) -> None:
        """Compares with the motions listed in front of it; those with a trigger may take turns.

        Raises:
            BadInput: if one prescribes something else for the same component of the same node.
        """
        for other in self._scene:
            if other is self:
                return
            if isinstance(other, BoundaryDomain) and other.part is self.part and other.moves:
                clash = self._clash(other) if self.when == other.when == always else None
                if clash is not None:
                    raise BadInput(
                        f"{self!r} and {other!r} prescribe different motions: component {clash[0]} of the node at "
                        f"{clash[1]}: take the node out of one of the regions"
                    )

    def _clash(self, other: BoundaryDomain) -> tuple[int, list[float]] | None:
        """Component and position of a node for which two motions want something else at one of a few times."""
        both, mine, theirs = np.intersect1d(self.nodes, other.nodes, assume_unique=True, return_indices=True)
        if not len(both):
            return None
        for here, there in zip(self._values.samples(), other._values.samples(), strict=True):
            known = dict(there)
            for axis, value in here:
                if axis in known:
                    one = np.broadcast_to(value, self.nodes.shape)[mine]
                    two = np.broadcast_to(known[axis], other.nodes.shape)[theirs]
                    different = both[(one != two) | (self.kind != other.kind)]
                    if len(different):
                        return axis, self.part.positions[different[0]].tolist()
        return None

    def begin(self, clock: Clock) -> None:
        if self._works and not self._before:
            if self.moves:
                self._before = {"value": self._v[self.nodes]}
            else:
                self._before = {"path": self._u[self.nodes], "value": self._load(clock.time)}

    def apply(self, clock: Clock) -> None:
        if self.moves:
            self._move(clock)
        else:
            self._push(clock)

    def _move(self, clock: Clock) -> None:
        again, self._step = clock.step == self._step, clock.step
        for axis, target in self._targets(clock, again):
            kicked = self._v[self.nodes, axis]
            if self._works:
                mean = 0.5 * (self._before["value"][:, axis] + target)
                self[external_work][...] += np.sum(self._mass * (target - kicked) * mean)
                self._before["value"][:, axis] = target
            self._v[self.nodes, axis] = target

    def _targets(self, clock: Clock, again: bool) -> list[Component]:
        """Velocities to set: (axis, values)."""
        if self.kind == "velocity":
            return self._values.at(clock.time if again else clock.time - 0.5 * clock.dt)
        if again:  # at the end of the step: the mean of the step before and the step to come, both as prescribed
            past, future = (dict(self._values.at(clock.time + shift)) for shift in (-clock.dt, clock.dt))
            return [(axis, (future[axis] - past[axis]) / (2.0 * clock.dt)) for axis in future]
        goal = self._values.at(clock.time)
        return [(axis, (there - self._u[self.nodes, axis]) / clock.dt) for axis, there in goal]

    def prescribed(self, start: float, end: float) -> list[Component]:
        """(axis, values (k,)), m, of a motion: the displacement at the end, or what a velocity adds from the start."""
        if self.kind == "velocity":
            return [(axis, (end - start) * value) for axis, value in self._values.at(0.5 * (start + end))]
        return self._values.at(end)

    def speeds(self, clock: Clock) -> list[Component]:
        """(axis, values (k,)), m/s, of a motion at the end of a step."""
        return self._targets(clock, True)

    def _load(self, time: float) -> NDArray[np.float64]:
        """(k, d) force per volume on the nodes."""
        load = np.zeros((len(self.nodes), self.part.dimension))
        for axis, value in self._values.entries(time):
            if self.kind == "force":  # a number is the total, an array the force on each node
                value = value / (self._size if value.ndim else self._size.sum())
            load[:, axis] = value
        return load

    def _push(self, clock: Clock) -> None:
        load = self._load(clock.time)
        self._f[self.nodes] += load
        if self._works and not self.hold:
            path = self._u[self.nodes]
            mean = 0.5 * (self._before["value"] + load)
            self[external_work][...] += np.sum(self._size[:, None] * mean * (path - self._before["path"]))
            self._before = {"path": path, "value": load}

    def state(self) -> dict[str, Any]:
        return dict(self._before)

    def restore(self, state: dict[str, Any]) -> None:
        self._before = {name: np.array(value) for name, value in state.items()}
