"""Contact: nodes that come too close to each other are pushed apart."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Part, Trigger, always, every
from rbs_core.part import Connection
from rbs_core.part.pairs import Pairs, pairs_among, pairs_between
from rbs_core.relation import Fields
from rbs_core.trigger import Clock
from rbs_plugins.boundary.search import Travel
from rbs_plugins.constitutive.bonded import per_density
from rbs_plugins.constitutive.pairwise import PairwiseForce
from rbs_plugins.fields import contact_distance, displacement, intact, volume

OFTEN = every(100)


def repulsion(length, contact_distance, stiffness):
    """Pairwise force of nodes that are nearer than they may be (Macek & Silling 2007; Parks et al. 2008)."""
    return stiffness * min(length / contact_distance - 1.0, 0.0)


def repulsion_potential(length, contact_distance, stiffness):
    """Its energy, ½ k d (1 − |y|/d)²: what two nodes give back when they part."""
    nearness = min(length / contact_distance - 1.0, 0.0)
    return 0.5 * stiffness * contact_distance * nearness * nearness


class ShortRangeRepulsion(PairwiseForce):
    """Nodes of two parts, or of one part where no bond holds them, repel each other when they are too close.

    Args:
        part: one part.
        other: the other one; None for the nodes of one part: faces of a crack that close, fragments that meet.
        stiffness: k of the pairwise force k (|y|/d − 1), N/m^6. About 15 c of the softer material is usual (Parks et
            al. 2008, with c the micromodulus of a bond-based one).
        distance: d, m; the mean spacing of the two parts if not given. Nodes of one part that are nearer to each other
            at rest, or when they are found after the bond between them has broken, repel each other from that distance
            on, so that nothing is pushed at once.
        skin: nodes are looked at as soon as they are nearer than d + skin, m; half of d if not given. A larger one
            means fewer searches of more pairs; results are the same but for round-off.
        search: within one part, when to search at least, if bonds have broken: until then these nodes do not repel
            each other. Otherwise a search comes by itself when the nodes have moved so far that it is needed.
        when: trigger.

    Raises:
        BadInput: on a stiffness, distance or skin that is not positive, or a distance that cannot be told.

    The force density is L_i = Σ_j k (|y|/d − 1) V_j y/|y| over the nodes j nearer than d, with y = y_j − y_i. Energy
    and momentum are kept. The stable step takes account of the nodes that may crowd into the ball of radius d.
    """

    @staticmethod
    def example(part: Part) -> dict[str, Any]:
        """So far that bonds broken by a notch are within it."""
        return {"stiffness": 1e18, "distance": 2.5 * (part.spacing or 1.0)}

    def __init__(
        self,
        part: Part,
        other: Part | None = None,
        *,
        stiffness: float,
        distance: float | None = None,
        skin: float | None = None,
        search: Trigger = OFTEN,
        when: Trigger = always,
    ) -> None:
        pair = Connection(part, other, pairs=np.empty((0, 2), np.int64), name=_name(part, other))
        pair.search_during_runs()
        self.distance = _mean_spacing(pair) if distance is None else distance
        self.skin = 0.5 * self.distance if skin is None else skin
        self.stiffness = stiffness
        for name in ("stiffness", "distance", "skin"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise BadInput(f"{pair.name}: {name}={value} must be positive and finite")
        if not isinstance(search, Trigger):
            raise BadInput(f"{pair.name}: search={search!r} must be a trigger such as every(100)")
        self._pair = pair
        self._room = -1.0  # m that the nodes may come until a search is due; at once
        self._held: Any = None  # which bonds held at the last search
        pair[contact_distance] = self.distance  # so that the law can ask for it
        super().__init__(pair, repulsion, potential=repulsion_potential, stiffness=stiffness, when=when)
        self._search = search

    @property
    def _own_bonds(self) -> bool:
        """True if there are bonds that keep nodes from repelling each other."""
        return len(self.ends) == 1 and self.part.connected

    @property
    def reads(self) -> Fields:  # type: ignore[override]
        """As every pairwise force, and the bonds of the part itself."""
        return (*super().reads, *([intact] if self._own_bonds else []))

    # -- search -----------------------------------------------------------------------------------------------------

    def attach(self) -> None:
        if not hasattr(self, "_travels"):
            self._travels = [Travel(end, self[end, displacement]) for end in self.ends]
        super().attach()

    def reset(self) -> None:
        super().reset()
        self._room = -1.0

    def begin(self, clock: Clock) -> None:
        if self._room < 0:
            self._find()
            self.attach()
        super().begin(clock)

    def apply(self, clock: Clock) -> None:
        ways = [travel.distance() for travel in self._travels]
        # of two parts both may have come, and within one any two of its nodes
        if sum(ways) * (3 - len(ways)) > self._room or self._broke(clock):
            self._find()
        super().apply(clock)

    def _broke(self, clock: Clock) -> bool:
        """True if it is time to look for bonds that have broken, and some have."""
        if not self._own_bonds or not self._search(clock):
            return False
        return not np.array_equal(self.part.raw(intact), self._held)

    def _find(self) -> None:
        """Takes the pairs that may come nearer than they may be before the next search."""
        before = self._places() if self._room >= 0 else None
        for travel in self._travels:
            travel.look()
        places = self._places()
        reach = self.distance + self.skin
        self._room = self.skin
        if len(places) == 2:
            pairs = pairs_between(places[0], places[1], reach)
            self._room = max(self.skin, self._travels[0].gap(self._travels[1]) - self.distance)
        else:
            pairs = self._free(pairs_among(places[0], reach))
        known = self._pair.pairs, self._distances()
        self._pair.take(pairs, [travel.seen for travel in self._travels])
        self._set_distances(*known, before)

    def _places(self) -> list[NDArray[np.float64]]:
        """Where the nodes were when somebody has looked, in the world."""
        return self._pair.places([travel.seen for travel in self._travels])

    def _free(self, pairs: Pairs) -> Pairs:
        """Those that no bond holds."""
        if not self._own_bonds:
            return pairs
        self._held = self.part.raw(intact).copy()
        return pairs[~self.part.bonds.holds(*pairs.T)]

    def _distances(self) -> NDArray[np.float64]:
        """(k,) contact distance of the pairs, of one part, m."""
        starts, ends = self._directed()
        return self._pair.raw(contact_distance)[starts < ends]

    def _directed(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Start and end of each directed bond, as nodes of the connection."""
        offsets, neighbors = self._pair.bonds.as_rows()
        return np.repeat(np.arange(len(self._pair)), np.diff(offsets)), neighbors.astype(np.int64)

    def _set_distances(
        self, pairs: Pairs, distances: NDArray[np.float64], before: list[NDArray[np.float64]] | None
    ) -> None:
        """Sets d; within one part no more than nodes have at rest, and for known pairs what they had.

        A pair that was as near at the last search, but not among the pairs, was bonded then: it gets the distance at
        which it is found, so that nothing is pushed at once.
        """
        if len(self.ends) == 2:
            self._pair[contact_distance] = self.distance
            return
        starts, ends = (self._pair.nodes[0][each] for each in self._directed())
        found = np.minimum(_apart(self.part.positions, starts, ends), self.distance)
        if before is not None:
            freed = _apart(before[0], starts, ends) < self.distance + self.skin
            found[freed] = np.minimum(found, self._pair.bonds.lengths)[freed]
        count = len(self.part)
        old = pairs[:, 0] * count + pairs[:, 1]
        now = np.minimum(starts, ends) * count + np.maximum(starts, ends)
        place = np.minimum(np.searchsorted(old, now), max(len(old) - 1, 0))
        if len(old):
            known = old[place] == now
            found[known] = distances[place[known]]
        self._pair[contact_distance] = found

    def state(self) -> dict[str, Any]:
        kept = {**super().state(), **self._pair.state(), "room": self._room}
        for number, travel in enumerate(self._travels):
            kept |= {f"seen {number}": travel.seen, f"began {number}": travel.began}
        return {**kept, "held": self._held} if self._own_bonds else kept

    def restore(self, state: dict[str, Any]) -> None:
        self._pair.restore(state)
        self._room, self._held = state["room"], state.get("held")
        for number, travel in enumerate(self._travels):
            travel.look(state[f"seen {number}"], state[f"began {number}"])

    # -- stable step ------------------------------------------------------------------------------------------------

    def stiffness_bounds(self) -> dict[Part, NDArray[np.float64]]:
        """Bound of the stiffness at each node, N/m^4: 2 k/d V for nodes V within d.

        Nodes that are packed as at rest fill the ball of radius d; it never holds less than two of the largest.
        """
        found = {}
        for end, other in zip(self.ends, reversed(self.ends), strict=True):
            crowd = max(_ball(self.distance, end), 2.0 * float(other[volume].max()))
            found[end] = np.full(len(end), 2.0 * self.stiffness / self.distance * crowd)
        return found

    def squared_frequencies(self) -> dict[Part, NDArray[np.float64]]:
        """Bound of the squared angular frequency at each node, 1/s^2, of the parts that have a density."""
        return per_density(self.stiffness_bounds())


def _name(part: Part, other: Part | None) -> str:
    names = [getattr(each, "name", repr(each)) for each in (part, other) if each is not None]
    return " against ".join(names if len(names) == 2 else [*names, "itself"])


def _apart(places: NDArray[np.float64], starts: NDArray[np.int64], ends: NDArray[np.int64]) -> NDArray[np.float64]:
    """Distances of pairs of nodes, m."""
    return np.asarray(np.linalg.norm(places[ends] - places[starts], axis=1))


def _mean_spacing(pair: Connection) -> float:
    spacings = [end.spacing for end in pair.ends if end.spacing is not None]
    if len(spacings) < len(pair.ends):
        raise BadInput(f"{pair.name}: say distance=, how near nodes may come: the parts do not know their spacing")
    return sum(spacings) / len(spacings)


def _ball(radius: float, part: Part) -> float:
    """Volume of the nodes in a ball, m^3."""
    unit = {1: 2.0 * (part.area or 1.0), 2: math.pi * (part.thickness or 1.0), 3: 4.0 / 3.0 * math.pi}
    return unit[part.dimension] * radius**part.dimension
