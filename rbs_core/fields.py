"""Fields: a declaration says what an array means; a store holds the arrays of one place, and only those asked for."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput, FieldClash, MissingField
from rbs_core.space.checks import as_real

PLACES = ("node", "bond", "part")
SHAPES = ("scalar", "vector", "tensor")


@dataclass(frozen=True)
class Field:
    """The declaration of an array: relations name fields, the scene allocates those that somebody named.

    Attributes:
        name: a Python identifier, unique in the vocabulary.
        at: "node", "bond" (directed: one entry per node and neighbor) or "part" (one value for the whole part).
        shape: "scalar", "vector" (d entries, d the dimension of the part) or "tensor" (d x d).
        unit: SI unit, "1" if dimensionless.
        symbol: as in the papers.
        doc: one sentence.
        dtype: numpy name of the type of one entry.
        initial: value before anybody has set it.
        exact: always in double precision, also in parts of single precision.
    """

    name: str
    at: str
    shape: str
    unit: str
    symbol: str
    doc: str
    dtype: str = "float64"
    initial: float = 0.0
    exact: bool = False

    def __post_init__(self) -> None:
        if not self.name.isidentifier():
            raise BadInput(f"Field({self.name!r}): the name must be a Python identifier, so that laws can ask for it")
        if self.at not in PLACES:
            raise BadInput(f"Field({self.name!r}): at={self.at!r} must be one of {', '.join(PLACES)}")
        if self.shape not in SHAPES:
            raise BadInput(f"Field({self.name!r}): shape={self.shape!r} must be one of {', '.join(SHAPES)}")
        if not self.doc:
            raise BadInput(f"Field({self.name!r}): say in one sentence (doc=...) what it is")

    def entry(self, dimension: int) -> tuple[int, ...]:
        """Shape of one entry in a part of that dimension."""
        return (dimension,) * SHAPES.index(self.shape)

    def __repr__(self) -> str:
        return f"Field({self.name!r}, at={self.at!r}, shape={self.shape!r}, unit={self.unit!r})"


reference_position = Field(
    "reference_position", "node", "vector", "m", "X", "Where the node was at the start.", exact=True
)
volume = Field("volume", "node", "scalar", "m^3", "V", "Volume that the node stands for.")
intact = Field("intact", "bond", "scalar", "1", "μ", "1 while the bond holds, 0 once broken.", "uint8", 1)
is_fictitious = Field(
    "is_fictitious", "node", "scalar", "1", "χ", "1 for nodes of a layer beyond the body, 0 for those of it.", "uint8"
)

KERNEL_FIELDS = (reference_position, volume, intact, is_fictitious)


class FieldStore:
    """The arrays of one place (nodes, bonds or the part itself), allocated on demand, one per field.

    Args:
        owner: name used in messages, e.g. "part 'plate'".
        at: the place.
        count: number of entries, None for place "part".
        dimension: 1, 2 or 3.
        real: type of real numbers, "float64" or "float32", for fields that need not be exact.
    """

    def __init__(self, owner: str, at: str, count: int | None, dimension: int, real: str = "float64") -> None:
        self.owner, self.at, self.count, self.dimension, self.real = owner, at, count, dimension, real
        self._arrays: dict[str, tuple[Field, NDArray[Any]]] = {}
        self.given: set[Field] = set()

    def __contains__(self, field: Field) -> bool:
        return field.name in self._arrays

    def __iter__(self) -> Iterator[Field]:
        return (field for field, _ in self._arrays.values())

    def shape(self, field: Field) -> tuple[int, ...]:
        """Shape of the whole array of a field."""
        lead = () if self.count is None else (self.count,)
        return lead + field.entry(self.dimension)

    def dtype(self, field: Field) -> np.dtype[Any]:
        """Type of the entries of a field here."""
        return np.dtype(self.real if field.dtype == "float64" and not field.exact else field.dtype)

    def allocate(self, field: Field) -> NDArray[Any]:
        """The array of a field, made with its initial value if it was not there.

        Raises:
            FieldClash: if another field of the same name is there, or the field belongs to another place.
        """
        if field.at != self.at:
            raise FieldClash(f"{field!r} lives at {field.at}s, not at the {self.at}s of {self.owner}")
        held = self._arrays.get(field.name)
        if held is None:
            held = (field, np.full(self.shape(field), field.initial, dtype=self.dtype(field)))
            self._arrays[field.name] = held
        elif held[0] != field:
            raise FieldClash(
                f"{self.owner} holds {held[0]!r}, and {field!r} has the same name but means something else: rename one"
            )
        return held[1]

    def size(self, field: Field) -> int:
        """Bytes that a field takes here, or would take."""
        return math.prod(self.shape(field)) * self.dtype(field).itemsize

    def raw(self, field: Field) -> NDArray[Any]:
        """What is really held of a field, made if it was not there: the array itself, unless a store packs it."""
        return self.allocate(field)

    def get(self, field: Field) -> NDArray[Any]:
        """The array of a field that is there.

        Raises:
            MissingField: if nobody has set or declared it.
        """
        if field.name not in self._arrays:
            have = ", ".join(sorted(self._arrays)) or "none"
            raise MissingField(
                f"{self.owner} has no field '{field.name}': assign part[{field.name}] = ..., or add a relation that "
                f"writes it and prepare the analysis (fields there now: {have})"
            )
        return self.allocate(field)

    def set(self, field: Field, value: ArrayLike) -> None:
        """Sets every entry: a number, one entry, or one entry per item.

        Raises:
            BadInput: on a wrong shape, on what is no number or does not fit the type of the field, or on NaN or
                infinity (named with its index); nothing is changed then.
        """
        values = self._converted(field, value)
        try:
            values = np.broadcast_to(values, self.shape(field))
        except ValueError:
            raise BadInput(
                f"{self.owner}: '{field.name}' needs shape {self.shape(field)} (or one entry), got {values.shape}"
            ) from None
        values = self._finite(field, values)
        array = self.allocate(field)
        if not array.flags.writeable:
            raise BadInput(f"{self.owner}: '{field.name}' is fixed now that the part is connected: set it before")
        array[...] = values
        self.given.add(field)

    def _finite(self, field: Field, values: NDArray[Any]) -> NDArray[Any]:
        if values.dtype.kind == "f" and not np.isfinite(values).all():
            index = np.argwhere(~np.isfinite(values))[0]
            raise BadInput(
                f"{self.owner}: '{field.name}' would be {values[tuple(index)]} at {self.at} {index.tolist()}: "
                "give finite numbers"
            )
        return values

    def _converted(self, field: Field, value: ArrayLike) -> NDArray[Any]:
        """The numbers in the type of the field: refused where that would change them, e.g. half a bond."""
        given = as_real(value, f"{self.owner}: '{field.name}'")
        if np.dtype(field.dtype).kind == "f":
            with np.errstate(over="ignore"):  # infinity is refused later
                return given.astype(self.dtype(field), copy=False)
        whole = np.isfinite(given)
        with np.errstate(invalid="ignore"):  # what does not fit is refused below
            values = np.where(whole, given, 0).astype(field.dtype)
        if not (whole & (values == given)).all():
            raise BadInput(f"{self.owner}: '{field.name}' holds {field.dtype} numbers, and some given ones are not")
        return values

    def keep(self, mask: NDArray[np.bool_]) -> None:
        """Drops the entries where the mask is False, in every field."""
        self._arrays = {name: (field, array[mask]) for name, (field, array) in self._arrays.items()}
        self.count = int(np.count_nonzero(mask))

    @property
    def nbytes(self) -> int:
        """Bytes held."""
        return sum(array.nbytes for _, array in self._arrays.values())
