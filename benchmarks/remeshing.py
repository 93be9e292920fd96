#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Prints what the filter "Remesh by icosphere" costs as a whole, through PyMeshLab: reading the
layers, certifying their maps, landmarks, distances, writing the new layers; and how far landmark
meshes are from the phantom's surfaces, by their number (the table of docs/remeshing.md).

    remeshing.py [DATA]

    DATA    folder with heart_cine and heart_truth
            (default SPHERE_PROPAGATION_DATA, else ../shared/data)

Milliseconds of a run that replaces earlier landmarks, the least of ten. scripts/measure-propagation
prints the core's part, in the unit u, too.
"""

import time

import pymeshlab
from main_job import load_layers
from setting import PLUGIN, given_data

VERTICES = 3500  # what the paper's layers have, about
FREQUENCIES = (5, 10, 20, 40)


def mapped(files, vertices):
    """A project whose layers all have a map; vertices: to which number they are decimated, None: as
    they are."""
    project = load_layers(files)
    for i in range(len(files) if vertices else 0):
        project.set_current_mesh(i)
        project.apply_filter(
            "meshing_decimation_quadric_edge_collapse",
            targetfacenum=2 * vertices - 4,
            preservetopology=True,
        )
    project.set_current_mesh(0)
    project.apply_filter("compute_spherical_parameterisation_root")
    project.apply_filter("transfer_spherical_parameterisation_to_layers", order="Cyclic time")
    return project


def cost(project, threads):
    """Wall clock and CPU, ms."""
    runs = []
    for _ in range(10):
        wall, cpu = time.perf_counter(), time.process_time()
        project.apply_filter("generate_icosphere_remeshing", threads=threads)
        runs.append((1000 * (time.perf_counter() - wall), 1000 * (time.process_time() - cpu)))
    return [min(run[i] for run in runs) for i in (0, 1)]


def mapped_phantom(part):
    project = pymeshlab.MeshSet()
    project.apply_filter("create_ventricle_phantom", part=part)
    project.set_current_mesh(0)
    project.apply_filter("compute_spherical_parameterisation_root")
    project.apply_filter("transfer_spherical_parameterisation_to_layers", order="Cyclic time")
    return project


def distances(project, frequency):
    """Of landmark meshes from their surfaces, mm: the mean over all layers, and the largest."""
    figures = project.apply_filter("generate_icosphere_remeshing", frequency=frequency)
    mean, largest = figures["surface_distance_mean"].mean(), figures["surface_distance_max"].max()
    return f"{mean:.2f} / {largest:.2f}"


def main():
    data = given_data()
    pymeshlab.load_plugin(str(PLUGIN))
    print(
        "| data | layers | vertices, mean | one thread: wall, CPU (ms) | all threads: wall, CPU "
        "(ms) |\n| --- | --- | --- | --- | --- |"
    )
    data_sets = (
        ("real patient with known truth", "heart_truth/mc/*.ply"),
        ("real patient, cine", "heart_cine/endo_*.ply"),
    )
    for name, pattern in data_sets:
        for vertices in (VERTICES, None):
            files = sorted(data.glob(pattern))
            project = mapped(files, vertices)
            mean = sum(project.mesh(i).vertex_number() for i in range(len(files))) / len(files)
            cells = ["{:.0f}, {:.0f}".format(*cost(project, threads)) for threads in (1, 0)]
            print(
                "| " + " | ".join([name, str(len(files)), f"{mean:.0f}", *cells]) + " |", flush=True
            )
    print("\n| landmarks | cavity, mean / largest (mm) | wall, mean / largest (mm) |")
    print("| --- | --- | --- |")
    projects = [mapped_phantom(part) for part in ("Cavity", "Wall")]
    for frequency in FREQUENCIES:
        landmarks = f"{10 * frequency**2 + 2} (`frequency` {frequency})"
        cells = [distances(project, frequency) for project in projects]
        print("| " + " | ".join([landmarks, *cells]) + " |", flush=True)


if __name__ == "__main__":
    main()
