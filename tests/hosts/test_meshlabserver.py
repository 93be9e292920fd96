# SPDX-License-Identifier: GPL-3.0-only
"""The whole job in meshlabserver 2020.09: what it saves is judged by the yardstick and by
PyMeshLab."""

import gzip
import re
import shutil

import numpy as np
import pymeshlab
import pytest
import volume_files
from conftest import SAMPLE, heart
from documents import EVALUATE, MODEL, PROPAGATE, REMESH, ROOT, landmark_layers
from server import SCRIPTS, layer_files, write_project, write_script

ROOT_NAME, PROPAGATE_NAME, REMESH_NAME = (
    "Spherical parameterise root",
    "Propagate parameterisation to layers",
    "Remesh by icosphere",
)
FIRST = "Change the current layer"


def opened(project):
    meshes = pymeshlab.MeshSet()
    meshes.load_project(str(project))
    return meshes


def inputs(name, surfaces):
    return surfaces if name == "sample" else heart(name, 5)


@pytest.mark.parametrize("script", ["main_job.mlx", "main_job_as_published.mlx"])
@pytest.mark.parametrize("data", ["sample", "heart_truth/mc", "heart_cine"])
def test_the_whole_job(server, measure, surfaces, tmp_path, data, script):
    files = inputs(data, surfaces)
    count = len(files)
    outputs = [
        argument
        for i in range(count)
        for argument in ("-o", tmp_path / f"map_{i}.ply", "-l", i, "-m", "vt")
    ]
    outputs += [
        argument
        for i in range(count)
        for argument in ("-o", tmp_path / f"landmarks_{i}.ply", "-l", count + i, "-m", "vc")
    ]
    run = server("-i", *files, "-s", SCRIPTS / script, *outputs, folder=tmp_path)
    assert run.code == 0, run.output[-3000:]
    assert run.output.count("0 flipped faces") >= count

    faces = None
    for i, file in enumerate(files):
        vertex, f = measure.read_ply(tmp_path / f"map_{i}.ply")
        figures = measure.map_figures(measure.points(vertex), f, measure.sphere_positions(vertex))
        assert figures["flips"] == 0 and abs(figures["degree"] - 1) < 1e-6
        original, _ = measure.read_ply(file)
        assert len(f) > 0 and np.abs(measure.points(vertex) - measure.points(original)).max() < 1e-4
        landmarks, f = measure.read_ply(tmp_path / f"landmarks_{i}.ply")
        assert len(measure.points(landmarks)) == 1002
        assert faces is None or np.array_equal(f, faces)
        faces = f

    # PyMeshLab makes the same of the same layers, in double precision.
    meshes = pymeshlab.MeshSet()
    for file in files:
        meshes.load_new_mesh(str(file))
    meshes.set_current_mesh(0)
    published = script != "main_job.mlx"
    meshes.apply_filter(ROOT, initial_map="Brechbuehler" if published else "Automatic")
    meshes.apply_filter(PROPAGATE, method="As published" if published else "Robust")
    meshes.apply_filter(REMESH)
    for i, layer in enumerate(landmark_layers(meshes)):
        points = measure.points(measure.read_ply(tmp_path / f"landmarks_{i}.ply")[0])
        # In mm; hearts are 100 mm long, floats of that size 8e-6 apart.
        assert np.abs(points - layer.vertex_matrix()).max() < 2e-3


def test_anchors_that_lie_beside_the_meshes_guide_the_job(server, surfaces, tmp_path):
    for file in surfaces:
        name = f"{file.stem}_picked_points.pp"
        shutil.copy(SAMPLE / "anchors" / name, tmp_path / name)
    run, _ = server.job(surfaces, tmp_path)
    assert run.code == 0, run.output[-3000:]
    for file in surfaces:
        assert re.search(rf"{file.stem}\S*: 4 anchors from", run.output)
    assert "Anchors, soft" in run.output


def test_a_saved_project_goes_on_in_pymeshlab_and_comes_back(server, surfaces, tmp_path):
    run, project = server.job(surfaces, tmp_path)
    assert run.code == 0, run.output[-3000:]
    assert len(layer_files(project)) == 2 * len(surfaces)
    meshes = opened(project)
    figures = meshes.apply_filter(EVALUATE)
    assert figures["valid"].tolist() == [1] * len(surfaces) and figures["flipped_faces"].sum() == 0
    landmarks = [m.vertex_matrix() for m in meshes][len(surfaces) :]
    figures = meshes.apply_filter(REMESH)  # knows surfaces from landmarks
    assert len(figures["surface_distance_max"]) == len(surfaces)
    # In the place of those that were loaded, under their names.
    again = list(meshes)[len(surfaces) :]
    assert len(again) == len(surfaces)
    for new, old in zip(again, landmarks, strict=True):
        # Texture coordinates are floats: 3e-8 of a turn.
        assert np.abs(new.vertex_matrix() - old).max() < 1e-3
    meshes.set_current_mesh(0)
    meshes.apply_filter(PROPAGATE, root_layer=0, method="As published")

    # Back, from PLY files of either precision.
    kept = [
        (m.vertex_matrix(), m.vertex_tex_coord_matrix(), m.face_matrix())
        for m in list(meshes)[: len(surfaces)]
    ]
    for scalar in ("float", "double"):
        folder = tmp_path / scalar
        folder.mkdir()
        files = [
            write_ply(folder / f"phase_{i}.ply", *layer, scalar) for i, layer in enumerate(kept)
        ]
        write_project(folder / "in.mlp", [(f, None, True) for f in files])
        script = write_script(folder / "remesh.mlx", REMESH_NAME)
        run = server("-p", folder / "in.mlp", "-s", script, "-w", folder / "out.mlp", folder=folder)
        assert run.code == 0, run.output[-3000:]
        back = [m.vertex_matrix() for m in opened(folder / "out.mlp")][len(surfaces) :]
        assert len(back) == len(surfaces)
    meshes.save_project(str(tmp_path / "pymeshlab.mlp"))
    run = server("-p", tmp_path / "pymeshlab.mlp", "-s", script, folder=tmp_path)
    assert run.code == 0 and run.output.count("1002 landmarks") >= len(surfaces), run.output[-3000:]


def test_from_a_label_volume_to_the_model(server, tmp_path):
    """Nothing is loaded: the script reads labels.nii.gz and writes model.npz; PyMeshLab makes the
    same of them."""
    x = np.stack(np.meshgrid(*[np.linspace(-1.3, 1.3, n) for n in (30, 26, 10)], indexing="ij"), -1)
    bend = 1 + 0.25 * x[..., 0] + 0.15 * x[..., 1] - 0.2 * x[..., 2]
    eggs = [
        (x**2 * stretch).sum(-1) * bend < 1
        for stretch in ([1, 1, 1], [1.5, 1, 1], [2, 1.5, 1], [1.5, 2.5, 1])
    ]
    labels = volume_files.nifti(np.stack(eggs, -1).astype("u1"), np.diag([2.0, 2, 6, 1]))
    (tmp_path / "labels.nii.gz").write_bytes(gzip.compress(labels))
    run = server(
        "-s", SCRIPTS / "label_volume_to_model.mlx", "-w", tmp_path / "out.mlp", folder=tmp_path
    )
    assert run.code == 0, run.output[-3000:]
    files = layer_files(tmp_path / "out.mlp")
    # Surfaces, landmarks, mean, modes.
    assert len(files) == 4 + 4 + 1 + 2 * 3 and all(file.is_file() for file in files)

    meshes = pymeshlab.MeshSet()
    meshes.apply_filter(
        "create_layers_from_label_volume", file_name=str(tmp_path / "labels.nii.gz")
    )
    meshes.apply_filter(ROOT)
    meshes.apply_filter(PROPAGATE, order="Cyclic time")
    meshes.apply_filter(REMESH)
    expected = meshes.apply_filter(MODEL)
    with np.load(tmp_path / "model.npz") as model:
        assert model["eigenvalues"] == pytest.approx(expected["eigenvalues"], rel=1e-3)


def write_ply(path, vertices, texture, faces, scalar):
    """A binary PLY with coordinates of this type, and float texture coordinates as every host
    writes them."""
    kind = {"float": "<f4", "double": "<f8"}[scalar]
    properties = [
        *((scalar, kind, name) for name in "xyz"),
        *(("float", "<f4", name) for name in ("texture_u", "texture_v")),
    ]
    header = "\n".join(
        [
            "ply",
            "format binary_little_endian 1.0",
            f"element vertex {len(vertices)}",
            *(f"property {type_name} {name}" for type_name, _, name in properties),
            f"element face {len(faces)}",
            "property list uchar int vertex_indices",
            "end_header\n",
        ]
    )
    points = np.empty(len(vertices), [(name, numpy_type) for _, numpy_type, name in properties])
    for (_, _, name), column in zip(properties, np.hstack([vertices, texture]).T, strict=True):
        points[name] = column
    rows = np.empty(len(faces), [("n", "u1"), ("i", "<i4", 3)])
    rows["n"], rows["i"] = 3, faces
    path.write_bytes(header.encode() + points.tobytes() + rows.tobytes())
    return path


def test_hidden_and_transformed_layers(server, measure, surfaces, tmp_path):
    """A hidden layer is left out; a matrix moves the landmarks, which get none."""
    turn = [0, -1, 0, 10, 1, 0, 0, -20, 0, 0, 1, 30, 0, 0, 0, 1]
    project = write_project(
        tmp_path / "in.mlp",
        [(surfaces[0], None, True), (surfaces[1], turn, True), (surfaces[2], None, False)],
    )
    outputs = [
        a
        for i in range(2)
        for a in ("-o", tmp_path / f"landmarks_{i}.ply", "-l", 3 + i, "-m", "vc")
    ]
    run = server("-p", project, "-s", SCRIPTS / "main_job.mlx", *outputs, folder=tmp_path)
    assert run.code == 0, run.output[-3000:]
    assert "ventricle_2.ply: 1002 landmarks" not in run.output
    assert "Warning: ventricle_1.ply: it lies in another pose" in run.output
    matrix = np.reshape(turn, (4, 4))
    for i, m in enumerate([np.eye(4), matrix]):
        points = measure.points(measure.read_ply(tmp_path / f"landmarks_{i}.ply")[0])
        seen = measure.points(measure.read_ply(surfaces[i])[0]) @ m[:3, :3].T + m[:3, 3]
        assert np.abs(points.mean(0) - seen.mean(0)).max() < 3
        assert (
            np.abs(points.min(0) - seen.min(0)).max() < 3
            and np.abs(points.max(0) - seen.max(0)).max() < 3
        )


# ---------------------------------------------------------------- what goes wrong


def failed(run, *words):
    """The script was refused, as meshlabserver does it, with a text for the user; nothing
    crashed."""
    assert run.code == 255, f"exit code {run.code}: {run.output[-2000:]}"
    for word in words:
        assert word in run.output


def test_an_open_mesh_is_named_in_the_log(server, measure, surfaces, tmp_path):
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(surfaces[0]))
    meshes.apply_filter("compute_selection_by_condition_per_face", condselect="fi==40")
    meshes.apply_filter("meshing_remove_selected_faces")
    meshes.save_current_mesh(str(tmp_path / "open.ply"))
    failed(
        server(
            "-i",
            tmp_path / "open.ply",
            surfaces[1],
            "-s",
            SCRIPTS / "main_job.mlx",
            folder=tmp_path,
        ),
        "open.ply",
        "Close Holes",
        f"Problem with filter: {ROOT_NAME}",
    )


@pytest.mark.parametrize(
    "filters, words",
    [
        ([FIRST, PROPAGATE_NAME], ["has no map"]),
        ([REMESH_NAME], ["No visible surface layer has a map"]),
        ([(ROOT_NAME, {"initial_map": 7})], ["initial_map is 7"]),
        ([(ROOT_NAME, {"area_weight": 3})], ["rea weight"]),
        ([(ROOT_NAME, {"area_weight": "nan"})], ["rea weight"]),
        ([FIRST, ROOT_NAME, (PROPAGATE_NAME, {"order": 4, "parents": "0, none"})], ['"none"']),
        ([FIRST, ROOT_NAME, PROPAGATE_NAME, (REMESH_NAME, {"frequency": 0})], ["requency"]),
    ],
    ids=[
        "propagate first",
        "remesh first",
        "choice",
        "weight",
        "weight nan",
        "parents",
        "frequency",
    ],
)
def test_bad_parameters_are_told(server, surfaces, tmp_path, filters, words):
    plain = [surfaces[0], surfaces[1]]
    files = []
    for file in plain:  # without the maps that the sample carries
        meshes = pymeshlab.MeshSet()
        meshes.load_new_mesh(str(file))
        files.append(tmp_path / file.name)
        meshes.save_current_mesh(str(files[-1]), save_vertex_coord=False)
    script = write_script(tmp_path / "job.mlx", *filters)
    failed(server("-i", *files, "-s", script, folder=tmp_path), *words)


def test_no_layer_at_all(server, tmp_path):
    for name in (ROOT_NAME, REMESH_NAME):
        failed(server("-s", write_script(tmp_path / "job.mlx", name), folder=tmp_path), "layer")
