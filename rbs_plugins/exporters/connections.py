"""ConnectionExporter: the bonds of a connection, to be looked at."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from rbs_core import BadInput, Clock, Part, Trigger, intact, once
from rbs_core.part import Connection
from rbs_plugins.exporters import vtu
from rbs_plugins.exporters.frames import FrameExporter
from rbs_plugins.exporters.neighborhoods import bond_data
from rbs_plugins.fields import displacement, reference_position


class ConnectionExporter(FrameExporter):
    """Writes the nodes that a connection bonds to each other, and these bonds as lines, in world coordinates.

    Args:
        connection: between two parts, or within one.
        path: folder and beginning of the file names: `<path>_<step>.vtu` and `<path>.pvd`, as VTKExporter.
        configuration: "reference" (default) or "current" positions.
        when: trigger; the first step if not given.

    Raises:
        BadInput: on what is no connection, on an unknown configuration; at the start of the run, if the folder cannot
            be written.

    Point data: `is_other`, 1 for nodes of the second part, `node`, the number of the node in its part, and
    `family_size`, the number of bonds that it feels here. There is one line for each pair of bonded nodes, with the
    cell data `node` and `neighbor` (numbers of points of the file), `bond_vector` and `bond_length` (m, in the
    configuration), and `intact`; vertices, one for each node, have no neighbor (-1) and length 0.

    Bonds that are searched again during a run are written as they are at the frame. `write(file)` writes without a run.
    """

    storages = ("list", "lattice")

    def __init__(
        self,
        connection: Connection,
        path: str | Path,
        *,
        configuration: str = "reference",
        when: Trigger = once,
    ) -> None:
        if not isinstance(connection, Connection):
            raise BadInput(f"ConnectionExporter: {connection!r} is no connection: give a Connection(part, other, ...)")
        self.connection, self.connections = connection, (connection,)
        super().__init__(connection.ends[0], (), path, configuration=configuration, when=when)

    @staticmethod
    def example(part: Part) -> dict[str, Any]:
        """Bonds within the part."""
        return {"connection": Connection(part, horizon=1.5 * (part.spacing or 1.0)), "path": "bonds"}

    @property
    def label(self) -> str:
        """Name in reports, and in checkpoints: two exporters of one connection differ by their files."""
        return f"{type(self).__name__} '{self.connection.name}' {self.path.name}"

    def __repr__(self) -> str:
        return super().__repr__().replace(f"({self.part.name}", f"({self.connection.name}", 1)

    @property
    def reads(self) -> tuple[Any, ...]:  # type: ignore[override]
        """Positions of the parts in the configuration, and which bonds hold."""
        fields = (reference_position, *((displacement,) if self.configuration == "current" else ()))
        return (*((end, field) for end in self.connection.ends for field in fields), (self.connection, intact))

    def apply(self, clock: Clock) -> None:
        self.write(self.frame(clock, "vtu"))
        vtu.write_collection(self.path.with_name(f"{self.path.name}.pvd"), self.frames)

    def write(self, file: str | Path) -> None:
        """Writes one VTU file, now."""
        bonds, nodes = self.connection.bonds, self.connection.nodes
        places = [self.positions_of(end)[chosen] for end, chosen in zip(self.connection.ends, nodes, strict=True)]
        points = np.concatenate(places)
        sizes = bonds.counts()
        starts, neighbors = np.repeat(np.arange(len(points)), sizes), bonds.as_rows()[1].astype(np.int64)
        first = starts < neighbors  # a bond that both ends feel is there twice, and breaks at both
        ends = np.stack([starts, neighbors], axis=1)[first]
        holds = np.asarray(self[self.connection, intact], np.uint8)[first]
        grid = vtu.Grid(
            points,
            vtu.cells(len(points), ends),
            {
                "is_other": np.repeat(np.arange(len(nodes), dtype=np.uint8), [len(chosen) for chosen in nodes]),
                "node": np.concatenate(nodes),
                "family_size": sizes,
            },
            {**bond_data(len(points), ends, points), "intact": np.concatenate([np.ones(len(points), np.uint8), holds])},
        )
        vtu.write_grid(Path(file), grid)
