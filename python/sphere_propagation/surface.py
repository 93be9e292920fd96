# SPDX-License-Identifier: GPL-3.0-only
"""Closed surfaces as arrays."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from typing import Any, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import adapters
from .errors import InputError

NAMELESS = "surface"  # what one is called where nobody said


@dataclass(frozen=True, eq=False)
class Surface:
    """A closed triangle mesh without holes, handles or loose parts.

    vertices: (n, 3) in one unit, mm for hearts; faces: (k, 3) vertex indices, counterclockwise from
    outside; name: what errors, layers and files call it; space: the frame of the vertices, "RAS"
    or "LPS", empty where nobody knows; lid: (n,), per vertex the number (from 1) of the lid that it
    belongs to, 0 where the surface was measured, None where there is no lid, as prepare says it.
    Anything that numpy takes for arrays of these shapes is accepted.
    """

    vertices: np.ndarray
    faces: np.ndarray
    name: str = NAMELESS
    space: str = ""
    lid: Optional[np.ndarray] = None

    def __post_init__(self):
        if not isinstance(self.name, str):
            raise InputError(f"A surface's name must be a text, not {self.name!r}.")
        if not isinstance(self.space, str) or self.space not in ("", "RAS", "LPS"):
            raise InputError(f'{self.name}: space must be "RAS", "LPS" or "", not {self.space!r}.')
        vertices = array_of(f"{self.name}: vertices", self.vertices)
        faces = array_of(f"{self.name}: faces", self.faces)
        if vertices.ndim != 2 or vertices.shape[1] != 3 or vertices.dtype.kind not in "fiu":
            raise InputError(
                f"{self.name}: vertices must be numbers of shape (n, 3), not {vertices.dtype} of "
                f"shape {vertices.shape}."
            )
        if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
            raise InputError(
                f"{self.name}: faces must be integers of shape (k, 3), not {faces.dtype} of shape "
                f"{faces.shape}." + _about_faces(faces)
            )
        outside = (faces < 0) | (faces >= len(vertices))
        if outside.any():
            first = int(np.flatnonzero(outside.any(1))[0])
            raise InputError(
                f"{self.name}: {int(outside.any(1).sum())} faces name a vertex that is not there "
                f"(first: face {first}, {faces[first].tolist()}, of {len(vertices)} vertices)."
                + (
                    " If they count from 1: faces - 1."
                    if faces.min() == 1 and faces.max() == len(vertices)
                    else ""
                )
            )
        if self.lid is not None:
            lid = array_of(f"{self.name}: lid", self.lid)
            if lid.shape != (len(vertices),) or lid.dtype.kind not in "biuf":
                raise InputError(
                    f"{self.name}: lid must be {len(vertices)} numbers, one per vertex, not "
                    f"{lid.dtype} of shape {lid.shape}."
                )
            object.__setattr__(self, "lid", lid.astype(int) if lid.any() else None)
        object.__setattr__(self, "vertices", np.ascontiguousarray(vertices, np.float64))
        object.__setattr__(self, "faces", np.ascontiguousarray(faces, np.int32))

    def __repr__(self) -> str:
        space = f", {self.space}" if self.space else ""
        return (
            f"Surface({self.name!r}, {len(self.vertices)} vertices, {len(self.faces)} faces{space})"
        )

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


def counted(things: Sequence, noun: str) -> str:
    """ "1 surface", "2 surfaces"."""
    return f"{len(things)} {noun}{'' if len(things) == 1 else 's'}"


def count_others(count: int) -> str:
    """ "1 other", "2 others"."""
    return f"{count} other{'' if count == 1 else 's'}"


def array_of(what: str, values: Any) -> np.ndarray:
    """Whatever numpy takes for an array; `what` it is, for errors."""
    try:
        found = np.asanyarray(values)
    except Exception as error:  # numpy's, or that of the values' own library
        advice = ": values.detach().cpu().numpy() is" if hasattr(values, "detach") else ""
        raise InputError(f"{what} cannot be made an array{advice}. {error}") from error
    if isinstance(found, np.ma.MaskedArray) and np.ma.getmaskarray(found).any():
        raise InputError(f"{what} are masked in part: leave these out first.")
    return np.asarray(found)


def _about_faces(faces: np.ndarray) -> str:
    """What to do where they are not triangles."""
    if faces.ndim == 2 and faces.shape[1] == 4 and faces.dtype.kind in "iu":
        counted = len(faces) and (faces[:, 0] == 3).all()
        return (
            " The first column counts corners: faces[:, 1:]."
            if counted
            else " Quadrilaterals are np.vstack([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])."
        )
    if faces.ndim == 1 and faces.size and faces.size % 4 == 0 and (faces[::4] == 3).all():
        return " As pyvista has them, triangles are faces.reshape(-1, 4)[:, 1:]."
    return ""


# The tuple: vertices, faces. Any: what adapters knows, files and objects of other libraries.
SurfaceLike = Union[Surface, Tuple[np.ndarray, np.ndarray], Any]


def as_surface(surface: SurfaceLike, name: str = NAMELESS) -> Surface:
    """A Surface, also from (vertices, faces), a file, or a mesh of another library; `name` is for
    those that have none."""
    if adapters.is_prepared(surface):
        surface = surface.surface
    if isinstance(surface, Surface):
        return surface
    mesh = adapters.mesh_of(surface, name)
    return Surface(mesh.vertices, mesh.faces, mesh.name or name, mesh.space)


def as_surfaces(surfaces: Sequence[SurfaceLike]) -> List[Surface]:
    """As as_surface; nameless ones are called after their place, also where all got the name that a
    nameless one has alone. A folder stands for its meshes."""
    given = adapters.surfaces_in(surfaces)
    found = [as_surface(surface, name) for surface, name in given]
    nameless = [i for i, surface in enumerate(found) if surface.name == NAMELESS]
    for i in nameless if len(nameless) > 1 else ():
        found[i] = replace(found[i], name=given[i][1])
    if not found:
        raise InputError("There is no surface to work on.")
    spaces = {surface.space: surface.name for surface in reversed(found) if surface.space}
    if len(spaces) > 1:
        raise InputError(
            f"{spaces['RAS']} is in RAS, {spaces['LPS']} in LPS: bring them into one frame, as "
            'sp.Surface(s.vertices * [-1, -1, 1], s.faces, s.name, "RAS").'
        )
    return found


def distinct_names(surfaces: Sequence[Surface]) -> List[str]:
    """Their names; those that several of them have, with their place."""
    count = Counter(surface.name for surface in surfaces)
    return [
        surface.name if count[surface.name] == 1 else f"{surface.name} ({i})"
        for i, surface in enumerate(surfaces)
    ]


def largest(surfaces: Sequence[Surface]) -> int:
    """Index of the surface of largest volume: end-diastole, the better root of a heart cycle. One
    of another unit, or another shape, does not count: up to a quarter of the surfaces, where they
    are more than twice as large as all others and three times as large as the median."""
    volumes = np.array([abs(surface.volume) for surface in surfaces])
    order = np.argsort(-volumes, kind="stable")
    ordered = volumes[order]
    first = 0
    for k in range(len(order) // 4):
        if ordered[k] > 2 * ordered[k + 1] and ordered[k] > 3 * np.median(volumes):
            first = k + 1
    return int(order[first])
