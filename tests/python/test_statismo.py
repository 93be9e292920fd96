# SPDX-License-Identifier: GPL-3.0-only
"""Shape models of statismo and scalismo, read by read_model and fitted."""

import json
import sys

import h5py
import numpy as np
import pytest
import sphere_propagation as sp


@pytest.fixture(scope="module")
def model(cycle):
    return sp.shape_model(cycle.landmarks, cycle.landmark_faces, alignment="None")


def write(path, model, place="", **changes):
    """By the layout that scalismo's StatismoIO writes: 32-bit floats, modes in columns, points and
    cells in columns, attributes of the representer, the version at the root. changes: of data sets,
    None leaves one out; kind, version and representer."""
    count = len(model.mean)
    basis = model.modes.reshape(len(model.modes), -1).T
    arrays = {
        "model/mean": model.mean.ravel().astype("f4"),
        "model/pcaBasis": basis.astype("f4"),
        "model/pcaVariance": model.eigenvalues.astype("f4"),
        "model/noiseVariance": np.float32([0]),
        "representer/points": model.mean.T.astype("f4"),
        "representer/cells": model.faces.T.astype("i4"),
        **changes.get("arrays", {}),
    }
    with h5py.File(path, "a") as file:
        for name, values in arrays.items():
            if values is not None:
                file[f"{place}/{name}"] = values
        about = file.require_group(f"{place}/representer").attrs
        about["name"] = np.array([b"itkStandardMeshRepresenter"])
        if changes.get("kind", "POLYGON_MESH"):
            about["datasetType"] = np.array([changes.get("kind", "POLYGON_MESH").encode()])
        major, minor = changes.get("version", (0, 9))
        if "version" not in file:
            file["version/majorVersion"], file["version/minorVersion"] = major, minor
    assert count
    return path


def covariance(model):
    scaled = model.modes.reshape(len(model.modes), -1) * np.sqrt(model.eigenvalues)[:, None]
    return scaled.T @ scaled


def alike(a, b):
    size = np.abs(b.mean).max()
    assert np.abs(a.mean - b.mean).max() < 1e-5 * size
    assert np.array_equal(a.faces, b.faces)
    assert np.abs(covariance(a) - covariance(b)).max() < 1e-5 * np.abs(covariance(b)).max()
    assert np.allclose(a.eigenvalues, b.eigenvalues, rtol=1e-4, atol=1e-6 * b.eigenvalues.max())


def test_a_model_by_the_layout_of_scalismo(model, tmp_path):
    found = sp.read_model(write(tmp_path / "model.h5", model))
    alike(found, model)
    assert found.scores.shape == (0, len(model.modes)) and found.names == []
    assert found.noise_variance == 0


@pytest.mark.parametrize("ending", ["h5", "json"])
def test_what_this_package_exports_comes_back(cycle, model, tmp_path, ending):
    file = tmp_path / f"model.{ending}"
    sp.shape_model(cycle.landmarks, cycle.landmark_faces, alignment="None", export_file=str(file))
    found = sp.read_model(file)
    alike(found, model)
    assert np.allclose(found.scores, model.scores, atol=1e-4 * np.abs(model.scores).max())


def test_what_is_orthonormal_and_what_is_not(model, tmp_path):
    """Version 0.8 has standard deviations in the basis; models of kernels have columns that are
    not orthogonal, which are turned into principal axes; and some write variances in any order."""
    basis = model.modes.reshape(len(model.modes), -1).T
    scaled = basis * np.sqrt(model.eigenvalues)
    old = write(
        tmp_path / "old.h5",
        model,
        version=(0, 8),
        arrays={"model/pcaBasis": scaled.astype("f4")},
    )
    alike(sp.read_model(old), model)
    turn, _ = np.linalg.qr(np.random.RandomState(0).normal(size=(len(scaled.T),) * 2))
    oblique = (scaled @ turn).astype("f4")
    ones = np.ones(len(turn), "f4")
    found = sp.read_model(
        write(
            tmp_path / "oblique.h5",
            model,
            arrays={"model/pcaBasis": oblique, "model/pcaVariance": ones},
        )
    )
    alike(found, model)
    flat = found.modes.reshape(len(found.modes), -1)
    assert np.allclose(flat @ flat.T, np.eye(len(flat)), atol=1e-6)
    reverse = write(
        tmp_path / "reverse.h5",
        model,
        arrays={
            "model/pcaBasis": basis[:, ::-1].astype("f4"),
            "model/pcaVariance": model.eigenvalues[::-1].astype("f4"),
        },
    )
    alike(sp.read_model(reverse), model)


def test_scores_noise_and_faces(model, tmp_path):
    standard = (model.scores / np.sqrt(model.eigenvalues)).T
    file = write(
        tmp_path / "model.h5",
        model,
        arrays={
            "modelinfo/scores": standard.astype("f4"),
            "model/noiseVariance": np.float32([0.25]),
            "representer/cells": model.faces[:, ::-1],  # F x 3, and inside out
        },
    )
    found = sp.read_model(file)
    assert np.allclose(found.scores, model.scores, atol=1e-3)
    assert found.noise_variance == 0.25 and len(found.names) == len(model.scores)
    assert np.array_equal(found.faces, model.faces)


def test_several_models_in_a_file(model, tmp_path):
    file = write(tmp_path / "face.h5", model, place="/shape")
    alike(sp.read_model(file), model)
    write(file, model, place="/color", arrays={"model/mean": np.zeros(model.mean.size, "f4")})
    alike(sp.read_model(file), model)  # /shape, as face models have it
    two = write(tmp_path / "two.h5", model, place="/a")
    write(two, model, place="/b")
    with pytest.raises(sp.FileError, match="several models, /a, /b"):
        sp.read_model(two)


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"kind": "POINT_SET"}, "of point set"),
        ({"kind": "VOLUME_MESH"}, "of volume mesh"),
        ({"arrays": {"representer/cells": None}}, "no triangles"),
        ({"arrays": {"model/mean": None}}, "no /model/mean"),
        ({"arrays": {"model/pcaVariance": None}}, "no /model/pcaVariance"),
        ({"arrays": {"model/pcaBasis": np.zeros((9, 2), "f4")}}, "do not fit together"),
        ({"arrays": {"model/pcaVariance": np.float32([-1] * 5)}}, "negative"),
        ({"arrays": {"model/mean": np.full(486, np.nan, "f4")}}, "finite"),
        ({"arrays": {"representer/cells": np.full((3, 4), 1000)}}, "landmark that is not there"),
        ({"arrays": {"representer/cells": np.zeros((4, 9), int)}}, "of triangles"),
    ],
)
def test_what_it_refuses(model, tmp_path, changes, words):
    with pytest.raises(sp.FileError, match=words):
        sp.read_model(write(tmp_path / "model.h5", model, **changes))


def test_other_files_and_damaged_ones(model, tmp_path, monkeypatch):
    (tmp_path / "text.h5").write_text("no model")
    (tmp_path / "list.json").write_text(json.dumps([1, 2]))
    (tmp_path / "half.json").write_text('{"groups": ')
    for name, words in (
        ("text.h5", "not an HDF5"),
        ("list.json", "no HDF5/JSON|not HDF5/JSON"),
        ("half.json", "not HDF5/JSON"),
    ):
        with pytest.raises(sp.FileError, match=words):
            sp.read_model(tmp_path / name)
    with pytest.raises(OSError):
        sp.read_model(tmp_path / "none.h5")
    file = write(tmp_path / "model.h5", model)
    (tmp_path / "cut.h5").write_bytes(file.read_bytes()[:-3000])
    with pytest.raises(sp.FileError):
        sp.read_model(tmp_path / "cut.h5")
    # Without h5py the error says what to install; .json needs nothing.
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(sp.FileError, match=r"sphere-propagation\[models\]"):
        sp.read_model(file)


def test_a_model_of_another_mesh_is_fitted_and_explored(model, tmp_path):
    """One whose points are no icosphere: a torus, wider or narrower."""
    u, v = (a.ravel() for a in np.meshgrid(np.arange(24), np.arange(12), indexing="ij"))
    turn, ring = 2 * np.pi * u / 24, 2 * np.pi * v / 12
    out = np.stack([np.cos(turn), np.sin(turn), np.zeros(len(u))], 1)
    tube = np.cos(ring)[:, None] * out + np.sin(ring)[:, None] * [0, 0, 1]
    mean = 40 * out + 15 * tube + 3 * np.c_[out[:, :1] ** 2, np.zeros((len(u), 2))]

    def at(i, j):
        return (i % 24) * 12 + j % 12

    faces = np.array(
        [
            face
            for i in range(24)
            for j in range(12)
            for face in (
                (at(i, j), at(i + 1, j), at(i + 1, j + 1)),
                (at(i, j), at(i + 1, j + 1), at(i, j + 1)),
            )
        ]
    )
    modes = np.stack([(out / np.linalg.norm(out)).ravel(), (tube / np.linalg.norm(tube)).ravel()])
    variances = np.array([(3 * np.linalg.norm(out)) ** 2, (1.5 * np.linalg.norm(tube)) ** 2])
    made = sp.ShapeModel(
        mean, modes.reshape(2, -1, 3), variances, np.zeros((0, 2)), faces, [], 0.0, {}
    )
    read = sp.read_model(write(tmp_path / "torus.h5", made))
    truth = read.shape([0.8 * np.sqrt(read.eigenvalues[0]), -np.sqrt(read.eigenvalues[1])])
    fit = sp.fit(str(tmp_path / "torus.h5"), (truth, read.faces), pose="As it lies")
    assert np.linalg.norm(fit.points - truth, axis=1).mean() < 0.6
    assert fit.map is None and np.isnan(fit.figures["percentile"])
    assert np.array_equal(fit.faces, read.faces)
    page = sp.explore(read)
    assert "0 shapes, 288 landmarks, 2 modes" in page.about


def test_a_folder_is_no_model_and_says_which_lie_in_it(tmp_path):
    with pytest.raises(sp.FileError, match="is a folder, and there is no model.npz in it"):
        sp.read_model(tmp_path)
    for name in ("endo", "wall"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "model.npz").touch()
    with pytest.raises(sp.FileError, match=r"endo/model\.npz, or another of its 2"):
        sp.read_model(tmp_path)
