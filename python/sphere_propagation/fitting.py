# SPDX-License-Identifier: GPL-3.0-only
"""A shape model fitted to a surface that it was not built from: the filter "Fit shape model" on
arrays."""

from __future__ import annotations

import csv
import tempfile
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import (
    Callable,
    Dict,
    Iterator,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Sequence,
    Tuple,
    Union,
)

import numpy as np

from . import adapters, anchor_files, attention, files, filters, layers
from .anchor_files import ENDINGS
from .errors import FileError, FilterError, InputError
from .files import write_ply
from .flags import by_flags
from .model import ShapeModel
from .model_files import beside, checked_names, name_arrays, read_model
from .parameters import NAMED, path_of, whole_number
from .results import ResultFolder, require_apart
from .sphere_map import SphereMap
from .surface import Surface, SurfaceLike, array_of, as_surface
from .units import DEFAULT_UNIT, unit_named

FIT = "compute_shape_model_fit"
POSES = NAMED["pose"]
SIZES = ("As the model", "Rigid", "Similarity")
ANCHOR_FILES = ENDINGS[:8]  # but for those that are meshes and particles elsewhere
NAMED_AT_MOST = 10
MAP_FIGURES = ("flipped_faces", "area_ratio_sd", "area_log_mean", "angle_error_mean")

ModelLike = Union[ShapeModel, str, Path]
# Landmark, by number or by a name that the model has -> x, y, z; or a file of such.
Anchors = Union[Mapping[Union[int, str], Sequence[float]], str, Path]


@dataclass(frozen=True, eq=False)
class Fit:
    """A shape of the model, fitted to a surface, and how certain it is.

    points: (landmarks, 3), in the surface's frame; faces: (k, 3); sd: (landmarks,), the root of the
    mean variance of each landmark's coordinates; covariance: (landmarks, 3, 3). All are those of a
    normal distribution, given what is seen of the surface.
    scores: along the model's modes; score_sd: their standard deviations.
    pose: (4, 4), from the model's frame to the surface's.
    map: of the surface, which then has landmarks of its own (remesh), like those of the model; None
    where the surface is open or the model leaves lids out.
    figures: surface_distance (mean distance of the surface from the fit), noise (its standard
    deviation, robustly), deviation (1 for a shape as far from the mean as shapes are), percentile
    (percent of the training shapes that deviate less), local_deviation, unseen (share of the
    landmarks that no part of the surface is near to), unexplained (share of the surface that no
    part of the model is near to), starts, seconds; with a map residual_mean, residual_p95,
    repaired_faces.
    """

    points: np.ndarray
    faces: np.ndarray
    sd: np.ndarray
    covariance: np.ndarray
    scores: np.ndarray
    score_sd: np.ndarray
    pose: np.ndarray
    map: Optional[SphereMap]
    figures: Dict[str, float]

    def __repr__(self) -> str:
        return (
            f"Fit({len(self.points)} landmarks, {self.figures['surface_distance']:.3g} from the "
            f"surface, sd {self.sd.mean():.3g}, deviation {self.figures['deviation']:.3g})"
        )


def fit(
    model: ModelLike,
    surface: SurfaceLike,
    *,
    anchors: Optional[Anchors] = None,
    anchor_sd: float = 0.0,
    pose: str = "Search",
    alignment: str = "As the model",
    modes: int = 0,
    local_deviation: bool = True,
    label: Union[str, int, Sequence[int]] = 1,
    export_file: str = "",
    threads: int = 0,
) -> Fit:
    """Fits a shape model to a surface that it was not built from: closed or open, whole or a part,
    in the model's unit, faces outside counter-clockwise.

    model: a ShapeModel, or its file (.npz; .h5 and .json of statismo and scalismo). surface: one,
    as everywhere; or a label volume, as read_label_volume takes it, of one phase: then the surface
    of its `label` in mm, in RAS.
    anchors: what is known of where landmarks lie, {landmark: (x, y, z)}, landmarks by number or by
    a name that the model has (landmark_names); or a file of them (docs/anchors.md). anchor_sd: how
    far off, per coordinate, 0 for the surface's mean edge.
    pose: "Search" from anywhere, "As it lies" in the model's frame, or by "Anchors", three or more.
    alignment: whether size is sought, as well: "Similarity", "Rigid", or "As the model", which was
    built with or without.
    modes: the first so many, 0 for all. local_deviation: whether shapes may differ from what the
    modes can show. export_file: .npz, with all of the result. threads: how many work, 0 for as many
    as the machine runs at once; the fit is the same with any number.

    Warns (SpherePropagationWarning) where the model does not come near much of the surface, or the
    shape is unlike all training shapes.
    """
    with _prepared(model) as prepared:
        return _fit(
            prepared,
            _surface_of(surface, label),
            anchors=anchors,
            anchor_sd=anchor_sd,
            pose=pose,
            alignment=alignment,
            modes=modes,
            local_deviation=local_deviation,
            export_file=str(path_of(export_file)) if export_file else "",
            threads=threads,
        )


class _Prepared(NamedTuple):
    """A model where the filter finds it."""

    shapes: ShapeModel
    folder: Path
    file: Path


@contextmanager
def _prepared(model: ModelLike) -> Iterator[_Prepared]:
    shapes = model if isinstance(model, ShapeModel) else read_model(model)
    with tempfile.TemporaryDirectory(prefix="sphere-propagation-") as folder:
        file = Path(folder) / "model.npz"
        np.savez(
            file,
            mean=np.ascontiguousarray(shapes.mean, float),
            modes=np.ascontiguousarray(shapes.modes, float),
            eigenvalues=np.ascontiguousarray(shapes.eigenvalues, float),
            scores=np.ascontiguousarray(shapes.scores, float),
            faces=np.ascontiguousarray(shapes.faces, np.int32),
            noise_variance=np.float64(shapes.noise_variance),
            **name_arrays(checked_names(shapes.landmark_names, len(shapes.mean))),
        )
        yield _Prepared(shapes, Path(folder), file)


def _surface_of(surface: SurfaceLike, label) -> Surface:
    if not adapters.is_label_volume(surface):
        return as_surface(surface)
    found = filters.read_label_volume(surface, labels=label).surfaces
    if len(found) > 1:
        raise InputError(
            f"The label volume has {len(found)} phases, and one surface is fitted at a time: fit "
            "each of sp.read_label_volume(volume, labels=1).surfaces."
        )
    return found[0]


def _fit(prepared: _Prepared, given: Surface, *, anchors=None, **parameters) -> Fit:
    """parameters: the filter's."""
    shapes = prepared.shapes
    meshes = layers.mesh_set([given])
    returned = layers.apply(
        meshes,
        FIT,
        model_file=str(prepared.file),
        anchor_file=_anchor_file(prepared.folder, anchors, shapes),
        **parameters,
    )
    fitted = meshes.mesh(meshes.mesh_number() - 1)
    count = len(shapes.mean)
    sphere = None
    if "flipped_faces" in returned:
        sphere = layers.map_of(
            meshes.mesh(0), {name: float(returned[name]) for name in MAP_FIGURES}
        )
    arrays = ("scores", "score_sd", "pose", "landmark_sd", "covariance", *MAP_FIGURES)
    return Fit(
        fitted.vertex_matrix(),
        np.asarray(shapes.faces, np.int32),
        np.asarray(returned["landmark_sd"]),
        np.reshape(returned["covariance"], (count, 3, 3)),
        np.asarray(returned["scores"]),
        np.asarray(returned["score_sd"]),
        np.reshape(returned["pose"], (4, 4)),
        sphere,
        {
            name: float(value)
            for name, value in returned.items()
            if name not in arrays and np.ndim(value) == 0 and not isinstance(value, (str, bytes))
        },
    )


def fit_files(
    model,
    surfaces,
    folder,
    say: Callable[[str], None],
    *,
    label=1,
    anchors="",
    unit=None,
    **choices,
) -> Tuple[List[str], Dict[str, str]]:
    """fit() for files, or folders of them, meshes and label volumes, each phase of these:
    NAME_fit.ply (quality: sd), NAME_fit.npz, and fits.csv with a row each. anchors: a file of them,
    or a folder with files that are called as the surfaces are. unit: of lengths (default: what
    landmarks.npz beside the model says, else mm). choices: of the filter; words may have hyphens.
    Returns what lies in the folder, and of surfaces that cannot be fitted, why."""
    unit = unit_named(unit or beside(Path(model))[1] or DEFAULT_UNIT)
    for key in ("pose", "alignment"):
        words = (
            value for value in (*POSES, *SIZES) if value.lower().replace(" ", "-") == choices[key]
        )
        choices[key] = next(words, choices[key])
    if choices["pose"] == "Anchors" and not anchors:
        raise InputError("pose: 'Anchors' needs anchors.")
    if anchors and not path_of(anchors).exists():
        raise InputError(f"anchors: there is no file or folder {anchors}.")
    paths = files.input_files(*surfaces)
    require_apart([model, *([anchors] if anchors else []), *paths], folder)
    results = ResultFolder(folder)
    results.require_folder()
    found, failed = _surfaces_of(paths, label)
    files.warn_of_frames([surface for _, surface in found if surface])
    if anchors and path_of(anchors).is_dir():
        anchor_files.warn_of_folder(anchors, [name for name, surface in found if surface])
    names = ("surface_distance", "noise", "deviation", "percentile", "unseen", "unexplained")
    with _prepared(model) as prepared:
        results.create()
        modes = range(len(prepared.shapes.modes))
        scores = [f"score_{m + 1}" for m in modes]
        rows = [["surface", *names, "map", "unit", "warnings", "error", *scores]]
        for name, surface in found:
            try:
                if surface is not None:
                    its = {**choices, "anchors": _anchors_of(anchors, name, choices["pose"])}
                    rows.append(_fit_file(prepared, surface, results, say, names, unit, its))
                    continue
            except (FileError, FilterError, InputError) as error:
                failed[name] = str(error)
            failed[name] = by_flags(failed[name])
            say(f"{name}: not fitted")
            blank = [""] * len(scores)
            rows.append([name, *[""] * len(names), "", unit, "", failed[name], *blank])
    results.write("fits.csv", lambda path: _write_table(path, rows))
    warned = [row[0] for row in rows[1:] if row[rows[0].index("warnings")]]
    if warned:
        say(
            f"{len(warned)} of {len(found)} deserve a look before their figures are used, as the "
            f"warnings say: {', '.join(warned[:NAMED_AT_MOST])}"
            + (" and others" if len(warned) > NAMED_AT_MOST else "")
        )
    made = [
        "fits.csv: a row for each surface: distance, deviation, warnings, scores",
        "*_fit.ply, *_fit.npz: the fitted shapes with the standard deviation of each landmark",
        "the surfaces themselves, as *.ply with their maps, where they are closed",
    ]
    return made[: 1 if len(failed) == len(found) else 3], failed


def _fit_file(
    prepared: _Prepared,
    surface: Surface,
    results: ResultFolder,
    say: Callable[[str], None],
    figures: Sequence[str],
    unit: str,
    choices,
) -> List[str]:
    """Its row of the table."""
    name = surface.name
    found: List[Fit] = []
    with attention.collected() as said:
        results.write(
            f"{name}_fit.npz",
            lambda path: found.append(_fit(prepared, surface, export_file=str(path), **choices)),
        )
    got = found[0]
    results.write(
        f"{name}_fit.ply",
        lambda path: write_ply(path, got.points, got.faces, scalars={"quality": got.sd}),
    )
    if got.map is not None:
        results.write(
            f"{name}.ply",
            lambda path: write_ply(path, surface.vertices, surface.faces, texture=got.map.texture),
        )
    say(
        f"{name}: {got.figures['surface_distance']:.3g} {unit} from the surface, deviation "
        f"{got.figures['deviation']:.3g}"
        + (
            f", more than {got.figures['percentile']:.0f} % of the training shapes"
            if np.isfinite(got.figures["percentile"])
            else ""
        )
        + ("" if got.map is None else ", map certified")
    )
    values = [*(got.figures[key] for key in figures), int(got.map is not None)]
    return [
        name,
        *(f"{value:.9g}" for value in values),
        unit,
        " ".join(sorted({warning.message or "other" for warning in said})),
        "",
        *(f"{score:.9g}" for score in got.scores),
    ]


def _anchors_of(given, name: str, pose: str) -> Optional[Path]:
    """The file of this surface; none where the folder has none."""
    if not given:
        return None
    given = path_of(given)
    file = anchor_files.file_in(given, name) if given.is_dir() else given
    if file is None and pose == "Anchors":
        raise InputError(
            f"{name}: its pose is to be that of its anchors, and there is no file of them: none of "
            f"{anchor_files.looked_for(given, name)}."
        )
    return file


def _surfaces_of(
    paths: Sequence[Path], label
) -> Tuple[List[Tuple[str, Optional[Surface]]], Dict[str, str]]:
    """Those in the files by names that differ, None where one cannot be read; and why it cannot."""
    found: List[Tuple[str, Optional[Surface]]] = []
    failed: Dict[str, str] = {}
    for path, name in zip(paths, files.names_of(paths)):
        try:
            found += [(surface.name, surface) for surface in _surfaces_in(path, name, label)]
        except (FileError, FilterError, InputError) as error:
            found.append((name, None))
            failed[name] = str(error)
    return found, failed


def _surfaces_in(path: Path, name: str, label) -> List[Surface]:
    if not files.is_label_volume(path):
        return [replace(files.read_mesh(path), name=name)]
    stem = files.stem_of(path)
    found = filters.read_label_volume(path, labels=label).surfaces
    names = [surface.name for surface in found]
    if len(found) == 1:
        return [replace(found[0], name=name)]
    names = [name + called[len(stem) :] if called.startswith(stem) else called for called in names]
    return [replace(surface, name=called) for surface, called in zip(found, names)]


def _write_table(path: Path, rows: List[List[str]]) -> None:
    with open(path, "w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)


def _anchor_file(folder: Path, anchors: Optional[Anchors], shapes: ShapeModel) -> str:
    """As a table of the filter's; empty where there are none."""
    if not anchors:
        return ""
    if adapters.is_path(anchors):
        anchor_files.require_points([path_of(anchors)])
        return str(path_of(anchors))
    count = len(shapes.mean)
    if not isinstance(anchors, Mapping):
        raise InputError(
            f"anchors must be a dictionary, {{landmark: (x, y, z)}}, not {type(anchors).__name__}."
        )
    rows = ["name,x,y,z"]
    for landmark, point in anchors.items():
        if isinstance(landmark, str) and landmark not in shapes.landmark_names:
            known = ", ".join(shapes.landmark_names) or "none"
            raise InputError(
                f"The model has no landmark called {landmark!r}; names that it has: {known}."
            )
        number = whole_number(
            "The landmark of an anchor",
            shapes.landmark_names[landmark] if isinstance(landmark, str) else landmark,
        )
        if not 0 <= number < count:
            raise InputError(
                f"There is no landmark {number}: the model's are numbered from 0 to {count - 1}."
            )
        place = array_of(f"The place of anchor {number}", point)
        if place.shape != (3,) or place.dtype.kind not in "fiu" or not np.isfinite(place).all():
            raise InputError(f"The place of anchor {number} must be three numbers, not {point!r}.")
        rows.append(",".join([str(number), *(repr(float(x)) for x in place)]))
    file = folder / "anchors.csv"
    file.write_text("\n".join(rows) + "\n")
    return str(file)
