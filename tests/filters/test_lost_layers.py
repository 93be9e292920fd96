# SPDX-License-Identifier: GPL-3.0-only
"""Layers that the motion fit loses: valid maps all the same, and a word about them in the log."""

import re

import filter_log
import numpy as np
import pymeshlab
import pytest
from environment import files_of

ROOT = "compute_spherical_parameterisation_root"
PROPAGATE = "transfer_spherical_parameterisation_to_layers"

SCRIPT = """
ms.apply_filter("create_ventricle_phantom", phases=3, voxel_size=4)
ms.set_current_mesh(1)
ms.apply_filter("compute_matrix_from_scaling_or_normalization", axisx=20, uniformflag=True)
ms.set_current_mesh(0)
"""
# What the fit cannot follow: the muscle among blood pools.
LOST = """
ms.apply_filter("create_ventricle_phantom", phases=2, voxel_size=3)
ms.apply_filter("create_ventricle_phantom", phases=1, voxel_size=3, part="Wall")
ms.set_current_mesh(0)
"""


def log_of(script, before=SCRIPT):
    return filter_log.log_of(before + script)


def test_the_log_says_which_layer_was_lost():
    log = log_of(f"ms.apply_filter({ROOT!r}); ms.apply_filter({PROPAGATE!r})", LOST)
    assert "Warning: phantom wall 00: the motion fit lost it" in log
    assert "Warning: phantom cavity 0" not in log


@pytest.mark.parametrize("method", ["Robust", "As published"])
@pytest.mark.parametrize("order", ["Time", "Star", "Similarity tree"])
def test_the_log_names_a_layer_in_another_unit_alone(order, method):
    for script, phase, kind in (
        (SCRIPT.replace("axisx=20", "axisx=5"), 1, "larger"),
        (SCRIPT.replace("axisx=20", "axisx=0.1"), 1, "smaller"),
        (SCRIPT.replace("axisx=20", "axisx=4").replace("mesh(1)", "mesh(0)"), 0, "larger"),
    ):
        log = log_of(
            f"ms.apply_filter({ROOT!r})\n"
            f"ms.apply_filter({PROPAGATE!r}, order={order!r}, method={method!r})",
            script,
        )
        assert re.search(rf"Warning: phantom cavity 0{phase}: it is [\d.]+ times {kind}", log)
        assert log.count("times larger") + log.count("times smaller") == 1
        assert ("(cm among mm?)" in log) == ("0.1" in script)
        if method == "Robust":
            assert log.count("Warning:") == 1


def test_the_route_says_how_each_layer_got_its_map():
    log = log_of(
        f"ms.apply_filter({ROOT!r}); print('route', "
        f"ms.apply_filter({PROPAGATE!r})['route'].tolist())",
        LOST,
    )
    assert "route [0.0, 0.0, 1.0]" in log


def test_the_log_names_a_layer_in_another_pose():
    script = SCRIPT.replace(
        '"compute_matrix_from_scaling_or_normalization", axisx=20, uniformflag=True',
        '"compute_matrix_from_translation", traslmethod="XYZ translation", axisx=500',
    )
    assert script != SCRIPT
    log = log_of(f"ms.apply_filter({ROOT!r}); ms.apply_filter({PROPAGATE!r})", script)
    assert (
        "Warning: phantom cavity 01: it lies in another pose and was laid on its parent for the fit"
        in log
    )
    assert "lost" not in log
    assert "Warning: phantom cavity 02" not in log


def test_the_log_says_that_a_root_is_a_sphere():
    sphere = """
def sphere(radius, centre=0.0):
    ms.apply_filter("create_sphere", radius=radius, subdiv=3)
    ms.apply_filter("compute_matrix_from_translation", traslmethod="XYZ translation", axisx=centre)
    ms.set_current_mesh(ms.current_mesh_id())
    ms.apply_filter("compute_spherical_parameterisation_root")
"""
    assert "is itself a sphere: any rotation of its map is as good" in log_of(
        sphere + "sphere(35, 100)"
    )
    assert "lies on the unit sphere, so the other filters take it for one" in log_of(
        sphere + "sphere(1)"
    )
    log = log_of(f"ms.apply_filter({ROOT!r})")
    assert "itself a sphere" not in log and "unit sphere" not in log


def test_a_filter_error_does_not_leave_a_dead_log_behind():
    """PyMeshLab keeps a MeshSet's log in the plugin when a filter throws, also after that MeshSet
    is gone."""
    log = log_of(f"""
other = pymeshlab.MeshSet()
other.apply_filter("create_ventricle_phantom", phases=1, voxel_size=4)
try:
    ms.apply_filter("generate_icosphere_remeshing")
except pymeshlab.PyMeshLabException:
    pass
del ms
other.apply_filter({ROOT!r})
print("still here")
""")
    assert "still here" in log


@pytest.mark.parametrize("order", ["Time", "Star", "Similarity tree"])
def test_skulls_of_several_species_get_valid_maps(order):
    meshes = pymeshlab.MeshSet()
    files = files_of("finch_skulls")
    for file in files:
        meshes.load_new_mesh(str(file))
    meshes.set_current_mesh(0)
    meshes.apply_filter(ROOT)
    figures = meshes.apply_filter(PROPAGATE, order=order)
    assert len(figures["flipped_faces"]) == len(files)
    assert np.all(figures["flipped_faces"] == 0)
