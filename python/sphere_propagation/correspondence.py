"""The whole job: root map, propagation, landmarks."""
from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Sequence

import numpy as np

from .errors import InputError
from .filters import Figures, parameterise_root, propagate, remesh
from .progress import Silent
from .sphere_map import MapLike, SphereMap, as_map
from .surface import Surface, SurfaceLike, as_surfaces, largest


@dataclass(frozen=True, eq=False)
class Correspondence:
    """All surfaces mapped to the sphere and resampled: landmarks[t, j] is the same place for all t."""

    surfaces: List[Surface]
    root: int  # index of the surface whose map was handed on
    method: str
    order: str
    root_map: SphereMap  # as it was handed on
    maps: List[SphereMap]  # one per surface
    landmarks: np.ndarray  # (surfaces, 10 f^2 + 2, 3)
    landmark_faces: np.ndarray  # (20 f^2, 3), shared by all
    figures: Figures  # those of Propagation and of Landmarks (its seconds are called remeshing_seconds)


def correspond(surfaces: Sequence[SurfaceLike], *, root: Optional[int] = None, method: str = "Robust", order: str = "Time",
               frequency: int = 10, initial_map: str = "Automatic", area_weight: float = 0.9, area_restoration: float = 0.0,
               parents="", root_map: Optional[MapLike] = None, progress=Silent()) -> Correspondence:
    """Corresponding landmarks on a sequence of closed surfaces, by parameterise_root, propagate and remesh, whose parameters it has.

    surfaces: in order of time, in one coordinate frame and unit. root: index of the surface that gets the first map; default: the one
    of largest volume, end-diastole of a heart cycle. root_map: a map of it that exists already. progress: is told what is being done
    and what was found, as a progress.Lines prints it.
    """
    surfaces = as_surfaces(surfaces)
    if root is None:
        root = largest(surfaces)
    if not 0 <= root < len(surfaces):
        raise InputError(f"Layer {root} cannot be the root: layers are numbered from 0 to {len(surfaces) - 1}.")
    if root_map is None:
        progress.begin(f"root map of {surfaces[root].name}")
        root_map = parameterise_root(surfaces[root], initial_map=initial_map, area_weight=area_weight)
        progress.done(f"root map of {surfaces[root].name}: {root_map.figures['flipped_faces']} flipped faces, "
                      f"area ratio sd {root_map.figures['area_ratio_sd']:.4f}")
    root_map = as_map(root_map)
    name = method.lower()
    progress.begin(f"{name}: maps of {len(surfaces)} layers")
    propagation = propagate(surfaces, root_map, root_layer=root, method=method, order=order, parents=parents,
                            area_restoration=area_restoration)
    figures = dict(propagation.figures)
    figures["seconds"] = figures["seconds"].copy()
    figures["seconds"][root] = root_map.figures.get("seconds", 0.0)
    progress.done(f"{name}: maps of {len(surfaces)} layers, {int(figures['flipped_faces'].sum())} flipped faces, "
                  f"{int(figures['repaired_faces'].sum())} repaired on the way")
    progress.begin(f"{name}: landmarks")
    landmarks = remesh(surfaces, propagation.maps, frequency=frequency)
    distances = dict(landmarks.figures)
    distances["remeshing_seconds"] = distances.pop("seconds")
    figures.update(distances)
    progress.done(f"{name}: {landmarks.points.shape[1]} landmarks on each layer, "
                  f"{figures['surface_distance_mean'].mean():.2f} mm from the surfaces on average")
    return Correspondence(surfaces, root, method, order, root_map, propagation.maps, landmarks.points, landmarks.faces, figures)
