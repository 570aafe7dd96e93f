"""How much a run says, on the terminal and into a file: six levels on top of the logger `rbs`."""

from __future__ import annotations

import logging
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from rbs_core.errors import BadInput

log = logging.getLogger("rbs")

PROCESS, TIMING = logging.INFO, 15
LEVELS = {
    "off": logging.CRITICAL + 10,
    "error": logging.ERROR,
    "warning": logging.WARNING,
    "process": PROCESS,
    "timing": TIMING,
    "debug": logging.DEBUG,
}
_NAMES = {number: name for name, number in LEVELS.items()}
FILE_ONLY = {"rbs_file_only": True}  # `extra` of a record that the terminal shows in another way, or not at all


class Terminal(logging.StreamHandler[Any]):
    """Writes to the error stream that is there at the moment: a progress bar puts its own in place."""

    def __init__(self, level: int) -> None:
        logging.Handler.__init__(self, level)
        self.setFormatter(_Spoken())
        self.addFilter(lambda record: not hasattr(record, "rbs_file_only"))

    @property
    def stream(self) -> IO[str]:
        """The error stream."""
        return sys.stderr


class _Spoken(logging.Formatter):
    """Plain sentences; warnings and errors say that they are from here."""

    def format(self, record: logging.LogRecord) -> str:
        text = record.getMessage()
        if record.levelno < logging.WARNING:
            return text
        return f"rbs: {text}" if record.levelno >= logging.ERROR else f"rbs: warning: {text}"


class _Dated(logging.Formatter):
    """A line of a file: date, level, message; what has several lines stands indented below."""

    def __init__(self) -> None:
        super().__init__(datefmt="%Y-%m-%d %H:%M:%S")

    def format(self, record: logging.LogRecord) -> str:
        name = _NAMES.get(record.levelno, record.levelname.lower())
        text = record.getMessage().replace("\n", "\n    ")
        return f"{self.formatTime(record, self.datefmt)} {name:<8} {text}"


def configure_logging(terminal: str = "process", file: str | Path | None = None, *, file_level: str = "timing") -> None:
    """Says how much runs tell from now on; what was said before is forgotten.

    Each level tells what those before it tell, and more: "off" nothing; "error" what ended a run; "warning" what may be
    wrong; "process" what a run is doing, with progress and an estimate of time and memory; "timing" where time and
    memory went; "debug" what is allocated, and every step with the time of every relation. Results do not depend on it.

    Args:
        terminal: level of the error stream.
        file: lines with date and level are added to it; none if not given. It is made with the first line.
        file_level: level of the file.

    Raises:
        BadInput: on an unknown level.
    """
    numbers = [level_number(level) for level in (terminal, file_level)]
    _remove(_ours())
    _add(Terminal(numbers[0]))
    if file is not None:
        add_file(file, file_level)


def add_file(path: str | Path, level: str) -> None:
    """Sends messages to a file as well."""
    handler = logging.FileHandler(path, mode="a", encoding="utf-8", delay=True)
    handler.setLevel(level_number(level))
    handler.setFormatter(_Dated())
    handler.rbs_file = True  # type: ignore[attr-defined]  # known again by `_ours`
    _add(handler)


@contextmanager
def logging_of_a_command() -> Iterator[None]:
    """Whatever is configured within the block is taken back at its end; what is warned of there becomes messages."""
    before, level, propagate, showwarning = _ours(), log.level, log.propagate, warnings.showwarning
    warnings.showwarning = _warned
    try:
        yield
    finally:
        warnings.showwarning = showwarning
        _remove([handler for handler in _ours() if handler not in before])
        for handler in before:
            _add(handler)
        log.setLevel(level)
        log.propagate = propagate


def level_number(name: str) -> int:
    """The number of a level.

    Raises:
        BadInput: if there is no such level.
    """
    if name not in LEVELS:
        raise BadInput(f"there is no level {name!r} of messages: take one of {', '.join(LEVELS)}")
    return LEVELS[name]


def shown(level: int) -> bool:
    """True if the terminal shows messages of a level; so it does progress where nothing was configured."""
    terminals = [handler.level for handler in log.handlers if isinstance(handler, Terminal)]
    return not terminals or min(terminals) <= level


def _ours() -> list[logging.Handler]:
    return [each for each in log.handlers if isinstance(each, Terminal) or hasattr(each, "rbs_file")]


def _warned(message: Warning | str, category: type[Warning], filename: str, lineno: int, *_: Any, **__: Any) -> None:
    where = "" if category is UserWarning else f" ({category.__name__}, {filename}:{lineno})"
    log.warning("%s%s", message, where)


def _add(handler: logging.Handler) -> None:
    log.addHandler(handler)
    log.setLevel(min(each.level for each in log.handlers))
    log.propagate = False  # said once, whatever else is configured


def _remove(handlers: list[logging.Handler]) -> None:
    for handler in handlers:
        log.removeHandler(handler)
        handler.close()
