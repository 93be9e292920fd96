"""What the command line does: meshes, or the phantom, through the whole job, and everything worth looking at into a folder."""
from __future__ import annotations

from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Sequence

import numpy as np

from . import files, filters, pictures, projects, report
from .correspondence import Correspondence, check_arguments, correspond
from .errors import InputError
from .model import ShapeModel
from .phantom import Ventricle
from .progress import Lines
from .results import ResultFolder
from .views import Row

STEPS_OF_A_METHOD = 2  # maps, landmarks


class Choices(NamedTuple):
    """What is chosen on the command line; None: as the job thinks best."""

    root: Optional[int] = None
    method: str = "Robust"  # the phantom gets both
    order: Optional[str] = None
    parents: str = ""
    frequency: int = 10
    initial_map: str = "Automatic"
    area_weight: float = 0.9
    area_restoration: float = 0.0
    pictures: bool = True
    volume: Dict[str, Any] = {}  # of read_label_volume, what is given

    def parameters(self) -> Dict[str, Any]:
        """Those of correspond() that are the same for every sequence."""
        return {"parents": self.parents, "frequency": self.frequency, "initial_map": self.initial_map, "area_weight": self.area_weight,
                "area_restoration": self.area_restoration}


def run_meshes(meshes: Sequence, folder, name: Optional[str], choices: Choices, progress: Callable[[int], Lines]) -> List[report.Run]:
    """Files and folders of meshes or label volumes; `name` calls the sequence. progress: makes the Lines for a number of steps."""
    if name is not None and (name in ("", ".", "..") or Path(name).name != name):
        raise InputError(f"The name of the sequence becomes a folder of results: it must be a plain name, not {name!r}.")
    paths = files.input_files(*meshes)
    if choices.volume and not any(map(files.is_label_volume, paths)):
        raise InputError(f"There is no label volume among the files, to which {', '.join(choices.volume)} could apply.")
    home = Path(folder).resolve()
    for path in paths:
        if home in path.resolve().parents:
            raise InputError(f"{path} lies in the output folder {folder}: choose another one.")
    if not any(map(files.is_label_volume, paths)):  # how many phases those have is known when they are read
        check_arguments(len(paths), root=choices.root, method=choices.method, order=choices.order or "Time", **choices.parameters())
    name = name or _name_of(meshes, paths)
    steps = progress(4 + STEPS_OF_A_METHOD + _picture_count(choices))
    surfaces = []
    for path in paths:
        steps.begin(f"reading {path.name}")
        surfaces += filters.read_label_volume(path, **choices.volume).surfaces if files.is_label_volume(path) else [files.read_mesh(path)]
    where = paths[0].name + (f" to {paths[-1].name}" if len(paths) > 1 else "")
    steps.done(f"{len(surfaces)} {'mesh' if len(surfaces) == 1 else 'meshes'}: {where}, "
               f"{sum(len(surface.vertices) for surface in surfaces)} vertices")
    results = ResultFolder(folder)
    results.create()  # before the work, not after
    result = correspond(surfaces, root=choices.root, method=choices.method, order=choices.order or "Time", progress=steps,
                        **choices.parameters())
    row = Row(name, result)
    _write_layers(results, name, row, steps)
    _build_model(results, name, result, steps)
    return _finish(results, [row], [report.Run(name, result)], None, choices, steps)


def run_phantom(folder, choices: Choices, phases: int, voxel_size: float, seed: int, progress: Callable[[int], Lines]) -> List[report.Run]:
    """Both parts of the phantom, by both methods, against the truth."""
    if not 0.25 <= voxel_size <= 4:
        raise InputError(f"The voxels of the phantom must measure 0.25 to 4 mm, not {voxel_size}.")
    check_arguments(phases, root=choices.root, method=choices.method, order=choices.order or "Cyclic time", **choices.parameters())
    steps = progress(len(filters.PARTS) * (5 + STEPS_OF_A_METHOD * len(filters.METHODS)) + _picture_count(choices, phantom=True))
    results = ResultFolder(folder)
    results.create()
    runs, rows, errors = [], [], []
    for part in filters.PARTS:
        name = part.lower()
        steps.begin(f"{name}: making the phantom")
        surfaces = filters.make_phantom(part=part, phases=phases, voxel_size=voxel_size, seed=seed)
        vertices = np.mean([len(surface.vertices) for surface in surfaces])
        steps.done(f"{name}: {len(surfaces)} phases of the phantom, {vertices:.0f} vertices on average")
        found, root_map = {}, None
        for method in filters.METHODS:
            found[method] = correspond(surfaces, root=choices.root or 0, root_map=root_map, method=method,
                                       order=choices.order or "Cyclic time", progress=_Named(steps, name), **choices.parameters())
            root_map = found[method].root_map
        steps.begin(f"{name}: comparing with the truth")
        truth = Ventricle(part, phases, seed)
        errors.append({method: truth.errors(result.landmarks, result.root) for method, result in found.items()})
        steps.done(f"{name}: worst error " + ", ".join(f"{method.lower()} {e.max():.2f} mm" for method, e in errors[-1].items()))
        runs += [report.Run(name, result, errors[-1][method]) for method, result in found.items()]
        rows.append(Row(part, found["Robust"], unit="mm", up=(0, 0, 1)))
        _write_layers(results, name, rows[-1], steps)
        _build_model(results, name, found["Robust"], steps)
    return _finish(results, rows, runs, errors, choices, steps)


def _name_of(given: Sequence, paths: Sequence[Path]) -> str:
    """That of the label volume, else of the folder that the meshes lie in."""
    if len(paths) == 1 and files.is_label_volume(paths[0]):
        return files.stem_of(paths[0])
    first = Path(given[0]).resolve()
    return next(filter(None, (path.name for path in (first, *first.parents) if path.is_dir())), "meshes")


class _Named:
    """Puts a sequence's name before what is said."""

    def __init__(self, steps: Lines, name: str):
        self.begin = lambda text: steps.begin(f"{name}: {text}")
        self.done = lambda text: steps.done(f"{name}: {text}")


def _write_layers(results: ResultFolder, name: str, row: Row, steps: Lines) -> None:
    steps.begin(f"{name}: writing layers and projects")
    projects.write_layers(results, name, row)
    steps.done(f"{name}: layers and projects written")


def _build_model(results: ResultFolder, name: str, result: Correspondence, steps: Lines) -> ShapeModel:
    """The shape model of all phases, as a file for NumPy and two tables."""
    steps.begin(f"{name}: shape model")
    names = [surface.name for surface in result.surfaces]
    made: List[ShapeModel] = []
    results.write(f"{name}/model.npz", lambda path: made.append(
        filters.shape_model(result.landmarks, result.landmark_faces, names, export_file=str(path))))
    model = made[0]
    results.write(f"{name}/scores.csv", lambda path: report.write_scores(path, model))
    results.write(f"{name}/model.csv", lambda path: report.write_measures(path, model))
    steps.done(f"{name}: shape model: {report.model_summary(model)}")
    return model


def _finish(results: ResultFolder, rows: Sequence[Row], runs: List[report.Run], errors: Optional[list], choices: Choices,
            steps: Lines) -> List[report.Run]:
    """The table of figures, then pictures, which can fail for reasons of their own."""
    results.write("figures.csv", lambda path: report.write_csv(path, runs))
    if _picture_count(choices):
        _draw(results, rows, errors, steps)
    elif choices.pictures:
        steps.note(f"no pictures: {pictures.what_is_missing()}")
    for path in results.kept:
        steps.note(f"kept, because it was changed since it was written or is somebody else's: {path}")
    steps.close()
    return runs


def _draw(results: ResultFolder, rows: Sequence[Row], errors: Optional[list], steps: Lines) -> None:
    drawings = [("landmarks.png", "landmarks over the cycle", lambda path: pictures.landmarks_over_cycle(rows, path)),
                ("checkerboard.png", "the maps over the cycle", lambda path: pictures.maps_over_cycle(rows, path)),
                ("map.png", "the root and its sphere", lambda path: pictures.root_and_sphere(rows, path))]
    if errors:
        drawings.append(("error.png", "error over the cycle", lambda path: pictures.errors_over_phase(rows, errors, path)))
    for name, what, draw in drawings:
        steps.begin(f"{name}: {what}")
        results.write(name, draw)
        steps.done(f"{name}: {what}")


def _picture_count(choices: Choices, phantom: bool = False) -> int:
    return 0 if not choices.pictures or pictures.what_is_missing() else 4 if phantom else 3
