# SPDX-License-Identifier: GPL-3.0-only
"""What tells one file from another."""

from __future__ import annotations

import hashlib
from pathlib import Path


def digest(path: Path) -> str:
    """A file's SHA-256."""
    found = hashlib.sha256()
    with open(path, "rb") as file:
        for block in iter(lambda: file.read(1 << 20), b""):
            found.update(block)
    return found.hexdigest()
