"""What a list of relations needs, clears and carries: pure functions on declarations.

Nothing here touches an array except to ask whether the script has given it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

from rbs_core.errors import FieldClash, MissingField
from rbs_core.fields import KERNEL_FIELDS, Field
from rbs_core.relation import Key, Relation
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
    read = {key for relation in relations for key in relation.keys("reads")}
    made.offered = {key for relation in relations for key in relation.keys("offers")} & read
    for relation in relations:
        changes = _changes(relation, made.offered)
        made.fields = list(dict.fromkeys([*made.fields, *relation.keys("reads"), *changes]))
        made.changed |= set(changes)
    _check_names(made.fields)
    _check_gaps(relations, made, providers)
    _check_adders(relations)
    _check_writers(relations, made)
    for position, relation in enumerate(relations):
        for key in relation.keys("adds"):
            if not any(key in cleared for cleared in made.clear.values()):
                made.clear.setdefault(position, []).append(key)
    made.carried = _carried(relations, made)
    return made


def _changes(relation: Relation, offered: set[Key]) -> list[Key]:
    return [*relation.keys("writes", "updates", "adds"), *(key for key in relation.keys("offers") if key in offered)]


def _check_names(keys: list[Key]) -> None:
    seen: dict[tuple[int, str], Field] = {}
    for part, each in keys:
        other = seen.setdefault((id(part), each.name), each)
        if other != each:
            raise FieldClash(f"part '{part.name}': {other!r} and {each!r} share a name and differ: rename one of them")


def _check_gaps(relations: Sequence[Relation], made: Plan, providers: Providers) -> None:
    for position, relation in enumerate(relations):
        for part, each in relation.keys("reads"):
            if (part, each) in made.changed or each in KERNEL_FIELDS or each in part.store(each.at):
                continue
            known = ", ".join(sorted(providers(each)))
            could = f", or add a relation that writes it ({known})" if known else " (no known relation writes it)"
            raise MissingField(
                f"relation {position} ({relation.label}) reads '{each.name}' of part '{part.name}', and "
                f"nothing provides it: assign part[{each.name}] = ...{could}"
            )


def _check_adders(relations: Sequence[Relation]) -> None:
    """Between the first and the last relation that add to a field, nobody may look at the half-made sum."""
    sums = dict.fromkeys(key for relation in relations for key in relation.keys("adds"))
    for part, each in sums:
        places = [i for i, relation in enumerate(relations) if (part, each) in relation.keys("adds")]
        for i, relation in enumerate(relations):
            if (part, each) in relation.keys("writes", "updates"):
                raise FieldClash(
                    f"relation {i} ({relation.label}) sets '{each.name}' of part '{part.name}', and relation "
                    f"{places[0]} ({relations[places[0]].label}) adds to it: a field is either set or summed"
                )
            if (part, each) in relation.keys("reads") and places[0] < i < places[-1]:
                raise FieldClash(
                    f"relation {i} ({relation.label}) reads '{each.name}' of part '{part.name}' between relations "
                    f"{places[0]} and {places[-1]}, which both add to it, so it would see half of the sum: list the "
                    "relations that add next to each other"
                )


def _check_writers(relations: Sequence[Relation], made: Plan) -> None:
    """Two relations may both set a field only if somebody looks at it in between."""
    for part, each in made.changed:
        previous: int | None = None
        for i, relation in enumerate(relations):
            if (part, each) in relation.keys("reads", "updates"):
                previous = None
            if (part, each) in relation.keys("writes"):
                other = None if previous is None else relations[previous]
                if other is not None and other is not relation and other.when == always == relation.when:
                    raise FieldClash(
                        f"relations {previous} ({other.label}) and {i} ({relation.label}) both write '{each.name}' of "
                        f"part '{part.name}' and nobody reads it in between: the first one works for nothing"
                    )
                previous = i


def _carried(relations: Sequence[Relation], made: Plan) -> list[Key]:
    """Fields read or updated before anything has set or cleared them in the same step.

    A setter counts only if it runs in every step, or under the trigger of the reader.
    """
    carried = []
    for key in made.fields:
        if key not in made.changed:
            continue
        setters: list[object] = []
        for position, relation in enumerate(relations):
            if key in made.clear.get(position, []):
                setters.append(always)
            looks = key in relation.keys("reads", "updates") or (key in made.offered and key in relation.keys("offers"))
            if looks and always not in setters and relation.when not in setters:
                carried.append(key)
                break
            if key in relation.keys("writes"):
                setters.append(relation.when)
    return carried
