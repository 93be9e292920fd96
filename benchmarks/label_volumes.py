#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Prints the tables of docs/label_volumes.md: label volumes of real hearts, through PyMeshLab.

    label_volumes.py [DATA]

    DATA    folder with heart_cine and heart_truth
            (default SPHERE_PROPAGATION_DATA, else ../shared/data)

Genus, volume and distances are measured by PyMeshLab and SciPy on the layers; what is said of the
labels is the filter's.
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pymeshlab
from scipy.spatial import cKDTree
from setting import PROJECT, VOLUME_PLUGIN, given_data

sys.path.insert(0, str(PROJECT / "tests/volumes"))
import volume_files

VOLUMES = (
    ("heart_cine/labels_4d_raw.nii.gz", ("1", "2")),
    ("heart_truth/labels_4d_1.5mm.nii.gz", ("1", "2", "1,2")),
)
THICK_PHASES = 8  # every so many of heart_truth are measured in thick slices


def imported(path, labels):
    """The layers, what the filter returns, and the seconds of the processor."""
    start = time.process_time()
    meshes = pymeshlab.MeshSet()
    returned = meshes.apply_filter(
        "create_layers_from_label_volume", file_name=str(path), labels=labels
    )
    return meshes, returned, time.process_time() - start


def measured(meshes):
    """Genus and volume (ml) of every layer."""
    found = []
    for mesh in meshes:
        one = pymeshlab.MeshSet()
        one.add_mesh(mesh)
        topology = one.apply_filter("get_topological_measures")
        assert (
            topology["is_mesh_two_manifold"]
            and topology["boundary_edges"] == 0
            and topology["connected_components_number"] == 1
        )
        found.append(
            (topology["genus"], one.apply_filter("get_geometric_measures")["mesh_volume"] / 1000)
        )
    return np.array(found).T


def distances(a, b):
    """Mean distance of each vertex to the other's nearest, both ways."""
    return cKDTree(b).query(a)[0].mean(), cKDTree(a).query(b)[0].mean()


def row(path, labels):
    meshes, returned, seconds = imported(path, labels)
    genus, volume = measured(meshes)
    share = 1000 * volume / returned["label_volume"]
    return (
        f"| {path.parent.name} | {labels} | {len(genus)}, {int((genus == 0).sum())} | "
        f"{volume[0]:.1f} / {volume.min():.1f} | {share.min():.3f} to {share.max():.3f} | "
        f"{returned['vertices'].mean():.0f} | {returned['handles'].sum():.0f} | "
        f"{returned['changed_voxels'].max():.0f} | {seconds:.1f} |"
    )


def against_given_surfaces(data):
    found = []
    for phase, mesh in enumerate(imported(data / VOLUMES[0][0], "1")[0]):
        given = pymeshlab.MeshSet()
        given.load_new_mesh(str(data / f"heart_cine/endo_{phase:02d}.ply"))
        found.append(distances(mesh.vertex_matrix(), given.current_mesh().vertex_matrix()))
    return np.array(found)


def thick_against_thin_slices(data, step=7):
    labels, matrix = volume_files.read_nifti(data / VOLUMES[1][0])
    layers = []
    with tempfile.TemporaryDirectory() as folder:
        for every in (1, step):
            path = Path(folder) / f"{every}.nii"
            path.write_bytes(
                volume_files.nifti(
                    np.ascontiguousarray(labels[:, :, ::every, 0]),
                    matrix @ np.diag([1, 1, every, 1]),
                )
            )
            meshes, *_ = imported(path, "2")  # kept until its layer is copied
            layers.append(meshes.current_mesh().vertex_matrix())
        return distances(*layers)


def surface_distance(a, b):
    """Mean distance of points on each of two layers from the other, both ways."""
    found = []
    for sampled, target in ((a, b), (b, a)):
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(target)
        meshes.add_mesh(sampled)
        found.append(
            meshes.apply_filter(
                "get_hausdorff_distance",
                sampledmesh=1,
                targetmesh=0,
                samplevert=False,
                sampleface=True,
                samplenum=20000,
            )["mean"]
        )
    return np.mean(found)


def against_all_slices(data, label, step, first, align):
    """Phases of heart_truth from every step-th slice against those from all slices: distances (mm)
    and volumes as shares."""
    labels, matrix = volume_files.read_nifti(data / VOLUMES[1][0])
    labels = labels[..., ::THICK_PHASES]
    sets = []
    with tempfile.TemporaryDirectory() as folder:
        for start, every in ((0, 1), (first, step)):
            place = matrix @ np.diag([1, 1, every, 1])
            place[:, 3] += start * matrix[:, 2]
            path = Path(folder) / f"{every}.nii"
            path.write_bytes(
                volume_files.nifti(np.ascontiguousarray(labels[:, :, start::every]), place)
            )
            meshes = pymeshlab.MeshSet()
            meshes.apply_filter(
                "create_layers_from_label_volume",
                file_name=str(path),
                labels=label,
                align_slices=align and every > 1,
            )
            sets.append(meshes)
        thin, thick = sets
        distances = [surface_distance(a, b) for a, b in zip(thick, thin)]
        volumes = measured(thick)[1] / measured(thin)[1]
    return np.array(distances), volumes


def thick_rows(data):
    """heart_truth in thick slices, from which its slices begin at two places."""
    print(
        "\n| label | slices (mm) | align_slices | mean distance (mm) | worst phase | volume, mean "
        "| phases |\n" + "| --- " * 7 + "|"
    )
    for label in ("1", "2"):
        for step in (5, 7, 8):
            for align in (False, True):
                parts = [against_all_slices(data, label, step, first, align) for first in (0, 3)]
                distances, volumes = map(np.concatenate, zip(*parts))
                print(
                    f"| {label} | {1.5 * step:g} | {'yes' if align else 'no'} | "
                    f"{distances.mean():.2f} | {distances.max():.2f} | {volumes.mean():.3f} | "
                    f"{volumes.min():.3f} to {volumes.max():.3f} |",
                    flush=True,
                )


def main(data):
    pymeshlab.load_plugin(str(VOLUME_PLUGIN))
    print(
        "| data | label | phases, of genus 0 | volume (ml), first / smallest | surface / voxels | "
        "vertices, mean | handles | voxels changed, most in a phase | s |\n" + "| --- " * 9 + "|"
    )
    for name, every in VOLUMES:
        for labels in every:
            print(row(data / name, labels), flush=True)
    given = against_given_surfaces(data)
    print(
        f"\nheart_cine against endo_TT.ply: {given[:, 0].mean():.2f} and {given[:, 1].mean():.2f} "
        f"mm, worst phase {given.max():.2f} mm"
    )
    thick_rows(data)
    print(
        "\nheart_truth's wall, thin slices against every seventh: {:.2f} and {:.2f} mm".format(
            *thick_against_thin_slices(data)
        )
    )


if __name__ == "__main__":
    main(given_data())
