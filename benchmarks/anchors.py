#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Prints what anchors do for landmarks on a real heart whose truth is known, through PyMeshLab.

    anchors.py [DATA]

    DATA    folder with heart_truth (default SPHERE_PROPAGATION_DATA, else ../shared/data)

Anchors are material points of the truth, as far apart as can be, with normal noise per coordinate
on every phase. Errors are of all landmarks, in mm, worst phase / mean, averaged over the seeds.
"""

import time

import numpy as np
import pymeshlab
from main_job import load_layers
from setting import PLUGIN, given_data, yardstick

# Anchors, noise (mm), seeds, what is asked of the filter.
RUNS = [
    (0, 0.0, 1, {}),
    (6, 1.0, 3, {"anchors": "Soft", "anchor_sd": 1.0}),
    (6, 1.0, 3, {"anchors": "Soft"}),
    (6, 1.0, 3, {"anchors": "Exact", "anchor_sd": 1.0}),
    (6, 0.0, 1, {"anchors": "Soft"}),
    (6, 0.0, 1, {"anchors": "Exact"}),
    (12, 0.0, 1, {"anchors": "Exact"}),
    (12, 1.0, 3, {"anchors": "Soft", "anchor_sd": 1.0}),
    (3, 1.0, 3, {"anchors": "Soft", "anchor_sd": 1.0}),
]


def far_apart(points, count):
    """Vertices, each as far from those before as can be."""
    chosen = [int(points[:, 2].argmin())]
    while len(chosen) < count:
        distance = np.linalg.norm(points[:, None] - points[chosen][None], axis=2).min(1)
        chosen.append(int(distance.argmax()))
    return chosen


def with_anchors(files, truth, count, noise, seed):
    """The project with a map of its first layer."""
    project = load_layers(files)
    project.apply_filter("compute_spherical_parameterisation_root")
    random = np.random.default_rng(seed)
    chosen = far_apart(truth[0][0], count) if count else []
    for mesh, (vertices, _) in zip(project, truth):
        for k, v in enumerate(chosen):
            place = vertices[v] + noise * random.standard_normal(3)
            mesh.add_vertex_custom_point_attribute(
                np.tile(place, (mesh.vertex_number(), 1)), f"anchor_{k:02d}"
            )
    return project


def main():
    data = given_data()
    measure, _ = yardstick(data)
    pymeshlab.load_plugin(str(PLUGIN))
    truth = [
        (measure.points(v), f)
        for v, f in map(measure.read_ply, sorted((data / "heart_truth/truth").glob("*.ply")))
    ]
    files = sorted((data / "heart_truth/mc").glob("*.ply"))
    print("| anchors | noise (mm) | asked | worst / mean error (mm) | flips | CPU s |")
    print("| --- | --- | --- | --- | --- | --- |")
    for count, noise, seeds, asked in RUNS:
        worst, mean, flips, seconds = [], [], 0, []
        for seed in range(seeds):
            project = with_anchors(files, truth, count, noise, seed)
            start = time.process_time()
            returned = project.apply_filter(
                "transfer_spherical_parameterisation_to_layers", order="Cyclic time", **asked
            )
            seconds.append(time.process_time() - start)
            flips += int(returned["flipped_faces"].sum())
            project.apply_filter("generate_icosphere_remeshing")
            landmarks = [project.mesh(len(files) + i).vertex_matrix() for i in range(len(files))]
            errors = [e.mean() for e in measure.truth_errors(truth, landmarks)]
            worst.append(max(errors))
            mean.append(np.mean(errors))
        words = ", ".join(f"{k} {v}" for k, v in asked.items()) or "none"
        print(
            f"| {count} | {noise:g} | {words} | {np.mean(worst):.2f} / {np.mean(mean):.2f} | "
            f"{flips} | {np.mean(seconds):.1f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
