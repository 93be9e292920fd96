# SPDX-License-Identifier: GPL-3.0-only
"""What a run leaves behind opens elsewhere: docs/landmarks_elsewhere.md, by readers that are not
ours."""

import csv
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from sphere_propagation import command
from sphere_propagation import write_ply as write

PAGE = Path(__file__).resolve().parents[2] / "docs/landmarks_elsewhere.md"


@pytest.fixture(scope="module")
def home(cycle, tmp_path_factory):
    folder = tmp_path_factory.mktemp("elsewhere")
    (folder / "NAME").mkdir()
    for k, surface in enumerate(cycle.surfaces[:4]):
        write(folder / f"NAME/phase_{k:02d}.ply", surface.vertices, surface.faces)
    words = ["run", folder / "NAME", "-o", folder / "results", "--frequency", 3, "--export", "h5"]
    assert command.main([*map(str, words), "--no-pictures"]) == 0
    return folder


@pytest.fixture(scope="module")
def landmarks(home):
    with np.load(home / "results/NAME/landmarks.npz") as file:
        return dict(file)


def block(language):
    return re.search(rf"^```{language}\n(.*?)^```", PAGE.read_text(), re.M | re.S)[1]


def test_the_block_for_r_runs(home, landmarks):
    if not shutil.which("Rscript"):
        pytest.skip("R is not installed")
    program = block("r") + '\ncat(dim(A), A[6, "z", 3], A[1, "x", 1], dim(scores), names[2])\n'
    made = subprocess.run(
        ["Rscript", "-e", program],
        cwd=home,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert made.returncode == 0, made.stderr
    words = made.stdout.split()
    assert words[:3] == ["92", "3", "4"] and words[5:] == ["4", "3", "phase_01"]
    points = landmarks["landmarks"]
    found = [float(word) for word in words[3:5]]
    assert found == pytest.approx([points[2, 5, 2], points[0, 0, 0]], rel=1e-4)


def test_the_block_for_matlab_reads_what_is_there(home, landmarks):
    """The same steps, by other readers: MATLAB's arrays are column by column."""
    with open(home / "results/NAME/landmarks.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    table = np.array([[float(row[axis]) for axis in "xyz"] for row in rows])
    names = list(dict.fromkeys(row["shape"] for row in rows))
    count = len(rows) // len(names)
    array = table.T.reshape((3, count, -1), order="F").transpose(2, 1, 0)
    assert array == pytest.approx(landmarks["landmarks"], rel=1e-6)
    h5py = pytest.importorskip("h5py")
    with (
        h5py.File(home / "results/NAME/model.h5") as file,
        np.load(home / "results/NAME/model.npz") as model,
    ):
        # h5read turns the axes of HDF5 round, which vectors do not notice.
        mean = np.reshape(file["/model/mean"], (3, -1), order="F").T
        assert mean == pytest.approx(model["mean"], rel=1e-4)
        assert np.ravel(file["/model/pcaVariance"]) == pytest.approx(model["eigenvalues"], rel=1e-4)
    assert "'/model/mean'" in block("matlab") and "'/model/pcaVariance'" in block("matlab")


@pytest.mark.parametrize("kind", ["landmarks", "surfaces"])
def test_vtk_reads_the_layers(home, landmarks, kind):
    pyvista = pytest.importorskip("pyvista")
    paths = sorted((home / "results/NAME" / kind).glob("*.ply"))
    assert len(paths) == 4
    for k, path in enumerate(paths):
        assert b"comment SPACE=RAS\n" in path.read_bytes()[:200]
        mesh = pyvista.read(path)
        assert "RGB" in mesh.point_data or "RGBA" in mesh.point_data
        if kind == "landmarks":
            assert np.asarray(mesh.points) == pytest.approx(landmarks["landmarks"][k], rel=1e-5)
            assert np.array_equal(mesh.faces.reshape(-1, 4)[:, 1:], landmarks["faces"])
