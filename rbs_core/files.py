"""Files that are there whole or not at all, in folders that were proved writable before any work."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rbs_core.errors import BadInput


def writable_folder(folder: Path) -> Path:
    """Makes a folder and proves that it can be written, before any work is done for it.

    Raises:
        BadInput: if not.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / f".probe-{os.getpid()}"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise BadInput(
            f"cannot write into the folder {folder}: {error.strerror or error}: choose another one"
        ) from None
    return folder


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Gives a temporary name beside the path, and renames what was written there if the block ends well."""
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        yield partial
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
