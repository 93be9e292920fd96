# SPDX-License-Identifier: GPL-3.0-only
"""Files: what is written comes back, in which order meshes are read, what an output folder keeps
and lets go of."""

import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
import pymeshlab
import pytest
import sphere_propagation as sp
from sphere_propagation.results import LIST, ResultFolder


def test_layers_written_come_back_with_their_maps(cycle, tmp_path):
    sp.write_layers(tmp_path, "cycle", cycle)
    meshes = pymeshlab.MeshSet()
    meshes.load_project(str(tmp_path / "cycle" / "cycle.mlp"))
    assert meshes.mesh_number() == 18
    assert [mesh.is_visible() for mesh in meshes] == 6 * [True] + 12 * [False]
    measures = meshes.apply_filter("get_spherical_parameterisation_measures")
    assert list(measures["valid"]) == 6 * [1]
    assert len(meshes.apply_filter("generate_icosphere_remeshing", frequency=4)["seconds"]) == 6
    assert meshes.mesh_number() == 18  # the landmark layers were known again and replaced
    project = xml.parse(tmp_path / "cycle" / "cycle_overview.mlp")
    assert len(project.findall(".//MLMesh")) == 13
    for mesh in project.findall(".//MLMesh"):
        # With a position for points MeshLab 2025.07 draws them after the first filter.
        assert mesh.find("RenderingOption").text.startswith("10000")
        assert (
            not Path(mesh.get("filename")).is_absolute()
            and (tmp_path / "cycle" / mesh.get("filename")).is_file()
        )


def test_surfaces_and_maps_come_back(cycle, tmp_path):
    sp.write_layers(tmp_path, "cycle", cycle)
    path = tmp_path / "cycle/surfaces/phantom_cavity_03.ply"
    surface, sphere = sp.read_mesh(path), sp.read_map(path)
    assert surface.name == "phantom_cavity_03" and np.array_equal(
        surface.faces, cycle.surfaces[3].faces
    )
    assert np.abs(surface.vertices - cycle.surfaces[3].vertices).max() < 1e-5
    assert np.abs(sphere.positions - cycle.maps[3].positions).max() < 1e-6
    assert sphere.figures["area_ratio_sd"] == pytest.approx(
        cycle.maps[3].figures["area_ratio_sd"], rel=1e-3
    )


def test_other_texture_coordinates_are_no_map(cycle, tmp_path):
    surface = cycle.surfaces[0]
    sp.write_ply(
        tmp_path / "planar.ply",
        surface.vertices,
        surface.faces,
        texture=np.zeros((len(surface.vertices), 2)),
    )
    sp.write_ply(tmp_path / "plain.ply", surface.vertices, surface.faces)
    for name, words in (
        ("planar", "no valid map"),
        ("plain", "no texture coordinates"),
        ("nowhere", "There is no file"),
    ):
        with pytest.raises(sp.FileError, match=words):
            sp.read_map(tmp_path / f"{name}.ply")


@pytest.mark.parametrize(
    "content, words",
    [
        (b"hello", "no PLY header"),
        (b"", "It is empty"),
        (b"ply\nformat ascii 1.0\nelement vertex 3\n", "no PLY header"),
        (
            b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            b"property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
            b"end_header\n0 0 0\n",
            "EOF",
        ),
    ],
)
def test_a_broken_file_is_named(content, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("broken.ply").write_bytes(content)
    for _ in range(2):  # the second relative path still means the same
        with pytest.raises(sp.FileError, match=f"broken.ply cannot be read as a mesh.*{words}"):
            sp.read_mesh("broken.ply")


def test_points_are_no_surface(tmp_path):
    sp.write_ply(tmp_path / "points.ply", np.zeros((3, 3)), np.zeros((0, 3), int))
    with pytest.raises(sp.FileError, match="holds no triangles"):
        sp.read_mesh(tmp_path / "points.ply")


def test_a_folder_is_in_natural_order(tmp_path):
    for name in ("phase_10.ply", "phase_2.PLY", "phase_1.stl", "notes.txt"):
        (tmp_path / name).touch()
    assert [path.name for path in sp.mesh_files(tmp_path)] == [
        "phase_1.stl",
        "phase_2.PLY",
        "phase_10.ply",
    ]


@pytest.mark.parametrize(
    "given, meant",
    [
        (
            ["t10.ply", "t1.ply", "t2.ply"],
            ["t1.ply", "t2.ply", "t10.ply"],
        ),  # names that differ in numbers alone
        (["systole.ply", "diastole.ply"], ["systole.ply", "diastole.ply"]),  # as given
    ],
)
def test_files_are_in_order_of_their_numbers(given, meant, tmp_path):
    for name in given:
        (tmp_path / name).touch()
    assert [path.name for path in sp.mesh_files(*(tmp_path / name for name in given))] == meant


def test_files_that_cannot_be_told_apart(tmp_path):
    for name in ("x.ply", "x.stl"):
        (tmp_path / name).touch()
    for given in ([tmp_path], [tmp_path / "x.ply", tmp_path / "x.ply"]):
        with pytest.raises(sp.FileError, match="same name"):
            sp.mesh_files(*given)


@pytest.mark.parametrize(
    "files, names",
    [
        # One name everywhere: the folder's, up to where they differ.
        (["a/x.ply", "b/x.ply"], ["a", "b"]),
        (["a/seg/x.ply", "b/seg/x.ply"], ["a", "b"]),
        (["a/1/x.ply", "a/2/x.ply", "b/1/x.ply"], ["a_1", "a_2", "b_1"]),
        # Several names: only those that are there twice.
        (["a/x.ply", "a/y.ply", "b/x.ply"], ["a_x", "y", "b_x"]),
        (["a/x_1.ply", "a/x_2.ply", "a/x_10.ply"], ["x_1", "x_2", "x_10"]),
    ],
)
def test_a_parent_folder_is_read_with_its_folders(files, names, tmp_path, cycle):
    surface = cycle.surfaces[0]
    for name in files:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        sp.write_ply(tmp_path / name, surface.vertices, surface.faces)
    assert sp.mesh_files(tmp_path) == [tmp_path / name for name in files]
    assert [surface.name for surface in sp.read_meshes(tmp_path)] == names


def test_what_is_below_files_is_named_and_results_are_left_alone(tmp_path):
    for name in ("x_1.ply", "old/x_1.ply", "__MACOSX/x_1.ply", ".trash/x_1.ply", "out/a/x_9.ply"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "out" / ".sphere-propagation.sha256").touch()
    with pytest.warns(sp.SpherePropagationWarning, match="not what is in old; give") as said:
        assert sp.mesh_files(tmp_path) == [tmp_path / "x_1.ply"]
    assert len(said) == 1
    (tmp_path / "x_1.ply").unlink()
    assert sp.mesh_files(tmp_path) == [tmp_path / "old/x_1.ply"]
    (tmp_path / "old/x_1.ply").unlink()
    (tmp_path / "old/again").symlink_to(tmp_path)  # a circle ends somewhere
    with pytest.raises(sp.FileError, match="holds no mesh"):
        sp.mesh_files(tmp_path)


def text(words):
    return lambda path: path.write_text(words)


def names(folder):
    return sorted(
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*")
        if path.is_file() and path.name != LIST
    )


def test_a_second_run_leaves_nothing_of_the_first(tmp_path):
    first = ResultFolder(tmp_path / "out")
    first.write("a/old.txt", text("old"))
    first.write("both.txt", text("first"))
    (tmp_path / "out/mine.txt").write_text("mine")
    second = ResultFolder(tmp_path / "out")
    assert "a/old.txt" in names(tmp_path / "out")  # until the second run has something to write
    second.write("both.txt", text("second"))
    second.write("b/new.txt", text("new"))
    assert names(tmp_path / "out") == ["b/new.txt", "both.txt", "mine.txt"] and not second.kept
    assert not (tmp_path / "out/a").exists() and (tmp_path / "out/both.txt").read_text() == "second"


def test_work_of_others_is_kept(tmp_path):
    first = ResultFolder(tmp_path)
    for name in ("edited.txt", "edited_too.txt"):
        first.write(name, text("ours"))
        (tmp_path / name).write_text("theirs")
    (tmp_path / "foreign.txt").write_text("foreign")
    second = ResultFolder(tmp_path)
    for name in ("edited.txt", "foreign.txt"):
        second.write(name, text("ours"))
    assert names(tmp_path) == [
        "edited.txt",
        "edited.txt.bak",
        "edited_too.txt",
        "foreign.txt",
        "foreign.txt.bak",
    ]
    assert (tmp_path / "edited.txt.bak").read_text() == "theirs" and (
        tmp_path / "foreign.txt.bak"
    ).read_text() == "foreign"
    assert {path.name for path in second.kept} == {
        "edited.txt.bak",
        "edited_too.txt",
        "foreign.txt.bak",
    }


def test_a_list_cannot_reach_outside(tmp_path):
    outside, out = tmp_path / "outside.txt", tmp_path / "out"
    outside.write_text("x")
    first = ResultFolder(out)
    first.write("inside.txt", text("x"))
    lines = (out / LIST).read_text()
    (out / LIST).write_text(lines + lines.replace("inside.txt", "../outside.txt"))
    ResultFolder(out).write("new.txt", text("y"))
    assert outside.exists() and names(out) == ["new.txt"]


def test_what_a_run_that_failed_wrote_goes_too(tmp_path):
    def fails(path):
        path.write_text("half")
        raise OSError("no space")

    first = ResultFolder(tmp_path)
    with pytest.raises(OSError):
        first.write("half.txt", fails)
    ResultFolder(tmp_path).write("new.txt", text("y"))
    assert names(tmp_path) == ["new.txt"]
