# SPDX-License-Identifier: GPL-3.0-only
"""Closed surfaces as arrays."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import List, Sequence, Tuple, Union

import numpy as np

from .errors import InputError


@dataclass(frozen=True, eq=False)
class Surface:
    """A closed triangle mesh without holes, handles or loose parts.

    vertices: (n, 3) in one unit, mm for hearts; faces: (k, 3) vertex indices, counterclockwise from
    outside; name: what errors, layers and files call it. Anything that numpy takes for arrays of
    these shapes is accepted.
    """

    vertices: np.ndarray
    faces: np.ndarray
    name: str = "surface"

    def __post_init__(self):
        vertices, faces = np.asarray(self.vertices), np.asarray(self.faces)
        if vertices.ndim != 2 or vertices.shape[1] != 3 or vertices.dtype.kind not in "fiu":
            raise InputError(
                f"{self.name}: vertices must be numbers of shape (n, 3), not {vertices.dtype} of "
                f"shape {vertices.shape}."
            )
        if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
            raise InputError(
                f"{self.name}: faces must be integers of shape (k, 3), not {faces.dtype} of shape "
                f"{faces.shape}."
            )
        outside = (faces < 0) | (faces >= len(vertices))
        if outside.any():
            first = int(np.flatnonzero(outside.any(1))[0])
            raise InputError(
                f"{self.name}: {int(outside.any(1).sum())} faces name a vertex that is not there "
                f"(first: face {first}, {faces[first].tolist()}, of {len(vertices)} vertices)."
            )
        object.__setattr__(self, "vertices", np.ascontiguousarray(vertices, np.float64))
        object.__setattr__(self, "faces", np.ascontiguousarray(faces, np.int32))

    @property
    def volume(self) -> float:
        """Of what it surrounds; negative when its faces look inwards."""
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)

    @property
    def mean_edge_length(self) -> float:
        """Of its faces' edges."""
        corners = self.vertices[self.faces]
        return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())


SurfaceLike = Union[Surface, Tuple[np.ndarray, np.ndarray]]  # the tuple: vertices, faces


def as_surface(surface: SurfaceLike, name: str = "surface") -> Surface:
    """A Surface, also from (vertices, faces); `name` is for those that have none."""
    if isinstance(surface, Surface):
        return surface
    try:
        vertices, faces = surface
    except (TypeError, ValueError):
        raise InputError(
            f"{name} must be a Surface or (vertices, faces), not {type(surface).__name__}."
        ) from None
    return Surface(vertices, faces, name)


def as_surfaces(surfaces: Sequence[SurfaceLike]) -> List[Surface]:
    """As as_surface; nameless ones are called after their place."""
    found = [as_surface(surface, f"surface {i}") for i, surface in enumerate(surfaces)]
    if not found:
        raise InputError("There is no surface to work on.")
    return found


def distinct_names(surfaces: Sequence[Surface]) -> List[str]:
    """Their names; those that several of them have, with their place."""
    count = Counter(surface.name for surface in surfaces)
    return [
        surface.name if count[surface.name] == 1 else f"{surface.name} ({i})"
        for i, surface in enumerate(surfaces)
    ]


def largest(surfaces: Sequence[Surface]) -> int:
    """Index of the surface of largest volume: end-diastole, the better root of a heart cycle."""
    return int(np.argmax([abs(surface.volume) for surface in surfaces]))
