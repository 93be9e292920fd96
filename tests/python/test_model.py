# SPDX-License-Identifier: GPL-3.0-only
"""The shape model as a function on arrays: the filter's numbers, and what they mean."""

import csv

import numpy as np
import pymeshlab
import pytest
import sphere_propagation as sp
from sphere_propagation import filters, model_pictures


@pytest.fixture(scope="module")
def model(cycle):
    return sp.shape_model(cycle.landmarks, cycle.landmark_faces)


def test_shapes_of_the_arrays(model, cycle):
    assert model.mean.shape == (162, 3) and model.modes.shape == (5, 162, 3)
    assert model.eigenvalues.shape == (5,) and model.scores.shape == (6, 5)
    assert np.array_equal(model.faces, cycle.landmark_faces) and model.names == [
        f"shape {k}" for k in range(6)
    ]
    assert all(values.shape == (5,) for values in model.figures.values())
    assert model.compactness[-1] == pytest.approx(model.total_variance)
    assert model.figures["variance_share"] == pytest.approx(
        model.compactness / model.total_variance
    )
    assert (np.diff(model.generalisation[:-1]) < 0).any() and (model.specificity > 0).all()


def test_the_model_is_a_principal_component_analysis(cycle):
    model = sp.shape_model(cycle.landmarks, cycle.landmark_faces, alignment="None")
    data = cycle.landmarks.reshape(6, -1)
    _, s, vt = np.linalg.svd(data - data.mean(0), full_matrices=False)
    assert model.mean == pytest.approx(data.mean(0).reshape(-1, 3), abs=1e-12)
    assert model.eigenvalues == pytest.approx(s[:5] ** 2 / 5, rel=1e-9)
    flat = model.modes.reshape(5, -1)
    assert np.abs((flat * vt[:5]).sum(1)) == pytest.approx(
        1, abs=1e-9
    ) and flat @ flat.T == pytest.approx(np.eye(5), abs=1e-9)
    assert model.mean + np.tensordot(model.scores, model.modes, 1) == pytest.approx(
        cycle.landmarks, abs=1e-9
    )


def test_shapes_of_the_model(model):
    assert model.shape([]) == pytest.approx(model.mean)
    rebuilt = np.array([model.shape(scores) for scores in model.scores])
    assert rebuilt == pytest.approx(
        model.mean + np.tensordot(model.scores, model.modes, 1), abs=1e-12
    )
    assert model.along(1, -3) == pytest.approx(
        model.shape([0, -3 * model.eigenvalues[1] ** 0.5]), abs=1e-12
    )
    with pytest.raises(sp.InputError, match="5 modes"):
        model.shape(np.zeros(6))
    with pytest.raises(sp.InputError, match="no mode 5"):
        model.along(5, 1)


def test_it_is_the_filter(cycle, model, tmp_path):
    """The same bits as a project in which the filter runs on the layers, and as the file that it
    writes."""
    meshes = pymeshlab.MeshSet()
    for points in cycle.landmarks:
        meshes.add_mesh(pymeshlab.Mesh(points, cycle.landmark_faces))
    returned = meshes.apply_filter(filters.MODEL)
    for name in ("generalisation", "specificity", "compactness"):
        assert np.array_equal(returned[name], getattr(model, name))
    again = sp.shape_model(
        cycle.landmarks, cycle.landmark_faces, export_file=tmp_path / "model.npz"
    )
    with np.load(tmp_path / "model.npz") as file:
        for name in ("mean", "modes", "eigenvalues", "scores", "faces"):
            assert np.array_equal(file[name], getattr(again, name)) and np.array_equal(
                file[name], getattr(model, name)
            ), name


def test_pictures_have_the_colours_of_the_layers(cycle, model):
    meshes = pymeshlab.MeshSet()
    for points in cycle.landmarks:
        meshes.add_mesh(pymeshlab.Mesh(points, cycle.landmark_faces))
    meshes.apply_filter(filters.MODEL)
    made = {mesh.label(): mesh for mesh in meshes if mesh.label().startswith("mode ")}
    reach = max(np.abs(mesh.vertex_scalar_array()).max() for mesh in made.values())
    for m in range(3):
        for sign, deviations in (("-", -3), ("+", 3)):
            mesh = made[f"mode {m + 1} {sign}3 sd"]
            values = model_pictures.displacements(model, model.along(m, deviations))
            assert values == pytest.approx(mesh.vertex_scalar_array(), abs=1e-9)
            assert model_pictures.displacement_colors(values, reach) == pytest.approx(
                mesh.vertex_color_matrix()[:, :3], abs=0.003
            )


def test_modes_can_be_left_out(cycle, model):
    two = sp.shape_model(cycle.landmarks, cycle.landmark_faces, modes=2)
    assert (
        two.modes == pytest.approx(model.modes[:2]) and two.total_variance == model.total_variance
    )
    assert two.figures["variance_share"][-1] < 1


def test_identical_shapes(cycle):
    model = sp.shape_model(cycle.landmarks[[0, 0, 0]], cycle.landmark_faces)
    assert (
        model.modes.shape == (0, 162, 3)
        and model.scores.shape == (3, 0)
        and model.total_variance == 0
    )
    assert model.mean == pytest.approx(cycle.landmarks[0], abs=1e-9)


def test_names_are_in_errors_and_files(cycle, tmp_path):
    names = [f"patient {k}" for k in range(6)]
    sp.shape_model(
        cycle.landmarks, cycle.landmark_faces, names, export_file=tmp_path / "scores.csv"
    )
    with open(tmp_path / "scores.csv", newline="") as file:
        assert [row[0] for row in csv.reader(file)][1:] == names
    broken = cycle.landmarks.copy()
    broken[2, 7, 1] = np.nan
    with pytest.raises(sp.FilterError, match="patient 2"):
        sp.shape_model(broken, cycle.landmark_faces, names)
    with pytest.raises(sp.FilterError, match="taken for landmarks"):
        sp.shape_model(cycle.landmarks, cycle.landmark_faces, ["mean shape", *names[1:]])


def test_input_that_cannot_be_meant(cycle, tmp_path):
    points, faces = cycle.landmarks, cycle.landmark_faces
    for words, call in {
        "(shapes, landmarks, 3)": lambda: sp.shape_model(points[0], faces),
        "not those that remesh gives": lambda: sp.shape_model(points[:, :100], faces),
        "as many names, not 2": lambda: sp.shape_model(points, faces, ["a", "b"]),
    }.items():
        with pytest.raises(sp.InputError) as refused:
            call()
        assert words in str(refused.value)
    for words, call in {
        "at least two shapes": lambda: sp.shape_model(points[:1], faces),
        "no format that is known": lambda: sp.shape_model(
            points, faces, export_file=tmp_path / "model.xyz"
        ),
    }.items():
        with pytest.raises(sp.FilterError, match=words):
            call()


def changed(cycle, k, change):
    shapes = np.array(cycle.landmarks)
    shapes[k] = change(shapes[k])
    return shapes


def test_a_mirror_image_takes_part_and_is_named(cycle):
    shapes = changed(cycle, 4, lambda shape: shape * [-1, 1, 1])
    with pytest.warns(sp.SpherePropagationWarning, match="shape 4.* mirror image"):
        assert len(sp.shape_model(shapes, cycle.landmark_faces).scores) == 6


def nan_at_5(shape):
    shape[[5, 8], 1] = np.nan
    return shape


@pytest.mark.parametrize(
    "change, words",
    [
        (nan_at_5, ['"shape 4"', "2 landmarks", "landmark 5", "Leave the shape out"]),
        (lambda shape: shape * 0 + 7, ['"shape 4"', "162 landmarks", "Leave the shape out"]),
    ],
)
def test_landmarks_that_are_none(cycle, change, words):
    with pytest.raises(sp.FilterError) as caught:
        sp.shape_model(changed(cycle, 4, change), cycle.landmark_faces)
    assert all(word in str(caught.value) for word in words), str(caught.value)
    assert "prepare" not in str(caught.value) and "::-1" not in str(caught.value)
