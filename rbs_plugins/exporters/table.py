"""CSVExporter: numbers of a part over time, one row per call."""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TextIO

from rbs_core import BadInput, Exporter, Field, Part, Trigger, always
from rbs_core.files import writable_folder
from rbs_core.trigger import Clock
from rbs_plugins.exporters.names import field_of, listed
from rbs_plugins.exporters.reductions import Reduced, Reduction


class CSVExporter(Exporter):
    """Writes step, time, numbers of the part, and sums, means and extremes of node fields as a table.

    Args:
        part: the part.
        fields: what to write: fields of the part (at="part"), e.g. energies, whose vectors become one column per
            component; and `total`, `mean`, `largest` and `smallest` of node fields.
        path: the .csv file; started anew by a run from the beginning, continued by a resumed one.
        when: trigger.

    Raises:
        BadInput: on a field that is not a number of the part, with the nearest names; on a component, region or node
            set that does not exist; on two columns of one name; at the start of the run, if the folder cannot be
            written.

    The first line holds the names of the columns with their units, e.g. `kinetic_energy [J]`.
    """

    example = {"fields": (), "path": "table.csv"}

    def __init__(
        self, part: Part, fields: Iterable[Field | Reduction], path: str | Path, *, when: Trigger = always
    ) -> None:
        super().__init__(part, when=when)
        self.path = Path(path)
        why = "so it fits no table; node fields do as total(field), mean(field), largest(field) or smallest(field)"
        self.fields: tuple[Field | Reduction, ...] = tuple(
            each if isinstance(each, Reduction) else field_of(self.label, each, ("part",), why)
            for each in listed(fields)
        )
        self._reduced = {k: Reduced(self.label, r, part) for k, r in enumerate(self.fields) if isinstance(r, Reduction)}
        self._columns = ["step", "time [s]", *self._named()]
        self._rows = 0
        self._file: TextIO | None = None

    def _named(self) -> list[str]:
        """Columns behind step and time, each with its unit.

        Raises:
            BadInput: if two have the same name.
        """
        columns: list[tuple[str, str]] = []
        for number, field in enumerate(self.fields):
            if isinstance(field, Reduction):
                names = self._reduced[number].names
            else:
                size = math.prod(field.entry(self.part.dimension))
                names = [field.name] if field.shape == "scalar" else [f"{field.name}_{k}" for k in range(size)]
            columns += [(name, field.unit) for name in names]
        for name, count in Counter([name for name, _ in columns] + ["step", "time"]).items():
            if count > 1:
                raise BadInput(
                    f"{self.label}: {count} columns would be called '{name}': give each its own, "
                    "as in mean(damage, region, name='damage_left')"
                )
        return [f"{name} [{unit}]" for name, unit in columns]

    @property
    def reads(self) -> tuple[Field, ...]:  # type: ignore[override]
        """The fields of the table, and those that its numbers are made of."""
        needed = [each.reads if isinstance(each, Reduction) else (each,) for each in self.fields]
        return tuple(dict.fromkeys(field for fields in needed for field in fields))

    @property
    def label(self) -> str:
        """Name in reports, and in checkpoints: two exporters of one part differ by their files."""
        return f"{super().label} {self.path.name}"

    def attach(self) -> None:
        writable_folder(self.path.parent)

    def apply(self, clock: Clock) -> None:
        if self._file is None:
            self._file = self._open()
        values: list[float] = []
        for number, field in enumerate(self.fields):
            if isinstance(field, Field):
                values += map(float, self[field].ravel())
            else:
                values += self._reduced[number](self.__getitem__)
        csv.writer(self._file, lineterminator="\n").writerow([clock.step, repr(clock.time), *map(repr, values)])
        self._file.flush()
        self._rows += 1

    def _open(self) -> TextIO:
        """The file with exactly the rows written so far: those behind the checkpoint of a resumed run are dropped."""
        kept: list[str] = []
        if self._rows:
            kept = self.path.read_text(encoding="utf-8").splitlines()[: self._rows + 1] if self.path.exists() else []
            if len(kept) < self._rows + 1:
                raise BadInput(
                    f"{self.label}: {self.path} should hold {self._rows} rows of the run that goes on, and holds "
                    f"{max(len(kept) - 1, 0)}: another run has written it; start again, or put the old table back"
                )
        if kept and next(csv.reader(kept)) != self._columns:
            raise BadInput(
                f"{self.label}: {self.path} has the columns {kept[0]}, this run would write {','.join(self._columns)}: "
                "another run has written it; start again, or take another path"
            )
        file = self.path.open("w", encoding="utf-8", newline="")
        if kept:
            file.write("\n".join(kept) + "\n")
        else:
            csv.writer(file, lineterminator="\n").writerow(self._columns)
        return file

    def close(self) -> None:
        if self._file is not None:
            self._file.close()
            self._file = None

    def reset(self) -> None:
        self._rows = 0

    def state(self) -> dict[str, Any]:
        return {"rows": self._rows}

    def restore(self, state: dict[str, Any]) -> None:
        self._rows = int(state["rows"])


class Table(dict[str, list[float]]):
    """Columns of a table by name.

    Attributes:
        units: of the columns by name, as far as the file says them.
    """

    def __init__(self, columns: dict[str, list[float]], units: dict[str, str]) -> None:
        super().__init__(columns)
        self.units = units


def read_table(path: str | Path) -> Table:
    """Columns of a table that CSVExporter wrote, by name without the unit; `read_table(path).units` are those."""
    with Path(path).open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    heads = [re.fullmatch(r"(.*?)(?: \[(.*)\])?", head) for head in rows[0]]
    named = [(found[1], found[2]) for found in heads if found]
    columns = {name: [float(row[i]) for row in rows[1:]] for i, (name, _) in enumerate(named)}
    return Table(columns, {name: unit for name, unit in named if unit is not None})
