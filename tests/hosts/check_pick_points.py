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


def test_from_clicks_to_maps_that_hold_anchors(meshlab, tmp_path):
    """As check_gui.py does in MeshLab 2025.07."""
    folder = tmp_path / "sample"
    shutil.copytree(SAMPLE, folder)
    with meshlab(folder / "ventricle.mlp") as gui:
        gui.fill_screen()
        until(lambda: len(gui.layers()) == 5, "the layers")
        gui.choose_layer(gui.layers()[0])
        assert pick(gui, folder / "surfaces/ventricle_0_picked_points.pp")
        assert "3 anchors from" in gui.apply("Load anchors")
        gui.close_dialog()
        gui.apply("Load anchors", File=str(folder / "anchors"), Show_anchors=True)
        gui.close_dialog()
        assert sum("anchors" in label for label in gui.layers()) == 5
        gui.picture("anchors")
        gui.choose_layer(gui.layers()[0])
        gui.apply("Spherical parameterise root")
        said = gui.apply(
            "Propagate parameterisation to layers", Order="Cyclic time", Anchors="Exact"
        )
        assert said.count("0 flipped faces") == 5 and "Anchors, " in said, said
