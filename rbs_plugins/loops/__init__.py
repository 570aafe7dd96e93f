"""Compiled loops: the one place that decides how and on how many threads a loop runs."""

from __future__ import annotations

from typing import Any

import numpy as np

from rbs_plugins.loops.loop import BATCH_BELOW, SERIAL_BELOW, Loop, Text

__all__ = ["BATCH_BELOW", "SERIAL_BELOW", "Loop", "Text", "flat"]


def flat(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """The same memory as one row."""
    return array.reshape(-1)
