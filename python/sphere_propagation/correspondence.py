# SPDX-License-Identifier: GPL-3.0-only
"""The whole job: root map, propagation, landmarks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Sequence, Union

import numpy as np

from .errors import InputError
from .filters import (
    INITIAL_MAPS,
    METHODS,
    MOST_LANDMARKS,
    ORDERS,
    Figures,
    parameterise_root,
    propagate,
    remesh,
)
from .progress import SILENT, Silent
from .sphere_map import MapLike, SphereMap, as_map
from .surface import Surface, SurfaceLike, as_surfaces, largest


@dataclass(frozen=True, eq=False)
class Correspondence:
    """All surfaces mapped to the sphere and resampled: landmarks[t, j] is the same place for all
    t."""

    surfaces: List[Surface]
    root: int  # index of the surface whose map was handed on
    method: str
    order: str
    root_map: SphereMap  # as it was handed on
    maps: List[SphereMap]  # one per surface
    landmarks: np.ndarray  # (surfaces, 10 f^2 + 2, 3)
    landmark_faces: np.ndarray  # (20 f^2, 3), shared by all
    figures: (
        Figures  # those of Propagation and of Landmarks (its seconds are called remeshing_seconds)
    )


def check_arguments(
    count: int,
    *,
    root: Optional[int],
    method: str,
    order: str,
    frequency: int,
    initial_map: str,
    area_weight: float,
    area_restoration: float,
    parents: Union[str, Sequence[int]],
) -> Optional[int]:
    """What the filters would refuse of correspond()'s arguments, but late, for so many surfaces.
    Returns the root, where it is known.

    Raises InputError.
    """
    for name, value, choices in (
        ("method", method, METHODS),
        ("order", order, ORDERS),
        ("initial_map", initial_map, INITIAL_MAPS),
    ):
        if value not in choices:
            raise InputError(
                f"{name} must be one of {', '.join(map(repr, choices))}, not {value!r}."
            )
    for name, value in (("area_weight", area_weight), ("area_restoration", area_restoration)):
        if not 0 <= value <= 1:
            raise InputError(f"{name} must lie between 0 and 1, not at {value}.")
    largest_frequency = int((MOST_LANDMARKS / count / 10) ** 0.5)
    if not 1 <= frequency <= largest_frequency:
        raise InputError(
            f"frequency must lie between 1 and {largest_frequency} for {count} surfaces, not at "
            f"{frequency}."
        )
    if order == "Given":
        root = _root_of(parents, count, root)
    if root is not None and not 0 <= root < count:
        raise InputError(
            f"Layer {root} cannot be the root: layers are numbered from 0 to {count - 1}."
        )
    return root


def _root_of(parents: Union[str, Sequence[int]], count: int, root: Optional[int]) -> int:
    """The one whose parent is -1, in parents that lead all layers to it."""
    try:
        numbers = [
            int(parent) for parent in (parents.split(",") if isinstance(parents, str) else parents)
        ]
    except ValueError:
        raise InputError(f'parents must be whole numbers, as "-1,0,1", not {parents!r}.') from None
    roots = [i for i, parent in enumerate(numbers) if parent == -1]
    if (
        len(numbers) != count
        or len(roots) != 1
        or not all(-1 <= parent < count for parent in numbers)
    ):
        raise InputError(
            f"parents must be {count} numbers, one per layer: -1 for the root, once, and for the "
            f"others the layer that their map comes from, 0 to {count - 1}; they are "
            f"{', '.join(map(str, numbers))}."
        )
    if root is not None and root != roots[0]:
        raise InputError(f"Layer {root} cannot be the root: parents say that layer {roots[0]} is.")
    for layer in range(count):
        at = layer
        for _ in range(count):
            at = at if at == roots[0] else numbers[at]
        if at != roots[0]:
            raise InputError(
                f"parents lead from layer {layer} round in a circle, not to the root, layer "
                f"{roots[0]}."
            )
    return roots[0]


def correspond(
    surfaces: Sequence[SurfaceLike],
    *,
    root: Optional[int] = None,
    method: str = "Robust",
    order: str = "Time",
    frequency: int = 10,
    initial_map: str = "Automatic",
    area_weight: float = 0.9,
    area_restoration: float = 0.0,
    parents="",
    root_map: Optional[MapLike] = None,
    mirror_layers: bool = False,
    progress: Silent = SILENT,
) -> Correspondence:
    """Corresponding landmarks on a sequence of closed surfaces, by parameterise_root, propagate and
    remesh, whose parameters it has.

    surfaces: in order of time, in one coordinate frame and unit. root: index of the surface that
    gets the first map; default: the one of largest volume, end-diastole of a heart cycle, and in
    the order Given the one whose parent is -1. root_map: a map of it that
    exists already. mirror_layers: as of propagate; `surfaces` of the result are then those that
    have the maps. progress: is told what is being done and what was found, as a progress.Lines
    prints it.

    Raises InputError for arguments out of range, before any work.
    """
    surfaces = as_surfaces(surfaces)
    root = check_arguments(
        len(surfaces),
        root=root,
        method=method,
        order=order,
        frequency=frequency,
        initial_map=initial_map,
        area_weight=area_weight,
        area_restoration=area_restoration,
        parents=parents,
    )
    if root is None:
        root = largest(surfaces)
    if root_map is None:
        progress.begin(f"root map of {surfaces[root].name}")
        root_map = parameterise_root(
            surfaces[root], initial_map=initial_map, area_weight=area_weight
        )
        progress.done(
            f"root map of {surfaces[root].name}: {root_map.figures['flipped_faces']} flipped "
            f"faces, area ratio sd {root_map.figures['area_ratio_sd']:.4f}"
        )
    root_map = as_map(root_map)
    name = method.lower()
    progress.begin(f"{name}: maps of {len(surfaces)} layers")
    propagation = propagate(
        surfaces,
        root_map,
        root_layer=root,
        method=method,
        order=order,
        parents=parents,
        area_restoration=area_restoration,
        mirror_layers=mirror_layers,
    )
    for surface, mirrored in zip(surfaces, propagation.figures["mirrored"]):
        if mirrored:
            progress.note(f"{surface.name} is a mirror image of the others, and was reflected")
    surfaces = propagation.surfaces
    figures = dict(propagation.figures)
    figures["seconds"] = figures["seconds"].copy()
    figures["seconds"][root] = root_map.figures.get("seconds", 0.0)
    progress.done(
        f"{name}: maps of {len(surfaces)} layers, {int(figures['flipped_faces'].sum())} flipped "
        f"faces, {int(figures['repaired_faces'].sum())} repaired on the way"
    )
    progress.begin(f"{name}: landmarks")
    landmarks = remesh(surfaces, propagation.maps, frequency=frequency)
    distances = dict(landmarks.figures)
    distances["remeshing_seconds"] = distances.pop("seconds")
    figures.update(distances)
    progress.done(
        f"{name}: {landmarks.points.shape[1]} landmarks on each layer, "
        f"{figures['surface_distance_mean'].mean():.2f} mm from the surfaces on average"
    )
    return Correspondence(
        surfaces,
        root,
        method,
        order,
        root_map,
        propagation.maps,
        landmarks.points,
        landmarks.faces,
        figures,
    )
