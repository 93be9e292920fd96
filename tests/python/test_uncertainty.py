# SPDX-License-Identifier: GPL-3.0-only
"""How well landmarks are known, as functions return it and files have it."""

import csv

import numpy as np
import pytest
import sphere_propagation as sp
from sphere_propagation import command, files


@pytest.fixture(scope="module")
def surfaces():
    return sp.make_phantom(phases=3, voxel_size=4.0)


def test_propagation_returns_what_was_asked_for(surfaces):
    root = sp.parameterise_root(surfaces[0])
    plain = sp.propagate(surfaces, root)
    assert plain.uncertainties is None and plain.root_error is None
    asked = sp.propagate(surfaces, root, uncertainty_quality=True, root_error_quality=True)
    assert asked.root_error is None and asked.root_error_sd is None  # three phases do not tell
    for surface, known, mean in zip(
        surfaces, asked.uncertainties, asked.figures["uncertainty_mean"]
    ):
        assert known.shape == (len(surface.vertices),)
        assert known.mean() == pytest.approx(mean)
    assert not asked.uncertainties[0].any() and asked.uncertainties[1].min() > 0
    for one, other in zip(plain.maps, asked.maps):
        assert (one.positions == other.positions).all()


def test_of_twelve_phases_the_roots_error_is_known():
    surfaces = sp.make_phantom(phases=12, voxel_size=4.0)
    root = sp.parameterise_root(surfaces[0])
    found = sp.propagate(
        surfaces, root, order="Cyclic time", residual_quality=True, root_error_quality=True
    )
    assert np.sqrt((found.root_error**2).mean()) == pytest.approx(found.root_error_sd, rel=1e-6)
    assert not found.residuals[0].any() and found.residuals[1].any()


def test_landmarks_have_that_of_the_vertices_beside_them(surfaces):
    result = sp.correspond(surfaces, root=0, frequency=4, uncertainty=True)
    assert result.uncertainty.shape == result.landmarks.shape[:2]
    maps = sp.propagate(surfaces, result.root_map, uncertainty_quality=True)
    for t, known in enumerate(maps.uncertainties):
        away = np.linalg.norm(
            surfaces[t].vertices[None] - result.landmarks[t][:, None], axis=2
        ).argmin(1)
        assert np.abs(known[away] - result.uncertainty[t]).max() <= 0.1 * known.max()
    assert sp.correspond(surfaces, root=0, frequency=4).uncertainty is None


def test_files_of_landmarks_have_it(surfaces, tmp_path):
    for i, surface in enumerate(surfaces):
        files.write_ply(tmp_path / f"phase_{i}.ply", surface.vertices, surface.faces)
    options = ["--uncertainty", "--frequency", "4", "--no-pictures"]
    assert command.main(["run", str(tmp_path), "-o", str(tmp_path / "results"), *options]) == 0
    (archive,) = (tmp_path / "results").glob("*/landmarks.npz")
    with np.load(archive) as file:
        known, landmarks = file["uncertainty"], file["landmarks"]
    assert known.shape == landmarks.shape[:2] and known.max() > 0
    with open(archive.with_suffix(".csv"), encoding="utf-8") as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["shape", "landmark", "x", "y", "z", "uncertainty"]
    assert [float(row[-1]) for row in rows[1:]] == pytest.approx(known.ravel().tolist(), rel=1e-6)
