# SPDX-License-Identifier: GPL-3.0-only
"""Anchors by clicks: where Pick Points of MeshLab 2020.09 takes points, and that "Load anchors"
reads what it saves (docs/anchors.md). Not a part of scripts/test, since real clicks have to wait
for a window that says nothing: after `scripts/test hosts`, `scripts/run-pytest
tests/hosts/check_pick_points.py` (needs xdotool)."""

import os
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np
import pymeshlab
from conftest import SAMPLE
from gui import GuiError, until

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
        environment = dict(
            entry.split("=", 1)
            for entry in Path(f"/proc/{gui.process.pid}/environ").read_text().split("\0")
            if "=" in entry
        )
        until(lambda: "ventricle 0" in gui.layers(), "the layer")
        gui.trigger("PickPoints")
        until(lambda: any(w["class"] == "PickPointsDialog" for w in gui.widgets()), "its dialog")
        x, y, width, height = next(w["place"] for w in gui.widgets() if w["class"] == "GLArea")

        def pointer(*words):
            display = dict(os.environ, DISPLAY=environment["DISPLAY"])
            subprocess.run(["xdotool", *map(str, words)], env=display, check=True)

        def click(at, button):
            # A move before, or Qt does not know where the pointer is; one behind draws anew.
            pointer("mousemove", *at, "sleep", 0.3, "mousemove", at[0] + 1, at[1], "sleep", 0.3)
            pointer("mousedown", button, "sleep", 0.4, "mouseup", button, "sleep", 1)
            pointer("mousemove", at[0] + 30, at[1] + 30, "sleep", 0.3)

        time.sleep(3)
        for across, down in ((0.45, 0.5), (0.4, 0.55), (0.5, 0.4)):
            click((int(x + across * width), int(y + down * height)), 3)
            time.sleep(1)
        gui.picture("picked")
        left, top, width, height = next(
            w["place"] for w in gui.widgets() if w["text"] == "Save" and w["window"] == "Form"
        )
        click((left + width // 2, top + height // 2), 1)

        def named():
            try:
                gui.ask("choose file", file=str(saved))
            except GuiError:
                return False
            return True

        try:
            until(named, "the file dialog", patience=10)
        except GuiError:
            return None  # it asks for no file where there are no points
        until(lambda: saved.exists() and "</PickedPoints>" in saved.read_text(), "the file")
    return saved


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
