"""Prescribed values: numbers, arrays or functions of time, per component."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput

Component = tuple[int, NDArray[np.float64]]


class Values:
    """What is prescribed on some nodes.

    Args:
        owner: name for messages.
        given: one entry per component (or just one in 1-D), each None (free), a number, an array (k,) or a function;
            or a function that returns such a sequence. Functions take (time) or (time, positions), time in s and
            positions (k, d) the reference positions of the nodes.
        positions: (k, d) of the nodes.

    Raises:
        BadInput: if the number of components, a shape, or (checked at time 0) a result does not fit.
    """

    def __init__(self, owner: str, given: Any, positions: NDArray[np.float64]) -> None:
        self._owner, self._positions = owner, positions
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
        self.at(0.0)

    def at(self, time: float) -> list[Component]:
        """(axis, values (k,)) of every prescribed component at a time, s.

        Raises:
            BadInput: if a function returns something of a wrong shape, NaN or infinity.
        """
        if self._whole is not None:
            rows = enumerate(self._components(self._whole(time)))
            return [(axis, self._row(value, axis, time)) for axis, value in rows if value is not None]
        return [(axis, self._row(v(time), axis, time) if callable(v) else v) for axis, v in self._parts]

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
        count = len(inspect.signature(function).parameters)
        if count not in (1, 2):
            raise BadInput(f"{self._owner}: a function takes (time) or (time, positions), this one takes {count}")
        return function if count == 1 else lambda time: function(time, self._positions)

    def _row(self, value: Any, axis: int, time: float | None = None) -> NDArray[np.float64]:
        count = len(self._positions)
        when = "" if time is None else f" at time {time:g} s"
        try:
            row = np.broadcast_to(np.asarray(value, np.float64), (count,))
        except (TypeError, ValueError):
            raise BadInput(
                f"{self._owner}: component {axis}{when} must be a number, {count} numbers (one per node) or a "
                f"function, got {value!r}"
            ) from None
        bad = np.flatnonzero(~np.isfinite(row))
        if len(bad):
            where = self._positions[bad[0]].tolist()
            raise BadInput(f"{self._owner}: component {axis}{when} is {row[bad[0]]} for the node at {where}")
        return row
