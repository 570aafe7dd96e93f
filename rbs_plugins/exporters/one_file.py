"""What exporters share that write a whole run into one HDF5 file: how it is begun, continued and refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Clock, Exporter
from rbs_core.files import written_whole
from rbs_plugins.exporters import growing

PRECISIONS = {None: None, "single": np.float32, "double": np.float64}


class OneFileExporter(Exporter):
    """An exporter of all frames into one file `path`, which a run from the beginning makes and a resumed one continues.

    A subclass sets `path`, `precision` and `_times = []`, and says what the file looks like: `_make`, `_append`,
    `_count`, `_cut`, `_save` and `_difference`.
    """

    path: Path
    precision: str | None
    _times: list[float]

    # -- what a subclass says ---------------------------------------------------------------------------------------

    def _make(self, path: Path) -> None:
        """Makes a file without frames."""
        raise NotImplementedError

    def _append(self, file: Any, times: list[float], clock: Clock) -> None:
        """Writes the frame of the last of these times, s, and makes it count."""
        raise NotImplementedError

    def _count(self, file: Any) -> int:
        """Number of frames that count."""
        raise NotImplementedError

    def _cut(self, file: Any, count: int) -> None:
        """Drops the frames behind so many."""
        raise NotImplementedError

    def _save(self, times: list[float]) -> None:
        """Makes a file that was not closed a sound one with these frames."""
        raise NotImplementedError

    def _difference(self, file: Any) -> str:
        """What tells a file from the one that this run has written so far, as the end of a sentence."""
        raise NotImplementedError

    # -- a run ------------------------------------------------------------------------------------------------------

    def reset(self) -> None:
        self._times = []

    def state(self) -> dict[str, Any]:
        return {"times": list(self._times)}

    def restore(self, state: dict[str, Any]) -> None:
        self._times = [float(time) for time in state["times"]]

    def begin(self, clock: Clock) -> None:
        """Drops what lies behind the frames of this run, if it goes on.

        Raises:
            BadInput: if the file does not hold these frames.
        """
        if not self._times:
            return
        difference = "is not there"
        if self.path.exists():
            try:
                difference = self._continue()
            except (OSError, RuntimeError, KeyError) as error:
                difference = f"cannot be continued ({error})"
        if difference:
            raise BadInput(
                f"{self.label}: {self.path} should hold {len(self._times)} frames of the run that goes on, and "
                f"{difference}: another run has written it; start again, or put the old file back"
            )

    def _continue(self) -> str:
        """Makes the file one with the frames of this run and no others; what is wrong if that cannot be."""
        import h5py

        with h5py.File(self.path, "r", locking=False) as file:
            difference = self._difference(file)
            if difference:
                return difference
            count = self._count(file)
        if not growing.was_closed(self.path):
            self._save(self._times)
        elif count > len(self._times):
            with growing.opened(self.path) as file:
                self._cut(file, len(self._times))
        return ""

    def apply(self, clock: Clock) -> None:
        times = [*self._times, clock.time]
        try:
            if self._times:
                with growing.opened(self.path) as file:
                    self._append(file, times, clock)
            else:
                with written_whole(self.path) as partial:
                    self._make(partial)
                    with growing.opened(partial) as file:
                        self._append(file, times, clock)
        except (OSError, RuntimeError) as error:
            why = str(error).split("\n")[0]
            raise OSError(f"{self.label} cannot write {self.path} ({why}): is the disk full?") from error
        self._times = times

    # -- what a subclass uses ---------------------------------------------------------------------------------------

    def _choice(self, name: str, value: Any, known: Any) -> None:
        """Refuses an unknown option.

        Raises:
            BadInput: with the known ones.
        """
        if value not in known:
            raise BadInput(f"{self.label}: {name}={value!r} must be one of {', '.join(map(repr, known))}")

    def _stored(self, array: NDArray[Any]) -> NDArray[Any]:
        """The same numbers, of the type of the file, one after the other in memory."""
        if array.dtype.kind == "b":  # HDF5 would make an enumeration of it, which viewers do not know
            return np.asarray(array, np.uint8, order="C")
        return np.asarray(array, PRECISIONS[self.precision] if array.dtype.kind == "f" else None, order="C")

    def _other_times(self, found: list[float]) -> str:
        """What is wrong with the times of a file, s, as the end of a sentence."""
        if len(found) < len(self._times):
            return f"holds {len(found)}"
        wrong = [pair for pair in zip(found, self._times, strict=False) if pair[0] != pair[1]]
        return f"holds the time {wrong[0][0]} s instead of {wrong[0][1]} s" if wrong else ""


def in_words(arrays: dict[str, tuple[Any, ...]]) -> str:
    """Arrays of a frame, (dtype, shape, compression) by name, for messages."""
    texts = [f"{name} ({dtype}, compression {how})" for name, (dtype, _, how) in sorted(arrays.items())]
    return ", ".join(texts) or "no fields"
