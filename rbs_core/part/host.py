"""Host: what fields live on, a part or the bonds between two parts."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.fields import Field, FieldStore
from rbs_core.part.neighborhoods import Bonds


class Host(ABC):
    """What fields live on.

    Attributes:
        name: used in messages, reports and files; unique within an analysis.
        dimension: 1, 2 or 3.
        precision: "double" or "single", of its real numbers.
        thickness: of a 2-D host, m, otherwise None.
        area: of a 1-D host, m^2, otherwise None.
        spacing: typical distance of nodes, m, if known.
    """

    name: str
    dimension: int
    precision: str
    thickness: float | None
    area: float | None
    spacing: float | None

    @abstractmethod
    def __len__(self) -> int:
        """Number of nodes."""

    @abstractmethod
    def __setitem__(self, field: Field, value: Any) -> None:
        """Sets every entry of a field."""

    @abstractmethod
    def store(self, at: str) -> FieldStore:
        """The arrays of one place: "node", "bond" or "part"."""

    @property
    @abstractmethod
    def fields(self) -> list[Field]:
        """The fields that have an array now."""

    @property
    @abstractmethod
    def nbytes(self) -> int:
        """Bytes of all fields and bonds."""

    @property
    @abstractmethod
    def bonds(self) -> Bonds:
        """The bonds.

        Raises:
            MissingField: if there are none.
        """

    @property
    @abstractmethod
    def connected(self) -> bool:
        """True if there are bonds."""

    @property
    @abstractmethod
    def version(self) -> tuple[int, int | None]:
        """Numbers of the present nodes and bonds: they change when these are made anew."""

    @property
    @abstractmethod
    def positions(self) -> NDArray[np.float64]:
        """(n, d) reference positions of its nodes, m."""

    @property
    def searched_again(self) -> bool:
        """True if bonds come and go during a run: they are no part of what a scene is."""
        return False

    def raw(self, field: Field) -> NDArray[Any]:
        """What is really held of a field, made if it was not there: bits, for instance, for the bonds of a lattice."""
        return self.store(field.at).raw(field)

    def __contains__(self, field: Field) -> bool:
        return field in self.store(field.at)

    def __getitem__(self, field: Field) -> NDArray[Any]:
        return self.store(field.at).get(field)
