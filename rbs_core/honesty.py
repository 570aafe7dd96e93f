"""What must not happen during a run: numbers that are not finite, relations that break their contracts.

Watching contracts is slow: for debugging and the conformance suite.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.errors import DishonestRelation, NotFinite
from rbs_core.fields import Field
from rbs_core.part import Host
from rbs_core.relation import Relation


def check_finite(keys: Iterable[tuple[Host, Field]]) -> None:
    """What goes into a file must be finite, so that the last good frame stays the last one written.

    Raises:
        NotFinite: names the first entry which is not.
    """
    for part, field in keys:
        array = part.raw(field)
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            raise not_finite(part, field.name, array)


def not_finite(part: Host, name: str, array: Any) -> NotFinite:
    """The error that names the first entry which is not finite."""
    index = np.argwhere(~np.isfinite(array))[0]
    node = int(index[0]) if len(index) else None
    where = "" if node is None or len(array) != len(part) else f" of node {node} at {part.positions[node].tolist()}"
    return NotFinite(
        f"'{name}'{where} in part '{part.name}' is {array[tuple(index)]}: look at the loads and the time step "
        "there; files written so far are good"
    )


@contextmanager
def blamed(relation: Relation) -> Iterator[None]:
    """Turns a refused store into a read-only array, of numpy or numba, into the error that names the relation."""
    try:
        yield
    except Exception as error:
        refused = [line.strip() for line in str(error).splitlines() if re.search("read-?only", line)]
        if not refused:
            raise
        raise DishonestRelation(
            f"{relation.label} stores into a field that its contract only reads ({refused[0]}): name the field under "
            f"updates or adds of {type(relation).__name__}"
        ) from error


class Watch:
    """Compares the fields of all parts before and after each `apply`.

    Fields that are only read are given read-only by `Relation.__getitem__` of a strict relation; this class finds what
    goes past it, and entries that a relation should have written and did not.
    """

    def __init__(self, relations: Sequence[Relation]) -> None:
        hosts = dict.fromkeys(host for relation in relations for host in relation.hosts)
        # bonds that come and go bring their fields with them
        self._parts = [host for host in hosts if host.fields and not host.searched_again]
        self._before: dict[tuple[Host, Field], NDArray[Any]] = {}

    def before(self, relation: Relation) -> None:
        """Fills what the relation will write with NaN and remembers everything else."""
        for part, field in (*relation.keys("writes"), *relation.starts):
            array = part.raw(field)
            if array.dtype.kind in "fiu":
                array[...] = np.nan if array.dtype.kind == "f" else np.iinfo(array.dtype).max
        self._before = {(p, f): p.raw(f).copy() for p in self._parts for f in p.fields}

    def after(self, relation: Relation) -> None:
        """Raises DishonestRelation if a field changed that the contract does not name, or a written one has gaps."""
        allowed = relation.keys("writes", "updates", "adds", "offers")
        for (part, field), old in self._before.items():
            if (part, field) in allowed:
                continue
            if not np.array_equal(part.raw(field), old, equal_nan=old.dtype.kind == "f"):
                raise DishonestRelation(
                    f"it changed '{field.name}' of part '{part.name}', which its contract does not name: add the field "
                    f"to updates or adds of {type(relation).__name__}"
                )
        for part, field in (*relation.keys("writes"), *relation.starts):
            array = part[field]
            if array.dtype.kind not in "fiu":
                continue  # no value of a bool means "unset"
            unset = np.isnan(array) if array.dtype.kind == "f" else array == np.iinfo(array.dtype).max
            if unset.any():
                verb = "can start" if (part, field) in relation.starts else "writes"
                raise DishonestRelation(
                    f"it says that it {verb} '{field.name}' of part '{part.name}' and left entry "
                    f"{np.argwhere(unset)[0].tolist()} unset (or NaN): set every entry, or name it under updates"
                )
