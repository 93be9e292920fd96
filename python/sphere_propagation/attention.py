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
from typing import Any, Dict, Iterable, Iterator, List, Mapping, Tuple, Union

from .errors import MESSAGES_FOR_ARRAYS, SpherePropagationWarning, for_arrays

PACKAGE = str(Path(__file__).parent)
#: Names of messages that say the same of a surface and of its landmarks.
ALIKE = (
    {
        "anotherSize",
        "anotherUnit",
        "anotherSizeThanRoot",
        "anotherUnitThanRoot",
        "severalSizes",
        "halfOfLayersLarger",
        "sizeStandsOut",
        "sizesStandOut",
        "halfOfShapesLarger",
    },
    {"repeatedSurface", "repeatedSurfaces", "repeatedShape", "repeatedShapes"},
)
KEY = "warnings"  # of what a filter returns (host/warnings.h)

_collecting: ContextVar[Tuple[List[SpherePropagationWarning], ...]] = ContextVar(
    "collecting", default=()
)
_noted: ContextVar[Tuple[str, ...]] = ContextVar("noted", default=())
_before: ContextVar[Tuple[SpherePropagationWarning, ...]] = ContextVar("before", default=())
_silent: ContextVar[bool] = ContextVar("silent", default=False)


def warnings_of(returned: Mapping[str, Any], notes: bool = False) -> List[SpherePropagationWarning]:
    """The warnings in what a filter returned to MeshSet.apply_filter; with notes also its advice,
    whose `kind` is "Note"."""
    code = returned.get(KEY)
    if code is None or not len(code):
        return []
    found = [
        SpherePropagationWarning.of(
            remark["subject"],
            remark["text"],
            remark["layers"],
            remark["message"],
            remark["kind"],
        )
        for remark in json.loads(bytes(map(int, code)).decode())
    ]
    return [warning for warning in found if notes or warning.kind != "Note"]


def pass_on(returned: Dict[str, Any]) -> None:
    """Takes the warnings out of what a filter returned, and issues them; and notes that noting()
    asks for, each text once."""
    for warning in map(_in_words_of_arrays, warnings_of(returned, notes=True)):
        if (
            warning.kind != "Note"
            or warning.message in _noted.get()
            and not any(
                str(warning) == str(other) for found in _collecting.get() for other in found
            )
        ):
            warn(warning)
    returned.pop(KEY, None)


def _in_words_of_arrays(warning: SpherePropagationWarning) -> SpherePropagationWarning:
    return SpherePropagationWarning.of(
        warning.subject,
        for_arrays(warning.said) if warning.message in MESSAGES_FOR_ARRAYS else warning.said,
        warning.layers,
        warning.message,
        warning.kind,
    )


def warn(warning: Union[str, SpherePropagationWarning]) -> None:
    """A SpherePropagationWarning; its place is where the package was called from."""
    if isinstance(warning, str):
        warning = SpherePropagationWarning(warning)
    if _silent.get() or _was_said(warning):
        return
    for found in _collecting.get():
        found.append(warning)
    frame, level = sys._getframe(1), 2  # the caller's; 1 would be this function
    while frame.f_back and str(Path(frame.f_code.co_filename).parent) == PACKAGE:
        frame, level = frame.f_back, level + 1
    warnings.warn(warning, stacklevel=level)


def _was_said(warning: SpherePropagationWarning) -> bool:
    """Whether warnings before said the same of all its layers."""
    said = {
        name
        for before in _before.get()
        for name in before.layers
        if any({warning.message, before.message} <= alike for alike in ALIKE)
    }
    return bool(warning.layers) and said.issuperset(warning.layers)


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
def after(said: Iterable[SpherePropagationWarning]) -> Iterator[None]:
    """Within, what these said of a surface is not said again of its landmarks."""
    token = _before.set((*_before.get(), *said))
    try:
        yield
    finally:
        _before.reset(token)


@contextmanager
def silenced() -> Iterator[None]:
    """Nothing is warned of within."""
    token = _silent.set(True)
    try:
        yield
    finally:
        _silent.reset(token)
