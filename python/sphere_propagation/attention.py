# SPDX-License-Identifier: GPL-3.0-only
"""What deserves a look: the filters' warnings, read from what they return, as warnings of Python's
at the line of the user's that called this package."""

from __future__ import annotations

import json
import sys
import warnings
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Tuple, Union

from .errors import SpherePropagationWarning

PACKAGE = str(Path(__file__).parent)
KEY = "warnings"  # of what a filter returns (host/warnings.h)

_collecting: ContextVar[Tuple[List[SpherePropagationWarning], ...]] = ContextVar(
    "collecting", default=()
)
_noted: ContextVar[Tuple[str, ...]] = ContextVar("noted", default=())
_silent: ContextVar[bool] = ContextVar("silent", default=False)


def warnings_of(returned: Mapping[str, Any], notes: bool = False) -> List[SpherePropagationWarning]:
    """The warnings in what a filter returned to MeshSet.apply_filter; with notes also its advice,
    whose `kind` is "Note"."""
    code = returned.get(KEY)
    if code is None or not len(code):
        return []
    found = [
        SpherePropagationWarning(
            f"{remark['layer']}: {remark['text']}" if remark["layer"] else remark["text"],
            remark["layer"],
            remark["message"],
            remark["kind"],
        )
        for remark in json.loads(bytes(map(int, code)).decode())
    ]
    return [warning for warning in found if notes or warning.kind != "Note"]


def pass_on(returned: Dict[str, Any]) -> None:
    """Takes the warnings out of what a filter returned, and issues them; and notes that noting()
    asks for, each text once."""
    for warning in warnings_of(returned, notes=True):
        if (
            warning.kind != "Note"
            or warning.message in _noted.get()
            and not any(
                str(warning) == str(other) for found in _collecting.get() for other in found
            )
        ):
            warn(warning)
    returned.pop(KEY, None)


def warn(warning: Union[str, SpherePropagationWarning]) -> None:
    """A SpherePropagationWarning; its place is where the package was called from."""
    if _silent.get():
        return
    if isinstance(warning, str):
        warning = SpherePropagationWarning(warning)
    for found in _collecting.get():
        found.append(warning)
    frame, level = sys._getframe(1), 2  # the caller's; 1 would be this function
    while frame.f_back and str(Path(frame.f_code.co_filename).parent) == PACKAGE:
        frame, level = frame.f_back, level + 1
    warnings.warn(warning, stacklevel=level)


@contextmanager
def collected() -> Iterator[List[SpherePropagationWarning]]:
    """A list of what is warned of within, whatever Python's filters do with it."""
    found: List[SpherePropagationWarning] = []
    token = _collecting.set((*_collecting.get(), found))
    try:
        yield found
    finally:
        _collecting.reset(token)


@contextmanager
def noting(*messages: str) -> Iterator[None]:
    """Within, notes of these names are issued as warnings are; their kind is "Note"."""
    token = _noted.set(messages)
    try:
        yield
    finally:
        _noted.reset(token)


@contextmanager
def silenced() -> Iterator[None]:
    """Nothing is warned of within."""
    token = _silent.set(True)
    try:
        yield
    finally:
        _silent.reset(token)
