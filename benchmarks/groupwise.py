#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-only
"""Prints the table of docs/groupwise.md: populations whose true correspondence is known, through
PyMeshLab, with every parameter of the filters as it comes, but for one column.

    groupwise.py [DATA] [NAME ...]
    groupwise.py [DATA] --restored [NAME ...]
    groupwise.py [DATA] --anchors NAME ...
    groupwise.py [DATA] --measures NAME ...
    groupwise.py [DATA] --phases PART ...
    groupwise.py [DATA] --skulls
    groupwise.py [DATA] --many N ...

    DATA    folder with classic and finch_skulls
            (default SPHERE_PROPAGATION_DATA, else ../shared/data)
    NAME    rows to print: bump, ellipsoids, skull, hippocampus, "other skull", head (default: all)
    --restored  propagated with area_restoration 1
    --anchors   what six points whose truth is known do, in groupwise alone and in propagation, too
    --measures  what compactness, generalisation and specificity say of one mode, between landmarks
            and between surfaces, of the truth, after propagation and after each objective
    --phases    what to do with phases of several subjects: PART cavity or wall (made_motions.py)
    --skulls    what the model of the real skulls is said to be, between surfaces
    --many  what N shapes cost instead (warped hippocampi of 3000 vertices, of one mesh)

Every shape is meshed anew, so that its vertices say nothing, with noise of a twentieth of the mean
edge along the normals. The error is that of all ordered pairs (s, t): the mean distance, by area,
of the landmarks of t from where the truth carries those of s; measured by DATA/../yardstick.
"""

import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pymeshlab
import sphere_propagation as sp
from made_motions import Ventricle, meshed
from setting import DATA, yardstick

SHAPES = 16
FREQUENCY = 10  # of the landmarks


class Population:
    """shapes: vertices of each, all with the same faces."""

    def __init__(self, shapes, faces):
        self.shapes, self.faces = shapes, faces

    def at(self, k):
        return self.shapes[k], self.faces


def sphere(frequency):
    made = pymeshlab.MeshSet()
    made.create_sphere(radius=1, subdiv=frequency)
    mesh = made.current_mesh()
    directions = mesh.vertex_matrix()
    return directions / np.linalg.norm(directions, axis=1, keepdims=True), mesh.face_matrix()


def bump(random):
    """The box of Davies with a bump that slides along it: one mode, which is linear."""
    u, faces = sphere(5)
    r = (u**4).sum(1) ** -0.25  # a rounded cube, stretched to a bar
    x = u * r[:, None] * [30, 10, 10]
    x[:, 2] *= np.where(x[:, 2] < 0, 1 + 0.4 * x[:, 0] / 30, 1)  # tapers: no symmetry to fall for
    height = u[:, 2] * r
    top = 1 / (1 + np.exp(-(height - 0.75) / 0.05))
    along, across = x[:, 0], x[:, 1]
    bulge = 8 * np.exp(-((along / 5) ** 4) - (across / 6) ** 4) * top
    slide = np.clip((29 - np.abs(along)) / 21, 0, 1) * np.clip((height - 0.2) / 0.4, 0, 1)
    x[:, 2] += bulge
    places = random.permutation(np.linspace(-1, 1, SHAPES))
    moved = [x + np.outer(14 * s * slide, [1, 0, 0]) for s in places]
    return Population(moved, faces)


def ellipsoids(random):
    u, faces = sphere(5)
    axes = [(30 + 6 * random.randn(), 20 + 3 * random.randn(), 14) for _ in range(SHAPES)]
    return Population([u * axis for axis in axes], faces)


def warped(surface, modes, size, random, count=SHAPES):
    """A population with `modes` modes, each of two waves of space; size: the first mode's root mean
    square, in radii of gyration."""
    vertices, faces = surface
    centre = vertices.mean(0)
    radius = np.sqrt(((vertices - centre) ** 2).sum(1).mean())
    x = (vertices - centre) / radius
    fields = []
    for mode in range(modes):
        field = np.zeros_like(x)
        for _ in range(2):
            wave, direction, phase = 1.6 * random.randn(3), random.randn(3), random.rand()
            field += np.sin(x @ wave + 2 * np.pi * phase)[:, None] * direction
        rms = np.sqrt((field**2).sum(1).mean())
        fields.append(field / rms * size * radius * 0.75**mode)
    moved = [vertices + sum(random.randn() * f for f in fields) for _ in range(count)]
    return Population(moved, faces)


def populations(data, measure):
    """Name to what makes it, the vertices of a shape, and the seed."""

    def surface(file):
        vertex, faces = measure.read_ply(data / file)
        return measure.points(vertex), faces

    skulls = sorted((data / "finch_skulls").glob("*.ply"))
    return {
        "bump": (bump, 3000, 5),
        "ellipsoids": (ellipsoids, 2500, 5),
        "skull": (lambda r: warped(surface(skulls[0]), 5, 0.12, r), 3500, 5),
        "hippocampus": (lambda r: warped(surface("classic/hippocampus.ply"), 4, 0.15, r), 3000, 5),
        "other skull": (lambda r: warped(surface(skulls[6]), 6, 0.12, r), 3000, 77),
        "head": (lambda r: warped(surface("classic/maxplanck.ply"), 4, 0.14, r), 3000, 78),
    }


def landmarks(project):
    project.apply_filter("generate_icosphere_remeshing", frequency=FREQUENCY)
    return [project.mesh(SHAPES + k).vertex_matrix() for k in range(SHAPES)]


def areas(points, faces):
    p = points[faces]
    face = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1) / 6
    return np.bincount(faces.ravel(), np.repeat(face, 3), len(points))


def error_of_pairs(measure, truth, found, faces):
    errors = []
    for s in range(SHAPES):
        face, weight, _ = measure.closest_points(*truth.at(s), found[s])
        share = areas(found[s], faces)
        for t in set(range(SHAPES)) - {s}:
            carried = np.einsum("pk,pkj->pj", weight, truth.shapes[t][truth.faces[face]])
            distance = np.linalg.norm(carried - found[t], axis=1)
            errors.append(share @ distance / share.sum())
    return np.mean(errors)


def carry(mesh, points):
    """Anchors on a layer."""
    for number, point in enumerate(points):
        places = np.tile(point, (mesh.vertex_number(), 1))
        mesh.add_vertex_custom_point_attribute(places, f"anchor_{number}")


def propagated(meshes, restoration=0.0, anchors=(), where=""):
    """where: anchors are carried from the "first" on, or "later", from propagation on."""
    project = pymeshlab.MeshSet()
    for vertices, faces in meshes:
        project.add_mesh(pymeshlab.Mesh(vertices, faces.astype(np.int32)))
    if where == "first":
        for mesh, points in zip(project, anchors):
            carry(mesh, points)
    project.set_current_mesh(0)
    project.apply_filter("compute_spherical_parameterisation_root")
    project.apply_filter(
        "transfer_spherical_parameterisation_to_layers",
        order="Similarity tree",
        area_restoration=restoration,
    )
    if where == "later":
        for mesh, points in zip(project, anchors):
            carry(mesh, points)
    return project


def flips(measure, project):
    return sum(
        measure.map_figures(
            mesh.vertex_matrix(),
            mesh.face_matrix(),
            mesh.vertex_custom_point_attribute_matrix("sphere_position"),
        )["flips"]
        for mesh in (project.mesh(k) for k in range(SHAPES))
    )


def cost_of(project, name, **parameters):
    """What a filter returns, and its CPU seconds."""
    start = time.process_time()
    returned = project.apply_filter(name, **parameters)
    return returned, time.process_time() - start


def shape_model(meshes, found, faces):
    """Of landmarks and the surfaces that they lie on, with one mode."""
    project = pymeshlab.MeshSet()
    for k, points in enumerate(found):
        project.add_mesh(pymeshlab.Mesh(points, faces), f"{k} landmarks")
    for k, (vertices, triangles) in enumerate(meshes):
        project.add_mesh(pymeshlab.Mesh(vertices, triangles.astype(np.int32)), str(k))
    return project.apply_filter(
        "compute_statistical_shape_model",
        alignment="None",
        modes=1,
        mode_layers=0,
        surface_measures=True,
    )


def row_of_measures(measure, truth, meshes, found, faces):
    """What the model of one mode is said to be, and the error, which takes the truth."""
    said = shape_model(meshes, found, faces)
    figures = (
        error_of_pairs(measure, truth, found, faces),
        100 * said["variance_share"][0],
        *(said[key][0] for key in ("generalisation", "specificity")),
        *(said[f"surface_{key}"][0] for key in ("generalisation", "specificity")),
        said["off_surface"].mean(),
    )
    return [*(f"{figure:.3f}" for figure in figures), f"{said['folded_faces'].sum():.0f}"]


def landmarks_of_truth(measure, truth, found):
    """Where the truth carries those of the first shape."""
    face, weight, _ = measure.closest_points(*truth.at(0), found[0])
    corners = truth.faces[face]
    return [np.einsum("pk,pkj->pj", weight, shape[corners]) for shape in truth.shapes]


def ways_to_rebuild(truth, faces):
    """Landmarks of some surfaces, which are called by their numbers, in each way."""
    propagated_once = {}  # the same for all ways

    def maps_of(others):
        key = tuple(surface.name for surface in others)
        if key not in propagated_once:
            propagated_once[key] = sp.correspond(others, root=0, order="Similarity tree").maps
        return propagated_once[key]

    def optimised(objective):
        def build(others):
            maps = maps_of(others)
            found = sp.optimise_groupwise(others, maps, alignment="None", objective=objective)
            return sp.remesh(others, found.maps, frequency=FREQUENCY)

        return build

    return {
        "truth": lambda others: (np.array([truth[int(s.name)] for s in others]), faces),
        "propagated": lambda others: sp.remesh(others, maps_of(others), frequency=FREQUENCY),
        **{name: optimised(name) for name in ("Population model", "Description length")},
    }


def rebuilt(meshes, build):
    surfaces = [sp.Surface(*mesh, str(k)) for k, mesh in enumerate(meshes)]
    return sp.rebuilt_generalisation(surfaces, 1, build=build, alignment="None").generalisation[0]


def population(make, vertices, seed):
    """The truth, and noisy surfaces of it, from populations()."""
    random = np.random.RandomState(seed)
    truth = make(random)
    return truth, [meshed(truth, k, vertices, random, noise=0.05) for k in range(SHAPES)]


def onto(measure, points, mesh):
    """The closest points of a mesh, which has noise."""
    vertices, faces = mesh
    face, weight, _ = measure.closest_points(vertices, faces, points)
    return np.einsum("pk,pkj->pj", weight, vertices[faces[face]])


def print_measures(data, measure, names):
    """Of one mode, for several ways to correspondence."""
    print(
        "| landmarks | error | variance of mode 1, % | generalisation | specificity | between "
        "surfaces: generalisation | specificity | off the surface | folded faces | left out before "
        "correspondence |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
    )
    made = populations(data, measure)
    for name in names:
        truth, meshes = population(*made[name])
        rows = {}
        for objective in ("propagated", "Population model", "Description length"):
            project = propagated(meshes)
            if objective != "propagated":
                project.apply_filter(
                    "compute_spherical_parameterisation_groupwise",
                    alignment="None",
                    objective=objective,
                )
            rows[objective] = landmarks(project)
        where = landmarks_of_truth(measure, truth, rows["propagated"])
        rows = {"truth": [onto(measure, *pair) for pair in zip(where, meshes)], **rows}
        ways = ways_to_rebuild(rows["truth"], project.mesh(SHAPES).face_matrix())
        for words, found in rows.items():
            cells = row_of_measures(
                measure, truth, meshes, found, project.mesh(SHAPES).face_matrix()
            )
            cells.append(f"{rebuilt(meshes, ways[words]):.3f}")
            print("| " + " | ".join([f"{name}, {words}", *cells]) + " |", flush=True)


def true_points(truth, count=6):
    """Vertices of the truth, each the farthest from those before on the first shape."""
    x = truth.shapes[0]
    chosen = [int(x[:, 0].argmax())]
    far = np.linalg.norm(x - x[chosen[0]], axis=1)
    while len(chosen) < count:
        chosen.append(int(far.argmax()))
        far = np.minimum(far, np.linalg.norm(x - x[chosen[-1]], axis=1))
    return chosen


def print_anchors(data, measure, names):
    """Errors with and without anchors at true points."""
    print(
        "| shapes | propagated | groupwise | with six anchors | with six anchors in propagation, "
        "too | flipped faces |\n| --- | --- | --- | --- | --- | --- |"
    )
    made = populations(data, measure)
    for name in names:
        truth, meshes = population(*made[name])
        chosen = true_points(truth)
        errors, flipped = [], 0
        for optimised, where in ((False, ""), (True, ""), (True, "later"), (True, "first")):
            project = propagated(meshes, anchors=[x[chosen] for x in truth.shapes], where=where)
            if optimised:
                project.apply_filter("compute_spherical_parameterisation_groupwise")
            found = landmarks(project)
            faces = project.mesh(SHAPES).face_matrix()
            errors.append(error_of_pairs(measure, truth, found, faces))
            flipped += flips(measure, project)
        cells = [name, *(f"{error:.2f}" for error in errors), flipped]
        print("| " + " | ".join(map(str, cells)) + " |", flush=True)


def maps_by(meshes, order, root_map=None):
    """Propagated from the first one."""
    root = sp.parameterise_root(meshes[0]) if root_map is None else root_map
    return sp.propagate(meshes, root, order=order).maps


def print_phases(measure, parts):
    """Six subjects in five phases each: every shape by itself in the optimisation, or one
    deformation per subject, by which its phases are carried along."""
    print(
        "| maps | all pairs | phases of one subject | one phase of two subjects | CPU s |\n"
        "| --- | --- | --- | --- | --- |"
    )
    warnings.simplefilter("ignore", sp.SpherePropagationWarning)  # of poses, which differ
    phases = (0, 4, 8, 12, 18)
    for part in parts:
        subjects = [Ventricle(part, 100 + s) for s in range(6)]
        random = np.random.RandomState(3)
        meshes = [[meshed(one, t, 2500, random, noise=0.05) for t in phases] for one in subjects]
        first = [cycle[0] for cycle in meshes]

        def cycles_from(maps, meshes=meshes):
            return [m for cycle, root in zip(meshes, maps) for m in maps_by(cycle, "Time", root)]

        everything = [mesh for cycle in meshes for mesh in cycle]
        start = maps_by(first, "Similarity tree")
        apart = cycles_from(start)
        clock = [time.process_time()]
        together = sp.optimise_groupwise(first, start).maps
        clock.append(time.process_time())
        carried = cycles_from(together)
        clock.append(time.process_time())
        alike = sp.optimise_groupwise(everything, apart).maps
        clock.append(time.process_time())
        both = sp.optimise_groupwise(everything, carried).maps
        seconds = np.diff(clock)
        ways = {
            "propagated": (apart, 0),
            "one deformation per subject, of its first phase": (carried, seconds[0]),
            "every shape by itself": (alike, seconds[2]),
            "the second, then the third": (both, seconds[0] + time.process_time() - clock[-1]),
        }
        for words, (maps, cost) in ways.items():
            errors = errors_of_phases(measure, subjects, phases, everything, maps)
            cells = [f"{part}, {words}", *(f"{e:.2f}" for e in errors), f"{cost:.1f}"]
            print("| " + " | ".join(cells) + " |", flush=True)


def errors_of_phases(measure, subjects, phases, meshes, maps):
    """Of all ordered pairs; of those of one subject; of those of one phase."""
    found = sp.remesh(meshes, maps, frequency=FREQUENCY).points
    tissue, whose = subjects[0].tissue, [(s, t) for s in range(len(subjects)) for t in phases]
    truth = [subjects[s].at(t) for s, t in whose]
    pairs = {"all": [], "subject": [], "phase": []}
    for a, (s, t) in enumerate(whose):
        face, weight, _ = measure.closest_points(*truth[a], found[a])
        corners = truth[a][1][face]
        counted = tissue[corners].all(1)
        for b, (other, then) in enumerate(whose):
            if a == b:
                continue
            carried = np.einsum("pk,pkj->pj", weight, truth[b][0][corners])
            error = np.linalg.norm(carried - found[b], axis=1)[counted].mean()
            pairs["all"].append(error)
            if s == other:
                pairs["subject"].append(error)
            elif t == then:
                pairs["phase"].append(error)
    return [np.mean(errors) for errors in pairs.values()]


def print_skulls(data):
    """What is said of real shapes, whose truth nobody knows."""
    print(
        "| landmarks | generalisation, 1 mode | 2 | 4 | specificity, 4 modes | off the surface, "
        "mean | worst | folded faces | least trust | CPU s |\n" + "| --- " * 10 + "|"
    )
    ways = {
        "propagated": None,
        "population model": {},
        "population model, `surface_precision` 300": {"surface_precision": 300},
        "description length": {"objective": "Description length"},
    }
    for words, parameters in ways.items():
        meshes = pymeshlab.MeshSet()
        for file in sorted((data / "finch_skulls").glob("*.ply")):
            meshes.load_new_mesh(str(file))
        project = propagated([(mesh.vertex_matrix(), mesh.face_matrix()) for mesh in meshes])
        trust, seconds = np.ones(1), 0.0
        if parameters is not None:
            returned, seconds = cost_of(
                project, "compute_spherical_parameterisation_groupwise", **parameters
            )
            trust = returned["trust"]
        project.apply_filter("generate_icosphere_remeshing", frequency=FREQUENCY)
        said = project.apply_filter(
            "compute_statistical_shape_model",
            alignment="Rigid",
            modes=4,
            mode_layers=0,
            surface_measures=True,
        )
        figures = (
            *said["surface_generalisation"][[0, 1, 3]],
            said["surface_specificity"][3],
            said["off_surface"].mean(),
            said["off_surface"].max(),
        )
        cells = [words, *(f"{figure:.3f}" for figure in figures)]
        cells += [f"{said['folded_faces'].sum():.0f}", f"{trust.min():.2f}", f"{seconds:.1f}"]
        print("| " + " | ".join(cells) + " |", flush=True)


def print_costs(data, measure, counts):
    """CPU seconds by number of shapes."""
    vertex, faces = measure.read_ply(data / "classic/hippocampus.ply")
    base = Population([measure.points(vertex)], faces)
    x, faces = meshed(base, 0, 3000, np.random.RandomState(1), noise=0)
    print(
        "| shapes | root, the most central | Similarity tree | groupwise | Remesh by icosphere |\n"
        "| --- | --- | --- | --- | --- |"
    )
    for count in map(int, counts):
        shapes = warped((x, faces), 4, 0.15, np.random.RandomState(5), count).shapes
        project = pymeshlab.MeshSet()
        for shape in shapes:
            project.add_mesh(pymeshlab.Mesh(shape, faces.astype(np.int32)))
        root, first = cost_of(project, "compute_spherical_parameterisation_root", most_central=True)
        others = [
            cost_of(
                project,
                "transfer_spherical_parameterisation_to_layers",
                order="Similarity tree",
                root_layer=root["root_layer"],
            ),
            cost_of(project, "compute_spherical_parameterisation_groupwise"),
            cost_of(project, "generate_icosphere_remeshing"),
        ]
        seconds = [first, *(s for _, s in others)]
        print("| " + " | ".join([str(count), *(f"{s:.1f}" for s in seconds)]) + " |", flush=True)


def main():
    names = sys.argv[1:]
    data = Path(names.pop(0)).resolve() if names and Path(names[0]).is_dir() else DATA
    measure, _ = yardstick(data)
    if names[:1] == ["--measures"]:
        print_measures(data, measure, names[1:])
        return
    if names[:1] == ["--anchors"]:
        print_anchors(data, measure, names[1:])
        return
    if names[:1] == ["--phases"]:
        print_phases(measure, names[1:])
        return
    if names[:1] == ["--skulls"]:
        print_skulls(data)
        return
    if names[:1] == ["--many"]:
        print_costs(data, measure, names[1:])
        return
    restoration = 0.0
    if names[:1] == ["--restored"]:
        restoration = 1.0
        names.pop(0)
    made = populations(data, measure)
    print(
        "| shapes | propagated | groupwise | where they lie (`alignment` None) | flipped faces | "
        "CPU s |\n| --- | --- | --- | --- | --- | --- |"
    )
    for name in names or made:
        truth, meshes = population(*made[name])
        errors, flipped, seconds = [], 0, []
        for alignment in (None, "Rigid", "None"):
            project = propagated(meshes, restoration)
            start = time.process_time()
            if alignment:
                project.apply_filter(
                    "compute_spherical_parameterisation_groupwise", alignment=alignment
                )
            seconds.append(time.process_time() - start)
            found = landmarks(project)
            faces = project.mesh(SHAPES).face_matrix()
            errors.append(error_of_pairs(measure, truth, found, faces))
            flipped += flips(measure, project)
        cells = [name, *(f"{error:.2f}" for error in errors), flipped, f"{seconds[1]:.1f}"]
        print("| " + " | ".join(map(str, cells)) + " |", flush=True)


if __name__ == "__main__":
    main()
