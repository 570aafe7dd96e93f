"""HDF5 files that grow frame by frame: begun, continued, cut, and of use whenever a process is killed.

What belongs to a frame is appended to datasets that grow along their first axis; a number that says how many frames
count is written last, by whoever defines the format. What an array of a frame is cut into are chunks of HDF5, which are
compressed by all threads and written at once.
"""

from __future__ import annotations

import itertools
import zlib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

# A file is made with an old header of HDF5: newer ones mark a file as open, and after a crash no viewer would take it.
# It is filled with the index of HDF5 1.10 (ParaView has it), which only grows at its end: frames are found where they
# were before, at whatever moment the writing stops.
HEADER, INDEX = ("v108", "v110"), ("v110", "v110")

# Numbers of so many frames lie together. Only where a new chunk of them begins a crash, within microseconds, costs the
# file.
CHUNK = 4096

LEVEL = 1  # of gzip: higher ones take twice as long for one or two per cent
Block = tuple[tuple[int, ...], NDArray[Any]]


@contextmanager
def begun(path: Path) -> Iterator[Any]:
    """A new file, to be filled."""
    import h5py

    with h5py.File(path, "w", libver=HEADER, locking=False):
        pass
    with opened(path) as file:
        yield file


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """A file to be continued. It is not locked: a viewer that has it open must not stop a run."""
    import h5py

    with h5py.File(path, "r+", libver=INDEX, locking=False) as file:
        yield file


def was_closed(path: Path) -> bool:
    """False if the process was killed while it wrote a frame: HDF5 has not told the header how long the file is."""
    with path.open("rb") as file:
        header = file.read(48)
    return int.from_bytes(header[28:36], "little") == path.stat().st_size


def numbers(group: Any, name: str, kind: Any, fill: float = 0) -> Any:
    """A dataset with one number for each frame, none so far."""
    return group.create_dataset(name, (0,), kind, maxshape=(None,), chunks=(CHUNK,), fillvalue=fill)


def frames(group: Any, name: str, values: NDArray[Any], compression: str | None, rows: int | None = None) -> Any:
    """A dataset for what is written in every frame, none so far.

    Args:
        group: where it will be.
        name: of it.
        values: of a frame: appended along the first axis.
        compression: None, "gzip" or "lzf".
        rows: entries along the second axis in a chunk; all if not given.
    """
    entry = values.shape[1:]
    chunk = values.shape if rows is None or not entry else (len(values), min(rows, entry[0]), *entry[1:])
    return group.create_dataset(
        name, (0, *entry), values.dtype, maxshape=(None, *entry), chunks=chunk, shuffle=compression is not None,
        compression=compression, compression_opts=LEVEL if compression == "gzip" else None, fill_time="never",
    )  # fmt: skip


def put(file: Any, name: str, frame: int, values: NDArray[Any]) -> None:
    """Writes what belongs to a frame behind the frames before."""
    begin = frame * len(values)
    data = resized(file, name, begin + len(values))
    values = values.astype(data.dtype, copy=False)  # chunks are taken as they are
    filters = data.get_create_plist()
    if filters.get_nfilters() and not _is_gzip(filters):
        file[name][begin:] = values
        return
    blocks = _blocks(values, begin, filters.get_chunk())
    if filters.get_nfilters():
        _compressed(data, blocks, filters.get_filter(1)[2][0])
        return
    for place, block in blocks:  # from the array to the disk
        data.write_direct_chunk(place, block)


def put_numbers(file: Any, name: str, values: Sequence[float]) -> None:
    """Writes the numbers of all frames: the last chunk of them, as the others are there."""
    data = resized(file, name, len(values))
    first = (len(values) - 1) // CHUNK * CHUNK
    chunk = np.zeros(CHUNK, data.dtype)
    chunk[: len(values) - first] = values[first:]
    data.write_direct_chunk((first,), chunk)


def resized(file: Any, name: str, rows: int) -> Any:
    """A dataset with so many rows: that of HDF5, which is there ten times as fast as that of h5py."""
    from h5py import h5d

    data = h5d.open(file.id, name.encode())
    data.set_extent((rows, *data.shape[1:]))
    return data


def _blocks(values: NDArray[Any], begin: int, chunk: tuple[int, ...]) -> Iterator[Block]:
    """The chunks of an array with their places; those that are cut off at the end are filled up."""
    for corner in itertools.product(*(range(0, size, step) for size, step in zip(values.shape, chunk, strict=True))):
        block = values[tuple(slice(a, a + step) for a, step in zip(corner, chunk, strict=True))]
        if block.shape != chunk:
            whole = np.zeros(chunk, values.dtype)
            whole[tuple(slice(0, size) for size in block.shape)] = block
            block = whole
        yield (begin + corner[0], *corner[1:]), np.ascontiguousarray(block)


def _is_gzip(filters: Any) -> bool:
    """True if chunks are shuffled and then compressed by gzip, and nothing else."""
    from h5py import h5z

    codes = [filters.get_filter(k)[0] for k in range(filters.get_nfilters())]
    return codes == [h5z.FILTER_SHUFFLE, h5z.FILTER_DEFLATE]


def _compressed(data: Any, blocks: Iterator[Block], level: int) -> None:
    """Compresses chunks by all threads, as HDF5 would do it by one, and writes them in order."""
    import numba

    def pack(block: Block) -> tuple[tuple[int, ...], bytes]:
        place, values = block
        shuffled = values.reshape(-1).view(np.uint8).reshape(-1, values.itemsize).T
        return place, zlib.compress(np.ascontiguousarray(shuffled).data, level)

    with ThreadPoolExecutor(numba.get_num_threads()) as pool:
        for place, packed in pool.map(pack, blocks):
            data.write_direct_chunk(place, packed)
