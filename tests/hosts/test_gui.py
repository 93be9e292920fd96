# SPDX-License-Identifier: GPL-3.0-only
"""MeshLab 2020.09's GUI: what a user meets. Pictures are kept in
build/test-results/screenshots/."""

import shutil

import documents
import numpy as np
import pymeshlab
import pytest
from gui import CREATING, FILTERS, FILTERS_WITH_DIALOG, GuiError, until

ROOT, PROPAGATE, REMESH, EVALUATE, SPHERES, PHANTOM, MODEL, LAYOUT = (
    "Spherical parameterise root",
    "Propagate parameterisation to layers",
    "Remesh by icosphere",
    "Evaluate spherical parameterisation",
    "Show parameterisation as sphere layers",
    "Beating ventricle phantom",
    "Build statistical shape model",
    "Lay layers side by side",
)


def ready(gui, count):
    until(lambda: len(gui.layers()) == count, f"{count} layers")


def opened(gui, count):
    """Also where the machine is so busy that a layer is listed long before it is read."""
    until(lambda: gui.log().count("Opened mesh") == count, f"{count} files to be read")
    ready(gui, count)


def names(gui):
    return [label.removesuffix(" *").removesuffix("*").strip() for label in gui.layers()]


def test_the_whole_job(meshlab, surfaces):
    with meshlab(*surfaces[:3]) as gui:
        opened(gui, 3)
        menus = {(e["menu"], e["text"]) for e in gui.menus()}
        for menu, name in [
            ("Remeshing, Simplification and Reconstruction", ROOT),
            ("Mesh Layer", ROOT),
            ("Remeshing, Simplification and Reconstruction", PROPAGATE),
            ("Mesh Layer", PROPAGATE),
            ("Remeshing, Simplification and Reconstruction", REMESH),
            ("Quality Measure and Computations", EVALUATE),
            ("Mesh Layer", SPHERES),
            *(("Create New Mesh Layer", name) for name in CREATING),
            *(("Mesh Layer", name) for name in FILTERS),  # together
        ]:
            assert (menu, name) in menus

        gui.open_filter(ROOT)
        texts = [w["text"] for w in gui.widgets()]
        assert any("certified valid" in t for t in texts)  # what the filter is
        assert any(t.startswith("Initial map") for t in texts) and "Area weight" in texts
        choices = next(w for w in gui.widgets() if w.get("items") and "Brechbuehler" in w["items"])
        assert (
            choices["items"] == ["Automatic", "Brechbuehler", "Harmonic"]
            and choices["text"] == "Automatic"
        )
        assert not any("Preview" in t for t in texts)
        gui.picture("1-root-dialog")

        assert "ventricle_2.ply" in gui.apply(ROOT, Initial_map="Brechbuehler")
        added = gui.apply(PROPAGATE, Method="As published")
        assert added.count("0 flipped faces") == 3
        gui.picture("2-propagated")
        gui.apply(REMESH)
        assert names(gui) == [f"ventricle_{i}" for i in range(3)] + [
            f"ventricle_{i} landmarks" for i in range(3)
        ]
        assert "492 landmarks" in gui.apply(REMESH, Frequency="7")  # replaced, not added
        assert len(gui.layers()) == 6
        gui.apply(SPHERES, Beside_the_surfaces=True)
        assert len(gui.layers()) == 9
        gui.run(EVALUATE)
        gui.picture("3-done")


def test_open_ventricles_get_lids_and_maps(meshlab, surfaces, tmp_path):
    """Cut across the upper third, as they come from segmentations that end at the valves."""
    files = []
    for file in surfaces[:3]:
        ms = pymeshlab.MeshSet()
        ms.load_new_mesh(str(file))
        v, f = ms.current_mesh().vertex_matrix(), ms.current_mesh().face_matrix()
        height = v[f].mean(1)[:, 2]
        kept = f[height < np.quantile(height, 0.8)]
        used, numbers = np.unique(kept, return_inverse=True)
        cut = pymeshlab.MeshSet()
        cut.add_mesh(pymeshlab.Mesh(v[used], numbers.reshape(-1, 3)))
        files.append(tmp_path / f"open_{file.name}")
        cut.save_current_mesh(str(files[-1]), save_vertex_color=False)
    with meshlab(*files) as gui:
        opened(gui, 3)
        gui.picture("1-open")
        with pytest.raises(GuiError, match="Prepare surface"):
            gui.apply(ROOT)
        gui.close_message()
        gui.close_dialog()
        said = gui.apply("Prepare surface", All_visible_surfaces=True)
        assert said.count("1 opening closed") == 3
        gui.picture("2-closed")
        assert "0 flipped faces" in gui.apply(ROOT)
        assert gui.apply(PROPAGATE).count("0 flipped faces") == 3
        assert "lie on lids" in gui.apply(REMESH)
        gui.picture("3-landmarks")


def test_an_empty_project_can_be_filled(meshlab):
    with meshlab() as gui:
        enabled = {(e["menu"], e["text"]) for e in gui.menus() if e["enabled"]}
        assert {("Create New Mesh Layer", name) for name in CREATING} <= enabled
        assert not {LAYOUT, ROOT} & {name for _, name in enabled}  # nothing there to work on
        added = gui.apply(PHANTOM, Phases="2")
        assert "Next: Spherical parameterise root." in added
        assert names(gui) == ["phantom cavity 00", "phantom cavity 01"]


def test_a_failure_is_shown_and_survived(meshlab, surfaces):
    with meshlab(surfaces[0]) as gui:
        opened(gui, 1)
        with pytest.raises(GuiError, match="between 0 and 1"):
            gui.apply(ROOT, Area_weight="7")
        gui.picture("message")
        gui.close_message()
        assert gui.alive()
        assert "0 flipped faces" in gui.apply(ROOT, Area_weight="1")


def test_clicks_while_a_filter_runs(meshlab, surfaces):
    """They are ignored: the filter runs once, no layer is closed under it, and MeshLab lives on."""
    with meshlab(surfaces[0]) as gui:
        opened(gui, 1)
        before = gui.log()
        gui.open_filter(PHANTOM)
        gui.set("Phases", "60")  # each calls the progress bar, whose event loop answers the clicks
        gui.start()
        for _ in range(5):
            gui.click("Apply", window=PHANTOM)
        assert "phases of the phantom" not in gui.log()  # all of them met it at work
        assert gui.wait_for_end(before) is None
        until(lambda: len(gui.layers()) == 61, "60 new layers")
        assert gui.log().count("Applied filter") == 1
        gui.picture("after-many-clicks")
        assert "0 flipped faces" in gui.apply(ROOT)


def test_a_project_is_saved_and_opened_again(meshlab, surfaces, tmp_path):
    files = [shutil.copy(file, tmp_path) for file in surfaces[:2]]
    project = tmp_path / "saved.mlp"
    with meshlab(*files) as gui:
        opened(gui, 2)
        for name in (ROOT, PROPAGATE, REMESH):
            gui.apply(name)
        gui.save_project(project)

    meshes = pymeshlab.MeshSet()
    meshes.load_project(str(project))
    assert meshes.apply_filter(documents.EVALUATE)["valid"].tolist() == [1, 1]
    assert meshes.mesh_number() == 4 and len(documents.landmark_layers(meshes)) == 2

    with meshlab(project) as gui:
        ready(gui, 4)
        # The maps are known again, and landmark layers replaced.
        assert gui.apply(REMESH).count("1002 landmarks") == 2
        assert len(gui.layers()) == 4


def large_sphere(file, lines=700):
    """A mesh that takes MeshLab a while to read."""
    theta, phi = np.linspace(0.01, 3.13, lines), np.linspace(0, 2 * np.pi, lines, endpoint=False)
    x = np.outer(np.sin(theta), np.cos(phi)), np.outer(np.sin(theta), np.sin(phi))
    v = 50 * np.stack([*x, np.outer(np.cos(theta), np.ones(lines))], -1).reshape(-1, 3)
    i, j = np.indices((lines - 1, lines))
    a, b = (i * lines + j).ravel(), (i * lines + (j + 1) % lines).ravel()
    f = np.concatenate([np.stack([a, a + lines, b], 1), np.stack([b, a + lines, b + lines], 1)])
    meshes = pymeshlab.MeshSet()
    documents.add(meshes, v, f, "large")
    meshes.save_current_mesh(str(file))
    return file


def test_a_filter_is_chosen_while_a_file_is_read(meshlab, surfaces, tmp_path):
    """MeshLab's window lets it be; the faces have no vertices then."""
    with meshlab(surfaces[0], large_sphere(tmp_path / "large.ply")) as gui:
        until(lambda: len(gui.layers()) == 2, "the second layer to be begun")
        gui.open_filter(PROPAGATE)
        gui.start()
        until(lambda: gui.message() or gui.log().count("Opened mesh") == 2, "an answer")
        if gui.message():  # a quick machine may have read it by now
            # Its vertices are there, then its faces; read: no layer has a map, or the sphere, which
            # lacks its poles, is looked at.
            answers = ("no faces", "still being read", "no map", "it is not closed")
            message = gui.message()
            assert any(answer in message for answer in answers), message
            gui.close_message()
        opened(gui, 2)


def test_dialogs_fit_a_small_screen(meshlab, surfaces):
    """Apply is seen on a laptop's screen, in the dialog of every filter."""
    with meshlab(*surfaces[:2]) as gui:
        opened(gui, 2)
        gui.fill_screen()
        off, hidden = {}, {}
        for name in FILTERS_WITH_DIALOG:
            gui.open_filter(name)
            gui.picture(name.replace(" ", "-"))
            off[name] = gui.button_off_screen()
            hidden[name] = gui.hidden_below_buttons() + gui.clipped_texts()
        assert off == dict.fromkeys(FILTERS_WITH_DIALOG, 0)
        assert hidden == dict.fromkeys(FILTERS_WITH_DIALOG, [])


def test_advanced_parameters_are_folded_away(meshlab, surfaces):
    with meshlab(*surfaces[:2]) as gui:
        opened(gui, 2)

        def labels():
            return {w["text"] for w in gui.widgets() if w["window"] == PROPAGATE}

        gui.open_filter(PROPAGATE)
        assert "Parents" in labels() and "Smoothing sweeps" not in labels()
        gui.click("Help", window=PROPAGATE)
        until(lambda: any(t.startswith("Which layer hands") for t in labels()), "the help")
        assert not any(t.startswith("As published: sweeps") for t in labels())
        gui.click("Help", window=PROPAGATE)
        gui.click("Advanced parameters", window=PROPAGATE)
        until(lambda: "Smoothing sweeps" in labels(), "the advanced parameters")
        gui.set("Threads", "-1")
        gui.start()
        until(gui.message, "what the filter says of it")
        assert "number of threads" in gui.message()
        gui.close_message()
        gui.click("Advanced parameters", window=PROPAGATE)
        until(lambda: "Smoothing sweeps" not in labels(), "the advanced parameters to go")


def test_a_path_that_is_typed_counts(meshlab, surfaces, tmp_path):
    """MeshLab itself takes a file from its chooser only."""
    file = tmp_path / "model.csv"
    with meshlab(*surfaces[:2]) as gui:
        opened(gui, 2)
        for name in (ROOT, PROPAGATE, REMESH):
            gui.apply(name)
        assert "Export file: none" in gui.apply(MODEL)
        assert f"written: {file}" in gui.apply(MODEL, Export_file=str(file))
        assert file.read_text().count("\n") == 3


def test_results_are_shown_beside_what_they_came_from(meshlab, surfaces, tmp_path):
    files = [shutil.copy(file, tmp_path) for file in surfaces[:2]]
    with meshlab(*files) as gui:
        opened(gui, 2)
        gui.fill_screen()
        gui.apply(ROOT)
        assert "2 surfaces, 2 mapped. Next: Remesh by icosphere." in gui.apply(PROPAGATE)
        assert "shown to the right" in gui.apply(REMESH)
        assert "A model of 2 shapes, 1 mode." in gui.apply(MODEL)
        gui.close_dialog()
        gui.picture("beside")
        gui.save_project(tmp_path / "saved.mlp")
        assert "7 layers side by side" in gui.run(LAYOUT)
        gui.picture("side-by-side")
        assert "7 layers are in place" in gui.run(LAYOUT)
        assert "A model of 2 shapes, 1 mode." in gui.apply(MODEL)  # of the same landmarks
    meshes = pymeshlab.MeshSet()
    meshes.load_project(str(tmp_path / "saved.mlp"))
    x = [m.transformed_vertex_matrix()[:, 0] for m in meshes]
    assert len(x) == 7
    for left, right in [(0, 2), (1, 2), (2, 3), (3, 4), (4, 5)]:
        assert x[left].max() < x[right].min()
