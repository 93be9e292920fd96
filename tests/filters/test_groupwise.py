# SPDX-License-Identifier: GPL-3.0-only
"""Maps of a population, optimised together: through PyMeshLab."""

import json

import numpy as np
import pymeshlab
import pytest
from documents import (
    EVALUATE,
    GROUPWISE,
    PROPAGATE,
    REMESH,
    ROOT,
    add,
    mapped_cycle,
    positions,
    snapshot,
)
from surfaces import egg


@pytest.fixture(scope="module")
def eggs():
    """Five eggs of two modes as a population, propagated."""
    ms = pymeshlab.MeshSet()
    v, f = egg()
    random = np.random.default_rng(4)
    for k in range(5):
        a, b = 0.15 * random.standard_normal(2)
        size = np.abs(v).max()
        x = v * [1 + a, 1, 1 - a]
        add(ms, x + b * size * np.outer((v[:, 0] / size) ** 2, [0, 1, 0]), f, f"egg {k}")
    ms.set_current_mesh(0)
    ms.apply_filter(ROOT)
    ms.apply_filter(PROPAGATE, order="Star")
    return [(m.vertex_matrix(), m.face_matrix(), positions(m).copy()) for m in ms]


def said(returned):
    """(layer, message) of each warning."""
    remarks = json.loads(bytes(map(int, returned["warnings"])).decode())
    return [(remark["layer"], remark["message"]) for remark in remarks]


def project(eggs):
    ms = pymeshlab.MeshSet()
    for k, (v, f, s) in enumerate(eggs):
        add(ms, v, f, f"egg {k}")
        ms.current_mesh().add_vertex_custom_point_attribute(s, "sphere_position")
    return ms


def test_a_shape_that_does_not_belong_is_named(eggs):
    v, f = egg()
    more = [(v * [1 + a, 1 - a, 1], f, eggs[0][2]) for a in (-0.1, -0.05, 0.05, 0.1)]
    ms = project(eggs + more)
    x, y = v[:, 0], v[:, 1]
    wave = 0.6 + 0.8 * np.cos(3 * np.arctan2(y, x)) * np.hypot(x, y) / np.abs(v).max()
    odd = v * wave[:, None]
    add(ms, odd, f, "odd one")
    ms.current_mesh().add_vertex_custom_point_attribute(eggs[0][2], "sphere_position")
    found = ms.apply_filter(GROUPWISE, iterations=3)
    assert ("odd one", "shapeNotCommon") in said(found)
    assert found["trust"][-1] < 0.5 and (found["trust"][:-1] > 0.6).all()
    assert found["flipped_faces"].sum() == 0


@pytest.mark.parametrize("objective", ["Population model", "Description length"])
@pytest.mark.parametrize("alignment", ["Rigid", "Similarity", "None"])
def test_maps_are_moved_and_valid(eggs, objective, alignment):
    ms = project(eggs)
    found = ms.apply_filter(GROUPWISE, objective=objective, alignment=alignment, iterations=3)
    assert ms.apply_filter(EVALUATE)["valid"].all()
    assert found["flipped_faces"].sum() == 0 and (found["tangential_move"] > 0).all()
    assert len(found["move_by_iteration"]) == 3 and len(found["total_variance"]) == 2
    assert (found["surface_precision"] > 0) == (objective == "Population model")
    for m, (_, _, before) in zip(ms, eggs):
        assert not np.allclose(positions(m), before, atol=1e-5)


def test_the_maps_belong_together_and_to_no_others(eggs):
    ms = mapped_cycle(3)
    ms.apply_filter(GROUPWISE, iterations=1)
    roots = ms.apply_filter(EVALUATE)["root"]
    assert len(set(roots)) == 1 and roots[0] > 0
    assert "warnings" not in ms.apply_filter(REMESH, frequency=3)


def test_landmarks_of_before_are_named():
    ms = mapped_cycle(3)
    ms.apply_filter(REMESH, frequency=3)
    ms.apply_filter(GROUPWISE, iterations=1)
    texts = bytes(
        ms.apply_filter("compute_statistical_shape_model", mode_layers=0)["warnings"].astype(
            np.uint8
        )
    ).decode()
    assert "mapsChanged" in texts


def test_threads_change_nothing(eggs):
    one, two = project(eggs), project(eggs)
    one.apply_filter(GROUPWISE, iterations=2, threads=1)
    two.apply_filter(GROUPWISE, iterations=2, threads=2)
    for a, b in zip(one, two):
        assert np.array_equal(positions(a), positions(b))


@pytest.mark.parametrize(
    "wrong",
    [
        {"iterations": 0},
        {"iterations": 1001},
        {"surface_precision": -1.0},
        {"prior_shapes": 0.0},
        {"frequency": 2},
        {"frequency": 31},
        {"threads": -1},
        {"anchor_sd": -1.0},
    ],
)
def test_what_is_out_of_range_is_refused_and_nothing_changes(eggs, wrong):
    ms = project(eggs)
    before = snapshot(ms)
    with pytest.raises(pymeshlab.PyMeshLabException):
        ms.apply_filter(GROUPWISE, **wrong)
    assert snapshot(ms) == before


def test_one_layer_has_nothing_in_common_with_others(eggs):
    ms = project(eggs[:1])
    before = snapshot(ms)
    with pytest.raises(pymeshlab.PyMeshLabException, match="nothing to compare it with"):
        ms.apply_filter(GROUPWISE)
    assert snapshot(ms) == before


def test_layers_without_a_map_are_left_out(eggs):
    ms = project(eggs[:3])
    add(ms, *egg(), "no map")
    found = ms.apply_filter(GROUPWISE, iterations=1)
    assert len(found["tangential_move"]) == 3 and b"leftOutWithoutMap" in bytes(
        found["warnings"].astype(np.uint8)
    )


def with_anchors(eggs, count=5, names=("tip", "side", "end")):
    """Each at the vertex of its own, which is the same material on all of them."""
    ms = project(eggs)
    v = eggs[0][0]
    at = dict(zip(names, (v[:, 0].argmax(), v[:, 1].argmax(), v[:, 0].argmin())))
    for mesh in list(ms)[:count]:
        x = mesh.vertex_matrix()
        for name, vertex in at.items():
            places = np.tile(x[vertex], (len(x), 1))
            mesh.add_vertex_custom_point_attribute(places, f"anchor_{name}")
    return ms


def test_anchors_that_layers_carry_are_brought_together(eggs):
    ms, off = with_anchors(eggs, 4), with_anchors(eggs, 4)
    found = ms.apply_filter(GROUPWISE, iterations=3, anchor_sd=0.01 * np.abs(eggs[0][0]).max())
    plain = off.apply_filter(GROUPWISE, iterations=3, anchors="Off")
    assert "anchor_distance_mean" not in plain
    distance = found["anchor_distance_mean"]
    assert np.isfinite(distance[:4]).all() and np.isnan(distance[4])
    assert (distance[:4] < 0.02 * np.abs(eggs[0][0]).max()).all()
    assert not np.allclose(positions(ms.mesh(0)), positions(off.mesh(0)), atol=1e-4)
    assert ms.apply_filter(EVALUATE)["valid"].all()


def test_anchors_of_one_layer_alone_and_of_the_other_objective_are_named(eggs):
    ms = with_anchors(eggs, 1, ("typo",))
    found = ms.apply_filter(GROUPWISE, iterations=1)
    assert "anchor_distance_mean" not in found
    assert "anchorsOnOneLayer" in [message for _, message in said(found)]
    ms = with_anchors(eggs)
    found = ms.apply_filter(GROUPWISE, iterations=1, objective="Description length")
    assert "groupwiseLeavesAnchors" in [message for _, message in said(found)]


def test_anchors_that_held_exactly_are_said_to_move(eggs):
    ms = project(eggs)
    for mesh in ms:
        v = mesh.vertex_matrix()
        tip = np.tile(v[v[:, 0].argmax()], (len(v), 1))
        mesh.add_vertex_custom_point_attribute(tip, "anchor_tip")
    words = "held anchors exactly"

    def warned():
        returned = ms.apply_filter(GROUPWISE, iterations=1)
        return words in bytes(map(int, returned.get("warnings", []))).decode()

    ms.set_current_mesh(0)
    ms.apply_filter(PROPAGATE, order="Star", anchors="Soft")
    assert not warned()
    ms.apply_filter(PROPAGATE, order="Star", anchors="Exact")
    assert warned()
    assert not warned(), "they hold no longer"
    ms.apply_filter(PROPAGATE, order="Star", anchors="Exact")
    ms.apply_filter(PROPAGATE, order="Star", anchors="Soft")
    assert not warned()
