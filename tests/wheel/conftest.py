# SPDX-License-Identifier: GPL-3.0-only
"""A fresh virtual environment with the wheel that scripts/test built, from the wheelhouse alone.

SPHERE_PROPAGATION_WHEEL        the wheel (scripts/wheel makes it)
SPHERE_PROPAGATION_WHEELHOUSE   folder with the wheels of PyMeshLab and numpy
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

sys.path[:0] = [
    str(Path(__file__).resolve().parents[2] / "scripts"),
    str(Path(__file__).resolve().parents[1] / "volumes"),
]


@pytest.fixture(scope="session")
def wheel():
    found = os.environ.get("SPHERE_PROPAGATION_WHEEL")
    if not found:
        pytest.skip("SPHERE_PROPAGATION_WHEEL names no wheel: scripts/test wheel builds one")
    return Path(found).resolve()


class Environment:
    """A virtual environment, and a folder to work in that is not the checkout."""

    def __init__(self, folder):
        self.folder, self.bin = folder / "work", folder / "environment/bin"
        self.folder.mkdir()

    def run(self, program, *arguments, code=0):
        """Runs a program of the environment there; its standard output, or, where it is to fail,
        what it says of errors."""
        clean = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith(("PYTHON", "SPHERE_PROPAGATION"))
        }
        ended = subprocess.run(
            [str(self.bin / program), *map(str, arguments)],
            cwd=self.folder,
            env=clean,
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        assert ended.returncode == code, ended.stdout + ended.stderr
        return ended.stderr if code else ended.stdout

    def install(self, what):
        """From the wheelhouse alone."""
        house = os.environ["SPHERE_PROPAGATION_WHEELHOUSE"]
        words = "-q", "--disable-pip-version-check", "--no-index", "--no-compile"
        self.run("python", "-m", "pip", "install", *words, "--find-links", house, what)


@pytest.fixture(scope="session")
def environment(wheel, tmp_path_factory):
    made = Environment(tmp_path_factory.mktemp("wheel"))
    subprocess.run([sys.executable, "-m", "venv", str(made.bin.parent)], check=True)
    made.install(wheel)
    return made
