# SPDX-License-Identifier: GPL-3.0-only
"""Code on the pages works. Python blocks run, those of a page one after another, in a folder like a
checkout with a reader's meshes in it:

    phases/phase_00.ply ...    closed surfaces of one cycle, coarse        heart.ply    one of them
    labels_4d.nii.gz           labels of two phases
    scripts, sample_projects, build/pymeshlab/plugins                      those of the checkout

Of shell blocks, every command is one that is known here, every script is there and knows its
options. A comment `<!-- not run: why -->` before a block excuses it.
"""

import gzip
import json
import os
import re
import shlex
import subprocess
import sys

import numpy as np
import pymeshlab
import pytest
from pages import PROJECT, all_pages

sys.path.insert(0, str(PROJECT / "tests/volumes"))
import volume_files

PAGES = all_pages()
SHELL = ("sh", "bash", "")
OTHER_COMMANDS = {
    "apt-get",
    "apt",
    "cmake",
    "cd",
    "cp",
    "mkdir",
    "git",
    "meshlab",
    "pip",
    "jsontoh5",
}
MESHLABSERVER = {"-i", "-o", "-s", "-m", "-w", "-p", "-l", "vt", "vc", "vn"}


def blocks(page, *languages):
    return [b for b in page.blocks if b.language in languages and not b.not_run]


@pytest.fixture(scope="module")
def folder(plugin, tmp_path_factory):
    """What a reader has."""
    folder = tmp_path_factory.mktemp("reader")
    for name in ("scripts", "sample_projects"):
        (folder / name).symlink_to(PROJECT / name)
    (folder / "build/pymeshlab/plugins").mkdir(parents=True)
    for built in plugin.parent.glob("libfilter_*.so"):
        (folder / "build/pymeshlab/plugins" / built.name).symlink_to(built)
    (folder / "labels_4d.nii.gz").write_bytes(
        gzip.compress(volume_files.nifti(np.stack([volume_files.egg()] * 2, -1)))
    )
    (folder / "phases").mkdir()
    meshes = pymeshlab.MeshSet()
    meshes.apply_filter("create_ventricle_phantom", phases=6, voxel_size=4.0)
    for phase, mesh in enumerate(meshes):
        meshes.set_current_mesh(mesh.id())
        for path in [f"phases/phase_{phase:02d}.ply"] + ["heart.ply"] * (phase == 0):
            meshes.save_current_mesh(str(folder / path))
    return folder


@pytest.mark.parametrize(
    "page", [p for p in PAGES if blocks(p, "python")], ids=lambda page: page.name
)
def test_python_runs(page, folder, plugin):
    if (
        page.name.endswith("label_volumes.md")
        and not (folder / "build/pymeshlab/plugins/libfilter_label_volume.so").exists()
    ):
        pytest.skip("built without the volume plugin")
    code = [[page.name, b.line, b.code] for b in blocks(page, "python")]
    environment = {
        **os.environ,
        "PYTHONPATH": str(PROJECT / "python"),
        "SPHERE_PROPAGATION_PLUGIN": str(plugin),
    }
    done = subprocess.run(
        [sys.executable, str(PROJECT / "tests/docs/run_blocks.py")],
        input=json.dumps(code),
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert not list(folder.rglob("*.ply.ply")), "a page's code saves files under a doubled ending"


# ---------------------------------------------------------------- shell


def commands(code):
    """The simple commands of a block, as lists of words, without variables set before them."""
    for line in re.sub(r"\\\n", " ", code).splitlines():
        words = shlex.split(line, comments=True)
        words = [
            part
            for word in words
            for part in (re.split(r"(;)$", word) if word.endswith(";") else [word])
            if part
        ]
        command = []
        for word in words + [";"]:
            if word in (";", "&&", "|"):
                while command and re.match(r"[A-Z_]+=", command[0]):
                    command.pop(0)
                if command:
                    yield command
                command = []
            else:
                command.append(word)


def presets():
    return [
        p["name"]
        for p in json.loads((PROJECT / "CMakePresets.json").read_text())["configurePresets"]
    ]


def check_script(name, arguments):
    """The script is there, and its head names each option and each of its own words."""
    script = PROJECT / name
    assert script.is_file() and os.access(script, os.X_OK), f"there is no script {name}"
    if script.name == "demo":
        return check_command(["demo", *arguments])
    head = script.read_text().split("\nset -", 1)[0]
    for word in arguments:
        plain = re.fullmatch(r"[a-z][\w.-]*|--?[a-z-]+", word)
        assert (
            not plain
            or re.search(rf"(?<![\w-]){re.escape(word)}(?![\w-])", head)
            or word in presets()
        ), f"{name} knows no {word}"


def check_command(arguments):
    """`sphere-propagation` takes these arguments."""
    from sphere_propagation import command

    command.parser().parse_args(arguments)  # which exits where they are wrong


def check(words, folder):
    if words[:2] == ["xvfb-run", "-a"]:
        words = words[2:]
    name, arguments = words[0], words[1:]
    if re.fullmatch(r"(\./)?scripts/[\w-]+", name):
        check_script(name.removeprefix("./"), arguments)
    elif name == "sphere-propagation":
        check_command(arguments)
    elif words[:3] == ["python3", "-m", "venv"]:
        pass
    elif name == "python3":
        assert (folder / arguments[0]).is_file(), f"there is no {arguments[0]}"
        subprocess.run(
            [sys.executable, *arguments], cwd=folder, check=True, capture_output=True, timeout=300
        )
    elif name.endswith("meshlabserver"):
        for word in arguments:
            assert not word.startswith("-") or word in MESHLABSERVER, (
                f"meshlabserver knows no {word}"
            )
            if word.endswith(".mlx"):
                assert (PROJECT / word.removeprefix("../")).is_file(), f"there is no {word}"
    else:
        assert name.rsplit("/")[-1] in OTHER_COMMANDS, f"{name} is no command that this test knows"


@pytest.mark.parametrize(
    "page", [p for p in PAGES if blocks(p, *SHELL)], ids=lambda page: page.name
)
def test_shell_names_what_is_there(page, folder):
    for block in blocks(page, *SHELL):
        for words in commands(block.code):
            try:
                check(words, folder)
            except (AssertionError, SystemExit, subprocess.CalledProcessError) as error:
                output = getattr(error, "stderr", b"") or b""
                pytest.fail(
                    f"{page.name}:{block.line}: {shlex.join(words)}: {error} "
                    f"{output.decode()[-1000:]}"
                )
