"""What a tangent offers: the matrix of the linearised forces, and its product with a vector."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from rbs_core import Part

Array = NDArray[np.float64]


class Tangent(ABC):
    """K = −d(V f)/du in N/m: how the forces of nodes resist a small change of the displacements.

    Rows and columns are node by node, over the parts in order: component c of node n of the first part is n d + c. The
    damage is held, and so is the state of laws that have one; loads and boundaries are not in it.

    Attributes:
        ends: the parts whose displacements it takes.
        symmetric: whether K is symmetric, as that of forces that come from an energy.
        constant: whether K is known to be the same for all displacements, as long as the same bonds hold.
        grounded: whether a body is pulled back to its place, as by springs to the ground: static solvers ask for no
            supports then.
    """

    ends: tuple[Part, ...]
    symmetric: bool
    constant: bool = False
    grounded: bool = False

    @abstractmethod
    def update(self) -> None:
        """Linearises about the present displacement, damage and time of the parts."""

    @abstractmethod
    def matrix(self) -> csr_array[Any]:
        """K, (dN, dN), N/m, with sorted columns.

        The arrays are the tangent's own: as long as the bonds are the same, the next call gives the same structure with
        other numbers in the same place.
        """

    @abstractmethod
    def multiply(self, v: Array, out: Array) -> None:
        """Adds K v to `out`, both (dN,), without a matrix; the same to the bit for any number of threads."""

    @abstractmethod
    def diagonal(self, out: Array) -> None:
        """Adds the diagonal of K to `out`, (dN,)."""

    @property
    def size(self) -> int:
        """Number of unknowns dN."""
        return sum(len(end) * end.dimension for end in self.ends)
