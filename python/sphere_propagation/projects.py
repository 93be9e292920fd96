"""What a correspondence leaves behind: layers as PLY files, and MeshLab projects that show them."""
from __future__ import annotations

from pathlib import Path
from typing import List

import numpy as np

from . import files, pictures, pipeline
from .colors import landmark_colors


def write_layers(folder: Path, name: str, row: pictures.Row) -> None:
    """FOLDER/name/: surfaces, landmarks and spheres as PLY; a project to work on and one to look at."""
    base, result = folder / name, row.result
    kinds = {}
    for kind in ("surfaces", "landmarks", "spheres"):
        kinds[kind] = base / kind
        kinds[kind].mkdir(parents=True, exist_ok=True)
        for old in kinds[kind].glob("*.ply"):  # layers of an earlier run
            old.unlink()
    # Colours sit on vertices, so coarse meshes get a coarse checkerboard.
    cells = 2 * int(np.clip(round(1 + len(result.surfaces[result.root].vertices) ** 0.5 / 20), 2, 4))
    shades = pipeline.map_colors(result.surfaces, result.maps, cells)
    hues = landmark_colors(result.landmarks.shape[1])
    layers = {kind: [] for kind in kinds}

    def add(kind, label, *mesh):
        path = kinds[kind] / (label.replace(" ", "_") + ".ply")
        files.write_ply(path, *mesh)
        layers[kind].append(files.ProjectLayer(label, path, kind == "surfaces"))

    for surface, sphere, points, colors in zip(result.surfaces, result.maps, result.landmarks, shades):
        add("surfaces", surface.name, surface.vertices, surface.faces, colors, sphere.texture)
        add("landmarks", f"{surface.name} landmarks", points, result.landmark_faces, hues)
        add("spheres", f"{surface.name} sphere", sphere.positions, surface.faces, colors)
    files.write_project(base / f"{name}.mlp", layers["surfaces"] + layers["landmarks"] + layers["spheres"])
    files.write_project(base / f"{name}_overview.mlp", overview(row, layers))


def overview(row: pictures.Row, layers) -> List[files.ProjectLayer]:
    """Surfaces in a grid, landmarks in a grid beside it, the root's sphere between the two; upright, as MeshLab looks at it."""
    result = row.result
    rotation = pictures.upright(result.surfaces[result.root].vertices, row.up)
    seen = [surface.vertices @ rotation.T for surface in result.surfaces]
    low, high = np.min([v.min(0) for v in seen], 0), np.max([v.max(0) for v in seen], 0)
    step = 1.12 * (high - low)[:2]
    columns = int(np.ceil(np.sqrt(0.5 * len(seen) * step[1] / step[0])))  # the two grids side by side make a square
    lines = -(-len(seen) // columns)
    radius = min(1.2 * step[0], 0.5 * lines * step[1])
    center = (low + high) / 2

    def placed(layer, turn, *where):
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = turn, where
        return layer._replace(visible=True, matrix=matrix)

    found = []
    for kind, start in (("surfaces", -radius - step[0] * columns), ("landmarks", radius + 0.2 * step[0])):
        for i, layer in enumerate(layers[kind]):
            x, y = start + (i % columns + 0.5) * step[0], (0.5 * (lines - 1) - i // columns) * step[1]
            found.append(placed(layer, rotation, x - center[0], y - center[1], -center[2]))
    turn = pictures.sphere_rotation(result.surfaces[result.root].vertices @ rotation.T, result.maps[result.root].positions)
    found.append(placed(layers["spheres"][result.root], 0.9 * radius * turn, 0, 0, 0))
    return found
