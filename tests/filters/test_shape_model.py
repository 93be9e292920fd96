# SPDX-License-Identifier: GPL-3.0-only
"""The statistical shape model: against PCA in numpy, its layers, its files as others read them, and
its errors."""

import csv
import json
import os
import re

import cycles
import numpy as np
import pymeshlab
import pytest
import pyvista
from documents import (
    MODEL,
    REMESH,
    add,
    content,
    labels,
    landmark_layers,
    layer,
    layers,
    mapped_cycle,
    refused,
    snapshot,
)
from filter_log import log_of

NAN = float("nan")


@pytest.fixture(scope="module")
def heart():
    """The landmarks of heart_cine, 30 x 1002 x 3, and their face list."""
    run = cycles.run_pipeline("heart_cine", "Robust", "Cyclic time")
    return np.array(run.landmarks), run.landmark_faces[0]


def project_of(landmarks, faces):
    ms = pymeshlab.MeshSet()
    for k, points in enumerate(landmarks):
        add(ms, points, faces, f"shape {k:02d}")
    return ms


def small_model_project(phases=5, frequency=4):
    """Landmark layers alone."""
    ms = mapped_cycle(phases)
    ms.apply_filter(REMESH, frequency=frequency)
    found = [(m.vertex_matrix(), m.face_matrix()) for m in landmark_layers(ms)]
    return project_of([v for v, _ in found], found[0][1])


def pca(shapes):
    """Mean, modes, eigenvalues (divisor K - 1) and scores of shapes (K x N x 3) as they are."""
    data = shapes.reshape(len(shapes), -1)
    mean = data.mean(0)
    u, s, vt = np.linalg.svd(data - mean, full_matrices=False)
    m = len(shapes) - 1
    return mean.reshape(-1, 3), vt[:m].reshape(m, -1, 3), (s**2 / m)[:m], (u * s)[:, :m]


def procrustes(shapes, rigid=False):
    """Generalised Procrustes alignment by scipy's rotations: frame of the first shape, average
    size."""
    from scipy.spatial.transform import Rotation

    first = shapes[0].mean(0)
    centred = shapes - shapes.mean(1, keepdims=True)
    size = np.linalg.norm(centred, axis=(1, 2)).mean()
    mean = centred[0]
    for _ in range(100):
        turned = np.array([Rotation.align_vectors(mean, x)[0].apply(x) for x in centred])
        scale = (
            np.ones(len(shapes)) if rigid else (turned * mean).sum((1, 2)) / (turned**2).sum((1, 2))
        )
        moved = scale[:, None, None] * turned
        mean = moved.mean(0)
        if not rigid:
            mean *= size / np.linalg.norm(mean)
    moved *= 1 if rigid else size / np.linalg.norm(moved.mean(0))
    back = Rotation.align_vectors(centred[0], moved[0])[0]
    return np.array([back.apply(x) for x in moved]) + first


# ---------------------------------------------------------------- figures


@pytest.mark.parametrize("alignment", ["None", "Rigid", "Similarity"])
def test_the_heart_as_numpy_has_it(heart, alignment):
    landmarks, faces = heart
    returned = project_of(landmarks, faces).apply_filter(MODEL, alignment=alignment)
    shapes = landmarks if alignment == "None" else procrustes(landmarks, alignment == "Rigid")
    mean, modes, eigenvalues, scores = pca(shapes)
    assert returned["eigenvalues"] == pytest.approx(eigenvalues, rel=1e-9)
    assert returned["compactness"] == pytest.approx(np.cumsum(eigenvalues), rel=1e-9)
    assert returned["variance_share"][-1] == pytest.approx(1)
    found = returned["scores"].reshape(30, 29)
    assert np.abs(found) == pytest.approx(np.abs(scores), rel=1e-6, abs=1e-6)
    assert (returned["shapes"], returned["modes"], returned["landmarks"]) == (30, 29, 1002)


def test_generalisation_and_specificity_as_numpy_has_them(heart):
    landmarks, faces = heart[0][::3], heart[1]
    returned = project_of(landmarks, faces).apply_filter(
        MODEL, alignment="None", specificity_samples=20000
    )

    def rms(difference):
        return np.sqrt((difference**2).sum(-1).mean(-1))

    for m in (1, 3, 9):
        distances = []
        for left in range(10):
            mean, modes, _, _ = pca(np.delete(landmarks, left, 0))
            modes = modes[:m]
            away = landmarks[left] - mean
            distances.append(rms(away - np.tensordot(np.tensordot(modes, away, 2), modes, 1)))
        assert returned["generalisation"][m - 1] == pytest.approx(np.mean(distances), rel=1e-9)
        assert returned["generalisation_error"][m - 1] == pytest.approx(
            np.std(distances) / 3, rel=1e-9
        )
        mean, modes, eigenvalues, _ = pca(landmarks)
        random = np.random.default_rng(1)
        samples = mean + np.tensordot(
            random.normal(size=(2000, m)) * np.sqrt(eigenvalues[:m]), modes[:m], 1
        )
        nearest = np.min([rms(samples - shape) for shape in landmarks], 0)
        assert returned["specificity"][m - 1] == pytest.approx(
            nearest.mean(), abs=5 * nearest.std() / 2000**0.5
        )


def test_pose_and_size_do_not_matter(heart):
    from scipy.spatial.transform import Rotation

    landmarks, faces = heart[0][::6], heart[1]
    expected = project_of(landmarks, faces).apply_filter(MODEL)["variance_share"]
    random = np.random.default_rng(2)
    moved = [
        random.uniform(0.3, 3) * r.apply(x) + random.normal(size=3) * 100
        for r, x in zip(Rotation.random(5, random), landmarks)
    ]
    assert project_of(moved, faces).apply_filter(MODEL)["variance_share"] == pytest.approx(
        expected, rel=1e-9
    )


def test_matrices_count(heart):
    landmarks, faces = heart[0][::6], heart[1]
    expected = project_of(landmarks, faces).apply_filter(MODEL, alignment="None")["eigenvalues"]
    ms = project_of(landmarks, faces)
    ms.set_current_mesh(2)
    ms.apply_filter(
        "compute_matrix_from_translation_rotation_scale", translationx=7, rotationz=30, freeze=False
    )
    assert not np.allclose(ms.apply_filter(MODEL, alignment="None")["eigenvalues"], expected)
    assert ms.apply_filter(MODEL, alignment="Rigid")["eigenvalues"] == pytest.approx(
        project_of(landmarks, faces).apply_filter(MODEL, alignment="Rigid")["eigenvalues"], rel=1e-9
    )


def test_area_weights_matter_a_little(heart):
    ms = project_of(heart[0][::6], heart[1])
    plain, weighted = (ms.apply_filter(MODEL, area_weights=w)["eigenvalues"] for w in (False, True))
    assert not np.allclose(plain, weighted, rtol=1e-6)
    assert weighted == pytest.approx(plain, rel=0.2)


def test_fewer_modes():
    ms = small_model_project()
    all_modes, two = ms.apply_filter(MODEL), ms.apply_filter(MODEL, modes=2)
    assert two["modes"] == 2 and len(two["scores"]) == 2 * 5
    for key in ("eigenvalues", "compactness", "variance_share", "generalisation"):
        assert two[key] == pytest.approx(all_modes[key][:2]), key
    assert ms.apply_filter(MODEL, modes=100)["modes"] == 4


def test_seeds():
    ms = small_model_project()
    draws = [ms.apply_filter(MODEL, seed=seed)["specificity"] for seed in (0, 0, 1)]
    assert np.array_equal(draws[0], draws[1]) and not np.array_equal(draws[0], draws[2])


def test_identical_shapes_have_no_modes():
    ms = small_model_project()
    v, f = layers(ms)[0].vertex_matrix(), layers(ms)[0].face_matrix()
    same = project_of([v, 2 * v[:, [1, 2, 0]] + 5, v], f)
    returned = same.apply_filter(MODEL)
    assert returned["modes"] == 0
    for key in ("eigenvalues", "compactness", "generalisation", "specificity", "scores"):
        assert np.size(returned[key]) == 0
    assert labels(same)[3:] == ["mean shape"]


# ---------------------------------------------------------------- layers


def test_layers_show_mean_and_modes():
    ms = small_model_project()
    shapes = np.array([m.vertex_matrix() for m in layers(ms)])
    returned = ms.apply_filter(MODEL, alignment="None", mode_layers=2, standard_deviations=2.5)
    assert labels(ms)[5:] == [
        "mean shape",
        "mode 1 -2.5 sd",
        "mode 1 +2.5 sd",
        "mode 2 -2.5 sd",
        "mode 2 +2.5 sd",
    ]
    mean, modes, eigenvalues, _ = pca(shapes)
    assert layer(ms, "mean shape").vertex_matrix() == pytest.approx(mean, abs=1e-9)
    faces = layers(ms)[0].face_matrix()
    for m in (1, 2):
        low, high = (layer(ms, f"mode {m} {sign}2.5 sd").vertex_matrix() for sign in "-+")
        assert (low + high) / 2 == pytest.approx(mean, abs=1e-9)
        assert np.abs(high - mean) == pytest.approx(
            np.abs(2.5 * np.sqrt(eigenvalues[m - 1]) * modes[m - 1]), abs=1e-9
        )
    for mesh in layers(ms)[5:]:
        assert np.array_equal(mesh.face_matrix(), faces)
    assert returned["modes"] == 4  # shown or not


def test_colours_are_displacements_along_the_normal():
    ms = small_model_project()
    ms.apply_filter(MODEL)
    mean = layer(ms, "mean shape")
    made = [m for m in ms if m.label().startswith("mode ")]
    displacements = []
    for mesh in made:
        d = ((mesh.vertex_matrix() - mean.vertex_matrix()) * pyvista_normals(mean)).sum(1)
        displacements.append(d)
        assert mesh.vertex_scalar_array() == pytest.approx(d, abs=0.02 * np.abs(d).max())
    range_ = max(np.abs(m.vertex_scalar_array()).max() for m in made)
    for mesh in made:
        colours, d = mesh.vertex_color_matrix()[:, :3], mesh.vertex_scalar_array()
        out, in_ = d > 0.3 * range_, d < -0.3 * range_
        assert (colours[out, 0] > colours[out, 2]).all() and (
            colours[in_, 0] < colours[in_, 2]
        ).all()
    brightest = [
        m.vertex_color_matrix()[np.abs(m.vertex_scalar_array()).argmin(), :3].min() for m in made
    ]
    assert min(brightest) > 0.8
    assert (
        mean.vertex_color_matrix()[:, :3] == 247 / 255
    ).all() and not mean.vertex_scalar_array().any()


def pyvista_normals(mesh):
    """Normals weighted by area."""
    v, f = mesh.vertex_matrix(), mesh.face_matrix()
    n = np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])
    sums = np.stack([np.bincount(f.ravel(), np.repeat(n[:, k], 3), len(v)) for k in range(3)], 1)
    return sums / np.linalg.norm(sums, axis=1, keepdims=True)


def test_a_second_run_replaces_what_the_first_made():
    ms = small_model_project()
    ms.apply_filter(MODEL, mode_layers=4)
    assert len(labels(ms)) == 5 + 9
    ms.set_mesh_visibility(layer(ms, "mode 3 -3 sd").id(), False)
    # From a file.
    user = add(
        ms, *[layers(ms)[0].vertex_matrix() + 1, layers(ms)[0].face_matrix()], "mode 9 -3 sd.ply"
    )
    ms.set_current_mesh(0)
    again = ms.apply_filter(MODEL, mode_layers=1, standard_deviations=2)
    assert labels(ms) == [f"shape {k:02d}" for k in range(5)] + [
        "mean shape",
        "mode 9 -3 sd.ply",
        "mode 1 -2 sd",
        "mode 1 +2 sd",
    ]
    assert (
        again["shapes"] == 5
        and ms.current_mesh_id() == 0
        and ms.mesh(user).label() == "mode 9 -3 sd.ply"
    )
    ms.apply_filter(MODEL, mode_layers=0)
    assert labels(ms)[5:] == ["mean shape", "mode 9 -3 sd.ply"]


def test_a_layer_that_goes_may_be_the_current_one():
    ms = small_model_project()
    ms.apply_filter(MODEL)
    ms.set_current_mesh(layer(ms, "mode 3 +3 sd").id())
    ms.apply_filter(MODEL, mode_layers=1)
    assert ms.current_mesh_id() in [m.id() for m in ms]


def test_the_model_is_not_made_of_itself(tmp_path):
    ms = small_model_project()
    first = ms.apply_filter(MODEL)
    assert np.array_equal(first["eigenvalues"], ms.apply_filter(MODEL)["eigenvalues"])
    again = pymeshlab.MeshSet()
    for mesh in layers(ms):  # nor when its layers come from files
        ms.set_current_mesh(mesh.id())
        ms.save_current_mesh(str(tmp_path / f"{mesh.label()}.ply"))
        again.load_new_mesh(str(tmp_path / f"{mesh.label()}.ply"))
    assert again.apply_filter(MODEL)["shapes"] == 5


def test_hidden_layers_do_not_count():
    ms = small_model_project()
    ms.set_mesh_visibility(1, False)
    assert ms.apply_filter(MODEL)["shapes"] == 4


def test_shapes_come_in_the_order_of_their_surfaces(tmp_path):
    """A surface remeshed later has its landmarks last in the list, but not last in time."""
    ms = mapped_cycle(4)
    ms.set_mesh_visibility(1, False)
    ms.apply_filter(REMESH, frequency=4)
    ms.set_mesh_visibility(1, True)
    ms.apply_filter(REMESH, frequency=4)
    assert [m.label()[15:17] for m in layers(ms)[4:]] == ["00", "02", "03", "01"]
    path = tmp_path / "scores.csv"
    found = ms.apply_filter(MODEL, export_file=str(path))["scores"].reshape(4, 3)
    with open(path, newline="") as file:
        assert [row[0] for row in csv.reader(file)][1:] == [
            f"phantom cavity {k:02d} landmarks" for k in range(4)
        ]
    in_time = mapped_cycle(4)
    in_time.apply_filter(REMESH, frequency=4)
    assert found == pytest.approx(in_time.apply_filter(MODEL)["scores"].reshape(4, 3), abs=1e-9)
    ms.set_mesh_visibility(0, False)  # also where the surfaces are hidden
    assert ms.apply_filter(MODEL)["scores"].reshape(4, 3) == pytest.approx(found, abs=1e-9)


def test_landmarks_stay_as_they_are():
    ms = small_model_project()
    before = [content(m) for m in ms]
    ms.apply_filter(MODEL)
    assert [content(m) for m in layers(ms)[:5]] == before


def test_the_log_has_figures_and_legend():
    log = log_of("""
ms.apply_filter(PHANTOM, phases=4, voxel_size=4)
for name in ROOT, PROPAGATE, REMESH, MODEL:
    ms.apply_filter(name)
""")
    assert re.search(r"4 shapes of 1002 landmarks, aligned in \d+ rounds: 3 modes", log)
    assert re.search(
        r"mode 1: standard deviation [\d.]+ per landmark, [\d.]+ % of the variance", log
    )
    assert re.search(r"Colours.*red ([\d.]+) outwards.*blue \1 inwards", log)


def model_log(shapes, faces, folder):
    """What the filter says of these landmark layers."""
    np.savez(folder / "shapes.npz", shapes=shapes, faces=faces)
    script = """
given = np.load("shapes.npz")
for k, points in enumerate(given["shapes"]):
    add(ms, points, given["faces"], f"shape {k:02d}")
ms.apply_filter(MODEL)
"""
    return log_of(script, folder)


def test_shapes_that_stand_out_are_named(tmp_path):
    rng = np.random.default_rng(1)
    project = small_model_project()
    faces = project.mesh(0).face_matrix()
    cycle = np.array([m.vertex_matrix() for m in project])
    shapes = cycle.mean(0) + np.einsum(
        "ki,inc->knc", 0.3 * rng.standard_normal((12, len(cycle))), cycle - cycle.mean(0)
    )
    assert "Warning" not in model_log(shapes, faces, tmp_path)
    shapes[4] *= 10
    shapes[7] = rng.permutation(shapes[7])
    log = model_log(shapes, faces, tmp_path)
    assert log.count("Warning") == 2
    assert re.search(r"Warning: shape 04: it is [\d.]+ times larger than most shapes", log)
    assert re.search(
        r"Warning: shape 07: it lies [\d.]+, in the mesh's unit, from the middle of the shapes", log
    )


def test_no_phase_of_a_heart_stands_out(heart, tmp_path):
    assert "Warning" not in model_log(*heart, tmp_path)


# ---------------------------------------------------------------- files, as others read them


@pytest.fixture(scope="module")
def exported(heart, tmp_path_factory):
    """export(ending): a model of every third heart written to a file: path, returned figures, the
    aligned shapes."""
    landmarks, faces = heart[0][::3], heart[1]
    folder = tmp_path_factory.mktemp("model")

    def export(ending):
        path = folder / ("heart" + ending)
        returned = project_of(landmarks, faces).apply_filter(MODEL, export_file=str(path))
        return path, returned, procrustes(landmarks)

    return export


def test_npz(exported, heart):
    path, returned, shapes = exported(".npz")
    with np.load(path) as file:
        model = dict(file)
    assert {k: v.shape for k, v in model.items()} == {
        "mean": (1002, 3),
        "modes": (9, 1002, 3),
        "eigenvalues": (9,),
        "scores": (10, 9),
        "faces": (2000, 3),
        "lid": (1002,),
    }
    assert not model["lid"].any()
    assert np.array_equal(model["eigenvalues"], returned["eigenvalues"])
    assert np.array_equal(model["scores"].ravel(), returned["scores"])
    assert np.array_equal(model["faces"], heart[1])
    rebuilt = model["mean"] + np.tensordot(model["scores"], model["modes"], 1)
    assert rebuilt == pytest.approx(shapes, abs=1e-6)
    assert np.tensordot(model["modes"], model["modes"], [[1, 2], [1, 2]]) == pytest.approx(
        np.eye(9), abs=1e-12
    )


def hdf5_json(path):
    """Values of the data sets and attributes by path, as the HDF Group lays HDF5/JSON out."""
    document = json.loads(path.read_text())
    found = {}

    def walk(group, at):
        for attribute in group["attributes"]:
            assert (
                attribute["type"]["class"] == "H5T_STRING"
                and attribute["shape"]["class"] == "H5S_SCALAR"
            )
            found[f"{at}@{attribute['name']}"] = attribute["value"]
        for link in group["links"]:
            assert link["class"] == "H5L_TYPE_HARD"
            there = document[link["collection"]][link["id"]]
            assert there["alias"] == [f"{at}/{link['title']}"]
            if link["collection"] == "groups":
                walk(there, f"{at}/{link['title']}")
            else:
                value = np.array(there["value"])
                assert list(value.shape) == there["shape"].get("dims", [])
                assert there["type"]["base"] in ("H5T_IEEE_F32LE", "H5T_STD_I32LE")
                found[f"{at}/{link['title']}"] = value

    walk(document["groups"][document["root"]], "")
    return found


def test_statismo_json(exported, heart):
    """The layout that scalismo's StatismoIO reads."""
    path, returned, shapes = exported(".json")
    model = hdf5_json(path)
    assert (model["/version/majorVersion"], model["/version/minorVersion"]) == (0, 9)
    assert model["/representer@name"] == "itkStandardMeshRepresenter"
    assert model["/representer@datasetType"] == "POLYGON_MESH"
    assert np.array_equal(model["/representer/cells"], heart[1].T)
    assert model["/representer/points"].shape == (3, 1002)
    mean, basis, variance = (
        model[f"/model/{name}"] for name in ("mean", "pcaBasis", "pcaVariance")
    )
    assert np.array_equal(mean.reshape(-1, 3).T, model["/representer/points"])
    assert basis.shape == (3006, 9) and basis.T @ basis == pytest.approx(np.eye(9), abs=1e-12)
    assert np.array_equal(variance, returned["eigenvalues"]) and model["/model/noiseVariance"] == [
        0
    ]
    for k in range(10):
        coefficients = model["/modelinfo/scores"][:, k]
        rebuilt = mean + basis @ (np.sqrt(variance) * coefficients)
        assert rebuilt.reshape(-1, 3) == pytest.approx(shapes[k], abs=1e-6)
        # and as scalismo finds the coefficients of a mesh
        assert basis.T @ (shapes[k].ravel() - mean) / np.sqrt(variance) == pytest.approx(
            coefficients, abs=1e-6
        )


def test_statismo_hdf5(exported):
    """By h5py: the layout, in the types that scalismo asks for, of what the JSON form holds."""
    import h5py

    path, returned, shapes = exported(".h5")
    reference = hdf5_json(exported(".json")[0])
    with h5py.File(path) as file:
        found = {}

        def collect(name, item):
            found.update({f"/{name}@{key}": value.decode() for key, value in item.attrs.items()})
            if isinstance(item, h5py.Dataset):
                assert item.dtype == (
                    "<i4" if name.startswith("version") or name.endswith("cells") else "<f4"
                )
                found[f"/{name}"] = item[()]

        file.visititems(collect)
    assert set(found) == set(reference)
    for name, value in reference.items():
        if isinstance(value, str):
            assert found[name] == value
        else:
            assert np.shape(found[name]) == value.shape and found[name] == pytest.approx(
                value, rel=1e-7, abs=1e-30
            ), name
    mean, basis, variance = (
        found[f"/model/{name}"].astype(float) for name in ("mean", "pcaBasis", "pcaVariance")
    )
    for k in range(10):
        rebuilt = (mean + basis @ (np.sqrt(variance) * found["/modelinfo/scores"][:, k])).reshape(
            -1, 3
        )
        # As far as 32 bits go.
        assert np.linalg.norm(rebuilt - shapes[k]) < 1e-6 * np.linalg.norm(shapes[k])


def test_hdf5_of_a_model_without_modes(tmp_path):
    import h5py

    ms = small_model_project()
    v, f = layers(ms)[0].vertex_matrix(), layers(ms)[0].face_matrix()
    project_of([v, v], f).apply_filter(MODEL, export_file=str(tmp_path / "model.h5"))
    with h5py.File(tmp_path / "model.h5") as file:
        assert file["model/pcaBasis"][()].shape == (486, 0) and file["model/pcaVariance"][
            ()
        ].shape == (0,)
        assert file["model/mean"][()].reshape(-1, 3) == pytest.approx(v, abs=1e-5)


def test_shapeworks_particles(exported):
    path, _, shapes = exported(".particles")
    assert np.loadtxt(path) == pytest.approx(shapes.mean(0), abs=1e-6)
    files = sorted(path.parent.glob("heart_*.particles"))
    assert [f.name for f in files] == [f"heart_{k:03d}.particles" for k in range(10)]
    assert np.array([np.loadtxt(f) for f in files]) == pytest.approx(shapes, abs=1e-6)


def test_ply(exported, measure, heart):
    path, returned, shapes = exported(".ply")
    vertex, faces = measure.read_ply(str(path))
    mean = measure.points(vertex)
    modes = np.array(
        [np.stack([vertex[f"mode_{m}_{axis}"] for axis in "xyz"], 1) for m in range(1, 10)]
    )
    rebuilt = mean + np.tensordot(returned["scores"].reshape(10, 9), modes, 1)
    assert rebuilt == pytest.approx(shapes, abs=1e-6)
    assert np.array_equal(faces, heart[1])
    header = path.read_bytes().split(b"end_header")[0].decode()
    eigenvalues = [
        float(line.split()[3])
        for line in header.splitlines()
        if line.startswith("comment eigenvalue ")
    ]
    assert np.array_equal(eigenvalues, returned["eigenvalues"])
    # Programs that know nothing of modes see the mean.
    seen = pyvista.read(path)
    assert np.asarray(seen.points) == pytest.approx(mean, abs=1e-4)
    ms = pymeshlab.MeshSet()
    ms.load_new_mesh(str(path))
    assert ms.current_mesh().vertex_matrix() == pytest.approx(mean, abs=1e-9)
    assert np.array_equal(ms.current_mesh().face_matrix(), heart[1])


def test_csv(exported):
    path, returned, _ = exported(".csv")
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["shape"] + [f"mode_{m}" for m in range(1, 10)]
    assert [row[0] for row in rows[1:]] == [f"shape {k:02d}" for k in range(10)]
    assert np.array_equal(
        np.array([row[1:] for row in rows[1:]], float).ravel(), returned["scores"]
    )


def test_exports_say_the_same_twice(exported):
    for ending in (".npz", ".h5", ".json", ".particles", ".ply", ".csv"):
        first = exported(ending)[0].read_bytes()
        assert exported(ending)[0].read_bytes() == first


@pytest.mark.parametrize("ending", [".npz", ".h5", ".json", ".particles", ".ply", ".csv"])
def test_fewer_modes_in_files(ending, tmp_path):
    ms = small_model_project()
    path = tmp_path / ("model" + ending)
    ms.apply_filter(MODEL, modes=2, export_file=str(path))
    if ending == ".npz":
        with np.load(path) as file:
            assert file["modes"].shape[0] == 2 and file["scores"].shape == (5, 2)
    elif ending == ".h5":
        import h5py

        with h5py.File(path) as file:
            assert file["model/pcaBasis"].shape[1] == 2 and file["modelinfo/scores"].shape == (2, 5)
    elif ending == ".json":
        assert hdf5_json(path)["/model/pcaBasis"].shape[1] == 2
    elif ending == ".csv":
        assert path.read_text().splitlines()[0] == "shape,mode_1,mode_2"
    elif ending == ".ply":
        assert b"mode_2_z" in path.read_bytes() and b"mode_3_x" not in path.read_bytes()
    else:
        assert len(list(tmp_path.iterdir())) == 6


# ---------------------------------------------------------------- errors


def test_no_landmarks():
    ms = mapped_cycle(2)
    with refused(ms, "No landmark layer is visible", "Remesh by icosphere"):
        ms.apply_filter(MODEL)


def test_one_shape_only():
    ms = small_model_project()
    for k in range(1, 5):
        ms.set_mesh_visibility(k, False)
    with refused(ms, "at least two shapes", '"shape 00"'):
        ms.apply_filter(MODEL)


def test_different_numbers_of_landmarks():
    ms = small_model_project()
    other = small_model_project(frequency=5)
    add(ms, layers(other)[0].vertex_matrix(), layers(other)[0].face_matrix(), "finer")
    with refused(ms, '"shape 00"', '"finer"', "162", "252", "do not correspond"):
        ms.apply_filter(MODEL)


def test_a_mirrored_layer():
    ms = small_model_project()
    ms.set_current_mesh(3)
    ms.apply_filter("compute_matrix_from_translation_rotation_scale", scalex=-1, freeze=False)
    returned = ms.apply_filter(MODEL)
    assert returned["shapes"] == 5
    remarks = json.loads(bytes(map(int, returned["warnings"])).decode())
    assert [
        r["text"] for r in remarks if r["message"] == "matrixMirrors" and "shape 03" in r["text"]
    ]
    faces = layers(ms)[0].face_matrix()
    assert (layer(ms, "mean shape").face_matrix() == faces).all()
    # Where most or all are mirrored, the model's faces are turned over.
    for k in range(5):
        if k != 3:
            ms.set_current_mesh(k)
            ms.apply_filter(
                "compute_matrix_from_translation_rotation_scale", scalex=-1, freeze=False
            )
    returned = ms.apply_filter(MODEL)
    assert "warnings" not in returned
    assert (layer(ms, "mean shape").face_matrix() == faces[:, [0, 2, 1]]).all()


def test_landmarks_that_stray_are_named():
    project = small_model_project(8)
    shapes = np.array([m.vertex_matrix() for m in project])

    def texts(shapes):
        ms = project_of(shapes, project.mesh(0).face_matrix())
        code = ms.apply_filter(MODEL).get("warnings", [])
        return json.loads(bytes(map(int, code)).decode() or "[]")

    assert texts(shapes) == []
    shapes[3, 17] += [60, 0, 0]
    shapes[5, [20, 140]] = shapes[5, [140, 20]]
    one, two = texts(shapes)
    assert (one["message"], one["layer"]) == ("landmarkStrays", "shape 03")
    assert "its landmark 17 lies 5" in one["text"] or "its landmark 17 lies 6" in one["text"]
    assert (two["message"], two["layer"]) == ("landmarksStray", "shape 05")
    assert "2 of its landmarks (20, 140)" in two["text"] or "(140, 20)" in two["text"]
    for k in (0, 1, 2, 6):
        shapes[k, 30 + 20 * k] += [0, 70 + 10 * k, 0]
    (all_of_them,) = texts(shapes)
    assert all_of_them["message"] == "shapesWithStrays" and len(all_of_them["layers"]) == 6
    assert "6 shapes of 8" in all_of_them["text"] and '(150 in "shape 06")' in all_of_them["text"]


@pytest.mark.parametrize("copies", [1, 4])
def test_shapes_that_are_there_twice(copies):
    project = small_model_project()
    shapes = [m.vertex_matrix() for m in project]
    shapes += [shape + 7 for shape in shapes[:copies]]
    code = project_of(shapes, project.mesh(0).face_matrix()).apply_filter(MODEL)["warnings"]
    (remark,) = json.loads(bytes(map(int, code)).decode())
    assert remark["layers"] == [f"shape {5 + k:02d}" for k in range(copies)]
    assert remark["message"] == ("repeatedShape" if copies == 1 else "repeatedShapes")
    assert '"shape 00"' in remark["text"]


def test_many_that_stand_out_are_one_warning():
    project = small_model_project()
    shapes = np.array([m.vertex_matrix() for m in project])
    rng = np.random.default_rng(5)
    ms = pymeshlab.MeshSet()
    for k in range(40):
        points = shapes[k % 5] * (1 + 0.01 * rng.standard_normal((1, 3)))
        if k >= 21:
            points = points / 10
        elif k % 4 == 1:
            points = rng.permutation(points)
        add(ms, points, project.mesh(0).face_matrix(), f"case {k:02d}")
    remarks = json.loads(bytes(map(int, ms.apply_filter(MODEL)["warnings"])).decode())
    assert sorted(r["message"] for r in remarks) == ["shapesStandOut", "sizesStandOut"]
    text = {r["message"]: r["text"] for r in remarks}
    sizes, away = text["sizesStandOut"], text["shapesStandOut"]
    assert "19 shapes of 40" in sizes and '"case 21"' in sizes and "9 more" in sizes
    assert "times smaller" in sizes and "cm among mm" in sizes
    assert "5 shapes of 40" in away and '"case 17"' in away


def test_nan():
    ms = small_model_project()
    v, f = layers(ms)[0].vertex_matrix(), layers(ms)[0].face_matrix()
    v[[17, 40]] = NAN
    add(ms, v, f, "broken")
    with refused(
        ms, '"broken"', "2 landmarks have coordinates that are not finite", "landmark 17", "hide"
    ):
        ms.apply_filter(MODEL)


@pytest.mark.parametrize("alignment", ["None", "Rigid", "Similarity"])
def test_landmarks_in_one_place(alignment):
    ms = small_model_project()
    v, f = layers(ms)[0].vertex_matrix(), layers(ms)[0].face_matrix()
    add(ms, v * 0 + v[5], f, "point")
    with refused(ms, '"point"', "all its 162 landmarks lie in one place", "Hide the layer"):
        ms.apply_filter(MODEL, alignment=alignment)


@pytest.mark.parametrize("name", ["mirrored landmarks", "mirrored"])
def test_a_mirror_image_takes_part(name):
    """The landmarks as points: which way the icosphere's faces look is no fault of theirs."""
    ms = small_model_project(phases=6)
    v, f = layers(ms)[0].vertex_matrix(), layers(ms)[0].face_matrix()
    v[:, 0] *= -1
    add(ms, v, f, name)
    assert ms.apply_filter(MODEL)["shapes"] == 7


def test_noise_gives_a_model():
    ms = small_model_project()
    f = layers(ms)[0].face_matrix()
    noise = np.random.default_rng(3).normal(size=(12, 162, 3)) * 30
    assert project_of(noise, f).apply_filter(MODEL)["modes"] == 11


@pytest.mark.parametrize(
    "parameters, words",
    [
        ({"modes": -1}, "modes must be 0 or more"),
        ({"standard_deviations": 0}, "above 0"),
        ({"standard_deviations": -3}, "above 0"),
        ({"standard_deviations": NAN}, "above 0"),
        ({"mode_layers": -1}, "modes shown"),
        ({"specificity_samples": 0}, "between 1 and 1000000"),
        ({"specificity_samples": 10**9}, "between 1 and 1000000"),
        ({"seed": -1}, "seed"),
    ],
)
def test_parameters_out_of_range(parameters, words):
    ms = small_model_project()
    with refused(ms, words):
        ms.apply_filter(MODEL, **parameters)


def test_files_that_cannot_be_written(tmp_path):
    ms = small_model_project()
    (tmp_path / "folder.npz").mkdir()
    for name, words in [
        ("model", ["no ending", ".npz, .h5, .json"]),
        ("model.xyz", ['".xyz" is no format']),
        ("missing/model.npz", ["there is no folder", "missing"]),
        ("folder.npz", ["it is a folder"]),
    ]:
        with refused(ms, "cannot be written", name, *words):
            ms.apply_filter(MODEL, export_file=str(tmp_path / name))
    assert [p.name for p in tmp_path.iterdir()] == ["folder.npz"]


@pytest.mark.parametrize("ending", [".npz", ".particles"])
def test_a_disk_that_is_full(ending, tmp_path):
    """The old file survives, no part of the new one is left, and the project is as it was."""
    ms = small_model_project()
    path = tmp_path / ("model" + ending)
    path.write_text("old")
    part = tmp_path / ("model" + ending + ".part")
    os.symlink("/dev/full", part)
    if ending == ".particles":
        os.rename(part, tmp_path / "model_002.particles.part")
    with refused(ms, "cannot be written", "No space left on device"):
        ms.apply_filter(MODEL, export_file=str(path))
    assert path.read_text() == "old"
    assert not list(tmp_path.glob("*.part"))


def test_a_folder_without_permission(tmp_path):
    if os.geteuid() == 0:
        pytest.skip("root may write everywhere")
    ms = small_model_project()
    tmp_path.chmod(0o500)
    with refused(ms, "cannot be written", "Permission denied"):
        ms.apply_filter(MODEL, export_file=str(tmp_path / "model.npz"))


def test_other_names_for_files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ms = small_model_project()
    for name in ("relative.npz", "Größe 1.NPZ", "with space.v2.npz"):
        ms.apply_filter(MODEL, export_file=name)
        with np.load(tmp_path / name) as file:
            assert file["scores"].shape == (5, 4)
    before = snapshot(ms)
    ms.apply_filter(MODEL)
    assert snapshot(ms) == before and len(list(tmp_path.iterdir())) == 3


def sampled_project(phases=5):
    """Surfaces and their landmark layers."""
    ms = mapped_cycle(phases)
    ms.apply_filter(REMESH, frequency=6)
    return ms


def test_measures_between_surfaces_are_returned_where_they_are_asked_for():
    ms = sampled_project()
    returned = ms.apply_filter(MODEL, surface_measures=True)
    for name in ("generalisation", "specificity"):
        assert len(returned[f"surface_{name}"]) == returned["modes"] == 4
        assert (returned[f"surface_{name}_error"] > 0).all()
        # Closest points are never farther than those that correspond.
        assert (returned[f"surface_{name}"] < returned[name] + returned["off_surface"].max()).all()
    assert len(returned["off_surface"]) == len(returned["folded_faces"]) == 5
    assert (returned["off_surface"] > 0).all() and returned["off_surface"].max() < 1.5
    assert not returned["folded_faces"].any()
    assert not {"off_surface", "surface_generalisation"} & set(ms.apply_filter(MODEL))


def test_distances_from_the_surface_are_those_of_remeshing():
    """Of the other direction alone, and at vertices."""
    ms = mapped_cycle(5)
    remeshed = ms.apply_filter(REMESH, frequency=6)
    model = ms.apply_filter(MODEL, surface_measures=True, alignment="None")
    assert np.allclose(model["off_surface"], remeshed["surface_distance_mean"], rtol=0.5)


def test_measures_between_surfaces_need_the_surfaces():
    ms = sampled_project()
    ms.set_current_mesh(1)
    ms.delete_current_mesh()
    with refused(ms, "The surface that", "is not in the project"):
        ms.apply_filter(MODEL, surface_measures=True)
    ms.apply_filter(MODEL)


def test_measures_between_surfaces_leave_lids_to_nobody():
    ms = sampled_project()
    whole = ms.apply_filter(MODEL, surface_measures=True)
    for mesh in ms:
        top = mesh.vertex_matrix()[:, 2]
        mesh.add_vertex_custom_scalar_attribute((top > np.quantile(top, 0.8)).astype(float), "lid")
    returned = ms.apply_filter(MODEL, surface_measures=True)
    assert returned["lid"].any()
    # Had the surfaces kept what the model leaves out, this would be some millimetres.
    assert returned["off_surface"].max() < 2 * whole["off_surface"].max()


def test_measures_between_surfaces_refuse_landmarks_of_another_place():
    ms = sampled_project()
    ms.set_current_mesh(1)
    ms.apply_filter("compute_matrix_from_translation", axisx=30.0, freeze=False)
    with refused(ms, "off its surface", "moved or replaced since"):
        ms.apply_filter(MODEL, surface_measures=True)
