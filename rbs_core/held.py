"""What a scene holds in memory, thing by thing, and whether what its contracts declare will fit."""

from __future__ import annotations

from collections.abc import Sequence

from rbs_core.memory import as_text, require_memory
from rbs_core.part import Host
from rbs_core.relation import Key, Relation
from rbs_core.report import Held


def held(hosts: Sequence[Host], relations: Sequence[Relation]) -> list[Held]:
    """Memory of every field, of the bonds, and of what relations keep beside them, the largest first."""
    found = []
    for host in hosts:
        fields = [Held(host.name, field.name, field.at, host.raw(field).nbytes) for field in host.fields]
        rest = host.nbytes - sum(each.nbytes for each in fields)
        found += [*fields, Held(host.name, "bonds" if host.connected else "cells", "", rest)]
    found += [Held(relation.label, "loops", "", relation.nbytes) for relation in relations]
    return sorted((each for each in found if each.nbytes), key=lambda each: -each.nbytes)


def require_fields(keys: Sequence[Key]) -> None:
    """Refuses fields that do not fit into memory, before any of them is made.

    Raises:
        BadInput: with the largest ones.
    """
    missing = [(host, field) for host, field in keys if field not in host]
    sizes = {(host.name, field.name): host.store(field.at).size(field) for host, field in missing}
    largest = sorted(sizes.items(), key=lambda item: -item[1])[:3]
    named = ", ".join(f"'{field}' of '{host}' {as_text(size)}" for (host, field), size in largest)
    require_memory(
        sum(sizes.values()),
        f"the fields of this scene ({named})",
        "take a larger spacing, Part(..., precision='single'), or a list of relations that needs fewer fields",
    )
