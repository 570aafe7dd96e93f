"""Bonds of a regular grid: a table of steps that all nodes share, and one bit per bond.

The cells of the grid, present or not, are numbered along one axis with margins wider than the longest step at both
ends. Step number k leads from cell c to cell c + steps[k]; bit k at cell c says whether that bond is there. The way
back from c + steps[k] to c is the same bit, so a bond has one state, seen from both ends. Holes, notches and cracks are
only bits; a step across an edge of the grid lands on some other cell, and its bit is never set.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core.errors import BadInput
from rbs_core.fields import Field, FieldStore, intact
from rbs_core.part.reach import half_steps
from rbs_core.part.storage import TOLERANCE, Crosses, Of, Storage

Bits = NDArray[Any]
# Cells that loops take at once: they may go so far beyond the last cell, where there are no bonds.
AT_ONCE = 32


class Lattice(Storage):
    """The lattice representation.

    Args:
        owner: whose they are, for messages: "part 'plate'".
        positions: (n, d) reference positions, m.
        cells: (n,) ascending numbers (x fastest) of the cells that hold nodes.
        shape: cells per axis.
        spacing: of the grid, m.
        reach: radius within which nodes are bonded, m; widened by one part in 1e9, as in the search for rows.
        real: type of bond fields of real numbers.

    Attributes:
        cells: (n,) cell of each node, margin included, ascending.
        margin: width of the margin, cells: a whole number of AT_ONCE, and as many more than the longest step.
        size: number of cells with both margins.
        vectors: (h, d) whole numbers of cells: half of the steps, each other one is the way back.
        steps: (h,) the same as distances between cell numbers, positive, ascending.
        present: (words, size) bits of the bonds that are there, intact or not.
        dense: True if every cell of the grid holds a node.
    """

    name = "lattice"

    def __init__(
        self,
        owner: str,
        positions: NDArray[np.float64],
        cells: NDArray[np.int64],
        shape: tuple[int, ...],
        spacing: float,
        reach: float,
        real: str = "float64",
    ) -> None:
        self._positions, self.spacing, self.shape = positions, spacing, shape
        self.vectors, self.steps = half_steps(shape, reach / spacing * (1 + TOLERANCE))
        longest = int(self.steps[-1]) if len(self.steps) else 0
        self.margin = -(-(longest + AT_ONCE) // AT_ONCE) * AT_ONCE
        count = int(np.prod(shape))
        self.size = count + 2 * self.margin
        self.dense = len(cells) == count
        self.cells = cells + self.margin
        self.lengths = spacing * np.sqrt((self.vectors.astype(np.float64) ** 2).sum(axis=1))
        self.width = 8 if len(self.steps) <= 8 else 16  # a loop loads a word of each cell for every step
        self.present = self._all_bits()
        self._length = self.count(self.present)
        self.fields: LatticeFields = LatticeFields(self, owner, real)

    def _all_bits(self) -> Bits:
        """Bits between all cells that hold nodes."""
        bits = self.no_bits()
        there = np.zeros(self.size, np.bool_)
        there[self.cells] = True
        inner = slice(self.margin, self.size - self.margin)
        there = there[inner].reshape(self.shape[::-1])
        for k, vector in enumerate(self.vectors[:, ::-1]):
            here = tuple(slice(max(0, -v), n - max(0, v)) for v, n in zip(vector, there.shape, strict=True))
            beyond = tuple(slice(max(0, v), n - max(0, -v)) for v, n in zip(vector, there.shape, strict=True))
            word = bits[k // self.width, inner].reshape(there.shape)
            word[here] |= (there[here] & there[beyond]).astype(bits.dtype) << bits.dtype.type(k % self.width)
        return bits

    def no_bits(self) -> Bits:
        """Bits that are all zero."""
        words = max(-(-len(self.steps) // self.width), 1)
        return np.zeros((words, self.size), f"uint{self.width}")

    # -- one step of all nodes --------------------------------------------------------------------------------------

    def bit(self, bits: Bits, step: int) -> NDArray[np.bool_]:
        """(size,) bit of one step at every cell."""
        mask = bits.dtype.type(1 << step % self.width)
        return np.asarray(bits[step // self.width] & mask, np.bool_)

    def directed(self, bits: Bits) -> Iterator[tuple[int, NDArray[np.bool_]]]:
        """(distance to the neighbor's cell, (n,) bit) for every direction, in ascending order of neighbors."""
        for step in reversed(range(len(self.steps))):
            yield -int(self.steps[step]), self.bit(bits, step)[self._nodes(-int(self.steps[step]))]
        for step in range(len(self.steps)):
            yield int(self.steps[step]), self.bit(bits, step)[self._nodes()]

    def _nodes(self, shift: int = 0) -> Any:
        """What picks, from an array by cell, the entries of all nodes, or of the cells so far from them."""
        if self.dense:
            return slice(self.margin + shift, self.size - self.margin + shift)
        return self.cells + shift

    def weigh(self, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,) sums of one weight (h,) per step over the bonds of each node."""
        total = np.zeros(len(self.cells))
        for weight, (_, there) in zip([*weights[::-1], *weights], self.directed(self.present), strict=True):
            total += weight * there
        return total

    def table(self, bits: Bits) -> NDArray[np.bool_]:
        """(n, 2h) bits of all directions: where `present` is set, in row-major order, they belong to the bonds."""
        result = np.empty((len(self.cells), 2 * len(self.steps)), np.bool_)
        for column, (_, holds) in enumerate(self.directed(bits)):
            result[:, column] = holds
        return result

    # -- as every storage -------------------------------------------------------------------------------------------

    def __len__(self) -> int:
        return self._length

    def offsets(self) -> NDArray[np.int64]:
        counts = np.zeros(len(self.cells) + 1, np.int64)
        for _, there in self.directed(self.present):
            counts[1:] += there
        return np.cumsum(counts, out=counts)

    def as_rows(self) -> tuple[NDArray[np.int64], NDArray[np.uint32]]:
        there = self.table(self.present)
        node_of = np.zeros(self.size, np.uint32)
        node_of[self.cells] = np.arange(len(self.cells), dtype=np.uint32)
        ways = np.array([way for way, _ in self.directed(self.present)], np.int64)
        nodes, columns = np.nonzero(there)
        return self.offsets(), node_of[self.cells[nodes] + ways[columns]]

    def neighbors(self, node: int) -> NDArray[Any]:
        cell, found = self.cells[node], []
        for step in reversed(range(len(self.steps))):
            found.append(cell - self.steps[step]) if self._holds(step, cell - self.steps[step]) else None
        for step in range(len(self.steps)):
            found.append(cell + self.steps[step]) if self._holds(step, cell) else None
        return np.searchsorted(self.cells, np.array(found, np.int64)).astype(np.uint32)

    def _holds(self, step: int, cell: int) -> bool:
        return bool(int(self.present[step // self.width, cell]) >> (step % self.width) & 1)

    def inverse_lengths(self) -> NDArray[np.float64]:
        return self.expand(1.0 / self.lengths)

    def expand(self, values: NDArray[Any]) -> NDArray[Any]:
        """(m,) entries of bonds from one value (h,) per step."""
        columns = np.nonzero(self.table(self.present))[1]
        return np.concatenate([values[::-1], values])[columns]

    def mark(self, field: Field, inside: NDArray[np.bool_]) -> None:
        there = np.zeros(self.size, np.bool_)
        there[self.cells] = inside
        self.fields.hold(field, self.present * there & self._reached(there))

    def _reached(self, there: NDArray[np.bool_]) -> Bits:
        """Bit k of a cell says whether the cell that step k leads to is there."""
        bits = self.no_bits()
        for k, step in enumerate(self.steps):
            bits[k // self.width, : self.size - step] |= there[step:].astype(bits.dtype) << bits.dtype.type(
                k % self.width
            )
        return bits

    def tabulate(self, field: Field, function: Of) -> None:
        self.fields.hold(field, function(self.spacing * self.vectors.astype(float)).astype(self.fields.dtype(field)))

    def cut(self, crosses: Crosses, near: NDArray[np.bool_]) -> tuple[int, int]:
        holds, crossing = self.fields.raw(intact), self._crossing(crosses, near)
        broken = self.count(holds & crossing)
        holds &= ~crossing
        return broken, self.count(crossing)

    def remove(self, crosses: Crosses, near: NDArray[np.bool_]) -> int:
        crossing = self._crossing(crosses, near)
        gone = self.count(crossing)
        for bits in (self.present, *self.fields.bits()):
            bits &= ~crossing
        self._length -= gone
        return gone

    def count(self, bits: Bits) -> int:
        """Number of directed bonds among bits."""
        return 2 * sum(int(np.count_nonzero(self.bit(bits, step))) for step in range(len(self.steps)))

    def _crossing(self, crosses: Crosses, near: NDArray[np.bool_]) -> Bits:
        """Bits of the bonds that cross."""
        bits, nodes = self.no_bits(), np.flatnonzero(near)
        for k, step in enumerate(self.steps):
            some = nodes[self.bit(self.present, k)[self.cells[nodes]]]
            starts, stops = self._positions[some], self._positions[np.searchsorted(self.cells, self.cells[some] + step)]
            crossed = some[np.asarray(crosses(starts, stops), np.bool_)] if len(some) else some
            bits[k // self.width, self.cells[crossed]] |= bits.dtype.type(1 << k % self.width)
        return bits

    @property
    def has_broken(self) -> bool:
        return intact in self.fields and not np.array_equal(self.fields.raw(intact), self.present)

    def holds(self, nodes: NDArray[np.int64], others: NDArray[np.int64]) -> NDArray[np.bool_]:
        bits = self.fields.raw(intact) if intact in self.fields else self.present
        here = np.minimum(self.cells[nodes], self.cells[others])
        ways = np.abs(self.cells[others] - self.cells[nodes])
        found = np.zeros(len(here), np.bool_)
        step = np.searchsorted(self.steps, ways)
        same = np.flatnonzero(step < len(self.steps))
        while len(same := same[self.steps[step[same]] == ways[same]]):
            words = bits[step[same] // self.width, here[same]]
            found[same] |= (words >> (step[same] % self.width).astype(bits.dtype)) & 1 != 0
            same = same[(step := step + 1)[same] < len(self.steps)]  # in a narrow grid, several steps lead as far
        return found

    def arrays(self) -> tuple[NDArray[Any], ...]:
        return np.array([*self.shape, self.margin]), self.vectors, self.cells, self.present

    @property
    def nbytes(self) -> int:
        return self.cells.nbytes + self.present.nbytes + self.fields.nbytes


class LatticeFields(FieldStore):
    """Bond fields of a lattice: bits where entries are 0 or 1, one value per step where bonds of a step are alike.

    The arrays (m,) that `allocate` and `get` return are made for the occasion and cannot be written; `set` takes them
    back. Loops use `raw`.
    """

    def __init__(self, lattice: Lattice, owner: str, real: str) -> None:
        super().__init__(owner, "bond", None, lattice.vectors.shape[1], real)
        self._lattice = lattice

    def shape(self, field: Field) -> tuple[int, ...]:
        return (len(self._lattice), *field.entry(self.dimension))

    def size(self, field: Field) -> int:
        type_ = self.dtype(field)
        return self._lattice.present.nbytes if type_ == np.uint8 else len(self._lattice.steps) * type_.itemsize

    def raw(self, field: Field) -> NDArray[Any]:
        """(words, size) bits of a field of the type uint8, (h,) one value per step of any other.

        Raises:
            FieldClash: as `allocate`.
            BadInput: for vectors and tensors, which a lattice cannot hold.
        """
        if field.name not in self._arrays and field.at == self.at:
            if not self.can_hold(field):
                raise BadInput(self._refusal(field))
            form = self._form(field, field.initial)
            assert form is not None, f"the initial value of {field!r} is no single number"
            self._arrays[field.name] = (field, form)
        return super().allocate(field)

    def allocate(self, field: Field) -> NDArray[Any]:
        held = self.raw(field)
        lattice = self._lattice
        if held.ndim == 2:
            there = lattice.table(lattice.present)
            array = lattice.table(held)[there].view(np.uint8)
        else:
            array = lattice.expand(held)
        array.flags.writeable = False
        return array

    def set(self, field: Field, value: ArrayLike) -> None:
        values = self._finite(field, self._converted(field, value))
        form = self._form(field, values) if self.can_hold(field) else None
        if form is None:
            raise BadInput(self._refusal(field))
        self.hold(field, form)
        self.given.add(field)

    def hold(self, field: Field, form: NDArray[Any]) -> None:
        """Takes bits or a table, as `raw` gives them."""
        if field.name in self._arrays:
            self.raw(field)[...] = form  # the same name with another meaning is refused
        else:
            self._arrays[field.name] = (field, form)

    def can_hold(self, field: Field) -> bool:
        """True for scalars."""
        return field.shape == "scalar"

    def fits(self, field: Field, value: ArrayLike) -> bool:
        """True if these entries can be bits or one value per step."""
        return self.can_hold(field) and self._form(field, self._converted(field, value)) is not None

    def _form(self, field: Field, value: Any) -> NDArray[Any] | None:
        lattice, values = self._lattice, np.asarray(value, self.dtype(field))
        flags = values.dtype == np.uint8 and values.max(initial=0) <= 1
        if not values.ndim:
            if flags:
                return lattice.present.copy() if values else lattice.no_bits()
            return None if values.dtype == np.uint8 else np.full(len(lattice.steps), values)
        if values.shape != (len(lattice),):
            raise BadInput(f"{self.owner}: '{field.name}' needs shape {self.shape(field)} or one entry")
        there = lattice.table(lattice.present)
        return self._bits(values, there) if flags else self._steps(values, there)

    def _bits(self, values: NDArray[Any], there: NDArray[np.bool_]) -> Bits | None:
        lattice, half = self._lattice, len(self._lattice.steps)
        table = np.zeros(there.shape, np.bool_)
        table[there] = values != 0
        bits = lattice.no_bits()
        for k in range(half):
            bits[k // lattice.width, lattice.cells] |= table[:, half + k].astype(bits.dtype) << bits.dtype.type(
                k % lattice.width
            )
        return bits if np.array_equal(lattice.table(bits), table) else None

    def _steps(self, values: NDArray[Any], there: NDArray[np.bool_]) -> NDArray[Any] | None:
        half, columns = len(self._lattice.steps), np.nonzero(there)[1]
        step = np.where(columns < half, half - 1 - columns, columns - half)
        table = np.zeros(half, values.dtype)
        table[step] = values
        return table if np.array_equal(table[step], values) else None

    def bits(self) -> list[Bits]:
        """The fields that are held as bits."""
        return [array for _, array in self._arrays.values() if array.ndim == 2]

    def _refusal(self, field: Field) -> str:
        return (
            f"{self.owner} stores its bonds as lattice, which holds scalars that are 0 or 1, the same from both ends, "
            f"or alike for all bonds of a step; '{field.name}' is not: part.connect(horizon, storage='list') holds it"
        )
