"""Free memory, and the refusal of what does not fit."""

from __future__ import annotations

import math

import psutil
import pytest

from rbs_core import BadInput, memory
from rbs_core.memory import as_text, free_memory, require_memory


def test_there_is_no_more_than_the_machine_has(monkeypatch):
    monkeypatch.delenv("RBS_MEMORY", raising=False)
    assert 0 < free_memory() <= psutil.virtual_memory().total


@pytest.mark.parametrize(
    ("text", "nbytes"),
    [("8GB", 8e9), ("8 GB", 8e9), ("1.5e9", 1.5e9), ("200kB", 2e5), ("200k", 2e5), ("3T", 3e12), ("7b", 7),
     ("off", math.inf)],
)  # fmt: skip
def test_somebody_may_say_how_much_there_is(monkeypatch, text, nbytes):
    monkeypatch.setenv("RBS_MEMORY", text)
    assert free_memory() == nbytes


@pytest.mark.parametrize("text", ["much", "-3", "8 bits", "GB"])
def test_what_is_no_amount_of_memory(monkeypatch, text):
    monkeypatch.setenv("RBS_MEMORY", text)
    with pytest.raises(BadInput, match=r"RBS_MEMORY=.*: give bytes \(8e9\), a number with a unit \(8GB\), or off"):
        free_memory()


def test_what_does_not_fit_is_refused_with_a_cure(monkeypatch):
    monkeypatch.setenv("RBS_MEMORY", "2GB")
    require_memory(2e9, "this", "make it smaller")
    with pytest.raises(BadInput) as caught:
        require_memory(3.1e9, "part 'plate': its bonds", "take a smaller horizon")
    assert str(caught.value) == (
        "part 'plate': its bonds would need 3.1 GB of memory, and 2 GB are free: take a smaller horizon"
    )


def test_small_things_do_not_ask_the_system(monkeypatch):
    monkeypatch.delenv("RBS_MEMORY", raising=False)
    monkeypatch.setattr(memory, "free_memory", lambda: 1 / 0)
    require_memory(1e6, "this", "that")
    with pytest.raises(ZeroDivisionError):
        require_memory(1e9, "this", "that")


V1 = {
    "memory.limit_in_bytes": "9000",
    "memory.usage_in_bytes": "3000",
    "memory.stat": "cache 1\ntotal_inactive_file 500",
}
V2 = {"memory.max": "8000\n", "memory.current": "3000\n", "memory.stat": "anon 1\ninactive_file 500\n"}


@pytest.mark.parametrize(("line", "root", "files", "left"), [("4:memory:", "V1", V1, 6500), ("0::", "V2", V2, 5500)])
def test_containers_and_batch_jobs_have_limits(monkeypatch, tmp_path, line, root, files, left):
    """The group itself has none (max), one above it has."""
    job = tmp_path / "job"
    (job / "task").mkdir(parents=True)
    for name, text in files.items():
        (job / name).write_text(text)
        (job / "task" / name).write_text("max" if "max" in name or "limit" in name else text)
    (tmp_path / "cgroup").write_text(f"7:pids:/\n{line}/job/task\n")
    monkeypatch.setattr(memory, root, tmp_path)
    real = memory.Path
    monkeypatch.setattr(memory, "Path", lambda name: tmp_path / "cgroup" if name == "/proc/self/cgroup" else real(name))
    assert list(memory._containers()) == [left]
    monkeypatch.delenv("RBS_MEMORY", raising=False)
    assert free_memory() == left


def test_where_there_are_no_such_groups(monkeypatch, tmp_path):
    monkeypatch.setattr(memory, "Path", lambda name: tmp_path / "nothing")
    assert list(memory._containers()) == []


@pytest.mark.parametrize(
    ("nbytes", "text"),
    [(0, "0 B"), (8, "8 B"), (999, "999 B"), (1000, "1 kB"), (85_200, "85 kB"), (170_000, "170 kB"), (3.1e9, "3.1 GB"),
     (999.6e6, "1 GB"), (22e9, "22 GB"), (5e12, "5 TB"), (5e15, "5000 TB"), (math.inf, "inf TB")],
)  # fmt: skip
def test_bytes_as_people_say_them(nbytes, text):
    assert as_text(nbytes) == text
