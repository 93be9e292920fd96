# SPDX-License-Identifier: GPL-3.0-only
"""A project over time: filters run again, files saved and loaded, layers of all kinds side by side,
layers hidden."""

import numpy as np
import pymeshlab
import pytest
from cycles import project_of
from documents import (
    ATTRIBUTE,
    EVALUATE,
    FILTERS,
    GROUPWISE,
    LAYOUT,
    MODEL,
    PHANTOM,
    PROPAGATE,
    REMESH,
    ROOT,
    SPHERES,
    add,
    content,
    has_attribute,
    labels,
    landmark_layers,
    layers,
    mapped_cycle,
    positions,
    refused,
    small_cycle,
    snapshot,
    texture_positions,
)
from filter_log import log_of
from scipy.spatial import cKDTree
from surfaces import egg, open_egg


def saved(ms, folder):
    """Saves every layer as PLY and returns the files."""
    files = []
    for mesh in layers(ms):
        ms.set_current_mesh(mesh.id())
        files.append(folder / f"{mesh.label()}.ply")
        ms.save_current_mesh(str(files[-1]))
    return files


def loaded(files):
    ms = pymeshlab.MeshSet()
    for file in files:
        ms.load_new_mesh(str(file))
    return ms


def figures_only(returned):
    return {key: value for key, value in returned.items() if key != "seconds"}


# ---------------------------------------------------------------- files


def test_a_map_survives_a_ply_file(tmp_path, measure):
    ms = mapped_cycle()
    before = ms.apply_filter(EVALUATE)
    ms.apply_filter(REMESH)
    again = loaded(saved(ms, tmp_path)[:4])
    assert not any(has_attribute(m) for m in again)
    after = again.apply_filter(EVALUATE)
    assert after["valid"].tolist() == [1] * 4
    for key in ("area_ratio_sd", "area_log_mean", "angle_error_mean"):
        assert after[key] == pytest.approx(before[key], rel=1e-4, abs=1e-5), key
    for mesh in again:
        figures = measure.map_figures(
            mesh.vertex_matrix(), mesh.face_matrix(), texture_positions(mesh)
        )
        assert figures["flips"] == 0 and figures["degree"] == pytest.approx(1)
    # and remeshing goes on from it
    again.apply_filter(REMESH)
    for mine, theirs in zip(landmark_layers(ms), landmark_layers(again)):
        assert np.abs(mine.vertex_matrix() - theirs.vertex_matrix()).max() < 0.01


def test_propagation_goes_on_from_a_loaded_root(tmp_path):
    ms = small_cycle()
    ms.apply_filter(ROOT)
    again = loaded(saved(ms, tmp_path))
    ms.apply_filter(PROPAGATE, root_layer=0)
    # The first that has a map; the last is current.
    assert again.filter_parameter_values(PROPAGATE)["root_layer"] == 0
    returned = again.apply_filter(PROPAGATE)
    assert returned["parent"].tolist() == [-1, 0, 1, 2]
    assert returned["flipped_faces"].sum() == 0
    for mine, theirs in zip(ms, again):
        if mine.id() > 0:
            assert np.percentile(np.abs(positions(mine) - positions(theirs)), 95) < 1e-4


def test_a_project_saved_and_opened_again_works_on(tmp_path):
    ms = mapped_cycle()
    ms.apply_filter(REMESH)
    ms.apply_filter(SPHERES)
    saved(ms, tmp_path)
    ms.save_project(str(tmp_path / "cycle.mlp"))
    again = pymeshlab.MeshSet()
    again.load_project(str(tmp_path / "cycle.mlp"))
    assert labels(again) == labels(ms)
    assert again.apply_filter(EVALUATE)["valid"].tolist() == [1] * 4
    again.apply_filter(PROPAGATE)
    again.apply_filter(REMESH)
    again.apply_filter(SPHERES)
    assert labels(again) == labels(ms)


def test_a_map_damaged_in_its_file_is_no_map(tmp_path):
    ms = mapped_cycle(3)
    files = saved(ms, tmp_path)
    uv = ms.mesh(1).vertex_tex_coord_matrix()
    uv[[100, 200]] = uv[[200, 100]]
    again = pymeshlab.MeshSet()
    again.load_new_mesh(str(files[0]))
    add(
        again,
        ms.mesh(1).vertex_matrix(),
        ms.mesh(1).face_matrix(),
        "damaged",
        v_tex_coords_matrix=uv,
    )
    again.load_new_mesh(str(files[2]))
    returned = again.apply_filter(EVALUATE)
    assert returned["valid"].tolist() == [1, 0, 1] and returned["flipped_faces"][1] > 0
    assert len(again.apply_filter(REMESH)["seconds"]) == 2
    with refused(again, '"damaged"', "has no map"):
        again.apply_filter(PROPAGATE, root_layer=1)


def test_landmark_and_sphere_layers_are_known_after_loading(tmp_path):
    ms = mapped_cycle(3)
    ms.apply_filter(REMESH)
    ms.apply_filter(SPHERES)
    again = loaded(saved(ms, tmp_path))
    assert again.mesh_number() == 9
    again.set_current_mesh(0)
    assert len(again.apply_filter(EVALUATE)["valid"]) == 3
    assert len(again.apply_filter(PROPAGATE)["parent"]) == 3
    assert len(again.apply_filter(REMESH)["seconds"]) == 3
    assert again.apply_filter(SPHERES)["layers"] == 3


def as_meshlabserver_names_them(files, folder):
    """x.ply and "x landmarks.ply" as its -w leaves them: x_out.ply and xlandmarks_out.ply."""
    renamed = []
    for file in files:
        renamed.append(folder / (file.stem.replace(" landmarks", "landmarks") + "_out.ply"))
        file.rename(renamed[-1])
    return renamed


@pytest.mark.parametrize("names", ["as saved", "by meshlabserver"])
def test_landmarks_that_were_saved_and_loaded_are_replaced(names, tmp_path):
    ms = mapped_cycle(3)
    ms.apply_filter(REMESH, frequency=4)
    files = saved(ms, tmp_path)
    if names == "by meshlabserver":
        files = as_meshlabserver_names_them(files, tmp_path)
    again = loaded(files)
    again.set_mesh_visibility(4, False)
    again.apply_filter(REMESH, frequency=5)
    assert again.mesh_number() == 6
    assert [m.vertex_number() for m in layers(again)[3:]] == [252] * 3
    for theirs in range(3, 6):  # each holds the landmarks of the surface that it held before
        points = again.mesh(theirs).vertex_matrix()
        away = [cKDTree(again.mesh(k).vertex_matrix()).query(points)[0].mean() for k in range(3)]
        assert int(np.argmin(away)) == theirs - 3
    again.set_mesh_visibility(4, True)
    assert again.apply_filter(MODEL)["shapes"] == 3


def test_landmarks_of_another_surface_are_not_replaced(tmp_path):
    """The next phase lies close by, but not there."""
    ms = mapped_cycle(4)
    ms.apply_filter(REMESH, frequency=4)
    files = saved(ms, tmp_path)
    # Landmarks of the one that is missing.
    again = loaded(as_meshlabserver_names_them([*files[:3], files[7]], tmp_path))
    held = content(again.mesh(3))
    again.apply_filter(REMESH, frequency=5)
    assert again.mesh_number() == 7 and content(again.mesh(3)) == held


def test_landmarks_that_are_there_twice_are_named():
    log = log_of("""
ms.apply_filter(PHANTOM, phases=2, voxel_size=4)
for name in (ROOT, PROPAGATE, REMESH):
    ms.apply_filter(name)
ms.add_mesh(pymeshlab.Mesh(ms.mesh(2).vertex_matrix(), ms.mesh(2).face_matrix()), "a copy")
print("shapes:", ms.apply_filter(MODEL)["shapes"])
ms.apply_filter(REMESH)
""")
    assert "shapes: 3" in log
    assert (
        '"phantom cavity 00 landmarks" and "a copy" both hold landmarks of "phantom cavity 00", '
        "which counts twice" in log
    )
    assert (
        'Warning: a copy: it also holds landmarks of "phantom cavity 00", from an earlier run'
        in log
    )


# ---------------------------------------------------------------- all filters, again and again


def run_all(ms):
    returned = [ms.apply_filter(PHANTOM, phases=4, voxel_size=4)]
    returned += [ms.apply_filter(name) for name in FILTERS[1:]]
    return [figures_only(r) for r in returned]


def same(a, b):
    return a.keys() == b.keys() and all(np.array_equal(a[k], b[k]) for k in a)


def test_all_filters_twice_in_one_project():
    ms = pymeshlab.MeshSet()
    first = run_all(ms)
    before = snapshot(ms)
    second = run_all(ms)
    # surfaces, landmarks, spheres; mean and modes; morphs
    assert ms.mesh_number() == 3 * 4 + (1 + 2 * 3) + (3 * 4 + 1)
    assert all(same(a, b) for a, b in zip(first, second))
    assert snapshot(ms) == before


def test_each_filter_twice_in_a_row():
    ms = small_cycle()
    takes_back, goes_on = LAYOUT, GROUPWISE  # from where it ended
    for name in (n for n in FILTERS[1:] if n not in (takes_back, goes_on)):
        first = ms.apply_filter(name)
        before = snapshot(ms)
        assert same(figures_only(first), figures_only(ms.apply_filter(name))), name
        assert snapshot(ms) == before, name


def test_other_parameters_replace_the_layers_made_before():
    ms = mapped_cycle(3)
    for frequency in (10, 4, 6):
        ms.apply_filter(REMESH, frequency=frequency)
        assert [m.vertex_number() for m in landmark_layers(ms)] == [10 * frequency**2 + 2] * 3
    assert ms.mesh_number() == 6


def test_layers_of_the_user_are_not_replaced():
    """A layer of the same name but of another kind is not what an earlier run made."""
    ms = mapped_cycle(2)
    add(ms, *egg(), "phantom cavity 00 landmarks")
    held = content(ms.mesh(2))
    ms.set_mesh_visibility(2, False)
    ms.apply_filter(REMESH)
    assert ms.mesh_number() == 5
    assert content(ms.mesh(2)) == {**held, "visible": False}


def test_the_same_in_a_new_project():
    """Results depend on nothing that was computed before."""
    projects = []
    for _ in range(2):
        ms = pymeshlab.MeshSet()
        run_all(ms)
        projects.append(snapshot(ms))
        mapped_cycle(2, part="Wall", seed=3)
    assert projects[0] == projects[1]


@pytest.mark.parametrize("method", ["Robust", "As published"])
def test_real_data_twice(method):
    found = []
    for _ in range(2):
        ms = project_of("heart_truth")
        for mesh in layers(ms)[6:]:
            ms.set_current_mesh(mesh.id())
            ms.delete_current_mesh()
        ms.set_current_mesh(0)
        ms.apply_filter(ROOT)
        ms.apply_filter(PROPAGATE, method=method)
        ms.apply_filter(REMESH)
        found.append(snapshot(ms))
    assert found[0] == found[1]


# ---------------------------------------------------------------- layers


def test_the_current_layer_stays_current():
    ms = mapped_cycle()
    for current in (2, 0):
        ms.set_current_mesh(current)
        for name in FILTERS[1:]:
            ms.apply_filter(name)
            assert ms.current_mesh_id() == current, name


def test_only_the_maps_change_on_surfaces():
    ms = small_cycle()
    before = [content(m) for m in ms]
    ms.apply_filter(ROOT)
    ms.apply_filter(PROPAGATE)
    for mesh, held in zip(ms, before):
        now = content(mesh)
        changed = {name for name in held if held[name] != now[name]}
        assert changed == {"attribute " + ATTRIBUTE, "attribute sphere_root", "texture coordinates"}


@pytest.mark.parametrize("name", [REMESH, EVALUATE, SPHERES])
def test_surfaces_stay_as_they_are(name):
    ms = mapped_cycle()
    before = [content(m) for m in ms]
    ms.apply_filter(name)
    assert [content(m) for m in layers(ms)[:4]] == before


def test_hidden_layers_are_left_out():
    ms = mapped_cycle()
    ms.set_mesh_visibility(2, False)
    hidden = content(ms.mesh(2))
    assert ms.apply_filter(PROPAGATE)["parent"].tolist() == [-1, 0, 1]
    assert len(ms.apply_filter(EVALUATE)["valid"]) == 3
    assert len(ms.apply_filter(REMESH)["seconds"]) == 3
    assert ms.apply_filter(SPHERES)["layers"] == 3
    assert content(ms.mesh(2)) == hidden
    assert not any(label.startswith("phantom cavity 02 ") for label in labels(ms))


def test_file_endings_are_left_out_of_new_labels():
    ms = pymeshlab.MeshSet()
    add(ms, *egg(), "phase.1.ply")
    ms.apply_filter(ROOT)
    ms.apply_filter(REMESH)
    ms.apply_filter(SPHERES)
    assert labels(ms) == ["phase.1.ply", "phase.1 landmarks", "phase.1 sphere"]


def test_layers_of_one_name_get_landmarks_each():
    ms = pymeshlab.MeshSet()
    for centre in (0, 50, 100):
        add(ms, *egg(centre=(centre, 0, 0)), "egg.ply")
        ms.apply_filter(ROOT)
    for _ in range(2):
        ms.apply_filter(REMESH)
        assert ms.mesh_number() == 6
        middles = [m.vertex_matrix()[:, 0].mean() for m in layers(ms)[3:]]
        assert middles == pytest.approx([0, 50, 100], abs=1)


def test_shape_model_layers_are_left_out_by_name():
    ms = mapped_cycle(2)
    for label in ("mean shape", "mode 1 -3 sd", "mode 2 +3 sd"):
        add(ms, *egg(), label)
    ms.set_current_mesh(0)
    assert len(ms.apply_filter(PROPAGATE)["parent"]) == 2


# ---------------------------------------------------------------- what is a map


def planar(vertices):
    low, high = vertices.min(0), vertices.max(0)
    return ((vertices - low) / (high - low))[:, :2]


def test_ordinary_texture_coordinates_are_no_map():
    ms = pymeshlab.MeshSet()
    v, f = egg()
    add(ms, v, f, "textured", v_tex_coords_matrix=planar(v))
    for name in (REMESH, SPHERES):
        with refused(ms, "No visible surface layer has a map"):
            ms.apply_filter(name)
    add(ms, *egg(), "other")
    with refused(ms, '"textured"', "has no map"):
        ms.apply_filter(PROPAGATE, root_layer=0)
    assert ms.filter_parameter_values(PROPAGATE)["root_layer"] == 1


def test_ordinary_texture_coordinates_survive_a_failure():
    ms = pymeshlab.MeshSet()
    v, f = open_egg()
    add(ms, v, f, "open", v_tex_coords_matrix=planar(v))
    with refused(ms, '"open"'):
        ms.apply_filter(ROOT)
    assert np.array_equal(
        ms.mesh(0).vertex_tex_coord_matrix().astype(np.float32), planar(v).astype(np.float32)
    )


def test_a_damaged_attribute_gives_way_to_the_texture_coordinates():
    ms = mapped_cycle(2)
    surface = ms.mesh(1)
    damaged = positions(surface)
    damaged[[10, 300]] = damaged[[300, 10]]
    again = pymeshlab.MeshSet()
    add(
        again,
        surface.vertex_matrix(),
        surface.face_matrix(),
        "surface",
        v_tex_coords_matrix=surface.vertex_tex_coord_matrix(),
    )
    again.current_mesh().add_vertex_custom_point_attribute(damaged, ATTRIBUTE)
    # What is stored is reported as it is.
    assert again.apply_filter(EVALUATE)["valid"].tolist() == [0]
    again.apply_filter(REMESH)
    ms.apply_filter(REMESH)
    assert np.abs(again.mesh(1).vertex_matrix() - layers(ms)[3].vertex_matrix()).max() < 0.01


@pytest.mark.parametrize(
    "damage",
    [
        lambda s: s * 1.001,  # off the sphere
        lambda s: s * [1, 1, -1],  # mirrored: everything is flipped
        lambda s: np.where(np.arange(len(s))[:, None] == 7, np.nan, s),
        lambda s: np.where(np.arange(len(s))[:, None] == 7, -s, s),
        lambda s: np.tile([0.0, 0, 1], (len(s), 1)),
    ],
    ids=["scaled", "mirrored", "nan", "antipodal", "constant"],
)
def test_an_invalid_map_is_reported_and_not_used(damage):
    ms = mapped_cycle(2)
    surface = ms.mesh(1)
    again = pymeshlab.MeshSet()
    add(again, surface.vertex_matrix(), surface.face_matrix(), "surface")
    again.current_mesh().add_vertex_custom_point_attribute(damage(positions(surface)), ATTRIBUTE)
    returned = again.apply_filter(EVALUATE)
    assert returned["valid"].tolist() == [0]
    for name in (REMESH, SPHERES):
        with refused(again, "No visible surface layer has a map"):
            again.apply_filter(name)


def test_other_filters_can_use_the_attributes_of_new_layers():
    """Scalar ones: for attributes of points MeshLab 2025.07 itself reserves too little and computes
    with freed memory (filter_func.cpp)."""
    ms = mapped_cycle(2)
    ms.apply_filter(REMESH)
    mesh = ms.mesh(3)
    ms.set_current_mesh(mesh.id())
    ms.apply_filter("compute_scalar_by_function_per_vertex", q="sphere_root")
    held = mesh.vertex_custom_scalar_attribute_array("sphere_root")
    assert np.array_equal(mesh.vertex_scalar_array(), held) and np.abs(held).max() > 0


# ---------------------------------------------------------------- the log


def test_the_log_names_layer_figures_and_time():
    log = log_of("""
ms.apply_filter(PHANTOM, phases=3, voxel_size=4)
for name in FILTERS[1:]:
    ms.apply_filter(name)
""")
    lines = [line.strip() for line in log.splitlines() if line.startswith("LOG:")]
    per_layer = [line for line in lines if "flipped face" in line]
    for t in range(3):
        of_layer = [line for line in per_layer if f"phantom cavity {t:02d}:" in line]
        # Propagation, groupwise and evaluation; the root has its own filter too.
        assert len(of_layer) == (4 if t == 0 else 3)
        for line in of_layer:
            for words in (
                " vertices",
                "0 flipped faces",
                "area ratio sd 0.",
                "angle error",
                "degrees",
            ):
                assert words in line
        assert any(f"phantom cavity {t:02d}: 1002 landmarks" in line for line in lines)
    seconds = [line for line in lines if " s (Hierarchical start" in line or line.endswith(" s")]
    # Phantom, root, two propagated layers, three remeshed, three evaluated.
    assert len(seconds) >= 1 + 1 + 2 + 3 + 3
    assert any("from phantom cavity 01 with residual" in line for line in lines)

    # Progress: real fractions that only grow.
    percents = [
        int(line.split("[")[1].split("%")[0])
        for line in lines
        if "Propagate parameterisation to layers    [" in line
    ]
    assert percents == sorted(set(percents)) and percents[-1] == 100 and len(percents) > 4


def test_remeshing_is_the_same_with_any_number_of_threads():
    ms = mapped_cycle(5)
    made, figures = [], []
    for threads in (1, 2, 5):
        figures.append(ms.apply_filter(REMESH, frequency=6, threads=threads))
        made.append([(m.vertex_matrix(), m.face_matrix()) for m in landmark_layers(ms)])
    for other, more in zip(made[1:], figures[1:]):
        assert len(other) == len(made[0]) == 5
        for (points, faces), (expected, expected_faces) in zip(other, made[0]):
            assert np.array_equal(points, expected) and np.array_equal(faces, expected_faces)
        for key in ("surface_distance_mean", "surface_distance_max"):
            assert np.array_equal(more[key], figures[0][key])


def test_remeshing_refuses_a_negative_number_of_threads():
    ms = mapped_cycle(1)
    with refused(ms, "number of threads must be 0 or more; it is -1"):
        ms.apply_filter(REMESH, threads=-1)
