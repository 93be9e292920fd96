# SPDX-License-Identifier: GPL-3.0-only
"""The package of the checkout, not one that happens to be installed; a small cycle that several
tests share."""

import sys
from pathlib import Path

import pytest

PYTHON = Path(__file__).resolve().parents[2] / "python"
sys.path[:0] = [str(PYTHON), str(Path(__file__).resolve().parents[1] / "volumes")]


@pytest.fixture(scope="session")
def cycle():
    import sphere_propagation as sp

    return sp.correspond(
        sp.make_phantom(phases=6, voxel_size=4.0), root=0, order="Cyclic time", frequency=4
    )


@pytest.fixture
def egg_file(tmp_path):
    """A label volume of one phase."""
    import volume_files

    path = tmp_path / "egg.nii"
    path.write_bytes(volume_files.nifti(volume_files.egg()))
    return path


@pytest.fixture
def run_python():
    """Runs Python code in a process of its own, with the package on its path: run_python(code,
    PLUGIN="..."), a CompletedProcess."""
    import os
    import subprocess

    def run(code, *arguments, **environment):
        paths = os.pathsep.join([str(PYTHON), *filter(None, [os.environ.get("PYTHONPATH")])])
        return subprocess.run(
            [sys.executable, "-c", code, *arguments],
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
            env={**os.environ, "PYTHONPATH": paths, **environment},
        )

    return run
