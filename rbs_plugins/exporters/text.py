"""TextExporter: points and fields as columns of plain text."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import IO, Any

import numpy as np

from rbs_core import BadInput, Clock, Field, Part, Trigger, always
from rbs_core.files import written_whole
from rbs_plugins.exporters.digits import MOST_DIGITS, RowWriter
from rbs_plugins.exporters.frames import FrameExporter, Room

AXES = "xyz"


class TextExporter(FrameExporter):
    """Writes a line per node, x y z and the components of the fields, into `<path>_<step>.txt` or all into one file.

    Args:
        part: the part.
        fields: node fields to export; none for a list of points.
        path: folder and beginning of the file names; of one file its name, `.txt` is added if it has no ending.
        configuration: "current" (default) or "reference" positions.
        digits: significant digits, 1 to 15; 9 (default) are all of a number in single precision.
        one_file: True for one file with a block for each frame, and two empty lines between blocks; started anew by a
            run from the beginning, continued by a resumed one.
        when: trigger.

    Raises:
        BadInput: as other exporters of nodes; on digits out of range; at the start of a resumed run, if the one file is
            not the one that it has written.

    Two lines that begin with `#` stand above the numbers: step and time, and the names of the columns with their units.
    Positions, vectors and tensors have three components per direction, in coordinates of the world.
    """

    example = {"fields": (), "path": "points"}

    def __init__(
        self,
        part: Part,
        fields: Iterable[Field],
        path: str | Path,
        *,
        configuration: str = "current",
        digits: int = 9,
        one_file: bool = False,
        when: Trigger = always,
    ) -> None:
        path = Path(path)
        path = path.with_name(f"{path.name}.txt") if one_file and not path.suffix else path
        super().__init__(part, fields, path, configuration=configuration, when=when)
        if not (isinstance(digits, int) and 1 <= digits <= MOST_DIGITS):
            raise BadInput(f"{self.label}: digits={digits!r} must be a whole number from 1 to {MOST_DIGITS}")
        self.digits, self.one_file = digits, one_file
        self._names = "# " + " ".join(["x[m]", "y[m]", "z[m]", *(name for f in self.fields for name in _columns(f))])
        self._bytes = 0
        self._rooms: dict[str, Room] = {}
        self._writer: RowWriter | None = None

    def attach(self) -> None:
        super().attach()
        self._rooms = {}
        self._writer = RowWriter(len(self._names.split()) - 1, self.digits)

    def reset(self) -> None:
        super().reset()
        self._bytes = 0

    def state(self) -> dict[str, Any]:
        return {**super().state(), "bytes": self._bytes}

    def restore(self, state: dict[str, Any]) -> None:
        super().restore(state)
        self._bytes = int(state["bytes"])

    def begin(self, clock: Clock) -> None:
        """Drops what lies behind the frames of a run that goes on in one file.

        Raises:
            BadInput: if the file does not hold them.
        """
        if not (self.one_file and self._bytes):
            return
        size, names = 0, ""
        if self.path.exists():
            size = self.path.stat().st_size
            with self.path.open("rb") as file:
                names = [file.readline().decode(errors="replace") for _ in range(2)][1].rstrip("\n")
        if size < self._bytes or names != self._names:
            raise BadInput(
                f"{self.label}: {self.path} should hold {self._bytes} bytes of the run that goes on, below the names "
                f"{self._names[2:]!r}: another run has written it; start again, or put the old file back"
            )
        os.truncate(self.path, self._bytes)

    def apply(self, clock: Clock) -> None:
        if self.one_file:
            with self.path.open("ab" if self._bytes else "wb") as file:
                if self._bytes:
                    file.write(b"\n\n")
                self._write(file, clock)
                self._bytes = file.tell()
            return
        with written_whole(self.frame(clock, "txt")) as partial, partial.open("wb") as file:
            self._write(file, clock)

    def _write(self, file: IO[bytes], clock: Clock) -> None:
        assert self._writer is not None
        file.write(f"# part '{self.part.name}', step {clock.step}, time {clock.time!r} s\n{self._names}\n".encode())
        arrays = [self.values(field, self._rooms.setdefault(field.name, {})) for field in self.fields]
        self._writer.write(file, [self.positions(room=self._rooms.setdefault("", {})), *arrays])


def _columns(field: Field) -> list[str]:
    """Names of the columns of a field with its unit, without blanks."""
    ends = ["".join(AXES[axis] for axis in entry) for entry in np.ndindex(*field.entry(3))]
    unit = field.unit.replace(" ", "*")
    return [f"{field.name}{end and f'_{end}'}[{unit}]" for end in ends]
