# SPDX-License-Identifier: GPL-3.0-only
"""The version of this package."""

from __future__ import annotations

import re
from pathlib import Path


def version() -> str:
    """That of the project in CMakeLists.txt: written down when the package is built, read there in
    a checkout."""
    try:
        from ._version import version as built

        return built
    except ImportError:
        text = (Path(__file__).resolve().parents[2] / "CMakeLists.txt").read_text(encoding="utf-8")
        found = re.search(r"project\(SpherePropagation VERSION ([0-9.]+)", text)
        return found[1] if found else "unknown"
