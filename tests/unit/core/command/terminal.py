"""A terminal: a process in the foreground of a pseudo terminal, its keys, and what its screen shows in the end."""

from __future__ import annotations

import os
import re
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

WIDTH = 110
# The process takes the terminal as its own, so that Ctrl-C becomes a signal there as it does for people.
FOREGROUND = "import fcntl, os, sys, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0); os.execv(sys.argv[1], sys.argv[1:])"
UNSET = ("NO_COLOR", "FORCE_COLOR", "CI", "TTY_COMPATIBLE", "RBS_MEMORY")


class Terminal:
    """Runs `python -m rbs_core ...` with input, output and errors on one pseudo terminal.

    Args:
        words: behind `rbs`.
        cwd: working directory.
        variables: more environment variables.
    """

    def __init__(self, words: list[str], cwd: Path, variables: dict[str, str] | None = None) -> None:
        import pty  # not on Windows

        self._ours, theirs = pty.openpty()
        plain = {name: value for name, value in os.environ.items() if name not in UNSET}
        terminal = {"TERM": "xterm", "COLUMNS": str(WIDTH), "LINES": "50", "PYTHONIOENCODING": "utf-8"}
        command = [sys.executable, "-c", FOREGROUND, sys.executable, "-m", "rbs_core", *words]
        self._process = subprocess.Popen(
            command, cwd=cwd, stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True,
            env={**plain, **terminal, **(variables or {})},
        )  # fmt: skip
        os.close(theirs)
        self._bytes = b""

    def wait_for(self, text: str, seconds: float = 60.0) -> None:
        """Until the screen has shown a text."""
        end = time.monotonic() + seconds
        while text not in self.text():
            assert self._read(end), f"no {text!r} within {seconds} s on:\n{self.text()}"

    def press(self, keys: str) -> None:
        """Types: "\\x03" is Ctrl-C."""
        os.write(self._ours, keys.encode())

    def end(self, seconds: float = 120.0) -> tuple[int, str]:
        """Exit code, and what the screen shows in the end."""
        limit = time.monotonic() + seconds
        try:
            while self._read(limit):
                pass
            return self._process.wait(max(limit - time.monotonic(), 1.0)), screen(self.text())
        finally:
            if self._process.poll() is None:
                os.killpg(self._process.pid, signal.SIGKILL)
                self._process.wait()
            os.close(self._ours)

    def text(self) -> str:
        """All that was written so far."""
        return self._bytes.decode(errors="replace")

    def _read(self, limit: float) -> bool:
        """False at the end of the output, or of the time."""
        ready, _, _ = select.select([self._ours], [], [], max(limit - time.monotonic(), 0.0))
        if not ready:
            return False
        try:
            piece = os.read(self._ours, 4096)
        except OSError:  # how Linux says that nobody writes any more
            return False
        self._bytes += piece
        return bool(piece)


def screen(text: str) -> str:
    """What stands on the screen after lines, colours, and the few movements of the cursor that a bar makes."""
    lines, row, column = [""], 0, 0
    for piece in re.findall(r"\x1b\[[?\d;]*[A-Za-z]|\r|\n|[^\x1b\r\n]+", text):
        if piece == "\r":
            column = 0
        elif piece == "\n":
            row += 1
            lines += [""] * (row + 1 - len(lines))
        elif piece.startswith("\x1b["):
            if piece.endswith("A"):
                row = max(row - int(piece[2:-1] or 1), 0)
            elif piece.endswith("K"):
                lines[row] = "" if piece[2:-1] == "2" else lines[row][:column]
        else:
            lines[row] = lines[row][:column].ljust(column) + piece + lines[row][column + len(piece) :]
            column += len(piece)
    return "\n".join(line.rstrip() for line in lines).strip("\n") + "\n"
