# SPDX-License-Identifier: GPL-3.0-only
"""Anchors by clicks: where Pick Points of MeshLab 2020.09 takes points, and that "Load anchors"
reads what it saves (docs/anchors.md). Not a part of scripts/test, since real clicks have to wait
for a window that says nothing: after `scripts/test hosts`, `scripts/run-pytest
tests/hosts/check_pick_points.py` (needs xdotool)."""

import shutil

import numpy as np
import pymeshlab
from conftest import SAMPLE
from gui import until
from picking import pick

PROJECT = """<!DOCTYPE MeshLabDocument>
<MeshLabProject>
 <MeshGroup>
  <MLMesh label="ventricle 0" filename="ventricle_0.ply" visible="1">
   <MLMatrix44>
{}</MLMatrix44>
  </MLMesh>
 </MeshGroup>
 <RasterGroup/>
</MeshLabProject>
"""


def picked(meshlab, folder, shift):
    """The file that Pick Points saves after three clicks on a layer that is moved so far; None
    where it took none of them."""
    shutil.copy(SAMPLE / "surfaces/ventricle_0.ply", folder)
    rows = np.hstack([np.eye(3, dtype=int), np.reshape(shift, (3, 1))]).tolist() + [[0, 0, 0, 1]]
    # As MeshLab writes it: without the blank that ends a row it crashes.
    matrix = "".join(" ".join(map(str, row)) + " \n" for row in rows)
    (folder / "picking.mlp").write_text(PROJECT.format(matrix))
    saved = folder / "ventricle_0_picked_points.pp"
    with meshlab(folder / "picking.mlp") as gui:
        gui.fill_screen()
        until(lambda: "ventricle 0" in gui.layers(), "the layer")
        return saved if pick(gui, saved) else None


def test_points_are_taken_on_layers_in_the_worlds_frame_alone(meshlab, tmp_path):
    for number, (shift, there) in enumerate((((0, 0, 0), True), ((4, 3, 6), False))):
        folder = tmp_path / str(number)
        folder.mkdir()
        saved = picked(meshlab, folder, shift)
        assert (saved is not None) == there, shift
        if not there:
            continue
        ms = pymeshlab.MeshSet()
        ms.load_project(str(folder / "picking.mlp"))
        ms.apply_filter("load_anchors_to_layers", file_name=str(saved))
        mesh = ms.mesh(0)
        for name in "012":  # which are numbered as they are clicked
            (place,) = np.unique(
                mesh.vertex_custom_point_attribute_matrix(f"anchor_{name}"), axis=0
            )
            assert np.linalg.norm(mesh.vertex_matrix() - place, axis=1).min() < 6, (shift, name)
