# SPDX-License-Identifier: GPL-3.0-only
"""sp.fit and `sphere-propagation fit`: a model on a surface that it was not built from."""

import csv
import warnings
from pathlib import Path

import nibabel
import numpy as np
import pytest
import pyvista
import sphere_propagation as sp
from sphere_propagation import command, fitting


@pytest.fixture(scope="module")
def model(cycle):
    """Of all phases but the third."""
    others = [i for i in range(len(cycle.landmarks)) if i != 2]
    return sp.shape_model(cycle.landmarks[others], cycle.landmark_faces, alignment="None")


def error(points, truth):
    return np.linalg.norm(points - truth, axis=1).mean()


def test_a_fit_is_near_the_landmarks_that_are_right(cycle, model):
    surface, truth = cycle.surfaces[2], cycle.landmarks[2]
    fit = sp.fit(model, surface, pose="as it lies")
    assert error(fit.points, truth) < 1.0
    assert fit.points.shape == model.mean.shape and fit.covariance.shape == (len(model.mean), 3, 3)
    assert fit.scores.shape == fit.score_sd.shape == model.eigenvalues.shape
    placed = fit.pose[:3, :3] @ model.shape(fit.scores).T + fit.pose[:3, 3:]
    assert error(placed.T, fit.points) < 3 * max(fit.figures["local_deviation"], 0.1)
    assert "162 landmarks" in repr(fit)
    # The map gives the surface landmarks of its own.
    assert fit.map.figures["flipped_faces"] == 0
    own = sp.remesh([surface], [fit.map], frequency=4)
    assert error(own.points[0], truth) < 1.0


def test_a_file_is_a_model(cycle, tmp_path):
    file = tmp_path / "model.npz"
    made = sp.shape_model(
        cycle.landmarks, cycle.landmark_faces, alignment="None", export_file=str(file)
    )
    a, b = (sp.fit(m, cycle.surfaces[2], pose="As it lies") for m in (made, str(file)))
    assert np.allclose(a.points, b.points, atol=1e-9)


def test_an_open_surface_has_no_map(cycle, model):
    v, f = cycle.surfaces[2].vertices, cycle.surfaces[2].faces
    top = np.quantile(v[:, 2], 0.7)
    fit = sp.fit(model, (v, f[(v[f][:, :, 2] < top).all(1)]), pose="As it lies")
    assert fit.map is None and fit.figures["unseen"] > 0.05
    assert error(fit.points, cycle.landmarks[2]) < 2


def test_anchors_are_kept(cycle, model):
    truth = cycle.landmarks[2]
    anchors = {j: truth[j] for j in (0, 50, 100, 150)}
    fit = sp.fit(model, cycle.surfaces[2], anchors=anchors, anchor_sd=0.05, pose="Anchors")
    assert fit.figures["starts"] == 1
    assert np.linalg.norm((fit.points - truth)[list(anchors)], axis=1).max() < 0.5


def test_anchors_are_called_by_names_that_the_model_has(
    cycle, model, tmp_path, monkeypatch, capsys
):
    """In the model and in its file; numbers go on working beside names."""
    monkeypatch.chdir(tmp_path)
    truth, names = cycle.landmarks[2], {"apex": 150, "basis ä": 0, "side": 70}
    others = [i for i in range(len(cycle.landmarks)) if i != 2]
    named = sp.shape_model(
        cycle.landmarks[others],
        cycle.landmark_faces,
        alignment="None",
        export_file="model.npz",
        landmark_names=names,
    )
    assert named.landmark_names == names == sp.read_model("model.npz").landmark_names
    places = {name: truth[j] for name, j in names.items()}
    right = sp.fit(
        model,
        cycle.surfaces[2],
        anchors={j: truth[j] for j in names.values()},
        anchor_sd=0.05,
        pose="Anchors",
    )
    for given in (named, "model.npz"):
        fit = sp.fit(given, cycle.surfaces[2], anchors=places, anchor_sd=0.05, pose="Anchors")
        assert np.allclose(fit.points, right.points, atol=1e-6)
    mixed = {"apex": truth[150], 0: truth[0], "side": truth[70]}
    fit = sp.fit(named, cycle.surfaces[2], anchors=mixed, anchor_sd=0.05, pose="Anchors")
    assert np.allclose(fit.points, right.points, atol=1e-6)
    # A file of anchors, by name; and a folder of them, on the command line.
    (tmp_path / "points").mkdir()
    rows = [f"{name};{x:.17g};{y:.17g};{z:.17g}" for name, (x, y, z) in places.items()]
    (tmp_path / "points" / "p.csv").write_text("\n".join(["name;x;y;z", *rows]) + "\n")
    fit = sp.fit(named, cycle.surfaces[2], anchors="points/p.csv", anchor_sd=0.05, pose="Anchors")
    assert np.allclose(fit.points, right.points, atol=1e-6)
    sp.write_ply("p.ply", cycle.surfaces[2].vertices, cycle.surfaces[2].faces)
    words = ["fit", "model.npz", "p.ply", "--pose", "anchors", "--anchors", "points"]
    assert command.main([*words, "--anchor-sd", "0.05"]) == 0
    with np.load("fit/p_fit.npz") as file:
        assert np.allclose(file["landmarks"], right.points, atol=0.1)  # a file of floats
    # Others are named.
    with pytest.raises(sp.InputError, match="no landmark called 'tip'; .*apex"):
        sp.fit(named, cycle.surfaces[2], anchors={"tip": (0, 0, 0)})
    (tmp_path / "points" / "p.csv").write_text("tip;0;0;0\n")
    with pytest.raises(sp.FilterError, match="apex, basis ä, side"):
        sp.fit(named, cycle.surfaces[2], anchors="points/p.csv")
    # A table of the user's own for a model that is there.
    sp.name_landmarks("model.npz", {"tip": 3})
    assert sp.read_model("model.npz").landmark_names == {"tip": 3}
    for wrong in ({"x": 162}, {"": 3}, {"x": 1.5}, [3]):
        with pytest.raises(sp.InputError):
            sp.name_landmarks("model.npz", wrong)


@pytest.mark.parametrize(
    "anchors, words",
    [
        ([(0, 0, 0)], "dictionary"),
        ({1000: (0, 0, 0)}, "no landmark 1000"),
        ({1.5: (0, 0, 0)}, "whole number"),
        ({0: (0, 0)}, "three numbers"),
        ({0: (0, 0, np.nan)}, "three numbers"),
    ],
)
def test_anchors_that_cannot_be(cycle, model, anchors, words):
    with pytest.raises(sp.InputError, match=words):
        sp.fit(model, cycle.surfaces[2], anchors=anchors)


def test_what_it_refuses(cycle, model):
    surface = cycle.surfaces[2]
    with pytest.raises(sp.FilterError, match="pose must be one of"):
        sp.fit(model, surface, pose="Somewhere")
    with pytest.raises(sp.FilterError, match="number of modes"):
        sp.fit(model, surface, modes=-1)
    with pytest.raises(sp.FilterError, match="no faces"):
        sp.fit(model, sp.Surface(surface.vertices, np.zeros((0, 3), int), "points"))


def test_the_command_fits_a_folder(cycle, model, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sp.shape_model(
        cycle.landmarks, cycle.landmark_faces, alignment="Rigid", export_file="model.npz"
    )
    (tmp_path / "patients").mkdir()
    for k in (1, 2):
        surface = cycle.surfaces[k]
        sp.write_ply(tmp_path / "patients" / f"p{k}.ply", surface.vertices, surface.faces)
    assert command.main(["fit", "model.npz", "patients", "-o", "out", "--pose", "as-it-lies"]) == 0
    said = capsys.readouterr().out
    assert "p1: " in said and "p2: " in said and "fits.csv" in said
    assert " mm from the surface" in said  # the default
    with open("out/fits.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["surface"] for row in rows] == ["p1", "p2"]
    assert all(row["map"] == "1" and float(row["surface_distance"]) < 1 for row in rows)
    with np.load("out/p1_fit.npz") as fit:
        assert fit["landmarks"].shape == (162, 3) and fit["covariance"].shape == (162, 3, 3)
    assert sp.read_mesh("out/p1_fit.ply").vertices.shape == (162, 3)
    assert sp.read_map("out/p1.ply").positions.shape == cycle.surfaces[1].vertices.shape
    # And again, in the same folder.
    words = ["fit", "model.npz", "patients", "-o", "out", "--modes-only", "--unit", "cm"]
    assert command.main(words) == 0
    assert " cm from the surface" in capsys.readouterr().out
    with open("out/fits.csv", newline="") as file:
        assert {row["unit"] for row in csv.DictReader(file)} == {"cm"}


def test_another_organ_is_named(cycle, tmp_path, capsys, monkeypatch):
    """Whatever the organ and its size: in Python, on the terminal and in the table; and no phase of
    the cycle itself is."""
    monkeypatch.chdir(tmp_path)
    sp.shape_model(cycle.landmarks, cycle.landmark_faces, alignment="Rigid", export_file="m.npz")
    size = np.ptp(cycle.surfaces[0].vertices, axis=0).max()
    wall = sp.make_phantom(part="Wall", phases=1, voxel_size=4.0)[0]
    sphere = pyvista.Sphere(theta_resolution=24, phi_resolution=24).scale(0.5 * size)
    long = pyvista.Sphere(theta_resolution=24, phi_resolution=24).scale(
        [0.2 * size, 0.2 * size, 1.5 * size]
    )
    for name, organ in (("wall", wall), ("ball", sphere), ("rod", long)):
        with pytest.warns(sp.SpherePropagationWarning) as said:
            sp.fit("m.npz", organ)
        assert {"fitIsFarOff", "surfaceUnexplained"} & {str(w.message.message) for w in said}, name
    for name, surface in (("wall", wall), ("phase", cycle.surfaces[1])):
        sp.write_ply(tmp_path / f"{name}.ply", surface.vertices, surface.faces)
    assert command.main(["fit", "m.npz", "wall.ply", "phase.ply"]) == 0
    said = capsys.readouterr()
    assert "1 of 2 deserve a look before their figures are used" in said.out
    assert said.err.startswith("warning: wall: ")
    with open("fit/fits.csv", newline="") as file:
        rows = {row["surface"]: row["warnings"].split() for row in csv.DictReader(file)}
    assert rows["phase"] == [] and {"fitIsFarOff", "surfaceUnexplained"} & set(rows["wall"])


def test_a_mirror_image_is_named_where_the_pose_is_searched_for(cycle):
    centre = cycle.landmarks.mean((0, 1))

    def twisted(points):
        """The phantom's cavity is nearly its own mirror image; this is not."""
        x, y, z = (np.asarray(points) - centre).T
        c, s = np.cos(0.02 * z), np.sin(0.02 * z)
        return np.stack([1.4 * c * x - s * y, 1.4 * s * x + c * y, z], -1)

    model = sp.shape_model(
        [twisted(x) for x in cycle.landmarks[1:]], cycle.landmark_faces, alignment="Rigid"
    )
    v, f = twisted(cycle.surfaces[0].vertices), np.asarray(cycle.surfaces[0].faces)
    named = {}
    for side in (1, -1):
        surface = v * [side, 1, 1], f[:, ::side]
        for pose in ("Search", "As it lies"):
            with warnings.catch_warnings(record=True) as said:
                warnings.simplefilter("always")
                sp.fit(model, surface, pose=pose)
            named[side, pose] = any(str(w.message.message) == "mirrorImageFitsBetter" for w in said)
    assert named.pop((-1, "Search")) and not any(named.values())


def test_a_label_volume_is_a_surface(cycle, model, tmp_path, capsys, monkeypatch):
    """The scan of the third phase, in slices 8 mm apart, as a file and as an array with its
    affine."""
    labels, affine = sp.Ventricle("Cavity", len(cycle.landmarks), 0).scan()
    one = np.where(labels[..., 2] == 1, np.uint8(3), np.uint8(0)), affine
    nibabel.save(nibabel.Nifti1Image(*one), tmp_path / "scan.nii.gz")
    surface = sp.read_label_volume(one, labels=3).surfaces[0]
    right = sp.fit(model, surface, pose="As it lies")
    for volume in (one, str(tmp_path / "scan.nii.gz"), nibabel.Nifti1Image(*one)):
        fit = sp.fit(model, volume, label=3, pose="As it lies")
        assert np.allclose(fit.points, right.points, atol=1e-3)
        assert fit.map is not None and fit.map.figures["flipped_faces"] == 0
    assert error(right.points, cycle.landmarks[2]) < 5  # slices 8 mm apart
    with pytest.raises(sp.FilterError, match="label"):
        sp.fit(model, one, label=1)
    with pytest.raises(sp.InputError, match="6 phases"):
        sp.fit(model, (labels, affine))
    # On the command line each phase of a volume is fitted.
    monkeypatch.chdir(tmp_path)
    sp.shape_model(cycle.landmarks, cycle.landmark_faces, alignment="None", export_file="model.npz")
    some = np.where(labels[..., 1:3] == 1, np.uint8(3), np.uint8(0))
    nibabel.save(nibabel.Nifti1Image(some, affine), "two.nii.gz")
    assert command.main(["fit", "model.npz", "two.nii.gz", "scan.nii.gz", "--label", "3"]) == 0
    with open("fit/fits.csv", newline="") as file:
        names = [row["surface"] for row in csv.DictReader(file)]
    assert len(names) == 3 and names[2] == "scan"
    assert all(name.startswith("two") for name in names[:2])
    assert "scan: " in capsys.readouterr().out


def test_choices_are_spelt_as_the_filter_has_them():
    assert fitting.POSES == ("Search", "As it lies", "Anchors")
    assert fitting.SIZES == ("As the model", "Rigid", "Similarity")


@pytest.fixture
def here(cycle, tmp_path, monkeypatch):
    """A folder with m.npz, p0.ply and p1.ply, to work in."""
    monkeypatch.chdir(tmp_path)
    sp.shape_model(cycle.landmarks, cycle.landmark_faces, alignment="Rigid", export_file="m.npz")
    for k in (0, 1):
        surface = cycle.surfaces[k]
        sp.write_ply(tmp_path / f"p{k}.ply", surface.vertices, surface.faces)
    return tmp_path


def test_the_command_goes_on_after_what_cannot_be_fitted(cycle, here, capsys):
    inside = cycle.surfaces[2]
    sp.write_ply("inside.ply", inside.vertices, inside.faces[:, ::-1])
    Path("text.ply").write_text("no mesh")
    assert command.main(["fit", "m.npz", "p0.ply", "inside.ply", "text.ply", "p1.ply"]) == 1
    said = capsys.readouterr()
    assert "p0: " in said.out and "p1: " in said.out and "inside: not fitted" in said.out
    assert "text.ply cannot be read" in said.err and "run --prepare turns them round" in said.err
    assert "faces[" not in said.err and "not fitted: text, inside" in said.err
    with open("fit/fits.csv", newline="") as file:
        rows = {row["surface"]: row for row in csv.DictReader(file)}
    assert list(rows) == ["p0", "inside", "text", "p1"]
    assert all((row["error"] == "") == (name[0] == "p") for name, row in rows.items())
    assert "run --prepare" in rows["inside"]["error"] and rows["inside"]["deviation"] == ""
    assert Path("fit/p1_fit.npz").exists() and not Path("fit/inside_fit.npz").exists()
    assert command.main(["fit", "m.npz", "inside.ply", "-o", "other"]) == 1
    assert "fit.npz" not in capsys.readouterr().out and Path("other/fits.csv").exists()


def test_the_command_names_anchors_that_are_not_there(cycle, here, capsys):
    points = [cycle.landmarks[0][j] for j in (0, 5, 9)]
    rows = [f"{j},{x},{y},{z}" for j, (x, y, z) in zip((0, 5, 9), points)]
    Path("anchors").mkdir()
    Path("anchors/p0.csv").write_text("\n".join(rows))
    Path("anchors/P1.csv").write_text("\n".join(rows))
    by = ["fit", "m.npz", "p0.ply", "p1.ply", "--anchors", "anchors"]
    assert command.main(by) == 0
    said = capsys.readouterr().err
    assert "has no file for p1: it is taken without" in said and "otherwise: P1.csv" in said
    assert command.main([*by, "--pose", "anchors"]) == 1
    said = capsys.readouterr()
    assert (
        "p1: its pose is to be" in said.err and "none of anchors/p1_picked_points.pp, " in said.err
    )
    assert "p0: " in said.out and "p1: not fitted" in said.out
    Path("anchors/p0.csv").write_text("")
    assert command.main(by) == 1
    assert "p0.csv holds no anchor" in capsys.readouterr().err
    for words, text in (
        (["--anchors", "none"], "--anchors: there is no file or folder none"),
        (["--pose", "anchors"], "--pose: 'Anchors' needs anchors"),
    ):
        assert command.main(["fit", "m.npz", "p0.ply", *words]) == 2
        assert text in capsys.readouterr().err
