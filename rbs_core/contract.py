"""What a list of relations needs, clears and carries: pure functions on declarations.

Nothing here touches an array except to ask whether the script has given it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

from rbs_core.errors import FieldClash, MissingField
from rbs_core.fields import KERNEL_FIELDS, Field
from rbs_core.relation import WORDS, Key, Relation
from rbs_core.trigger import always

Providers = Callable[[Field], Iterable[str]]


@dataclass
class Plan:
    """What the contracts of a scene add up to.

    Attributes:
        fields: every (part, field) to allocate, in order of first mention.
        clear: position in the list -> fields cleared right before it.
        carried: fields whose value a step takes over from the step before: what a checkpoint holds.
        changed: every (part, field) that some relation changes.
        offered: every (part, field) that is offered and read.
    """

    fields: list[Key] = field(default_factory=list)
    clear: dict[int, list[Key]] = field(default_factory=dict)
    carried: list[Key] = field(default_factory=list)
    changed: set[Key] = field(default_factory=set)
    offered: set[Key] = field(default_factory=set)

    def __str__(self) -> str:
        """A line for each field: what the scene does with it."""
        cleared = [key for keys in self.clear.values() for key in keys]
        lines = []
        for key in self.fields:
            part, each = key
            words = [
                word
                for word, there in (
                    ("changed", key in self.changed),
                    ("cleared", key in cleared),
                    ("carried", key in self.carried),
                    ("offer taken", key in self.offered),
                )
                if there
            ]
            lines.append(f"{part.name}: {each.name} ({each.at} {each.shape}) {', '.join(words) or 'only read'}")
        return "\n".join(lines)


def plan(relations: Sequence[Relation], providers: Providers = lambda _: ()) -> Plan:
    """Checks the contracts of a scene and derives what it needs.

    Args:
        relations: in the order of execution; one relation may stand in several places.
        providers: names of known relations that could provide a field, for the message about a gap.

    Raises:
        FieldClash: if two fields share a name, or relations contradict each other.
        MissingField: if a field is read that neither the script nor a relation provides.
    """
    made = Plan()
    named = [_Named(i, relation) for i, relation in enumerate(relations)]
    read = {key for each in named for key in each.reads}
    made.offered = {key for each in named for key in each.offers} & read
    fields: dict[Key, None] = {}
    for each in named:
        changes = [*each.writes, *each.updates, *each.adds, *(key for key in each.offers if key in made.offered)]
        fields.update(dict.fromkeys([*each.reads, *changes]))
        made.changed |= set(changes)
    made.fields = list(fields)
    _check_names(made.fields)
    _check_gaps(named, made, providers)
    touching: dict[Key, list[_Named]] = {key: [] for key in made.fields}
    for each in named:
        for key in each.all:
            if key in touching:
                touching[key].append(each)
    for key, those in touching.items():
        _check_adders(key, those)
        _check_writers(key, those)
        adders = [each for each in those if key in each.adds]
        if adders:
            made.clear.setdefault(adders[0].position, []).append(key)
    made.carried = [key for key, those in touching.items() if key in made.changed and _is_carried(key, those, made)]
    return made


class _Named:
    """A relation at its position, with what its contract names, looked up once."""

    def __init__(self, position: int, relation: Relation) -> None:
        self.position, self.relation = position, relation
        self.reads, self.writes, self.updates, self.adds, self.offers = (
            dict.fromkeys(relation.keys(word)) for word in WORDS
        )
        self.all = {**self.reads, **self.writes, **self.updates, **self.adds, **self.offers}

    def __str__(self) -> str:
        return f"{self.position} ({self.relation.label})"


def _check_names(keys: list[Key]) -> None:
    seen: dict[tuple[int, str], Field] = {}
    for part, each in keys:
        other = seen.setdefault((id(part), each.name), each)
        if other != each:
            raise FieldClash(f"part '{part.name}': {other!r} and {each!r} share a name and differ: rename one of them")


def _check_gaps(named: Sequence[_Named], made: Plan, providers: Providers) -> None:
    for one in named:
        for part, each in one.reads:
            if (part, each) in made.changed or each in KERNEL_FIELDS or each in part.store(each.at):
                continue
            known = ", ".join(sorted(providers(each)))
            could = f", or add a relation that writes it ({known})" if known else " (no known relation writes it)"
            raise MissingField(
                f"relation {one} reads '{each.name}' of part '{part.name}', and nothing provides it: assign "
                f"part[{each.name}] = ...{could}"
            )


def _check_adders(key: Key, those: Sequence[_Named]) -> None:
    """Between the first and the last relation that add to a field, nobody may look at the half-made sum."""
    adders = [one for one in those if key in one.adds]
    if not adders:
        return
    first, last, (part, each) = adders[0], adders[-1], key
    for one in those:
        if (key in one.writes and one.position > first.position) or key in one.updates:
            raise FieldClash(
                f"relation {one} sets '{each.name}' of part '{part.name}', and relation {first} adds to it: a field is "
                "either set or summed"
            )
        if key in one.reads and first.position < one.position < last.position:
            raise FieldClash(
                f"relation {one} reads '{each.name}' of part '{part.name}' between relations {first.position} and "
                f"{last.position}, which both add to it, so it would see half of the sum: list the relations that add "
                "next to each other"
            )


def _check_writers(key: Key, those: Sequence[_Named]) -> None:
    """Two relations may both set a field only if somebody looks at it in between."""
    previous: _Named | None = None
    part, each = key
    for one in those:
        if key in one.reads or key in one.updates:
            previous = None
        if key in one.writes:
            other = one.relation if previous is None else previous.relation
            if other is not one.relation and other.when == always == one.relation.when:
                raise FieldClash(
                    f"relations {previous} and {one} both write '{each.name}' of part '{part.name}' and nobody reads "
                    "it in between: the first one works for nothing"
                )
            previous = one


def _is_carried(key: Key, those: Sequence[_Named], made: Plan) -> bool:
    """True for a field that is read or updated before anything has set or cleared it in the same step.

    A setter counts only if it runs in every step, or under the trigger of the reader.
    """
    setters: list[object] = []
    for one in those:
        if key in made.clear.get(one.position, ()):
            setters.append(always)
        looks = key in one.reads or key in one.updates or (key in made.offered and key in one.offers)
        if looks and always not in setters and one.relation.when not in setters:
            return True
        if key in one.writes:
            setters.append(one.relation.when)
    return False
