# SPDX-License-Identifier: GPL-3.0-only
"""What is seen after a filter: where its layers are shown, which one is the current one, and how
its log ends."""

import numpy as np
import pymeshlab
import pytest
from documents import (
    COLOR,
    LAYOUT,
    LOAD,
    MODEL,
    PROPAGATE,
    REMESH,
    ROOT,
    SPHERES,
    add,
    landmark_layers,
    mapped_cycle,
    snapshot,
)
from filter_log import lines_of
from surfaces import egg


def box(mesh):
    v = mesh.transformed_vertex_matrix()
    return v.min(0)[:2], v.max(0)[:2]  # as MeshLab looks at it


def apart(meshes):
    boxes = [box(m) for m in meshes]
    return all(
        (low > h).any() or (high < left).any()
        for i, (low, high) in enumerate(boxes)
        for left, h in boxes[:i]
    )


def moved_only(before, after):
    """Whether layers differ in their matrices alone."""
    changed = {
        key
        for a, b in zip(before["layers"], after["layers"])
        for key in a
        if a[key] != b[key] and key != "matrix"
    }
    return not changed and before["current"] == after["current"]


# ---------------------------------------------------------------- side by side


def test_layers_are_laid_out_and_brought_back():
    ms = mapped_cycle(4)
    ms.apply_filter(REMESH, frequency=4)
    matrix = np.array([[0, -1, 0, 5], [1, 0, 0, 1 / 3], [0, 0, 1, -2], [0, 0, 0, 1.0]])
    ms.set_current_mesh(1)
    ms.apply_filter("set_matrix", transformmatrix=matrix, freeze=False)
    before = snapshot(ms)
    assert not apart(ms)
    assert ms.apply_filter(LAYOUT) == {"layers": 8, "side_by_side": True}
    assert apart(ms) and moved_only(before, snapshot(ms))
    # In reading order, landmarks to the right of the surfaces.
    low = [box(m)[0] for m in ms]
    assert low[0][0] < low[1][0] and low[0][1] > low[3][1]
    assert max(box(m)[1][0] for m in list(ms)[:4]) < min(box(m)[0][0] for m in list(ms)[4:])
    assert ms.apply_filter(LAYOUT) == {"layers": 8, "side_by_side": False}
    assert snapshot(ms) == before  # bit for bit


def test_shown_anchors_go_with_their_layer(tmp_path):
    ms = mapped_cycle(2)
    for mesh in ms:
        place = ",".join(map(repr, map(float, mesh.vertex_matrix()[0])))
        (tmp_path / f"{mesh.label()}.csv").write_text(f"name,x,y,z\napex,{place}\n")
    ms.apply_filter(LOAD, file_name=str(tmp_path), show_anchors=True)
    assert ms.mesh_number() == 4
    before = snapshot(ms)
    assert ms.apply_filter(LAYOUT)["layers"] == 2
    surfaces, balls = list(ms)[:2], list(ms)[2:]
    for surface, ball in zip(surfaces, balls):
        assert np.array_equal(surface.transform_matrix(), ball.transform_matrix())
    assert not np.array_equal(balls[1].transform_matrix(), np.eye(4))
    ms.apply_filter(LAYOUT)
    assert snapshot(ms) == before
    # Also where they are shown while it lies there.
    laid = mapped_cycle(2)
    laid.apply_filter(LAYOUT)
    laid.apply_filter(LOAD, file_name=str(tmp_path), show_anchors=True)
    assert np.allclose(laid.mesh(1).transform_matrix(), laid.mesh(3).transform_matrix())
    laid.apply_filter(LAYOUT)
    assert np.allclose(laid.mesh(3).transform_matrix(), np.eye(4))


def test_a_layer_that_is_shown_later_is_laid_out_with_the_others():
    ms = mapped_cycle(3)
    ms.set_current_mesh(2)
    ms.set_current_mesh_visibility(False)
    before = [m.transform_matrix() for m in ms]
    assert ms.apply_filter(LAYOUT)["layers"] == 2
    assert np.array_equal(ms.mesh(2).transform_matrix(), np.eye(4))
    ms.set_current_mesh_visibility(True)
    assert ms.apply_filter(LAYOUT) == {"layers": 3, "side_by_side": True}
    assert apart(ms)
    assert not ms.apply_filter(LAYOUT)["side_by_side"]
    assert all(np.array_equal(a, m.transform_matrix()) for a, m in zip(before, ms))


def test_filters_take_layers_where_they_belong():
    """Propagation, landmarks and the model are the same, laid out or not."""
    plain, laid = mapped_cycle(3), mapped_cycle(3)
    for ms in (plain, laid):
        if ms is laid:
            ms.apply_filter(LAYOUT)
        returned = [ms.apply_filter(PROPAGATE, order="Cyclic time")]
        returned += [ms.apply_filter(REMESH, frequency=4)]
        if ms is laid:
            ms.apply_filter(LAYOUT)  # the landmarks as well
        returned += [ms.apply_filter(MODEL, alignment="None")]
        for found in returned:
            found.pop("seconds")
        if ms is plain:
            first = returned
    for a, b in zip(first, returned):
        assert set(a) == set(b)
        assert all(np.array_equal(a[key], b[key]) for key in a)


def test_a_layer_that_was_moved_by_hand_stays_moved():
    ms = mapped_cycle(2)
    ms.apply_filter(LAYOUT)
    ms.set_current_mesh(1)
    by_hand = ms.mesh(1).transform_matrix().copy()
    by_hand[:3, 3] += (1, 2, 3)
    ms.apply_filter("set_matrix", transformmatrix=by_hand, freeze=False)
    ms.apply_filter(LAYOUT)
    assert np.allclose(ms.mesh(1).transform_matrix()[:3, 3], (1, 2, 3))


def test_a_surface_that_is_prepared_stays_aside():
    ms = pymeshlab.MeshSet()
    v, f = egg()
    add(ms, v, f, "whole")
    add(ms, v, f[:-1], "open")
    ms.apply_filter(LAYOUT)
    seen = box(ms.mesh(1))
    ms.apply_filter("apply_surface_preparation")
    assert np.allclose(seen, box(ms.mesh(1)), atol=1e-6)
    ms.apply_filter(LAYOUT)
    assert np.allclose(ms.mesh(1).transform_matrix(), np.eye(4))


def test_nothing_to_lay_out():
    ms = pymeshlab.MeshSet()
    v, f = egg()
    add(ms, v, f, "egg")
    ms.set_current_mesh_visibility(False)
    with pytest.raises(pymeshlab.PyMeshLabException, match="No layer with vertices is visible"):
        ms.apply_filter(LAYOUT)


# ---------------------------------------------------------------- results


def test_spheres_stand_beside_the_surfaces():
    ms = mapped_cycle(2)
    ms.apply_filter(SPHERES, beside_surfaces=True)
    right = max(box(ms.mesh(i))[1][0] for i in (0, 1))
    assert all(box(m)[0][0] > right for m in list(ms)[2:])


def test_landmarks_and_modes_beside_what_they_came_from():
    """On by default where there is a window; in scripts new layers have the identity."""
    plain, aside = mapped_cycle(3), mapped_cycle(3)
    for ms, beside in ((plain, False), (aside, True)):
        ms.apply_filter(REMESH, frequency=4, beside_surfaces=beside)
        ms.apply_filter(MODEL, beside_shapes=beside, alignment="None")
        assert ms.current_mesh_id() == 0  # as scripts expect; in a window it is the mean shape
    assert all(np.array_equal(m.transform_matrix(), np.eye(4)) for m in plain)
    right = max(box(m)[1][0] for m in list(aside)[:3])
    landmarks, model = landmark_layers(aside), list(aside)[6:]
    assert apart(landmarks) and apart(model)
    assert min(box(m)[0][0] for m in landmarks) > right
    assert min(box(m)[0][0] for m in model) > max(box(m)[1][0] for m in landmarks)
    for a, b in zip(plain, aside):
        assert np.array_equal(a.vertex_matrix(), b.vertex_matrix())
    # Run again, they are where they were.
    where = [m.transform_matrix() for m in aside]
    aside.apply_filter(REMESH, frequency=4, beside_surfaces=True)
    aside.apply_filter(MODEL, beside_shapes=True, alignment="None")
    assert len(where) == aside.mesh_number()
    where_now = [m.transform_matrix() for m in aside]
    assert np.allclose(where[6:], where_now[6:])
    aside.apply_filter(LAYOUT), aside.apply_filter(LAYOUT)
    assert all(np.allclose(m.transform_matrix(), np.eye(4)) for m in aside)


def test_modes_stand_in_rows_behind_the_mean():
    """Minus before plus, made so and laid out so."""
    ms = mapped_cycle(4)
    ms.apply_filter(REMESH, frequency=4)
    ms.apply_filter(MODEL, beside_shapes=True, mode_layers=2, alignment="None")
    for _ in range(2):
        at = {m.label(): sum(box(m)) / 2 for m in list(ms)[8:]}
        mean = at.pop("mean shape")
        x, y = np.reshape(list(at.values()), (2, 2, 2)).transpose(2, 0, 1)  # mode, sign
        assert list(at)[:2] == ["mode 1 -3 sd", "mode 1 +3 sd"]
        assert np.allclose(x[0], x[1]) and mean[0] < x[0, 0] < x[0, 1]
        assert np.allclose(y[:, 0], y[:, 1]) and y[0, 0] > mean[1] > y[1, 0]
        assert apart(list(ms)[8:])
        ms.apply_filter(LAYOUT)


def test_a_model_is_fitted_to_a_surface_unless_told_otherwise():
    """Also where the current layer is one that a filter made, as the mean shape is."""
    ms = mapped_cycle(3)
    ms.apply_filter(REMESH, frequency=4)
    ms.apply_filter(MODEL, alignment="None")
    for current, target in ((2, 2), (ms.mesh_number() - 1, 0), (3, 0)):
        ms.set_current_mesh(current)
        assert ms.filter_parameter_values("compute_shape_model_fit")["target_layer"] == target


def test_a_fit_is_shown_on_its_surface(tmp_path):
    """Also where surfaces are laid out; it belongs where the surface does."""
    ms, file = mapped_cycle(4), str(tmp_path / "model.npz")
    ms.apply_filter(REMESH, frequency=4)
    ms.apply_filter(MODEL, alignment="None", export_file=file)
    ms.apply_filter(LAYOUT)
    ms.apply_filter("compute_shape_model_fit", model_file=file, target_layer=3, pose="As it lies")
    fit = ms.mesh(ms.mesh_number() - 1)
    assert np.allclose(box(fit), box(ms.mesh(3)), atol=0.1 * np.ptp(box(fit), axis=0).max())
    assert not ms.apply_filter(LAYOUT)["side_by_side"]  # the fit was laid out with the others
    assert np.allclose(fit.transform_matrix(), np.eye(4))


def test_the_root_is_remembered():
    """Also where another layer than a surface is the current one."""
    ms = mapped_cycle(3)
    ms.set_current_mesh(2)
    ms.apply_filter(ROOT)
    assert ms.apply_filter(PROPAGATE)["parent"].tolist() == [1, 2, -1]
    ms.apply_filter(REMESH, frequency=3)
    ms.set_current_mesh(4)
    assert ms.apply_filter(PROPAGATE)["parent"].tolist() == [1, 2, -1]


# ---------------------------------------------------------------- colours


def test_landmark_colours_tell_every_direction():
    ms = mapped_cycle(2)
    ms.apply_filter(REMESH, frequency=6)
    mesh = ms.mesh(2)
    place, colours = mesh.vertex_matrix(), mesh.vertex_color_matrix()[:, :3]
    assert np.array_equal(colours, ms.mesh(3).vertex_color_matrix()[:, :3])
    # The poles differ, and so do places on opposite sides: what is far apart is told apart.
    ms.apply_filter(REMESH, frequency=6, landmark_colors="Index as hue")
    by_index = ms.mesh(2).vertex_color_matrix()[:, :3]
    assert np.abs(by_index[0] - by_index[-1]).max() < 0.05  # the paper's: red at both ends
    assert np.abs(colours[0] - colours[-1]).max() > 0.3
    far = np.linalg.norm(place[:, None] - place[None], axis=2) > 0.6 * np.ptp(place, axis=0).max()
    assert np.abs(colours[:, None] - colours[None]).max(2)[far].min() > 0.02
    assert np.abs(by_index[:, None] - by_index[None]).max(2)[far].min() < 0.018


def test_cells_are_chosen_by_the_coarsest_mesh():
    ms = mapped_cycle(2)  # a few hundred vertices
    assert ms.filter_parameter_values(COLOR)["cells"] == 4
    fine = pymeshlab.MeshSet()
    fine.apply_filter("create_ventricle_phantom", phases=1, voxel_size=2.0)
    assert fine.filter_parameter_values(COLOR)["cells"] == 8  # nothing is known
    fine.apply_filter(ROOT)
    count = fine.mesh(0).vertex_number()
    assert fine.filter_parameter_values(COLOR)["cells"] == 2 * round((count / 54) ** 0.5 / 2)


# ---------------------------------------------------------------- the end of the log

JOB = """
ms.apply_filter(PHANTOM, phases=4, voxel_size=4)
ms.set_current_mesh(1)
ms.apply_filter(ROOT)
ms.set_current_mesh(3)
ms.set_current_mesh_visibility(False)
ms.set_current_mesh(1)
ms.apply_filter(PROPAGATE)
ms.apply_filter(REMESH, frequency=3)
ms.set_current_mesh(ms.mesh_number() - 1)
ms.set_current_mesh_visibility(False)
ms.apply_filter(MODEL, modes=9)
"""


def test_the_log_ends_with_where_the_job_stands():
    lines = lines_of(JOB)
    ends = [
        lines.index(words)
        for words in (
            '"phantom cavity 01" is mapped. Next: Propagate parameterisation to layers.',
            '3 surfaces, 3 mapped; hidden, left out: "phantom cavity 03". '
            "Next: Remesh by icosphere.",
            '3 surfaces, landmarks on 3; hidden, left out: "phantom cavity 03". '
            "Next: Build statistical shape model.",
            'A model of 2 shapes, 1 mode; hidden, left out: "phantom cavity 02 landmarks".',
        )
    ]
    assert ends == sorted(ends) and ends[-1] == len(lines) - 1
    # Notes stand right above: the better root by name, and what was asked for and is not there.
    for end, words in ((ends[0], '"phantom cavity 00"'), (ends[1], '"phantom cavity 00"')):
        assert lines[end - 1].startswith("Note: ") and words in lines[end - 1]
    assert lines[ends[3] - 1] == "Note: there are no more than 1 mode."


MAPPED = """
ms.apply_filter(PHANTOM, phases=3, voxel_size=4)
ms.apply_filter(ROOT)
"""
PROPAGATED = MAPPED + "ms.apply_filter(PROPAGATE)\n"
HIDE_LAST = """
ms.set_current_mesh(ms.mesh_number() - 1)
ms.set_current_mesh_visibility(False)
ms.set_current_mesh(0)
"""
OPEN = """
from surfaces import open_egg
for name in "a", "b", "c":
    add(ms, *open_egg(), name)
"""
HIDDEN = '; hidden, left out: "phantom cavity 02"'
SUMMARIES = {  # script: last line
    OPEN + "ms.apply_filter(PREPARE)": '1 surface, 1 changed, 1 closed; "All visible surfaces" is '
    "off, left out: 2 visible surfaces. Next: Spherical parameterise root.",
    OPEN + HIDE_LAST + "ms.apply_filter(PREPARE, all_visible=True)": "2 surfaces, 2 changed, "
    '2 closed; hidden, left out: "c". Next: Spherical parameterise root.',
    OPEN + "ms.apply_filter(PREPARE, all_visible=True, close_openings=False)": "3 surfaces, "
    "0 changed, 0 closed. Next: what the warnings advise.",
    PROPAGATED + "ms.apply_filter(PREPARE, all_visible=True)": "3 surfaces, 0 changed, 3 closed. "
    "Next: Remesh by icosphere.",
    PROPAGATED + "add(ms, *__import__('surfaces').open_egg(), 'late'); ms.apply_filter(PREPARE)": (
        '1 surface, 1 changed, 1 closed; "All visible surfaces" is off, left out: 3 visible '
        "surfaces. Next: Propagate parameterisation to layers."
    ),
    MAPPED + "ms.apply_filter(EVALUATE)": "3 surfaces, 1 with a valid map. "
    "Next: Propagate parameterisation to layers.",
    PROPAGATED + HIDE_LAST + "ms.apply_filter(EVALUATE)": "2 surfaces, 2 with a valid map"
    + HIDDEN
    + ". Next: Remesh by icosphere.",
    MAPPED + HIDE_LAST + "ms.apply_filter(SPHERES)": "2 surfaces, spheres of 1"
    + HIDDEN
    + ". Next: Colour by spherical parameterisation.",
    PROPAGATED + HIDE_LAST + "ms.apply_filter(COLOR)": "2 layers coloured"
    + HIDDEN
    + ". Next: Remesh by icosphere.",
    PROPAGATED + "ms.apply_filter(REMESH, frequency=3)" + HIDE_LAST + "ms.apply_filter(COLOR)": (
        '5 layers coloured; hidden, left out: "phantom cavity 02 landmarks". '
        "Next: Build statistical shape model."
    ),
    PROPAGATED
    + "ms.apply_filter(REMESH, frequency=3)"
    + HIDE_LAST
    + "ms.apply_filter(COLOR, landmark_layers=False)": "3 layers coloured. "
    "Next: Build statistical shape model.",
}


@pytest.mark.parametrize("script", SUMMARIES)
def test_every_filter_ends_with_a_summary(script):
    assert lines_of(script)[-1] == SUMMARIES[script]
