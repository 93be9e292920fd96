# SPDX-License-Identifier: GPL-3.0-only
"""scripts/install-plugin: what it puts where, again and again, and takes away. Never in the
system's folders."""

import os
import subprocess

import pytest
from environment import PROJECT
from server import SCRIPTS, Server

PLUGIN = "libfilter_sphere_propagation.so"


@pytest.fixture
def install(tmp_path):
    """install(*arguments): (exit code, what it said); the user's data are in tmp_path/data."""

    def run(*arguments):
        ended = subprocess.run(
            [str(PROJECT / "scripts/install-plugin"), *map(str, arguments)],
            text=True,
            capture_output=True,
            env={**os.environ, "XDG_DATA_HOME": str(tmp_path / "data")},
            check=False,
        )
        return ended.returncode, ended.stderr

    return run


def test_a_private_meshlab_again_and_again(install, tmp_path):
    prefix = tmp_path / "my meshlab"
    for _ in range(2):
        code, said = install("--prefix", prefix, "meshlab-2020.09")
        assert code == 0 and f"{prefix}/bin/meshlabserver" in said and "--remove" in said
    server = Server(prefix / "bin/meshlabserver")
    run = server("-s", SCRIPTS / "main_job.mlx", folder=tmp_path)
    # There is no layer.
    assert "Spherical parameterise root not found" not in run.output and run.code != 0

    # As after an update of the package: other binaries, plugins that are new or gone.
    binary, plugins = prefix / "app/meshlabserver", prefix / "app/plugins"
    right = binary.read_bytes()
    binary.write_bytes(b"of yesterday")
    (plugins / "libio_base.so").unlink()
    (plugins / "libgone.so").symlink_to("/nowhere/libgone.so")
    server("-s", SCRIPTS / "main_job.mlx", folder=tmp_path)
    assert binary.read_bytes() == right
    assert (plugins / "libio_base.so").exists() and not (plugins / "libgone.so").is_symlink()

    code, said = install("--remove", "--prefix", prefix, "meshlab-2020.09")
    assert code == 0 and not prefix.exists()
    code, said = install("--remove", "--prefix", prefix, "meshlab-2020.09")
    assert code == 0 and "nothing to remove" in said


def test_what_is_somebody_elses_stays(install, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/thesis.txt").write_text("all of it")
    code, said = install("--prefix", tmp_path / "mine", "meshlab-2020.09")
    assert code != 0 and "was not made by this script" in said
    install("--remove", "--prefix", tmp_path / "mine", "meshlab-2020.09")
    assert (tmp_path / "mine/thesis.txt").read_text() == "all of it"
    install("--prefix", tmp_path / "other", "meshlab-2020.09")
    (tmp_path / "other/notes.txt").write_text("kept")
    install("--remove", "--prefix", tmp_path / "other", "meshlab-2020.09")
    assert [p.name for p in (tmp_path / "other").iterdir()] == ["notes.txt"]


def test_the_folder_of_2025_is_cleared(install, tmp_path):
    folder = tmp_path / "data/VCG/MeshLab_64bit_fp/MeshLabExtraPlugins/2025.07"
    folder.mkdir(parents=True)
    (folder / PLUGIN).write_bytes(b"")
    (folder / "libother.so").write_bytes(b"")
    assert install("--remove", "meshlab")[0] == 0
    assert [p.name for p in folder.iterdir()] == ["libother.so"]


@pytest.mark.parametrize(
    "arguments", [["2020.09"], ["--prefix"], ["--help"], ["--prefix", "x", "meshlab"]]
)
def test_what_it_does_not_understand(install, arguments):
    assert install(*arguments)[0] != 0
