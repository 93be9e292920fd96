# SPDX-License-Identifier: GPL-3.0-only
"""The names, parameters, defaults and returned keys that users and measurements rely on."""

import numpy as np
import pymeshlab
import pytest
from documents import (
    COLOR,
    EVALUATE,
    FIGURES,
    FILTERS,
    GROUPWISE,
    LAYOUT,
    LOAD,
    MENU_OF,
    MODEL,
    MORPH,
    PHANTOM,
    PREPARE,
    PROPAGATE,
    REMESH,
    ROOT,
    SPHERES,
    add,
    labels,
    mapped_cycle,
    positions,
    small_cycle,
    written_script,
)
from environment import PROJECT
from surfaces import egg

# Parameters in their order, with their defaults; a list is a choice whose first entry is the
# default, unless CHOSEN says otherwise.
CHOSEN = {"anchors": 1}
PARAMETERS = {
    PHANTOM: {"part": ["Cavity", "Wall"], "phases": 25, "voxel_size": 2.0, "twist": 0.0, "seed": 0},
    PREPARE: {
        "all_visible": False,
        "weld": True,
        "remove_duplicate_faces": True,
        "remove_fins": True,
        "join_shells": False,
        "keep_largest_component": True,
        "close_openings": True,
        "lid": ["Curved", "Flat"],
        "orient": True,
        "remove_handles": False,
    },
    ROOT: {
        "initial_map": ["Automatic", "Brechbuehler", "Harmonic"],
        "area_weight": 0.9,
        "anchor_positions": "",
        "most_central": False,
        "threads": 0,
    },
    LOAD: {"file_name": "", "coordinates": ["World", "Mesh"], "show_anchors": False},
    PROPAGATE: {
        "root_layer": 0,
        "method": ["Robust", "As published"],
        "order": ["Time", "Cyclic time", "Similarity tree", "Star", "Given"],
        "parents": "",
        "area_restoration": 0.0,
        "residual_quality": False,
        "uncertainty_quality": False,
        "root_error_quality": False,
        "mirror_layers": False,
        "anchors": ["Off", "Soft", "Exact"],
        "anchor_files": "",
        "anchor_sd": 0.0,
        "anchor_snap": False,
        "anchor_pose": False,
        "anisotropic_scaling": True,
        "icp_iterations": 30,
        "smoothing_sweeps": 50,
        "threads": 0,
    },
    GROUPWISE: {
        "alignment": ["Rigid", "Similarity", "None"],
        "iterations": 8,
        "surface_precision": 0.0,
        "objective": ["Population model", "Description length"],
        "anchors": ["Off", "Soft"],
        "anchor_sd": 0.0,
        "prior_shapes": 2.0,
        "frequency": 7,
        "threads": 0,
    },
    REMESH: {
        "frequency": 10,
        "color_landmarks": True,
        "landmark_colors": ["Place on the sphere", "Index as hue"],
        "beside_surfaces": False,
        "threads": 0,
    },
    EVALUATE: {},
    SPHERES: {"beside_surfaces": False},
    LAYOUT: {},
    COLOR: {
        "pattern": ["Checkerboard", "Latitude and longitude", "Direction", "Area ratio"],
        "cells": 8,
        "area_ratio_limit": 2.0,
        "store_area_ratio": False,
        "landmark_layers": True,
    },
    MORPH: {
        "steps": 3,
        "connectivity": ["Common icosphere", "Union of both connectivities"],
        "frequency": 10,
        "along": ["Linear", "Shape model"],
        "closed": False,
        "ends": True,
        "beside_surfaces": False,
        "threads": 0,
    },
    MODEL: {
        "alignment": ["Similarity", "Rigid", "None", "Anchors", "Scaled anchors"],
        "leave_out_lids": ["Most shapes", "Any shape", "Never"],
        "modes": 0,
        "standard_deviations": 3.0,
        "mode_layers": 3,
        "export_file": "",
        "beside_shapes": False,
        "area_weights": False,
        "surface_measures": False,
        "specificity_samples": 1000,
        "seed": 0,
    },
}

RETURNED = {
    PHANTOM: {"layers", "vertices", "seconds"},
    PREPARE: {
        "weld",
        "remove_duplicate_faces",
        "remove_fins",
        "join_shells",
        "keep_largest_component",
        "close_openings",
        "lid",
        "orient",
        "remove_handles",
        "closed",
        "vertices",
        "vertices_before",
        "opening_layer",
        "opening_edges",
        "opening_perimeter",
        "seconds",
    },
    ROOT: {"root_layer", *FIGURES},
    LOAD: {"anchors"},
    PROPAGATE: {
        "parent",
        "residual_mean",
        "residual_p95",
        "repaired_faces",
        "route",
        "distant",
        "mirrored",
        *FIGURES,
    },
    GROUPWISE: {
        "tangential_move",
        "model_residual",
        "repaired_faces",
        "trust",
        "move_by_iteration",
        "total_variance",
        "surface_precision",
        *FIGURES,
    },
    REMESH: {"surface_distance_mean", "surface_distance_max", "lid", "seconds"},
    EVALUATE: {"valid", "degree", "root", *FIGURES},
    SPHERES: {"layers"},
    COLOR: {"layers"},
    MORPH: {"from", "to", "share", "volume", "vertices", "layers", "crossings", "seconds"},
    LAYOUT: {"layers", "side_by_side"},
    MODEL: {
        "eigenvalues",
        "compactness",
        "variance_share",
        "generalisation",
        "generalisation_error",
        "specificity",
        "specificity_error",
        "scores",
        "mean",
        "mode_vectors",
        "lid",
        "total_variance",
        "shapes",
        "modes",
        "landmarks",
        "seconds",
    },
}


@pytest.fixture(scope="module")
def tour():
    """A project after all filters, and what each returned, none of their parameters set but the
    phantom's size."""
    ms = pymeshlab.MeshSet()
    returned = {PHANTOM: ms.apply_filter(PHANTOM, phases=3, voxel_size=4)}
    for name in FILTERS[1:]:
        returned[name] = ms.apply_filter(name)
    return ms, returned


def test_filters_are_known_to_pymeshlab():
    assert set(FILTERS) <= set(pymeshlab.filter_list())


@pytest.mark.parametrize("name", FILTERS)
def test_parameters_and_their_defaults(name):
    ms = small_cycle(2)
    found = ms.filter_parameter_values(name)
    meant = {k: CHOSEN.get(k, 0) if isinstance(v, list) else v for k, v in PARAMETERS[name].items()}
    assert list(found) == list(meant)
    assert found == pytest.approx(meant, rel=1e-6)
    assert {k: type(v) for k, v in found.items()} == {k: type(v) for k, v in meant.items()}


def test_menu_names_and_choices(tour, tmp_path):
    """A filter script knows the menu's names and the texts of choices."""
    script = dict(written_script(tour[0], tmp_path / "script.mlx"))
    assert list(script) == [MENU_OF[name] for name in FILTERS]
    for name in FILTERS:
        for parameter, default in PARAMETERS[name].items():
            written = script[MENU_OF[name]][parameter]
            assert written["description"] and len(written["tooltip"]) > 20, parameter
            if isinstance(default, list):
                assert written["type"] == "RichEnum"
                assert [
                    written[f"enum_val{i}"] for i in range(int(written["enum_cardinality"]))
                ] == default


@pytest.mark.parametrize("name", FILTERS)
def test_returned_keys(tour, name):
    assert set(tour[1][name]) == RETURNED[name]


def test_the_root_returns_numbers(tour):
    root = tour[1][ROOT]
    assert isinstance(root["flipped_faces"], int)
    assert root["root_layer"] == 0
    assert all(isinstance(root[key], float) for key in FIGURES[1:])


@pytest.mark.parametrize("name", [PROPAGATE, REMESH, EVALUATE])
def test_several_layers_return_one_entry_each(tour, name):
    for key, value in tour[1][name].items():
        assert isinstance(value, np.ndarray) and value.shape == (3,) and np.isfinite(value).all(), (
            key
        )
    assert (tour[1][name]["seconds"] > 0)[1:].all()


def test_the_phantom_says_what_it_made(tour):
    ms, returned = tour
    assert returned[PHANTOM]["layers"] == 3
    assert returned[PHANTOM]["vertices"].tolist() == [m.vertex_number() for m in list(ms)[:3]]


@pytest.mark.parametrize("name", FILTERS)
def test_returned_keys_are_documented(name):
    """PyMeshLab shows no filter's description, so it is looked for in the filter's help."""
    help_texts = PROJECT / "filter_sphere_propagation/help"
    text = (help_texts / f"{name}.html").read_text()
    if "{map_figures}" in text:
        text += (help_texts / "map_figures.html").read_text()
    for key in RETURNED[name]:
        assert f"<b>{key}</b>" in text, key


def test_new_layers_are_called_after_their_source(tour):
    surfaces = [f"phantom cavity {t:02d}" for t in range(3)]
    model = ["mean shape", "mode 1 -3 sd", "mode 1 +3 sd", "mode 2 -3 sd", "mode 2 +3 sd"]
    assert labels(tour[0]) == surfaces + [s + " landmarks" for s in surfaces] + [
        s + " sphere" for s in surfaces
    ] + model + [f"{surfaces[0]} to {surfaces[1]} {share} %" for share in (0, 25, 50, 75, 100)] + [
        f"{surfaces[1]} to {surfaces[2]} {share} %" for share in (25, 50, 75, 100)
    ]


def test_sphere_layers_are_the_surface_on_the_sphere(tour):
    ms = tour[0]
    for surface, sphere in zip(list(ms)[:3], list(ms)[6:9]):
        assert np.array_equal(sphere.face_matrix(), surface.face_matrix())
        assert np.array_equal(sphere.vertex_matrix(), positions(surface))


def test_sphere_layers_carry_the_colours_over():
    ms = pymeshlab.MeshSet()
    v, f = egg()
    colours = np.random.default_rng(1).integers(0, 256, (len(v), 4)) / 255
    colours[:, 3] = 1
    add(ms, v, f, "egg", v_color_matrix=colours)
    ms.apply_filter(ROOT)
    ms.apply_filter(SPHERES)
    assert np.array_equal(ms.mesh(1).vertex_color_matrix(), ms.mesh(0).vertex_color_matrix())


@pytest.mark.parametrize("frequency", [1, 2, 3, 10, 17])
def test_frequency_gives_the_number_of_landmarks(frequency):
    ms = mapped_cycle(2)
    ms.apply_filter(REMESH, frequency=frequency)
    for mesh in list(ms)[2:]:
        assert mesh.vertex_number() == 10 * frequency**2 + 2
        assert mesh.face_number() == 20 * frequency**2


def test_landmarks_without_colours():
    ms = mapped_cycle(2)
    ms.apply_filter(REMESH, color_landmarks=False)
    assert len(np.unique(ms.mesh(2).vertex_color_matrix(), axis=0)) == 1


# ------------------------------------------------ which layer gets its map from which


@pytest.mark.parametrize("root", [0, 2, 4])
@pytest.mark.parametrize(
    "order, parents",
    [
        ("Time", {0: [-1, 0, 1, 2, 3], 2: [1, 2, -1, 2, 3], 4: [1, 2, 3, 4, -1]}),
        ("Cyclic time", {0: [-1, 0, 1, 4, 0], 2: [1, 2, -1, 2, 3], 4: [4, 0, 3, 4, -1]}),
        ("Star", {0: [-1, 0, 0, 0, 0], 2: [2, 2, -1, 2, 2], 4: [4, 4, 4, 4, -1]}),
    ],
)
def test_order(order, parents, root):
    ms = small_cycle(5)
    ms.set_current_mesh(root)
    ms.apply_filter(ROOT)
    returned = ms.apply_filter(PROPAGATE, order=order)
    assert returned["parent"].tolist() == parents[root]
    assert returned["flipped_faces"].sum() == 0


def test_similarity_tree_reaches_every_layer():
    ms = small_cycle(5)
    ms.apply_filter(ROOT)
    returned = ms.apply_filter(PROPAGATE, order="Similarity tree")
    parent = returned["parent"].astype(int)
    assert parent[0] == -1 and (parent[1:] >= 0).all()
    for at in range(5):
        for _ in range(5):
            at = max(parent[at], 0)
        assert at == 0
    assert returned["flipped_faces"].sum() == 0


@pytest.mark.parametrize("text", ["-1, 0, 1, 1, 0", "-1 0 1 1 0", "-1;0;1;1;0"])
def test_given_order(text):
    ms = small_cycle(5)
    ms.apply_filter(ROOT)
    returned = ms.apply_filter(PROPAGATE, order="Given", parents=text)
    assert returned["parent"].tolist() == [-1, 0, 1, 1, 0]
    assert returned["flipped_faces"].sum() == 0


def test_parents_are_layer_numbers_not_places_in_the_list():
    ms = small_cycle(5)
    ms.set_current_mesh(1)
    ms.delete_current_mesh()
    ms.set_current_mesh(3)
    ms.apply_filter(ROOT)
    assert ms.apply_filter(PROPAGATE, order="Given", parents="2 3 -1 3")["parent"].tolist() == [
        2,
        3,
        -1,
        3,
    ]
    assert ms.apply_filter(PROPAGATE, order="Time")["parent"].tolist() == [2, 3, -1, 3]


def test_default_root_layer():
    """The current layer if it has a map, else the first that has one."""
    ms = small_cycle(4)
    ms.set_current_mesh(2)
    ms.apply_filter(ROOT)
    assert ms.filter_parameter_values(PROPAGATE)["root_layer"] == 2
    ms.set_current_mesh(0)
    assert ms.filter_parameter_values(PROPAGATE)["root_layer"] == 2
    assert ms.apply_filter(PROPAGATE)["parent"].tolist() == [1, 2, -1, 2]
    assert ms.filter_parameter_values(PROPAGATE)["root_layer"] == 0


def test_methods_differ():
    ms = small_cycle(3)
    ms.apply_filter(ROOT)
    found = {}
    for method in ("Robust", "As published"):
        ms.apply_filter(PROPAGATE, method=method)
        found[method] = positions(ms.mesh(2))
    assert not np.allclose(found["Robust"], found["As published"], atol=0.01)


@pytest.mark.parametrize(
    "constant", [{"anisotropic_scaling": False}, {"icp_iterations": 0}, {"smoothing_sweeps": 0}]
)
def test_constants_of_the_published_method_matter(constant):
    ms = small_cycle(3)
    ms.apply_filter(ROOT)
    ms.apply_filter(PROPAGATE, method="As published")
    usual = positions(ms.mesh(2))
    returned = ms.apply_filter(PROPAGATE, method="As published", **constant)
    assert not np.allclose(usual, positions(ms.mesh(2)), atol=1e-6)
    assert returned["flipped_faces"].sum() == 0
    if "smoothing_sweeps" in constant:
        # What the sweeps do not smooth away is repaired, and counted.
        assert returned["repaired_faces"].sum() > 0
