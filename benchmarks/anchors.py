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
    (6, 0.0, 1, {"anchors": "Exact", "anchor_sd": 0.3}),
    (12, 0.0, 1, {"anchors": "Exact", "anchor_sd": 0.3}),
    (12, 1.0, 3, {"anchors": "Soft", "anchor_sd": 1.0}),
    (3, 1.0, 3, {"anchors": "Soft", "anchor_sd": 1.0}),
    (3, 1.0, 3, {"anchors": "Soft", "anchor_sd": 1.0, "anchor_pose": True}),
    (6, 1.0, 3, {"anchors": "Soft", "anchor_sd": 1.0, "anchor_pose": True}),
    (6, 0.0, 1, {"anchors": "Soft", "anchor_pose": True}),
    (6, 0.0, 1, {"anchors": "Exact", "anchor_pose": True}),
    (12, 0.0, 1, {"anchors": "Exact", "anchor_pose": True}),
]
# The same with a twist of so many degrees from the lowest to the highest point added, as it grows
# and falls over the cycle.
TWIST = 40.0
TWISTED = [
    (0, 0.0, 1, {}),
    (6, 1.0, 3, {"anchors": "Soft", "anchor_sd": 1.0}),
    (6, 1.0, 3, {"anchors": "Soft", "anchor_sd": 1.0, "anchor_pose": True}),
    (12, 1.0, 3, {"anchors": "Soft", "anchor_sd": 1.0, "anchor_pose": True}),
]


def far_apart(points, count):
    """Vertices, each as far from those before as can be."""
    chosen = [int(points[:, 2].argmin())]
    while len(chosen) < count:
        distance = np.linalg.norm(points[:, None] - points[chosen][None], axis=2).min(1)
        chosen.append(int(distance.argmax()))
    return chosen


def with_anchors(files, truth, count, noise, seed, twist=None):
    """The project with a map of its first layer. twist: of points and the number of their phase."""
    project = load_layers(files)
    if twist:
        surfaces = [(mesh.vertex_matrix(), mesh.face_matrix()) for mesh in project]
        project = pymeshlab.MeshSet()
        for phase, (points, faces) in enumerate(surfaces):
            project.add_mesh(pymeshlab.Mesh(twist(points, phase), faces), f"phase {phase:02d}")
        project.set_current_mesh(0)
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


def twisted(points, phase, phases, low, high, middle):
    """Points of a phase, turned about the vertical axis by their height and the time."""
    grown = np.radians(TWIST) * np.sin(np.pi * phase / phases) ** 2
    angle = grown * (points[:, 2] - low) / (high - low)
    x, y = (points[:, :2] - middle).T
    c, s = np.cos(angle), np.sin(angle)
    turned = np.stack([c * x - s * y, s * x + c * y], 1) + middle
    return np.column_stack([turned, points[:, 2]])


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
    low, high = truth[0][0][:, 2].min(), truth[0][0][:, 2].max()
    middle = truth[0][0][:, :2].mean(0)

    def twist(points, phase):
        return twisted(points, phase, len(files), low, high, middle)

    as_it_is, turned = truth, [(twist(v, i), f) for i, (v, f) in enumerate(truth)]
    runs = [(*run, None) for run in RUNS] + [(*run, twist) for run in TWISTED]
    for count, noise, seeds, asked, way in runs:
        truth = turned if way else as_it_is
        worst, mean, flips, seconds = [], [], 0, []
        for seed in range(seeds):
            project = with_anchors(files, truth, count, noise, seed, way)
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
        words += f", twist of {TWIST:g} degrees" if way else ""
        print(
            f"| {count} | {noise:g} | {words} | {np.mean(worst):.2f} / {np.mean(mean):.2f} | "
            f"{flips} | {np.mean(seconds):.1f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
