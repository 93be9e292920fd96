# SPDX-License-Identifier: GPL-3.0-only
"""One subject after the other, in a process of their own: one that crashes it is listed, and the
next goes on in a new one."""

from __future__ import annotations

import ctypes
import errno
import multiprocessing
import os
import signal
from typing import Any, Callable, Iterator, Sequence, Tuple

from ..errors import SpherePropagationError
from .wording import for_files

DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of Linux's prctl
OF_THE_MACHINE = (errno.ENOSPC, errno.EIO, errno.EDQUOT, errno.ESTALE, errno.EMFILE)
KILLED = (signal.SIGKILL, signal.SIGTERM)  # by somebody, not by the subject


class Failed(Exception):
    """A subject cannot be done, for this reason."""


def die_with_parent(parent: int) -> None:
    """The kernel ends this process when its parent ends, however that comes; Linux only. parent:
    who it is; one that has ended before is followed at once."""
    try:
        ctypes.CDLL(None).prctl(DEATH_SIGNAL, int(signal.SIGKILL))
    except (AttributeError, OSError):
        return
    if os.getppid() != parent:
        os.kill(os.getpid(), signal.SIGKILL)


def each(function: Callable[[Any], Any], items: Sequence[Any]) -> Iterator[Tuple[int, Any, str]]:
    """For each item, in their order: its place, what function(item) returns, and the reason where
    it cannot be done (then the result is None). An error of the machine's (no memory, disk full) is
    raised: another try may do."""
    context = multiprocessing.get_context("fork")
    place, tries = 0, 0
    while place < len(items):
        here, there = context.Pipe(duplex=False)
        process = context.Process(
            target=_serve, args=(os.getpid(), there, here, function, items[place:])
        )
        process.start()
        there.close()
        try:
            while place < len(items):
                kind, value = here.recv()
                if kind == "machine":
                    raise value
                yield place, value if kind == "done" else None, value if kind == "failed" else ""
                place, tries = place + 1, 0
        except EOFError:
            process.join()
            ended = -(process.exitcode or 0)
            tries += 1
            if ended in KILLED and tries == 1:
                continue  # again, in a process of its own
            yield place, None, _how(ended, process.exitcode)
            place, tries = place + 1, 0
        finally:
            here.close()
            process.join()


def _how(ended: int, code: Any) -> str:
    try:
        name = signal.Signals(ended).name
    except ValueError:
        return f"The program ended while it was at work on it (exit code {code})."
    more = ", twice: is there enough memory?" if ended in KILLED else "."
    return f"The program was ended by {name} while it was at work on it{more}"


def _serve(parent, there, here, function, items) -> None:
    here.close()
    die_with_parent(parent)
    for item in items:
        try:
            there.send(("done", function(item)))
        except (MemoryError, OSError) as error:
            theirs = isinstance(error, OSError) and error.errno not in OF_THE_MACHINE
            there.send(("failed", reason(error)) if theirs else ("machine", error))
        except Exception as error:
            there.send(("failed", reason(error)))
    there.close()
    os._exit(0)  # what libraries do at the end of a process is the parent's


def reason(error: BaseException) -> str:
    """In one line."""
    known = isinstance(error, (SpherePropagationError, Failed))
    text = for_files(str(error)) if known else f"{type(error).__name__}: {error}"
    return " ".join(text.split())
