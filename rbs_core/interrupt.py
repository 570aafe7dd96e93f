"""Ctrl-C: the first one asks the run to end after the step, a second one breaks it off."""

from __future__ import annotations

import signal
import threading
from types import FrameType
from typing import Any


class Interrupt:
    """Listens for Ctrl-C within a `with` block, in the main thread; elsewhere signals go their usual way.

    Attributes:
        asked: True after the first Ctrl-C.
    """

    def __init__(self) -> None:
        self.asked = False
        self._previous: Any = None
        self._listening = False

    def __enter__(self) -> Interrupt:
        if threading.current_thread() is threading.main_thread():
            self._previous = signal.signal(signal.SIGINT, self._hear)
            self._listening = True
        return self

    def _hear(self, _number: int, _frame: FrameType | None) -> None:
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True

    def __exit__(self, *_: object) -> None:
        if self._listening:
            signal.signal(signal.SIGINT, self._previous)
