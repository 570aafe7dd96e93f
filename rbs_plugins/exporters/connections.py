"""ConnectionExporter: bonds between two parts, to be looked at."""

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
    """Writes the nodes of two parts that are bonded to each other, and these bonds as lines, in world coordinates.

    Args:
        connection: connection of two parts; of a connected part all its nodes and bonds are written.
        path: folder and beginning of the file names: `<path>_<step>.vtu` and `<path>.pvd`, as VTKExporter.
        configuration: "reference" (default) or "current" positions.
        when: trigger; the first step if not given.

    Raises:
        BadInput: on what is no connection, on an unknown configuration; at the start of the run, if the folder cannot
            be written.
        MissingField: before the part is connected.

    Point data: `is_other`, 1 for nodes of the second part, `node`, the number of the node in its part, and
    `family_size`, the number of bonds that it feels here. There is one line for each pair of bonded nodes, with the
    cell data `node` and `neighbor` (numbers of points of the file), `bond_vector` and `bond_length` (m, in the
    configuration), and `intact`; vertices, one for each node, have no neighbor (-1) and length 0.

    Bonds that are searched again during a run are written as they are at the frame. `write(file)` writes without a run.
    """

    example = {"path": "bonds"}
    storages = ("list", "lattice")

    def __init__(
        self,
        connection: Connection | Part,
        path: str | Path,
        *,
        configuration: str = "reference",
        when: Trigger = once,
    ) -> None:
        if not isinstance(connection, Connection | Part):
            raise BadInput(f"ConnectionExporter: {connection!r} is no connection: give a Connection(part, other, ...)")
        self.host = connection
        self.ends = connection.ends if isinstance(connection, Connection) else (connection,)
        self.connections = (connection,) if isinstance(connection, Connection) else ()
        super().__init__(self.ends[0], (), path, configuration=configuration, when=when)
        _ = connection.bonds  # refused here if they are not there

    @property
    def label(self) -> str:
        """Name in reports, and in checkpoints: two exporters of one connection differ by their files."""
        return f"{type(self).__name__} '{self.host.name}' {self.path.name}"

    def __repr__(self) -> str:
        return super().__repr__().replace(f"({self.part.name}", f"({self.host.name}", 1)

    @property
    def reads(self) -> tuple[Any, ...]:  # type: ignore[override]
        """Positions of the parts in the configuration, and which bonds hold."""
        fields = (reference_position, *((displacement,) if self.configuration == "current" else ()))
        return (*((end, field) for end in self.ends for field in fields), (self.host, intact))

    def apply(self, clock: Clock) -> None:
        self.write(self.frame(clock, "vtu"))
        vtu.write_collection(self.path.with_name(f"{self.path.name}.pvd"), self.frames)

    def write(self, file: str | Path) -> None:
        """Writes one VTU file, now."""
        host, bonds = self.host, self.host.bonds
        nodes = host.nodes if isinstance(host, Connection) else (np.arange(len(host)),)
        places = [self.positions_of(end)[chosen] for end, chosen in zip(self.ends, nodes, strict=True)]
        points = np.concatenate(places)
        sizes = bonds.counts()
        starts, neighbors = np.repeat(np.arange(len(points)), sizes), bonds.as_rows()[1].astype(np.int64)
        # bonds that both ends feel are there twice, and break together
        pairs = np.minimum(starts, neighbors) * len(points) + np.maximum(starts, neighbors)
        once_each = np.unique(pairs, return_index=True)[1]
        ends = np.stack([starts, neighbors], axis=1)[once_each]
        holds = np.asarray(self[host, intact], np.uint8)[once_each]
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
