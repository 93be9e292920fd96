# SPDX-License-Identifier: GPL-3.0-only
"""Maps that do not belong together: told apart by the root that they came from, named in the log,
refused by the model."""

import filter_log
import numpy as np
import pymeshlab
import pytest
from documents import (
    ATTRIBUTE,
    EVALUATE,
    MODEL,
    PROPAGATE,
    REMESH,
    ROOT,
    add,
    digest,
    landmark_layers,
    layers,
    mapped_cycle,
    positions,
    refused,
    small_cycle,
)

MARK = "sphere_root"


def roots(ms):
    return ms.apply_filter(EVALUATE)["root"].tolist()


def mark(mesh):
    values = np.unique(mesh.vertex_custom_scalar_attribute_array(MARK))
    assert len(values) == 1
    return values[0]


def remap(ms, number, **parameters):
    current = ms.current_mesh_id()
    ms.set_current_mesh(number)
    ms.apply_filter(ROOT, **parameters)
    ms.set_current_mesh(current)


def log_of(script, phases=3):
    """What the filters say, after a cycle was mapped and propagated."""
    before = f"""
ms.apply_filter(PHANTOM, phases={phases}, voxel_size=4)
ms.apply_filter(ROOT)
ms.apply_filter(PROPAGATE)
ms.apply_filter(REMESH, frequency=4)
def remap(number, **parameters):
    ms.set_current_mesh(number)
    ms.apply_filter(ROOT, **parameters)
def delete(number):
    ms.set_current_mesh(number)
    ms.delete_current_mesh()
"""
    return filter_log.log_of(before + script)


# ---------------------------------------------------------------- the number that stands for a root


def test_propagated_maps_carry_their_root():
    ms = mapped_cycle(4)
    known = roots(ms)
    assert known[0] > 0 and known == [known[0]] * 4
    assert [mark(m) for m in ms] == known


def test_a_root_has_the_same_number_in_every_run():
    assert roots(mapped_cycle(2)) == roots(mapped_cycle(2))


def test_another_map_is_another_root():
    ms = mapped_cycle(3)
    before = roots(ms)
    remap(ms, 0, area_weight=0.5)
    after = roots(ms)
    assert after[1:] == before[1:] and after[0] != before[0]
    remap(ms, 0)  # the same map again is the same root
    assert roots(ms) == before
    remap(ms, 0, area_weight=0.5)
    ms.apply_filter(PROPAGATE)
    assert roots(ms) == [after[0]] * 3


def test_another_mesh_of_the_same_positions_is_another_root():
    """A map is positions and faces."""
    ms = small_cycle(1)
    ms.apply_filter(ROOT)
    mesh = ms.mesh(0)
    other = pymeshlab.MeshSet()
    for turn in (0, 1):
        add(other, mesh.vertex_matrix(), np.roll(mesh.face_matrix(), turn, 0), f"turned {turn}")
        other.current_mesh().add_vertex_custom_point_attribute(positions(mesh), ATTRIBUTE)
        add(other, ms.mesh(0).vertex_matrix() + 1, mesh.face_matrix(), "target")
        other.apply_filter(PROPAGATE, root_layer=2 * turn)
        other.set_mesh_visibility(2 * turn, False)
        other.set_mesh_visibility(2 * turn + 1, False)
    assert mark(other.mesh(1)) == mark(other.mesh(0)) == mark(ms.mesh(0))
    assert mark(other.mesh(3)) == mark(other.mesh(2)) != mark(ms.mesh(0))


def test_a_handed_on_map_hands_its_root_on():
    ms = mapped_cycle(3)
    before = roots(ms)
    ms.apply_filter(PROPAGATE, root_layer=2)
    assert roots(ms) == before


def test_area_restoration_keeps_the_root():
    ms = mapped_cycle(3)
    before, held = roots(ms), positions(ms.mesh(1))
    ms.apply_filter(PROPAGATE, area_restoration=1.0)
    assert np.abs(positions(ms.mesh(1)) - held).max() > 1e-3
    assert roots(ms) == before


def test_copies_keep_their_root_where_they_keep_the_attribute():
    """MeshLab's own filter for copies keeps no attributes, but texture coordinates."""
    ms = mapped_cycle(2)
    ms.set_current_mesh(1)
    ms.add_mesh(ms.mesh(1), "copy")
    assert positions(ms.current_mesh()).any() and mark(ms.current_mesh()) == mark(ms.mesh(1))
    ms.apply_filter("generate_copy_of_current_mesh")
    known = roots(ms)
    assert known == [known[0]] * 3 + [-1]


@pytest.mark.parametrize(
    "name, parameters",
    [
        ("apply_coord_laplacian_smoothing", {"stepsmoothnum": 1}),
        (
            "compute_matrix_from_translation",
            {"traslmethod": "XYZ translation", "axisx": 5, "freeze": True},
        ),
        ("apply_color_inverse_per_vertex", {}),
    ],
)
def test_filters_that_keep_the_map_keep_its_root(name, parameters):
    ms = mapped_cycle(2)
    before = roots(ms)
    ms.set_current_mesh(1)
    ms.apply_filter(name, **parameters)
    assert roots(ms) == before


def test_vertices_without_a_root_make_it_unknown():
    ms = mapped_cycle(1)
    ms.apply_filter(
        "meshing_surface_subdivision_midpoint", iterations=1, threshold=pymeshlab.PercentageValue(0)
    )
    assert ms.mesh(0).vertex_number() > 1000
    assert len(np.unique(ms.mesh(0).vertex_custom_scalar_attribute_array(MARK))) > 1
    assert roots(ms) == [-1]


def test_files_do_not_keep_the_root(tmp_path):
    """Not known, so nobody is accused; propagation makes it known again."""
    ms, again = mapped_cycle(3), pymeshlab.MeshSet()
    for mesh in layers(ms):
        ms.set_current_mesh(mesh.id())
        ms.save_current_mesh(str(tmp_path / f"{mesh.id()}.ply"))
        again.load_new_mesh(str(tmp_path / f"{mesh.id()}.ply"))
    assert roots(again) == [-1] * 3
    again.apply_filter(REMESH)
    again.apply_filter(MODEL)
    again.apply_filter(PROPAGATE)
    known = roots(again)
    assert known[0] > 0 and known == [known[0]] * 3


def test_a_layer_joined_of_two_has_no_root():
    ms = mapped_cycle(2)
    remap(ms, 1)
    joined = np.concatenate([m.vertex_custom_scalar_attribute_array(MARK) for m in ms])
    mesh = ms.mesh(0)
    half = np.resize(joined[[0, -1]], mesh.vertex_number())
    add(ms, mesh.vertex_matrix(), mesh.face_matrix(), "joined")
    ms.current_mesh().add_vertex_custom_point_attribute(positions(mesh), ATTRIBUTE)
    ms.current_mesh().add_vertex_custom_scalar_attribute(half, MARK)
    assert roots(ms)[2] == -1


# ------------------------------------------------ what the filters say of different roots


def test_layers_of_one_root_are_not_complained_of():
    log = log_of(
        "ms.apply_filter(EVALUATE); ms.apply_filter(SPHERES); ms.apply_filter(COLOR); "
        "ms.apply_filter(MODEL)"
    )
    assert "Warning" not in log and "is not known" not in log


@pytest.mark.parametrize("name", ["REMESH", "EVALUATE", "SPHERES", "COLOR"])
def test_maps_of_different_roots_are_named(name):
    log = log_of(f"remap(1); ms.apply_filter({name})")
    assert (
        'Warning: the maps come from different roots ("phantom cavity 00", "phantom cavity 02" '
        'from one; "phantom cavity 01" from another), so that'
    ) in log


def test_a_root_map_on_every_layer_is_named_group_by_group():
    log = log_of("for i in range(6): remap(i)\nms.apply_filter(REMESH)", phases=6)
    assert (
        '("phantom cavity 00" from one; "phantom cavity 01" from another;' in log
        and "; and 2 more roots)" in log
    )


def test_layers_of_unknown_root_beside_others_are_named_without_a_warning():
    log = log_of("""
mesh = ms.mesh(1)
uv = mesh.vertex_tex_coord_matrix()
moved = mesh.vertex_matrix() + 1
ms.add_mesh(pymeshlab.Mesh(moved, mesh.face_matrix(), v_tex_coords_matrix=uv), "from a file")
ms.apply_filter(REMESH)
""")
    assert 'Note: which root the maps of "from a file" came from is not known' in log
    assert "different roots" not in log


@pytest.mark.parametrize(
    "stale", ["one remapped", "new root without propagation", "each its own root"]
)
def test_the_model_refuses_landmarks_of_different_roots(stale):
    ms = mapped_cycle(3)
    for number in {
        "one remapped": [2],
        "new root without propagation": [0],
        "each its own root": [0, 1, 2],
    }[stale]:
        remap(ms, number, area_weight=0.5)
    ms.apply_filter(REMESH)
    named = [
        '"phantom cavity 00 landmarks"',
        '"phantom cavity 02 landmarks"',
        "Propagate parameterisation to layers",
    ]
    with refused(ms, "sampled from maps of different roots", *named):
        ms.apply_filter(MODEL)
    ms.apply_filter(PROPAGATE, root_layer=0)
    with refused(ms, "different roots"):  # the landmarks are still the old ones
        ms.apply_filter(MODEL)
    ms.apply_filter(REMESH)
    assert ms.apply_filter(MODEL)["shapes"] == 3


def test_the_model_takes_what_is_visible_of_one_root():
    ms = mapped_cycle(3)
    remap(ms, 2)
    ms.apply_filter(REMESH)
    ms.set_mesh_visibility(5, False)
    assert ms.apply_filter(MODEL)["shapes"] == 2


def test_landmarks_carry_the_root_of_their_map():
    ms = mapped_cycle(2)
    ms.apply_filter(REMESH)
    assert [mark(m) for m in landmark_layers(ms)] == roots(ms)


# ---------------------------------------------------------------- landmarks that are left over


def test_landmarks_whose_surface_was_deleted_are_named():
    log = log_of("delete(1); ms.apply_filter(MODEL)")
    assert 'Warning: the surfaces of "phantom cavity 01 landmarks" are not in the project' in log


def test_landmarks_alone_are_no_left_overs():
    assert "Warning" not in log_of("for i in range(3): delete(i)\nms.apply_filter(MODEL)")


def test_landmarks_whose_surface_lost_its_map_are_named():
    log = log_of("""
v, f = ms.mesh(1).vertex_matrix(), ms.mesh(1).face_matrix()
delete(1)
ms.add_mesh(pymeshlab.Mesh(v, f), "phantom cavity 01")
ms.apply_filter(MODEL)
""")
    assert 'Warning: the surfaces of "phantom cavity 01 landmarks" have no map (any more)' in log


def test_landmarks_of_an_earlier_map_are_named():
    log = log_of(
        "ms.apply_filter(PROPAGATE, method='As published', root_layer=0); ms.apply_filter(MODEL)"
    )
    assert (
        'Warning: the maps of the surfaces of "phantom cavity 01 landmarks", "phantom cavity 02 '
        'landmarks" have changed since these landmarks were made. Run "Remesh by icosphere" again.'
    ) in log
    again = log_of(
        "ms.apply_filter(PROPAGATE, method='As published', root_layer=0)\n"
        "ms.apply_filter(REMESH, frequency=4)\n"
        "ms.apply_filter(MODEL)"
    )
    assert "Warning" not in again


def test_the_landmarks_are_the_same_with_and_without_marks():
    ms = mapped_cycle(2)
    ms.apply_filter(REMESH)
    bare = pymeshlab.MeshSet()
    for mesh in layers(ms)[:2]:
        add(bare, mesh.vertex_matrix(), mesh.face_matrix(), mesh.label())
        bare.current_mesh().add_vertex_custom_point_attribute(positions(mesh), ATTRIBUTE)
    bare.apply_filter(REMESH)
    for mine, theirs in zip(landmark_layers(ms), landmark_layers(bare)):
        assert digest(mine.vertex_matrix()) == digest(theirs.vertex_matrix())
