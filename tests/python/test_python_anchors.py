# SPDX-License-Identifier: GPL-3.0-only
"""Points of the user's own, as dictionaries and as files."""

import json
import re
from pathlib import Path

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


def test_anchors_in_one_place_are_named(surfaces):
    apex = surfaces[1].vertices[surfaces[1].vertices[:, 2].argmin()]
    anchors = [anchors_of(surfaces[0]), {"apex": apex, "left side": apex}, None]
    root = sp.parameterise_root(surfaces[0])
    with pytest.warns(sp.SpherePropagationWarning, match="apex.* lie in one place"):
        sp.propagate(surfaces, root, anchors=anchors)


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


def row(name, place):
    return f"{name},{','.join(map(repr, map(float, place)))}\n"


@pytest.fixture
def beating(surfaces, tmp_path):
    """Three meshes phase_0 ... and a folder with their anchors."""
    (tmp_path / "meshes").mkdir()
    (tmp_path / "anchors").mkdir()
    for i, surface in enumerate(surfaces):
        files.write_ply(tmp_path / f"meshes/phase_{i}.ply", surface.vertices, surface.faces)
        rows = [row(name, place) for name, place in anchors_of(surface).items()]
        (tmp_path / f"anchors/phase_{i}.csv").write_text("".join(rows))
    return tmp_path


@pytest.fixture
def run(beating, capsys):
    def call(*words, by=("--anchors", "anchors")):
        folder = [beating / word if word == "anchors" else word for word in by]
        given = ["run", beating / "meshes", "-o", beating / "out", "--no-pictures", *folder]
        given += ["--frequency", 2, "--root", 0, *words]
        code = command.main(list(map(str, given)))
        said = capsys.readouterr()
        return code, said.out, " ".join(said.err.split())

    return call


def of_run(folder):
    return json.loads((folder / "out/run.json").read_text())["anchors"]


def test_what_a_folder_of_anchors_lacks_is_said(beating, run):
    (beating / "anchors/phase_2.csv").rename(beating / "anchors/phase2.csv")
    (beating / "anchors/notes.md").write_text("no anchors")
    code, _, said = run("--exact-anchors")
    assert code == 0 and of_run(beating) == "apex, left side (exact)"
    assert "has no file for phase_2: it is taken without anchors" in said
    assert "files that belong to no surface, as they are called otherwise: phase2.csv." in said
    assert "nothing is made to correspond" not in said
    # On one surface alone they do nothing.
    for path in ("phase_1.csv", "phase2.csv"):
        (beating / "anchors" / path).unlink()
    code, _, said = run("--exact-anchors")
    assert code == 0 and of_run(beating) == "none that two surfaces have"
    assert "has no file for phase_1, phase_2: they are taken" in said
    assert "phase_0: no other surface has its anchors apex, left side, so nothing" in said


def test_a_folder_that_serves_other_runs_too_is_a_note(beating, run):
    (beating / "anchors/phase_7.csv").write_text("apex,1,2,3\n")
    code, _, said = run()
    assert code == 0 and said.startswith("Note: The folder of anchors")
    assert "called otherwise: phase_7.csv" in said and "warning" not in said


@pytest.mark.parametrize(
    "name, text",
    [
        ("phase_1.csv", ""),
        ("phase_1.csv", "# of nobody\nname,x,y,z\n"),
        ("phase_1_picked_points.pp", " \n"),
        ("phase_1.mrk.json", ""),
    ],
)
def test_a_file_without_a_point_is_an_error(surfaces, beating, run, name, text):
    (beating / "anchors/phase_1.csv").unlink()
    (beating / "anchors" / name).write_text(text)
    code, _, said = run()
    assert code == 1 and f"{name} holds no anchor" in said
    meshes = sp.read_meshes(beating / "meshes")
    with pytest.raises(sp.FileError, match="holds no anchor"):
        sp.correspond(meshes, anchors=beating / "anchors", frequency=2)


def test_points_without_a_place_are_no_error(beating, run):
    (beating / "anchors/phase_1.csv").write_text("apex,,,\nleft side,nan,nan,nan\n")
    assert run()[0] == 0


@pytest.mark.parametrize("flag", ["--exact-anchors", "--anchor-snap", "--anchor-pose"])
def test_what_needs_anchors_is_refused_without(surfaces, run, flag):
    frequency = ("--frequency", 10)
    code, _, said = run(flag, *frequency, by=())
    assert code == 2 and f"error: {flag} needs --anchors: give them, or leave it out." in said
    name = flag[2:].replace("-", "_").replace("exact_anchors", "exact")
    for none in (None, [None] * 3, [{}] * 3):
        with pytest.raises(sp.InputError, match=f"{name} needs anchors"):
            sp.correspond(surfaces, anchors=none, frequency=10, **{name: True})


def test_anchors_beside_meshes_are_noted(beating, run):
    (beating / "meshes/phase_1.fcsv").write_text("a,1,2,3\n")
    code, said, _ = run(by=())
    assert code == 0 and of_run(beating) == "none"
    assert f"--anchors {beating / 'meshes'} says so: phase_1.fcsv" in " ".join(said.split())
    assert "lie beside" not in run()[1]


def test_a_folder_of_anchors_that_cannot_be_read_is_said(beating, run, monkeypatch):
    def refuse(self):
        if self.name == "anchors":
            raise PermissionError(13, "Permission denied", str(self))
        return listing(self)

    listing = Path.iterdir
    monkeypatch.setattr(Path, "iterdir", refuse)
    code, _, said = run()
    assert code == 1 and "anchors cannot be read: Permission denied" in said


def test_a_misspelt_anchor_is_named_with_its_surface(surfaces, beating, run):
    file = beating / "anchors/phase_2.csv"
    file.write_text(file.read_text().replace("apex", "apexx"))
    words = "there are anchors that the root {} lacks; of the root's are missing: apex. Is a name "
    words += "misspelt?"
    said = run()[2]
    assert "phase_2: " + words.format("phase_0") in said
    assert 'phase_0: the anchors "apexx" of "phase_2" are not on it, which is the root' in said
    anchors = [anchors_of(surface) for surface in surfaces]
    anchors[2]["apexx"] = anchors[2].pop("apex")
    with pytest.warns(sp.SpherePropagationWarning) as warned:
        sp.correspond(surfaces, anchors=anchors, root=0, frequency=2)
    found = [w.message for w in warned if w.message.message == "anchorsOfOtherNames"]
    assert len(found) == 1 and found[0].layer == surfaces[2].name
    assert str(found[0]).endswith(words.format(surfaces[0].name))


def test_anchors_off_their_surface_are_one_warning_a_surface(surfaces, beating, run):
    """As those of a file in LPS that does not say so."""
    far = {name: place * [-1, -1, 1] + 300 for name, place in anchors_of(surfaces[1]).items()}
    (beating / "anchors/phase_1.csv").write_text("".join(row(*one) for one in far.items()))
    said = run()[2]
    words = r'phase_1: 2 of its anchors \("apex", "left side"\) lie [\d.]+ to [\d.]+ '
    assert len(re.findall(words + "edge lengths off, so they may be another layer's", said)) == 1
    assert said.count("edge lengths off") == 1
    file = beating / "anchors/phase_1.csv"
    file.write_text(file.read_text().splitlines()[0] + "\n")
    assert 'phase_1: its anchor "apex" lies' in run()[2]
