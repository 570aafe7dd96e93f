"""Where a crack ends, and how fast it grows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core import BadInput, Field, Measure, Part, Trigger, always
from rbs_core.trigger import Clock
from rbs_plugins.fields import crack_tip, crack_tip_speed, damage, reference_position
from rbs_plugins.measures.places import place_for

THRESHOLD = 0.3  # beside a straight crack through a square grid at m = 3 a node has lost 11 of 28 bonds, 0.39


class CrackTip(Measure):
    """Position and speed of the tip of a crack: of the nodes of a region, the damaged one foremost in a direction.

    Args:
        part: the part; a relation such as Damage writes its damage in front of this one.
        direction: (d,) in which the crack grows; its length does not matter.
        threshold: nodes with more damage than this belong to the crack, between 0 and 1.
        within: geometry, mask, indices or node set to which the crack is confined; the body of the part if not given.
        start: (d,) tip before any node is damaged, m; the origin if not given.
        window: over how many looks the speed is taken, at least 2.
        position: where to write the tip; another vector field of parts if there are several tips.
        speed: where to write its speed.
        when: trigger.

    Raises:
        BadInput: on a direction without length, a threshold or window out of range, a region without nodes, or fields
            that are not those of a part.

    The tip is the mean of the damaged nodes that lie as far in the direction as the foremost one, to a thousandth of a
    spacing, and within a horizon of it: nodes on both sides of a crack share it. Nodes right at the end of a cut have
    lost few bonds, so with the default threshold and m = 3 the tip trails it by up to 1.5 spacings. Positions are those
    of the reference configuration. The speed is the slope of a straight line through the last `window` looks at
    position·direction, 0 at the first one; on a grid a tip moves by whole spacings, so a window should see it pass
    several.

    A crack that branches has a tip per branch: give each a CrackTip with a region (`within`) of its own and fields of
    its own. Without, the foremost branch counts, and the field jumps from one to the other when they take turns.
    """

    reads = (damage, reference_position)

    @staticmethod
    def example(part: Part) -> dict[str, Any]:
        """Along the first axis."""
        return {"direction": np.eye(part.dimension)[0].tolist()}

    def __init__(
        self,
        part: Part,
        direction: ArrayLike,
        *,
        threshold: float = THRESHOLD,
        within: Any = None,
        start: ArrayLike | None = None,
        window: int = 5,
        position: Field = crack_tip,
        speed: Field = crack_tip_speed,
        when: Trigger = always,
    ) -> None:
        super().__init__(part, when=when)
        self.direction = unit_vector(self.label, "direction", direction, part.dimension)
        self.start = np.zeros(part.dimension) if start is None else point(self.label, "start", start, part.dimension)
        self.threshold = checked_threshold(self.label, threshold)
        if not (isinstance(window, int) and window >= 2):
            raise BadInput(f"{self.label}: window={window!r} must be a whole number of looks, at least 2")
        self.nodes = part.body if within is None else part.where(within)
        if not len(self.nodes):
            raise BadInput(f"{self.label}: no node lies in {within!r}: check the region or the spacing")
        self.window = window
        self.position = place_for(self.label, position, crack_tip)
        self.speed = place_for(self.label, speed, crack_tip_speed)
        self.writes = (position, speed)
        self.reset()

    def reset(self) -> None:
        self._times: NDArray[np.float64] = np.zeros(0)
        self._places: NDArray[np.float64] = np.zeros(0)

    def state(self) -> dict[str, Any]:
        return {"times": self._times, "places": self._places}

    def restore(self, state: dict[str, Any]) -> None:
        self._times, self._places = np.asarray(state["times"]), np.asarray(state["places"])

    def apply(self, clock: Clock) -> None:
        broken = self.nodes[self[damage][self.nodes] > self.threshold]
        tip = self._foremost(self[reference_position][broken]) if len(broken) else self.start
        self._times = np.append(self._times, clock.time)[-self.window :]
        self._places = np.append(self._places, tip @ self.direction)[-self.window :]
        self[self.position][...] = tip
        self[self.speed][...] = slope(self._times, self._places)

    def _foremost(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        along = points @ self.direction
        first = int(np.argmax(along))
        reach = self.part.bonds.horizon if self.part.connected else np.inf
        exact = 1e-3 * (self.part.spacing or 0.0)
        equal = along >= along[first] - exact
        near = np.linalg.norm(points - points[first], axis=1) <= reach
        return np.asarray(points[equal & near].mean(axis=0))


def slope(times: NDArray[np.float64], values: NDArray[np.float64]) -> float:
    """Slope of the straight line of least squares; 0 if there is only one time."""
    from_mean = times - times.mean()
    moment = float(from_mean @ from_mean)
    return float(from_mean @ (values - values.mean())) / moment if moment > 0 else 0.0


def point(label: str, name: str, values: ArrayLike, dimension: int) -> NDArray[np.float64]:
    """A place or direction (d,).

    Raises:
        BadInput: on other shapes, and numbers that are not finite.
    """
    try:
        found = np.atleast_1d(np.asarray(values, np.float64))
    except (TypeError, ValueError):
        found = np.zeros(0)
    if found.shape != (dimension,) or not np.isfinite(found).all():
        raise BadInput(f"{label}: {name}={values!r} must be {dimension} finite numbers")
    return found


def unit_vector(label: str, name: str, values: ArrayLike, dimension: int) -> NDArray[np.float64]:
    """A direction (d,) of length 1.

    Raises:
        BadInput: as `point`, and on one without length.
    """
    found = point(label, name, values, dimension)
    size = float(np.linalg.norm(found))
    if size == 0:
        raise BadInput(f"{label}: {name}={values!r} has no length")
    return found / size


def checked_threshold(label: str, threshold: float) -> float:
    """A damage between 0 and 1.

    Raises:
        BadInput: if it is not.
    """
    if not (isinstance(threshold, int | float) and 0 <= threshold < 1):
        raise BadInput(f"{label}: threshold={threshold!r} must be a damage, at least 0 and below 1")
    return float(threshold)
