"""Prescribed values: numbers, arrays or functions of time, per component."""

from __future__ import annotations

import hashlib
import inspect
import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput

Component = tuple[int, NDArray[np.float64]]
SAMPLES = (0.0, 1e-9, 1e-6, 1e-3, 1.0)  # s: times at which two prescriptions are compared


class Values:
    """What is prescribed on some nodes.

    Args:
        owner: name for messages.
        given: one entry per component (or just one in 1-D), each None (free), a number, an array (k,) or a function;
            or a function that returns such a sequence. Functions take (time) or (time, positions), time in s and
            positions (k, d) the reference positions of the nodes; a parameter with a default keeps it.
        positions: (k, d) of the nodes.
        steady: the same components must be prescribed at all times.

    Raises:
        BadInput: if the number of components, a shape, or (checked at time 0) a result does not fit.
    """

    def __init__(self, owner: str, given: Any, positions: NDArray[np.float64], steady: bool = False) -> None:
        self._owner, self._positions = owner, positions
        self._axes: list[int] | None = None
        self._whole: Callable[[float], Any] | None = None
        self._parts: list[tuple[int, Callable[[float], Any] | NDArray[np.float64]]] = []
        if callable(given):
            self._whole = self._timed(given)
        else:
            for axis, value in enumerate(self._components(given)):
                if value is not None:
                    self._parts.append((axis, self._timed(value) if callable(value) else self._row(value, axis)))
            if not self._parts:
                raise BadInput(f"{owner}: every component is None, so nothing is prescribed")
        axes = [axis for axis, _ in self.entries(0.0)]
        if steady:
            self._axes = axes

    def at(self, time: float) -> list[Component]:
        """(axis, values (k,)) of every prescribed component at a time, s.

        Raises:
            BadInput: if a function returns something of a wrong shape, NaN or infinity, or (if `steady`) other
                components than at time 0.
        """
        return [(axis, np.broadcast_to(value, (len(self._positions),))) for axis, value in self.entries(time)]

    def entries(self, time: float) -> list[Component]:
        """Like `at`, but as it was given: one number for all nodes stays a number, of shape ()."""
        if self._whole is not None:
            rows = enumerate(self._components(self._whole(time)))
            found = [(axis, self._row(value, axis, time)) for axis, value in rows if value is not None]
        else:
            found = [(axis, self._row(v(time), axis, time) if callable(v) else v) for axis, v in self._parts]
        axes = [axis for axis, _ in found]
        if self._axes is not None and axes != self._axes:
            raise BadInput(
                f"{self._owner}: prescribes components {axes} at time {time:g} s, but {self._axes} at time 0 s: "
                "prescribe the same ones at all times, and end it by when="
            )
        return found

    def samples(self) -> Iterator[list[Component]]:
        """What is prescribed at a few times; nothing at a time for which a function fails."""
        for time in SAMPLES:
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")
                try:
                    found = self.entries(time)
                except Exception:  # whatever the function of somebody else does at a time that the run may never reach
                    found = []
            yield found

    def digest(self) -> str:
        """A text that differs if what is prescribed differs at one of a few times."""
        digest = hashlib.blake2b(digest_size=12)
        for number, found in enumerate(self.samples()):
            for axis, value in found:
                digest.update(f"{number} {axis} {value.shape}".encode())
                digest.update(value.tobytes())
        return digest.hexdigest()

    def _components(self, given: Any) -> Sequence[Any]:
        dimension = self._positions.shape[1]
        if isinstance(given, np.ndarray) and given.shape == self._positions.shape:
            return list(given.T)
        if dimension == 1 and not isinstance(given, list | tuple):
            return [given]
        try:
            components = list(given)
        except TypeError:
            components = []
        if len(components) != dimension:
            raise BadInput(f"{self._owner}: give {dimension} components (None for a free one), got {given!r}")
        return components

    def _timed(self, function: Callable[..., Any]) -> Callable[[float], Any]:
        try:
            parameters = list(inspect.signature(function).parameters.values())
        except (TypeError, ValueError):
            raise BadInput(
                f"{self._owner}: {function!r} does not tell what it takes: wrap it, `lambda time: ...`"
            ) from None
        rest = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
        needed = [each for each in parameters if each.default is each.empty and each.kind not in rest]
        count = len(needed)
        if count not in (1, 2) or any(each.kind is each.KEYWORD_ONLY for each in needed):
            names = "".join(f" {each}" for each in needed)
            raise BadInput(
                f"{self._owner}: a function takes (time) or (time, positions) by position, and has a default for every "
                f"other parameter; this one takes {count}{names and f':{names}'}"
            )
        return function if count == 1 else lambda time: function(time, self._positions)

    def _row(self, value: Any, axis: int, time: float | None = None) -> NDArray[np.float64]:
        count = len(self._positions)
        when = "" if time is None else f" at time {time:g} s"
        try:
            row = np.asarray(value, np.float64)
            np.broadcast_to(row, (count,))
        except (TypeError, ValueError):
            raise BadInput(
                f"{self._owner}: component {axis}{when} must be a number, {count} numbers (one per node) or a "
                f"function, got {value!r}"
            ) from None
        bad = np.flatnonzero(~np.isfinite(row))
        if len(bad):
            where = self._positions[bad[0]].tolist()
            raise BadInput(f"{self._owner}: component {axis}{when} is {row.flat[bad[0]]} for the node at {where}")
        return row.reshape(()) if row.size == 1 else row
