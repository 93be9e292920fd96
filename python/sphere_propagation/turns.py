# SPDX-License-Identifier: GPL-3.0-only
"""One filter at a time: the plugin refuses a second one while the first runs, and PyMeshLab keeps
one log and goes from folder to folder when it reads files. Other threads wait for their turn."""

from __future__ import annotations

import os
import threading
from contextlib import contextmanager
from dataclasses import dataclass, field

from .errors import SpherePropagationError


@dataclass
class _Turns:
    lock: threading.Lock = field(default_factory=threading.Lock)
    holder: int = 0  # the thread whose turn it is

    def start_afresh(self) -> None:
        """A forked process has only the thread that forked, which holds nothing."""
        self.__init__()


_turns = _Turns()
os.register_at_fork(after_in_child=_turns.start_afresh)


@contextmanager
def turn(what: str):
    """Waits until no other thread is at it. `what` is done: for the error that a thread gets which
    would wait for itself, as a signal's handler or a callback can."""
    if _turns.holder == threading.get_ident():
        raise SpherePropagationError(
            f"{what} cannot start while another call of sphere_propagation is at work in the same "
            "thread, as from a callback or a signal's handler: call it when that has returned."
        )
    with _turns.lock:
        _turns.holder = threading.get_ident()
        try:
            yield
        finally:
            _turns.holder = 0
