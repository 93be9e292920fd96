# SPDX-License-Identifier: GPL-3.0-only
"""What deserves a look reaches scripts: the key `warnings` of what a filter returns."""

import json

import numpy as np
import pymeshlab
import pytest
from documents import (
    COLOR,
    EVALUATE,
    FILTERS,
    MODEL,
    PROPAGATE,
    REMESH,
    ROOT,
    SPHERES,
    add,
    landmark_layers,
    layer,
    mapped_cycle,
    positions,
    small_cycle,
)
from surfaces import egg, open_egg


def remarks(returned):
    """As docs/hosts.md says to read them."""
    return json.loads(bytes(map(int, returned["warnings"])).decode())


def said(returned):
    """(layer, message) of each."""
    return [(remark["layer"], remark["message"]) for remark in remarks(returned)]


def changed(ms, number, vertices):
    """The project with other vertices in one of its layers."""
    other = pymeshlab.MeshSet()
    for i, mesh in enumerate(ms):
        points = vertices(mesh.vertex_matrix()) if i == number else mesh.vertex_matrix()
        add(other, points, mesh.face_matrix(), mesh.label())
    other.set_current_mesh(0)
    other.apply_filter(ROOT)
    return other


def test_nothing_is_returned_where_there_is_nothing_to_say():
    ms = pymeshlab.MeshSet()
    assert "warnings" not in ms.apply_filter(FILTERS[0], phases=3, voxel_size=4)
    for name in FILTERS[1:]:
        assert "warnings" not in ms.apply_filter(name), name


def test_a_warning_of_a_layer_names_it():
    ms = changed(small_cycle(3), 1, lambda v: v + [500, 0, 0])
    (remark,) = remarks(ms.apply_filter(PROPAGATE))
    assert remark["kind"] == "Warning" and remark["message"] == "anotherPose"
    assert remark["layer"] == "phantom cavity 01"
    assert remark["text"].startswith("it lies in another pose and was laid on its parent")


def test_a_warning_of_the_whole_names_none():
    ms = mapped_cycle(2)
    (remark,) = remarks(ms.apply_filter(PROPAGATE, parents="-1, 0"))
    assert (remark["layer"], remark["message"]) == ("", "parentsNotLookedAt")


def test_advice_is_told_apart():
    ms = small_cycle(3)
    ms.set_current_mesh(1)
    (remark,) = remarks(ms.apply_filter(ROOT))
    assert (remark["kind"], remark["layer"], remark["message"]) == ("Note", "", "betterRoot")


def test_names_are_utf_8():
    vertices, faces = egg()
    ms = pymeshlab.MeshSet()
    name = 'Vénule "α" ✓\\'
    add(ms, vertices / np.linalg.norm(vertices, axis=1)[:, None] * 30, faces, name)
    assert said(ms.apply_filter(ROOT)) == [(name, "rootIsSphere")]


def test_a_root_that_is_a_unit_sphere():
    vertices, faces = egg()
    ms = pymeshlab.MeshSet()
    add(ms, vertices / np.linalg.norm(vertices, axis=1)[:, None], faces, "unit")
    assert said(ms.apply_filter(ROOT)) == [("unit", "rootOnUnitSphere")]


def test_a_layer_of_another_size_and_one_in_another_unit():
    for factor, message in ((5, "anotherSize"), (10, "anotherUnit"), (0.1, "anotherUnit")):
        ms = changed(small_cycle(3), 2, lambda v, factor=factor: v * factor)
        found = said(ms.apply_filter(PROPAGATE))
        assert [one for one in found if one[0]] == [("phantom cavity 02", message)]
    for factor, message in ((5, "anotherSizeThanRoot"), (0.1, "anotherUnitThanRoot")):
        ms = changed(small_cycle(2), 1, lambda v, factor=factor: v * factor)
        found = said(ms.apply_filter(PROPAGATE))
        assert [one for one in found if one[0]] == [("phantom cavity 01", message)]


@pytest.mark.parametrize("copies", [1, 5])
def test_surfaces_that_are_there_twice(copies):
    """Vertices may be in another order; up to three are named one by one."""
    ms = pymeshlab.MeshSet()
    for mesh in small_cycle(8):
        add(ms, mesh.vertex_matrix(), mesh.face_matrix(), mesh.label())
    for k in range(copies):
        v, f = ms.mesh(k).vertex_matrix(), ms.mesh(k).face_matrix()
        add(ms, v[::-1], len(v) - 1 - f, f"copy {k}")
    ms.set_current_mesh(0)
    ms.apply_filter(ROOT)
    found = [
        r for r in remarks(ms.apply_filter(PROPAGATE, order="Star")) if "vertex by" in r["text"]
    ]
    assert len(found) == 1
    assert '"phantom cavity 00"' in found[0]["text"]
    if copies == 1:
        assert (found[0]["layer"], found[0]["message"]) == ("copy 0", "repeatedSurface")
    else:
        assert found[0]["message"] == "repeatedSurfaces" and len(found[0]["layers"]) == 5
        assert "5 of 13 layers" in found[0]["text"] and '"copy 4"' in found[0]["text"]


def test_a_layer_that_is_reflected():
    """Egg-shaped with two bumps, so that no plane of symmetry is left."""
    vertices, faces = egg(14, 20, radii=(40, 30, 22))
    unit = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    for centre in ([0.6, 0.64, 0.48], [-0.48, 0.6, 0.64]):
        vertices = vertices * (1 + 0.4 * np.exp(-5 * ((unit - centre) ** 2).sum(1)))[:, None]
    ms = pymeshlab.MeshSet()
    for i in range(4):
        side = [-1, 1, 1] if i == 2 else [1, 1, 1]
        add(ms, vertices * side * (1 - 0.02 * i), faces[:, :: side[0]], f"shape {i}")
    ms.set_current_mesh(0)
    ms.apply_filter(ROOT)
    returned = ms.apply_filter(PROPAGATE, mirror_layers=True)
    assert returned["mirrored"].tolist() == [0, 0, 1, 0]
    assert said(returned) == [("shape 2", "reflected")]


@pytest.fixture
def cycle():
    ms = mapped_cycle(3)
    ms.apply_filter(PROPAGATE)
    return ms


@pytest.mark.parametrize("name", [REMESH, COLOR, SPHERES])
def test_layers_that_are_left_out(cycle, name):
    vertices, faces = egg()
    texture = np.zeros((len(vertices), 2))
    add(cycle, vertices + 100, faces, "without map")
    add(cycle, vertices + 200, faces, "painted", v_tex_coords_matrix=texture)
    vertices, faces = open_egg()
    texture = np.zeros((len(vertices), 2))
    add(cycle, vertices + 300, faces, "open", v_tex_coords_matrix=texture)
    found = remarks(cycle.apply_filter(name))
    assert [(remark["layer"], remark["message"]) for remark in found] == [
        ("without map", "leftOutWithoutMap"),
        ("painted", "leftOutWithBadMap"),
        ("open", "layerLeftOut"),
    ]
    assert found[2]["text"].startswith(
        "left out, since it is not a closed surface: it is not closed:"
    )


def test_maps_of_several_roots(cycle):
    cycle.set_current_mesh(2)
    cycle.apply_filter(ROOT)
    assert said(cycle.apply_filter(REMESH)) == [("", "mapsOfSeveralRoots")]


def test_a_map_that_is_not_valid(cycle):
    mesh = layer(cycle, "phantom cavity 01")
    flipped = positions(mesh) * [1, 1, -1]
    other = pymeshlab.MeshSet()
    add(other, mesh.vertex_matrix(), mesh.face_matrix(), "flipped")
    other.current_mesh().add_vertex_custom_point_attribute(flipped, "sphere_position")
    returned = other.apply_filter(EVALUATE)
    assert returned["valid"] == [0]
    assert said(returned) == [("flipped", "mapNotValid")]


def test_a_sphere_without_its_surface(cycle):
    cycle.apply_filter(SPHERES)
    cycle.set_mesh_visibility(1, False)
    found = said(cycle.apply_filter(COLOR, pattern="Area ratio"))
    assert found == [("phantom cavity 01 sphere", "sphereWithoutSurface")]


def test_landmarks_that_are_there_twice(cycle):
    cycle.apply_filter(REMESH, frequency=3)
    first = landmark_layers(cycle)[0]
    add(cycle, first.vertex_matrix(), first.face_matrix(), "a copy")
    assert said(cycle.apply_filter(MODEL)) == [("", "shapeCountedTwice")]
    assert said(cycle.apply_filter(REMESH, frequency=3)) == [("a copy", "landmarksTwice")]


def test_shapes_that_are_identical(cycle):
    cycle.apply_filter(REMESH, frequency=3)
    first = landmark_layers(cycle)[0]
    other = pymeshlab.MeshSet()
    for name in ("a landmarks", "b landmarks"):
        add(other, first.vertex_matrix(), first.face_matrix(), name)
    returned = other.apply_filter(MODEL, modes=5)
    assert ("", "identicalShapes") in said(returned)
    assert {"Note"} == {r["kind"] for r in remarks(returned) if r["message"] == "fewerModes"}


def test_a_warning_of_several_layers_lists_them():
    ms = pymeshlab.MeshSet()
    vertices, faces = egg()
    for i in range(4):
        add(ms, vertices * (10 if i > 1 else 1) * (1 + 0.01 * i), faces, f"s{i}")
    ms.set_current_mesh(0)
    ms.apply_filter(ROOT)
    (remark,) = [r for r in remarks(ms.apply_filter(PROPAGATE)) if "half" in r["message"]]
    assert remark["layers"] == ["s2", "s3"] and remark["layer"] == remark["subject"] == ""
    ms = changed(small_cycle(3), 1, lambda v: v + [500, 0, 0])
    (remark,) = remarks(ms.apply_filter(PROPAGATE))
    assert remark["layers"] == ["phantom cavity 01"]
    assert remark["layer"] == remark["subject"] == "phantom cavity 01"
