"""What relations hold before an attempt, so that it can be taken back, with the bonds that have failed in it."""

from __future__ import annotations

from copy import deepcopy

from rbs_core import Relation
from rbs_core.trigger import Clock


class Kept:
    """The fields that a relation and those that it owns change in place, and what the latter keep beside them.

    Args:
        relation: attached; not changed by this.
    """

    def __init__(self, relation: Relation) -> None:
        self._owned = relation.owns
        keys = [*relation.keys("updates"), *filter(relation.wants, relation.keys("offers"))]
        arrays = [relation.raw(key) for key in keys]
        self._fields = [(array, array.copy()) for array in arrays]
        self._states = [deepcopy(each.state()) for each in self._owned]

    def take_back(self, clock: Clock) -> None:
        """Everything is as it was."""
        for array, before in self._fields:
            array[...] = before
        for each, state in zip(self._owned, self._states, strict=True):
            each.reset()
            each.restore(state)
            each.begin(clock)
