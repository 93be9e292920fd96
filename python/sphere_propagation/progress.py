# SPDX-License-Identifier: GPL-3.0-only
"""Saying what goes on: lines where output is kept, a bar on a terminal.

PyMeshLab passes no progress on to Python, so a bar moves from one step to the next (one filter, one
picture); in between only its clock ticks.
"""

from __future__ import annotations

import shutil
import sys
import threading
import time
from typing import Optional, TextIO


class Silent:
    """Says nothing; what correspond() uses unless told otherwise."""

    def begin(self, doing: str) -> None:
        """A step starts."""

    def done(self, found: str) -> None:
        """The step that began last is over."""

    def note(self, text: str) -> None:
        """Something worth knowing that is no step."""

    def close(self) -> None:
        """Nothing more comes."""


SILENT = Silent()


class Lines(Silent):
    """One line per step, with the seconds that it took."""

    def __init__(self, stream: Optional[TextIO] = None):
        self.stream = stream or sys.stdout
        self.start = self.last = time.monotonic()

    def done(self, found: str) -> None:
        now = time.monotonic()
        self._print(f"[{now - self.last:5.1f} s] {found}")
        self.last = now

    def note(self, text: str) -> None:
        self._print(f"          {text}")

    def warning(self, text: str, kind: str = "warning") -> None:
        """Something that deserves a look, whose line goes to stderr."""
        print(f"{kind}: {text}", file=sys.stderr, flush=True)

    def seconds(self) -> float:
        return time.monotonic() - self.start

    def _print(self, line: str) -> None:
        print(line, file=self.stream, flush=True)


class Bar(Lines):
    """The same lines, and below them a bar with the number of the step, what it does and for how
    long it has been at it."""

    def __init__(self, steps: int, stream: Optional[TextIO] = None):
        super().__init__(stream)
        self.steps, self.finished, self.doing = steps, 0, ""
        self.lock, self.closed = threading.Lock(), threading.Event()
        self.ticker = threading.Thread(target=self._tick, daemon=True)
        self.ticker.start()

    def begin(self, doing: str) -> None:
        self.doing = doing
        self._draw()

    def done(self, found: str) -> None:
        self.finished, self.doing = self.finished + 1, ""
        super().done(found)
        self._draw()

    def close(self) -> None:
        if self.closed.is_set():
            return
        self.closed.set()
        self.ticker.join()
        with self.lock:
            self.stream.write("\r\033[K")
            self.stream.flush()

    def _print(self, line: str) -> None:
        with self.lock:
            self.stream.write(f"\r\033[K{line}\n")
            self.stream.flush()

    def warning(self, text: str, kind: str = "warning") -> None:
        with self.lock:  # the line takes the bar's place, which is drawn again below it
            self.stream.write("\r\033[K")
            self.stream.flush()
            super().warning(text, kind)

    def _tick(self) -> None:
        while not self.closed.wait(0.5):
            self._draw()

    def _draw(self) -> None:
        filled = round(20 * min(1, self.finished / self.steps))
        text = (
            f"[{'#' * filled}{'.' * (20 - filled)}] "
            f"{min(self.finished + 1, self.steps)}/{self.steps}"
        )
        if self.doing:
            text += f"  {self.doing}  {time.monotonic() - self.last:.0f} s"
        with self.lock:
            if not self.closed.is_set():
                self.stream.write(f"\r\033[K{text[: shutil.get_terminal_size().columns - 1]}")
                self.stream.flush()


def for_stream(steps: int, stream: Optional[TextIO] = None) -> Lines:
    """A bar on a terminal, lines elsewhere."""
    stream = stream or sys.stdout
    return Bar(steps, stream) if stream.isatty() else Lines(stream)
