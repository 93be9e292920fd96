"""The Python package: its truth about the phantom, the job on arrays, files that come back, and what the command line says."""
import csv
import re
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "python"))

from sphere_propagation import demo, files, pictures, pipeline, plugin, projects  # noqa: E402
from sphere_propagation.phantom import TRUSTED, Ventricle  # noqa: E402


@pytest.fixture(scope="module")
def cycle():
    surfaces = pipeline.make_phantom("Cavity", phases=6, voxel_size=4.0)
    return pipeline.run(surfaces, order="Cyclic time", frequency=4)["Robust"]


@pytest.mark.parametrize("part", pipeline.PARTS)
def test_the_truth_is_the_plugins(part):
    meshes = plugin.load().MeshSet()
    meshes.apply_filter("create_ventricle_phantom", part=part, phases=5, seed=3, twist=12)
    truth = Ventricle(part, phases=5, seed=3, twist=12)
    for phase, mesh in enumerate(meshes):
        u, theta, m = mesh.vertex_custom_point_attribute_matrix("material_coordinate").T
        tissue = u < 0.93  # above are the lid and the cut
        away = np.linalg.norm(truth.position(u, theta, m, phase) - mesh.vertex_matrix(), axis=1)[tissue]
        assert away.mean() < 0.3 and away.max() < 2.1  # a tenth of a voxel and one voxel of 2 mm


@pytest.mark.parametrize("part", pipeline.PARTS)
def test_material_points_are_found_again(part):
    truth = Ventricle(part, seed=1)
    u, theta = np.linspace(0.02, 0.9, 200), np.linspace(0, 40, 200)
    for m in truth.sheets:
        found = truth.material_points(truth.position(u, theta, m, 4), 4)
        assert found.distance.max() < 1e-6
        assert np.abs(truth.position(found.u, found.theta, found.m, 9) - truth.position(u, theta, m, 9)).max() < 1e-4


def test_errors_are_zero_for_the_truth_itself():
    truth = Ventricle("Wall", phases=5)
    points = [truth.position(np.linspace(0.1, 0.9, 50), np.linspace(0, 6, 50), 1.0, phase) for phase in range(5)]
    assert truth.errors(np.array(points), root=2).max() < 1e-4
    points[3] = points[3] + [0, 0, 0.5]
    assert truth.errors(np.array(points), root=2)[3] == pytest.approx(0.5, abs=1e-4)
    assert TRUSTED > 0.5


def test_the_job_on_arrays(cycle):
    assert cycle.landmarks.shape == (6, 162, 3)
    assert cycle.figures["flipped_faces"].sum() == 0
    assert all(np.allclose(np.linalg.norm(sphere.positions, axis=1), 1) for sphere in cycle.maps)
    assert all(sphere.texture is not None for sphere in cycle.maps)


def test_layers_written_come_back_with_their_maps(cycle, tmp_path):
    projects.write_layers(tmp_path, "cycle", pictures.Row("cycle", cycle))
    meshes = plugin.load().MeshSet()
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
        assert not Path(mesh.get("filename")).is_absolute() and (tmp_path / "cycle" / mesh.get("filename")).is_file()


def test_natural_order(tmp_path):
    for name in ("phase_10.ply", "phase_2.PLY", "phase_1.stl", "notes.txt"):
        (tmp_path / name).touch()
    assert [path.name for path in files.mesh_files(tmp_path)] == ["phase_1.stl", "phase_2.PLY", "phase_10.ply"]


def write(folder, surfaces):
    for surface in surfaces:
        files.write_ply(folder / f"{surface.name}.ply", surface.vertices, surface.faces)


def test_a_folder_from_the_command_line(cycle, tmp_path, capsys):
    source = tmp_path / "heart"
    source.mkdir()
    write(source, cycle.surfaces[:3])
    assert demo.main([str(tmp_path / "out"), "--input", str(source), "--frequency", "3"]) == 0
    said = capsys.readouterr().out
    assert str(tmp_path / "out") in said and re.search(r"heart +Robust +3 +0 ", said)
    with open(tmp_path / "out" / "figures.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["root"] for row in rows] == ["1", "0", "0"]  # the largest volume is end-diastole
    for name in ("landmarks.png", "checkerboard.png", "map.png", "heart/heart.mlp", "heart/heart_overview.mlp"):
        assert (tmp_path / "out" / name).stat().st_size > 1000


def refusal(capsys, *arguments):
    assert demo.main([str(argument) for argument in arguments]) == 1
    return capsys.readouterr().err


def test_refusals_name_what_is_wrong(cycle, tmp_path, capsys):
    source, out = tmp_path / "heart", tmp_path / "out"
    source.mkdir()
    assert "holds no mesh" in refusal(capsys, out, "--input", source)
    assert "There is no folder" in refusal(capsys, out, "--input", tmp_path / "nowhere")
    write(source, cycle.surfaces[:2])
    assert "Layer 9 cannot be the root" in refusal(capsys, out, "--input", source, "--root", 9)
    assert "choose another" in refusal(capsys, source, "--input", source)
    opened = cycle.surfaces[2]
    write(source, [opened._replace(faces=opened.faces[1:])])
    assert opened.name in refusal(capsys, out, "--input", source) and not (out / "figures.csv").exists()
    (source / "broken.ply").write_text("hello")
    assert "broken.ply cannot be read" in refusal(capsys, out, "--input", source)
    (source / "broken.stl").touch()
    assert "same name" in refusal(capsys, out, "--input", source)
