# SPDX-License-Identifier: GPL-3.0-only
"""The plugin in MeshLab 2025.07's GUI, checked by what it leaves behind: the project that is saved
from there and read by PyMeshLab. scripts/check-gui builds what this needs and names it:

    MESHLAB_GUI    the program         GUI_PLUGIN     the plugin built for it
    GUI_AGENT      libgui_agent.so     GUI_PICTURES   where pictures go
    SPHERE_PROPAGATION_PLUGIN          the plugin for PyMeshLab, which checks
"""

import contextlib
import os
import shutil
import sys
import tempfile
import time
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
import pymeshlab
import pytest
from gui import CREATING, FILTERS_WITH_DIALOG, GuiError, MeshLab, until
from picking import pick
from PIL import Image

SAMPLE = Path(__file__).parents[2] / "sample_projects/ventricle"
PICTURES = Path(os.environ["GUI_PICTURES"])
FILTERS = {  # menu entry -> menus that show it
    "Beating ventricle phantom": {"Create New Mesh Layer", "Mesh Layer"},
    "Spherical parameterise root": {"Remeshing, Simplification and Reconstruction", "Mesh Layer"},
    "Propagate parameterisation to layers": {
        "Remeshing, Simplification and Reconstruction",
        "Mesh Layer",
    },
    "Optimise parameterisations groupwise": {
        "Remeshing, Simplification and Reconstruction",
        "Mesh Layer",
    },
    "Remesh by icosphere": {"Remeshing, Simplification and Reconstruction"},
    "Evaluate spherical parameterisation": {"Quality Measure and Computations"},
    "Show parameterisation as sphere layers": {"Mesh Layer"},
    "Colour by spherical parameterisation": {
        "Color Creation and Processing",
        "Quality Measure and Computations",
    },
    "Build statistical shape model": {"Mesh Layer", "Quality Measure and Computations"},
    "Fit shape model": {"Mesh Layer"},
    "Prepare surface": {"Cleaning and Repairing"},
    "Load anchors": {"Mesh Layer"},
    "Morph between layers": {"Mesh Layer"},
    "Lay layers side by side": {"Mesh Layer"},
}
ROOT, PROPAGATE, GROUPWISE, REMESH, EVALUATE, SPHERES, COLOR, MODEL = list(FILTERS)[1:-5]
PHANTOM, LAYOUT = "Beating ventricle phantom", "Lay layers side by side"
ANCHORS = "Load anchors"
IMPORTS = (Path(os.environ["GUI_PLUGIN"]).parent / "libfilter_label_volume.so").exists()
IMPORT = "Import label volume as layers"
PHASES = [f"ventricle {i}" for i in range(5)]


@pytest.fixture(scope="session", autouse=True)
def plugin():
    pymeshlab.load_plugin(os.environ["SPHERE_PROPAGATION_PLUGIN"])


@pytest.fixture
def start(tmp_path):
    """start(file...): MeshLab with these files, in a home that holds the plugin where a user puts
    it."""

    def started(*files, **more):
        home = tmp_path / "home"
        folder = home / "data/VCG/MeshLab_64bit_fp/MeshLabExtraPlugins/2025.07"
        folder.mkdir(parents=True, exist_ok=True)
        for plugin in Path(os.environ["GUI_PLUGIN"]).parent.glob("libfilter_*.so"):
            shutil.copy(plugin, folder)
        return MeshLab(
            os.environ["MESHLAB_GUI"],
            home,
            os.environ["GUI_AGENT"],
            files,
            pictures=PICTURES,
            **more,
        )

    return started


@pytest.fixture
def sample():
    """A copy of the sample project, so that the original stays as it is. Pictures show its path,
    which is therefore a short one."""
    with tempfile.TemporaryDirectory(prefix="sample-") as folder:
        shutil.copytree(SAMPLE, folder, dirs_exist_ok=True)
        yield Path(folder) / "ventricle.mlp"


def labels(gui):
    # The star says that a layer is not saved.
    return [label.replace(" *", "") for label in gui.layers()]


def show(gui, name):
    """A picture of everything."""
    gui.trigger("Reset Trackball")
    time.sleep(1)  # it is drawn in the next frame
    gui.picture(name)


def saved(gui, path):
    """The project as PyMeshLab reads it after it was saved from the GUI: {label: layer}."""
    gui.save_project(path)
    ms = pymeshlab.MeshSet()
    ms.load_project(str(path))
    return ms, {m.label(): m for m in ms}


def certified(ms):
    figures = ms.apply_filter("get_spherical_parameterisation_measures")
    return (
        len(figures["valid"])
        if figures["valid"].all() and not figures["flipped_faces"].any()
        else 0
    )


def test_every_filter_is_in_its_menus(start, sample):
    with start(sample) as gui:
        found = {}
        for entry in gui.menus():
            if entry["text"] in FILTERS:
                assert entry["enabled"], entry
                found.setdefault(entry["text"], set()).add(entry["menu"])
        assert set(found) == set(FILTERS)
        assert {name: menus & found[name] for name, menus in FILTERS.items()} == FILTERS
        entries = {(e["menu"], e["text"]) for e in gui.menus()}
        ours = set(FILTERS) | ({IMPORT} if IMPORTS else set())
        assert {("Mesh Layer", name) for name in ours} <= entries  # they stand together


def test_an_empty_project_can_be_filled(start):
    with start() as gui:
        enabled = {(e["menu"], e["text"]) for e in gui.menus() if e["enabled"]}
        creating = {name for name in CREATING if name == PHANTOM or IMPORTS}
        assert {("Create New Mesh Layer", name) for name in creating} <= enabled
        assert not {LAYOUT, ROOT} & {name for _, name in enabled}  # nothing there to work on
        gui.apply(PHANTOM, Phases="2")
        assert labels(gui) == ["phantom cavity 00", "phantom cavity 01"]


def test_dialogs_fit_a_small_screen(start, sample):
    """Apply is seen on a laptop's screen, in the dialog of every filter."""
    with start(sample) as gui:
        gui.fill_screen()
        entries = {e["text"] for e in gui.menus()}
        off, clipped = {}, {}
        for name in entries & set(FILTERS_WITH_DIALOG):  # the volume plugin may be absent
            gui.open_filter(name)
            gui.picture("dialog-" + name.replace(" ", "-"))
            off[name] = gui.button_off_screen()
            clipped[name] = gui.clipped_texts()
            gui.close_dialog()
        assert set(FILTERS) - {EVALUATE, LAYOUT} <= set(off)
        assert off == dict.fromkeys(off, 0)
        assert clipped == dict.fromkeys(off, [])


def test_the_main_job(start, sample):
    """Root, propagation, landmarks, spheres and colours from the menu; the saved project holds them
    all."""
    with start(sample) as gui:
        assert labels(gui) == PHASES
        gui.fill_screen()
        gui.picture("1-opened")
        gui.choose_layer("ventricle 0")
        gui.open_filter(ROOT)
        gui.picture("2-root-dialog")
        assert "0 flipped faces" in gui.apply(ROOT)
        gui.open_filter(PROPAGATE)
        gui.set("Order", "Cyclic time")
        gui.picture("3-propagation-dialog", of_dialog=True)
        assert gui.apply(PROPAGATE, Order="Cyclic time").count("0 flipped faces") == 5
        gui.apply(SPHERES, Beside_the_surfaces=True)
        assert labels(gui) == PHASES + [p + " sphere" for p in PHASES]
        gui.open_filter(COLOR)
        gui.picture("4-colour-dialog")
        for name, pattern in (
            ("5-checkerboard", "Checkerboard"),
            ("6-graticule", "Latitude and longitude"),
            ("7-direction", "Direction"),
            ("8-area-ratio", "Area ratio"),
        ):
            # The tutorial shows the checkerboard that the defaults give.
            more = {} if pattern == "Checkerboard" else {"Cells": "6"}
            assert "10 layers coloured" in gui.apply(COLOR, Pattern=pattern, **more)
            gui.close_dialog()
            show(gui, name)
        gui.apply(REMESH, Frequency="5")
        assert labels(gui) == PHASES + [p + " sphere" for p in PHASES] + [
            p + " landmarks" for p in PHASES
        ]
        assert "15 layers coloured" in gui.apply(COLOR, Pattern="Area ratio")
        gui.close_dialog()
        gui.run(LAYOUT)
        show(gui, "15-side-by-side")
        gui.run(LAYOUT)
        assert gui.run(EVALUATE).count("0 flipped faces") == 5
        ms, layers = saved(gui, sample.parent / "result.mlp")
    assert certified(ms) == 5
    faces = layers["ventricle 0 landmarks"].face_matrix()
    for phase in PHASES:
        surface, landmarks, sphere = (
            layers[phase],
            layers[phase + " landmarks"],
            layers[phase + " sphere"],
        )
        assert surface.has_vertex_tex_coord()
        assert landmarks.vertex_number() == 252 and np.array_equal(landmarks.face_matrix(), faces)
        assert np.abs(np.linalg.norm(sphere.vertex_matrix(), axis=1) - 1).max() < 1e-6
        assert np.array_equal(sphere.face_matrix(), surface.face_matrix())
        assert np.array_equal(sphere.vertex_color_matrix(), surface.vertex_color_matrix())
        assert np.ptp(landmarks.vertex_color_matrix()[:, :3], axis=0).max() > 0.01
        ratio = surface.face_scalar_array()
        assert ratio.min() > 0 and ratio.max() < 20 and ratio.std() > 0
    # The root's is the least.
    assert (
        layers["ventricle 2"].face_scalar_array().std()
        > 2 * layers["ventricle 0"].face_scalar_array().std()
    )


def test_the_shape_model(start, sample):
    with start(sample) as gui:
        gui.fill_screen()
        gui.choose_layer("ventricle 0")
        gui.apply(ROOT)
        gui.apply(PROPAGATE, Order="Cyclic time")
        gui.apply(REMESH)
        assert "mode 1: standard deviation" in gui.apply(MODEL)
        ends = [f"mode {m} {sign}3 sd" for m in (1, 2, 3) for sign in "-+"]
        made = ["mean shape", *ends]
        assert labels(gui)[-7:] == made
        gui.close_dialog()
        show(gui, "12-model")
        ms, layers = saved(gui, sample.parent / "model.mlp")
    faces = layers["ventricle 0 landmarks"].face_matrix()
    assert all(np.array_equal(layers[name].face_matrix(), faces) for name in made)


@pytest.mark.skipif(
    not IMPORTS,
    reason="built without the volume plugin",
)
def test_from_a_label_volume_to_a_model(start):
    """The phantom's scan: labels in, model out, by clicks alone."""
    # Here: it finds the plugin loaded.
    sys.path.insert(0, str(Path(__file__).parents[2] / "python"))
    from sphere_propagation.nifti import write_nifti
    from sphere_propagation.phantom import Ventricle

    with tempfile.TemporaryDirectory(prefix="scan-") as folder:
        scan, model = Path(folder) / "scan.nii.gz", Path(folder) / "model.npz"
        labels_of_the_phantom, affine = Ventricle(phases=10).scan()
        write_nifti(scan, labels_of_the_phantom, affine)
        with start() as gui:
            gui.fill_screen()
            gui.open_filter(IMPORT)
            gui.set("File", str(scan))
            gui.picture("13-import-dialog", of_dialog=True)
            gui.apply(IMPORT, File=str(scan))
            surfaces = [f"scan label 1 phase {phase:02d}" for phase in range(10)]
            assert labels(gui) == surfaces
            gui.close_dialog()
            gui.trigger("Front (Z is up)")  # z is superior
            time.sleep(1)
            gui.picture("14-imported")
            gui.choose_layer(gui.layers()[0])
            gui.apply(ROOT)
            gui.apply(PROPAGATE, Order="Cyclic time")
            gui.apply(REMESH)
            assert "mode 1: standard deviation" in gui.apply(
                MODEL, Modes_shown="1", Export_file=str(model)
            )
            assert labels(gui)[10:20] == [name + " landmarks" for name in surfaces]
            assert labels(gui)[20:] == ["mean shape", "mode 1 -3 sd", "mode 1 +3 sd"]
        with np.load(model) as written:
            assert written["scores"].shape == (10, 9) and written["mean"].shape == (1002, 3)


def test_anchors_by_clicks(start, sample):
    """Points picked on a layer lie beside its mesh, where they are found; those of the sample's
    folder are shown, and held."""
    file = sample.parent / "surfaces/ventricle_0_picked_points.pp"
    with start(sample) as gui:
        gui.fill_screen()
        gui.choose_layer("ventricle 0")
        assert pick(gui, file, "16-picked")
        assert "3 anchors from" in gui.apply(ANCHORS)
        gui.close_dialog()
        gui.apply(ANCHORS, File=str(sample.parent / "anchors"), Show_anchors=True)
        gui.close_dialog()
        balls = [p + " anchors" for p in PHASES]
        assert labels(gui) == PHASES + balls
        gui.run(LAYOUT)
        show(gui, "17-anchors")
        gui.run(LAYOUT)
        gui.choose_layer(gui.layers()[0])  # which has a star now
        gui.apply(ROOT)
        gui.open_filter(PROPAGATE)
        gui.picture("18-anchors-dialog", of_dialog=True)
        said = gui.apply(PROPAGATE, Order="Cyclic time", Anchors="Exact")
        assert said.count("0 flipped faces") == 5 and "Anchors, " in said, said
        ms, layers = saved(gui, sample.parent / "result.mlp")
    assert certified(ms) == 5
    for phase in PHASES:
        assert layers[phase + " anchors"].vertex_number() == 4 * 92, phase  # icospheres


def test_the_finished_sample_opens(start, sample):
    with start(sample.parent / "finished/finished.mlp") as gui:
        assert labels(gui) == PHASES + [p + " landmarks" for p in PHASES] + ["ventricle 0 sphere"]
        gui.fill_screen()
        show(gui, "9-finished")
        assert gui.run(EVALUATE).count("0 flipped faces") == 5


def test_the_dialogs_name_the_largest_layer(start):
    surfaces = [SAMPLE / f"surfaces/ventricle_{i}.ply" for i in (0, 2)]
    with start(*surfaces) as gui:  # the last one opened is the current one
        gui.fill_screen()
        gui.open_filter(ROOT)
        gui.picture("10-root-smaller", of_dialog=True)
        labels = [w["text"] for w in gui.widgets()]
        assert any('"ventricle_0.ply" is the largest' in text for text in labels), labels
        assert '"ventricle_0.ply" is the largest' in gui.apply(ROOT)


def test_a_second_click_while_a_filter_runs(start, sample):
    with start(sample) as gui:
        gui.choose_layer("ventricle 0")
        gui.apply(ROOT)
        gui.open_filter(PROPAGATE)
        before = gui.log()
        gui.start()
        for _ in range(5):
            with contextlib.suppress(GuiError):  # the button is not there for a moment
                gui.start()
        assert gui.wait_for_end(before) is None
        until(lambda: gui.ask("lists"), "an answer")
        ms, _ = saved(gui, sample.parent / "result.mlp")
    assert certified(ms) == 5


def test_an_error_is_shown_and_nothing_is_lost(start, sample, tmp_path):
    surface = pymeshlab.MeshSet()
    surface.load_new_mesh(str(SAMPLE / "surfaces/ventricle_0.ply"))
    whole = surface.current_mesh()
    opened = pymeshlab.MeshSet()
    opened.add_mesh(pymeshlab.Mesh(whole.vertex_matrix(), whole.face_matrix()[:-1]), "open")
    opened.save_current_mesh(str(tmp_path / "open.ply"))
    with start(SAMPLE / "surfaces/ventricle_1.ply", tmp_path / "open.ply") as gui:
        gui.fill_screen()
        gui.open_filter(ROOT)
        before = gui.log()
        gui.start()
        message = gui.wait_for_end(before)
        gui.picture("11-error")
        assert '"open.ply"' in message and "not closed" in message
        gui.close_message()
        assert gui.alive() and labels(gui) == ["ventricle_1", "open"]
        gui.choose_layer("ventricle_1")
        assert "0 flipped faces" in gui.apply(ROOT)


def test_turned_faces_are_drawn_anew(start, tmp_path):
    """A mesh of as many faces as before, whose normals are others: what was dark is bright."""
    ms = pymeshlab.MeshSet()
    ms.load_new_mesh(str(SAMPLE / "surfaces/ventricle_0.ply"))
    ms.add_mesh(pymeshlab.Mesh(ms.mesh(0).vertex_matrix(), ms.mesh(0).face_matrix()[:, ::-1]))
    ms.save_current_mesh(str(tmp_path / "inward.ply"), save_vertex_color=False)
    with start(tmp_path / "inward.ply") as gui:
        gui.fill_screen()
        light = []
        for name in ("19-inward", "20-turned"):
            if light:
                assert "faces turned" in gui.apply("Prepare surface")
                gui.close_dialog()
            gui.trigger("Reset Trackball")
            time.sleep(1)
            picture = np.asarray(Image.open(gui.picture(name)).convert("L"), float)
            light.append(picture[330:470, 330:470].mean())  # the middle of what is seen
    assert light[1] > 1.5 * light[0], light


def test_hidden_and_moved_layers(start, sample):
    """A hidden layer is left alone; a layer that its matrix moves is taken where it is seen."""
    project = xml.parse(sample)
    meshes = project.getroot().findall(".//MLMesh")
    meshes[1].set("visible", "0")
    meshes[2].find("MLMatrix44").text = "\n0 -1 0 0 \n1 0 0 0 \n0 0 1 0 \n0 0 0 1 \n"
    path = sample.parent / "surfaces/ventricle_2.ply"
    turned = pymeshlab.MeshSet()
    # The file is turned back, so that the matrix brings it to its place.
    turned.load_new_mesh(str(path))
    mesh = turned.current_mesh()
    v = mesh.vertex_matrix() @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]).T
    turned.add_mesh(pymeshlab.Mesh(v, mesh.face_matrix()), "turned")
    turned.save_current_mesh(str(path))
    project.write(sample)
    with start(sample) as gui:
        gui.choose_layer("ventricle 0")
        gui.apply(ROOT)
        gui.apply(PROPAGATE)
        gui.apply(REMESH, Frequency="5")
        ms, layers = saved(gui, sample.parent / "result.mlp")
    assert (
        not layers["ventricle 1"].has_vertex_tex_coord() and "ventricle 1 landmarks" not in layers
    )
    assert [k for k in layers if k.endswith("landmarks")] == [
        f"ventricle {i} landmarks" for i in (0, 2, 3, 4)
    ]
    moved, neighbour = layers["ventricle 2 landmarks"], layers["ventricle 3 landmarks"]
    # In mm; a quarter turn is far more.
    assert np.linalg.norm(moved.vertex_matrix() - neighbour.vertex_matrix(), axis=1).mean() < 6
