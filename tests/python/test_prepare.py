# SPDX-License-Identifier: GPL-3.0-only
"""Prepare surface on arrays."""

import numpy as np
import pytest
import sphere_propagation as sp
from sphere_propagation.surface import as_surface, as_surfaces


@pytest.fixture(scope="module")
def heart():
    return sp.make_phantom(phases=1, voxel_size=4)[0]


def opened(surface):
    """Without its upper quarter, as soup: every face has vertices of its own."""
    corners = surface.vertices[surface.faces]
    height = corners[:, :, 2].max(1)
    corners = corners[height < np.quantile(height, 0.75)]
    return sp.Surface(
        corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3), "open", "RAS"
    )


def test_an_open_ventricle_gets_a_map(heart):
    prepared = sp.prepare(opened(heart))
    surface, figures = prepared
    assert (surface.name, surface.space) == ("open", "RAS")
    assert figures["closed"] == 1 and figures["close_openings"] == 1
    assert figures["weld"] == len(opened(heart).vertices) - (prepared.lid == 0).sum()
    assert figures["lid"] == (prepared.lid > 0).sum() > 10
    assert len(figures["opening_edges"]) == len(figures["opening_perimeter"]) == 1
    assert prepared.lid_faces.sum() == len(surface.faces) - len(opened(heart).faces)
    assert sp.parameterise_root(surface).figures["flipped_faces"] == 0


def test_what_is_closed_comes_back(heart):
    prepared = sp.prepare(heart)
    assert prepared.surface is heart
    assert not prepared.lid.any() and not prepared.lid_faces.any()
    assert prepared.figures["closed"] == 1


def test_what_is_left_is_a_warning(heart):
    with pytest.warns(
        sp.SpherePropagationWarning, match="not a closed surface yet: it is not closed"
    ):
        prepared = sp.prepare(opened(heart), close_openings=False)
    assert prepared.figures["closed"] == 0 and prepared.surface.volume > 0


def test_nothing_to_prepare():
    with pytest.raises(sp.FilterError, match="no faces"):
        sp.prepare((np.zeros((4, 3)), np.zeros((0, 3), int)))


def test_what_was_prepared_is_a_surface(heart):
    """Everywhere, and with its name."""
    prepared = sp.prepare(opened(heart))
    assert as_surface(prepared) is prepared.surface
    assert sp.prepare(prepared).surface is prepared.surface
    sphere_map = sp.parameterise_root(prepared)
    assert sp.evaluate([prepared], [sphere_map])["valid"].all()
    result = sp.correspond([prepared, heart], frequency=2)
    assert [surface.name for surface in result.surfaces] == ["open", heart.name]
    with pytest.raises(sp.InputError, match=r"one of them is \[surface\]"):
        sp.correspond(prepared)


def test_lids_are_known_to_the_end(tmp_path):
    hearts = [sp.prepare(opened(heart)) for heart in sp.make_phantom(phases=3, voxel_size=4)]
    assert all((heart.surface.lid == heart.lid).all() for heart in hearts)
    result = sp.correspond(hearts, frequency=4)
    assert result.lid.shape == (162,) and result.lid.dtype == bool and 5 < result.lid.sum() < 80
    landmarks = sp.remesh(result.surfaces, result.maps, frequency=4)
    assert (result.lid == (landmarks.lid.sum(0) >= 2)).all()
    file = tmp_path / "model.npz"
    model = sp.shape_model(
        result.landmarks, result.landmark_faces, lid=result.lid, export_file=str(file)
    )
    kept = ~result.lid
    assert (model.lid == result.lid).all() and len(model.mean) == kept.sum()
    where = np.flatnonzero(kept)[model.faces]
    rows = set(map(tuple, result.landmark_faces.tolist()))
    assert len(where) == kept[result.landmark_faces].all(1).sum()
    assert all(tuple(row) in rows for row in where.tolist())
    with np.load(file) as saved:
        assert (saved["lid"] == result.lid).all() and (saved["faces"] == model.faces).all()
    whole = sp.shape_model(result.landmarks, result.landmark_faces)
    assert len(whole.mean) == 162 and not whole.lid.any()
    never = sp.shape_model(
        result.landmarks, result.landmark_faces, lid=landmarks.lid, leave_out_lids="Never"
    )
    assert (never.eigenvalues == whole.eigenvalues).all()
    with pytest.raises(sp.InputError, match=r"lid must be of shape \(3, 162\) or \(162,\)"):
        sp.shape_model(result.landmarks, result.landmark_faces, lid=result.lid[1:])
    with pytest.raises(sp.InputError, match="lid must be 3 numbers"):
        sp.Surface(np.eye(3), [[0, 1, 2]], lid=[1])


def test_nameless_ones_are_numbered(heart):
    arrays = heart.vertices, heart.faces
    prepared = sp.prepare(arrays)
    names = [surface.name for surface in as_surfaces([prepared, heart, prepared.surface])]
    assert names == ["surface 0", heart.name, "surface 2"]
    assert [s.name for s in as_surfaces({"a": prepared, "b": prepared})] == ["a", "b"]
    assert as_surfaces([prepared, heart])[0] is prepared.surface


def test_other_numbers_of_openings_are_named(heart):
    """Each is prepared by itself; what comes after tells."""
    surfaces = []
    for i in range(4):
        corners = heart.vertices[heart.faces][:, :, 2]
        keep = corners.max(1) < np.quantile(heart.vertices[:, 2], 0.8)
        if i == 2:
            keep &= corners.min(1) > np.quantile(heart.vertices[:, 2], 0.15)
        scaled = sp.Surface(heart.vertices * (1 + 0.02 * i), heart.faces[keep], f"p_{i}")
        surfaces.append(sp.prepare(scaled).surface)
    with pytest.warns(sp.SpherePropagationWarning) as warned:
        sp.correspond(surfaces, root=0, frequency=4)
    (differ,) = (w.message for w in warned if w.message.message == "openingsDiffer")
    assert differ.layers == ("p_2",) and '"p_2" 2, the others 1.' in str(differ)


def test_the_advice_is_for_python(heart):
    with pytest.warns(sp.SpherePropagationWarning) as warned:
        sp.prepare(opened(heart), close_openings=False)
    (left,) = (w.message for w in warned)
    assert str(left).endswith("Prepare it with the steps that were left out.")
    inner = heart.vertices * 0.7
    faces = heart.faces[heart.vertices[heart.faces][:, :, 2].max(1) < 10]
    wall = sp.Surface(
        np.vstack([heart.vertices, inner]), np.vstack([faces, faces + len(inner)]), "wall"
    )
    with pytest.warns(sp.SpherePropagationWarning, match="Prepare it with join_shells=True"):
        sp.prepare(wall)
