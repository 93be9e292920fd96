# SPDX-License-Identifier: GPL-3.0-only
"""Writes the sample: five phases of a small beating ventricle, as they come from a segmentation and
as they end. Run by scripts/make-sample."""

import dataclasses
import math
import shutil
import sys
from pathlib import Path

import sphere_propagation as sp
from sphere_propagation.files import write_ply
from sphere_propagation.project_file import ProjectLayer, write_project
from sphere_propagation.results import LIST
from sphere_propagation.views import Row, upright

surfaces = sp.make_phantom(phases=5, voxel_size=3.5)
# Upright and towards the camera, as MeshLab looks at it; all by the same rotation.
rotation = upright(surfaces[0].vertices, (0, 0, 1))
surfaces = [
    dataclasses.replace(surface, name=f"ventricle {i}", vertices=surface.vertices @ rotation.T)
    for i, surface in enumerate(surfaces)
]
result = sp.correspond(surfaces, root=0, order="Cyclic time", frequency=5)

# To work on: surfaces, nothing else.
folder = Path(sys.argv[1]) / "ventricle"
shutil.rmtree(folder, ignore_errors=True)
(folder / "surfaces").mkdir(parents=True)
layers = []
for surface in surfaces:
    path = folder / "surfaces" / (surface.name.replace(" ", "_") + ".ply")
    write_ply(path, surface.vertices, surface.faces)
    layers.append(ProjectLayer(surface.name, path))
write_project(folder / "ventricle.mlp", layers)

# Anchors, as MeshLab's Pick Points saves them: tissue that the phantom's formula follows. In a
# folder of their own: beside the surfaces they would be taken without being asked for.
ventricle = sp.Ventricle(phases=len(surfaces))
tissue = {"apex": (0, 0), "front": (0.6, 0), "left": (0.6, 2.1), "right": (0.6, 4.2)}  # u, theta
(folder / "anchors").mkdir()
for phase, surface in enumerate(surfaces):
    lines = []
    for name, (u, theta) in tissue.items():
        place = ventricle.position(u, theta, 0, phase) @ rotation.T
        x, y, z = min(surface.vertices.tolist(), key=lambda point: math.dist(point, place))
        lines.append(f'    <point x="{x:.5f}" y="{y:.5f}" z="{z:.5f}" active="1" name="{name}"/>')
    text = "\n".join(["<!DOCTYPE PickedPoints>", "<PickedPoints>", *lines, "</PickedPoints>", ""])
    (folder / "anchors" / f"ventricle_{phase}_picked_points.pp").write_text(text)

# To look at: what the filters make of it, side by side.
sp.write_layers(folder, "finished", Row("finished", result, up=rotation @ (0, 0, 1)))
made = folder / "finished"
(made / "finished_overview.mlp").replace(made / "finished.mlp")
(made / LIST).unlink()
for path in sorted((made / "spheres").glob("*.ply"))[1:]:  # the root's tells enough
    path.unlink()
