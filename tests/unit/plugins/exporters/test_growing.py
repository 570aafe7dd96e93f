"""Files that grow: chunks that are compressed here are what HDF5 would have made of them."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

from rbs_plugins.exporters import growing


@pytest.mark.parametrize("compression", ["gzip", "lzf", None])
@pytest.mark.parametrize("rows", [None, 1, 3, 100])
@pytest.mark.parametrize("kind", [np.float64, np.float32, np.uint8, np.int64])
def test_frames_are_read_back_by_hdf5(tmp_path, compression, rows, kind, rng):
    frames = (100 * rng.normal(size=(4, 1, 7, 2))).astype(kind)
    with growing.begun(tmp_path / "a.h5") as file:
        growing.frames(file, "x", frames[0], compression, rows)
    for number, values in enumerate(frames):
        with growing.opened(tmp_path / "a.h5") as file:
            growing.put(file, "x", number, values)
    with h5py.File(tmp_path / "a.h5") as file:
        data = file["x"]
        assert data.chunks == (1, min(rows or 7, 7), 2)
        assert data.compression == compression
        assert data.dtype == kind
        assert np.array_equal(data[...], frames[:, 0])
    assert growing.was_closed(tmp_path / "a.h5")


def test_frames_of_several_rows_and_of_one_number(tmp_path, rng):
    with growing.begun(tmp_path / "a.h5") as file:
        growing.frames(file, "rows", np.zeros((5, 3)), "gzip")
        growing.frames(file, "number", np.zeros(1), None)
        for frame in range(3):
            growing.put(file, "rows", frame, np.full((5, 3), frame))
            growing.put(file, "number", frame, np.array([10.0 * frame]))
    with h5py.File(tmp_path / "a.h5") as file:
        assert np.array_equal(file["rows"][:, 0], np.repeat([0.0, 1.0, 2.0], 5))
        assert file["number"][:].tolist() == [0.0, 10.0, 20.0]


def test_numbers_beyond_a_chunk(tmp_path):
    numbers = np.arange(growing.CHUNK + 2, dtype=float).tolist()
    with growing.begun(tmp_path / "a.h5") as file:
        growing.numbers(file, "time", np.float64)
        for count in (1, growing.CHUNK, growing.CHUNK + 1, growing.CHUNK + 2):
            growing.put_numbers(file, "time", numbers[:count])
    with h5py.File(tmp_path / "a.h5") as file:
        assert file["time"][:].tolist() == numbers
