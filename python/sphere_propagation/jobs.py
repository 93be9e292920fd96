# SPDX-License-Identifier: GPL-3.0-only
"""What the command line does: meshes, or the phantom, through the whole job, and everything worth
looking at into a folder."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Set, Tuple

import numpy as np

from . import anchor_files, attention, files, filters, gallery, pictures, plugin, projects, report
from .adapters import is_path
from .attention import warn
from .correspondence import Correspondence, checked, correspond_by
from .errors import FilterError, InputError, SpherePropagationWarning
from .explorer import Explorer, explore
from .flags import option
from .gallery import Section
from .model import ShapeModel
from .nifti import write_nifti
from .parameters import DEFAULTS, METHODS, CorrespondenceParameters
from .phantom import SCAN_SPACING, Ventricle
from .preparation import prepare, steps_in_words
from .progress import Lines
from .provenance import Provenance, provenance
from .results import ResultFolder, require_apart
from .surface import Surface, count_others, distinct_names
from .units import DEFAULT_UNIT
from .views import Row

SECONDS_PER_PHASE = 0.04  # in the phantom's scan; nothing depends on it

# What is done one after another; a progress bar counts it.
METHOD_STEPS = ("maps", "landmarks")
RESULT_STEPS = ("layers and projects", "shape model")
MESH_STEPS = ("meshes", "root map", *METHOD_STEPS, *RESULT_STEPS)
SCAN_STEPS = ("labels", "surfaces", "root map", *METHOD_STEPS, *RESULT_STEPS)
PART_STEPS = ("phantom", "root map", *METHOD_STEPS * len(METHODS), "truth", *RESULT_STEPS)

UNTIMED = ("Similarity tree", "Star")  # orders of shapes that are no phases
EXPORTS = ("h5", "json", "particles", "ply")  # of the shape model; npz and csv are always there
EXPLORER = "explore.html"  # beside the model, and inside the report
FORMATS = ("svg", "pdf")  # of pictures; png is always there

# Notes of the import that matter where several label volumes are read.
OF_SEVERAL = ("handlesElsewhere",)
# What was changed on request, and how files were read that can be read in two ways.
ALWAYS_NOTED = ("slicesAligned", "anchorsInLps")


@dataclass(frozen=True)
class Choices:
    """What is chosen on the command line."""

    parameters: CorrespondenceParameters = DEFAULTS  # the phantom gets all methods
    pictures: bool = True
    # Of read_label_volume, what is given.
    volume: Mapping[str, Any] = field(default_factory=dict)
    # Of prepare, what is given; None: meshes are taken as they come.
    preparation: Optional[Mapping[str, Any]] = None
    unit: Optional[str] = None  # of meshes; default: DEFAULT_UNIT
    mixed: bool = False  # whether label volumes and meshes may come together
    alignment: str = filters.ALIGNMENTS[0]  # of the shape model
    exports: Sequence[str] = ()  # of EXPORTS, beside model.npz
    formats: Sequence[str] = ()  # of FORMATS, beside png
    command: Sequence[str] = ()  # its words, for the report


def run_meshes(
    meshes: Sequence,
    folder,
    name: Optional[str],
    choices: Choices,
    progress: Callable[[int], Lines],
) -> List[report.Run]:
    """Files and folders of meshes or label volumes; `name` calls the sequence. progress: makes the
    Lines for a number of steps."""
    if name is not None and (name in ("", ".", "..") or Path(name).name != name):
        raise InputError(
            "The name of the sequence becomes a folder of results: it must be a plain name, not "
            f"{name!r}."
        )
    paths = files.input_files(*meshes)
    if choices.volume and not any(map(files.is_label_volume, paths)):
        raise InputError(
            "There is no label volume among the files, to which "
            f"{', '.join(map(option, choices.volume))} could apply."
        )
    if len(paths) > 1 and choices.volume.get("file_series"):
        raise InputError("file_series reads the files beside one: give one file, not several.")
    if choices.preparation is not None and all(map(files.is_label_volume, paths)):
        raise InputError("There is no mesh among the files, which could be prepared.")
    _require_one_kind(paths, choices)
    if choices.alignment in filters.ALIGNMENTS_BY_ANCHORS and choices.parameters.anchors is None:
        raise InputError(f"alignment: {choices.alignment!r} needs anchors.")
    ResultFolder(folder).require_folder()
    require_apart([*paths, *_files_of(choices.parameters)], folder)
    if not any(map(files.is_label_volume, paths)):  # whose phases are counted when they are read
        checked(choices.parameters, len(paths))
    name = name or _name_of(meshes, paths)
    steps = progress(len(MESH_STEPS) + _picture_count(choices, [{gallery.MODEL}]))
    alone = sum(map(files.is_label_volume, paths)) < 2
    notes = ALWAYS_NOTED if alone else (*ALWAYS_NOTED, *OF_SEVERAL)
    with attention.collected() as said, attention.noting(*notes):
        return _run_files(paths, folder, name, choices, steps, said)


def _files_of(parameters: CorrespondenceParameters) -> List[Path]:
    """What is read beside the surfaces."""
    return [Path(p) for p in (parameters.anchors, parameters.anchor_positions) if is_path(p)]


def _require_one_kind(paths: Sequence[Path], choices: Choices) -> None:
    volumes = [path for path in paths if files.is_label_volume(path)]
    meshes = [path for path in paths if not files.is_label_volume(path)]
    if volumes and meshes and not choices.mixed:
        raise InputError(
            f"There are label volumes ({_some(volumes)}) and meshes ({_some(meshes)}) among the "
            "files: leave one kind out, or say with --mixed that all are one collection."
        )
    if volumes and choices.unit not in (None, DEFAULT_UNIT):
        raise InputError(
            f"Surfaces of label volumes are in {DEFAULT_UNIT}: --unit {choices.unit} is for meshes."
        )


def _some(paths: Sequence[Path]) -> str:
    return paths[0].name + (f" and {count_others(len(paths) - 1)}" if len(paths) > 1 else "")


def _run_files(
    paths: Sequence[Path],
    folder,
    name: str,
    choices: Choices,
    steps: Lines,
    said: Sequence[SpherePropagationWarning],
) -> List[report.Run]:
    """said: what was warned of since the run began, which grows."""
    surfaces, phases = [], None
    began = provenance(choices.command, {}, paths)
    names = files.names_of(paths)
    volumes = [pair for pair in zip(paths, names) if files.is_label_volume(pair[0])]
    of_volumes: Dict[str, List[Surface]] = {}
    if volumes:  # together, for what is done to one is done to all
        steps.begin(f"reading {_some([path for path, _ in volumes])}")
        volume = filters.read_label_volume(
            paths[0] if len(paths) == 1 else [path for path, _ in volumes], **choices.volume
        )
        for surface in volume.surfaces:
            called = surface.name.rsplit(" label ", 1)[0]
            # A series has more names than the file that stands for it.
            of_volumes.setdefault(names[0] if len(paths) == 1 else called, []).append(surface)
        # Some may have been skipped.
        phases = volume.figures["phase"] if len(paths) == 1 else None
    for path, called in zip(paths, names):
        if files.is_label_volume(path):
            surfaces += of_volumes.get(called, [])
        else:
            steps.begin(f"reading {path.name}")
            mesh = replace(files.read_mesh(path), name=called)
            surfaces.append(_prepared(mesh, choices.preparation))
    files.warn_of_frames(surfaces)
    if len(surfaces) == 1 and files.is_label_volume(paths[0]):
        raise InputError(
            f"{paths[0]} gives one surface: landmarks that correspond take two or more. One "
            "volume has no phases; give a volume of several (4D), or the files of all of them."
        )
    if len(surfaces) == 1:
        raise InputError(
            f"{paths[0]} gives one surface: landmarks that correspond take two or more. Give all "
            "meshes of the sequence, or their folder."
        )
    where = _where(paths, names)
    steps.done(
        f"{len(surfaces)} {'mesh' if len(surfaces) == 1 else 'meshes'}: {where}, "
        f"{sum(len(surface.vertices) for surface in surfaces)} vertices"
    )
    anchors, called = choices.parameters.anchors, distinct_names(surfaces)
    if is_path(anchors) and any(anchor_files.file_in(anchors, name) for name in called):
        anchor_files.warn_of_folder(anchors, called)  # else the filter refuses
    results = ResultFolder(folder)
    results.create()  # before the work, not after
    _note_anchors_beside(paths, choices, steps)
    labels = all(map(files.is_label_volume, paths))
    if choices.unit is None and not labels:
        steps.note(f"the meshes' unit is taken to be {DEFAULT_UNIT}: --unit says another one")
    if choices.parameters.order in UNTIMED and not choices.parameters.groupwise:
        steps.note(
            "shapes in no order gain by --groupwise, which compares all with each other and not "
            "each with one"
        )
    unit = DEFAULT_UNIT if choices.unit is None else choices.unit
    result = correspond_by(choices.parameters, surfaces, progress=steps, unit=unit)
    row = Row(name, result, phases=phases)
    _write_layers(results, name, row, steps)
    model, explorer = _build_model(results, name, row, choices, steps)
    runs = [report.Run(name, result, warnings=list(said))]
    text = (
        f"{len(surfaces)} surfaces, {where}: landmarks that correspond, and the shape model of "
        f"them. Method {result.method}, order {result.order}, root {surfaces[result.root].name}."
    )
    title = f"{name}: from {'labels' if labels else 'surfaces'} to a shape model"
    made = began.saying(facts_of(result, choices))
    section = Section([row], runs, model=model, explorer=explorer)
    return _finish(results, title, text, [section], choices, steps, made)


def _note_anchors_beside(paths: Sequence[Path], choices: Choices, steps: Lines) -> None:
    """MeshLab's filter follows them; here nobody has asked for them."""
    if choices.parameters.anchors is not None:
        return
    found = anchor_files.beside(paths, list(map(files.stem_of, paths)))
    if found:
        steps.note(
            f"anchors that lie beside the surfaces are heeded where --anchors {found[0].parent} "
            f"says so: {anchor_files.listed([path.name for path in found])}"
        )


def _where(paths: Sequence[Path], names: Sequence[str]) -> str:
    """From which files; names: what their surfaces are called."""
    folders = len({path.parent for path in paths})
    if len(paths) == 1:
        return paths[0].name
    if folders == 1:
        return f"{paths[0].name} to {paths[-1].name}"
    return f"{names[0]} to {names[-1]}, from {folders} folders"


def _anchors(found: Optional[filters.AnchorFit], parameters: CorrespondenceParameters) -> str:
    if found is None:
        return "none"
    how = "exact" if parameters.exact else "soft"
    if found.landmarks is None:
        shared = [name for name, n in zip(found.names, found.counts) if n > 1]
        return f"{', '.join(shared)} ({how})" if shared else "none that two surfaces have"
    names = [f"{name} landmark {j}" for name, j in zip(found.names, found.landmarks)]
    return f"{', '.join(names)} ({how})"


def facts_of(result: Correspondence, choices: Choices) -> Dict[str, Any]:
    """What a result depends on, beside its inputs."""
    parameters, root = choices.parameters, result.surfaces[result.root]
    facts = {
        "root": f"{root.name} (--root {result.root})",
        "method": result.method,
        "order": result.order,
        "parents": " ".join(f"{parent:.0f}" for parent in result.figures["parent"])
        if result.order == "Given"
        else "",
        "alignment": choices.alignment,
        "frequency": f"{parameters.frequency} ({result.landmarks.shape[1]} landmarks)",
        "initial map": parameters.initial_map,
        "area weight": f"{parameters.area_weight:g}",
        "area restoration": f"{parameters.area_restoration:g}",
        "mirror layers": "yes" if parameters.mirror_layers else "no",
        "groupwise": "yes" if parameters.groupwise else "no",
        "uncertainty": "yes" if parameters.uncertainty else "no",
        "anchors": _anchors(result.anchors, parameters),
        "unit": result.unit,
    }
    facts.update({name.replace("_", " "): value for name, value in choices.volume.items()})
    if choices.preparation is not None:
        facts["prepared"] = "yes" + "".join(
            f", {name.replace('_', ' ')}" for name, value in choices.preparation.items() if value
        )
    return facts


def _prepared(surface: Surface, how: Optional[Mapping[str, Any]]) -> Surface:
    """As it is to go on; what was done to it is a warning."""
    if how is None:
        return surface
    made, figures = prepare(surface, **how)
    if made is not surface:
        warn(
            SpherePropagationWarning(
                f"{surface.name}: it was prepared: {', '.join(steps_in_words(figures))}; "
                f"{figures['vertices']:g} vertices, {figures['vertices_before']:g} before.",
                surface.name,
                "prepared",
            )
        )
    return made


def run_phantom(
    folder,
    choices: Choices,
    phases: int,
    voxel_size: float,
    seed: int,
    progress: Callable[[int], Lines],
) -> List[report.Run]:
    """The phantom from a scan of it to a shape model; and both its parts, by both methods, against
    the truth."""
    parameters = checked(choices.parameters, phases)
    choices = replace(choices, parameters=parameters)
    began = provenance(choices.command, {}, [])
    ResultFolder(folder).require_folder()
    require_apart(_files_of(parameters), folder)
    without = plugin.volume_failure()
    scanned = int(not without)
    kinds = [{gallery.MODEL}] * scanned + [{gallery.ERRORS}]
    steps = progress(
        len(PART_STEPS) * len(filters.PARTS)
        + len(SCAN_STEPS) * scanned
        + _picture_count(choices, kinds)
    )
    results = ResultFolder(folder)
    fine, runs, rows, errors, sections = {}, [], [], [], []
    for part in filters.PARTS:
        steps.begin(f"{part.lower()}: making the phantom")
        try:
            fine[part] = filters.make_phantom(
                part=part, phases=phases, voxel_size=voxel_size, seed=seed
            )
        except FilterError as error:  # only the arguments can be wrong
            raise InputError(str(error)) from error
        vertices = np.mean([len(surface.vertices) for surface in fine[part]])
        steps.done(
            f"{part.lower()}: {phases} phases of the phantom, {vertices:.0f} vertices on average"
        )
    results.create()  # before the work, not after
    if scanned:
        sections.append(
            _scan_section(
                results,
                Ventricle("Cavity", phases, seed),
                fine["Cavity"],
                parameters,
                choices,
                steps,
            )
        )
    else:
        steps.note(f"no scan: label volumes cannot be read here. {without}")
    for part, surfaces in fine.items():
        name, found, root_map = part.lower(), {}, None
        for method in METHODS:
            found[method] = correspond_by(
                replace(parameters, method=method), surfaces, root_map, _Named(steps, name)
            )
            root_map = found[method].root_map
            parameters = replace(parameters, root=found[method].root)
        steps.begin(f"{name}: comparing with the truth")
        truth = Ventricle(part, phases, seed)
        errors.append(
            {
                method: truth.errors(result.landmarks, result.root)
                for method, result in found.items()
            }
        )
        steps.done(
            f"{name}: worst error "
            + ", ".join(f"{method.lower()} {e.max():.2f} mm" for method, e in errors[-1].items())
        )
        rows.append(Row(part, found["Robust"], up=(0, 0, 1)))
        _write_layers(results, name, rows[-1], steps)
        with attention.collected() as of_model:
            _build_model(results, name, rows[-1], choices, steps)
        for method, result in found.items():
            said = [*result.warnings, *(of_model if method == "Robust" else ())]
            runs.append(report.Run(name, result, errors[-1][method], said))
    sections.append(
        Section(
            rows,
            runs,
            "How right is it? Fine surfaces whose truth is known",
            "Labels say nothing of the tissue between the slices, so a scan cannot tell how far "
            "landmarks follow it. The same ventricle without a scanner can: its surfaces in "
            f"voxels of {voxel_size:g} mm, cavity and wall, and of every point where the tissue "
            "there goes. Both methods are measured against that.",
            "truth_",
            errors=errors,
        )
    )
    text = f"A phantom, number {seed}, over one cycle of {phases} phases, " + (
        f"first as a scanner sees it, in slices {SCAN_SPACING[2]:g} mm apart; then as it is."
        if scanned
        else "as it is."
    )
    return _finish(
        results,
        "A beating ventricle, from labels to a shape model" if scanned else "A beating ventricle",
        text,
        sections,
        choices,
        steps,
        began.saying(
            {
                "phantom": f"seed {seed}, {phases} phases, voxels of {voxel_size:g} mm",
                **facts_of(found["Robust"], choices),
                "method": " and ".join(METHODS),
            }
        ),
    )


def _scan_section(
    results: ResultFolder,
    phantom: Ventricle,
    fine: Sequence[Surface],
    parameters: CorrespondenceParameters,
    choices: Choices,
    steps: Lines,
) -> Section:
    """The way of a clinic's data: labels in thick slices, surfaces, landmarks, shape model."""
    name, volume = "scan", choices.volume
    with attention.collected() as said:
        steps.begin(f"{name}: labelling slices")
        labels, affine = phantom.scan()
        path = results.write(
            f"{name}/{name}.nii.gz",
            lambda path: write_nifti(path, labels, affine, SECONDS_PER_PHASE),
        )
        voxels = " x ".join(f"{length:g}" for length in SCAN_SPACING)
        steps.done(f"{name}: {labels.shape[3]} phases of labels, voxels of {voxels} mm")
        steps.begin(f"{name}: surfaces of the labels")
        surfaces = filters.read_label_volume(
            path, **{key: value for key, value in volume.items() if key != "voxel_size"}
        ).surfaces
        steps.done(
            f"{name}: {len(surfaces)} surfaces, "
            f"{np.mean([len(surface.vertices) for surface in surfaces]):.0f} vertices on average"
        )
        result = correspond_by(
            replace(parameters, method=DEFAULTS.method), surfaces, progress=_Named(steps, name)
        )
        row = Row(f"Cavity, from slices {SCAN_SPACING[2]:g} mm apart", result, up=(0, 0, 1))
        _write_layers(results, name, row, steps)
        model, explorer = _build_model(results, name, row, choices, steps)
        whole = str(volume.get("labels", "1")) == "1"
        return Section(
            [row],
            [report.Run(name, result, warnings=list(said))],
            "From a label volume to a shape model",
            f"What goes in is scan.nii.gz: labels in voxels of {voxels} mm, as clinics have them. "
            "What comes out: a closed surface per phase, landmarks that correspond, and the "
            "statistical shape model of the cycle.",
            model=model,
            explorer=explorer,
            true_volumes=np.array([surface.volume for surface in fine]) if whole else None,
        )


def _name_of(given: Sequence, paths: Sequence[Path]) -> str:
    """That of the label volume, else of the folder that the meshes lie in."""
    if len(paths) == 1 and files.is_label_volume(paths[0]):
        return files.stem_of(paths[0])
    first = Path(given[0]).resolve()
    return next(
        filter(None, (path.name for path in (first, *first.parents) if path.is_dir())), "meshes"
    )


class _Named:
    """Puts a sequence's name before what is said."""

    def __init__(self, steps: Lines, name: str):
        self.begin = lambda text: steps.begin(f"{name}: {text}")
        self.done = lambda text: steps.done(f"{name}: {text}")
        self.note = lambda text: steps.note(f"{name}: {text}")


def _write_layers(results: ResultFolder, name: str, row: Row, steps: Lines) -> None:
    steps.begin(f"{name}: writing layers and projects")
    projects.write_layers(results, name, row)
    steps.done(f"{name}: layers and projects written")


def _build_model(
    results: ResultFolder, name: str, row: Row, choices: Choices, steps: Lines
) -> Tuple[ShapeModel, Explorer]:
    """The landmarks and their shape model, as files for NumPy, as tables, as a page to explore it,
    and as what else was asked for."""
    result = row.result
    steps.begin(f"{name}: shape model")
    for ending in ("npz", "csv"):
        results.write(
            f"{name}/landmarks.{ending}", lambda path: projects.write_landmarks(path, result)
        )
    names = distinct_names(result.surfaces)
    made: List[ShapeModel] = []

    def build(path: Path, **more) -> None:
        made.append(
            filters.shape_model(
                result.landmarks,
                result.landmark_faces,
                names,
                lid=result.lid,
                alignment=choices.alignment,
                export_file=str(path),
                landmark_names=_named(result.anchors),
                anchors=result.anchors,
                **more,
            )
        )

    with attention.after(result.warnings):
        results.write(f"{name}/model.npz", build)
    for ending in choices.exports:
        with attention.silenced():  # it was said before; how good the model is, measured
            results.write_all(
                [f"{name}/model.{ending}"],
                lambda paths: build(paths[0], specificity_samples=1),
                _beside_particles,
            )
    model = made[0]
    results.write(f"{name}/scores.csv", lambda path: report.write_scores(path, model))
    results.write(f"{name}/model.csv", lambda path: report.write_measures(path, model))
    explorer = explore(
        model,
        title=name,
        unit=result.unit,
        cyclic=result.order == "Cyclic time",
        up=row.up,
    )
    results.write(f"{name}/{EXPLORER}", explorer.save)
    steps.done(f"{name}: shape model: {report.model_summary(model)}")
    return model, explorer


def _named(anchors: Optional[filters.AnchorFit]) -> Dict[str, int]:
    """The landmarks that anchors became, where anchor_snap was asked for."""
    if anchors is None or anchors.landmarks is None:
        return {}
    return {name: int(landmark) for name, landmark in zip(anchors.names, anchors.landmarks)}


def _beside_particles(path: Path) -> List[Path]:
    """ShapeWorks' files of the single shapes."""
    return sorted(path.parent.glob(f"{path.stem}_[0-9]*.particles")) if path.suffix else []


def _finish(
    results: ResultFolder,
    title: str,
    text: str,
    sections: Sequence[Section],
    choices: Choices,
    steps: Lines,
    made: Provenance,
) -> List[report.Run]:
    """The table of figures, then the page and its pictures, which can fail for reasons of their
    own."""
    runs = [run for section in sections for run in section.runs]
    results.write("figures.csv", lambda path: report.write_csv(path, runs))
    results.write("warnings.csv", lambda path: report.write_warnings(path, runs))
    missing = pictures.what_is_missing() if choices.pictures else ""
    if missing:
        steps.note(f"no pictures: {missing}")
    results.write("run.json", lambda path: path.write_text(made.as_json() + "\n", encoding="utf-8"))
    draw = choices.pictures and not missing
    gallery.show(results, title, text, sections, draw, steps, choices.formats, made)
    for path in results.kept:
        steps.note(
            f"kept, because it was changed since it was written or is somebody else's: {path}"
        )
    steps.close()
    return runs


def _picture_count(choices: Choices, sections: Sequence[Set[str]]) -> int:
    if not choices.pictures or pictures.what_is_missing():
        return 0
    return sum(map(gallery.picture_count, sections))
