# SPDX-License-Identifier: GPL-3.0-only
"""Colour by spherical parameterisation: the same place has the same colour on every layer; area
ratios as quality."""

import sys

import numpy as np
import pymeshlab
import pytest
from documents import (
    COLOR,
    EVALUATE,
    PROPAGATE,
    REMESH,
    ROOT,
    SPHERES,
    add,
    has_attribute,
    landmark_layers,
    layers,
    mapped_cycle,
    positions,
    refused,
    small_cycle,
    snapshot,
)
from environment import PROJECT
from surfaces import egg, open_egg

sys.path.insert(0, str(PROJECT / "python"))
from sphere_propagation.colors import map_colors, sphere_coordinates

PATTERNS = ["Checkerboard", "Latitude and longitude", "Direction", "Area ratio"]


def rgb(mesh):
    return np.round(255 * mesh.vertex_color_matrix()[:, :3]).astype(int)


def spheres(ms):
    return [m for m in ms if m.label().endswith(" sphere")]


def surfaces_of(ms):
    return [m for m in ms if "landmarks" not in m.label() and "sphere" not in m.label()]


def full_project(phases=3):
    ms = mapped_cycle(phases)
    ms.apply_filter(REMESH, frequency=8)
    ms.apply_filter(SPHERES)
    return ms


@pytest.fixture(scope="module")
def project():
    """Do not change anything but colours and quality."""
    return full_project()


def far_from_edges(places, cells, around, least=0.06):
    """Which points of the sphere are further than `least` radians from the edges of the
    checkerboard, in both directions."""
    longitude, latitude = sphere_coordinates(places)
    u, v = longitude * around, (1 - latitude) / 2 * cells
    width = np.sqrt(np.maximum(1 - places[:, 2] ** 2, 1e-12)) * 2 * np.pi / around
    return (np.abs(u - np.round(u)) * width > least) & (
        np.abs(v - np.round(v)) * np.pi / cells > least
    )


def test_the_checkerboard_is_that_of_the_pictures(project):
    """An independent implementation, which knows no blending, agrees away from the edges; blending
    stays within its two sides."""
    assert project.apply_filter(COLOR, cells=4)["layers"] == 9
    checked = 0
    for mesh, places in [(m, positions(m)) for m in surfaces_of(project)] + [
        (m, m.vertex_matrix()) for m in spheres(project)
    ]:
        longitude, latitude = sphere_coordinates(places)
        expected = 255 * map_colors(longitude, latitude, cells=4)
        inside = far_from_edges(places, 4, 6, least=0.3)
        checked += inside.sum()
        assert np.abs(rgb(mesh) - expected)[inside].max() <= 1
        plain = 255 * map_colors(longitude, latitude, cells=4, shade=0)
        assert (rgb(mesh) <= plain + 1).all() and (rgb(mesh) >= plain * 0.5 - 1).all()
    assert checked > 300


@pytest.mark.parametrize("pattern", PATTERNS)
def test_surface_and_sphere_match(project, pattern):
    project.apply_filter(COLOR, pattern=pattern)
    for surface, sphere in zip(surfaces_of(project), spheres(project)):
        assert np.array_equal(rgb(surface), rgb(sphere))
    assert np.ptp(rgb(surface), axis=0).max() > 5


def test_the_same_place_has_the_same_colour_on_every_layer(project):
    project.apply_filter(COLOR, pattern="Direction")
    colours, places = [], []
    for mesh in layers(project):
        places.append(positions(mesh) if has_attribute(mesh) else mesh.vertex_matrix())
        colours.append(rgb(mesh))
    marks = landmark_layers(project)
    assert all(np.array_equal(rgb(m), rgb(marks[0])) for m in marks)
    root, others = (
        0,
        [
            i
            for i, m in enumerate(layers(project))
            if m in surfaces_of(project) or m in spheres(project)
        ],
    )
    compared = 0
    for i in others[1:]:
        cosine = places[i] @ places[root].T
        near = cosine.max(1) > np.cos(0.005)
        compared += near.sum()
        assert np.abs(colours[i] - colours[root][cosine.argmax(1)])[near].max(initial=0) <= 8
    assert compared > 100


def test_landmarks_match_their_surface(project):
    """The landmark nearest to a vertex of the surface has nearly its colour."""
    project.apply_filter(COLOR, pattern="Direction")
    for surface, marks in zip(surfaces_of(project), landmark_layers(project)):
        gaps = np.linalg.norm(
            surface.vertex_matrix()[:, None] - marks.vertex_matrix()[None], axis=2
        )
        difference = np.abs(rgb(surface) - rgb(marks)[gaps.argmin(1)]).max(1)
        assert np.median(difference) < 15


def test_landmark_layers_may_be_left_alone():
    ms = full_project(2)
    before = [rgb(m) for m in landmark_layers(ms)]
    assert ms.apply_filter(COLOR, landmark_layers=False)["layers"] == 4
    assert all(np.array_equal(a, rgb(m)) for a, m in zip(before, landmark_layers(ms)))
    assert ms.apply_filter(COLOR)["layers"] == 6
    assert not any(np.array_equal(a, rgb(m)) for a, m in zip(before, landmark_layers(ms)))
    ms.apply_filter(REMESH, frequency=8)
    assert all(np.array_equal(a, rgb(m)) for a, m in zip(before, landmark_layers(ms)))


def solid_angles(places, faces):
    a, b, c = (places[faces[:, k]] for k in range(3))

    def dot(p, q):
        return np.einsum("ij,ij->i", p, q)

    return 2 * np.arctan2(dot(a, np.cross(b, c)), 1 + dot(a, b) + dot(b, c) + dot(c, a))


def areas(vertices, faces):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


@pytest.mark.parametrize(
    "pattern, more", [("Area ratio", {}), ("Direction", {"store_area_ratio": True})]
)
def test_area_ratios_are_stored_as_quality(pattern, more):
    ms = full_project(3)
    ms.apply_filter(COLOR, pattern=pattern, **more)
    for surface, sphere in zip(surfaces_of(ms), spheres(ms)):
        f, places = surface.face_matrix(), positions(surface)
        share = solid_angles(places, f) / (4 * np.pi)
        due = areas(surface.vertex_matrix(), f) / areas(surface.vertex_matrix(), f).sum()
        assert np.allclose(surface.face_scalar_array(), share / due, rtol=1e-9)
        around = [np.bincount(f.ravel(), np.repeat(x, 3)) for x in (share, due)]
        assert np.allclose(surface.vertex_scalar_array(), around[0] / around[1], rtol=1e-9)
        assert np.allclose(sphere.vertex_scalar_array(), surface.vertex_scalar_array(), rtol=1e-9)
        assert np.allclose(sphere.face_scalar_array(), surface.face_scalar_array(), rtol=1e-9)
    figures = ms.apply_filter(EVALUATE)
    for surface, sd in zip(surfaces_of(ms), figures["area_ratio_sd"]):
        assert surface.face_scalar_array().std() == pytest.approx(sd, rel=1e-9)
    ms.set_current_mesh(1)  # MeshLab's own filters work on it
    statistics = ms.apply_filter("get_scalar_statistics_per_vertex")
    assert statistics["avg"] == pytest.approx(ms.mesh(1).vertex_scalar_array().mean(), rel=1e-5)


def test_colours_of_area_ratios():
    ms = mapped_cycle(3)
    ms.apply_filter(COLOR, pattern="Area ratio")
    root, other = rgb(ms.mesh(0)), ms.mesh(1)
    assert np.ptp(root, axis=1).max() < 25  # the root map preserves areas: grey
    ratio, colours = other.vertex_scalar_array(), rgb(other)
    warm = colours[:, 0] - colours[:, 2]
    assert (warm[ratio > 1.1] > 10).all() and (warm[ratio < 1 / 1.1] < -10).all()
    before = np.abs(warm).mean()
    ms.apply_filter(COLOR, pattern="Area ratio", area_ratio_limit=1.2)
    colours = rgb(ms.mesh(1))
    assert np.abs(colours[:, 0] - colours[:, 2]).mean() > 1.5 * before


def test_nothing_but_colours_is_changed():
    ms = full_project(3)
    ms.set_current_mesh(2)
    before = snapshot(ms)
    ms.apply_filter(COLOR)
    after = snapshot(ms)
    assert before != after
    for a, b in zip(before["layers"], after["layers"]):
        changed = {k for k in a if a[k] != b[k]}
        assert changed == {"vertex colours"}
    assert before["current"] == after["current"]


def test_the_same_again():
    a, b = full_project(3), full_project(3)
    a.apply_filter(COLOR)
    b.apply_filter(COLOR, pattern="Area ratio")
    b.apply_filter(COLOR)
    assert all(np.array_equal(rgb(x), rgb(y)) for x, y in zip(a, b))


def test_hidden_layers_and_those_without_a_map_are_left_alone():
    ms = full_project(3)
    ms.set_current_mesh(1)
    ms.set_current_mesh_visibility(False)
    add(ms, *egg(), "egg")
    add(ms, *open_egg(), "open")
    before = snapshot(ms)["layers"]
    assert ms.apply_filter(COLOR)["layers"] == 8
    after = snapshot(ms)["layers"]
    assert [a == b for a, b in zip(before, after)] == [False, True] + 7 * [False] + [True, True]


def test_matrices_do_not_matter():
    ms, moved = full_project(2), full_project(2)
    for mesh in layers(moved):
        moved.set_current_mesh(mesh.id())
        moved.apply_filter(
            "set_matrix",
            transformmatrix=np.array(
                [[0, 2, 0, 50.0], [-2, 0, 0, 7], [0, 0, 2, -90], [0, 0, 0, 1]]
            ),
            freeze=False,
        )
    for project in (ms, moved):
        project.apply_filter(COLOR, pattern="Checkerboard", store_area_ratio=True)
    for a, b in zip(ms, moved):
        assert np.array_equal(rgb(a), rgb(b))
        assert np.allclose(a.vertex_scalar_array(), b.vertex_scalar_array(), rtol=1e-6)


def test_maps_read_from_files_are_coloured(tmp_path):
    ms = full_project(2)
    ms.apply_filter(COLOR)
    again = pymeshlab.MeshSet()
    for i, mesh in enumerate(layers(ms)):
        ms.set_current_mesh(mesh.id())
        ms.save_current_mesh(str(tmp_path / f"{i}.ply"))
        again.load_new_mesh(str(tmp_path / f"{i}.ply"))
    stored = [rgb(m) for m in again]
    assert all(np.array_equal(rgb(m), s) for m, s in zip(ms, stored))  # colours are kept
    again.apply_filter(COLOR, pattern="Area ratio")
    assert again.apply_filter(COLOR)["layers"] == 6
    assert all(np.abs(rgb(m) - s).max() <= 1 for m, s in zip(again, stored))


# ---------------------------------------------------------------- what it refuses


def test_no_map():
    ms = small_cycle(2)
    with refused(ms, "Spherical parameterise root", "Propagate parameterisation to layers"):
        ms.apply_filter(COLOR)
    empty = pymeshlab.MeshSet()
    with pytest.raises(pymeshlab.PyMeshLabException):
        empty.apply_filter(COLOR)


@pytest.mark.parametrize(
    "more, words",
    [
        ({"cells": 1}, "cells"),
        ({"cells": 100000}, "cells"),
        ({"pattern": "Area ratio", "area_ratio_limit": 1.0}, "area ratio"),
    ],
)
def test_parameters_out_of_range(project, more, words):
    with refused(project, words):
        project.apply_filter(COLOR, **more)


def test_spheres_alone():
    ms = mapped_cycle(2)
    ms.apply_filter(SPHERES)
    for i in (0, 1):
        ms.set_current_mesh(i)
        ms.set_current_mesh_visibility(False)
    assert ms.apply_filter(COLOR)["layers"] == 2
    with refused(ms, "show the surfaces"):
        ms.apply_filter(COLOR, pattern="Area ratio")


# ---------------------------------------------------------------- spheres beside the surfaces


def test_spheres_beside_the_surfaces():
    ms = mapped_cycle(5)
    ms.apply_filter(SPHERES, beside_surfaces=True)
    right = max(m.vertex_matrix()[:, 0].max() for m in surfaces_of(ms))
    centres = []
    for surface, sphere in zip(surfaces_of(ms), spheres(ms)):
        # On the unit sphere: the matrix alone shows it elsewhere.
        assert np.array_equal(sphere.vertex_matrix(), positions(surface))
        matrix = sphere.transform_matrix()
        radius = np.linalg.det(matrix[:3, :3]) ** (1 / 3)
        assert np.allclose(matrix[:3, :3] @ matrix[:3, :3].T, radius**2 * np.eye(3))
        seen, around = (
            surface.vertex_matrix() - surface.vertex_matrix().mean(0),
            sphere.vertex_matrix() @ matrix[:3, :3].T,
        )
        cosine = (seen * around).sum(1) / np.linalg.norm(seen, axis=1) / radius
        assert np.median(cosine) > 0.8  # the same side is in front
        area = areas(surface.vertex_matrix(), surface.face_matrix()).sum()
        assert 4 * np.pi * radius**2 == pytest.approx(area, rel=1e-6)
        assert matrix[0, 3] - radius > right
        centres.append((matrix[:3, 3], radius))
    for i, (a, r) in enumerate(centres):
        assert all(np.linalg.norm(a - b) > r + s for b, s in centres[:i])
    # They are spheres to every filter, and replaced by the next run.
    assert ms.apply_filter(PROPAGATE, order="Cyclic time")["parent"].shape == (5,)
    ms.apply_filter(COLOR)
    assert all(np.array_equal(rgb(a), rgb(b)) for a, b in zip(surfaces_of(ms), spheres(ms)))
    ms.apply_filter(SPHERES, beside_surfaces=False)
    assert ms.mesh_number() == 10
    assert all(np.array_equal(m.transform_matrix(), np.eye(4)) for m in spheres(ms))


# ---------------------------------------------------------------- which layer is the largest


def volumes(ms):
    """Of what the layers surround: the tetrahedra between the origin and each face."""
    return [np.linalg.det(m.vertex_matrix()[m.face_matrix()]).sum() / 6 for m in ms]


def dialog(ms, name, parameter, path):
    """Label and tooltip of a parameter, as a filter script writes them."""
    from documents import MENU_OF, written_script

    return dict(written_script(ms, path))[MENU_OF[name]][parameter]


@pytest.mark.parametrize("current", [0, 2])
def test_dialogs_name_the_largest_layer(current, tmp_path):
    ms = small_cycle(5)
    assert np.argmax(volumes(ms)) == 0
    ms.set_current_mesh(current)
    ms.apply_filter(ROOT)
    ms.apply_filter(PROPAGATE)
    root, propagate = (
        dialog(ms, n, p, tmp_path / "s.mlx")
        for n, p in ((ROOT, "initial_map"), (PROPAGATE, "root_layer"))
    )
    named = '"phantom cavity 00"'
    assert named in propagate["tooltip"]
    assert (named in root["description"]) == (current == 2)
    assert (named in propagate["description"]) == (current == 2)


def test_broken_layers_are_no_largest_ones(tmp_path):
    ms = small_cycle(2)
    v, f = egg()
    v = 100 * v
    v[5, 1] = np.nan
    add(ms, v, f, "not a number")
    add(ms, 100 * v[:4], np.empty((0, 3)), "points")
    add(ms, 1e300 * egg()[0], f, "beyond all bounds")
    ms.set_current_mesh(0)
    ms.apply_filter(ROOT)
    assert dialog(ms, ROOT, "initial_map", tmp_path / "s.mlx")["description"] == "Initial map"
