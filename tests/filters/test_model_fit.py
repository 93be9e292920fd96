# SPDX-License-Identifier: GPL-3.0-only
"""Fit shape model: the layer, the map and the figures, in every case that a user brings."""

import numpy as np
import pymeshlab
import pytest
from documents import (
    FIT,
    MODEL,
    PROPAGATE,
    REMESH,
    add,
    has_attribute,
    labels,
    landmark_layers,
    layer,
    mapped_cycle,
    positions,
    snapshot,
)
from environment import PROJECT

PARAMETERS = {
    "model_file": "",
    "target_layer": 0,
    "pose": 0,
    "alignment": 0,
    "modes": 0,
    "local_deviation": True,
    "anchor_file": "",
    "anchor_sd": 0.0,
    "export_file": "",
    "threads": 0,
}
MAP = {
    "flipped_faces",
    "area_ratio_sd",
    "area_log_mean",
    "angle_error_mean",
    "residual_mean",
    "residual_p95",
    "repaired_faces",
}
RETURNED = MAP | {
    "calibration",
    "scores",
    "score_sd",
    "pose",
    "landmark_sd",
    "covariance",
    "surface_distance",
    "noise",
    "deviation",
    "percentile",
    "local_deviation",
    "unseen",
    "unexplained",
    "starts",
    "closed",
    "seconds",
}


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """A model of five phases, and the sixth with the landmarks that it has."""
    ms = mapped_cycle(6)
    ms.apply_filter(REMESH, frequency=6)
    left_out = landmark_layers(ms)[2]
    truth = left_out.vertex_matrix()
    source = ms.mesh(2)
    surface = source.vertex_matrix(), source.face_matrix()
    ms.set_current_mesh(left_out.id())
    ms.set_current_mesh_visibility(False)
    file = tmp_path_factory.mktemp("model") / "model.npz"
    ms.apply_filter(MODEL, alignment="None", export_file=str(file))
    return str(file), surface, truth


def project(surface):
    ms = pymeshlab.MeshSet()
    add(ms, *surface, "patient")
    return ms


def error(mesh, truth):
    return np.linalg.norm(mesh.vertex_matrix() - truth, axis=1).mean()


def test_parameters_and_their_defaults(built):
    ms = project(built[1])
    assert ms.filter_parameter_values(FIT) == PARAMETERS


def test_what_it_returns_is_documented():
    text = (PROJECT / f"filter_sphere_propagation/help/{FIT}.html").read_text()
    for key in RETURNED:
        assert f"<b>{key}</b>" in text, key


def test_a_new_surface_gets_the_shape_and_a_map(built):
    file, surface, truth = built
    ms = project(surface)
    found = ms.apply_filter(FIT, model_file=file)
    assert set(found) - {"warnings"} == RETURNED
    assert labels(ms) == ["patient", "patient fit"]
    fit = layer(ms, "patient fit")
    assert error(fit, truth) < 1.0
    assert np.allclose(fit.vertex_scalar_array(), found["landmark_sd"], rtol=1e-6)
    assert found["flipped_faces"] == 0 and found["closed"]
    covariance = found["covariance"].reshape(-1, 3, 3)
    assert np.allclose(np.sqrt(np.trace(covariance, axis1=1, axis2=2) / 3), found["landmark_sd"])
    pose = found["pose"].reshape(4, 4)
    assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-9)
    # Its own landmarks lie on it, where the truth has them.
    ms.apply_filter(REMESH, frequency=6)
    assert error(layer(ms, "patient landmarks"), truth) < 1.0
    # Again: in the place of the first one.
    ms.set_current_mesh(0)
    ms.apply_filter(FIT, model_file=file, target_layer=0)
    assert labels(ms) == ["patient", "patient fit", "patient landmarks"]


def test_a_fit_is_no_landmark_layer(built):
    file, surface, _ = built
    ms = project(surface)
    ms.apply_filter(FIT, model_file=file)
    with pytest.raises(pymeshlab.PyMeshLabException, match="landmark"):
        ms.apply_filter(MODEL)


def test_the_pose_is_found_from_anywhere(built):
    """The phantom is nearly a body of revolution: its apex tells."""
    file, (v, f), truth = built
    angle = np.radians(130)
    turn = np.array(
        [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    )
    ms = project((v @ turn.T + [100, 0, -50], f))
    found = ms.apply_filter(FIT, model_file=file)
    assert found["starts"] > 1
    apex = truth[:, 2].argmin()
    fit = layer(ms, "patient fit").vertex_matrix()
    assert np.linalg.norm(fit[apex] - (turn @ truth[apex] + [100, 0, -50])) < 4
    assert found["surface_distance"] < 0.5


def test_the_layers_matrix_counts(built):
    file, (v, f), truth = built
    ms = project((v, f))
    ms.apply_filter(
        "compute_matrix_from_translation", axisx=5.0, axisy=0.0, axisz=2.0, freeze=False
    )
    ms.apply_filter(FIT, model_file=file, pose="As it lies")
    assert error(layer(ms, "patient fit"), truth + [5, 0, 2]) < 1.5


def test_an_open_surface_is_completed(built):
    file, (v, f), truth = built
    top = v[:, 2].max() - 0.3 * np.ptp(v[:, 2])
    ms = project((v, f[(v[f][:, :, 2] < top).all(1)]))
    found = ms.apply_filter(FIT, model_file=file, pose="As it lies")
    assert not found["closed"] and not MAP & set(found)
    assert found["unseen"] > 0.1
    assert not has_attribute(ms.mesh(0))
    assert error(layer(ms, "patient fit"), truth) < 2


def test_anchors_are_named_by_their_landmarks(built, tmp_path):
    file, surface, truth = built
    anchors = tmp_path / "anchors.csv"
    rows = [f"{j},{x},{y},{z}" for j, (x, y, z) in enumerate(truth) if j % 90 == 0]
    anchors.write_text("\n".join(rows))
    ms = project(surface)
    found = ms.apply_filter(
        FIT, model_file=file, pose="Anchors", anchor_file=str(anchors), anchor_sd=0.05
    )
    assert found["starts"] == 1
    fit = layer(ms, "patient fit").vertex_matrix()
    assert np.linalg.norm((fit - truth)[::90], axis=1).max() < 0.5
    anchors.write_text("apex,0,0,0\nbase,0,0,1\nleft,0,1,0")
    refuses(ms, "apex.*number from 0 to", model_file=file, anchor_file=str(anchors))
    anchors.write_text("1,0,0,0\n2,0,0,1")
    refuses(ms, "three anchors", model_file=file, pose="Anchors", anchor_file=str(anchors))


def test_the_export_holds_all_of_it(built, tmp_path):
    file, surface, _ = built
    ms = project(surface)
    found = ms.apply_filter(FIT, model_file=file, export_file=str(tmp_path / "fit.npz"))
    with np.load(tmp_path / "fit.npz") as written:
        assert np.array_equal(written["sd"], found["landmark_sd"])
        assert np.array_equal(written["covariance"].ravel(), found["covariance"])
        assert np.array_equal(written["scores"], found["scores"])
        assert np.array_equal(written["pose"].ravel(), found["pose"])
        assert written["noise"] == found["noise"]
        assert np.allclose(written["landmarks"], layer(ms, "patient fit").vertex_matrix())


def test_it_is_the_same_with_any_number_of_threads(built):
    file, surface, _ = built
    made = []
    for threads in (1, 3):
        ms = project(surface)
        found = ms.apply_filter(FIT, model_file=file, threads=threads)
        made.append((found["scores"], found["covariance"], positions(ms.mesh(0))))
    assert all(np.array_equal(a, b) for a, b in zip(*made))


def test_another_organ_is_named(built):
    """A sphere, twice as large: whatever is found, something is said."""
    file, (v, f), _ = built
    sphere = pymeshlab.MeshSet()
    sphere.create_sphere(radius=60.0, subdiv=4)
    ms = project((sphere.mesh(0).vertex_matrix(), sphere.mesh(0).face_matrix()))
    said = bytes(ms.apply_filter(FIT, model_file=file)["warnings"].astype(np.uint8)).decode()
    assert '"patient"' in said


def said(returned):
    return bytes(returned["warnings"].astype(np.uint8)).decode() if "warnings" in returned else ""


def test_a_good_fit_is_not_warned_of_and_others_are(built, tmp_path):
    file, (v, f), _ = built
    assert not said(project((v, f)).apply_filter(FIT, model_file=file))
    # A model without size takes centimetres for small shapes: that is said.
    ms = mapped_cycle(6)
    ms.apply_filter(REMESH, frequency=5)
    similar = str(tmp_path / "similar.npz")
    ms.apply_filter(MODEL, alignment="Similarity", export_file=similar)
    assert "times smaller" in said(project((v / 10, f)).apply_filter(FIT, model_file=similar))
    # A shape that the model cannot show.
    flat = project((v * [1.6, 0.6, 1], f))
    assert "let expect" in said(flat.apply_filter(FIT, model_file=file, local_deviation=False))


def refuses(ms, words, **parameters):
    before = snapshot(ms)
    with pytest.raises(pymeshlab.PyMeshLabException, match=words):
        ms.apply_filter(FIT, **parameters)
    assert snapshot(ms) == before


def test_it_refuses_in_words(built, tmp_path):
    file, surface, _ = built
    ms = project(surface)
    refuses(ms, "No model is chosen")
    refuses(ms, "cannot be read", model_file=str(tmp_path / "none.npz"))
    (tmp_path / "text.npz").write_text("a model")
    refuses(ms, "no archive", model_file=str(tmp_path / "text.npz"))
    with np.load(file) as model:
        arrays = dict(model)
    np.savez_compressed(tmp_path / "packed.npz", **arrays)
    refuses(ms, "compressed", model_file=str(tmp_path / "packed.npz"))
    for parameters in (
        {"modes": -1},
        {"threads": -1},
        {"anchor_sd": -1.0},
        {"export_file": str(tmp_path / "fit.txt")},
        {"export_file": str(tmp_path / "no" / "fit.npz")},
    ):
        refuses(ms, "", model_file=file, **parameters)
    points = pymeshlab.MeshSet()
    add(points, surface[0], np.zeros((0, 3)), "points")
    refuses(points, "points.*no faces|no faces.*points", model_file=file)


def test_a_model_without_scores_is_fitted_with_a_remark(built, tmp_path):
    file, surface, truth = built
    with np.load(file) as model:
        arrays = {key: model[key] for key in ("mean", "modes", "eigenvalues", "faces")}
    np.savez(tmp_path / "bare.npz", **arrays)
    ms = project(surface)
    found = ms.apply_filter(FIT, model_file=str(tmp_path / "bare.npz"))
    assert np.isnan(found["percentile"]) and found["local_deviation"] > 0
    assert error(layer(ms, "patient fit"), truth) < 1.5


def test_size_is_sought_where_the_model_has_none(built, tmp_path):
    """Built by Similarity, of a sequence whose sizes differ."""
    ms = mapped_cycle(6)
    ms.apply_filter(PROPAGATE)
    ms.apply_filter(REMESH, frequency=5)
    file = str(tmp_path / "similar.npz")
    ms.apply_filter(MODEL, alignment="Similarity", export_file=file)
    v, f = built[1]
    one = project((1.4 * v, f))
    pose = one.apply_filter(FIT, model_file=file)["pose"].reshape(4, 4)
    assert np.cbrt(np.linalg.det(pose[:3, :3])) > 1.1
    two = project((1.4 * v, f))
    found = two.apply_filter(FIT, model_file=file, alignment="Rigid")
    assert np.linalg.det(found["pose"].reshape(4, 4)[:3, :3]) == pytest.approx(1)
    assert "holds the fit to the mean's" in said(found)


def test_a_half_that_is_held_to_another_size_is_named(built, tmp_path):
    """It lies near the model wherever that is, so its distance says nothing."""
    ms = mapped_cycle(6)
    ms.apply_filter(REMESH, frequency=5)
    file = str(tmp_path / "similar.npz")
    ms.apply_filter(MODEL, alignment="Similarity", export_file=file)
    v, f = built[1]
    upper = f[(v[f][:, :, 2] > np.median(v[:, 2])).all(1)]
    mean = np.linalg.norm(np.load(file)["mean"] - np.load(file)["mean"].mean(0), axis=1).mean()
    size = mean / np.linalg.norm(v - v.mean(0), axis=1).mean()
    for scale, named in ((1.3 * size, True), (size, False)):
        ms = project((scale * v, upper))
        found = ms.apply_filter(FIT, model_file=file, alignment="Rigid")
        assert ("holds the fit to the mean's" in said(found)) == named
