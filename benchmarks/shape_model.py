#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Prints what the filter "Build statistical shape model" costs as a whole, through PyMeshLab, by
number of shapes: alignment, modes, generalisation, specificity, the layer of the mean.

    shape_model.py [SHAPES ...]

    SHAPES    numbers of shapes (default 100 500 2000)

The shapes are made: 1002 landmarks of an ellipsoid that varies along 60 smooth directions, the m-th
by 0.9^m, with noise of 0.2 mm, so that all modes are there.
"""

import sys
import time

import numpy as np
import pymeshlab
from setting import PLUGIN

FREQUENCY = 10
DIRECTIONS, NOISE = 60, 0.2  # mm


def icosphere():
    """Vertices and faces as "Remesh by icosphere" has them."""
    project = pymeshlab.MeshSet()
    project.apply_filter("create_ventricle_phantom", phases=1, voxel_size=4.0)
    project.apply_filter("compute_spherical_parameterisation_root")
    project.apply_filter("generate_icosphere_remeshing", frequency=FREQUENCY)
    sphere = list(project)[-1]
    return sphere.vertex_matrix(), sphere.face_matrix()


def population(points, shapes, seed=1):
    """(shapes, landmarks, 3), mm."""
    rng = np.random.default_rng(seed)
    centre = points - points.mean(0)
    unit = centre / np.linalg.norm(centre, axis=1).max()
    directions = []
    for m in range(DIRECTIONS):
        waves = unit @ rng.standard_normal(3) * (1 + m / 10) + 3 * rng.standard_normal()
        directions.append(np.sin(waves)[:, None] * rng.standard_normal(3) * 3 * 0.9**m)
    scores = rng.standard_normal((shapes, DIRECTIONS))
    varied = np.tensordot(scores, np.array(directions), 1)
    return centre + varied + NOISE * rng.standard_normal((shapes, *points.shape))


def cost(points, faces, **parameters):
    """Wall clock and CPU, s, and how many modes there are."""
    project = pymeshlab.MeshSet()
    for k, shape in enumerate(points):
        project.add_mesh(pymeshlab.Mesh(shape, faces), f"shape {k}")
    wall, cpu = time.perf_counter(), time.process_time()
    modes = project.apply_filter("compute_statistical_shape_model", mode_layers=0, **parameters)
    return time.perf_counter() - wall, time.process_time() - cpu, modes["modes"]


def main():
    pymeshlab.load_plugin(str(PLUGIN))
    points, faces = icosphere()
    print(
        "| shapes | all modes: wall, CPU (s) | ten modes: wall, CPU (s) |\n| --- | --- | --- |",
        flush=True,
    )
    for shapes in map(int, sys.argv[1:] or (100, 500, 2000)):
        sample = population(points, shapes)
        cells = [
            "{:.1f}, {:.1f} ({} modes)".format(*cost(sample, faces, modes=modes))
            for modes in (0, 10)
        ]
        print(f"| {shapes} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
