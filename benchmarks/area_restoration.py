#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Prints the table of docs/area_restoration.md: what even areas cost in landmark error, on the
phantom.

    area_restoration.py [DATA]

    DATA    folder with the real hearts, beside which the yardstick lies
            (default SPHERE_PROPAGATION_DATA, else ../shared/data)

Area sd: the mean over the phases; landmark error: worst and mean over the phases. Cyclic order,
root 0, 25 phases; measured by the yardstick from what the filters stored.
"""

import tempfile
from pathlib import Path

import numpy as np
import pymeshlab
from main_job import load_layers, stored_figures
from setting import PLUGIN, given_data, yardstick

AMOUNTS = (0.0, 0.5, 1.0)
PARTS = ("cavity", "wall")


def cells(measure, ventricle, files, amount):
    project = load_layers(files)
    project.apply_filter("compute_spherical_parameterisation_root")
    project.apply_filter(
        "transfer_spherical_parameterisation_to_layers",
        order="Cyclic time",
        area_restoration=amount,
    )
    project.apply_filter("generate_icosphere_remeshing")
    count = len(files)
    landmarks = [project.mesh(count + i).vertex_matrix() for i in range(count)]
    deviation = np.mean([stored_figures(measure, project, i)["sd"] for i in range(count)])
    errors = ventricle.errors(landmarks)
    return [f"{deviation:.3f}", f"{max(errors):.2f} / {np.mean(errors):.2f}"]


def main():
    measure, phantom = yardstick(given_data())
    pymeshlab.load_plugin(str(PLUGIN))
    found = {amount: [] for amount in AMOUNTS}
    for part in PARTS:
        ventricle = phantom.Ventricle(part)
        with tempfile.TemporaryDirectory() as folder:
            files = [Path(folder) / f"{t:02d}.ply" for t in range(ventricle.phases)]
            for t, file in enumerate(files):
                phantom.write_ply(file, *ventricle.mesh(t))
            for amount in AMOUNTS:
                found[amount] += cells(measure, ventricle, files, amount)
    header = ["`area_restoration`"]
    for part in PARTS:
        header += [f"{part}: area sd, mean", "landmark error, worst / mean (mm)"]
    print("| " + " | ".join(header) + " |")
    print("| " + " | ".join(["---"] * len(header)) + " |")
    for amount in AMOUNTS:
        print("| " + " | ".join([f"{amount:g}", *found[amount]]) + " |", flush=True)


if __name__ == "__main__":
    main()
