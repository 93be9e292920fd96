# SPDX-License-Identifier: GPL-3.0-only
"""The whole job: root map, propagation, landmarks."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import List, Optional, Sequence

import numpy as np

from . import attention
from .errors import FilterError, InputError, SpherePropagationWarning
from .filters import (
    MAX_LANDMARKS,
    AnchorFit,
    Figures,
    anchors_of,
    landmark_places,
    optimise_groupwise,
    parameterise_most_central,
    parameterise_root,
    propagate,
    remesh,
)
from .parameters import (
    DEFAULTS,
    MOST_CENTRAL,
    NAMED,
    AnchorPositions,
    Anchors,
    CorrespondenceParameters,
    Parents,
    Root,
    in_full,
    parent_numbers,
    real_number,
    require_choice,
    whole_number,
)
from .progress import SILENT, Silent
from .sphere_map import MapLike, SphereMap, as_map
from .surface import Surface, SurfaceLike, as_surfaces, largest
from .units import DEFAULT_UNIT, unit_named

SNAP_FREQUENCY = 10  # of the landmarks that anchor_snap brings anchors to


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
    # Those of Propagation and of Landmarks, whose seconds are called remeshing_seconds.
    figures: Figures
    # Of all steps, as they were issued.
    warnings: List[SpherePropagationWarning] = field(default_factory=list)
    unit: str = DEFAULT_UNIT  # of lengths: a word for texts
    # (10 f^2 + 2,), True where a landmark lies on a lid of half of the surfaces or more, so that it
    # is made up; shape_model leaves it out.
    lid: Optional[np.ndarray] = None
    anchors: Optional[AnchorFit] = None  # what became of them, where there were some
    # Where asked for, (surfaces, landmarks): how well each is known along the surface, as
    # Propagation has it at vertices.
    uncertainty: Optional[np.ndarray] = None

    def __repr__(self) -> str:
        return (
            f"Correspondence({len(self.surfaces)} surfaces, {self.landmarks.shape[1]} landmarks, "
            f"root {self.root}, {self.method}, {self.order}, "
            f"{self.figures['flipped_faces'].sum():.0f} flipped faces, "
            f"{len(self.warnings)} warning{'' if len(self.warnings) == 1 else 's'})"
        )


def correspond(
    surfaces: Sequence[SurfaceLike],
    *,
    root: Root = DEFAULTS.root,
    method: str = DEFAULTS.method,
    order: str = DEFAULTS.order,
    frequency: int = DEFAULTS.frequency,
    initial_map: str = DEFAULTS.initial_map,
    area_weight: float = DEFAULTS.area_weight,
    area_restoration: float = DEFAULTS.area_restoration,
    parents: Parents = DEFAULTS.parents,
    root_map: Optional[MapLike] = None,
    mirror_layers: bool = DEFAULTS.mirror_layers,
    groupwise: bool = DEFAULTS.groupwise,
    anchors: Anchors = DEFAULTS.anchors,
    anchor_sd: float = DEFAULTS.anchor_sd,
    exact: bool = DEFAULTS.exact,
    anchor_snap: bool = DEFAULTS.anchor_snap,
    anchor_pose: bool = DEFAULTS.anchor_pose,
    anchor_positions: AnchorPositions = DEFAULTS.anchor_positions,
    uncertainty: bool = DEFAULTS.uncertainty,
    unit: str = DEFAULT_UNIT,
    progress: Silent = SILENT,
) -> Correspondence:
    """Corresponding landmarks on a sequence of closed surfaces, by parameterise_root, propagate and
    remesh, whose parameters it has.

    surfaces: in order of time, in one coordinate frame and unit.
    root: index of the surface that gets the first map; default: the one of largest volume,
    end-diastole of a heart cycle, and in the order Given the one whose parent is -1; "most
    central": the one that is the most like all others, for shapes in no order.
    root_map: a map of it that exists already.
    mirror_layers: as of propagate; `surfaces` of the result are then those that have the maps.
    groupwise: whether all maps, the root's too, are optimised together before landmarks are made,
    as optimise_groupwise does; for shapes in no order.
    anchors, anchor_sd, exact, anchor_snap, anchor_pose: points that must correspond, as of
    propagate.
    anchor_positions: where the root's anchors are to lie on the sphere, as of parameterise_root.
    uncertainty: whether the result says how well each landmark is known (method Robust).
    unit: what lengths are called in texts, tables and pictures; nothing is converted.
    progress: is told what is being done and what was found, as a progress.Lines prints it.

    Raises InputError for arguments out of range, before any work.
    """
    parameters = CorrespondenceParameters(
        root=root,
        method=method,
        order=order,
        parents=parents,
        frequency=frequency,
        initial_map=initial_map,
        area_weight=area_weight,
        area_restoration=area_restoration,
        mirror_layers=mirror_layers,
        groupwise=groupwise,
        anchors=anchors,
        anchor_sd=anchor_sd,
        exact=exact,
        anchor_snap=anchor_snap,
        anchor_pose=anchor_pose,
        anchor_positions=anchor_positions,
        uncertainty=uncertainty,
    )
    return correspond_by(parameters, surfaces, root_map, progress, unit)


def correspond_by(
    parameters: CorrespondenceParameters,
    surfaces: Sequence[SurfaceLike],
    root_map: Optional[MapLike] = None,
    progress: Silent = SILENT,
    unit: str = DEFAULT_UNIT,
) -> Correspondence:
    """As correspond."""
    unit = unit_named(unit)
    with attention.collected() as said:
        found = _correspond(parameters, surfaces, root_map, progress, unit)
    return replace(found, warnings=said)


def _correspond(
    parameters: CorrespondenceParameters,
    surfaces: Sequence[SurfaceLike],
    root_map: Optional[MapLike],
    progress: Silent,
    unit: str,
) -> Correspondence:
    surfaces = as_surfaces(surfaces)
    if len(surfaces) == 1:
        raise InputError("There is one surface: correspondence takes two or more.")
    parameters = checked(parameters, len(surfaces))
    root = largest(surfaces) if parameters.root is None else parameters.root
    if root == MOST_CENTRAL:
        if root_map is not None:
            raise InputError("Which surface has root_map? Say it by root, a number.")
        progress.begin(f"root map of the most central of {len(surfaces)} surfaces")
        root, root_map = parameterise_most_central(
            surfaces,
            initial_map=parameters.initial_map,
            area_weight=parameters.area_weight,
            anchors=parameters.anchors,
            anchor_positions=parameters.anchor_positions,
        )
        progress.done(_described(surfaces[root].name, root_map))
    elif root_map is None:
        progress.begin(f"root map of {surfaces[root].name}")
        root_map = parameterise_root(
            surfaces[root],
            initial_map=parameters.initial_map,
            area_weight=parameters.area_weight,
            anchors=_anchors_of_root(parameters.anchors, root),
            anchor_positions=parameters.anchor_positions,
        )
        progress.done(_described(surfaces[root].name, root_map))
    elif parameters.anchor_positions is not None:
        raise InputError(
            "anchor_positions are for the map of the root that is made, not for one "
            "that is given (root_map)."
        )
    root_map = as_map(root_map)
    name = parameters.method.lower()
    progress.begin(f"{name}: maps of {len(surfaces)} layers")
    propagation = propagate(
        surfaces,
        root_map,
        root_layer=root,
        method=parameters.method,
        order=parameters.order,
        parents=parameters.parents,
        area_restoration=parameters.area_restoration,
        mirror_layers=parameters.mirror_layers,
        anchors=parameters.anchors,
        anchor_sd=parameters.anchor_sd,
        exact=parameters.exact,
        anchor_snap=parameters.anchor_snap,
        anchor_pose=parameters.anchor_pose,
        uncertainty_quality=parameters.uncertainty,
    )
    surfaces = propagation.surfaces
    figures = dict(propagation.figures)
    figures["seconds"] = figures["seconds"].copy()
    figures["seconds"][root] = root_map.figures.get("seconds", 0.0)
    progress.done(
        f"{name}: maps of {len(surfaces)} layers, {int(figures['flipped_faces'].sum())} flipped "
        f"faces, {int(figures['repaired_faces'].sum())} repaired on the way"
    )
    maps = propagation.maps
    if parameters.groupwise and len(surfaces) > 1:
        if parameters.exact and propagation.anchors is not None:
            attention.warn(
                "groupwise moves the anchors that exact holds: where they must hold, leave it out."
            )
        held = propagation.anchors
        maps = _optimised(
            surfaces,
            maps,
            parameters.order,
            figures,
            name,
            progress,
            unit,
            anchors=None if held is None else held.of_surfaces(),
            anchor_sd=parameters.anchor_sd,
        )
    progress.begin(f"{name}: landmarks")
    landmarks = remesh(surfaces, maps, frequency=parameters.frequency)
    distances = dict(landmarks.figures)
    distances["remeshing_seconds"] = distances.pop("seconds")
    figures.update(distances)
    progress.done(
        f"{name}: {landmarks.points.shape[1]} landmarks on each layer, "
        f"{figures['surface_distance_mean'].mean():.2g} {unit} from the surfaces on average"
    )
    return Correspondence(
        surfaces=surfaces,
        root=root,
        method=parameters.method,
        order=parameters.order,
        root_map=maps[root] if parameters.anchor_snap else root_map,
        maps=maps,
        landmarks=landmarks.points,
        landmark_faces=landmarks.faces,
        figures=figures,
        unit=unit,
        lid=2 * landmarks.lid.sum(0) >= len(surfaces),
        anchors=_renumbered(propagation.anchors, parameters.frequency),
        uncertainty=_at_landmarks(
            surfaces, maps, propagation.uncertainties, len(landmarks.points[0])
        ),
    )


def _described(name: str, root_map: SphereMap) -> str:
    return (
        f"root map of {name}: {root_map.figures['flipped_faces']} flipped faces, area ratio sd "
        f"{root_map.figures['area_ratio_sd']:.4f}"
    )


def _at_landmarks(
    surfaces: List[Surface],
    maps: List[SphereMap],
    values: Optional[List[np.ndarray]],
    count: int,
) -> Optional[np.ndarray]:
    """Smooth values of vertices at the landmarks: that of the vertex that is next on the sphere."""
    if values is None:
        return None
    places = landmark_places(surfaces[0], maps[0], count)
    return np.stack(
        [
            of_layer[np.argmax(sphere_map.positions @ places.T, axis=0)]
            for sphere_map, of_layer in zip(maps, values)
        ]
    )


def _anchors_of_root(anchors: Anchors, root: int):
    return anchors if anchors is None or isinstance(anchors, (str, Path)) else anchors[root]


def _renumbered(anchors: Optional[AnchorFit], frequency: int) -> Optional[AnchorFit]:
    """With the landmarks of an icosphere of another frequency, a multiple: it is nested
    (vcg_ext/mesh/icosphere.h), place s of row r at place k s of row k r."""
    if anchors is None or anchors.landmarks is None:
        return anchors

    def starts(f):
        row = np.arange(3 * f + 1)
        return np.cumsum([0, *np.maximum(1, 5 * np.minimum(f, np.minimum(row, 3 * f - row)))])

    k, former = frequency // SNAP_FREQUENCY, starts(SNAP_FREQUENCY)
    row = np.searchsorted(former, anchors.landmarks, side="right") - 1
    numbers = starts(frequency)[k * row] + k * (anchors.landmarks - former[row])
    return replace(anchors, landmarks=numbers)


def _optimised(
    surfaces: List[Surface],
    maps: List[SphereMap],
    order: str,
    figures: Figures,
    name: str,
    progress: Silent,
    unit: str,
    **anchors,
) -> List[SphereMap]:
    """The maps after optimise_groupwise, whose figures join or replace those of propagation."""
    if order in ("Time", "Cyclic time"):
        progress.note(
            f"groupwise is for shapes in no order: in the order {order} propagation has followed "
            "the motion, which knows more than what the phases have in common"
        )
    progress.begin(f"{name}: maps of {len(surfaces)} layers together")
    found = optimise_groupwise(surfaces, maps, **anchors)
    for key, values in found.figures.items():
        added = key in ("repaired_faces", "seconds")
        figures[key] = figures[key] + values if added else values
    progress.done(
        f"{name}: maps of {len(surfaces)} layers together, landmarks moved by "
        f"{found.figures['tangential_move'].mean():.2g} {unit} on average"
    )
    return found.maps


def checked(parameters: CorrespondenceParameters, count: int) -> CorrespondenceParameters:
    """The same for so many surfaces, with the root where parents say it.

    Raises InputError for what the filters would refuse, but late.
    """
    for name in ("method", "order", "initial_map"):
        value = in_full(name, getattr(parameters, name))
        require_choice(name, value, NAMED[name])
        parameters = replace(parameters, **{name: value})
    for name in ("groupwise", "exact", "anchor_snap", "anchor_pose", "uncertainty"):
        if not isinstance(getattr(parameters, name), (bool, np.bool_)):
            raise InputError(f"{name} must be True or False, not {getattr(parameters, name)!r}.")
    for name in ("area_weight", "area_restoration"):
        value = real_number(name, getattr(parameters, name), finite=False)
        if not 0 <= value <= 1:
            raise InputError(f"{name} must lie between 0 and 1, not at {value}.")
    places, folder = anchors_of(parameters.anchors, count)
    sd = real_number("anchor_sd", parameters.anchor_sd, finite=False)
    if not 0 <= sd < np.inf:
        raise InputError(f"anchor_sd must be 0 or more, not {sd}.")
    max_frequency = int(((MAX_LANDMARKS / count - 2) / 10) ** 0.5)
    frequency = whole_number("frequency", parameters.frequency)
    if not 1 <= frequency <= max_frequency:
        raise InputError(
            f"frequency must lie between 1 and {max_frequency} for {count} surfaces, not at "
            f"{frequency}."
        )
    root = parameters.root
    if isinstance(root, str):
        root = root.replace("-", " ").lower()
        if root != MOST_CENTRAL:
            raise InputError(f"root must be a number or {MOST_CENTRAL!r}, not {parameters.root!r}.")
    elif root is not None:
        root = whole_number("root", root)
    if isinstance(root, int) and not 0 <= root < count:
        raise InputError(
            f"Layer {root} cannot be the root: layers are numbered from 0 to {count - 1}."
        )
    if parameters.order == "Given":
        given = _root_of(parameters.parents, count)
        if root is not None and root != given:
            raise InputError(f"The root cannot be {root!r}: parents say that layer {given} is.")
        root = given
    if parameters.anchor_snap and frequency % SNAP_FREQUENCY:
        raise InputError(
            "anchor_snap makes anchors landmarks where frequency is a multiple of "
            f"{SNAP_FREQUENCY}, not {frequency}."
        )
    for name in ("exact", "anchor_snap", "anchor_pose"):
        if getattr(parameters, name) and not folder and not any(places or ()):
            raise InputError(f"{name} needs anchors: give them, or leave it out.")
    return replace(parameters, root=root, frequency=frequency)


def _root_of(parents: Parents, count: int) -> int:
    """The surface whose parent is -1. What the filter would say against the others it says here,
    where it has tetrahedra to work on."""
    numbers = parent_numbers(parents)
    root = numbers.index(-1) if -1 in numbers else 0
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    try:
        with attention.silenced():
            propagate(
                [Surface(corners, faces, f"surface {i}") for i in range(count)],
                corners / np.sqrt(3),
                root_layer=min(root, count - 1),
                method="As published",
                order="Given",
                parents=numbers,
                anisotropic_scaling=False,
                icp_iterations=0,
                smoothing_sweeps=0,
            )
    except FilterError as error:
        raise InputError(str(error)) from error
    return root
