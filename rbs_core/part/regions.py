"""Regions: which nodes of a part are meant by a geometry, a mask, indices, a function or the name of a node set."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput, nearest
from rbs_core.geometry import Geometry

Region = Geometry | ArrayLike | Callable[[NDArray[np.float64]], ArrayLike] | str
Sets = Mapping[str, NDArray[np.int64]]


def nodes_in(owner: str, region: Region, positions: NDArray[np.float64], sets: Sets) -> NDArray[np.int64]:
    """Ascending indices of the nodes in a region.

    Args:
        owner: for messages, e.g. "part 'plate'".
        region: geometry, mask (n,), indices (k,), function of the positions that returns one of these two, or name of a
            node set.
        positions: (n, d) of all nodes, m.
        sets: the node sets by name.

    Raises:
        BadInput: on anything else, a mask of another length, an index that does not exist, or an unknown name (with the
            nearest ones).
    """
    if isinstance(region, Geometry):
        return np.flatnonzero(region.contains(positions))
    if isinstance(region, str):
        if region not in sets:
            raise BadInput(f"{owner} has no node set {region!r}: {nearest(region, sets)}")
        return sets[region].copy()
    chosen = np.asarray(region(positions) if callable(region) else region)
    count = len(positions)
    if chosen.dtype == np.bool_:
        if chosen.shape != (count,):
            raise BadInput(f"{owner}: a mask must have shape ({count},), got {chosen.shape}")
        return np.flatnonzero(chosen)
    if chosen.dtype.kind not in "iu" or chosen.ndim != 1:
        raise BadInput(
            f"{owner}: a region is a geometry, a mask, indices, a function or the name of a node set, got {region!r}"
        )
    if len(chosen) and (chosen.min() < 0 or chosen.max() >= count):
        raise BadInput(f"{owner}: node indices must lie in 0..{count - 1}")
    return np.unique(chosen).astype(np.int64)


class NodeSets(Mapping[str, NDArray[np.int64]]):
    """The named regions of a part: name to ascending indices (k,) of nodes, which cannot be written.

    `part.node_sets["left"] = region` makes or replaces one, from whatever `part.where` takes; `del` takes it away. They
    belong to the nodes, and go when these are made anew.

    Raises:
        BadInput: on a name that does not exist (with the nearest ones), a name that is no text, or a region without
            nodes.
    """

    def __init__(
        self, owner: str, held: dict[str, NDArray[np.int64]], find: Callable[[Any], NDArray[np.int64]]
    ) -> None:
        self._owner, self._held, self._find = owner, held, find

    def __getitem__(self, name: str) -> NDArray[np.int64]:
        if name not in self._held:
            raise BadInput(f"{self._owner} has no node set {name!r}: {nearest(str(name), self._held)}")
        return self._held[name]

    def __setitem__(self, name: str, region: Region) -> None:
        if not isinstance(name, str) or not name:
            raise BadInput(f"{self._owner}: the name of a node set must be a text, got {name!r}")
        nodes = self._find(region).copy()
        if not len(nodes):
            raise BadInput(f"{self._owner}: the node set {name!r} would be empty: check the region")
        nodes.flags.writeable = False
        self._held[name] = nodes

    def __delitem__(self, name: str) -> None:
        self[name]  # an unknown one is refused
        del self._held[name]

    def __contains__(self, name: object) -> bool:
        return name in self._held

    def get(self, name: str, default: Any = None) -> Any:
        """The node set, or the default if there is none."""
        return self._held.get(name, default)

    def __iter__(self) -> Iterator[str]:
        return iter(self._held)

    def __len__(self) -> int:
        return len(self._held)

    def __repr__(self) -> str:
        sets = ", ".join(f"{name} ({len(nodes)})" for name, nodes in self._held.items())
        return f"<node sets of {self._owner}: {sets or 'none'}>"
