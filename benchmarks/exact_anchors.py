#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Prints whether maps hold anchors exactly, and stay valid, where these are moved far.

    exact_anchors.py [DATA]

    DATA    folder with heart_cine, finch_skulls and classic (default SPHERE_PROPAGATION_DATA, else
            ../shared/data)

Six anchors as far apart as can be on the root, carried to each layer by maps made without any, then
moved along the layer by a share of the diagonal of its box: each in a direction of its own, or all
turned about the longest axis of the box, one end against the other.
"""

import time

import numpy as np
import pymeshlab
from anchors import far_apart
from main_job import load_layers
from setting import PLUGIN, given_data

PROPAGATE = "transfer_spherical_parameterisation_to_layers"
ANCHORS = 6
FAILED = []  # PyMeshLab goes on writing into the log of a project in which something failed


def positions(mesh):
    return mesh.vertex_custom_point_attribute_matrix("sphere_position")


def in_face(faces, points, place, random):
    """A point within the face whose middle is nearest to a place: its face and weights."""
    face = int(((points[faces].mean(1) - place) ** 2).sum(1).argmin())
    return face, random.dirichlet((4.0, 4.0, 4.0))


def at(faces, points, face, weights):
    return weights @ points[faces[face]]


def moved(points, place, way, share, random):
    low, high = points.min(0), points.max(0)
    length = share * np.linalg.norm(high - low)
    if way == "at random":
        direction = random.standard_normal(3)
        return place + length * direction / np.linalg.norm(direction)
    axis = int((high - low).argmax())
    a, b = (axis + 1) % 3, (axis + 2) % 3
    middle = (low + high) / 2
    radius = np.linalg.norm((high - low)[[a, b]]) / 2
    angle = 2 * (place - middle)[axis] / (high - low)[axis] * length / radius
    turned = place.copy()
    x, y = (place - middle)[[a, b]]
    turned[a] = middle[a] + np.cos(angle) * x - np.sin(angle) * y
    turned[b] = middle[b] + np.sin(angle) * x + np.cos(angle) * y
    return turned


def hold(files, order, way, share, seed):
    """Refusals, flips, the worst distance in radians, by how many degrees the angle error grows at
    most, CPU seconds, for the layers behind the root."""
    random = np.random.default_rng(seed)
    project = load_layers(files)
    project.apply_filter("compute_spherical_parameterisation_root")
    plain = project.apply_filter(PROPAGATE, order=order, anchors="Off")
    root = project.mesh(0)
    faces, sphere = root.face_matrix(), positions(root)
    chosen = far_apart(root.vertex_matrix(), ANCHORS)
    ways = {0: [(int(np.where((faces == v).any(1))[0][0]), np.full(3, 1 / 3)) for v in chosen]}
    targets = [at(faces, sphere, *there) for there in ways[0]]
    for i in range(1, project.mesh_number()):
        mesh = project.mesh(i)
        f, v, s = mesh.face_matrix(), mesh.vertex_matrix(), positions(mesh)
        ways[i] = []
        for target in targets:
            carried = at(f, v, *in_face(f, s, target / np.linalg.norm(target), random))
            ways[i].append(in_face(f, v, moved(v, carried, way, share, random), random))
    for i, its in ways.items():
        mesh = project.mesh(i)
        f, v = mesh.face_matrix(), mesh.vertex_matrix()
        for k, there in enumerate(its):
            mesh.add_vertex_custom_point_attribute(
                np.tile(at(f, v, *there), (len(v), 1)), f"anchor_{k}"
            )
    start = time.process_time()
    try:
        held = project.apply_filter(PROPAGATE, order=order, anchors="Exact")
    except pymeshlab.PyMeshLabException as error:
        FAILED.append(project)
        return str(error).strip().splitlines()[-1]
    seconds = time.process_time() - start
    worst = 0.0
    for i, its in ways.items():
        f, s = project.mesh(i).face_matrix(), positions(project.mesh(i))
        for there, target in zip(its, targets):
            place = at(f, s, *there)
            worst = max(worst, np.linalg.norm(np.cross(place, target)))
    growth = (held["angle_error_mean"] - plain["angle_error_mean"])[1:].max()
    return int(held["flipped_faces"].sum()), worst, growth, seconds


def main():
    data = given_data()
    pymeshlab.load_plugin(str(PLUGIN))
    sets = {
        "heart cycle": (sorted((data / "heart_cine").glob("*.ply"))[::3], "Time"),
        "skulls": (sorted((data / "finch_skulls").glob("*.ply")), "Star"),
    }
    for file in sorted((data / "classic").glob("*.ply")):
        sets[file.stem] = ([file, file], "Time")
    print("| layers | moved | seed | flips | worst (rad) | angle error grows by | CPU s |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for name, (files, order) in sets.items():
        for way in ("at random", "as a twist"):
            for share in (0.1, 0.2):
                for seed in range(2 if way == "at random" else 1):
                    found = hold(files, order, way, share, seed)
                    if isinstance(found, str):
                        words = f"{found} | | |"
                    else:
                        flips, worst, growth, seconds = found
                        words = f"{flips} | {worst:.0e} | {growth:.1f} | {seconds:.1f}"
                    print(f"| {name} | {share:.0%} {way} | {seed} | {words} |", flush=True)


if __name__ == "__main__":
    main()
