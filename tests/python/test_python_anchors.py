# SPDX-License-Identifier: GPL-3.0-only
"""Points of the user's own, as dictionaries and as files."""

import numpy as np
import pytest
import sphere_propagation as sp
from sphere_propagation import command, files


def anchors_of(surface):
    v = surface.vertices
    return {"apex": v[v[:, 2].argmin()], "left side": v[v[:, 0].argmax()]}


@pytest.fixture(scope="module")
def surfaces():
    return sp.make_phantom(phases=3, voxel_size=4.0)


def test_anchors_hold_on_the_surfaces_that_have_them(surfaces):
    anchors = [anchors_of(surfaces[0]), None, anchors_of(surfaces[2])]
    result = sp.correspond(surfaces, anchors=anchors, exact=True, root=0, frequency=4)
    assert result.anchors.names == ["apex", "left side"]
    assert np.isnan(result.anchors.distance).tolist() == [[False] * 2, [True] * 2, [False] * 2]
    assert np.nanmax(result.anchors.distance) < 1e-9
    assert result.anchors.z.shape == (3, 2) and result.anchors.widening.shape == (3,)
    assert sp.correspond(surfaces, root=0, frequency=4).anchors is None


def test_anchors_become_landmarks(surfaces):
    anchors = [anchors_of(surface) for surface in surfaces]
    for frequency in (10, 30):
        result = sp.correspond(
            surfaces, anchors=anchors, exact=True, anchor_snap=True, root=0, frequency=frequency
        )
        for points, its in zip(result.landmarks, anchors):
            assert np.allclose(points[result.anchors.landmarks], list(its.values()), atol=1e-9)
        assert (result.root_map.positions == result.maps[0].positions).all()


def test_a_folder_serves_functions_and_the_command(surfaces, tmp_path):
    (tmp_path / "anchors").mkdir()
    for i, surface in enumerate(surfaces):
        files.write_ply(tmp_path / f"phase_{i}.ply", surface.vertices, surface.faces)
        rows = [f"{name},{x},{y},{z}" for name, (x, y, z) in anchors_of(surface).items()]
        (tmp_path / f"anchors/phase_{i}.csv").write_text("\n".join(rows))
    meshes = sp.read_meshes(tmp_path)
    found = sp.propagate(
        meshes, sp.parameterise_root(meshes[0]), order="Time", anchors=tmp_path / "anchors"
    ).anchors
    assert not np.isnan(found.distance).any() and found.names == ["apex", "left side"]
    options = ["--anchors", tmp_path / "anchors", "--anchor-sd", 2, "--frequency", 4]
    done = command.main([str(x) for x in ["run", tmp_path, "-o", tmp_path / "results", *options]])
    assert done == 0


@pytest.mark.parametrize(
    "anchors, words",
    [
        ("no such folder", "is no folder"),
        ([{}], "one dictionary or None per surface: 1 for 3"),
        ([[1, 2, 3]] * 3, "of surface 0 must be a dictionary"),
        ([{}, {"a": (1, 2)}, {}], "'a' of surface 1 must be three numbers"),
        ([{}, {"a": (1, 2, np.nan)}, {}], "'a' of surface 1 must be three numbers"),
    ],
)
def test_what_is_no_anchor_is_refused(surfaces, anchors, words):
    with pytest.raises(sp.InputError, match=words):
        sp.correspond(surfaces, anchors=anchors)


def test_bad_choices_are_refused(surfaces):
    with pytest.raises(sp.InputError, match="multiple of 10, not 12"):
        sp.correspond(surfaces, anchor_snap=True, frequency=12)
    with pytest.raises(sp.InputError, match="anchor_sd must be 0 or more"):
        sp.correspond(surfaces, anchor_sd=-1)
    with pytest.raises(sp.InputError, match="exact must be True or False"):
        sp.correspond(surfaces, exact="yes")


def test_the_roots_anchors_lie_where_they_are_asked_to(surfaces, tmp_path):
    wanted = {"apex": (0, 0, -2), "left side": (180, 30)}
    anchors = [anchors_of(surface) for surface in surfaces]
    places = np.array([[0, 0, -1], [-np.sqrt(0.75), 0, 0.5]])
    at = [np.linalg.norm(surfaces[0].vertices - p, axis=1).argmin() for p in anchors[0].values()]
    (tmp_path / "cavity.csv").write_text(
        "\n".join(f"{name},{x!r},{y!r},{z!r}" for name, (x, y, z) in anchors[0].items())
    )
    alone = sp.parameterise_root(surfaces[0], anchors=anchors[0], anchor_positions=wanted)
    np.testing.assert_allclose(alone.positions[at], places, atol=1e-11)
    (tmp_path / "positions.txt").write_text("name lon lat\napex 0 -90\n")
    result = sp.correspond(
        surfaces,
        anchors=anchors,
        anchor_positions=tmp_path / "positions.txt",
        exact=True,
        root=0,
        frequency=4,
    )
    for anchor, surface, sphere in zip(anchors, surfaces, result.maps):
        vertex = np.linalg.norm(surface.vertices - anchor["apex"], axis=1).argmin()
        np.testing.assert_allclose(sphere.positions[vertex], places[0], atol=1e-9)


def test_wrong_positions_are_named(surfaces):
    anchors = anchors_of(surfaces[0])
    for wrong, words in (
        ([1], "must be a file or a dictionary"),
        ({"apex": "up"}, "must be a direction"),
        ({"apex": (0, 0, 0)}, "has no direction"),
        ({"apex": (0, 91)}, "latitude"),
    ):
        with pytest.raises(sp.InputError, match=words):
            sp.parameterise_root(surfaces[0], anchors=anchors, anchor_positions=wrong)
    with pytest.raises(sp.FilterError, match="has none of the anchors"):
        sp.parameterise_root(surfaces[0], anchor_positions={"apex": (0, 0, 1)})
    given = sp.parameterise_root(surfaces[0])
    with pytest.raises(sp.InputError, match="anchor_positions"):
        sp.correspond(surfaces, root=0, root_map=given, anchor_positions={"apex": (0, 0, 1)})


def test_anchors_align_a_shape_model(surfaces):
    anchors = [
        {name: s.vertices[s.vertices[:, k].argmin()] for k, name in enumerate("abc")}
        for s in surfaces
    ]
    result = sp.correspond(surfaces, anchors=anchors, anchor_pose=True, root=0, frequency=4)
    assert np.allclose(result.anchors.places[1][2], anchors[1]["c"])
    shapes = result.landmarks, result.landmark_faces
    model = sp.shape_model(*shapes, anchors=result.anchors, alignment="anchors")
    as_given = sp.shape_model(*shapes, anchors=anchors, alignment="Anchors")
    assert (model.mean == as_given.mean).all()
    rigid = sp.shape_model(*shapes, alignment="Rigid")
    assert model.total_variance > 1.001 * rigid.total_variance  # all landmarks are nearer
    with pytest.raises(sp.InputError, match="needs anchors"):
        sp.shape_model(*shapes, alignment="Anchors")
    with pytest.raises(sp.InputError, match="not a path"):
        sp.shape_model(*shapes, alignment="Anchors", anchors="folder")
    with pytest.raises(sp.FilterError, match="shape 1.* shares 2"):
        two = [anchors[0], {k: anchors[1][k] for k in "ab"}, anchors[2]]
        sp.shape_model(*shapes, alignment="Anchors", anchors=two)


def test_the_command_aligns_by_anchors(surfaces, tmp_path, capsys):
    (tmp_path / "anchors").mkdir()
    for i, surface in enumerate(surfaces):
        files.write_ply(tmp_path / f"phase_{i}.ply", surface.vertices, surface.faces)
        v = surface.vertices
        rows = [f"{k},{','.join(map(str, v[v[:, k].argmin()]))}" for k in range(3)]
        (tmp_path / f"anchors/phase_{i}.csv").write_text("\n".join(rows))
    words = ["run", tmp_path, "-o", tmp_path / "out", "--no-pictures", "--frequency", 4]
    by = ["--alignment", "scaled-anchors"]
    assert command.main([str(x) for x in [*words, *by]]) == 2
    assert "--alignment" in capsys.readouterr().err
    by += ["--anchors", tmp_path / "anchors", "--anchor-pose"]
    assert command.main([str(x) for x in [*words, *by]]) == 0
