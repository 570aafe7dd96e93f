"""How much memory there is, and a refusal of what does not fit, before it is taken."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

from rbs_core.errors import BadInput

VARIABLE = "RBS_MEMORY"
UNITS = ("B", "kB", "MB", "GB", "TB")
SMALL = 100_000_000  # bytes that nobody need look for: asking the system takes as long as a step of a small part
V1, V2 = Path("/sys/fs/cgroup/memory"), Path("/sys/fs/cgroup")  # where Linux tells the limits of a container


def free_memory() -> float:
    """Bytes that can be taken now: free memory of the machine, or what is left to the container or batch job.

    The environment variable `RBS_MEMORY` says something else: a number with or without a unit (`8GB`), or `off` for no
    limit (infinity).

    Raises:
        BadInput: if the variable is neither.
    """
    given = os.environ.get(VARIABLE, "").strip()
    if given:
        return _given(given)
    import psutil  # here: what needs little memory does not ask

    return float(min([psutil.virtual_memory().available, *_containers()]))


def require_memory(nbytes: float, what: str, cure: str) -> None:
    """Refuses work that does not fit.

    Args:
        nbytes: bytes that it needs.
        what: it, as the beginning of a sentence, e.g. "part 'block': its bonds".
        cure: what to do about it.

    Raises:
        BadInput: if more is needed than there is.
    """
    if not fits(nbytes):
        free = as_text(free_memory())
        raise BadInput(f"{what} would need {as_text(nbytes)} of memory, and {free} are free: {cure}")


def fits(nbytes: float) -> bool:
    """True if so many bytes are free; of a few the system is not asked."""
    return (nbytes <= SMALL and not os.environ.get(VARIABLE)) or nbytes <= free_memory()


def as_text(nbytes: float) -> str:
    """Bytes as people say them: 3.1 GB; 1 GB is 1e9 bytes."""
    size = float(nbytes)
    for unit in UNITS[:-1]:
        if size < 999.5:
            return f"{size:.0f} {unit}" if unit == "B" or size >= 99.5 else f"{size:.2g} {unit}"
        size /= 1000
    return f"{size:.2g} {UNITS[-1]}" if size < 99.5 else f"{size:.0f} {UNITS[-1]}"


def _given(text: str) -> float:
    if text.lower() == "off":
        return float("inf")
    found = re.fullmatch(r"(\d+\.?\d*(?:[eE]\d+)?)\s*([kKMGT]?)[bB]?", text)
    if found is None:
        raise BadInput(f"{VARIABLE}={text}: give bytes (8e9), a number with a unit (8GB), or off")
    return float(found[1]) * 10.0 ** (3 * ("", "K", "M", "G", "T").index(found[2].upper()))


def _containers() -> Iterator[int]:
    """What is left below the limit of every group of processes that this one belongs to; nothing but on Linux."""
    try:
        lines = Path("/proc/self/cgroup").read_text(encoding="utf-8").splitlines()
    except OSError:
        return
    for line in lines:
        _, controllers, path = line.split(":", 2)
        if controllers == "memory":
            root, names = V1, ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
        elif not controllers:
            root, names = V2, ("memory.max", "memory.current", "inactive_file")
        else:
            continue
        folder = root / path.lstrip("/")
        for group in (folder, *folder.parents):
            left = _left(group, *names)
            if left is not None:
                yield left
            if group == root:
                break


def _left(group: Path, limit: str, usage: str, cached: str) -> int | None:
    """Bytes below the limit of a group; None if it has none. Cached files do not count: the system gives them up."""
    try:
        most, taken = (int((group / name).read_text(encoding="utf-8")) for name in (limit, usage))
        numbers = dict(line.split() for line in (group / "memory.stat").read_text(encoding="utf-8").splitlines())
    except (OSError, ValueError):  # no such group, or "max"
        return None
    return max(most - taken + int(numbers.get(cached, 0)), 0)
