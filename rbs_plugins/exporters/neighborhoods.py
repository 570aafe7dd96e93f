"""NeighborhoodExporter: sizes of families, and the bonds of some nodes, to be looked at."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import Clock, Part, Trigger, intact, once
from rbs_plugins.exporters import vtu
from rbs_plugins.exporters.frames import FrameExporter
from rbs_plugins.exporters.reductions import nodes_of
from rbs_plugins.fields import displacement, reference_position


class NeighborhoodExporter(FrameExporter):
    """Writes the nodes of a part with the sizes of their families, and the bonds of chosen nodes as lines.

    Args:
        part: connected part.
        path: folder and beginning of the file names: `<path>_<step>.vtu` and `<path>.pvd`, as VTKExporter.
        of: region of nodes whose bonds are written (a geometry, a mask, indices, a function of the positions, or the
            name of a node set of the part). If not given, the first node of every size of family that there is: one
            example of each kind.
        configuration: "reference" (default) or "current" positions.
        when: trigger; the first step if not given.

    Raises:
        BadInput: on a region without nodes, a node set that does not exist, or an unknown configuration.
        MissingField: before the part is connected.

    Point data: `family_size`, `missing_neighbors` (to the largest family of the part), `broken_bonds`, and `chosen`, 1
    where bonds are written. Cell data of lines: `node` and `neighbor`, `bond_vector` and `bond_length` (m, in the
    configuration), and `intact`; vertices, one for each node, have no neighbor (-1) and length 0.

    `write(file)` writes without a run, when a part is connected.
    """

    example = {"path": "families"}
    storages = ("list", "lattice")

    def __init__(
        self, part: Part, path: str | Path, *, of: Any = None, configuration: str = "reference", when: Trigger = once
    ) -> None:
        super().__init__(part, (), path, configuration=configuration, when=when)
        _ = part.bonds  # refused here if they are not there
        self.of = of
        self._nodes = nodes_of(self.label, part, of)

    @property
    def reads(self) -> tuple[Any, ...]:  # type: ignore[override]
        """Positions of the configuration, and which bonds hold."""
        return (reference_position, *((displacement,) if self.configuration == "current" else ()), intact)

    def apply(self, clock: Clock) -> None:
        self.write(self.frame(clock, "vtu"))
        vtu.write_collection(self.path.with_name(f"{self.path.name}.pvd"), self.frames)

    def write(self, file: str | Path) -> None:
        """Writes one VTU file, now."""
        bonds, points = self.part.bonds, self.positions()
        sizes = bonds.counts()
        nodes = np.unique(sizes, return_index=True)[1] if self._nodes is None else self._nodes
        chosen = np.zeros(len(points), np.uint8)
        chosen[nodes] = 1
        neighbors = [np.asarray(bonds.neighbors(int(node)), np.int64) for node in nodes]
        ends = np.stack([np.repeat(nodes, sizes[nodes]), np.concatenate(neighbors)], axis=1)
        # a lattice unpacks the bits of all bonds to show whether they hold: once, and only if some do not
        held = self[intact] if bonds.has_broken else None
        holds = np.ones(len(ends), np.uint8)
        if held is not None:
            holds = np.concatenate([np.asarray(held[bonds.family(int(node))], np.uint8) for node in nodes])
        grid = vtu.Grid(
            points,
            vtu.cells(len(points), ends),
            {
                "family_size": sizes,
                "missing_neighbors": sizes.max() - sizes,
                "broken_bonds": _broken(sizes, held),
                "chosen": chosen,
            },
            {**bond_data(len(points), ends, points), "intact": np.concatenate([np.ones(len(points), np.uint8), holds])},
        )
        vtu.write_grid(Path(file), grid)


def _broken(sizes: NDArray[np.int64], held: NDArray[Any] | None) -> NDArray[np.int64]:
    """(n,) number of broken bonds of each node, from the sizes of families and which bonds hold; all, if None."""
    if held is None:
        return np.zeros(len(sizes), np.int64)
    nodes = np.searchsorted(np.cumsum(sizes), np.flatnonzero(held == 0), side="right")
    return np.bincount(nodes, minlength=len(sizes))


def bond_data(count: int, ends: NDArray[np.int64], points: NDArray[np.float64]) -> dict[str, NDArray[Any]]:
    """Cell data of vertices, so many, and behind them of lines between two points each.

    Args:
        count: number of vertices.
        ends: (k, 2) numbers of points.
        points: (n, 3) m.
    """
    vectors = np.zeros((count + len(ends), 3))
    vectors[count:] = points[ends[:, 1]] - points[ends[:, 0]]
    return {
        "node": np.concatenate([np.arange(count), ends[:, 0]]),
        "neighbor": np.concatenate([np.full(count, -1), ends[:, 1]]),
        "bond_vector": vectors,
        "bond_length": np.linalg.norm(vectors, axis=1),
    }
