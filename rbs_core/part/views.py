"""Node and Neighborhood: windows of two slots on the arrays of a part, for looking, set-ups and tests.

Reading a field returns its entry, assigning writes into the array. Loops over many nodes belong in compiled loops.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput
from rbs_core.fields import Field

if TYPE_CHECKING:
    from rbs_core.part.discretized import Discretized


class Node:
    """One node of a part: `node[displacement]`, `node.neighborhood`."""

    __slots__ = ("index", "part")

    def __init__(self, part: Discretized, index: int) -> None:
        if not -len(part) <= index < len(part):
            raise BadInput(f"part '{part.name}' has no node {index}: its nodes are 0 to {len(part) - 1}")
        self.part = part
        self.index = int(index) % len(part)

    def __getitem__(self, field: Field) -> Any:
        return self._array(field)[self.index]

    def __setitem__(self, field: Field, value: ArrayLike) -> None:
        self._array(field)[self.index] = value

    def _array(self, field: Field) -> NDArray[Any]:
        if field.at != "node":
            other = "node.neighborhood[...]" if field.at == "bond" else "part[...]"
            raise BadInput(f"'{field.name}' lives at the {field.at}, not at a node: ask for {other}")
        return self.part[field]

    @property
    def neighborhood(self) -> Neighborhood:
        """The bonds of this node."""
        return Neighborhood(self.part, self.index)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Node) and self.part is other.part and self.index == other.index

    def __hash__(self) -> int:
        return hash((id(self.part), self.index))

    def __repr__(self) -> str:
        return f"<node {self.index} of part '{self.part.name}'>"


class Neighborhood:
    """The bonds of one node: iterates over the neighbors, each a Node that has a neighborhood itself."""

    __slots__ = ("index", "part")

    def __init__(self, part: Discretized, index: int) -> None:
        self.part, self.index = part, index

    @property
    def neighbors(self) -> NDArray[Any]:
        """Indices of the neighbors, ascending."""
        return self.part.bonds.neighbors(self.index)

    def __len__(self) -> int:
        return len(self.neighbors)

    def __iter__(self) -> Iterator[Node]:
        return (Node(self.part, int(neighbor)) for neighbor in self.neighbors)

    def __getitem__(self, field: Field) -> NDArray[Any]:
        """Entries of a bond field for these bonds, or of a node field at the neighbors (a copy)."""
        if field.at == "bond":
            return np.asarray(self.part[field][self.part.bonds.family(self.index)])
        if field.at != "node":
            raise BadInput(f"'{field.name}' lives at the part, not at its nodes: ask for part[...]")
        return np.asarray(self.part[field][self.neighbors])

    def __setitem__(self, field: Field, value: ArrayLike) -> None:
        if field.at != "bond":
            raise BadInput(f"'{field.name}' lives at the {field.at}: assign through that, not through the neighborhood")
        entries, family = self.part[field], self.part.bonds.family(self.index)
        if entries.flags.writeable:
            entries[family] = value
        else:  # a lattice makes arrays of bond fields for the occasion
            changed = entries.copy()
            changed[family] = value
            self.part[field] = changed

    def reach(self, walks: int = 2) -> NDArray[np.int64]:
        """Indices of all nodes that up to so many walks from neighbor to neighbor lead to, without this one."""
        found = {self.index}
        edge = {self.index}
        for _ in range(walks):
            edge = {int(j) for i in edge for j in self.part.bonds.neighbors(i)} - found
            found |= edge
        return np.array(sorted(found - {self.index}), dtype=np.int64)

    def __repr__(self) -> str:
        return f"<neighborhood of node {self.index} of part '{self.part.name}': {len(self)} neighbors>"
