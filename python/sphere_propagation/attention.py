# SPDX-License-Identifier: GPL-3.0-only
"""Warnings of this package, at the line of the user's that called it."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

from .errors import SpherePropagationWarning

PACKAGE = str(Path(__file__).parent)


def warn(text: str) -> None:
    """A SpherePropagationWarning; its place is where the package was called from."""
    frame, level = sys._getframe(1), 2  # the caller's; 1 would be this function
    while frame.f_back and str(Path(frame.f_code.co_filename).parent) == PACKAGE:
        frame, level = frame.f_back, level + 1
    warnings.warn(text, SpherePropagationWarning, stacklevel=level)
