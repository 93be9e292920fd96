# SPDX-License-Identifier: GPL-3.0-only
"""From which side surfaces are looked at, in pictures and in projects."""

from __future__ import annotations

import re
from typing import List, NamedTuple, Optional, Sequence

import numpy as np

from .correspondence import Correspondence
from .units import volume_unit


class Row(NamedTuple):
    """One sequence in a picture of several surfaces, or in a project."""

    title: str
    result: Correspondence
    up: Optional[Sequence[float]] = None  # direction; default: along the root's long axis
    phases: Optional[Sequence[int]] = (
        None  # the number of each surface's phase; default: as they come, from 0
    )

    def numbers(self) -> List[int]:
        """Of the phases."""
        return (
            [int(phase) for phase in self.phases]
            if self.phases is not None
            else list(range(len(self.result.surfaces)))
        )

    @property
    def timed(self) -> bool:
        """Whether these are phases of one thing, and no collection of shapes: they are in an order
        of time, and their names are alike but for numbers."""
        names = [surface.name for surface in self.result.surfaces]
        return self.result.order in ("Time", "Cyclic time") and (
            self.phases is not None or len({re.sub(r"\d+", "#", name) for name in names}) == 1
        )

    @property
    def noun(self) -> str:
        """What each surface is, for texts."""
        return "phase" if self.timed else "shape"

    def caption(self, i: int) -> str:
        """Of one surface."""
        surface = self.result.surfaces[i]
        if not self.timed:
            return surface.name
        per, unit = volume_unit(self.result.unit)
        volume = abs(surface.volume) / per
        digits = f"{volume:.0f}" if volume >= 10 else f"{volume:.2g}"
        return f"phase {self.numbers()[i]}, {digits} {unit}"


def upright(
    vertices: np.ndarray, up: Optional[Sequence[float]] = None, tilt: float = 26.0
) -> np.ndarray:
    """Rotation (3, 3) to view coordinates (right, up, towards the eye): `up` upright, the broad
    side in front, seen from `tilt` degrees above. Without `up` the long axis is upright, its narrow
    end down, as hearts are drawn.
    """
    centered = vertices - vertices.mean(0)
    if up is None:
        axis = np.linalg.eigh(centered.T @ centered)[1][:, 2]
        axis = axis * (1 if ((centered @ axis) ** 3).sum() < 0 else -1)
    else:
        axis = np.asarray(up, float)
    axis = axis / np.linalg.norm(axis)
    flat = centered - np.outer(centered @ axis, axis)
    eye = np.linalg.eigh(flat.T @ flat)[1][:, 1]  # 0 is the axis itself
    eye = eye * (1 if eye[np.abs(eye).argmax()] < 0 else -1)
    right = np.cross(axis, eye)
    angle = np.radians(tilt)
    tilted = np.array(
        [[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]]
    )
    return tilted @ np.stack([right, axis, eye])


def sphere_rotation(vertices: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Rotation (3, 3) that turns the sphere so that it shows the same side as the surface does."""
    u, _, v = np.linalg.svd((vertices - (vertices.min(0) + vertices.max(0)) / 2).T @ positions)
    return u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v


def chosen_phases(count: int, columns: int, rows: int = 1) -> List[int]:
    """Some of them, spread evenly: over a cycle the last is followed by the first."""
    shown = min(count, columns * rows)
    return [int(round(k * count / shown)) for k in range(shown)]
