"""Sets of Exodus files: meshio reads the elements, and leaves out the names of their blocks, and the sets of sides."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Sets = dict[str, NDArray[np.int64]]


def sets(path: Path) -> tuple[Sets, Sets]:
    """Blocks and side sets as numbers of cells, node sets as numbers of points, from 0 in the order of the file.

    Those without a name are called block_3, side_set_3 and node_set_3, after their number in the file.
    """
    import netCDF4

    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        cells: Sets = {}
        first = 0
        blocks = [name for name in file.variables if name.startswith("connect")]  # the order in which meshio reads them
        for block in blocks:
            count = len(file.variables[block])
            place = int(block.removeprefix("connect") or 1) - 1
            _add(cells, _name(file, "eb", "block", place), np.arange(first, first + count))
            first += count
        for name, elements in _numbered(file, "ss", "side_set", "elem_ss"):
            _add(cells, name, np.unique(elements))
        return cells, dict(_numbered(file, "ns", "node_set", "node_ns"))


def _numbered(file: Any, prefix: str, kind: str, variable: str) -> list[tuple[str, NDArray[np.int64]]]:
    """(name, numbers from 0) of the sets of a kind."""
    found = [name for name in file.variables if name.startswith(variable)]
    places = [int(name.removeprefix(variable) or 1) - 1 for name in found]
    return [
        (_name(file, prefix, kind, place), np.asarray(file.variables[name][:], np.int64) - 1)
        for name, place in zip(found, places, strict=True)
    ]


def _add(held: Sets, name: str, cells: NDArray[np.int64]) -> None:
    held[name] = np.concatenate([held.get(name, np.empty(0, np.int64)), cells])


def _name(file: Any, prefix: str, kind: str, place: int) -> str:
    """Name of a set, or its kind with its number."""
    if f"{prefix}_names" in file.variables:
        letters = np.asarray(file.variables[f"{prefix}_names"][place])
        name = b"".join(letters.tolist()).split(b"\0")[0].decode("utf-8", errors="replace").strip()
        if name:
            return name
    numbers = file.variables.get(f"{prefix}_prop1")
    return f"{kind}_{place + 1 if numbers is None else int(numbers[place])}"
