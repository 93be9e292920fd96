# SPDX-License-Identifier: GPL-3.0-only
"""How well a model shows a shape that took no part in it at all, not even in the correspondence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import attention, layers
from .correspondence import Correspondence, correspond
from .errors import InputError
from .filters import Landmarks, shape_model
from .fitting import POSES, fit
from .parameters import in_full, require_choice, whole_numbers
from .surface import Surface, SurfaceLike, array_of, as_surfaces
from .turns import turn

DISTANCE = "get_hausdorff_distance"  # of MeshLab
MAX_SHAPES = 20  # each of which is a population to build

Built = Union[Correspondence, Landmarks, Tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True, eq=False)
class RebuiltGeneralisation:
    """modes: how many, by column. distances: (shapes, modes), how far each surface lies from the
    best shape of the model of all others: the mean over the vertices of each, from the closest
    points of the other, both ways, in their unit."""

    modes: List[int]
    distances: np.ndarray

    @property
    def generalisation(self) -> np.ndarray:
        """Their mean, by number of modes."""
        return self.distances.mean(0)

    @property
    def generalisation_error(self) -> np.ndarray:
        """Its standard error."""
        return self.distances.std(0) / np.sqrt(max(1, len(self.distances) - 1))

    def __repr__(self) -> str:
        found = ", ".join(f"{g:.3g} with {m}" for g, m in zip(self.generalisation, self.modes))
        return f"RebuiltGeneralisation({len(self.distances)} shapes: {found})"


def rebuilt_generalisation(
    surfaces: Sequence[SurfaceLike],
    modes: Union[int, Sequence[int]] = 1,
    *,
    build: Optional[Callable[[List[Surface]], Built]] = None,
    alignment: str = "Rigid",
    pose: str = "As it lies",
) -> RebuiltGeneralisation:
    """The generalisation of a way to correspondence: each surface is left out in turn, the
    correspondence of all others is built anew without it, and the model of their landmarks is
    fitted to it by distances alone. The measure of shape_model leaves a shape out of the modes
    only, whose landmarks were found together with all others.

    surfaces: 4 to 20, in one unit. modes: of the models, one number or several, each at most the
    number of surfaces less two.
    build: surfaces -> Correspondence, Landmarks or (points, faces); default: correspond in the
    order Similarity tree, with groupwise. alignment: of the model. pose: where each surface is
    looked for, as of fit.
    """
    surfaces = as_surfaces(surfaces)
    if not 4 <= len(surfaces) <= MAX_SHAPES:
        raise InputError(
            f"Correspondence is rebuilt without each of 4 to {MAX_SHAPES} surfaces, not of "
            f"{len(surfaces)}: that is as many populations. Choose some of them."
        )
    wanted = whole_numbers("modes", modes)
    if not wanted or not all(1 <= m <= len(surfaces) - 2 for m in wanted):
        raise InputError(
            f"modes must lie between 1 and {len(surfaces) - 2} for {len(surfaces)} surfaces, not "
            f"at {', '.join(map(str, wanted)) or 'none'}."
        )
    if build is not None and not callable(build):
        raise InputError(f"build must be a function of surfaces, not {type(build).__name__}.")
    pose = in_full("pose", pose)
    require_choice("pose", pose, POSES[:2])
    distances = np.empty((len(surfaces), len(wanted)))
    with attention.silenced():  # as many times the same
        for k, surface in enumerate(surfaces):
            points, faces = _built(build, surfaces[:k] + surfaces[k + 1 :])
            model = shape_model(points, faces, alignment=alignment, specificity_samples=1)
            for i, m in enumerate(wanted):
                found = fit(model, surface, pose=pose, modes=m, local_deviation=False)
                distances[k, i] = _distance(surface, Surface(found.points, found.faces, "fit"))
    return RebuiltGeneralisation(wanted, distances)


def _distance(one: Surface, other: Surface) -> float:
    """The mean distance of the vertices of each from the closest points of the other, averaged."""
    meshes = layers.mesh_set([one, other])
    ways = []
    for sampled in (0, 1):
        with turn(DISTANCE):
            ways.append(
                meshes.apply_filter(
                    DISTANCE,
                    sampledmesh=sampled,
                    targetmesh=1 - sampled,
                    samplevert=True,
                    sampleedge=False,
                    sampleface=False,
                )["mean"]
            )
    return float(np.mean(ways))


def _built(build, others: List[Surface]) -> Tuple[np.ndarray, np.ndarray]:
    if build is None:
        made: Built = correspond(others, order="Similarity tree", groupwise=True)
    else:
        made = build(others)
    if isinstance(made, Correspondence):
        points, faces = made.landmarks, made.landmark_faces
    elif isinstance(made, Landmarks):
        points, faces = made.points, made.faces
    else:
        try:
            points, faces = made
        except (TypeError, ValueError):
            raise InputError(
                "build must return a Correspondence, Landmarks or (points, faces), not "
                f"{type(made).__name__}."
            ) from None
    points = array_of("Landmarks", points)
    if len(points) != len(others):
        raise InputError(f"build made landmarks of {len(points)} of {len(others)} surfaces.")
    return points, array_of("faces", faces)
