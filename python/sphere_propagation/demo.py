"""The command line: a phantom or a folder of meshes through the whole job, and everything worth looking at into a folder."""
from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import List, Optional, Sequence

import numpy as np

from . import files, pictures, pipeline, projects, report
from .phantom import Ventricle
from .pipeline import PipelineError
from .plugin import PluginError

METHODS = {"robust": "Robust", "published": "As published"}
ORDERS = {"time": "Time", "cyclic": "Cyclic time", "similarity": "Similarity tree", "star": "Star"}


class Steps:
    """One line per step with the seconds that it took."""

    def __init__(self):
        self.start = self.last = time.monotonic()

    def __call__(self, text: str) -> None:
        now = time.monotonic()
        print(f"[{now - self.last:5.1f} s] {text}", flush=True)
        self.last = now

    def total(self) -> float:
        return time.monotonic() - self.start


def run_phantom(options, folder: Path, steps: Steps) -> List[report.Run]:
    runs, rows, errors = [], [], []
    for part in pipeline.PARTS:
        surfaces = pipeline.make_phantom(part, options.phases, options.voxel_size, options.seed)
        vertices = np.mean([len(surface.vertices) for surface in surfaces])
        steps(f"{part.lower()}: {len(surfaces)} phases of the phantom, {vertices:.0f} vertices on average")
        results = pipeline.run(surfaces, options.root or 0, pipeline.METHODS, ORDERS[options.order or "cyclic"], options.frequency,
                               lambda text: steps(f"{part.lower()}: {text}"))
        truth = Ventricle(part, options.phases, options.seed)
        errors.append({method: truth.errors(result.landmarks, result.root) for method, result in results.items()})
        steps(f"{part.lower()}: worst error " + ", ".join(f"{method.lower()} {e.max():.2f} mm" for method, e in errors[-1].items()))
        runs += [report.Run(part.lower(), results[method], errors[-1][method]) for method in results]
        rows.append(pictures.Row(part, results["Robust"], unit="mm", up=(0, 0, 1)))
        projects.write_layers(folder, part.lower(), rows[-1])
        steps(f"{part.lower()}: layers and projects written")
    draw(folder, rows, steps, errors)
    return runs


def run_folder(options, folder: Path, steps: Steps) -> List[report.Run]:
    source = Path(options.input)
    paths = files.mesh_files(source)
    if folder.resolve() in [source.resolve(), *source.resolve().parents]:
        raise PipelineError(f"The meshes lie in the output folder {folder}: choose another one.")
    surfaces = [files.read_mesh(path) for path in paths]
    steps(f"{len(surfaces)} mesh{'es' * (len(surfaces) > 1)} from {source}: {paths[0].name} to {paths[-1].name}, "
          f"{sum(len(surface.vertices) for surface in surfaces)} vertices")
    root = pipeline.largest(surfaces) if options.root is None else options.root
    method = METHODS[options.method]
    result = pipeline.run(surfaces, root, [method], ORDERS[options.order or "time"], options.frequency, steps)[method]
    name = source.resolve().name
    row = pictures.Row(name, result)
    projects.write_layers(folder, name, row)
    steps("layers and projects written")
    draw(folder, [row], steps)
    return [report.Run(name, result)]


def draw(folder: Path, rows: Sequence[pictures.Row], steps: Steps, errors: Optional[list] = None) -> None:
    pictures.landmarks_over_cycle(rows, folder / "landmarks.png")
    steps("landmarks.png: landmarks over the cycle")
    pictures.maps_over_cycle(rows, folder / "checkerboard.png")
    steps("checkerboard.png: the maps over the cycle")
    pictures.root_and_sphere(rows, folder / "map.png")
    steps("map.png: the root and its sphere")
    if errors:
        pictures.errors_over_phase(rows, errors, folder / "error.png")
        steps("error.png: error over the cycle")


def parser() -> argparse.ArgumentParser:
    found = argparse.ArgumentParser(prog="scripts/demo", description=__doc__)
    found.add_argument("folder", nargs="?", default="demo", help="where everything goes (default: %(default)s)")
    found.add_argument("--input", metavar="FOLDER", help="meshes (ply, stl, obj, off) in natural order, instead of the phantom")
    found.add_argument("--root", type=int, help="number of the root, from 0 (default: the mesh of largest volume; the phantom's phase 0)")
    found.add_argument("--order", choices=list(ORDERS), help="who hands the map to whom (default: time; for the phantom cyclic)")
    found.add_argument("--method", choices=list(METHODS), default="robust", help="with --input (default: robust); the phantom gets both")
    found.add_argument("--frequency", type=int, default=10, help="10 f^2 + 2 landmarks (default: 10, which gives 1002)")
    found.add_argument("--phases", type=int, default=25, help="of the phantom (default: 25)")
    found.add_argument("--voxel-size", type=float, default=2.0, help="of the phantom, mm (default: 2)")
    found.add_argument("--seed", type=int, default=0, help="of the phantom: another one makes another ventricle (default: 0)")
    return found


def main(arguments: Optional[Sequence[str]] = None) -> int:
    options = parser().parse_args(arguments)
    steps, folder = Steps(), Path(options.folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        runs = (run_folder if options.input else run_phantom)(options, folder, steps)
        report.write_csv(folder / "figures.csv", runs)
    except (PipelineError, PluginError, OSError, ImportError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print(f"\n{report.summary(runs)}\n\nIn {folder.resolve()} ({steps.total():.0f} s):")
    for data in dict.fromkeys(run.data for run in runs):
        print(f"  {data}/{data}.mlp, {data}/{data}_overview.mlp: open in MeshLab, to work on and to look at")
    print("  *.png: pictures    figures.csv: one row per layer")
    return 0


if __name__ == "__main__":
    sys.exit(main())
