"""ConnectionExporter: bonds between two parts, to be looked at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core import BadInput, Clock, Everywhere, Part, Trigger, once
from rbs_core.report import log
from rbs_plugins.exporters import vtu
from rbs_plugins.exporters.frames import FrameExporter
from rbs_plugins.exporters.neighborhoods import bond_data
from rbs_plugins.fields import displacement, reference_position


@runtime_checkable
class Connected(Protocol):
    """What a connection between two parts must have to be exported: anything that has it will do.

    Attributes:
        part: the part whose nodes own the bonds.
        other: the part that they lead to.
    """

    part: Part
    other: Part

    def as_rows(self) -> tuple[NDArray[np.int64], NDArray[Any]]:
        """Offsets (n + 1,) and neighbors (m,): bonds of node i lead to other's nodes neighbors[offsets[i] : ...]."""


@dataclass(frozen=True)
class GivenRows:
    """A connection made of given rows, e.g. of a search of one's own.

    Attributes:
        part, other, offsets, neighbors: as in `Connected`.
    """

    part: Part
    other: Part
    offsets: ArrayLike
    neighbors: ArrayLike

    def as_rows(self) -> tuple[NDArray[np.int64], NDArray[Any]]:
        """The rows."""
        return np.asarray(self.offsets, np.int64), np.asarray(self.neighbors, np.int64)

    def __repr__(self) -> str:
        ends = [getattr(part, "name", part) for part in (self.part, self.other)]
        return f"GivenRows({ends[0]}, {ends[1]}, {len(self.as_rows()[1])} bonds)"


class ConnectionExporter(FrameExporter):
    """Writes the nodes of two parts that are bonded to each other, and these bonds as lines.

    Args:
        part: the part whose nodes own the bonds.
        connection: anything with `part`, `other` and `as_rows()`, see `Connected`.
        path: folder and beginning of the file names: `<path>_<step>.vtu` and `<path>.pvd`, as VTKExporter.
        configuration: "reference" (default) or "current" positions.
        when: trigger; the first step if not given.

    Raises:
        BadInput: on what is no connection of this part, on an unknown configuration; at the start of the run and when
            the file is written, on rows that do not fit the parts.

    Point data: `is_other`, 1 for nodes of the other part, `node`, the number of the node in its part, and
    `family_size`, the number of its bonds here. Cell data of lines: `node` and `neighbor` (numbers of points of the
    file), `bond_vector` and `bond_length` (m, in the configuration); vertices, one for each node, have no neighbor
    (-1) and length 0.

    `write(file)` writes without a run.
    """

    def __init__(
        self,
        part: Part,
        connection: Connected,
        path: str | Path,
        *,
        configuration: str = "reference",
        when: Trigger = once,
    ) -> None:
        super().__init__(part, (), path, configuration=configuration, when=when)
        named = ("part", "other")
        if not (isinstance(connection, Connected) and all(isinstance(getattr(connection, n), Part) for n in named)):
            raise BadInput(f"{self.label}: {connection!r} is no connection: it needs part, other and as_rows()")
        if connection.part is not part:
            raise BadInput(
                f"{self.label}: {connection!r} belongs to part '{connection.part.name}': give that one in front of it"
            )
        self.connection, self.other = connection, connection.other
        self._warned = False

    @staticmethod
    def example(part: Part) -> Mapping[str, Any]:
        """Every node bonded to the node of the same number of a part beside."""
        other = Part(f"{part.name} beside", Everywhere(), dimension=part.dimension)
        other.place(part.positions + 0.1, 1.0)
        return {"connection": GivenRows(part, other, np.arange(len(part) + 1), np.arange(len(part))), "path": "bonds"}

    @property
    def reads(self) -> tuple[Any, ...]:  # type: ignore[override]
        """Positions of both parts in the configuration."""
        fields = (reference_position, *((displacement,) if self.configuration == "current" else ()))
        return (*fields, *((self.other, field) for field in fields))

    def attach(self) -> None:
        super().attach()
        self._rows()

    def apply(self, clock: Clock) -> None:
        self.write(self.frame(clock, "vtu"))
        vtu.write_collection(self.path.with_name(f"{self.path.name}.pvd"), self.frames)

    def write(self, file: str | Path) -> None:
        """Writes one VTU file, now."""
        offsets, neighbors = self._rows()
        if not len(neighbors) and not self._warned:
            self._warned = True
            log.warning("%s: no node of '%s' is bonded to '%s'", self.label, self.part.name, self.other.name)
        sizes = np.diff(offsets)
        here, there = np.flatnonzero(sizes), np.unique(neighbors)
        # points of the file: nodes of the one part that have bonds, and behind them those of the other
        places = np.cumsum(sizes > 0) - 1
        ends = np.stack([np.repeat(places, sizes), len(here) + np.searchsorted(there, neighbors)], axis=1)
        points = np.concatenate([self.positions()[here], self.positions_of(self.other)[there]])
        counts = np.bincount(neighbors, minlength=len(self.other))
        grid = vtu.Grid(
            points,
            vtu.cells(len(points), ends),
            {
                "is_other": np.repeat(np.array([0, 1], np.uint8), [len(here), len(there)]),
                "node": np.concatenate([here, there]),
                "family_size": np.concatenate([sizes[here], counts[there]]),
            },
            bond_data(len(points), ends, points),
        )
        vtu.write_grid(Path(file), grid)

    def _rows(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The rows of the connection.

        Raises:
            BadInput: if they do not fit the parts.
        """
        offsets, neighbors = (np.asarray(rows, np.int64) for rows in self.connection.as_rows())
        count, most = len(self.part), len(self.other)
        fits = offsets.shape == (count + 1,) and offsets[0] == 0 and offsets[-1] == len(neighbors)
        if not fits or (np.diff(offsets) < 0).any():
            raise BadInput(
                f"{self.label}: the offsets of {self.connection!r} must be {count + 1} numbers that rise from 0 to the "
                f"number of bonds, {len(neighbors)}: search the bonds again"
            )
        if len(neighbors) and not 0 <= neighbors.min() <= neighbors.max() < most:
            raise BadInput(
                f"{self.label}: {self.connection!r} leads to node {neighbors.max()} of part '{self.other.name}', which "
                f"has the nodes 0 to {most - 1}: search the bonds again"
            )
        return offsets, neighbors
