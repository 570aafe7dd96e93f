"""CrackPath: cracks as polylines."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from rbs_core import BadInput, Exporter, Part, Trigger, always
from rbs_core.files import writable_folder, written_whole
from rbs_core.space import convert, world
from rbs_core.trigger import Clock
from rbs_plugins.fields import damage, reference_position
from rbs_plugins.measures.crack import THRESHOLD, checked_threshold

AXES = "xyz"


class CrackPath(Exporter):
    """Writes polylines through the damaged nodes into `<path>_<step>.csv`, the longest first, then its branches.

    Args:
        part: 2-D or 3-D part; a relation such as Damage writes its damage in front of this one.
        path: folder and beginning of the file names.
        threshold: nodes with more damage than this belong to cracks, between 0 and 1.
        within: geometry, mask, indices or node set to look at; the body of the part if not given. A crack in 3-D is a
            surface: take a slab one spacing thick for its trace there.
        when: trigger.

    Attributes:
        paths: list of (k, d) arrays, m, as of the last look, see `crack_paths`.

    Raises:
        BadInput: on a 1-D part, a threshold out of range, a region without nodes, or a part without spacing; at the
            start of the run, if the folder cannot be written.

    A row is a point: number of the polyline, and its reference position in coordinates of the world.
    """

    reads = (damage, reference_position)

    @staticmethod
    def example(part: Part) -> dict[str, Any] | None:
        """All cracks; a bar has none."""
        return None if part.dimension == 1 else {"path": "crack"}

    def __init__(
        self, part: Part, path: str | Path, *, threshold: float = THRESHOLD, within: Any = None, when: Trigger = always
    ) -> None:
        super().__init__(part, when=when)
        self.path = Path(path)
        if part.dimension == 1:
            raise BadInput(f"{self.label}: a crack in a 1-D part is a point: take CrackTip")
        self.threshold = checked_threshold(self.label, threshold)
        self.nodes = part.body if within is None else part.where(within)
        if not len(self.nodes):
            raise BadInput(f"{self.label}: no node lies in {within!r}: check the region or the spacing")
        if part.spacing is None:
            raise BadInput(f"{self.label}: the distance of neighbors is not known: part.place(..., spacing=...)")
        self.spacing = part.spacing
        self.paths: list[NDArray[np.float64]] = []

    @property
    def label(self) -> str:
        """Name in reports, and in checkpoints: two exporters of one part differ by their files."""
        return f"{super().label} {self.path.name}"

    def attach(self) -> None:
        writable_folder(self.path.parent)

    def apply(self, clock: Clock) -> None:
        broken = self.nodes[self[damage][self.nodes] > self.threshold]
        self.paths = crack_paths(self[reference_position][broken], self.spacing)
        file_name = self.path.with_name(f"{self.path.name}_{clock.step:08d}.csv")
        with written_whole(file_name) as partial, partial.open("w", encoding="utf-8", newline="") as file:
            rows = csv.writer(file, lineterminator="\n")
            rows.writerow(["path", *(f"{axis} [m]" for axis in AXES[: self.part.dimension])])
            for number, points in enumerate(self.paths):
                places = points if self.part.system is world else convert(points, self.part.system, world)
                rows.writerows([number, *map(repr, place)] for place in places.tolist())


def crack_paths(points: NDArray[np.float64], spacing: float) -> list[NDArray[np.float64]]:
    """Polylines through damaged nodes.

    Args:
        points: (n, d) of the damaged nodes, m.
        spacing: of the nodes, m.

    Returns:
        (k, d) arrays, the longest first. Nodes up to 1.6 spacings apart are linked. The first polyline of a cluster is
        the shortest way along links between two nodes that are (nearly) the farthest apart; each point of it becomes
        the mean of the nodes within 1.6 spacings, so it runs in the middle of the damaged band. Further ones are found
        in the same way among the nodes that are more than 2.5 spacings from all those before. What is shorter than 3
        spacings is no path. A polyline begins at the end with the lower first coordinate.
    """
    left, found = np.ones(len(points), np.bool_), []
    while left.any():
        chosen = points[left]
        pairs = cKDTree(chosen).query_pairs(1.6 * spacing, output_type="ndarray")
        sizes = np.linalg.norm(chosen[pairs[:, 0]] - chosen[pairs[:, 1]], axis=1)
        graph = coo_array((sizes, (pairs[:, 0], pairs[:, 1])), (len(chosen), len(chosen))).tocsr()
        ways = [_longest(graph, chosen, members) for members in _clusters(graph)]
        ways = [way for way in ways if _length(way) >= 3 * spacing]
        if not ways:
            break
        for way in ways:
            near = cKDTree(chosen).query_ball_point(way, 1.6 * spacing)
            middle = np.array([chosen[sorted(each)].mean(axis=0) for each in near])
            keep = np.concatenate([[True], np.linalg.norm(np.diff(middle, axis=0), axis=1) > 1e-3 * spacing])
            found.append(middle[keep])
        away = cKDTree(np.concatenate(ways)).query(points)[0] > 2.5 * spacing
        left &= away
    return sorted(found, key=_length, reverse=True)


def _clusters(graph: Any) -> list[NDArray[np.int64]]:
    count, labels = connected_components(graph, directed=False)
    order = np.argsort(labels, kind="stable")
    return np.split(order, np.searchsorted(labels[order], np.arange(1, count)))


def _longest(graph: Any, points: NDArray[np.float64], members: NDArray[np.int64]) -> NDArray[np.float64]:
    """The way between two ends of a cluster: the farthest from some node, and the farthest from that."""
    inner = graph[members][:, members]
    first = int(np.argmin(points[members] @ np.arange(points.shape[1], 0, -1)))
    for _ in range(2):
        away, before = dijkstra(inner, directed=False, indices=first, return_predecessors=True)
        first, start = int(np.argmax(away)), first
    way = [first]
    while way[-1] != start:
        way.append(int(before[way[-1]]))
    found = points[members[way]]
    return found if tuple(found[0]) <= tuple(found[-1]) else found[::-1]


def _length(points: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
