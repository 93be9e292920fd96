# SPDX-License-Identifier: GPL-3.0-only
"""The sample projects tell what their README says."""

import os
import subprocess
import sys

import numpy as np
import pymeshlab
from documents import COLOR, EVALUATE, LOAD, PROPAGATE, REMESH, ROOT, SPHERES, landmark_layers
from environment import PROJECT

SAMPLE = PROJECT / "sample_projects/ventricle"
PHASES = [f"ventricle {i}" for i in range(5)]


def opened(path):
    ms = pymeshlab.MeshSet()
    ms.load_project(str(path))
    return ms


def test_the_start_has_surfaces_only():
    ms = opened(SAMPLE / "ventricle.mlp")
    assert [m.label() for m in ms] == PHASES
    assert all(
        np.array_equal(m.transform_matrix(), np.eye(4)) and not m.has_vertex_tex_coord() for m in ms
    )
    ms.set_current_mesh(0)
    for name, parameters in (
        (ROOT, {}),
        (PROPAGATE, {"order": "Cyclic time"}),
        (REMESH, {}),
        (SPHERES, {}),
        (COLOR, {}),
    ):
        ms.apply_filter(name, **parameters)
    assert ms.mesh_number() == 15
    assert ms.apply_filter(EVALUATE)["valid"].tolist() == [1] * 5


def test_its_anchors_are_tissue_that_propagation_finds_nearly_and_holds():
    ms = opened(SAMPLE / "ventricle.mlp")
    assert ms.apply_filter(LOAD, file_name=str(SAMPLE / "anchors"))["anchors"].tolist() == [4] * 5
    ms.set_current_mesh(0)
    ms.apply_filter(ROOT)
    found = ms.apply_filter(PROPAGATE, order="Cyclic time", anchors="Exact")
    assert bytes(map(int, found["anchor_names"])).decode() == "apex\nfront\nleft\nright"
    assert found["anchor_distance"].max() < 1e-9
    assert found["anchor_distance_before"].reshape(5, 4)[1:].mean() < 6, "mm"
    assert "warnings" not in found


def test_the_end_has_maps_landmarks_and_colours():
    ms = opened(SAMPLE / "finished/finished.mlp")
    assert [m.label() for m in ms] == PHASES + [p + " landmarks" for p in PHASES] + [
        "ventricle 0 sphere"
    ]
    assert ms.apply_filter(EVALUATE)["valid"].tolist() == [1] * 5
    surfaces, sphere = list(ms)[:5], ms.mesh(10)
    assert all(np.ptp(m.vertex_color_matrix()[:, :3], axis=0).max() > 0.3 for m in ms)
    assert np.array_equal(sphere.vertex_color_matrix(), surfaces[0].vertex_color_matrix())
    marks = landmark_layers(ms)
    assert all(np.array_equal(m.face_matrix(), marks[0].face_matrix()) for m in marks)
    boxes = [(m.bounding_box().min(), m.bounding_box().max(), m.transform_matrix()) for m in ms]
    centres = np.array([(t @ [*(a + b) / 2, 1])[:3] for a, b, t in boxes])
    gaps = np.linalg.norm(centres[:, None] - centres[None], axis=2) + 1e9 * np.eye(len(centres))
    assert gaps.min() > 40  # mm: side by side


def test_it_is_what_make_sample_makes(tmp_path):
    """Up to rounding, which compilers do as they like."""
    script = PROJECT / "sample_projects/make_sample.py"
    paths = {"PYTHONPATH": str(PROJECT / "python")}
    subprocess.run([sys.executable, script, tmp_path], check=True, env={**os.environ, **paths})
    kept = {path.relative_to(SAMPLE) for path in SAMPLE.rglob("*") if path.is_file()}
    made = {
        path.relative_to(tmp_path / "ventricle") for path in tmp_path.rglob("*.*") if path.is_file()
    }
    assert made == kept
    for project in ("ventricle.mlp", "finished/finished.mlp"):
        for a, b in zip(opened(SAMPLE / project), opened(tmp_path / "ventricle" / project)):
            assert a.label() == b.label() and np.array_equal(a.face_matrix(), b.face_matrix())
            assert np.abs(a.vertex_matrix() - b.vertex_matrix()).max() < 0.01  # mm
            assert np.abs(a.transform_matrix() - b.transform_matrix()).max() < 0.01


def test_it_is_small():
    size = sum(path.stat().st_size for path in SAMPLE.rglob("*") if path.is_file())
    assert size < 700_000
