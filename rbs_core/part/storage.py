"""How the bonds of a part are held: what every representation must be able to do."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.fields import Field, FieldStore

TOLERANCE = 1e-9  # of a horizon: nodes on it belong to the family in every direction alike
Of = Callable[[NDArray[np.float64]], NDArray[np.float64]]
Crosses = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.bool_]]


class Storage(ABC):
    """The directed bonds of a part; nodes in ascending order, and the neighbors of a node in ascending order.

    Attributes:
        name: of the representation, as in `connect(storage=...)`.
        fields: the arrays of bond fields.
    """

    name: str
    fields: FieldStore

    @abstractmethod
    def __len__(self) -> int:
        """Number of directed bonds."""

    @abstractmethod
    def as_rows(self) -> tuple[NDArray[np.int64], NDArray[np.uint32]]:
        """Offsets (n+1,) and neighbors (m,) as compressed rows."""

    @abstractmethod
    def offsets(self) -> NDArray[np.int64]:
        """(n+1,) first bond of each node in the bond fields."""

    @abstractmethod
    def neighbors(self, node: int) -> NDArray[Any]:
        """Neighbors of a node, ascending."""

    @abstractmethod
    def inverse_lengths(self) -> NDArray[np.float64]:
        """(m,) 1 / reference length, 1/m."""

    @abstractmethod
    def mark(self, field: Field, inside: NDArray[np.bool_]) -> None:
        """Sets a bond field of the type uint8 to 1 where both ends are inside (n,), to 0 elsewhere."""

    @abstractmethod
    def tabulate(self, field: Field, function: Of) -> None:
        """Sets a bond field to a function of the reference bonds ξ, (k, d) -> (k,), m."""

    @abstractmethod
    def cut(self, crosses: Crosses, near: NDArray[np.bool_]) -> tuple[int, int]:
        """Breaks bonds that cross, of nodes that are near (n,). Returns how many broke and how many cross."""

    @abstractmethod
    def remove(self, crosses: Crosses, near: NDArray[np.bool_]) -> int:
        """Takes away bonds that cross, of nodes that are near (n,). Returns how many went."""

    @property
    @abstractmethod
    def has_broken(self) -> bool:
        """True if any bond is broken."""

    @abstractmethod
    def holds(self, nodes: NDArray[np.int64], others: NDArray[np.int64]) -> NDArray[np.bool_]:
        """(k,) True for pairs of nodes between which there is a bond, and it is intact."""

    @abstractmethod
    def arrays(self) -> tuple[NDArray[Any], ...]:
        """What tells these bonds from others: equal arrays mean equal bonds."""

    @property
    @abstractmethod
    def nbytes(self) -> int:
        """Bytes held, bond fields included."""
