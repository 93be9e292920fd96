# SPDX-License-Identifier: GPL-3.0-only
"""Morph between layers: its layers, their order and shapes, and what it says where nothing lies
between."""

import json

import numpy as np
import pymeshlab
import pytest
from documents import EVALUATE, MODEL, MORPH, PROPAGATE, REMESH, ROOT, labels, layer, mapped_cycle
from documents import refused as is_refused

UNION = "Union of both connectivities"
NAMES = [f"phantom cavity {i:02}" for i in range(3)]


def between(i, j, percent):
    return f"{NAMES[i]} to {NAMES[j]} {percent} %"


def volume(mesh):
    corners = mesh.vertex_matrix()[mesh.face_matrix()]
    return np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6


def test_layers_come_in_order_of_time_and_meet_the_landmarks_at_their_ends():
    ms = mapped_cycle(3)
    ms.apply_filter(REMESH, frequency=6)
    returned = ms.apply_filter(MORPH, frequency=6)
    made = [between(0, 1, p) for p in (0, 25, 50, 75, 100)] + [
        between(1, 2, p) for p in (25, 50, 75, 100)
    ]
    assert labels(ms)[6:] == made
    assert returned["layers"] == 9 and returned["crossings"] == 0
    assert returned["share"].tolist() == [0, 0.25, 0.5, 0.75, 1, 0.25, 0.5, 0.75, 1]
    assert returned["from"].tolist() == [0] * 5 + [1] * 4
    assert returned["to"].tolist() == [1] * 5 + [2] * 4
    ends = [layer(ms, f"{name} landmarks").vertex_matrix() for name in NAMES]
    for name, expected in (
        (between(0, 1, 0), ends[0]),
        (between(0, 1, 100), ends[1]),
        (between(1, 2, 100), ends[2]),
    ):
        np.testing.assert_array_equal(layer(ms, name).vertex_matrix(), expected)
    half = layer(ms, between(0, 1, 50)).vertex_matrix()
    np.testing.assert_allclose(half, (ends[0] + ends[1]) / 2, atol=1e-10)
    volumes = [volume(layer(ms, name)) for name in made]
    np.testing.assert_allclose(returned["volume"], volumes, rtol=1e-9)


def test_the_union_is_both_surfaces_at_its_ends():
    ms = mapped_cycle(2)
    returned = ms.apply_filter(MORPH, connectivity=UNION, steps=1)
    assert labels(ms)[2:] == [between(0, 1, p) for p in (0, 50, 100)]
    first, second = (layer(ms, name) for name in NAMES[:2])
    n, m = first.vertex_number(), second.vertex_number()
    begin, half, end = (layer(ms, between(0, 1, p)) for p in (0, 50, 100))
    assert begin.vertex_number() == n + m + returned["crossings"] == returned["vertices"][0]
    np.testing.assert_array_equal(begin.face_matrix(), end.face_matrix())
    np.testing.assert_array_equal(begin.vertex_matrix()[:n], first.vertex_matrix())
    np.testing.assert_array_equal(end.vertex_matrix()[n : n + m], second.vertex_matrix())
    np.testing.assert_allclose(
        half.vertex_matrix(), (begin.vertex_matrix() + end.vertex_matrix()) / 2, atol=1e-10
    )
    assert volume(begin) == pytest.approx(volume(first), rel=1e-9)
    assert volume(end) == pytest.approx(volume(second), rel=1e-9)
    assert min(volume(first), volume(second)) < volume(half) < max(volume(first), volume(second))


def test_layers_are_where_surfaces_are_seen():
    ms = mapped_cycle(2)
    ms.set_current_mesh(1)
    ms.compute_matrix_from_translation(traslmethod=0, axisx=500.0, freeze=False)
    ms.apply_filter(MORPH, connectivity=UNION, steps=1)
    moved = layer(ms, between(0, 1, 50))
    assert np.array_equal(moved.transform_matrix(), np.eye(4))
    ends = [layer(ms, between(0, 1, p)).vertex_matrix()[:, 0].mean() for p in (0, 100)]
    assert ends[1] - ends[0] > 300
    assert moved.vertex_matrix()[:, 0].mean() == pytest.approx(np.mean(ends))


def test_ways_may_be_closed_and_smooth_and_without_ends():
    ms = mapped_cycle(3)
    ms.apply_filter(MORPH, frequency=4, steps=1, ends=False)
    straight = [between(0, 1, 50), between(1, 2, 50)]
    assert labels(ms)[3:] == straight
    before = layer(ms, straight[1]).vertex_matrix()
    ms.apply_filter(MORPH, frequency=4, steps=1, ends=False, along="Shape model", closed=True)
    assert labels(ms)[3:] == [*straight, between(2, 0, 50)], "replaced, and one more"
    assert np.abs(layer(ms, straight[1]).vertex_matrix() - before).max() > 0.05
    ms.apply_filter(MORPH, frequency=4, steps=2, ends=False)
    assert between(0, 1, 50) not in labels(ms), "of the run before"
    assert between(0, 1, 33.33) in labels(ms)


def test_other_filters_leave_morphs_alone(tmp_path):
    ms = mapped_cycle(3)
    ms.apply_filter(REMESH, frequency=4)
    ms.apply_filter(MORPH, frequency=4)
    assert ms.apply_filter(MODEL)["shapes"] == 3
    assert len(ms.apply_filter(EVALUATE)["valid"]) == 3
    ms.set_current_mesh(0)
    assert len(ms.apply_filter(PROPAGATE)["parent"]) == 3
    one = next(i for i, m in enumerate(ms) if m.label() == between(0, 1, 25))
    ms.set_current_mesh(one)
    ms.save_current_mesh(str(tmp_path / "a to b 25 %.ply"))
    ms.load_new_mesh(str(tmp_path / "a to b 25 %.ply"))
    assert ms.apply_filter(MODEL)["shapes"] == 3, "known again from its file's name"


def test_poses_that_differ_are_warned_of_or_refused():
    for angle, words in ((100.0, "enclose as little as"), (180.0, "encloses anything")):
        ms = pymeshlab.MeshSet()
        ms.create_cube(size=10.0)
        ms.meshing_surface_subdivision_midpoint(iterations=3)
        ms.apply_filter(ROOT)
        ms.generate_copy_of_current_mesh()
        ms.apply_filter(ROOT)
        ms.set_current_mesh(1)
        ms.compute_matrix_from_rotation(rotaxis="Z axis", angle=angle, freeze=False)
        if angle < 180:
            returned = ms.apply_filter(MORPH, connectivity=UNION)
            said = json.loads(bytes(map(int, returned["warnings"])).decode())
            assert any(words in str(remark) for remark in said), said
        else:
            with is_refused(ms, words, "50 %"):
                ms.apply_filter(MORPH)


def test_one_surface_and_wrong_numbers_are_refused():
    ms = mapped_cycle(1)
    with is_refused(ms, "only visible surface with a map"):
        ms.apply_filter(MORPH)
    ms = mapped_cycle(2)
    for wrong, words in (
        ({"steps": 0}, "number of steps must lie between 1"),
        ({"frequency": 0}, "frequency"),
        ({"threads": -1}, "number of threads"),
        ({"steps": 10000, "frequency": 100}, "number of vertices of the morph"),
    ):
        with is_refused(ms, words):
            ms.apply_filter(MORPH, **wrong)
