# SPDX-License-Identifier: GPL-3.0-only
"""What a correspondence leaves behind: layers as PLY files, and MeshLab projects that show them."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Dict, List, Union

import numpy as np

from .colors import place_colors, sphere_coordinates
from .correspondence import Correspondence
from .errors import InputError
from .files import write_ply
from .filters import landmark_places, map_colors
from .parameters import path_of
from .project_file import ProjectLayer, write_project
from .results import ResultFolder
from .surface import distinct_names
from .views import Row, sphere_rotation, upright


def write_layers(folder, name: str, result: Union[Row, Correspondence]) -> None:
    """FOLDER/name/: surfaces, landmarks and spheres as PLY, in folders of their own; a project to
    work on and one to look at.

    folder: a path, or the ResultFolder that these files are a part of. What the last call with this
    name wrote is replaced.
    """
    row = result if isinstance(result, Row) else Row(name, result)
    if not isinstance(row.result, Correspondence):
        raise InputError(f"Layers are those of correspond(), not of {type(row.result).__name__}.")
    if not isinstance(name, str) or not name or Path(name).name != name:
        raise InputError(f"The name of the layers becomes a folder's: {name!r} cannot.")
    result = row.result
    results, place = (
        (folder, f"{name}/")
        if isinstance(folder, ResultFolder)
        else (ResultFolder(path_of(folder).absolute() / name), "")
    )
    # Colours sit on vertices, so coarse meshes get a coarse checkerboard.
    cells = 2 * int(
        np.clip(round(1 + len(result.surfaces[result.root].vertices) ** 0.5 / 20), 2, 4)
    )
    shades = map_colors(result.surfaces, result.maps, cells=cells)
    root = result.root
    places = landmark_places(result.surfaces[root], result.maps[root], result.landmarks.shape[1])
    hues = place_colors(*sphere_coordinates(places))
    layers: Dict[str, List[ProjectLayer]] = {"surfaces": [], "landmarks": [], "spheres": []}

    def add(kind, label, *mesh):
        path = results.write(
            f"{place}{kind}/{label.replace(' ', '_').replace('/', '_')}.ply",
            lambda path: write_ply(path, *mesh, space=result.surfaces[0].space),
        )
        layers[kind].append(ProjectLayer(label, path, kind == "surfaces"))

    labels = distinct_names(result.surfaces)
    for surface, label, sphere, points, colors in zip(
        result.surfaces, labels, result.maps, result.landmarks, shades
    ):
        add("surfaces", label, surface.vertices, surface.faces, colors, sphere.texture)
        add("landmarks", f"{label} landmarks", points, result.landmark_faces, hues)
        add("spheres", f"{label} sphere", sphere.positions, surface.faces, colors)
    everything = layers["surfaces"] + layers["landmarks"] + layers["spheres"]
    results.write(f"{place}{name}.mlp", lambda path: write_project(path, everything))
    results.write(
        f"{place}{name}_overview.mlp", lambda path: write_project(path, overview(row, layers))
    )


def write_landmarks(path, result: Correspondence) -> None:
    """All landmarks in one file; its ending chooses: .npz (landmarks (surfaces, N, 3), faces,
    names, root, unit, lid (N,)) or .csv (a row per landmark: shape, landmark, x, y, z; landmarks
    count from 0); with uncertainty (surfaces, N), a last column in .csv, where it was asked for."""
    path = path_of(path)
    if not isinstance(result, Correspondence):
        raise InputError(f"Landmarks are those of correspond(), not of {type(result).__name__}.")
    names = distinct_names(result.surfaces)
    if path.suffix.lower() == ".npz":
        more = {} if result.uncertainty is None else {"uncertainty": result.uncertainty}
        np.savez_compressed(
            path,
            **more,
            landmarks=result.landmarks,
            faces=result.landmark_faces,
            names=np.array(names),
            root=result.root,
            unit=np.array(result.unit),
            lid=np.zeros(result.landmarks.shape[1], bool) if result.lid is None else result.lid,
        )
    elif path.suffix.lower() == ".csv":
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            columns, rows = ["x", "y", "z"], result.landmarks
            if result.uncertainty is not None:
                columns.append("uncertainty")
                rows = np.dstack([rows, result.uncertainty])
            writer.writerow(["shape", "landmark", *columns])
            for name, points in zip(names, rows):
                writer.writerows(
                    [name, j, *(f"{value:.9g}" for value in point)]
                    for j, point in enumerate(points.tolist())
                )
    else:
        raise InputError(f"Landmarks are written as .npz or .csv, not as {path.name}.")


def overview(row: Row, layers) -> List[ProjectLayer]:
    """Surfaces in a grid, landmarks in a grid beside it, the root's sphere between the two;
    upright, as MeshLab looks at it."""
    result = row.result
    rotation = upright(result.surfaces[result.root].vertices, row.up)
    seen = [surface.vertices @ rotation.T for surface in result.surfaces]
    low, high = np.min([v.min(0) for v in seen], 0), np.max([v.max(0) for v in seen], 0)
    step = 1.12 * (high - low)[:2]
    # The two grids side by side make a square.
    columns = int(np.ceil(np.sqrt(0.5 * len(seen) * step[1] / step[0])))
    lines = -(-len(seen) // columns)
    radius = min(1.2 * step[0], 0.5 * lines * step[1])
    center = (low + high) / 2

    def placed(layer, turn, *where):
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = turn, where
        return layer._replace(visible=True, matrix=matrix)

    found = []
    for kind, start in (
        ("surfaces", -radius - step[0] * columns),
        ("landmarks", radius + 0.2 * step[0]),
    ):
        for i, layer in enumerate(layers[kind]):
            x, y = (
                start + (i % columns + 0.5) * step[0],
                (0.5 * (lines - 1) - i // columns) * step[1],
            )
            found.append(placed(layer, rotation, x - center[0], y - center[1], -center[2]))
    turn = sphere_rotation(
        result.surfaces[result.root].vertices @ rotation.T, result.maps[result.root].positions
    )
    found.append(placed(layers["spheres"][result.root], 0.9 * radius * turn, 0, 0, 0))
    return found
