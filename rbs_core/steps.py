"""Doing the calls of a step, each with its time taken and its errors told with their place."""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence
from contextlib import nullcontext

from rbs_core.contract import Plan
from rbs_core.errors import DishonestRelation, NotFinite
from rbs_core.honesty import Watch, blamed, check_finite
from rbs_core.relation import Relation
from rbs_core.report import Row, log
from rbs_core.schedule import Call
from rbs_core.trigger import Clock


class Steps:
    """The steps of a run.

    Args:
        calls: of every step, in order.
        clock: advanced by every step.

    Attributes:
        rows: cost of each call.
        watch: compares what relations do with their contracts, for debugging; None (default) does not.
    """

    def __init__(self, calls: Sequence[Call], clock: Clock) -> None:
        self._clock = clock
        self.watch: Watch | None = None
        self.rows = [Row(call.label, nodes=call.node_items()) for call in calls]
        self._pairs = list(zip(calls, self.rows, strict=True))
        # asked once: the shortest steps take a few microseconds
        self.do = self._told if log.isEnabledFor(logging.DEBUG) else self._do

    def first_sums(self, relations: Sequence[Relation], plan: Plan) -> None:
        """Makes sums that a step takes over from the step before, once for the initial state (the initial forces).

        What writes the fields that they are made from runs in front of them, e.g. the dilatation of the initial state.
        """
        summed = {key for keys in plan.clear.values() for key in keys}
        needed = summed.intersection(plan.carried)
        chosen = []
        for position, relation in reversed(list(enumerate(relations))):
            made = set(relation.keys("writes", "adds"))
            if made & needed and relation.when(self._clock):
                chosen.append((position, relation))
                needed.update(relation.keys("reads"))
        for part, field in summed & needed:
            part.raw(field)[...] = 0
        for position, relation in reversed(chosen):
            self.apply(Call(position, [relation]))

    def _do(self) -> None:
        """The next step."""
        clock = self._clock
        clock.advance()
        for call, row in self._pairs:
            for array in call.cleared:
                array.fill(0)
            if not call.due(clock):
                continue
            start = time.perf_counter()
            self.apply(call)
            row.seconds += time.perf_counter() - start
            row.calls += 1
            row.items += call.items()
            row.visited += call.visited()

    def _told(self) -> None:
        """The next step, and a message about it."""
        before = [(row.calls, row.seconds) for row in self.rows]
        start = time.perf_counter()
        self._do()
        seconds = time.perf_counter() - start
        each = [
            f"{position} {row.name} {(row.seconds - earlier) * 1e3:.3g} ms"
            for position, (row, (calls, earlier)) in enumerate(zip(self.rows, before, strict=True))
            if row.calls > calls
        ]
        clock = self._clock
        log.debug(
            "step %d, time %.6g s: %.3g ms (%s)", clock.step, clock.time, seconds * 1e3, ", ".join(each) or "no calls"
        )

    def apply(self, call: Call) -> None:
        """One call.

        Raises:
            NotFinite, DishonestRelation: with the step and the relation.
        """
        clock, watch, relation = self._clock, self.watch, call.relations[0]
        try:
            if watch is not None:
                watch.before(relation)
            if relation.role == "exporter":
                check_finite(relation.keys("reads"))
            with nullcontext() if watch is None else blamed(relation):
                call.apply(clock)
            if watch is not None:
                watch.after(relation)
        except (NotFinite, DishonestRelation) as error:
            where = f"step {clock.step} (time {clock.time:.6g} s), relation {call.position} ({call.label})"
            raise type(error)(f"{where}: {error}") from None
