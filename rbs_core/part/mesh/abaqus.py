"""Element sets of Abaqus files: meshio reads the elements, but mixes up sets that span several blocks of them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


def cell_sets(path: Path, shapes: Sequence[tuple[int, ...]]) -> dict[str, NDArray[np.int64]] | None:
    """Numbers of the cells, from 0 in the order of the file, of every element set.

    Args:
        path: of the file.
        shapes: of the blocks of cells that meshio has found, (cells, points of a cell).

    Returns:
        The sets by name; None if elements cannot be told by their numbers: with included files, or numbers that are
        there twice.
    """
    cells: dict[int, int] = {}
    members: dict[str, list[int]] = defaultdict(list)
    expected = iter(shapes)
    for keyword, options, words in _sections(path):
        if keyword == "INCLUDE":
            return None
        if keyword == "ELEMENT":
            count, *width = next(expected, (0,))
            elements = [int(word) for word in words][:: width[0] + 1 if width else 1]
            if len(elements) != count:
                return None
            cells.update(zip(elements, range(len(cells), len(cells) + count), strict=True))
            if "ELSET" in options:
                members[options["ELSET"]] += elements
        elif keyword == "ELSET" and "ELSET" in options:
            members[options["ELSET"]] += _listed(words, "GENERATE" in options, members)
    if len(cells) != sum(shape[0] for shape in shapes):
        return None
    return {name: np.array([cells[one] for one in some if one in cells], np.int64) for name, some in members.items()}


def _listed(words: list[str], generate: bool, known: dict[str, list[int]]) -> list[int]:
    """Numbers of elements: one after another, as triples of first, last and step, or as names of sets before."""
    if not generate:
        return [one for word in words for one in ([int(word)] if word.isdigit() else known.get(word, []))]
    numbers = [int(word) for word in words]
    return [one for k in range(0, len(numbers), 3) for one in range(numbers[k], numbers[k + 1] + 1, numbers[k + 2])]


def _sections(path: Path) -> Iterator[tuple[str, dict[str, str], list[str]]]:
    """(keyword, options, words of the lines behind it), comments left out."""
    keyword, options, words = "", dict[str, str](), list[str]()
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        if line.startswith("**"):
            continue
        split = [word.strip() for word in line.split(",")]
        if line.startswith("*"):
            yield keyword, options, words
            keyword, words = split[0].lstrip("*").strip().upper(), []
            pairs = (word.partition("=") for word in split[1:])
            options = {name.strip().upper(): value.strip() for name, _, value in pairs}
        elif keyword in ("ELEMENT", "ELSET"):
            words += [*filter(None, split), *(["1"] if "GENERATE" in options and len(split) == 2 else [])]
    yield keyword, options, words
