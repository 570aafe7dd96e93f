"""A checkpoint that is damaged, or was never one, is refused with a sentence and changes nothing."""

from __future__ import annotations

import json
import zipfile

import numpy as np
import pytest

from rbs_core import BadCheckpoint
from tests.unit.core.toys import held, oscillators, refused


def test_a_truncated_file_is_refused_wherever_it_ends(tmp_path):
    oscillators(tmp_path / "state.npz")[1].run(steps=2)
    whole = (tmp_path / "state.npz").read_bytes()
    part, analysis = oscillators(tmp_path / "other.npz")
    for size in (*range(0, len(whole), 211), len(whole) - 1):
        (tmp_path / "cut.npz").write_bytes(whole[:size])
        refused(analysis, [part], tmp_path / "cut.npz", "cut.npz is damaged or no checkpoint .*: delete it and start")


def test_a_damaged_file_is_refused_or_harmless(tmp_path, rng):
    """A flipped bit is found by the check sums of the archive, unless it lies where nobody looks."""
    good, analysis = oscillators(tmp_path / "state.npz")
    analysis.run(steps=2)
    whole = (tmp_path / "state.npz").read_bytes()
    found = 0
    for place in rng.integers(len(whole), size=200):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << int(rng.integers(8))
        (tmp_path / "bad.npz").write_bytes(damaged)
        part, analysis = oscillators(tmp_path / "other.npz")
        try:
            analysis.run(steps=2, resume=tmp_path / "bad.npz")
        except BadCheckpoint:
            found += 1
        else:
            assert held(part) == held(good)
    assert found > 100


@pytest.mark.parametrize("content", [b"", b"not a checkpoint", b"\x80\x04K\x01."], ids=["empty", "text", "pickle"])
def test_another_file_is_refused(tmp_path, content):
    (tmp_path / "other.npz").write_bytes(content)
    part, analysis = oscillators(tmp_path / "state.npz")
    refused(analysis, [part], tmp_path / "other.npz", "is damaged or no checkpoint")


def test_archives_that_are_no_checkpoints_are_refused(tmp_path):
    part, analysis = oscillators(tmp_path / "state.npz")
    np.savez(tmp_path / "mine.npz", a=np.zeros(3))
    refused(analysis, [part], tmp_path / "mine.npz", "is damaged or no checkpoint")
    with zipfile.ZipFile(tmp_path / "docs.npz", "w") as archive:
        archive.writestr("word/document.xml", "<xml/>")
    refused(analysis, [part], tmp_path / "docs.npz", "is damaged or no checkpoint")
    refused(analysis, [part], tmp_path, "is damaged or no checkpoint")  # a folder


def test_another_format_is_refused(tmp_path):
    part, analysis = oscillators(tmp_path / "state.npz")
    np.savez(tmp_path / "old.npz", meta=np.array(json.dumps({"format": 0})))
    refused(analysis, [part], tmp_path / "old.npz", "has format 0, this version reads 1: delete it and start again")
