"""In which calls a step is done: one for each relation, or one for many that do the same on small parts.

Relations whose contracts do not touch each other may trade places: kicks of two parts, for instance. So a list that
goes part by part can be done kind by kind, and a thousand small parts cost one call instead of a thousand.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby
from typing import Any

from numpy.typing import NDArray

from rbs_core.relation import Key, Relation
from rbs_core.trigger import Clock, always


@dataclass
class Call:
    """One call of a step.

    Attributes:
        position: of the first relation in the list.
        relations: one, or those that are done together.
        clear: fields that are set to zero before.
        together: does the work of several relations; None for one.
    """

    position: int
    relations: list[Relation]
    clear: list[Key] = field(default_factory=list)
    together: Callable[[Clock], None] | None = None

    @property
    def label(self) -> str:
        """Name in reports."""
        first = self.relations[0]
        return first.label if self.together is None else f"{type(first).__name__}, {len(self.relations)} parts"

    def due(self, clock: Clock) -> bool:
        """True if the call is to be made in this step."""
        return self.together is not None or self.relations[0].when(clock)

    def apply(self, clock: Clock) -> None:
        """Does the work."""
        if self.together is not None:
            self.together(clock)
        else:
            self.relations[0].apply(clock)

    @cached_property
    def cleared(self) -> list[NDArray[Any]]:
        """The arrays to set to zero before."""
        return [part.raw(field) for part, field in self.clear]

    @cached_property
    def _items(self) -> int:
        return sum(relation.items() for relation in self.relations)

    def items(self) -> int:
        """Directed bonds that the call works for."""
        return self.relations[0].items() if self.together is None else self._items

    def node_items(self) -> int:
        """Nodes that the call works for."""
        return sum(relation.node_items() for relation in self.relations)

    def visited(self) -> int:
        """Those that it has looked at: all, of relations that are done together."""
        return self.relations[0].visited() if self.together is None else self._items


def with_feeders(relations: Sequence[Relation]) -> list[Relation]:
    """The relations of a step with their feeders, those that are not listed themselves.

    They stand in front of all forces that follow one another, so that a sum over several parts and their connections is
    whole before any force looks at it; feeders of other relations right in front of these.
    """
    listed, result = set(relations), []
    for constitutive, group in groupby(relations, lambda relation: relation.role == "constitutive"):
        members = list(group)
        for each in [members] if constitutive else [[member] for member in members]:
            result += [*dict.fromkeys(f for member in each for f in _all_feeders(member) if f not in listed), *each]
    return result


def _all_feeders(relation: Relation) -> list[Relation]:
    return [each for feeder in relation.feeders for each in (*_all_feeders(feeder), feeder)]


def schedule(relations: Sequence[Relation], clear: Mapping[int, Sequence[Key]], *, batches: bool = True) -> list[Call]:
    """The calls of a step, to be asked for once all relations are attached.

    Args:
        relations: in the order of the scene.
        clear: fields to be cleared before the relation at a position.
        batches: whether relations may be done together.
    """
    calls = [Call(position, [relation], list(clear.get(position, ()))) for position, relation in enumerate(relations)]
    _start_sums(calls)
    keys = [relation.batch_key() if batches and relation.when == always else None for relation in relations]
    shared = [key for key in keys if key is not None]
    if len(set(shared)) == len(shared):
        return calls
    groups: dict[Hashable, list[Call]] = {}
    for call, key, level in zip(calls, keys, _levels(calls), strict=True):
        groups.setdefault((level, call.position if key is None else key), []).append(call)
    if all(len(group) == 1 for group in groups.values()):
        return calls
    ordered = sorted(groups.items(), key=lambda item: (item[0][0], item[1][0].position))  # type: ignore[index]
    return [_merged(group) for _, group in ordered]


def _start_sums(calls: list[Call]) -> None:
    """Tells relations that can set a sum instead of adding to it: it needs no clearing then."""
    places = Counter(call.relations[0] for call in calls)
    for call in calls:
        relation = call.relations[0]
        alone = places[relation] == 1 and relation.when == always
        started = [key for key in call.clear if alone and relation.can_start(key)]
        relation.starts = frozenset(started)
        call.clear = [key for key in call.clear if key not in relation.starts]


def _merged(group: list[Call]) -> Call:
    first = group[0]
    if len(group) == 1:
        return first
    members = [call.relations[0] for call in group]
    cleared = [key for call in group for key in call.clear]
    return Call(first.position, members, cleared, members[0].batch(members))


def _levels(calls: Sequence[Call]) -> Iterator[int]:
    """How many relations in front of each must be done before it, one after another.

    A relation waits for those that change what it touches, those that look at what it changes, and those that it was
    given. Relations that add to one sum need not wait for each other, but for the first of them, which clears or sets
    it. Nothing is moved across what `stays`.
    """
    changed: dict[Any, int] = {}
    added: dict[Any, int] = {}
    looked: dict[Any, int] = {}
    floor = top = 0
    for call in calls:
        relation = call.relations[0]
        first = {*call.clear, *relation.starts}
        adds = [key for key in relation.keys("adds") if key not in first]
        offers = filter(relation.wants, relation.keys("offers"))
        writes = [*relation.keys("writes", "updates"), *offers, *first, relation]
        reads = [*relation.keys("reads"), *_given(relation.parameters.values())]
        waits = [changed.get(key, 0) for key in (*reads, *writes, *adds)]
        waits += [added.get(key, 0) for key in (*reads, *writes)]
        waits += [looked.get(key, 0) for key in (*writes, *adds)]
        level = max([floor, *waits])
        if relation.stays:
            level = floor = max(top, level)
        for known, keys in ((looked, reads), (added, adds)):
            for key in keys:
                known[key] = max(known.get(key, 0), level + 1)
        for key in writes:
            changed[key] = level + 1
        top = max(top, level + 1)
        if relation.stays:
            floor = top
        yield level


def _given(values: Any) -> Iterator[Relation]:
    """The relations among arguments."""
    for value in values:
        if isinstance(value, Relation):
            yield value
        elif isinstance(value, list | tuple):
            yield from _given(value)
