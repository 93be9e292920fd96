# SPDX-License-Identifier: GPL-3.0-only
"""The plugin's filters as functions on arrays. Each works in a project of its own, so nothing is
shared between calls.

Keyword parameters have the names and defaults of the filters' own parameters; what they mean in
depth is in the filters' help and in docs/. Every map that comes back is certified valid.
"""

from __future__ import annotations

import contextlib
import csv
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from . import adapters, anchor_files, attention, layers, model_files, plugin
from .errors import FilterError, InputError, SpherePropagationWarning, some
from .model import ShapeModel
from .parameters import (
    DEFAULTS,
    NAMED,
    AnchorPositions,
    Anchors,
    Parents,
    in_full,
    listed,
    real_number,
    whole_number,
    whole_numbers,
)
from .sphere_map import MapLike, SphereMap, as_map
from .surface import (
    Surface,
    SurfaceLike,
    array_of,
    as_surface,
    as_surfaces,
    counted,
    distinct_names,
)

ROOT = "compute_spherical_parameterisation_root"
LOAD = "load_anchors_to_layers"
PROPAGATE = "transfer_spherical_parameterisation_to_layers"
GROUPWISE = "compute_spherical_parameterisation_groupwise"
REMESH = "generate_icosphere_remeshing"
MODEL = "compute_statistical_shape_model"
EVALUATE = "get_spherical_parameterisation_measures"
COLOR = "compute_color_from_spherical_parameterisation_per_vertex"
PHANTOM = "create_ventricle_phantom"
IMPORT = plugin.VOLUME_FILTER

PATTERNS = NAMED["pattern"]
ALIGNMENTS = NAMED["alignment"]
ALIGNMENTS_BY_ANCHORS = ("Anchors", "Scaled anchors")
PARTS = NAMED["part"]
COORDINATES = NAMED["coordinates"]
HANDLE_REPAIRS = NAMED["handle_repair"]
LID_RULES = NAMED["leave_out_lids"]

# Landmarks of all layers together, as in filter_sphere_propagation/remeshing_filter.cpp, which says
# no only after the maps were made. A test asks it.
MAX_LANDMARKS = 20_000_000
LISTED = 5  # names in a message

Figures = Dict[str, np.ndarray]  # name -> one entry per layer, in layer order, root included
# Of shape models that are measured between surfaces.
SURFACE_MEASURES = (
    *("surface_generalisation", "surface_generalisation_error"),
    *("surface_specificity", "surface_specificity_error"),
    *("off_surface", "folded_faces"),
)
MAP_FIGURES = ("flipped_faces", "area_ratio_sd", "area_log_mean", "angle_error_mean", "seconds")


@dataclass(frozen=True, eq=False)
class LabelSurfaces:
    """The surfaces of a label volume, one per phase, in order of time, and the figures of the
    filter.

    figures: phase (its number), label_volume (of the voxels, mm^3), volume (of the surface, mm^3),
    vertices, interpolated_slices, dropped_share (of the voxels, in smaller parts), filled_voxels,
    handles (that the label had), changed_voxels (to remove them), thin (1 where so much smoothing
    takes much of the label away), seconds.
    """

    surfaces: List[Surface]
    figures: Figures

    def __repr__(self) -> str:
        vertices = sum(len(surface.vertices) for surface in self.surfaces)
        return f"LabelSurfaces({counted(self.surfaces, 'surface')}, {vertices} vertices)"


@dataclass(frozen=True, eq=False)
class AnchorFit:
    """What became of anchors: by surface and, in the order of `names`, by anchor; NaN where a
    surface lacks it.

    names: of the root's anchors. distance: how far the surface's anchor lies from the place of the
    root's, in their unit; distance_before: the same for the place that the surface's parent brings
    along, nothing fitted yet (Robust). z: how many standard deviations per coordinate it lies from
    where the others say that it is (Robust). widening: by surface, by how much more variance than
    the prior's they ask for. landmarks: with anchor_snap, which landmark each is: of propagate, of
    those of frequency 10; of correspond, of its own.
    """

    names: List[str]
    distance: np.ndarray
    distance_before: np.ndarray
    z: np.ndarray
    widening: np.ndarray
    landmarks: Optional[np.ndarray] = None
    places: Optional[np.ndarray] = None  # (surfaces, anchors, 3), where they lie

    @property
    def counts(self) -> np.ndarray:
        """By anchor, how many surfaces have it."""
        return np.isfinite(self.distance).sum(0)

    def of_surfaces(self) -> List[Dict[str, np.ndarray]]:
        """Per surface its anchors, name -> (x, y, z); reflected where the surface was."""
        return [
            {name: p for name, p in zip(self.names, row) if np.isfinite(p).all()}
            for row in ([] if self.places is None else self.places)
        ]

    def __repr__(self) -> str:
        return f"AnchorFit({', '.join(self.names)}; {np.nanmean(self.distance):.3g} off on average)"


@dataclass(frozen=True, eq=False)
class Propagation:
    """Maps of all surfaces, in their order, and the figures of the filter.

    figures: parent (the surface that the map came from, -1 for the root), residual_mean and
    residual_p95 (distance of the surface's vertices from what was brought onto it, in their unit),
    repaired_faces, route (0 by the method asked for; where Robust lost a surface 1 by alignment
    with its parent, 2 as published), flipped_faces, area_ratio_sd, area_log_mean, angle_error_mean
    (degrees), seconds, mirrored (1 for a surface that was reflected, with mirror_layers), distant
    (1 for a surface that lies far off what was brought onto it).
    residuals: where asked for, of each surface the distance of every vertex from what was brought
    onto it.
    uncertainties: where asked for, of each surface how well landmarks are known along it at every
    vertex: the standard deviation of each of the two coordinates along the surface, so that 95 %
    lie within 2.45 times that. NaN where the fit lost the surface, 0 on the root.
    root_error: where asked for and known, what the root's surface lacks outwards at every vertex;
    root_error_sd: its size, where all surfaces were fitted at once.
    branch_distance (in the surfaces' unit), branch_angle (degrees): in Cyclic time, how far the
    maps of the two branches are apart where they meet.
    surfaces: what the maps are of: those given, but for the ones that were reflected.
    anchors: where there were some.
    """

    maps: List[SphereMap]
    figures: Figures
    residuals: Optional[List[np.ndarray]] = None
    branch_distance: Optional[float] = None
    branch_angle: Optional[float] = None
    surfaces: Optional[List[Surface]] = None
    anchors: Optional[AnchorFit] = None
    uncertainties: Optional[List[np.ndarray]] = None
    root_error: Optional[np.ndarray] = None
    root_error_sd: Optional[float] = None

    def __repr__(self) -> str:
        return (
            f"Propagation({counted(self.maps, 'map')}, "
            f"{np.sum(self.figures['flipped_faces']):.0f} flipped faces, residual "
            f"{np.mean(self.figures['residual_mean']):.3g} on average)"
        )


@dataclass(frozen=True, eq=False)
class Optimisation:
    """Maps of a population that were optimised together, and the figures of the filter.

    figures: tangential_move (how far landmarks moved along the surface, on average, in its unit),
    model_residual (root mean square of the distance along the normal between landmarks and where
    the population's model expects them), repaired_faces, trust (how much the surface counted in
    what was learnt, 1 or less where its shape does not belong to the others), flipped_faces,
    area_ratio_sd, area_log_mean, angle_error_mean (degrees), seconds; with anchors
    anchor_distance_mean (how far a surface's anchors lie from the places that all agree on, NaN
    where it has none).
    move_by_iteration: how far landmarks still were from where they were expected.
    total_variance: of the aligned landmarks, before and after.
    surface_precision: the one that was used.
    """

    maps: List[SphereMap]
    figures: Figures
    move_by_iteration: np.ndarray
    total_variance: np.ndarray
    surface_precision: float

    def __repr__(self) -> str:
        return (
            f"Optimisation({counted(self.maps, 'map')}, "
            f"{np.sum(self.figures['flipped_faces']):.0f} flipped faces, moved by "
            f"{np.mean(self.figures['tangential_move']):.3g} on average)"
        )


@dataclass(frozen=True, eq=False)
class Landmarks:
    """The same points on every surface: points[t, j] is landmark j on surface t, the same place for
    all t.

    points: (surfaces, 10 f^2 + 2, 3); faces: (20 f^2, 3), shared by all; figures:
    surface_distance_mean and surface_distance_max (between landmark mesh and surface, both ways, in
    their unit), lid (how many landmarks lie on lids), seconds.
    lid: (surfaces, 10 f^2 + 2), True where a landmark lies on a lid of that surface and so is made
    up.
    """

    points: np.ndarray
    faces: np.ndarray
    figures: Figures
    lid: Optional[np.ndarray] = None

    def __repr__(self) -> str:
        shapes, landmarks = self.points.shape[:2]
        return f"Landmarks({shapes} x {landmarks} points, {len(self.faces)} faces)"


def read_label_volume(
    file,
    *,
    labels: Union[str, int, Sequence[int]] = "1",
    voxel_size: float = 0.0,
    smoothing: float = 1.0,
    coordinates: str = "RAS",
    fill_holes: bool = True,
    keep_largest_component: bool = True,
    cut_handles: bool = True,
    handle_repair: str = "Whichever changes less",
    align_slices: bool = False,
    file_series: bool = False,
    skip_incomplete_phases: bool = False,
    longest_gap: int = 10,
) -> LabelSurfaces:
    """A segmentation (NIfTI, NRRD, MetaImage; 3D, or 4D with time) as one closed surface of genus 0
    per phase, in millimetres.

    file: its path; or an image of nibabel, SimpleITK, ITK, ANTs, torchio or MONAI, or (labels,
    affine): an array (x, y, z) or (x, y, z, time) and the way (4, 4) from its indices to RAS in mm.
    Or a folder of files or a list of these, which are looked at together, as the phases of one are.
    labels: what is inside, 1 or "1"; several, as [1, 2] or "1,2", are united. Every phase must have
    each of them, or skip_incomplete_phases leaves it out.
    voxel_size: edge of the cubes that are worked on, mm; larger ones make fewer vertices; 0: the
    file's smallest spacing.
    smoothing: standard deviation in these cubes, 0 to 5. coordinates: one of COORDINATES.
    fill_holes, keep_largest_component, cut_handles: cavities are filled, smaller parts dropped,
    handles removed, in all phases alike and at the same places; handle_repair, one of
    HANDLE_REPAIRS: how. align_slices: slices are moved in their plane where they do not follow from
    those beside them, as after another breath. longest_gap: how many empty slices in a row are
    interpolated.
    file_series: also read the files beside this one whose names differ from it in one number only,
    one phase each.

    Warns (SpherePropagationWarning) where the surfaces differ much from the labels. Raises
    PluginError where ITK is missing.
    """
    plugin.require_volumes()
    meshes = layers.mesh_set()
    text = (
        labels if isinstance(labels, str) else ",".join(map(str, whole_numbers("labels", labels)))
    )
    if file_series is True and not (adapters.is_path(file) and not Path(file).is_dir()):
        raise InputError("file_series reads the files beside one: it takes a file.")
    figures = _import(
        meshes,
        file,
        labels=text,
        voxel_size=voxel_size,
        smoothing=smoothing,
        coordinates=coordinates,
        fill_holes=fill_holes,
        keep_largest_component=keep_largest_component,
        cut_handles=cut_handles,
        handle_repair=handle_repair,
        align_slices=align_slices,
        file_series=file_series,
        skip_incomplete_phases=skip_incomplete_phases,
        longest_gap=longest_gap,
    )
    del figures["layers"]
    surfaces = [
        replace(layers.surface_of(mesh), space=in_full("coordinates", coordinates))
        for mesh in meshes
    ]
    return LabelSurfaces(surfaces, figures)


def _import(meshes, file, **parameters) -> Figures:
    with adapters.volume_file(file) as (path, called):
        try:
            return layers.apply(meshes, IMPORT, file_name=path, **parameters)
        except FilterError as error:
            text = str(error)
            for written, name in called.items():
                text = text.replace(written, name)
            raise FilterError(IMPORT, text) from error.__cause__


def parameterise_root(
    surface: SurfaceLike,
    *,
    initial_map: str = DEFAULTS.initial_map,
    area_weight: float = DEFAULTS.area_weight,
    anchors: Union[None, str, Path, Mapping[str, Sequence[float]]] = None,
    anchor_positions: AnchorPositions = DEFAULTS.anchor_positions,
    threads: int = 0,
) -> SphereMap:
    """An area-preserving map of one surface to the unit sphere.

    initial_map: where the minimisation starts, one of INITIAL_MAPS. area_weight: 0 to 1; 1 asks for
    equal areas alone, as far as validity allows, 0 for angles alone; the default all but preserves
    areas.
    anchors: points of the surface by name, or a folder with a file of them, called as the surface.
    anchor_positions: where on the sphere they are to lie: a dictionary of directions (x, y, z) or
    (longitude, latitude) in degrees, or a file (docs/anchors.md). threads: how many work on large
    surfaces, 0 for as many as the machine runs at once; the map is the same with any number.

    Raises FilterError when the surface is not closed, has handles or several parts, and when its
    anchors cannot lie there.
    """
    return _root_map(
        [as_surface(surface)],
        anchors if isinstance(anchors, (str, Path)) else [anchors],
        anchor_positions,
        initial_map=initial_map,
        area_weight=area_weight,
        threads=threads,
    )[1]


def parameterise_most_central(
    surfaces: Sequence[SurfaceLike],
    *,
    initial_map: str = DEFAULTS.initial_map,
    area_weight: float = DEFAULTS.area_weight,
    anchors: Anchors = None,
    anchor_positions: AnchorPositions = DEFAULTS.anchor_positions,
    threads: int = 0,
) -> Tuple[int, SphereMap]:
    """Which surface is the most like all others (the medoid of their distances after rigid
    alignment), and its map: a root for shapes in no order.

    anchors: per surface, as of propagate. The others as of parameterise_root.
    """
    return _root_map(
        as_surfaces(surfaces),
        anchors,
        anchor_positions,
        most_central=True,
        initial_map=initial_map,
        area_weight=area_weight,
        threads=threads,
    )


def _root_map(
    surfaces: Sequence[Surface], anchors: Anchors, anchor_positions: AnchorPositions, **parameters
) -> Tuple[int, SphereMap]:
    """Of the first surface, or of the most central one."""
    places, folder = anchors_of(anchors, len(surfaces))
    meshes = layers.mesh_set(surfaces, anchors=places)
    if folder and anchor_positions is not None:
        names = distinct_names(surfaces)
        anchor_files.require_points(anchor_files.file_in(folder, name) for name in names)
        layers.apply(meshes, LOAD, file_name=folder)
    with positions_file(anchor_positions) as positions:
        figures = layers.apply(meshes, ROOT, anchor_positions=positions, **parameters)
    figures.pop("anchor_moved", None)
    root = figures.pop("root_layer")
    return root, layers.map_of(meshes.mesh(root), figures)


@contextlib.contextmanager
def positions_file(positions: AnchorPositions):
    """The file that the filter reads; empty where there are none."""
    if positions is None or isinstance(positions, (str, Path)):
        yield "" if positions is None else str(positions)
        return
    if not isinstance(positions, Mapping):
        raise InputError(
            "anchor_positions must be a file or a dictionary, name -> (x, y, z) or (longitude, "
            f"latitude), not {type(positions).__name__}."
        )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "positions.csv"
        with open(path, "w", newline="", encoding="utf-8") as file:
            rows = csv.writer(file)
            rows.writerow(["name", "x", "y", "z"])
            for name, place in positions.items():
                rows.writerow([name, *map(repr, direction_of(str(name), place))])
        yield str(path)


def direction_of(name: str, place) -> List[float]:
    """A direction from x, y, z or from longitude and latitude in degrees."""
    try:
        numbers = np.asarray(place, float)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.shape not in ((2,), (3,)) or not np.isfinite(numbers).all() or not name:
        raise InputError(
            f"The position of anchor {name!r} must be a direction (x, y, z), or longitude and "
            f"latitude in degrees, not {place!r}."
        )
    if len(numbers) == 3:
        if not numbers.any():
            raise InputError(f"The position of anchor {name!r} has no direction.")
        return numbers.tolist()
    if abs(numbers[1]) > 90:
        raise InputError(f"The latitude of anchor {name!r} must lie between -90 and 90 degrees.")
    east, north = np.radians(numbers)
    return [
        float(np.cos(north) * np.cos(east)),
        float(np.cos(north) * np.sin(east)),
        float(np.sin(north)),
    ]


def _maps_with_figures(meshes, figures, count: int) -> List[SphereMap]:
    """Of the first meshes, each with its row of a filter's figures."""
    return [
        layers.map_of(meshes.mesh(i), layers.row(figures, i, MAP_FIGURES)) for i in range(count)
    ]


def propagate(
    surfaces: Sequence[SurfaceLike],
    root_map: MapLike,
    *,
    root_layer: int = 0,
    method: str = DEFAULTS.method,
    order: str = DEFAULTS.order,
    parents: Parents = DEFAULTS.parents,
    area_restoration: float = DEFAULTS.area_restoration,
    residual_quality: bool = False,
    uncertainty_quality: bool = False,
    root_error_quality: bool = False,
    mirror_layers: bool = DEFAULTS.mirror_layers,
    anchors: Anchors = DEFAULTS.anchors,
    anchor_sd: float = DEFAULTS.anchor_sd,
    exact: bool = DEFAULTS.exact,
    anchor_snap: bool = DEFAULTS.anchor_snap,
    anchor_pose: bool = DEFAULTS.anchor_pose,
    anisotropic_scaling: bool = True,
    icp_iterations: int = 30,
    smoothing_sweeps: int = 50,
    threads: int = 0,
) -> Propagation:
    """The root's map handed on to all other surfaces, along a tree, so that a point of the sphere
    means one place on all of them.

    surfaces: in order of time, in one unit. root_map: the map of surfaces[root_layer].
    method: Robust (a motion model moves the root onto each surface) or As published (the paper's
    steps).
    order: who hands the map to whom, one of ORDERS; Cyclic time for a whole heart cycle, Similarity
    tree where there is no order.
    parents: for the order Given, one number per surface: where its map comes from, -1 for the root.
    area_restoration: 0 to 1, how far each map is moved towards area preservation in the end.
    residual_quality, uncertainty_quality (one of the two), root_error_quality: whether `residuals`,
    `uncertainties`, `root_error` are returned.
    mirror_layers: reflect a surface that is a mirror image of the others, a left bone among right
    ones, before its map is made: the maps are then those of `surfaces` in what is returned.
    anchors: points that must correspond, per surface a dictionary (name -> x, y, z) or None; or a
    folder of files, called as the surfaces are (docs/anchors.md). Names join them; a surface may
    lack some.
    anchor_sd: how far each may be off in each coordinate, as a standard deviation; 0: the surface's
    mean edge length. exact: whether every map has them in exactly the root's places. anchor_snap:
    whether the root's map is first moved until its anchors are landmarks of frequency 10.
    anchor_pose: whether surfaces are laid for the fit where their anchors come closest to the
    root's, three or more, whatever their shapes say.
    anisotropic_scaling, icp_iterations, smoothing_sweeps: of the paper's steps; As published only.
    threads: how many work, 0 for as many as the machine runs at once; the result is the same with
    any number.

    Warns (SpherePropagationWarning) of surfaces that deserve a look: that lie far off what was
    brought onto them, in another pose, mirrored, of another size, or that the fit lost.
    """
    surfaces = as_surfaces(surfaces)
    root_map = as_map(root_map)
    root_layer = whole_number("root_layer", root_layer)
    if not 0 <= root_layer < len(surfaces):
        raise InputError(
            f"Layer {root_layer} cannot be the root: layers are numbered from 0 to "
            f"{len(surfaces) - 1}."
        )
    if not isinstance(parents, str):
        parents = ", ".join(map(str, whole_numbers("parents", parents)))
    places, folder = anchors_of(anchors, len(surfaces))
    if folder:
        names = distinct_names(surfaces)
        anchor_files.require_points(anchor_files.file_in(folder, name) for name in names)
    meshes = layers.mesh_set(surfaces, {root_layer: root_map}, places)
    with attention.collected() as said:
        figures = layers.apply(
            meshes,
            PROPAGATE,
            anchors="Off" if places is None and not folder else "Exact" if exact else "Soft",
            anchor_files=folder,
            anchor_sd=real_number("anchor_sd", anchor_sd),
            anchor_snap=anchor_snap,
            anchor_pose=anchor_pose,
            root_layer=root_layer,
            method=method,
            order=order,
            parents=parents,
            area_restoration=area_restoration,
            residual_quality=residual_quality,
            uncertainty_quality=uncertainty_quality,
            root_error_quality=root_error_quality,
            mirror_layers=mirror_layers,
            anisotropic_scaling=anisotropic_scaling,
            icp_iterations=icp_iterations,
            smoothing_sweeps=smoothing_sweeps,
            threads=threads,
        )
    if len(figures["parent"]) != len(surfaces):
        others = layers.without_map(meshes)
        raise FilterError(
            PROPAGATE,
            f"Not taken for surfaces: {some(others, LISTED)}. A mesh is none that is "
            "an icosphere's landmark mesh, lies on the unit sphere, or is called like a layer of a "
            "shape model: leave out what an earlier run has made.",
        )
    maps = _maps_with_figures(meshes, figures, len(surfaces))
    qualities = [mesh.vertex_scalar_array() for mesh in meshes]
    root_error = None
    if root_error_quality and "root_error_sd" in figures:
        root_error = qualities[root_layer]
        qualities[root_layer] = np.zeros(len(root_error))
    uncertainties = None
    if uncertainty_quality:
        unknown = np.isnan(figures["uncertainty_mean"])
        uncertainties = [
            np.full(len(surface.vertices), np.nan) if nobody_knows else quality
            for surface, quality, nobody_knows in zip(surfaces, qualities, unknown)
        ]
    fit = None
    if "anchor_distance" in figures:
        by_anchor = {
            name: figures.pop(f"anchor_{name}").reshape(len(surfaces), -1)
            for name in ("distance", "distance_before", "z")
        }
        widening = figures.pop("prior_widening")
        names = bytes(map(int, figures.pop("anchor_names"))).decode().split("\n")
        places = figures.pop("anchor_places").reshape(len(surfaces), len(names), 3)
        landmarks = figures.pop("anchor_landmark", None)
        if landmarks is not None:
            landmarks = landmarks.astype(int)
        fit = AnchorFit(names, **by_anchor, widening=widening, landmarks=landmarks, places=places)
        _warn_of_lonely(fit, surfaces[root_layer].name)
        if any(warning.message == "anchorsNotOnRoot" for warning in said):
            _warn_of_foreign(fit, surfaces, root_layer, anchors)
    branches = figures.pop("branch_distance", None), figures.pop("branch_angle", None)
    as_mapped = [
        replace(layers.surface_of(meshes.mesh(i), surface.name), space=surface.space)
        if figures["mirrored"][i]
        else surface
        for i, surface in enumerate(surfaces)
    ]
    return Propagation(
        maps,
        figures,
        qualities if residual_quality else None,
        *branches,
        surfaces=as_mapped,
        anchors=fit,
        uncertainties=uncertainties,
        root_error=root_error,
        root_error_sd=figures.pop("root_error_sd", None),
    )


def _warn_of_lonely(fit: AnchorFit, root: str) -> None:
    """Of the root's anchors those that no other surface has."""
    lonely = [name for name, n in zip(fit.names, fit.counts) if n < 2]
    if lonely:
        attention.warn(
            SpherePropagationWarning(
                f"{root}: no other surface has its anchors {anchor_files.listed(lonely)}, so "
                "nothing is made to correspond by them.",
                root,
                "anchorsOnRootAlone",
            )
        )


def _warn_of_foreign(
    fit: AnchorFit, surfaces: Sequence[Surface], root: int, anchors: Anchors
) -> None:
    """Which surfaces have anchors that the root lacks, and which of the root's they lack."""
    places, folder = anchors_of(anchors, len(surfaces))
    if folder:
        with attention.silenced():
            counts = layers.apply(layers.mesh_set(surfaces), LOAD, file_name=folder)["anchors"]
    else:
        counts = np.array([len(its) for its in places or ()])
    has = np.isfinite(fit.distance)
    if len(counts) != len(surfaces):
        return
    without: Dict[str, List[str]] = {}
    for i in np.flatnonzero(counts > has.sum(1)):
        missing = [name for name, there in zip(fit.names, has[i]) if not there]
        without.setdefault(anchor_files.listed(missing), []).append(surfaces[i].name)
    for missing, whose in without.items():
        attention.warn(
            SpherePropagationWarning(
                f"{anchor_files.listed(whose)}: there are anchors that the root "
                f"{surfaces[root].name} lacks; of the root's are missing: {missing or 'none'}. Is "
                "a name misspelt?",
                layers=whose,
                message="anchorsOfOtherNames",
                subject=anchor_files.listed(whose),
            )
        )


def anchors_of(anchors: Anchors, count: int):
    """Per surface its anchors, None where there are none at all; and the folder of files, if it is
    one that was given."""
    if anchors is None:
        return None, ""
    if isinstance(anchors, (str, Path)):
        if not Path(anchors).is_dir():
            raise InputError(f"anchors: {anchors} is no folder.")
        anchor_files.require_readable(anchors)
        return None, str(anchors)
    given = listed("anchors", anchors)
    if len(given) != count:
        raise InputError(
            f"anchors must be one dictionary or None per surface: {len(given)} for {count} "
            "surfaces."
        )
    return [_places(i, one) for i, one in enumerate(given)], ""


def _places(number: int, anchors) -> Dict[str, np.ndarray]:
    if anchors is None:
        return {}
    if not isinstance(anchors, Mapping):
        raise InputError(
            f"The anchors of surface {number} must be a dictionary, name -> (x, y, z), not "
            f"{type(anchors).__name__}."
        )
    places = {}
    for name, place in anchors.items():
        try:
            point = np.asarray(place, float)
        except (TypeError, ValueError):
            point = np.zeros(0)
        if point.shape != (3,) or not np.isfinite(point).all() or not str(name):
            raise InputError(
                f"The place of anchor {str(name)!r} of surface {number} must be three numbers, not "
                f"{place!r}."
            )
        places[str(name)] = point
    return places


def optimise_groupwise(
    surfaces: Sequence[SurfaceLike],
    maps: Sequence[MapLike],
    *,
    alignment: str = "Rigid",
    iterations: int = 8,
    surface_precision: float = 0.0,
    objective: str = "Population model",
    prior_shapes: float = 2.0,
    frequency: int = 7,
    anchors: Anchors = None,
    anchor_sd: float = 0.0,
    threads: int = 0,
) -> Optimisation:
    """The maps of shapes in no order, moved until one shape model explains all of them together.

    surfaces, maps: two or more, with maps that correspond roughly, as propagate gives them.
    alignment: what is taken out of the shapes before they are compared: Rigid, Similarity or None.
    iterations: how often the model is learnt and the maps moved.
    surface_precision: how much the surfaces count against the prior; 0: the recommended one.
    objective: Population model, or Description length for comparison.
    prior_shapes: for how many shapes the prior counts. frequency: of the icosphere of landmarks by
    which shapes are compared.
    anchors: points that correspond, per surface a dictionary (name -> x, y, z) or None, or a folder
    of files, called as the surfaces are (docs/anchors.md); anchor_sd: how far each may be off in
    each coordinate, as a standard deviation, 0 for the surface's mean edge length.
    threads: how many work, 0 for as many as the machine runs at once; the maps are the same with
    any number.
    """
    surfaces = as_surfaces(surfaces)
    places, folder = anchors_of(anchors, len(surfaces))
    meshes = layers.mesh_set(surfaces, _maps_of(surfaces, maps), places)
    if folder:
        layers.apply(meshes, LOAD, file_name=folder)
    figures = layers.apply(
        meshes,
        GROUPWISE,
        anchors="Off" if places is None and not folder else "Soft",
        anchor_sd=real_number("anchor_sd", anchor_sd),
        alignment=alignment,
        iterations=iterations,
        surface_precision=surface_precision,
        objective=objective,
        prior_shapes=prior_shapes,
        frequency=frequency,
        threads=threads,
    )
    if len(figures["tangential_move"]) != len(surfaces):
        raise FilterError(
            GROUPWISE,
            f"Of {len(surfaces)} meshes only {len(figures['tangential_move'])} were taken for "
            "surfaces.",
        )
    run = [figures.pop(key) for key in ("move_by_iteration", "total_variance", "surface_precision")]
    moved = _maps_with_figures(meshes, figures, len(surfaces))
    return Optimisation(moved, figures, *run)


def remesh(
    surfaces: Sequence[SurfaceLike],
    maps: Sequence[MapLike],
    *,
    frequency: int = DEFAULTS.frequency,
    threads: int = 0,
) -> Landmarks:
    """All surfaces sampled at the same 10 f^2 + 2 points of the sphere. maps: one per surface, as
    propagate gives them.

    frequency: parts into which each edge of the icosahedron is split; 10 gives 1002 landmarks.
    threads: how many work, 0 for as many as the machine runs at once; the landmarks are the same
    with any number.
    """
    surfaces = as_surfaces(surfaces)
    meshes = layers.mesh_set(surfaces, _maps_of(surfaces, maps))
    figures = layers.apply(
        meshes, REMESH, frequency=frequency, color_landmarks=False, threads=threads
    )
    made = [meshes.mesh(i) for i in range(len(surfaces), meshes.mesh_number())]
    if len(made) != len(surfaces):
        raise FilterError(
            REMESH,
            f"{len(surfaces)} surfaces gave {len(made)} landmark meshes: not every one was taken "
            "for a surface.",
        )
    points = np.stack([mesh.vertex_matrix() for mesh in made])
    lid = np.zeros(points.shape[:2], bool)
    for i, mesh in enumerate(made):
        numbers = layers.lid_of(mesh)
        if numbers is not None:
            lid[i] = numbers > 0
    return Landmarks(points, made[0].face_matrix(), figures, lid)


def landmark_places(surface: SurfaceLike, map: MapLike, count: int) -> np.ndarray:
    """Where the landmarks lie on the sphere, (count, 3) unit vectors: the icosphere's vertices, as
    closely as the surface's triangles allow. surface, map: any that they were sampled from."""
    surface, map = as_surface(surface), as_map(map)
    # The map's own sphere as a surface, which must not be taken for a layer of spheres.
    sphere = Surface(10 * map.positions, surface.faces, "sphere")
    points = remesh([sphere], [map], frequency=round(((count - 2) / 10) ** 0.5)).points[0]
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def shape_model(
    points: np.ndarray,
    faces: np.ndarray,
    names: Optional[Sequence[str]] = None,
    *,
    lid: Optional[np.ndarray] = None,
    leave_out_lids: str = "Most shapes",
    alignment: str = "Similarity",
    modes: int = 0,
    export_file: str = "",
    area_weights: bool = False,
    specificity_samples: int = 1000,
    seed: int = 0,
    landmark_names: Optional[Mapping[str, int]] = None,
    anchors: Union[None, AnchorFit, Sequence[Optional[Mapping[str, Sequence[float]]]]] = None,
    surfaces: Optional[Sequence[SurfaceLike]] = None,
) -> ShapeModel:
    """Mean, modes and scores of landmarks that correspond, and how good a model they make:
    `shape_model(*remesh(...)[:2])`.

    points: (shapes, landmarks, 3), two shapes or more; faces: those of Landmarks or Correspondence,
    shared by all; names: what errors and files call the shapes.
    lid: that of Landmarks or Correspondence: (landmarks,) or (shapes, landmarks), True where they
    are made up. leave_out_lids: which of these the model leaves out, one of LID_RULES; its `lid`
    says which it did.
    alignment: what is taken out of the shapes first, one of ALIGNMENTS: pose and size, pose,
    nothing; Anchors: pose, and Scaled anchors: both, as `anchors` alone tell them. modes: how
    many are kept, 0 for all.
    export_file: where the model is written to as well; the ending chooses the format: .npz (NumPy),
    .h5 and .json (statismo, scalismo), .particles (ShapeWorks), .ply, .csv (the scores).
    area_weights: whether landmarks weigh in the alignment as the area around them.
    specificity_samples, seed: of the random shapes that the specificity is measured with.
    landmark_names: {name: landmark} of those that have one, so that anchors of these names are
    fitted to the model (`fit`); in .npz files, too.
    anchors: for the alignment by them: those of Correspondence or Propagation, or one dictionary
    (name -> x, y, z) or None per shape. Each shape needs three that others have, too.
    surfaces: those that the landmarks lie on, one per shape, for measures between surfaces
    (surface_measures of the filter), which the result then has as surface_figures.

    Identical shapes make a model without modes.
    """
    shapes = _landmark_meshes(points, faces, names, lid)
    named = model_files.checked_names(landmark_names, len(shapes[0].vertices))
    if isinstance(anchors, AnchorFit):
        anchors = anchors.of_surfaces()
    if isinstance(anchors, (str, Path)):
        raise InputError(
            "anchors of a shape model must be those of a result, or dictionaries, not a path."
        )
    rule = in_full("alignment", alignment)
    by_anchors = isinstance(rule, str) and rule in ALIGNMENTS_BY_ANCHORS
    if by_anchors and anchors is None:
        raise InputError(f"alignment: {alignment!r} needs anchors.")
    places = anchors_of(anchors, len(shapes))[0] if by_anchors else None
    sampled = [] if surfaces is None else as_surfaces(surfaces)
    if surfaces is not None and len(sampled) != len(shapes):
        raise InputError(
            f"surfaces must be one per shape: {len(sampled)} for {len(shapes)} shapes."
        )
    meshes = layers.mesh_set(shapes, anchors=places)
    returned = layers.apply(
        meshes,
        MODEL,
        alignment=alignment,
        leave_out_lids=leave_out_lids,
        modes=modes,
        mode_layers=0,
        export_file=str(export_file),
        area_weights=area_weights,
        specificity_samples=specificity_samples,
        seed=seed,
    )
    if returned["shapes"] != len(shapes):
        raise FilterError(
            MODEL,
            f"Of {len(shapes)} shapes only {returned['shapes']} were taken for landmarks: the "
            "others lie on the unit sphere, or are called like a layer of a shape model.",
        )
    kept, count = returned["modes"], returned["landmarks"]
    left_out = returned["lid"] > 0
    number = np.cumsum(~left_out) - 1
    named = {name: int(number[j]) for name, j in named.items() if not left_out[j]}
    if named and Path(export_file).suffix.lower() == ".npz":
        model_files.name_landmarks(export_file, named)
    return ShapeModel(
        np.reshape(returned["mean"], (count, 3)),
        np.reshape(returned["mode_vectors"], (kept, count, 3)),
        returned["eigenvalues"],
        np.reshape(returned["scores"], (len(shapes), kept)),
        number[shapes[0].faces[~left_out[shapes[0].faces].any(1)]].astype(np.int32),
        [shape.name for shape in shapes],
        returned["total_variance"],
        {
            name: returned[name]
            for name in (
                "compactness",
                "variance_share",
                "generalisation",
                "generalisation_error",
                "specificity",
                "specificity_error",
            )
        },
        left_out,
        landmark_names=named,
        surface_figures=_between_surfaces(
            shapes,
            sampled,
            places,
            alignment=alignment,
            leave_out_lids=leave_out_lids,
            modes=modes,
            area_weights=area_weights,
            seed=seed,
        ),
    )


def _between_surfaces(
    shapes: List[Surface], surfaces: List[Surface], places, **parameters
) -> Dict[str, np.ndarray]:
    """The measures of the same model once more, by names that tell whose landmarks shapes are; what
    deserves to be known of it was said."""
    if not surfaces:
        return {}
    names = distinct_names(surfaces)
    sampled = [replace(surface, name=name) for surface, name in zip(surfaces, names)]
    shapes = [replace(shape, name=f"{name} landmarks") for shape, name in zip(shapes, names)]
    if places is not None:
        places = [*places, *([{}] * len(sampled))]
    with attention.silenced():
        returned = layers.apply(
            layers.mesh_set(shapes + sampled, anchors=places),
            MODEL,
            mode_layers=0,
            specificity_samples=1,
            surface_measures=True,
            **parameters,
        )
    return {name: returned[name] for name in SURFACE_MEASURES}


def _landmark_meshes(
    points: np.ndarray,
    faces: np.ndarray,
    names: Optional[Sequence[str]],
    lid: Optional[np.ndarray],
) -> List[Surface]:
    points, faces = array_of("Landmarks", points), array_of("faces", faces)
    if points.ndim != 3 or points.shape[2] != 3 or points.dtype.kind not in "fiu":
        raise InputError(
            f"Landmarks must be numbers of shape (shapes, landmarks, 3), not {points.dtype} of "
            f"shape {points.shape}."
        )
    frequency = max(1, round(max(0, points.shape[1] - 2) / 10) ** 0.5)
    if points.shape[1] != 10 * round(frequency) ** 2 + 2 or np.shape(faces) != (
        2 * points.shape[1] - 4,
        3,
    ):
        raise InputError(
            f"{points.shape[1]} landmarks with faces of shape {np.shape(faces)} are not those "
            "that remesh gives: 10 f^2 + 2 landmarks and (20 f^2, 3) faces."
        )
    names = [f"shape {k}" for k in range(len(points))] if names is None else listed("names", names)
    if len(names) != len(points):
        raise InputError(f"{len(points)} shapes need as many names, not {len(names)}.")
    if lid is not None:
        lid = array_of("lid", lid)
        if lid.shape not in (points.shape[:2], points.shape[1:2]) or lid.dtype.kind not in "biuf":
            raise InputError(
                f"lid must be of shape {points.shape[:2]} or {points.shape[1:2]}, not {lid.dtype} "
                f"of shape {lid.shape}."
            )
        lid = np.broadcast_to(lid > 0, points.shape[:2])
    return [
        Surface(shape, faces, name, lid=None if lid is None else lid[k])
        for k, (shape, name) in enumerate(zip(points, names))
    ]


def evaluate(surfaces: Sequence[SurfaceLike], maps: Sequence[MapLike]) -> Figures:
    """Certifies and measures maps, one per surface. A map that is not valid is reported, not
    refused.

    Returned: valid (1 or 0), degree (how often the sphere is covered; 1 in a valid map),
    flipped_faces, area_ratio_sd, area_log_mean, angle_error_mean (degrees), seconds.
    """
    surfaces = as_surfaces(surfaces)
    figures = layers.apply(layers.mesh_set(surfaces, _maps_of(surfaces, maps)), EVALUATE)
    if len(figures["valid"]) != len(surfaces):
        raise FilterError(
            EVALUATE,
            f"Of {len(surfaces)} meshes only {len(figures['valid'])} were taken for surfaces.",
        )
    return figures


def map_colors(
    surfaces: Sequence[SurfaceLike],
    maps: Sequence[MapLike],
    *,
    pattern: str = "Checkerboard",
    cells: int = 8,
    area_ratio_limit: float = 2.0,
) -> List[np.ndarray]:
    """A pattern of the sphere on the vertices of each surface, (n, 3) in [0, 1]: the same place has
    the same colour on all of them.

    pattern: one of PATTERNS. cells: fields from pole to pole, 2 or more. area_ratio_limit: above 1,
    where the colours of the pattern Area ratio end: with 2 at twice (red) and half (blue) of the
    area's due share.
    """
    surfaces = as_surfaces(surfaces)
    meshes = layers.mesh_set(surfaces, _maps_of(surfaces, maps))
    layers.apply(meshes, COLOR, pattern=pattern, cells=cells, area_ratio_limit=area_ratio_limit)
    return [mesh.vertex_color_matrix()[:, :3] for mesh in meshes]


def make_phantom(
    *,
    part: str = "Cavity",
    phases: int = 25,
    voxel_size: float = 2.0,
    twist: float = 0.0,
    seed: int = 0,
) -> List[Surface]:
    """A beating left ventricle, one surface per phase of one heart cycle, without correspondence;
    phase 0 is end-diastole.

    part: Cavity or Wall. voxel_size: mm, 0.25 to 4; 2 gives about 4000 vertices. twist: degrees, of
    the apex at end-systole.
    seed: each number makes another ventricle. `Ventricle` with the same part, phases, seed and
    twist knows the truth.
    """
    meshes = layers.mesh_set()
    layers.apply(
        meshes, PHANTOM, part=part, phases=phases, voxel_size=voxel_size, twist=twist, seed=seed
    )
    return [layers.surface_of(mesh) for mesh in meshes]


def _maps_of(surfaces: Sequence[Surface], maps: Sequence[MapLike]) -> Dict[int, SphereMap]:
    maps = listed("maps", maps)
    if len(surfaces) != len(maps):
        raise InputError(f"{len(surfaces)} surfaces need as many maps, not {len(maps)}.")
    return {i: as_map(positions) for i, positions in enumerate(maps)}
