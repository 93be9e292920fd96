# SPDX-License-Identifier: GPL-3.0-only
"""The unit of lengths, which meshes do not say: a word for tables, pictures and messages; no number
depends on it."""

from __future__ import annotations

from typing import Tuple

from .errors import InputError

DEFAULT_UNIT = "mm"
# Of a volume, per unit of length to the third: how many make one, and what it is called.
_VOLUMES = {
    "um": (1e9, "mm³"),
    "µm": (1e9, "mm³"),
    "mm": (1e3, "ml"),
    "cm": (1.0, "ml"),
    "m": (1.0, "m³"),
}


def unit_named(unit) -> str:
    """The unit as it was given, where it can be one."""
    if not isinstance(unit, str) or not unit.strip() or len(unit.split()) > 1 or len(unit) > 12:
        raise InputError(f"unit must be a short word, as 'mm', not {unit!r}.")
    return unit.strip()


def volume_unit(unit: str) -> Tuple[float, str]:
    """By how much a volume in unit³ is divided, and the name of what that is."""
    return _VOLUMES.get(unit, (1.0, f"{unit}³"))
