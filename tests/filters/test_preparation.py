# SPDX-License-Identifier: GPL-3.0-only
"""Prepare surface: meshes as they come get maps afterwards; what is clean is left alone."""

import json

import numpy as np
import pymeshlab
import pytest
import surfaces
from documents import (
    MODEL,
    PREPARE,
    PROPAGATE,
    REMESH,
    ROOT,
    add,
    layer,
    layers,
    refused,
    small_cycle,
    snapshot,
)
from surfaces import egg

DEFECTS = {
    "open": (surfaces.open_egg, {"close_openings": 1}),
    "two parts": (surfaces.two_parts, {"keep_largest_component": 1}),
    "crumb": (surfaces.small_second_part, {"keep_largest_component": 1}),
    "fin": (surfaces.fin_on_an_edge, {"remove_fins": 1}),
    "pinched": (
        surfaces.pinched_at_a_vertex,
        {"remove_fins": 1, "keep_largest_component": 1},
    ),
    "one face turned": (surfaces.one_face_turned, {"orient": 1}),
    "half turned": (surfaces.half_the_faces_turned, {"orient": 140}),
    "inside out": (surfaces.inside_out, {"orient": 280}),
    "nan": (lambda: surfaces.with_coordinate(np.nan), {"weld": 1, "close_openings": 1}),
    "unreferenced": (surfaces.unreferenced_vertices, {"weld": 2}),
    "unwelded": (surfaces.unwelded, {"weld": 698}),
    "a vertex twice": (surfaces.face_with_a_vertex_twice, {"remove_duplicate_faces": 1}),
    "handle": (surfaces.torus, {"remove_handles": 1}),
}
STEPS = [
    "weld",
    "remove_duplicate_faces",
    "remove_fins",
    "keep_largest_component",
    "close_openings",
    "orient",
    "remove_handles",
]


def said(returned):
    """The warnings' texts, with the layers' names."""
    if "warnings" not in returned:
        return []
    remarks = json.loads(bytes(map(int, returned["warnings"])).decode())
    return [f"{remark['layer']}: {remark['text']}" for remark in remarks]


def cup(below=20.0):
    """The egg without its upper end."""
    v, f = egg()
    return v, f[(v[f][:, :, 2] < below).all(axis=1)]


@pytest.mark.parametrize("case", DEFECTS)
def test_each_defect_is_mended_and_counted(case):
    make, counts = DEFECTS[case]
    ms = pymeshlab.MeshSet()
    add(ms, *make(), "bad")
    returned = ms.apply_filter(PREPARE, remove_handles=True)
    assert returned["closed"] == 1
    assert {s: int(returned[s][0]) for s in STEPS if returned[s][0]} == counts
    assert ms.apply_filter(ROOT)["flipped_faces"] == 0
    assert ms.apply_filter(PREPARE)["close_openings"] == 0


def test_what_is_closed_is_left_alone():
    ms = small_cycle(1)
    before = snapshot(ms)
    returned = ms.apply_filter(PREPARE)
    assert snapshot(ms) == before
    assert returned["closed"] == 1 and not any(returned[s][0] for s in STEPS)


def test_lids_are_marked_and_the_wall_stays():
    v, f = cup()
    ms = pymeshlab.MeshSet()
    colours = np.random.default_rng(0).integers(0, 256, (len(v), 4)) / 255
    add(ms, v, f, "cup", v_color_matrix=colours)
    returned = ms.apply_filter(PREPARE)
    mesh = ms.current_mesh()
    lid = mesh.vertex_custom_scalar_attribute_array("lid")
    wall = np.unique(f)
    assert (mesh.vertex_matrix()[lid == 0] == v[wall]).all()
    assert (mesh.vertex_color_matrix()[lid == 0, :3] == colours[wall, :3]).all()
    assert set(lid) == {0, 1} and returned["lid"] == (lid > 0).sum()
    assert (mesh.vertex_selection_array() == (lid > 0)).all()
    selected = mesh.face_selection_array()
    assert not selected[: len(f)].any() and selected[len(f) :].all()
    assert returned["opening_edges"] == [14] and returned["opening_layer"] == [0]
    rim = v[np.isclose(v[:, 2], v[wall][:, 2].max())]
    around = np.linalg.norm(rim - np.roll(rim, 1, axis=0), axis=1).sum()
    assert returned["opening_perimeter"] == pytest.approx([around])


def two_shells():
    """The two sides of a cup's wall, without the rim between them."""
    v, f = cup(15)
    inner = v * [0.7, 0.7, 0.8] + [0, 0, 2]
    return np.vstack([v, inner]), np.vstack([f, f + len(v)])


def test_the_sides_of_a_wall_are_named_and_joined():
    volume = {}
    for join in (False, True):
        ms = pymeshlab.MeshSet()
        add(ms, *two_shells(), "wall")
        returned = ms.apply_filter(PREPARE, join_shells=join)
        text = " ".join(said(returned))
        assert ("wall: it is the inner and the outer side of one wall" in text) != join
        assert returned["join_shells"] == join and returned["closed"] == 1
        assert returned["keep_largest_component"] == (not join)
        volume[join] = ms.apply_filter("get_geometric_measures")["mesh_volume"]
        assert ms.apply_filter(ROOT)["flipped_faces"] == 0
    assert 0.3 * volume[False] < volume[True] < 0.7 * volume[False]
    assert ms.current_mesh().face_selection_array().sum() >= 28


def test_walls_that_are_open_twice_are_joined_once():
    v, f = two_shells()
    half = len(v) // 2
    side = v[:half, 0] - np.abs(v[:half, 2] + 20)
    for beside in (side.argmax(), half + side.argmax()):  # a hole in each shell
        f = f[(f != beside).all(axis=1)]
    ms = pymeshlab.MeshSet()
    add(ms, v, f, "wall")
    returned = ms.apply_filter(PREPARE, join_shells=True)
    text = " ".join(said(returned))
    assert returned["join_shells"] == 1 and returned["closed"] == 1
    assert len(returned["opening_edges"]) == 3
    assert "wall: the sides of its wall are joined at 1 opening; the 2 other ones are" in text


def test_parts_that_are_no_wall_are_not_to_be_joined():
    v, f = two_shells()
    half = len(v) // 2
    v[half:, 2] *= -1  # open to the other side
    ms = pymeshlab.MeshSet()
    add(ms, v, f, "wall")
    returned = ms.apply_filter(PREPARE, join_shells=True)
    text = " ".join(said(returned))
    assert returned["join_shells"] == 0 and returned["closed"] == 1
    assert "It is not joined: it does not lie within that one, or no rim" in text


def lid_of(mesh):
    return mesh.vertex_custom_scalar_attribute_array("lid")


def test_landmarks_and_the_model_know_of_lids(tmp_path):
    ms = pymeshlab.MeshSet()
    for k, below in enumerate((20, 19, 20.5, 21)):
        v, f = cup(below)
        add(ms, v * [1, 1, 1 + k / 20], f, f"phase {k}")
    ms.set_current_mesh(0)
    ms.apply_filter(PREPARE, all_visible=True)
    ms.apply_filter(ROOT)
    ms.apply_filter(PROPAGATE)
    returned = ms.apply_filter(REMESH, frequency=6)
    landmarks = [m for m in ms if m.label().endswith("landmarks")]
    on = np.array([lid_of(m) > 0 for m in landmarks])
    assert (returned["lid"] == on.sum(1)).all() and (on.sum(1) > 5).all()
    assert (on != on[0]).any()
    for source, mesh, lids in zip(ms, landmarks, on):
        assert (mesh.vertex_selection_array() == lids).all()
        rim = source.vertex_matrix()[lid_of(source) == 0][:, 2].max()
        height = mesh.vertex_matrix()[:, 2]
        assert height[lids].min() >= rim - 1e-9 and height[~lids].max() <= rim + 1e-9
        faces = mesh.face_matrix()
        assert (mesh.face_selection_array() == lids[faces].all(1)).all()
    path = tmp_path / "model.npz"
    for rule, left_out in (
        ("Most shapes", on.sum(0) >= 2),
        ("Any shape", on.any(0)),
        ("Never", np.zeros(362, bool)),
    ):
        model = ms.apply_filter(MODEL, leave_out_lids=rule, export_file=str(path))
        assert ((model["lid"] > 0) == left_out).all()
        assert model["landmarks"] == (~left_out).sum()
        with np.load(path) as file:
            assert (file["lid"] == left_out).all() and file["lid"].dtype == bool
            assert len(file["mean"]) == (~left_out).sum() > file["faces"].max()
            assert len(file["faces"]) == (~left_out[faces].any(1)).sum()
        assert layer(ms, "mean shape").vertex_number() == (~left_out).sum()
    default = ms.apply_filter(MODEL)
    assert ((default["lid"] > 0) == (on.sum(0) >= 2)).all()


def test_layers_without_lids_among_others_are_named():
    ms = pymeshlab.MeshSet()
    for k, (v, f) in enumerate((cup(), egg(), egg(), egg(), egg())):
        add(ms, v, f, f"phase {k}")
    ms.set_current_mesh(0)
    ms.apply_filter(PREPARE)
    ms.apply_filter(ROOT)
    ms.apply_filter(PROPAGATE)
    text = " ".join(said(ms.apply_filter(REMESH, frequency=4)))
    assert all(f'"phase {k}"' in text for k in (1, 2, 3, 4)) and "carry no lids" in text
    assert '"phase 0"' not in text
    returned = ms.apply_filter(MODEL)
    assert returned["landmarks"] == 162 and not returned["lid"].any()
    assert "fewer than half" in " ".join(said(returned))


def test_a_flat_lid_is_flat_and_a_curved_one_is_not():
    heights = {}
    for lid in ("Flat", "Curved"):
        ms = pymeshlab.MeshSet()
        add(ms, *cup(), "cup")
        ms.apply_filter(PREPARE, lid=lid)
        made = ms.current_mesh().vertex_custom_scalar_attribute_array("lid") > 0
        heights[lid] = ms.current_mesh().vertex_matrix()[made, 2]
    rim = cup()[0][np.unique(cup()[1])][:, 2].max()
    assert heights["Flat"] == pytest.approx(rim)
    assert (heights["Curved"] > rim).all()


@pytest.mark.parametrize("mirror", [1, -1])
def test_the_matrix_stays(mirror):
    v, f = cup()
    ms = pymeshlab.MeshSet()
    add(ms, v, f, "cup")
    matrix = np.diag([mirror * 2.0, 3, 4, 1])
    matrix[:3, 3] = 5, 6, 7
    ms.apply_filter("set_matrix", transformmatrix=matrix, freeze=False)
    ms.apply_filter(PREPARE)
    mesh = ms.current_mesh()
    assert (mesh.transform_matrix() == matrix).all()
    lid = mesh.vertex_custom_scalar_attribute_array("lid")
    assert (mesh.vertex_matrix()[lid == 0] == v[np.unique(f)]).all()
    assert mesh.vertex_matrix()[lid > 0, 2].min() > v[np.unique(f)][:, 2].max()
    assert ms.apply_filter(ROOT)["flipped_faces"] == 0


def test_all_visible_layers():
    ms = pymeshlab.MeshSet()
    for label, mesh in (("open", cup()), ("closed", egg()), ("hidden", cup()), ("two", cup(10))):
        add(ms, *mesh, label)
    ms.set_mesh_visibility(2, False)
    returned = ms.apply_filter(PREPARE, all_visible=True)
    assert list(returned["close_openings"]) == [1, 0, 1]
    assert list(returned["opening_layer"]) == [0, 2]
    assert [m.vertex_number() for m in layers(ms)][2] == len(cup()[0])


def test_steps_that_are_off_do_nothing():
    ms = pymeshlab.MeshSet()
    add(ms, *surfaces.two_parts(), "two")
    before = snapshot(ms)
    returned = ms.apply_filter(PREPARE, keep_largest_component=False)
    assert snapshot(ms) == before and returned["closed"] == 0


def moebius_strip(around=60):
    t = np.repeat(np.linspace(0, 2 * np.pi, around, endpoint=False), 2)
    w = np.tile([-0.3, 0.3], around)
    r = 1 + w * np.cos(t / 2)
    a = np.arange(0, 2 * around, 2)
    b, c = np.append(a[1:], 1), np.append(a[1:] + 1, 0)
    return (
        np.column_stack([r * np.cos(t), r * np.sin(t), w * np.sin(t / 2)]),
        np.concatenate([np.column_stack([a, b, a + 1]), np.column_stack([a + 1, b, c])]),
    )


@pytest.mark.parametrize(
    "mesh, options, words",
    [
        (moebius_strip(), {}, "one side only"),
        (moebius_strip(), {"orient": False, "close_openings": False}, "one side only"),
        ((np.eye(3), np.array([[0, 1, 2]])), {}, "too little of it"),
        ((np.eye(3), np.array([[0, 1, 2]])), {"weld": False}, "too little of it"),
    ],
)
def test_no_step_is_advised_that_would_not_help(mesh, options, words):
    ms = pymeshlab.MeshSet()
    add(ms, *mesh, "strip")
    returned = ms.apply_filter(PREPARE, **options)
    assert returned["closed"] == 0
    (warning,) = said(returned)
    assert words in warning and "left out" not in warning


def test_sheets_of_a_share_of_the_area_are_a_warning():
    v, f = egg()
    below = (v[f][:, :, 2] < 5).all(axis=1)
    sides = np.concatenate([f[below][:, [0, 1]], f[below][:, [1, 2]], f[below][:, [2, 0]]])
    _, index, count = np.unique(
        np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    rim = sides[count[index.ravel()] == 1]
    septum = np.column_stack([rim[:, ::-1], np.full(len(rim), len(v))])
    v = np.concatenate([v, [v[rim[:, 0]].mean(axis=0)]])
    # Two chambers, each with the septum as its wall: one body now.
    ms = pymeshlab.MeshSet()
    add(ms, v, np.concatenate([f, septum, septum[:, ::-1]]), "two chambers")
    returned = ms.apply_filter(PREPARE)
    assert returned["closed"] == 1
    (warning,) = said(returned)
    assert "dropped as fins or membranes" in warning and "two chambers" in warning
    ms = pymeshlab.MeshSet()
    add(ms, *surfaces.fin_on_an_edge(), "fin")
    assert not said(ms.apply_filter(PREPARE))


def ragged(depth, seed=0):
    """A cup of 3,000 vertices whose rim is the staircase of its faces, with notches in a sixth of
    them, `depth` faces deep."""
    ms = pymeshlab.MeshSet()
    ms.create_sphere(radius=1, subdiv=5)
    v, f = ms.mesh(0).vertex_matrix(), ms.mesh(0).face_matrix()
    v = v / np.linalg.norm(v, axis=1, keepdims=True) * [25, 25, 42]
    keep = v[f].mean(1) @ [0.2, -0.1, 1] < 20
    touches = np.isin(f, f[~keep]).any(1)
    random = np.random.default_rng(seed)
    rim = np.flatnonzero(keep & touches)
    for start in random.choice(rim, len(rim) // 6 if depth else 0, replace=False):
        notch = np.array([start])
        for _ in range(depth - 1):
            notch = np.flatnonzero(np.isin(f, f[notch]).sum(1) >= 2)
        keep[notch] = False
    return surfaces.without_unreferenced(v, f[keep])


@pytest.mark.parametrize("lid", ["Flat", "Curved"])
def test_a_ragged_rim_is_closed_and_said_to_be_ragged(lid):
    """A staircase is none; the lid of a rim with notches goes into them."""
    volumes = []
    for depth in (0, 6):
        ms = pymeshlab.MeshSet()
        add(ms, *ragged(depth), "cup")
        figures = ms.apply_filter(PREPARE, lid=lid)
        assert figures["closed"] == 1 and lid_of(ms.mesh(0)).max() == 1
        assert ["is ragged" in text for text in said(figures)] == [True] * (depth > 0)
        volumes.append(ms.get_geometric_measures()["mesh_volume"])
    assert 0.8 * volumes[0] < volumes[1] < 0.99 * volumes[0]


@pytest.mark.parametrize("lid", ["Curved", "Flat"])
def test_a_surface_that_is_mostly_lid_is_a_warning(lid):
    for below, warns in ((20, False), (-15, True)):
        ms = pymeshlab.MeshSet()
        add(ms, *cup(below), "cup")
        returned = ms.apply_filter(PREPARE, lid=lid)
        assert returned["closed"] == 1
        assert ["of its area are lids" in text for text in said(returned)] == [True] * warns


def test_nothing_to_prepare_is_refused():
    ms = pymeshlab.MeshSet()
    add(ms, *surfaces.points_only(), "points")
    with refused(ms, '"points"', "vertices but no faces"):
        ms.apply_filter(PREPARE)


def cut(z, scale=1.0):
    """An egg open at both ends (z: lower, upper; None: closed there), in any size."""
    v, f = egg(14, 20)
    low, high = z
    keep = np.ones(len(f), bool)
    if low is not None:
        keep &= (v[f][:, :, 2] > low).all(axis=1)
    if high is not None:
        keep &= (v[f][:, :, 2] < high).all(axis=1)
    return v * scale, f[keep]


def openings_said(returned):
    found = json.loads(bytes(map(int, returned.get("warnings", []))).decode() or "[]")
    return [(r["layers"], r["text"]) for r in found if r["message"] == "openingsDiffer"]


@pytest.mark.parametrize("odd, other", [((None, 20), (-20, 20)), ((-20, 20), (None, 20))])
def test_other_numbers_of_openings_are_named(odd, other):
    ms = pymeshlab.MeshSet()
    for i in range(5):
        add(ms, *cut(odd if i in (1, 3) else other, 1 + 0.01 * i), f"p_{i}")
    few, many = ("1", "2") if odd[0] is None else ("2", "1")
    text = f'"p_1", "p_3" {few}, the others {many}.'
    ((names, said_of),) = openings_said(ms.apply_filter(PREPARE, all_visible=True))
    assert names == ["p_1", "p_3"] and text in said_of
    # The lids tell later, too.
    ms.set_current_mesh(0)
    ms.apply_filter(ROOT)
    ms.apply_filter(PROPAGATE)
    ((names, said_of),) = openings_said(ms.apply_filter(REMESH, frequency=4))
    assert names == ["p_1", "p_3"] and text in said_of


def test_openings_of_closed_surfaces_and_of_two_halves():
    ms = pymeshlab.MeshSet()
    for i, z in enumerate([(None, 20), (None, 20), (None, None)]):
        add(ms, *cut(z), f"p_{i}")
    ((names, text),) = openings_said(ms.apply_filter(PREPARE, all_visible=True))
    assert names == ["p_2"] and '"p_2" none, the others 1.' in text
    ms = pymeshlab.MeshSet()
    for i, z in enumerate([(None, 20), (None, 20), (-20, 20), (-20, 20)]):
        add(ms, *cut(z), f"p_{i}")
    ((names, text),) = openings_said(ms.apply_filter(PREPARE, all_visible=True))
    assert names == [f"p_{i}" for i in range(4)] and '"p_0", "p_1" 1, "p_2", "p_3" 2.' in text


def test_equal_openings_and_missing_faces_are_no_matter():
    ms = pymeshlab.MeshSet()
    for i in range(3):
        v, f = cut((-20, 20), 1 + 0.05 * i)
        add(ms, v, np.delete(f, [i * 40 + 17], axis=0) if i else f, f"p_{i}")
    assert openings_said(ms.apply_filter(PREPARE, all_visible=True)) == []
    assert openings_said(ms.apply_filter(PREPARE, all_visible=True)) == []
