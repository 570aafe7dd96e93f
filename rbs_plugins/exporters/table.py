"""CSVExporter: numbers of a part over time, one row per call."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TextIO

from rbs_core import BadInput, Exporter, Field, Part, Trigger, always
from rbs_core.files import writable_folder
from rbs_core.trigger import Clock


class CSVExporter(Exporter):
    """Writes step, time and fields of the part (at="part") as a table; vectors become one column per component.

    Args:
        part: the part.
        fields: what to write, e.g. energies.
        path: the .csv file; started anew by a run from the beginning, continued by a resumed one.
        when: trigger.

    Raises:
        BadInput: on a field that is not a number of the part; at the start of the run, if the folder cannot be written.
    """

    example = {"fields": (), "path": "table.csv"}

    def __init__(self, part: Part, fields: Iterable[Field], path: str | Path, *, when: Trigger = always) -> None:
        super().__init__(part, when=when)
        self.path = Path(path)
        self.fields = (fields,) if isinstance(fields, Field) else tuple(fields)
        for field in self.fields:
            if not isinstance(field, Field) or field.at != "part":
                raise BadInput(f"{self.label}: {field!r} is no number of the part (at='part'), so it fits no table")
        self._rows = 0
        self._file: TextIO | None = None

    @property
    def reads(self) -> tuple[Field, ...]:  # type: ignore[override]
        """The fields of the table."""
        return self.fields

    @property
    def label(self) -> str:
        """Name in reports, and in checkpoints: two exporters of one part differ by their files."""
        return f"{super().label} {self.path.name}"

    def attach(self) -> None:
        writable_folder(self.path.parent)

    def apply(self, clock: Clock) -> None:
        if self._file is None:
            self._file = self._open()
        values = [float(value) for field in self.fields for value in self[field].ravel()]
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
        columns = ["step", "time", *self._columns()]
        if kept and kept[0].split(",") != columns:
            raise BadInput(f"{self.label}: {self.path} has the columns {kept[0]}, this run would write {columns}")
        file = self.path.open("w", encoding="utf-8", newline="")
        if kept:
            file.write("\n".join(kept) + "\n")
        else:
            csv.writer(file, lineterminator="\n").writerow(columns)
        return file

    def _columns(self) -> list[str]:
        names = []
        for field in self.fields:
            size = self[field].size
            names += [field.name] if size == 1 else [f"{field.name}_{axis}" for axis in range(size)]
        return names

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


def read_table(path: str | Path) -> dict[str, list[float]]:
    """Columns of a table that CSVExporter wrote, by name."""
    with Path(path).open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    return {name: [float(row[i]) for row in rows[1:]] for i, name in enumerate(rows[0])}
