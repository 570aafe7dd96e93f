"""Viscous damping: a resistance in proportion to the velocity."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core import BadInput, Boundary, Part, Trigger, always
from rbs_core.trigger import Clock
from rbs_plugins.fields import density, displacement, force_density, velocity, viscous_dissipation, volume
from rbs_plugins.loops import Loop, Text
from rbs_plugins.loops.loop import CHUNK
from rbs_plugins.loops.nodes import chunks, resist, sum_resistance


class ViscousDamping(Boundary):
    """Resistance −c v against any motion, as of dashpots between the nodes and the ground.

    Args:
        part: the part that is damped.
        coefficient: c, N s/m^4 (force density per velocity): a number, or one per node (n,).
        ratio: damping ratio ζ instead, of a mode that swings with `frequency`: c = 2 ζ ω ρ. 1 is critical.
        frequency: angular frequency ω of that mode, rad/s.
        when: trigger.

    Raises:
        BadInput: unless either a coefficient, or ratio and frequency are given, none of them negative.

    Stands beside the forces: `step(forces, boundaries=[damping])`. In velocity Verlet it sees the velocity of the
    middle of the step, so the damping is good to first order in dt, and the stable step of a mode that swings with ω
    is 2/ω (sqrt(1 + ζ²) − ζ), shorter than without (Belytschko, Liu & Moran 2000, chapter 6). `stable_dt` knows this;
    it takes the largest ω and the largest c/ρ of all nodes. The work that it takes, by the trapezoidal rule along the
    path, is offered as `viscous_dissipation`.
    """

    example = {"coefficient": 1e8}
    reads = (velocity, density, displacement, volume)
    adds = (force_density,)
    offers = (viscous_dissipation,)

    def __init__(
        self,
        part: Part,
        coefficient: ArrayLike | None = None,
        *,
        ratio: float | None = None,
        frequency: float | None = None,
        when: Trigger = always,
    ) -> None:
        super().__init__(part, when=when)
        if (ratio is None) != (frequency is None) or (coefficient is None) == (ratio is None):
            raise BadInput(f"{self.label}: give either a coefficient, or a ratio and the frequency it is meant for")
        for name, value in (("ratio", ratio), ("frequency", frequency)):
            if value is not None and not (math.isfinite(value) and value >= 0):
                raise BadInput(f"{self.label}: {name}={value} must be finite and not negative")
        if coefficient is not None:
            given = np.asarray(coefficient, np.float64)
            if given.shape not in ((), (len(part),)) or not (np.isfinite(given) & (given >= 0)).all():
                raise BadInput(
                    f"{self.label}: the coefficient must be one number or ({len(part)},), finite and not negative"
                )
        self._given = coefficient, ratio, frequency
        self.hold = False  # True while an implicit solver tries velocities that are no path to do work on
        self.reset()

    def reset(self) -> None:
        self._before: dict[str, NDArray[Any]] = {}

    @property
    def coefficients(self) -> NDArray[np.float64]:
        """(n,) c of each node, N s/m^4."""
        coefficient, ratio, frequency = self._given
        if ratio is None or frequency is None:
            return np.broadcast_to(np.asarray(coefficient, np.float64), (len(self.part),)).copy()
        return np.asarray(2.0 * ratio * frequency * self.part[density], np.float64)

    def attach(self) -> None:
        self._works = self.wants(viscous_dissipation)
        if self._works and self.when != always:
            raise BadInput(f"{self.label}: its work can only be followed if it acts in every step")
        u, v = self[displacement], self[velocity]
        arrays = {"out": self[force_density], "velocity": v, "coefficient": self.coefficients}
        self._loop = Loop(Text.of(resist), "resist", arrays, len(u), u.size)
        if self._works:
            self._room = {"path": np.empty_like(u), "past": np.empty_like(v)}
            self._partial = chunks(len(u))
            arrays |= {"displacement": u, "volume": self[volume], "partial": self._partial, **self._room}
            self._work = Loop(Text.of(sum_resistance), "sum_resistance", {**arrays, "chunk": CHUNK}, len(u), u.size)

    def begin(self, clock: Clock) -> None:
        if self._works:
            here = self._before or {"path": self[displacement], "past": self[velocity]}
            for name, room in self._room.items():
                room[...] = here[name]
            self._before = self._room

    def apply(self, clock: Clock) -> None:
        self._loop()
        if self._works and not self.hold:
            self._work()
            self[viscous_dissipation][...] += self._partial.sum()

    def state(self) -> dict[str, Any]:
        return dict(self._before)

    def restore(self, state: dict[str, Any]) -> None:
        self._before = {name: np.array(value) for name, value in state.items()}

    def squared_frequency(self) -> NDArray[np.float64] | None:
        """What the damping of this part adds to the squared frequency of its forces, 1/s^2.

        With γ = c/ρ the step is 2/Ω, Ω = sqrt(ω² + γ²/4) + γ/2. It depends on ω, so the first damping of a part speaks
        for all.
        """
        every = [each for each in dict.fromkeys(self._scene) if each.part is self.part]
        damping = [each for each in every if isinstance(each, ViscousDamping)] or [self]
        if damping[0] is not self or density not in self.part:
            return None
        rate = np.max(sum(each.coefficients for each in damping) / self.part[density], initial=0.0)
        others: Any = 0.0
        for relation in dict.fromkeys(self._scene):
            if not isinstance(relation, ViscousDamping):
                others = others + relation.squared_frequencies().get(self.part, 0.0)
        most = float(np.max(others))
        more = rate * rate / 2.0 + rate * math.sqrt(most + rate * rate / 4.0)
        return np.full(len(self.part), float(more))

    @property
    def nbytes(self) -> int:
        """Coefficients, and what the work needs of the step before."""
        return 8 * len(self.part) + sum(array.nbytes for array in self._before.values())
