#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Prints the README's table: the main job on real hearts and on the phantom, through PyMeshLab.

    main_job.py [DATA]

    DATA    folder with heart_cine and heart_truth
            (default SPHERE_PROPAGATION_DATA, else ../shared/data)

Maps and correspondences are measured by DATA/../yardstick, from what the filters stored, not by the
filters' own figures.
"""

import tempfile
import time
from pathlib import Path

import numpy as np
import pymeshlab
from setting import PLUGIN, given_data, yardstick


def load_layers(files):
    project = pymeshlab.MeshSet()
    for file in files:
        project.load_new_mesh(str(file))
    project.set_current_mesh(0)
    return project


def run_main_job(files, method, order):
    """The project after the three filters, the landmarks of each layer, and the seconds it took
    with loading."""
    start = time.perf_counter()
    project = load_layers(files)
    project.apply_filter("compute_spherical_parameterisation_root")
    project.apply_filter(
        "transfer_spherical_parameterisation_to_layers", method=method, order=order
    )
    project.apply_filter("generate_icosphere_remeshing")
    seconds = time.perf_counter() - start
    count = len(files)
    return project, [project.mesh(count + i).vertex_matrix() for i in range(count)], seconds


def stored_figures(measure, project, layer):
    mesh = project.mesh(layer)
    return measure.map_figures(
        mesh.vertex_matrix(),
        mesh.face_matrix(),
        mesh.vertex_custom_point_attribute_matrix("sphere_position"),
    )


def row(name, measure, files, method, order, errors):
    project, landmarks, seconds = run_main_job(files, method, order)
    figures = [stored_figures(measure, project, i) for i in range(len(files))]
    error = errors(landmarks) if errors else None
    cells = [
        name,
        str(len(files)),
        method,
        order,
        f"{figures[0]['sd']:.4f} / {figures[0]['angle']:.1f}°",
        str(sum(f["flips"] for f in figures)),
        f"{max(error):.2f} / {np.mean(error):.2f}" if error else "",
        f"{seconds:.1f}",
    ]
    print("| " + " | ".join(cells) + " |", flush=True)


def main():
    data = given_data()
    measure, phantom = yardstick(data)
    pymeshlab.load_plugin(str(PLUGIN))
    print(
        "| data | layers | method | order | root: area sd / angle error | flipped faces, all "
        "layers | landmark error, worst / mean (mm) | seconds |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    methods = ["As published", "Robust"]
    truth = [
        (measure.points(v), f)
        for v, f in map(measure.read_ply, sorted((data / "heart_truth/truth").glob("*.ply")))
    ]
    real = sorted((data / "heart_truth/mc").glob("*.ply"))
    for method in methods:
        row(
            "real patient with known truth",
            measure,
            real,
            method,
            "Cyclic time",
            lambda landmarks: [e.mean() for e in measure.truth_errors(truth, landmarks)],
        )
    cine = sorted((data / "heart_cine").glob("endo_*.ply"))
    for method in methods:
        row("real patient, cine", measure, cine, method, "Cyclic time", None)
    for part in ("cavity", "wall"):
        ventricle = phantom.Ventricle(part)
        with tempfile.TemporaryDirectory() as folder:
            files = [Path(folder) / f"{t:02d}.ply" for t in range(ventricle.phases)]
            for t, file in enumerate(files):
                phantom.write_ply(file, *ventricle.mesh(t))
            for method in methods:
                row(f"phantom, {part}", measure, files, method, "Cyclic time", ventricle.errors)


if __name__ == "__main__":
    main()
