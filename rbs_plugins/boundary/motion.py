"""Solid motion: a part moves as a whole, because its coordinate system does."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core import BadInput, Boundary, CoordinateSystem, Everywhere, Part, Trigger, always, world
from rbs_core.space import Cartesian
from rbs_core.trigger import Clock

Vector = NDArray[np.float64]


class SolidMotion(Boundary):
    """What translation and rotation have in common: the system of a part is moved, and everything below it.

    Args:
        part: a part in a system of its own, not in the world.
        system: another one above it that shall be moved instead.
        when: trigger.

    Displacements and velocities of the nodes are those within the part; nobody computes them for a rigid tool. Other
    parts notice the motion where a connection, or contact, joins them to this one.

    Several motions of one system add up: each goes on from where the one before has led.
    """

    stays = True

    def __init__(self, part: Part, *, system: CoordinateSystem | None = None, when: Trigger = always) -> None:
        super().__init__(part, when=when)
        self.system = part.system if system is None else system
        above: CoordinateSystem | None = part.system
        while above is not None and above is not self.system:
            above = above.parent
        if above is None:
            raise BadInput(f"{self.label}: {self.system!r} is neither the system of the part nor above it")
        if self.system.parent is None or not isinstance(self.system.mapping, Cartesian):
            raise BadInput(
                f"{self.label}: the part lives in {self.system!r}, which cannot be moved: make it in one of its own, "
                "Part(..., system=world.child('tool'))"
            )
        self._first: Cartesian = self.system.mapping
        self._done = 0.0  # s

    def advance(self, begin: float, end: float) -> None:
        """Moves the system as from one time to another, s; for a subclass to say."""
        raise NotImplementedError

    def reset(self) -> None:
        self.system.mapping, self._done = self._first, 0.0

    def apply(self, clock: Clock) -> None:
        self.advance(self._done, clock.time)
        self._done = clock.time
        moved: Any = self.system.mapping
        # made anew, so that nothing is known but what a checkpoint holds
        self.system.mapping = Cartesian(moved.origin, moved.axes)

    def state(self) -> dict[str, Any]:
        mapping: Any = self.system.mapping
        return {"done": self._done, "origin": np.array(mapping.origin), "axes": np.array(mapping.axes)}

    def restore(self, state: dict[str, Any]) -> None:
        self.system.mapping, self._done = Cartesian(state["origin"], state["axes"]), state["done"]


class Translation(SolidMotion):
    """Shifts a part.

    Args:
        part: a part in a system of its own.
        velocity: (d,) m/s; or a function of time that gives it.
        acceleration: (d,) m/s^2, beside a velocity at the beginning or instead.
        displacement: function of time, s, that gives (d,) the whole way, m; instead of the other two.
        system: as for every motion.
        when: trigger.

    Vectors are in coordinates of the system's parent, the world for instance.

    Raises:
        BadInput: unless the motion is given in one way, with as many finite components as the part has dimensions.
    """

    @staticmethod
    def example(part: Part) -> dict[str, Any]:
        """A part of its own that sets off and gets faster."""
        along = np.eye(part.dimension)[0]
        return {"part": _movable(part), "velocity": 3.0 * along, "acceleration": 2.0 * along}

    def __init__(
        self,
        part: Part,
        *,
        velocity: ArrayLike | Callable[[float], ArrayLike] | None = None,
        acceleration: ArrayLike | None = None,
        displacement: Callable[[float], ArrayLike] | None = None,
        system: CoordinateSystem | None = None,
        when: Trigger = always,
    ) -> None:
        super().__init__(part, system=system, when=when)
        self._way = _way(self.label, (velocity, acceleration, displacement), "velocity, acceleration, displacement",
                         part.dimension)  # fmt: skip

    def advance(self, begin: float, end: float) -> None:
        self.system.translate(self._way(begin, end))


class Rotation(SolidMotion):
    """Turns a part about an axis that moves along with it.

    Args:
        part: a part in a system of its own, 2-D or 3-D.
        velocity: angular velocity, rad/s; or a function of time that gives it.
        acceleration: angular acceleration, rad/s^2, beside a velocity at the beginning or instead.
        angle: function of time, s, that gives the whole angle, rad; instead of the other two.
        axis: (3,) direction in coordinates of the system, by the rule of the right hand; z if not given.
        center: (d,) a point of the axis in coordinates of the system, m; its origin if not given.
        system: as for every motion.
        when: trigger.

    Raises:
        BadInput: unless the motion is given in one way, by finite numbers; on a 1-D part, an axis without length, or
            one that leads out of the plane of a 2-D part.
    """

    @staticmethod
    def example(part: Part) -> dict[str, Any] | None:
        """A part of its own that turns about its origin."""
        return None if part.dimension == 1 else {"part": _movable(part), "velocity": 3.0}

    def __init__(
        self,
        part: Part,
        *,
        velocity: float | Callable[[float], float] | None = None,
        acceleration: float | None = None,
        angle: Callable[[float], float] | None = None,
        axis: ArrayLike = (0.0, 0.0, 1.0),
        center: ArrayLike | None = None,
        system: CoordinateSystem | None = None,
        when: Trigger = always,
    ) -> None:
        super().__init__(part, system=system, when=when)
        if part.dimension == 1:
            raise BadInput(f"{self.label}: a 1-D part has nothing to turn in")
        self._way = _way(self.label, (velocity, acceleration, angle), "velocity, acceleration, angle", None)
        self._axis = _vector(f"{self.label}: axis", axis, 3)
        self._center = np.zeros(3)
        if center is not None:
            self._center[: part.dimension] = _vector(f"{self.label}: center", center, part.dimension)
        if not self._axis.any():
            raise BadInput(f"{self.label}: axis={self._axis.tolist()} has no length")
        if part.dimension == 2 and self._axis[:2].any():
            raise BadInput(f"{self.label}: axis={self._axis.tolist()}, but a 2-D part can only turn about z")

    def advance(self, begin: float, end: float) -> None:
        mapping: Any = self.system.mapping
        center = mapping.to_parent(self._center[None, :])[0]
        self.system.rotate(float(self._way(begin, end)[0]), axis=self._axis @ mapping.axes, center=center)


def _movable(part: Part) -> Part:
    """One node in a system of its own: something that can be moved, for the examples."""
    tool = Part("tool", Everywhere(), dimension=part.dimension, system=world.child("tool"))
    return tool.place(np.zeros((1, part.dimension)), 1.0)


def _way(owner: str, given: Sequence[Any], names: str, size: int | None) -> Callable[[float, float], Vector]:
    """Function that gives the way, or the angle, between two times.

    Args:
        owner: for messages.
        given: rate, its rate, and the whole as a function of time; some of them None.
        names: of these.
        size: number of components, None for an angle.
    """
    rate, growth, whole = given
    if all(each is None for each in given) or (whole is not None and (rate is not None or growth is not None)):
        raise BadInput(f"{owner}: give {names.rpartition(', ')[0]} (or both), or {names.rpartition(', ')[2]}")
    if whole is not None and not callable(whole):
        raise BadInput(f"{owner}: {names.rpartition(', ')[2]}={whole!r} must be a function of time")
    if callable(rate) and growth is not None:
        raise BadInput(f"{owner}: a velocity that is a function of time leaves nothing for an acceleration to say")

    def at(function: Callable[[float], Any], time: float) -> Vector:
        return _vector(f"{owner}: at time {time:g} s", function(time), size)

    if whole is not None:
        at(whole, 0.0)
        return lambda begin, end: at(whole, end) - at(whole, begin)
    if callable(rate):
        at(rate, 0.0)
        # Simpson's rule: exact for velocities that are cubic in time
        return lambda begin, end: (end - begin) / 6.0 * (
            at(rate, begin) + 4.0 * at(rate, 0.5 * (begin + end)) + at(rate, end)
        )  # fmt: skip
    zero = np.zeros(size or 1)
    first = zero if rate is None else _vector(f"{owner}: velocity", rate, size)
    second = zero if growth is None else _vector(f"{owner}: acceleration", growth, size)
    return lambda begin, end: (end - begin) * (first + 0.5 * (end + begin) * second)


def _vector(owner: str, value: Any, size: int | None) -> Vector:
    try:
        found = np.atleast_1d(np.asarray(value, np.float64))
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.shape != (size or 1,) or not np.isfinite(found).all():
        wanted = "a finite number" if size in (None, 1) else f"{size} finite numbers"
        raise BadInput(f"{owner}: must be {wanted}, got {value!r}")
    return found
