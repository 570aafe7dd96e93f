"""Watch: catches relations that do something else than their contracts say. Slow: for debugging and conformance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.errors import DishonestRelation
from rbs_core.fields import Field
from rbs_core.part import Part
from rbs_core.relation import Relation


class Watch:
    """Compares the fields of all parts before and after each `apply`.

    Fields that are only read are given read-only by `Relation.__getitem__` of a strict relation; this class finds what
    goes past it, and entries that a relation should have written and did not.
    """

    def __init__(self, relations: Sequence[Relation]) -> None:
        self._parts = [part for part in dict.fromkeys(r.part for r in relations) if part.fields]
        self._before: dict[tuple[Part, Field], NDArray[Any]] = {}

    def before(self, relation: Relation) -> None:
        """Fills what the relation will write with NaN and remembers everything else."""
        for field in relation.writes:
            array = relation.part.store(field.at).get(field)
            array[...] = np.nan if array.dtype.kind == "f" else np.iinfo(array.dtype).max
        self._before = {(part, field): part[field].copy() for part in self._parts for field in part.fields}

    def after(self, relation: Relation) -> None:
        """Raises DishonestRelation if a field changed that the contract does not name, or a written one has gaps."""
        allowed = {*relation.writes, *relation.updates, *relation.adds, *relation.offers}
        for (part, field), old in self._before.items():
            if part is relation.part and field in allowed:
                continue
            if not np.array_equal(part[field], old, equal_nan=old.dtype.kind == "f"):
                raise DishonestRelation(
                    f"it changed '{field.name}' of part '{part.name}', which its contract does not name: add the field "
                    f"to updates or adds of {type(relation).__name__}"
                )
        for field in relation.writes:
            array = relation.part[field]
            unset = np.isnan(array) if array.dtype.kind == "f" else array == np.iinfo(array.dtype).max
            if unset.any():
                raise DishonestRelation(
                    f"it says that it writes '{field.name}' of part '{relation.part.name}' and left entry "
                    f"{np.argwhere(unset)[0].tolist()} unset (or NaN): set every entry, or name it under updates"
                )
